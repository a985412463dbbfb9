//! When the matrix of a block's first solves is factored.
//!
//! A guess, its second stage and its limit have one matrix. Dense matrices of three and more
//! unknowns are factored once for all of them, and in `prepare` if they depend on parameters and
//! step size alone. The runtime solves fewer unknowns by formulas.

use super::{Program, Residual, Tier, Value};
use crate::structure::{Block, Matrix, Solution, Storage};

/// Smallest dense matrix that is solved by factors.
const SMALLEST: usize = 3;

/// Where a matrix is factored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Factored {
    /// Nowhere: each solve eliminates by itself.
    Nowhere,
    /// In a step, once for all its solves.
    InStep,
    /// In `prepare`.
    InPrepare,
}

impl Block<Value, Residual> {
    /// Where the matrix of the first solves is factored.
    pub(crate) fn factored(&self, program: &Program) -> Factored {
        let Some(matrix) = self.solution.first_matrix() else {
            return Factored::Nowhere;
        };
        if matrix.storage != Storage::Dense || matrix.size() < SMALLEST {
            return Factored::Nowhere;
        }
        let is_early = |value: Value| program.get(value).tier == Tier::Prepare;
        if matrix.stored().all(is_early) {
            Factored::InPrepare
        } else if self.solution.first_solves() > 1 {
            Factored::InStep
        } else {
            Factored::Nowhere
        }
    }
}

impl<T: PartialEq, R> Solution<T, R> {
    /// The matrix of the solves before any iteration.
    pub(crate) fn first_matrix(&self) -> Option<&Matrix<T>> {
        match self {
            Self::Formula(_) => None,
            Self::System { linear, .. } => Some(&linear.matrix),
            Self::Iteration(iteration) => Some(&iteration.guess.matrix),
        }
    }

    /// The number of solves with that matrix.
    pub(crate) fn first_solves(&self) -> usize {
        match self {
            Self::Formula(_) => 0,
            Self::System { .. } => 1,
            Self::Iteration(iteration) => {
                let judge = iteration.judge.as_ref();
                let limit = judge.filter(|j| !iteration.limit_is_guess(j));
                1 + iteration.refinements.len() + usize::from(limit.is_some())
            }
        }
    }
}
