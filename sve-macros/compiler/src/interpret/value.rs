//! Values of the symbolic execution of a body.

use std::rc::Rc;

use super::closures::Closure;
use super::fields::FieldPath;
use super::integers::Integer;
use super::matrices::Matrix;
use super::references::Place;
use crate::algebra::Expr;

/// The value of a variable or an expression.
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
    /// A field of the user's struct, or a constant from outside the block. Its use decides whether it is a number, an array or a matrix.
    Field(FieldPath),
    /// A closure that is not called yet.
    Closure(Rc<Closure>),
    /// The result of `x.into()`, until a type annotation decides its type.
    Converted(Box<Value>),
    /// The array of `array::from_fn(…)`, until a type annotation decides its length.
    Generated(Rc<Closure>),
    /// A mutable reference.
    Place(Place),
    Unit,
    /// The value of a variable that is declared and not yet assigned.
    Unset,
    /// The value of an expression in which a mistake has been reported.
    Poison,
}

impl Value {
    /// Returns the number of values of which the value consists, itself included.
    pub(super) fn entries(&self) -> usize {
        match self {
            Self::Array(values) | Self::Tuple(values) | Self::Sequence(values) => {
                1 + values.iter().map(Self::entries).sum::<usize>()
            }
            Self::Matrix(matrix) => 1 + matrix.entries.iter().map(Self::entries).sum::<usize>(),
            _ => 1,
        }
    }

    /// Returns whether arrays are nested in the value more than `depth` deep.
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
