//! What a step hands to its iterations: the options, and where a solution is followed from one step to another, the guesses.
//!
//! Input: guess and equations of a block. Output: its solution. Invariant: without a tape the only cost is a test of that.

use std::cell::{Cell, RefCell};

use super::{Evaluation, Newton, SolveError, Trust, Way};
use crate::linear::Matrix;

/// Solves the blocks of a step: what [`Variational::increment`](crate::Variational::increment) is called with.
#[derive(Clone, Copy, Debug)]
pub struct Solver<'a> {
    newton: &'a Newton,
    trust: Trust,
    tape: Option<&'a Tape>,
}

/// The solutions of the blocks of a step, one after the other.
#[derive(Debug, Default)]
pub(crate) struct Tape {
    /// Guesses; where they end, each block guesses for itself.
    guesses: Vec<f64>,
    /// How many of them are used.
    used: Cell<usize>,
    found: RefCell<Vec<f64>>,
}

impl Tape {
    pub(crate) fn new(guesses: Vec<f64>) -> Self {
        Self {
            guesses,
            ..Self::default()
        }
    }

    /// What was found.
    pub(crate) fn into_found(self) -> Vec<f64> {
        self.found.into_inner()
    }

    #[cold]
    fn guess<const K: usize>(&self, own: [f64; K]) -> [f64; K] {
        let used = self.used.get();
        self.used.set(used + K);
        let given = self.guesses.get(used..used + K);
        given.and_then(|x| x.try_into().ok()).unwrap_or(own)
    }

    #[cold]
    fn note(&self, solution: &[f64]) {
        self.found.borrow_mut().extend(solution);
    }
}

impl<'a> Solver<'a> {
    /// Blocks guess for themselves, and do what they can.
    #[inline]
    pub fn new(newton: &'a Newton) -> Self {
        Self {
            newton,
            trust: Trust::Segment,
            tape: None,
        }
    }

    /// As [`new`](Self::new), where a solution cannot be followed.
    pub(crate) fn trusting(newton: &'a Newton) -> Self {
        Self {
            trust: Trust::Any,
            ..Self::new(newton)
        }
    }

    /// Guesses are those of the tape, and a solution that is not in plain reach of its guess is none.
    pub(crate) fn following(newton: &'a Newton, tape: &'a Tape) -> Self {
        Self {
            newton,
            trust: Trust::Calm,
            tape: Some(tape),
        }
    }

    /// The solution of a block near `guess`; see the module's page. `origin` has the sign of the determinant of the Jacobian in
    /// the limit of no noise and h → 0, or is NaN where there is no such limit.
    ///
    /// # Errors
    /// [`SolveError`], from the last attempt.
    #[inline]
    pub fn solve_or<const K: usize, J: Matrix<K>>(
        &self,
        guess: [f64; K],
        origin: f64,
        fallback: impl FnOnce() -> [f64; K],
        rounding: impl Fn(&[f64; K]) -> [f64; K],
        evaluate: impl Fn(&[f64; K]) -> Evaluation<K, J>,
    ) -> Result<[f64; K], SolveError> {
        let guess = match self.tape {
            None => guess,
            Some(tape) => tape.guess(guess),
        };
        let way = Way {
            origin,
            trust: self.trust,
        };
        let x = self
            .newton
            .solve_or(guess, way, fallback, rounding, evaluate)?;
        if let Some(tape) = self.tape {
            tape.note(&x);
        }
        Ok(x)
    }
}
