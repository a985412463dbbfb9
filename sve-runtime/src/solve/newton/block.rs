//! The interface of a step to Newton's method: the guesses of its blocks, and the roots that they
//! accept.
//!
//! Input: guess and equations of a block. Output: its solution. Invariant: on the fast path the
//! interface costs one test of its mode.

use super::convergence::{CONTRACTION, STRONG_CONTRACTION};
use super::driver::{Acceptance, RootTest};
use super::{Evaluation, Newton};
use crate::solve::SolveError;
use crate::solve::dense::{DeterminantSign, Matrix};

/// Solves the blocks of a step. `StepEquations::increment` takes it as an argument.
#[derive(Clone, Copy, Debug)]
pub struct BlockSolver<'a> {
    newton: &'a Newton,
    mode: Mode<'a>,
}

/// The guesses from which blocks start, and the roots that they accept.
#[derive(Clone, Copy, Debug)]
enum Mode<'a> {
    /// Starts from the guesses of the blocks. A root is accepted by the path of the iteration if
    /// the block needs strong contraction or has no bounds, otherwise by the bounds of the block's
    /// Jacobian.
    FastPath,
    /// Like the fast path, but blocks that need strong contraction are accepted by the bounds of
    /// their paths.
    Bounds,
    /// Starts from the given solutions, one number for each unknown of the step (warm start).
    /// Rejects a root that Newton does not reach by contracting steps.
    Continuation(&'a [f64]),
    /// Starts from the guesses of the blocks and accepts any root: continuation has no point to
    /// start from.
    Unchecked,
}

/// The properties of a block of a step that Newton's method needs.
#[derive(Clone, Copy, Debug)]
pub struct BlockProperties {
    /// Number of the block's first unknown among all unknowns of the step.
    pub first: usize,
    /// True if the step tests the root by bounds of the Jacobian afterwards.
    pub has_bounds: bool,
    /// True if the fast path accepts a root only when the iteration contracts strongly, and never
    /// by its determinant. This holds for many stages without bounds, and for multipliers of
    /// constraints.
    pub needs_strong_contraction: bool,
    /// The sign of the Jacobian's determinant in the limit of no noise and h → 0.
    pub limit_sign: DeterminantSign,
}

impl<'a> BlockSolver<'a> {
    /// A solver for the fast path: blocks start from their own guesses.
    #[inline]
    pub fn new(newton: &'a Newton) -> Self {
        Self {
            newton,
            mode: Mode::FastPath,
        }
    }

    /// A solver that starts from the given solutions, one number for each unknown of the step, and
    /// rejects a root that Newton does not reach by contracting steps.
    pub(crate) fn warm_started(newton: &'a Newton, solutions: &'a [f64]) -> Self {
        Self {
            newton,
            mode: Mode::Continuation(solutions),
        }
    }

    /// A solver that accepts roots of blocks with multipliers by bounds.
    pub(crate) fn by_bounds(newton: &'a Newton) -> Self {
        Self {
            newton,
            mode: Mode::Bounds,
        }
    }

    /// A solver that accepts any root.
    pub(crate) fn unchecked(newton: &'a Newton) -> Self {
        Self {
            newton,
            mode: Mode::Unchecked,
        }
    }

    /// Returns whether the step is solved on its own, from its own guesses and with its own tests
    /// of the root.
    #[inline(always)]
    pub fn is_fast_path(&self) -> bool {
        matches!(self.mode, Mode::FastPath)
    }

    /// Returns whether the step has to test roots by the bounds of their blocks.
    #[inline(always)]
    pub fn tests_bounds(&self) -> bool {
        matches!(self.mode, Mode::FastPath | Mode::Bounds)
    }

    /// Returns whether the step has to test roots by the bounds of the paths of their blocks.
    #[inline(always)]
    pub fn tests_paths(&self) -> bool {
        matches!(self.mode, Mode::Bounds)
    }

    /// Solves a block. Starts from `guess`, then from the result of `fallback`. `guess` is not
    /// copied before the first evaluation. `rounding` bounds the rounding errors of the residual.
    /// The header of `solve/newton/mod.rs` says which attempts follow a failure.
    ///
    /// # Errors
    /// The [`SolveError`] of the last attempt.
    #[inline]
    pub fn solve_block<const K: usize, J: Matrix<K>>(
        &self,
        block: BlockProperties,
        guess: &[f64; K],
        fallback: impl FnOnce() -> [f64; K],
        rounding: impl Fn(&[f64; K]) -> [f64; K],
        evaluate: impl Fn(&[f64; K]) -> Evaluation<K, J>,
    ) -> Result<[f64; K], SolveError> {
        let BlockProperties {
            first,
            has_bounds,
            needs_strong_contraction,
            limit_sign,
        } = block;
        let (acceptance, sign) = match self.mode {
            Mode::FastPath if needs_strong_contraction => (Acceptance::Contracting, limit_sign),
            Mode::Bounds if needs_strong_contraction && !has_bounds => {
                return Err(SolveError::OtherBranch);
            }
            Mode::FastPath | Mode::Bounds if has_bounds => {
                (Acceptance::Any, DeterminantSign::UNKNOWN)
            }
            Mode::FastPath | Mode::Bounds => (Acceptance::OneUnknownOnSegment, limit_sign),
            Mode::Continuation(_) => (Acceptance::Contracting, limit_sign),
            Mode::Unchecked => (Acceptance::Any, limit_sign),
        };
        let guess = match self.mode {
            Mode::FastPath | Mode::Bounds | Mode::Unchecked => guess,
            Mode::Continuation(solutions) => block_of(solutions, first, guess),
        };
        let contraction = match self.mode {
            Mode::FastPath if needs_strong_contraction => STRONG_CONTRACTION,
            _ => CONTRACTION,
        };
        let test = RootTest {
            sign,
            acceptance,
            contraction,
        };
        self.newton
            .solve_from(guess, test, Some(fallback), rounding, evaluate)
    }
}

/// Returns the recorded solution of the block whose first unknown has the number `first`; `guess`
/// if no solution is recorded.
#[cold]
fn block_of<'a, const K: usize>(
    solutions: &'a [f64],
    first: usize,
    guess: &'a [f64; K],
) -> &'a [f64; K] {
    let block = solutions.get(first..first + K);
    block
        .and_then(|block| block.try_into().ok())
        .unwrap_or(guess)
}
