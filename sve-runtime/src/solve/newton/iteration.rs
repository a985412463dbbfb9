//! The state of an iteration of Newton's method and the operations off the fast path: the last
//! update, the line search, the verification of a root.

use super::update::{Update, tie_breaking_factor};
use crate::solve::SolveError;

/// Halvings of an update that leads out of the domain of the equations.
const MAX_HALVINGS: u32 = 60;

/// Fraction of the predicted decrease that a damped step must achieve (Armijo's condition).
const DECREASE: f64 = 0.25;

/// Number of subintervals of the segment from the initial guess to the root; the sign of the
/// Jacobian's determinant is checked at their end points.
const SUBINTERVALS: u32 = 16;

/// The phase of an iteration.
#[derive(Clone, Copy, Debug)]
pub(super) enum Phase<const K: usize> {
    /// Makes full Newton steps.
    FullSteps,
    /// Makes damped steps: halves each step until it decreases the residual.
    DampedSteps,
    /// Checks the sign of the Jacobian's determinant at the points of the segment from the guess to
    /// the root.
    Verification {
        root: [f64; K],
        /// Number of the point, from 0 at the guess.
        point: u32,
    },
}

/// The state of an iteration.
#[derive(Clone, Copy)]
pub(super) struct Iteration<const K: usize> {
    pub(super) phase: Phase<K>,
    /// The point to evaluate.
    pub(super) x: [f64; K],
    /// The point before the last update.
    pub(super) previous_x: [f64; K],
    /// Relative residual at `previous_x`.
    pub(super) previous_residual: f64,
    /// Largest residuals at `x` with which the iteration contracts.
    pub(super) contraction_bounds: [f64; K],
    /// Updates made.
    pub(super) updates: u32,
    /// Halvings of the last update.
    pub(super) halvings: u32,
    /// True if all residuals so far have decreased by the contraction factor.
    pub(super) is_contracting: bool,
}

/// Residual and update at the point of an iteration. The Jacobian itself is not passed on, so that
/// its entries need not be stored.
#[derive(Clone, Copy)]
pub(super) struct Judged<const K: usize> {
    pub(super) residual: [f64; K],
    /// For each equation, the sum of the magnitudes of its terms.
    pub(super) magnitude: [f64; K],
    /// The largest residual relative to the magnitude.
    pub(super) relative: f64,
    /// The update from this point; `None` if the Jacobian is singular.
    pub(super) update: Option<Update<K>>,
    pub(super) has_finite_jacobian: bool,
}

/// The decision of a function off the fast path.
pub(super) enum Decision<const K: usize> {
    /// The iteration continues.
    Continue(Iteration<K>),
    /// The iteration is at a root.
    Root(Iteration<K>),
    /// The root passed verification.
    Verified([f64; K]),
}

impl<const K: usize> Iteration<K> {
    pub(super) fn new(guess: [f64; K]) -> Self {
        Self {
            phase: Phase::FullSteps,
            x: guess,
            previous_x: [0.0; K],
            // any finite residual is smaller than half of this one
            previous_residual: f64::MAX,
            contraction_bounds: [f64::MAX; K],
            updates: 0,
            halvings: 0,
            is_contracting: true,
        }
    }

    /// Makes the last update, at a residual below the tolerance. Does nothing if the Jacobian is
    /// singular, or if the update would be larger than the one before and so gain nothing.
    #[inline(always)]
    pub(super) fn make_last_update(&mut self, update: Option<&Update<K>>) {
        let Some(Update { newton: update, .. }) = update else {
            return;
        };
        let mut is_smaller = true;
        for i in 0..K {
            is_smaller &= update[i].abs() <= (self.x[i] - self.previous_x[i]).abs();
        }
        if !is_smaller {
            return;
        }
        for i in 0..K {
            self.x[i] -= update[i] * tie_breaking_factor(self.x[i]);
        }
    }

    /// Returns whether the damped step satisfies Armijo's condition.
    pub(super) fn has_decreased(&self, residual: f64) -> bool {
        let factor = 0.5_f64.powi(self.halvings as i32);
        self.previous_residual == f64::MAX
            || residual <= (1.0 - DECREASE * factor) * self.previous_residual
    }

    /// Halves the last update.
    ///
    /// # Errors
    /// [`SolveError::NonFinite`] if the halved update no longer changes the unknowns.
    pub(super) fn halve_update(self) -> Result<Self, SolveError> {
        if self.x == self.previous_x || self.halvings == MAX_HALVINGS {
            return Err(SolveError::NonFinite);
        }
        let mut x = self.previous_x;
        for i in 0..K {
            x[i] += 0.5 * (self.x[i] - self.previous_x[i]);
        }
        // Half of one unit in the last place can be rounded up to the same point.
        if x == self.x || !x.iter().all(|y| y.is_finite()) {
            x = self.previous_x;
        }
        Ok(Self {
            x,
            halvings: self.halvings + 1,
            is_contracting: false,
            ..self
        })
    }

    /// Begins the verification of the root at `x`.
    #[cold]
    pub(super) fn into_verification(self, guess: &[f64; K]) -> Self {
        Self {
            phase: Phase::Verification {
                root: self.x,
                point: 0,
            },
            x: *guess,
            ..self
        }
    }

    /// Goes on to the next point of the segment from the guess to the root, after a point that
    /// passed.
    pub(super) fn verify_next(
        mut self,
        guess: &[f64; K],
        root: [f64; K],
        point: u32,
    ) -> Decision<K> {
        if point == SUBINTERVALS {
            return Decision::Verified(root);
        }
        let point = point + 1;
        let part = f64::from(point) / f64::from(SUBINTERVALS);
        for i in 0..K {
            self.x[i] = guess[i] + part * (root[i] - guess[i]);
        }
        self.phase = Phase::Verification { root, point };
        Decision::Continue(self)
    }
}
