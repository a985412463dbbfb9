//! The table of methods of vectors, matrices and rotations: receiver, arguments and result of each method.
//!
//! Methods that call closures are in `closures.rs`, methods that return submatrices or iterators in `views.rs`, methods that are not
//! supported in `refused.rs`.

use super::formulas::{
    determinant, each, entrywise, image, inner, minor, norm, normalized, transpose,
};
use super::{Kind, Matrix, MatrixType, sum};
use crate::algebra::{Arena, Expr};

/// The values that have a method.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Receiver {
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
pub(super) enum ArgumentKind {
    /// A matrix of the receiver's size.
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
pub(super) struct CallArguments {
    pub(super) matrices: Vec<Matrix<Expr>>,
    pub(super) numbers: Vec<Expr>,
    pub(super) index: usize,
}

impl CallArguments {
    fn matrix(&self) -> Option<&Matrix<Expr>> {
        self.matrices.first()
    }

    fn number(&self) -> Option<Expr> {
        self.numbers.first().copied()
    }
}

/// A function that computes a result of this type.
pub(super) type Compute<T> = fn(&mut Arena, &Matrix<Expr>, &CallArguments) -> Option<T>;

/// The result of a method, with the function that computes it. The function returns `None` if an argument is missing, which has been
/// reported.
pub(super) enum MethodResult {
    Number(Compute<Expr>),
    Matrix(Compute<Matrix<Expr>>),
}

pub(super) struct Method {
    pub(super) name: &'static str,
    pub(super) receiver: Receiver,
    pub(super) takes: &'static [ArgumentKind],
    pub(super) result: MethodResult,
}

const fn number(
    name: &'static str,
    receiver: Receiver,
    takes: &'static [ArgumentKind],
    compute: Compute<Expr>,
) -> Method {
    let result = MethodResult::Number(compute);
    Method {
        name,
        receiver,
        takes,
        result,
    }
}

const fn matrix(
    name: &'static str,
    receiver: Receiver,
    takes: &'static [ArgumentKind],
    compute: Compute<Matrix<Expr>>,
) -> Method {
    let result = MethodResult::Matrix(compute);
    Method {
        name,
        receiver,
        takes,
        result,
    }
}

/// The methods of nalgebra that are smooth formulas.
pub(super) static METHODS: &[Method] = &[
    number(
        "dot",
        Receiver::Any,
        &[ArgumentKind::Same],
        |arena, m, given| Some(inner(arena, m, given.matrix()?)),
    ),
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
        &[ArgumentKind::Same],
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
        Receiver::OfLength(2),
        &[ArgumentKind::Same],
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
        Receiver::OfLength(3),
        &[ArgumentKind::Same],
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
    matrix("cross_matrix", Receiver::OfLength(3), &[], |arena, m, _| {
        let zero = arena.constant(0.0);
        let [x, y, z] = [0, 1, 2].map(|i| m.entries[i]);
        let [nx, ny, nz] = [x, y, z].map(|entry| arena.neg(entry));
        let rows = [[zero, nz, y], [z, zero, nx], [ny, x, zero]];
        Some(Matrix::from_fn(MatrixType::matrix(3, 3), |i, j| rows[i][j]))
    }),
    matrix(
        "component_mul",
        Receiver::Any,
        &[ArgumentKind::Same],
        |arena, m, given| Some(entrywise(arena, m, given.matrix()?, Arena::mul)),
    ),
    matrix(
        "component_div",
        Receiver::Any,
        &[ArgumentKind::Same],
        |arena, m, given| Some(entrywise(arena, m, given.matrix()?, Arena::div)),
    ),
    matrix(
        "scale",
        Receiver::Any,
        &[ArgumentKind::Number],
        |arena, m, given| Some(each(arena, m, given.number()?, Arena::mul)),
    ),
    matrix(
        "unscale",
        Receiver::Any,
        &[ArgumentKind::Number],
        |arena, m, given| Some(each(arena, m, given.number()?, Arena::div)),
    ),
    matrix(
        "add_scalar",
        Receiver::Any,
        &[ArgumentKind::Number],
        |arena, m, given| Some(each(arena, m, given.number()?, Arena::add)),
    ),
    matrix("normalize", Receiver::Any, &[], |arena, m, _| {
        Some(normalized(arena, m))
    }),
    matrix(
        "lerp",
        Receiver::Vector,
        &[ArgumentKind::Same, ArgumentKind::Number],
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
    matrix("row", Receiver::Any, &[ArgumentKind::Row], |_, m, given| {
        Some(m.part((given.index, 0), MatrixType::matrix(1, m.ty.columns)))
    }),
    matrix(
        "column",
        Receiver::Any,
        &[ArgumentKind::Column],
        |_, m, given| Some(m.part((0, given.index), MatrixType::vector(m.ty.rows))),
    ),
    matrix("into_owned", Receiver::Any, &[], |_, m, _| Some(m.clone())),
    matrix("clone_owned", Receiver::Any, &[], |_, m, _| Some(m.clone())),
    matrix("inverse", Receiver::Rotation, &[], |_, m, _| {
        Some(m.transposed())
    }),
    matrix(
        "transform_vector",
        Receiver::Rotation,
        &[ArgumentKind::Vector],
        |arena, m, given| Some(image(arena, m, given.matrix()?)),
    ),
    matrix(
        "inverse_transform_vector",
        Receiver::Rotation,
        &[ArgumentKind::Vector],
        |arena, m, given| Some(image(arena, &m.transposed(), given.matrix()?)),
    ),
    matrix("matrix", Receiver::Rotation, &[], |_, m, _| {
        Some(m.clone().with_kind(Kind::Matrix))
    }),
    matrix("into_inner", Receiver::Wrapped, &[], |_, m, _| {
        Some(m.clone().with_kind(Kind::Matrix))
    }),
];

impl Receiver {
    pub(super) fn accepts(self, ty: MatrixType) -> bool {
        match self {
            Self::Any => true,
            Self::Vector => ty.is_vector(),
            Self::OfLength(length) => ty.len() == length && ty.rows.min(ty.columns) == 1,
            Self::Square => ty.is_square(),
            Self::One => ty.len() == 1,
            Self::Rotation => ty.kind == Kind::Rotation,
            Self::Wrapped => ty.kind != Kind::Matrix,
        }
    }

    pub(super) fn described(self) -> String {
        match self {
            Self::Any => "matrices".to_owned(),
            Self::Vector => "vectors".to_owned(),
            Self::OfLength(length) => format!("vectors of length {length}"),
            Self::Square => "square matrices".to_owned(),
            Self::One => "matrices of one entry".to_owned(),
            Self::Rotation => "rotations".to_owned(),
            Self::Wrapped => "rotations and unit vectors".to_owned(),
        }
    }
}
