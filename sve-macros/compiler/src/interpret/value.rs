//! What a variable of a body can hold while it is run symbolically.

use std::rc::Rc;

use super::closures::Closure;
use super::fields::FieldPath;
use super::integers::Integer;
use super::matrices::Matrix;
use super::references::Place;
use crate::algebra::Expr;

/// A value.
#[derive(Clone)]
pub(super) enum Value {
    /// An `f64`.
    Scalar(Expr),
    /// An integer known at compile time.
    Int(Integer),
    Array(Vec<Value>),
    /// A vector, matrix or rotation of nalgebra.
    Matrix(Matrix<Value>),
    Tuple(Vec<Value>),
    /// An iterator: the list of its items.
    Sequence(Vec<Value>),
    /// A field of the user's struct, or a constant from outside the block: a number, an array or a matrix, which its use decides.
    Field(FieldPath),
    /// `|x| …`, which waits to be called.
    Closure(Rc<Closure>),
    /// `x.into()`: what it becomes is for the type that is written beside it to say.
    Converted(Box<Value>),
    /// `array::from_fn(…)`, whose length is for the type that is written beside it to say.
    Generated(Rc<Closure>),
    /// A mutable reference.
    Place(Place),
    Unit,
    /// A variable that has been declared and not yet assigned to.
    Unset,
    /// The result of a mistake that has been reported.
    Poison,
}

impl Value {
    /// Numbers in it.
    pub(super) fn entries(&self) -> usize {
        match self {
            Self::Array(values) | Self::Tuple(values) | Self::Sequence(values) => {
                1 + values.iter().map(Self::entries).sum::<usize>()
            }
            Self::Matrix(matrix) => 1 + matrix.entries.iter().map(Self::entries).sum::<usize>(),
            _ => 1,
        }
    }

    /// Whether arrays are nested in it more than `depth` deep.
    pub(super) fn is_deeper(&self, depth: usize) -> bool {
        match self {
            Self::Array(values) | Self::Tuple(values) | Self::Sequence(values) => {
                depth == 0 || values.iter().any(|value| value.is_deeper(depth - 1))
            }
            Self::Matrix(matrix) => {
                depth == 0
                    || matrix
                        .entries
                        .iter()
                        .any(|value| value.is_deeper(depth - 1))
            }
            _ => false,
        }
    }

    pub(super) fn kind(&self) -> String {
        match self {
            Self::Scalar(_) => "an `f64`".to_owned(),
            Self::Int(i) => format!("the integer {}", i.value),
            Self::Array(values) => format!("an array of {}", values.len()),
            Self::Matrix(matrix) => format!("a `{}`", matrix.ty),
            Self::Tuple(values) => format!("a tuple of {}", values.len()),
            Self::Sequence(values) => format!("an iterator over {}", values.len()),
            Self::Field(path) => path.kind(),
            Self::Closure(_) => "a closure".to_owned(),
            Self::Converted(inner) => inner.kind(),
            Self::Generated(_) => "an array whose length is not written".to_owned(),
            Self::Place(_) => "a mutable reference".to_owned(),
            Self::Unit => "nothing".to_owned(),
            Self::Unset => "a variable without a value".to_owned(),
            Self::Poison => "an error".to_owned(),
        }
    }
}
