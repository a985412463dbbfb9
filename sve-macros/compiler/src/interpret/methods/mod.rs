//! The table of methods: what has a method, its arguments, and what computes its result.
//!
//! `call.rs` looks a method up, evaluates its arguments and calls it; what is not understood has a message in `refused.rs`. The smooth
//! functions of the algebra are methods of numbers too, and are not repeated here.

mod call;
mod refused;

use std::f64::consts::PI;

use syn::{Expr as Syntax, ExprMethodCall};

use super::Lowering;
use super::calls::Argument;
use super::matrices::formulas::{
    cross, cross_matrix, diagonal, distance, each, entrywise, image, inner, lerp, norm, normalized,
    perp, sum, transpose,
};
use super::matrices::views::{columns, rows};
use super::matrices::{Kind, Matrix, MatrixType};
use super::value::Value;
use super::{adapters, sequences};
use crate::algebra::{Arena, Expr, Function};
use Receiver::{Any, Array, Iterator, List, Number, OfLength, One, Rotation, Square, Vector};
use Run::{Adapter, Entry, Float, Formula, Own};
pub(super) use refused::{refusal, rough_method, unknown_type};

/// What has a method.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Receiver {
    Number,
    Array,
    Iterator,
    /// Arrays and iterators.
    List,
    /// Vectors, matrices and rotations.
    Any,
    /// One column.
    Vector,
    /// A vector or row of this length.
    OfLength(usize),
    Square,
    One,
    Rotation,
    /// A rotation or a unit vector.
    Wrapped,
}

/// The kind of an argument.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Take {
    Value,
    Number,
    /// An index or a length.
    Count,
    /// The index of a row.
    Row,
    /// The index of a column.
    Column,
    /// A matrix of the receiver's size.
    Same,
    /// A vector with as many entries as the receiver has rows.
    Rows,
    /// A closure, or the name of a variable that holds one.
    Function,
}

/// The arguments of a call, by their kinds.
#[derive(Default)]
pub(super) struct Given<'c> {
    pub(super) values: Vec<Argument>,
    pub(super) numbers: Vec<Expr>,
    pub(super) counts: Vec<usize>,
    pub(super) matrices: Vec<Matrix<Expr>>,
    pub(super) functions: Vec<&'c Syntax>,
}

/// A call of a method of the table.
pub(super) struct Call<'c> {
    pub(super) syntax: &'c ExprMethodCall,
    pub(super) receiver: Argument,
    pub(super) given: Given<'c>,
}

impl Given<'_> {
    fn matrix(&self) -> &Matrix<Expr> {
        &self.matrices[0]
    }
}

impl Call<'_> {
    /// Returns the receiver, or the matrix without rows and columns if it is none.
    pub(super) fn matrix(&self) -> Matrix<Value> {
        match &self.receiver.value {
            Value::Matrix(matrix) => matrix.clone(),
            _ => Matrix::from_fn(MatrixType::matrix(0, 0), |_, _| Value::Poison),
        }
    }
}

/// What computes the result of a method.
pub(super) enum Run {
    /// A number or a tuple of the receiver and the arguments, which are numbers.
    Float(fn(&mut Arena, &[Expr]) -> Value),
    /// A number of the receiver, a matrix.
    Entry(fn(&mut Arena, &Matrix<Expr>, &Given<'_>) -> Expr),
    /// A matrix of the receiver, a matrix.
    Formula(fn(&mut Arena, &Matrix<Expr>, &Given<'_>) -> Matrix<Expr>),
    /// The items of another iterator.
    Adapter(fn(&mut Lowering<'_>, Vec<Value>, &Call<'_>) -> Option<Vec<Value>>),
    /// Another value.
    Own(fn(&mut Lowering<'_>, &Call<'_>) -> Option<Value>),
}

pub(super) struct Method {
    /// The names, separated by spaces.
    names: &'static str,
    receiver: Receiver,
    takes: &'static [Take],
    run: Run,
}

const fn row(receiver: Receiver, names: &'static str, takes: &'static [Take], run: Run) -> Method {
    Method {
        names,
        receiver,
        takes,
        run,
    }
}

const SAME: &[Take] = &[Take::Same];
const ONE_NUMBER: &[Take] = &[Take::Number];
const COUNT: &[Take] = &[Take::Count];
const COUNTS: &[Take] = &[Take::Count, Take::Count];
const VALUE: &[Take] = &[Take::Value];
const FUNCTION: &[Take] = &[Take::Function];

static METHODS: &[Method] = &[
    row(
        Number,
        "recip",
        &[],
        Float(|a, x| Value::Scalar(a.pow(x[0], -1))),
    ),
    row(
        Number,
        "mul_add",
        &[Take::Number, Take::Number],
        Float(|arena, x| {
            let product = arena.mul(x[0], x[1]);
            Value::Scalar(arena.add(product, x[2]))
        }),
    ),
    row(
        Number,
        "sin_cos",
        &[],
        Float(|arena, x| {
            let pair = [Function::Sin, Function::Cos].map(|f| arena.call(f, x[0]));
            Value::Tuple(pair.map(Value::Scalar).into())
        }),
    ),
    row(
        Number,
        "to_radians",
        &[],
        Float(|a, x| Value::Scalar(a.scale(PI / 180.0, x[0]))),
    ),
    row(
        Number,
        "to_degrees",
        &[],
        Float(|a, x| Value::Scalar(a.scale(180.0 / PI, x[0]))),
    ),
    row(
        Number,
        "log",
        ONE_NUMBER,
        Float(|arena, x| {
            let [x, base] = [x[0], x[1]].map(|e| arena.call(Function::Ln, e));
            Value::Scalar(arena.div(x, base))
        }),
    ),
    row(List, "len", &[], Own(sequences::length)),
    row(
        List,
        "iter into_iter copied cloned",
        &[],
        Adapter(|_, items, _| Some(items)),
    ),
    row(Array, "map", FUNCTION, Own(sequences::map)),
    row(Iterator, "map", FUNCTION, Adapter(adapters::map)),
    row(Iterator, "for_each", FUNCTION, Own(sequences::for_each)),
    row(
        List,
        "windows chunks chunks_exact",
        COUNT,
        Own(sequences::chunks),
    ),
    row(List, "as_flattened", &[], Own(sequences::as_flattened)),
    row(List, "sum product", &[], Own(sequences::total)),
    row(
        List,
        "fold",
        &[Take::Value, Take::Function],
        Own(sequences::fold),
    ),
    row(List, "rev", &[], Adapter(adapters::rev)),
    row(List, "enumerate", &[], Adapter(adapters::enumerate)),
    row(List, "flatten", &[], Adapter(adapters::flatten)),
    row(List, "flat_map", FUNCTION, Adapter(adapters::flat_map)),
    row(List, "zip", VALUE, Adapter(adapters::zip)),
    row(List, "chain", VALUE, Adapter(adapters::chain)),
    row(List, "filter", FUNCTION, Adapter(adapters::filter)),
    row(List, "skip", COUNT, Adapter(adapters::skip)),
    row(List, "take", COUNT, Adapter(adapters::take)),
    row(List, "step_by", COUNT, Adapter(adapters::step_by)),
    row(Any, "dot", SAME, Entry(|a, m, x| inner(a, m, x.matrix()))),
    row(
        Any,
        "norm_squared magnitude_squared",
        &[],
        Entry(|a, m, _| inner(a, m, m)),
    ),
    row(Any, "norm magnitude", &[], Entry(|a, m, _| norm(a, m))),
    row(
        Any,
        "metric_distance",
        SAME,
        Entry(|a, m, x| distance(a, m, x.matrix())),
    ),
    row(Any, "sum", &[], Entry(|a, m, _| sum(a, &m.entries))),
    row(
        Any,
        "product",
        &[],
        Entry(|a, m, _| {
            let factors: Vec<(Expr, i32)> = m.entries.iter().map(|&entry| (entry, 1)).collect();
            a.product(&factors)
        }),
    ),
    row(
        Any,
        "mean",
        &[],
        Entry(|a, m, _| {
            let total = sum(a, &m.entries);
            let count = a.constant(m.entries.len() as f64);
            a.div(total, count)
        }),
    ),
    row(
        Square,
        "trace",
        &[],
        Entry(|a, m, _| sum(a, &diagonal(m).entries)),
    ),
    row(
        Square,
        "determinant",
        &[],
        Own(|x, call| x.determinant(call)),
    ),
    row(
        OfLength(2),
        "perp",
        SAME,
        Entry(|a, m, x| perp(a, m, x.matrix())),
    ),
    row(
        One,
        "to_scalar into_scalar",
        &[],
        Entry(|_, m, _| m.entries[0]),
    ),
    row(
        OfLength(3),
        "cross",
        SAME,
        Formula(|a, m, x| cross(a, m, x.matrix())),
    ),
    row(
        OfLength(3),
        "cross_matrix",
        &[],
        Formula(|a, m, _| cross_matrix(a, m)),
    ),
    row(
        Any,
        "component_mul",
        SAME,
        Formula(|a, m, x| entrywise(a, m, x.matrix(), Arena::mul)),
    ),
    row(
        Any,
        "component_div",
        SAME,
        Formula(|a, m, x| entrywise(a, m, x.matrix(), Arena::div)),
    ),
    row(
        Any,
        "scale",
        ONE_NUMBER,
        Formula(|a, m, x| each(a, m, x.numbers[0], Arena::mul)),
    ),
    row(
        Any,
        "unscale",
        ONE_NUMBER,
        Formula(|a, m, x| each(a, m, x.numbers[0], Arena::div)),
    ),
    row(
        Any,
        "add_scalar",
        ONE_NUMBER,
        Formula(|a, m, x| each(a, m, x.numbers[0], Arena::add)),
    ),
    row(Any, "normalize", &[], Formula(|a, m, _| normalized(a, m))),
    row(
        Vector,
        "lerp",
        &[Take::Same, Take::Number],
        Formula(|a, m, x| lerp(a, [m, x.matrix()], x.numbers[0])),
    ),
    row(
        Any,
        "transpose adjoint",
        &[],
        Formula(|_, m, _| transpose(m)),
    ),
    row(Square, "diagonal", &[], Formula(|_, m, _| diagonal(m))),
    row(
        Any,
        "row",
        &[Take::Row],
        Formula(|_, m, x| m.row(x.counts[0])),
    ),
    row(
        Any,
        "column",
        &[Take::Column],
        Formula(|_, m, x| m.column(x.counts[0])),
    ),
    row(
        Any,
        "into_owned clone_owned",
        &[],
        Formula(|_, m, _| m.clone()),
    ),
    row(Rotation, "inverse", &[], Formula(|_, m, _| m.transposed())),
    row(
        Rotation,
        "transform_vector",
        &[Take::Rows],
        Formula(|a, m, x| image(a, m, x.matrix())),
    ),
    row(
        Rotation,
        "inverse_transform_vector",
        &[Take::Rows],
        Formula(|a, m, x| image(a, &m.transposed(), x.matrix())),
    ),
    row(
        Rotation,
        "matrix",
        &[],
        Formula(|_, m, _| m.clone().with_kind(Kind::Matrix)),
    ),
    row(
        Receiver::Wrapped,
        "into_inner",
        &[],
        Formula(|_, m, _| m.clone().with_kind(Kind::Matrix)),
    ),
    row(
        Any,
        "len",
        &[],
        Own(|_, c| Some(Value::count(c.matrix().ty.len()))),
    ),
    row(
        Any,
        "nrows",
        &[],
        Own(|_, c| Some(Value::count(c.matrix().ty.rows))),
    ),
    row(
        Any,
        "ncols",
        &[],
        Own(|_, c| Some(Value::count(c.matrix().ty.columns))),
    ),
    row(
        Any,
        "iter into_iter",
        &[],
        Own(|_, c| Some(Value::Sequence(c.matrix().entries))),
    ),
    row(
        Any,
        "as_slice",
        &[],
        Own(|_, c| Some(Value::Array(c.matrix().entries))),
    ),
    row(Any, "column_iter", &[], Own(columns)),
    row(Any, "row_iter", &[], Own(rows)),
    row(Any, "rows columns", COUNTS, Own(|x, call| x.part(call))),
    row(
        Any,
        "fixed_rows fixed_columns",
        COUNT,
        Own(|x, call| x.part(call)),
    ),
    row(Any, "fixed_view", COUNTS, Own(|x, call| x.part(call))),
    row(Any, "map", FUNCTION, Own(|x, call| x.map_entries(call))),
    row(
        Any,
        "zip_map",
        &[Take::Same, Take::Function],
        Own(|x, call| x.map_entries(call)),
    ),
    row(
        Any,
        "fold",
        &[Take::Value, Take::Function],
        Own(sequences::fold),
    ),
    row(
        Any,
        "tr_mul",
        VALUE,
        Own(|x, call| x.transposed_product(call)),
    ),
];

impl Receiver {
    /// Returns whether vectors, matrices or rotations of some size are such receivers.
    fn is_matrix(self) -> bool {
        !matches!(self, Number | Array | Iterator | List)
    }

    /// Returns whether values of this kind are such receivers; of a matrix, whether matrices of another size may be.
    fn includes(self, value: &Value) -> bool {
        match value {
            Value::Array(_) => matches!(self, Array | List),
            Value::Sequence(_) => matches!(self, Iterator | List),
            Value::Matrix(_) => self.is_matrix(),
            _ => self == Number,
        }
    }

    fn accepts(self, ty: MatrixType) -> bool {
        match self {
            Any | Number | Array | Iterator | List => true,
            Vector => ty.is_vector(),
            OfLength(length) => ty.len() == length && ty.rows.min(ty.columns) == 1,
            Square => ty.is_square(),
            One => ty.len() == 1,
            Rotation => ty.kind == Kind::Rotation,
            Self::Wrapped => ty.kind != Kind::Matrix,
        }
    }

    fn described(self) -> String {
        match self {
            Number | Array | Iterator | List | Any => "matrices".to_owned(),
            Vector => "vectors".to_owned(),
            OfLength(length) => format!("vectors of length {length}"),
            Square => "square matrices".to_owned(),
            One => "matrices of one entry".to_owned(),
            Rotation => "rotations".to_owned(),
            Self::Wrapped => "rotations and unit vectors".to_owned(),
        }
    }
}

impl Method {
    fn has_name(&self, name: &str) -> bool {
        self.names.split(' ').any(|own| own == name)
    }

    /// Returns whether the method is a formula of the entries of its receiver, a vector or matrix.
    fn is_formula(&self) -> bool {
        matches!(self.run, Entry(_) | Formula(_)) || self.names == "determinant"
    }
}

/// Returns the method of this name with such a receiver.
fn find(name: &str, is_receiver: impl Fn(Receiver) -> bool) -> Option<&'static Method> {
    let mut methods = METHODS.iter();
    methods.find(|method| method.has_name(name) && is_receiver(method.receiver))
}

/// Returns the formula of vectors and matrices of this name.
fn formula(name: &str) -> Option<&'static Method> {
    find(name, Receiver::is_matrix).filter(|method| method.is_formula())
}

/// Returns whether arrays or iterators have a method of this name.
fn is_of_lists(name: &str) -> bool {
    find(name, |receiver| matches!(receiver, Array | Iterator | List)).is_some()
}

/// Returns the number of arguments and the computation of a method of numbers.
pub(super) fn of_numbers(name: &str) -> Option<(usize, &'static Run)> {
    let method = find(name, |receiver| receiver == Number)?;
    Some((method.takes.len(), &method.run))
}

/// Returns the names of the methods of numbers in the table.
pub(super) fn names_of_numbers() -> impl std::iter::Iterator<Item = &'static str> {
    let methods = METHODS.iter().filter(|method| method.receiver == Number);
    methods.map(|method| method.names)
}
