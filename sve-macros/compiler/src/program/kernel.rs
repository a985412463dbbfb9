//! Functions as data: named arrays of expressions → a program with the values of the arrays.
//!
//! Each function of a system or a rule that has no solve within it is such a list of arrays: jets,
//! the linearised step, energies, multipliers, guesses, bounds.

use super::{Labels, Program, Scheduler, Value};
use crate::algebra::Expr;
use crate::structure::{Matrix, Storage};

/// An array that a function computes: of expressions, or of their values in a program.
#[derive(Clone)]
pub(crate) struct Array<T> {
    pub(crate) rows: Vec<Vec<T>>,
    pub(crate) shape: Shape,
    /// Labels of the rows; none for an array without a name.
    names: Vec<String>,
}

/// How an array is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    /// A single number.
    Number,
    /// One row.
    Vector,
    /// Rows, or the stored entries of a matrix of the runtime.
    Matrix(Storage),
}

impl<T: Copy> Array<T> {
    pub(crate) fn number(name: &str, value: T) -> Self {
        Self {
            shape: Shape::Number,
            ..Self::vector(name, &[value])
        }
    }

    pub(crate) fn vector(name: &str, values: &[T]) -> Self {
        Self {
            rows: vec![values.to_vec()],
            shape: Shape::Vector,
            names: vec![name.to_owned()],
        }
    }

    /// Vectors of equal length; the entries of the first are labelled `name_0_0`, `name_0_1`, ….
    pub(crate) fn rows(name: &str, rows: &[Vec<T>]) -> Self {
        Self {
            rows: rows.to_vec(),
            shape: Shape::Matrix(Storage::Dense),
            names: (0..rows.len()).map(|i| format!("{name}_{i}")).collect(),
        }
    }

    pub(crate) fn matrix(name: &str, matrix: &Matrix<T>) -> Self {
        Self {
            shape: Shape::Matrix(matrix.storage),
            ..Self::rows(name, &matrix.rows)
        }
    }

    /// A vector whose values are named by what they are.
    pub(crate) fn unnamed(values: &[T]) -> Self {
        Self::vector("", values).without_names()
    }

    /// The same array, with values that are named by what they are.
    pub(crate) fn without_names(self) -> Self {
        Self {
            names: Vec::new(),
            ..self
        }
    }

    pub(crate) fn entries(&self) -> impl Iterator<Item = T> + '_ {
        self.rows.iter().flatten().copied()
    }
}

/// All entries of some arrays, in order.
pub(crate) fn entries<T: Copy>(arrays: &[Array<T>]) -> Vec<T> {
    arrays.iter().flat_map(Array::entries).collect()
}

/// A function: its program, and the arrays that the function computes.
pub(crate) struct Kernel {
    pub(crate) program: Program,
    pub(crate) labels: Labels,
    pub(crate) arrays: Vec<Array<Value>>,
}

impl Kernel {
    /// Schedules arrays of expressions.
    pub(crate) fn new(mut scheduler: Scheduler<'_>, arrays: &[Array<Expr>]) -> Self {
        let arrays = arrays.iter().map(|array| scheduler.array(array)).collect();
        Self::of_values(scheduler, arrays)
    }

    /// The function that computes arrays which are scheduled.
    pub(crate) fn of_values(scheduler: Scheduler<'_>, arrays: Vec<Array<Value>>) -> Self {
        let mut labels = Labels::default();
        for Array { rows, names, .. } in &arrays {
            for (row, name) in rows.iter().zip(names) {
                labels.vector(name, 0, row);
            }
        }
        labels.expressions(&scheduler, &[]);
        Self {
            program: scheduler.finish(&entries(&arrays)),
            labels,
            arrays,
        }
    }
}

impl Scheduler<'_> {
    /// Schedules an array.
    pub(crate) fn array(&mut self, array: &Array<Expr>) -> Array<Value> {
        Array {
            rows: array.rows.iter().map(|row| self.values(row)).collect(),
            shape: array.shape,
            names: array.names.clone(),
        }
    }
}
