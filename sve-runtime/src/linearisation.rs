//! The linearised step that the macro generates, and its solution by the implicit-function theorem (`docs/mathematics.md`, section 8).

use crate::solve::SolveError;
use crate::solve::gauss_jordan;

/// The non-zero entries of a matrix.
#[derive(Clone, Copy, Debug)]
pub struct Entries<'a> {
    /// Row and column of each.
    pub places: &'a [(usize, usize)],
    /// The value of each.
    pub values: &'a [f64],
}

impl Entries<'_> {
    fn dense(&self, rows: usize, columns: usize) -> Vec<f64> {
        let mut dense = vec![0.0; rows * columns];
        for (&(row, column), &value) in self.places.iter().zip(self.values) {
            dense[columns * row + column] = value;
        }
        dense
    }
}

/// The equations of a step and its results, linearised around a solved step.
#[derive(Clone, Debug)]
pub struct Linearisation {
    unknowns: usize,
    outputs: usize,
    inputs: usize,
    residual_by_unknowns: Vec<f64>,
    residual_by_inputs: Vec<f64>,
    output_by_unknowns: Vec<f64>,
    output_by_inputs: Vec<f64>,
}

impl Linearisation {
    /// Stores ∂R/∂x, ∂R/∂z, ∂y/∂x, ∂y/∂z for the numbers of unknowns x, outputs y and inputs z.
    #[must_use]
    pub fn new(
        [unknowns, outputs, inputs]: [usize; 3],
        [rx, rz, yx, yz]: [Entries<'_>; 4],
    ) -> Self {
        Self {
            unknowns,
            outputs,
            inputs,
            residual_by_unknowns: rx.dense(unknowns, unknowns),
            residual_by_inputs: rz.dense(unknowns, inputs),
            output_by_unknowns: yx.dense(outputs, unknowns),
            output_by_inputs: yz.dense(outputs, inputs),
        }
    }

    /// Returns `dy/dz`, row by row. With `increments` the results are differences to the state at the start, whose derivative is added.
    ///
    /// # Errors
    /// [`SolveError`] if ∂R/∂x is singular, or the result is not finite.
    pub(crate) fn solve(mut self, increments: bool) -> Result<Vec<f64>, SolveError> {
        let moves = &mut self.residual_by_inputs;
        gauss_jordan::solve_columns(&mut self.residual_by_unknowns, moves, self.unknowns)?;
        let mut all = self.output_by_inputs;
        for row in 0..self.outputs {
            let result = &mut all[self.inputs * row..self.inputs * (row + 1)];
            if increments {
                result[row] += 1.0;
            }
            let slopes = &self.output_by_unknowns[self.unknowns * row..];
            let moves = moves.chunks(self.inputs);
            for (&slope, moves) in slopes[..self.unknowns].iter().zip(moves) {
                for (x, by) in result.iter_mut().zip(moves) {
                    *x -= slope * by;
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
