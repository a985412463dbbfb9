//! The linearised step that the macro generates, and its solution by the implicit-function theorem (`docs/mathematics.md`, section 8).

use nalgebra::DMatrix;

use crate::solve::{SolveError, lu};

/// The non-zero entries of a matrix.
#[derive(Clone, Copy, Debug)]
pub struct Entries<'a> {
    /// Row and column of each.
    pub places: &'a [(usize, usize)],
    /// The value of each.
    pub values: &'a [f64],
}

impl Entries<'_> {
    fn dense(&self, rows: usize, columns: usize) -> DMatrix<f64> {
        let mut dense = DMatrix::zeros(rows, columns);
        for (&place, &value) in self.places.iter().zip(self.values) {
            dense[place] = value;
        }
        dense
    }
}

/// The equations of a step and its results, linearised around a solved step.
#[derive(Clone, Debug)]
pub struct Linearisation {
    residual_by_unknowns: DMatrix<f64>,
    residual_by_inputs: DMatrix<f64>,
    output_by_unknowns: DMatrix<f64>,
    output_by_inputs: DMatrix<f64>,
}

impl Linearisation {
    /// Stores ∂R/∂x, ∂R/∂z, ∂y/∂x, ∂y/∂z for the numbers of unknowns x, outputs y and inputs z.
    #[must_use]
    pub fn new(
        [unknowns, outputs, inputs]: [usize; 3],
        [rx, rz, yx, yz]: [Entries<'_>; 4],
    ) -> Self {
        Self {
            residual_by_unknowns: rx.dense(unknowns, unknowns),
            residual_by_inputs: rz.dense(unknowns, inputs),
            output_by_unknowns: yx.dense(outputs, unknowns),
            output_by_inputs: yz.dense(outputs, inputs),
        }
    }

    /// Stores these matrices.
    pub(crate) fn of_matrices(
        residual_by_unknowns: DMatrix<f64>,
        residual_by_inputs: DMatrix<f64>,
        output_by_unknowns: DMatrix<f64>,
        output_by_inputs: DMatrix<f64>,
    ) -> Self {
        Self {
            residual_by_unknowns,
            residual_by_inputs,
            output_by_unknowns,
            output_by_inputs,
        }
    }

    /// Returns `dy/dz`. With `increments` the results are differences to the state at the start, whose derivative is added.
    ///
    /// # Errors
    /// [`SolveError`] if ∂R/∂x is singular, or the result is not finite.
    pub(crate) fn solve(self, increments: bool) -> Result<DMatrix<f64>, SolveError> {
        let moves = lu::solve(self.residual_by_unknowns, self.residual_by_inputs)?;
        let slopes = self.output_by_unknowns;
        let mut all = self.output_by_inputs;
        if increments {
            (0..all.nrows()).for_each(|i| all[(i, i)] += 1.0);
        }
        // Term by term: a product of matrices may contract operations, with other bits on other machines.
        for column in 0..all.ncols() {
            for row in 0..all.nrows() {
                for k in 0..moves.nrows() {
                    all[(row, column)] -= slopes[(row, k)] * moves[(k, column)];
                }
            }
        }
        if all.iter().all(|x| x.is_finite()) {
            Ok(all)
        } else {
            Err(SolveError::NonFinite)
        }
    }
}
