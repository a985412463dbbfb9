//! Methods of vectors, matrices and rotations: a table of what each takes and gives.
//!
//! Methods that run closures are in `closures.rs`, those that give parts or iterators in `views.rs`, those that are refused in
//! `refused.rs`.

use proc_macro2::Span;
use syn::ExprMethodCall;

use super::{Kind, Matrix, MatrixType, sum, unknown_type};
use crate::algebra::{Arena, Expr, Function};
use crate::interpret::Lowering;
use crate::interpret::calls::Argument;
use crate::interpret::fields::FieldPath;
use crate::interpret::floats::{are, plural};
use crate::interpret::value::Value;

/// What a method is of.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Receiver {
    Any,
    /// One column.
    Vector,
    /// A vector or row of this length.
    Of(usize),
    Square,
    One,
    Rotation,
    /// A rotation or a unit vector.
    Wrapped,
}

/// An argument.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Takes {
    /// Of the size of the receiver.
    Same,
    /// A vector with as many entries as the receiver has rows.
    Vector,
    Number,
    /// The index of a row.
    Row,
    /// The index of a column.
    Column,
}

/// The arguments of a call.
#[derive(Default)]
struct Given {
    matrices: Vec<Matrix<Expr>>,
    numbers: Vec<Expr>,
    index: usize,
}

impl Given {
    fn matrix(&self) -> Option<&Matrix<Expr>> {
        self.matrices.first()
    }

    fn number(&self) -> Option<Expr> {
        self.numbers.first().copied()
    }
}

/// A function that computes a result of this type.
type Compute<T> = fn(&mut Arena, &Matrix<Expr>, &Given) -> Option<T>;

/// What a method gives; nothing where an argument is missing, which has been reported.
enum Gives {
    Number(Compute<Expr>),
    Matrix(Compute<Matrix<Expr>>),
}

struct Method {
    name: &'static str,
    receiver: Receiver,
    takes: &'static [Takes],
    gives: Gives,
}

const fn number(
    name: &'static str,
    receiver: Receiver,
    takes: &'static [Takes],
    compute: Compute<Expr>,
) -> Method {
    let gives = Gives::Number(compute);
    Method {
        name,
        receiver,
        takes,
        gives,
    }
}

const fn matrix(
    name: &'static str,
    receiver: Receiver,
    takes: &'static [Takes],
    compute: Compute<Matrix<Expr>>,
) -> Method {
    let gives = Gives::Matrix(compute);
    Method {
        name,
        receiver,
        takes,
        gives,
    }
}

/// The methods of nalgebra that are smooth formulas.
static METHODS: &[Method] = &[
    number("dot", Receiver::Any, &[Takes::Same], |arena, m, given| {
        Some(inner(arena, m, given.matrix()?))
    }),
    number("norm_squared", Receiver::Any, &[], |arena, m, _| {
        Some(inner(arena, m, m))
    }),
    number("magnitude_squared", Receiver::Any, &[], |arena, m, _| {
        Some(inner(arena, m, m))
    }),
    number("norm", Receiver::Any, &[], |arena, m, _| {
        Some(norm(arena, m))
    }),
    number("magnitude", Receiver::Any, &[], |arena, m, _| {
        Some(norm(arena, m))
    }),
    number(
        "metric_distance",
        Receiver::Any,
        &[Takes::Same],
        |arena, m, given| {
            let difference = entrywise(arena, m, given.matrix()?, Arena::sub);
            Some(norm(arena, &difference))
        },
    ),
    number("sum", Receiver::Any, &[], |arena, m, _| {
        Some(sum(arena, &m.entries))
    }),
    number("product", Receiver::Any, &[], |arena, m, _| {
        let factors: Vec<(Expr, i32)> = m.entries.iter().map(|&entry| (entry, 1)).collect();
        Some(arena.product(&factors))
    }),
    number("mean", Receiver::Any, &[], |arena, m, _| {
        let total = sum(arena, &m.entries);
        let count = arena.constant(m.entries.len() as f64);
        (m.ty.len() > 0).then(|| arena.div(total, count))
    }),
    number("trace", Receiver::Square, &[], |arena, m, _| {
        let diagonal: Vec<Expr> = (0..m.ty.rows).map(|i| m.at(i, i)).collect();
        Some(sum(arena, &diagonal))
    }),
    number("determinant", Receiver::Square, &[], |arena, m, _| {
        determinant(arena, m)
    }),
    number(
        "perp",
        Receiver::Of(2),
        &[Takes::Same],
        |arena, m, given| {
            let b = given.matrix()?;
            Some(minor(
                arena,
                [m.entries[0], m.entries[1]],
                [b.entries[0], b.entries[1]],
            ))
        },
    ),
    number("to_scalar", Receiver::One, &[], |_, m, _| {
        m.entries.first().copied()
    }),
    number("into_scalar", Receiver::One, &[], |_, m, _| {
        m.entries.first().copied()
    }),
    matrix(
        "cross",
        Receiver::Of(3),
        &[Takes::Same],
        |arena, m, given| {
            let [a, b] = [&m.entries, &given.matrix()?.entries];
            let entry = |i: usize| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                minor(arena, [a[j], a[k]], [b[j], b[k]])
            };
            let entries = (0..3).map(entry).collect();
            Some(Matrix {
                ty: m.ty.plain(),
                entries,
            })
        },
    ),
    matrix("cross_matrix", Receiver::Of(3), &[], |arena, m, _| {
        let zero = arena.constant(0.0);
        let [x, y, z] = [0, 1, 2].map(|i| m.entries[i]);
        let [nx, ny, nz] = [x, y, z].map(|entry| arena.neg(entry));
        let rows = [[zero, nz, y], [z, zero, nx], [ny, x, zero]];
        Some(Matrix::from_fn(MatrixType::matrix(3, 3), |i, j| rows[i][j]))
    }),
    matrix(
        "component_mul",
        Receiver::Any,
        &[Takes::Same],
        |arena, m, given| Some(entrywise(arena, m, given.matrix()?, Arena::mul)),
    ),
    matrix(
        "component_div",
        Receiver::Any,
        &[Takes::Same],
        |arena, m, given| Some(entrywise(arena, m, given.matrix()?, Arena::div)),
    ),
    matrix(
        "scale",
        Receiver::Any,
        &[Takes::Number],
        |arena, m, given| Some(each(arena, m, given.number()?, Arena::mul)),
    ),
    matrix(
        "unscale",
        Receiver::Any,
        &[Takes::Number],
        |arena, m, given| Some(each(arena, m, given.number()?, Arena::div)),
    ),
    matrix(
        "add_scalar",
        Receiver::Any,
        &[Takes::Number],
        |arena, m, given| Some(each(arena, m, given.number()?, Arena::add)),
    ),
    matrix("normalize", Receiver::Any, &[], |arena, m, _| {
        Some(normalized(arena, m))
    }),
    matrix(
        "lerp",
        Receiver::Vector,
        &[Takes::Same, Takes::Number],
        |arena, m, given| {
            let share = given.number()?;
            let one = arena.constant(1.0);
            let rest = arena.sub(one, share);
            let [a, b] =
                [(m, rest), (given.matrix()?, share)].map(|(m, x)| each(arena, m, x, Arena::mul));
            Some(entrywise(arena, &a, &b, Arena::add))
        },
    ),
    matrix("transpose", Receiver::Any, &[], |_, m, _| {
        Some(transpose(m))
    }),
    matrix("adjoint", Receiver::Any, &[], |_, m, _| Some(transpose(m))),
    matrix("diagonal", Receiver::Square, &[], |_, m, _| {
        Some(Matrix::from_fn(MatrixType::vector(m.ty.rows), |i, _| {
            m.at(i, i)
        }))
    }),
    matrix("row", Receiver::Any, &[Takes::Row], |_, m, given| {
        Some(m.part((given.index, 0), MatrixType::matrix(1, m.ty.columns)))
    }),
    matrix("column", Receiver::Any, &[Takes::Column], |_, m, given| {
        Some(m.part((0, given.index), MatrixType::vector(m.ty.rows)))
    }),
    matrix("into_owned", Receiver::Any, &[], |_, m, _| Some(m.clone())),
    matrix("clone_owned", Receiver::Any, &[], |_, m, _| Some(m.clone())),
    matrix("inverse", Receiver::Rotation, &[], |_, m, _| {
        Some(m.transposed())
    }),
    matrix(
        "transform_vector",
        Receiver::Rotation,
        &[Takes::Vector],
        |arena, m, given| image(arena, m, given.matrix()?),
    ),
    matrix(
        "inverse_transform_vector",
        Receiver::Rotation,
        &[Takes::Vector],
        |arena, m, given| image(arena, &m.transposed(), given.matrix()?),
    ),
    matrix("matrix", Receiver::Rotation, &[], |_, m, _| {
        Some(m.clone().with_kind(Kind::Matrix))
    }),
    matrix("into_inner", Receiver::Wrapped, &[], |_, m, _| {
        Some(m.clone().with_kind(Kind::Matrix))
    }),
];

fn inner(arena: &mut Arena, a: &Matrix<Expr>, b: &Matrix<Expr>) -> Expr {
    let products = entrywise(arena, a, b, Arena::mul);
    sum(arena, &products.entries)
}

/// √(Σ x²), whose derivatives do not exist at 0: the domain of the root.
fn norm(arena: &mut Arena, m: &Matrix<Expr>) -> Expr {
    let square = inner(arena, m, m);
    arena.call(Function::Sqrt, square)
}

pub(super) fn normalized(arena: &mut Arena, m: &Matrix<Expr>) -> Matrix<Expr> {
    let norm = norm(arena, m);
    each(arena, m, norm, Arena::div)
}

/// A vector or matrix of what an operation makes of the entries of two.
pub(super) fn entrywise(
    arena: &mut Arena,
    a: &Matrix<Expr>,
    b: &Matrix<Expr>,
    operation: fn(&mut Arena, Expr, Expr) -> Expr,
) -> Matrix<Expr> {
    let pairs = a.entries.iter().zip(&b.entries);
    let entries = pairs.map(|(&a, &b)| operation(arena, a, b)).collect();
    Matrix {
        ty: a.ty.plain(),
        entries,
    }
}

/// A vector or matrix of what an operation makes of each entry and a number.
fn each(
    arena: &mut Arena,
    m: &Matrix<Expr>,
    x: Expr,
    operation: fn(&mut Arena, Expr, Expr) -> Expr,
) -> Matrix<Expr> {
    let entries = m
        .entries
        .iter()
        .map(|&entry| operation(arena, entry, x))
        .collect();
    Matrix {
        ty: m.ty.plain(),
        entries,
    }
}

fn transpose(m: &Matrix<Expr>) -> Matrix<Expr> {
    let transposed = m.transposed();
    match m.ty.kind {
        Kind::Rotation => transposed,
        _ => transposed.with_kind(Kind::Matrix),
    }
}

/// `a₀ b₁ − a₁ b₀`.
fn minor(arena: &mut Arena, a: [Expr; 2], b: [Expr; 2]) -> Expr {
    let [left, right] = [(a[0], b[1]), (a[1], b[0])].map(|(a, b)| arena.mul(a, b));
    arena.sub(left, right)
}

/// A rotation of a vector.
fn image(arena: &mut Arena, rotation: &Matrix<Expr>, v: &Matrix<Expr>) -> Option<Matrix<Expr>> {
    let entries = (0..rotation.ty.rows).map(|i| {
        let row = rotation.part((i, 0), MatrixType::matrix(1, rotation.ty.columns));
        inner(arena, &row, v)
    });
    Some(Matrix {
        ty: v.ty.plain(),
        entries: entries.collect(),
    })
}

/// Expansion by the first column of ever smaller minors; those of the last columns are computed once for each choice of rows.
fn determinant(arena: &mut Arena, m: &Matrix<Expr>) -> Option<Expr> {
    let n = m.ty.rows;
    if n > MINORS {
        return None;
    }
    // minors of the last columns, by the set of their rows
    let mut minors = vec![arena.constant(1.0); 1 << n];
    for rows in 1_usize..1 << n {
        let column = n - rows.count_ones() as usize;
        let mut terms = Vec::new();
        for (sign, row) in (0..n).filter(|row| rows >> row & 1 == 1).enumerate() {
            let product = arena.mul(m.at(row, column), minors[rows & !(1 << row)]);
            terms.push(if sign % 2 == 0 {
                product
            } else {
                arena.neg(product)
            });
        }
        minors[rows] = sum(arena, &terms);
    }
    minors.last().copied()
}

/// Largest size of which a determinant is written out: the number of its minors doubles with each row.
const MINORS: usize = 6;

/// Whether vectors or matrices have a method of this name.
pub(super) fn is_method(name: &str) -> bool {
    METHODS.iter().any(|method| method.name == name)
}

/// The names of methods, for suggestions.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    METHODS.iter().map(|method| method.name)
}

/// The type that a parameter must have for a method and its first argument; nothing where several types are possible.
fn type_of_parameter(method: &Method, first: Option<&Value>) -> Option<MatrixType> {
    match (method.receiver, method.takes.first(), first) {
        (_, Some(Takes::Same), Some(Value::Matrix(other))) => Some(other.ty.plain()),
        // a cross product of columns, unless the argument is known to be a row
        (Receiver::Of(length), Some(Takes::Same), Some(_)) => Some(MatrixType::vector(length)),
        _ => None,
    }
}

impl Lowering<'_> {
    /// A method of the table; nothing if it has none of this name.
    pub(super) fn tabled_method(
        &mut self,
        call: &ExprMethodCall,
        receiver: &Matrix<Value>,
        arguments: &[Argument],
        at: Span,
    ) -> Option<Value> {
        let name = call.method.to_string();
        let method = METHODS.iter().find(|method| method.name == name)?;
        let ty = receiver.ty;
        if !method.receiver.accepts(ty) {
            let message = format!(
                "a `{ty}` has no `{name}`: it is a method of {}",
                method.receiver.described()
            );
            return Some(self.refuse(&call.method, message));
        }
        if name == "determinant" && ty.rows > MINORS {
            let message = format!(
                "the determinant of a `{ty}` is too long a formula: the limit is {MINORS} rows"
            );
            return Some(self.refuse(&call.method, message));
        }
        if arguments.len() != method.takes.len() {
            let takes = plural(method.takes.len(), "argument");
            let message = format!("`{name}` takes {takes}, here {}", are(arguments.len()));
            return Some(self.refuse(&call.method, message));
        }
        let mut given = Given::default();
        for (takes, argument) in method.takes.iter().zip(arguments) {
            if self
                .given(&mut given, *takes, ty, argument, &name)
                .is_none()
            {
                return Some(Value::Poison);
            }
        }
        let receiver = self.numbers(receiver, &at);
        let Some(receiver) = receiver.filter(|m| self.work(m.entries.len(), call)) else {
            return Some(Value::Poison);
        };
        Some(match method.gives {
            Gives::Number(compute) => match compute(self.arena, &receiver, &given) {
                Some(number) => self.computed_number(number, &call.method),
                None => Value::Poison,
            },
            Gives::Matrix(compute) => match compute(self.arena, &receiver, &given) {
                Some(matrix) => self.computed_matrix(matrix, &call.method),
                None => Value::Poison,
            },
        })
    }

    /// Reads an argument of a method of a `ty`; nothing after an error.
    fn given(
        &mut self,
        given: &mut Given,
        takes: Takes,
        ty: MatrixType,
        argument: &Argument,
        name: &str,
    ) -> Option<()> {
        match takes {
            Takes::Same => {
                let matrix = self.matrix_argument(argument, ty.plain(), name)?;
                given.matrices.push(matrix);
            }
            Takes::Vector => {
                let matrix = self.matrix_argument(argument, MatrixType::vector(ty.rows), name)?;
                given.matrices.push(matrix);
            }
            Takes::Number => given
                .numbers
                .push(self.scalar(&argument.value, &argument.at)?),
            Takes::Row => given.index = self.count_argument(argument, ty.rows, "rows")?,
            Takes::Column => given.index = self.count_argument(argument, ty.columns, "columns")?,
        }
        Some(())
    }

    /// An argument that is a matrix of this size; a parameter gets its type from there.
    pub(super) fn matrix_argument(
        &mut self,
        argument: &Argument,
        ty: MatrixType,
        name: &str,
    ) -> Option<Matrix<Expr>> {
        match &argument.value {
            Value::Matrix(matrix) if matrix.ty.has_size_of(ty) => {
                self.numbers(matrix, &argument.at)
            }
            Value::Field(path) if !path.is_self() && !path.is_number() => {
                self.numbers(&Matrix::of_field(path, ty), &argument.at)
            }
            Value::Poison => None,
            other => {
                let message = format!("`{name}` takes a `{ty}` here, and this is {}", other.kind());
                self.refuse(&argument.at, message);
                None
            }
        }
    }

    /// An argument that is an index below `bound`.
    fn count_argument(&mut self, argument: &Argument, bound: usize, what: &str) -> Option<usize> {
        let index = self.index_of(&argument.value, &argument.at)?;
        if index < bound {
            return Some(index);
        }
        let message = format!("index {index} is out of range: there are {bound} {what}");
        self.refuse(&argument.at, message);
        None
    }

    /// A method of vectors of a parameter, whose type is found from the arguments.
    pub(super) fn method_of_field(
        &mut self,
        call: &ExprMethodCall,
        path: &FieldPath,
        at: Span,
    ) -> Option<Value> {
        let name = call.method.to_string();
        let method = METHODS.iter().find(|method| method.name == name)?;
        let arguments: Vec<Argument> = call.args.iter().map(|a| self.argument(a)).collect();
        if arguments
            .iter()
            .any(|argument| matches!(argument.value, Value::Poison))
        {
            return Some(Value::Poison);
        }
        let first = arguments.first().map(|argument| &argument.value);
        let Some(ty) = type_of_parameter(method, first).filter(|_| !path.is_number()) else {
            let message = if path.is_number() {
                no_method_of_number(&name)
            } else {
                unknown_type(path)
            };
            return Some(self.refuse(&at, message));
        };
        let receiver = Matrix::of_field(path, ty);
        self.tabled_method(call, &receiver, &arguments, at)
    }
}

/// What to say of a method of vectors that is called on a number.
pub(super) fn no_method_of_number(name: &str) -> String {
    format!(
        "`{name}` is a method of vectors and matrices, and this is a number: in a product a field is taken for one, unless its type is written, as in `let g: Vector3<f64> = self.g;`"
    )
}

impl Receiver {
    fn accepts(self, ty: MatrixType) -> bool {
        match self {
            Self::Any => true,
            Self::Vector => ty.is_vector(),
            Self::Of(length) => ty.len() == length && ty.rows.min(ty.columns) == 1,
            Self::Square => ty.is_square(),
            Self::One => ty.len() == 1,
            Self::Rotation => ty.kind == Kind::Rotation,
            Self::Wrapped => ty.kind != Kind::Matrix,
        }
    }

    fn described(self) -> String {
        match self {
            Self::Any => "matrices".to_owned(),
            Self::Vector => "vectors".to_owned(),
            Self::Of(length) => format!("vectors of length {length}"),
            Self::Square => "square matrices".to_owned(),
            Self::One => "matrices of one entry".to_owned(),
            Self::Rotation => "rotations".to_owned(),
            Self::Wrapped => "rotations and unit vectors".to_owned(),
        }
    }
}
