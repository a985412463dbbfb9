//! What a step hands to the iterations of its blocks: the options, and how their solutions are found and accepted.
//!
//! Input: guess and equations of a block. Output: its solution. Invariant: without given guesses the only cost is a test of that.

use super::{Evaluation, Newton, SolveError, Trust, Way};
use crate::linear::Matrix;

/// Solves the blocks of a step: what [`Variational::increment`](crate::Variational::increment) is called with.
#[derive(Clone, Copy, Debug)]
pub struct Solver<'a> {
    newton: &'a Newton,
    mode: Mode<'a>,
}

/// How solutions are found and accepted.
#[derive(Clone, Copy, Debug)]
enum Mode<'a> {
    /// Blocks guess for themselves. A solution is judged by bounds of the Jacobian where the block has them, else by the
    /// course of its iteration.
    Fast,
    /// Guesses of all unknowns are given, from the last point of a continuation; a solution is accepted where Newton's method
    /// contracts towards it from there.
    Following(&'a [f64]),
    /// Any solution is accepted, where there is nothing to follow.
    Trusting,
}

/// A block of a step, for its iteration.
#[derive(Clone, Copy, Debug)]
pub struct BlockSolve {
    /// Number of its first unknown among all of the step.
    pub first: usize,
    /// Whether its solution is judged by bounds of the Jacobian afterwards.
    pub judged: bool,
    /// A number of the sign of the determinant of the Jacobian in the limit of no noise and h → 0; NaN where there is no such
    /// limit.
    pub origin: f64,
}

impl<'a> Solver<'a> {
    /// Blocks guess for themselves, and do what they can.
    #[inline]
    pub fn new(newton: &'a Newton) -> Self {
        Self {
            newton,
            mode: Mode::Fast,
        }
    }

    /// As [`new`](Self::new), where a solution cannot be followed: any is accepted.
    pub(crate) fn trusting(newton: &'a Newton) -> Self {
        Self {
            newton,
            mode: Mode::Trusting,
        }
    }

    /// Starts from `guesses`, one of each unknown of the step, and accepts only what is reached by contracting updates.
    pub(crate) fn following(newton: &'a Newton, guesses: &'a [f64]) -> Self {
        Self {
            newton,
            mode: Mode::Following(guesses),
        }
    }

    /// Whether solutions have to pass the bounds of their block.
    #[inline(always)]
    pub fn judges(&self) -> bool {
        matches!(self.mode, Mode::Fast)
    }

    /// The solution of a block near `guess`; see the module's page.
    ///
    /// # Errors
    /// [`SolveError`], from the last attempt.
    #[inline]
    pub fn solve_block<const K: usize, J: Matrix<K>>(
        &self,
        block: BlockSolve,
        guess: [f64; K],
        fallback: impl FnOnce() -> [f64; K],
        rounding: impl Fn(&[f64; K]) -> [f64; K],
        evaluate: impl Fn(&[f64; K]) -> Evaluation<K, J>,
    ) -> Result<[f64; K], SolveError> {
        let BlockSolve {
            first,
            judged,
            origin,
        } = block;
        let (trust, origin) = match self.mode {
            Mode::Fast if judged => (Trust::Any, f64::NAN),
            Mode::Fast => (Trust::Segment, origin),
            Mode::Following(_) => (Trust::Calm, origin),
            Mode::Trusting => (Trust::Any, origin),
        };
        let guess = match self.mode {
            Mode::Fast | Mode::Trusting => guess,
            Mode::Following(guesses) => given(guesses, first).unwrap_or(guess),
        };
        let way = Way { origin, trust };
        self.newton
            .solve_or(guess, way, fallback, rounding, evaluate)
    }
}

/// The guesses of a block.
#[cold]
fn given<const K: usize>(guesses: &[f64], first: usize) -> Option<[f64; K]> {
    guesses.get(first..first + K)?.try_into().ok()
}
