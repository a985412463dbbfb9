//! Conversion of parameters to numbers in generated code.

use nalgebra::{Rotation, SMatrix};

/// A type that a parameter in a formula can have.
#[diagnostic::on_unimplemented(
    message = "this parameter is taken for an `f64`, and it has another type",
    label = "not an `f64`",
    note = "the macro does not see the types of fields: name the type of a vector or matrix once in the block, as in \
            `let m: Matrix2<f64> = self.m;`"
)]
pub trait Number {
    /// Returns the value.
    fn value(self) -> f64;
}

impl Number for f64 {
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
}

/// Returns the value of a parameter. If the parameter is not an `f64`, the compile error of
/// `Number` explains how to name its type.
#[inline(always)]
pub fn number<T: Number>(parameter: T) -> f64 {
    parameter.value()
}

/// A type that `into` converts to a matrix: an array of columns, a matrix, or a rotation.
pub trait Columns {
    /// Returns the entry of a row and a column.
    fn entry(&self, row: usize, column: usize) -> f64;
}

impl<const R: usize, const C: usize> Columns for [[f64; R]; C] {
    #[inline(always)]
    fn entry(&self, row: usize, column: usize) -> f64 {
        self[column][row]
    }
}

impl<const R: usize, const C: usize> Columns for SMatrix<f64, R, C> {
    #[inline(always)]
    fn entry(&self, row: usize, column: usize) -> f64 {
        self[(row, column)]
    }
}

impl<const D: usize> Columns for Rotation<f64, D> {
    #[inline(always)]
    fn entry(&self, row: usize, column: usize) -> f64 {
        self[(row, column)]
    }
}

/// Returns an entry of a parameter that `into` converts to a matrix.
#[inline(always)]
pub fn entry(parameter: &impl Columns, row: usize, column: usize) -> f64 {
    parameter.entry(row, column)
}
