//! Values of the symbolic execution of a body.

use std::rc::Rc;

use super::closures::Closure;
use super::fields::FieldPath;
use super::frames::Place;
use super::integers::Integer;
use super::matrices::Matrix;
use super::scenes::streams::Stream;
use crate::algebra::Expr;
use crate::model::scene::Int;

/// The value of a variable or an expression.
#[derive(Clone)]
pub(super) enum Value {
    /// An `f64`.
    Scalar(Expr),
    /// An integer known at compile time.
    Int(Integer),
    /// An integer known when the program runs.
    Index(Int),
    /// An array or iterator whose length is known when the program runs.
    Stream(Stream),
    Array(Vec<Value>),
    /// A vector, matrix or rotation of nalgebra.
    Matrix(Matrix<Value>),
    Tuple(Vec<Value>),
    /// An iterator: the list of its items.
    Sequence(Vec<Value>),
    /// A field of the user's struct, or a constant from outside the block. Its use decides whether
    /// it is a number, an array or a matrix.
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
    /// Returns a length or an index.
    pub(super) fn count(count: usize) -> Self {
        Self::Int(Integer::count(count))
    }

    /// Returns the entries of an array, a tuple or a matrix.
    pub(super) fn list(&self) -> Option<&Vec<Self>> {
        match self {
            Self::Array(values) | Self::Tuple(values) => Some(values),
            Self::Matrix(matrix) => Some(&matrix.entries),
            _ => None,
        }
    }

    pub(super) fn list_mut(&mut self) -> Option<&mut Vec<Self>> {
        match self {
            Self::Array(values) | Self::Tuple(values) => Some(values),
            Self::Matrix(matrix) => Some(&mut matrix.entries),
            _ => None,
        }
    }

    /// Returns the entries of an array, a tuple or a matrix, or the items of an iterator; an empty
    /// list for other values.
    pub(super) fn items(&self) -> &[Self] {
        match self {
            Self::Sequence(values) => values,
            value => value.list().map_or(&[], Vec::as_slice),
        }
    }

    /// Returns the number of values of which the value consists, itself included.
    pub(super) fn entries(&self) -> usize {
        1 + self.items().iter().map(Self::entries).sum::<usize>()
    }

    /// Returns whether arrays are nested more than `depth` deep in the value.
    pub(super) fn is_deeper(&self, depth: usize) -> bool {
        match self {
            Self::Array(_) | Self::Tuple(_) | Self::Sequence(_) | Self::Matrix(_) => {
                depth == 0 || self.items().iter().any(|value| value.is_deeper(depth - 1))
            }
            _ => false,
        }
    }

    /// Returns the message for a constant from outside the block whose value the macro needs;
    /// `None` for other values.
    pub(super) fn unseen(&self) -> Option<String> {
        match self {
            Self::Field(path) => path.unseen(),
            _ => None,
        }
    }

    pub(super) fn kind(&self) -> String {
        match self {
            Self::Scalar(_) => "an `f64`".to_owned(),
            Self::Int(i) => format!("the integer {}", i.value),
            Self::Index(_) => "an integer known when the program runs".to_owned(),
            Self::Stream(_) => "a sequence whose length is known when the program runs".to_owned(),
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
