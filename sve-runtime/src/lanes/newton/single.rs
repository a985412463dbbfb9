//! Newton's method in lanes for a single unknown whose root is accepted by bounds.
//!
//! Input: guesses, and the evaluations at the points of the iteration. Output: the roots, to
//! rounding. The evaluation at the guess belongs to the start, and no test follows it: sizes of
//! updates are compared from the second evaluation on. Thus a step of two evaluations has one loop
//! over the lanes for each evaluation.
//!
//! If an update of third order by u₁ follows an update by u₀, it leaves an error of C u₁³, and C is
//! measured as u₁/u₀³. A third evaluation is omitted if the residual of this error is negligible,
//! by the bound that
//! [`predicts_negligible`](crate::solve::newton::convergence::predicts_negligible) has for relative
//! residuals. Updates have the unit of the unknown, so this prediction does not need the relative
//! residual at the guess, which is large where all terms but one vanish. All other tests compare a
//! residual with the magnitudes of its terms, as the scalar method does.

// Both sides are computed: a branch would prevent vector instructions.
#![allow(clippy::needless_bitwise_bool)]

use super::{CONVERGED, FAILED, ITERATING, LANES, Lane, MAX_ITERATIONS};
use crate::solve::newton::Newton;
use crate::solve::newton::convergence::{Evaluation, NEGLIGIBLE, ROOT_OF_ROUNDING, STALL};
use crate::solve::newton::update::{LARGEST_CORRECTION, tie_breaking_factor};

/// Iterations in one unknown, one for each lane.
#[repr(C, align(64))]
pub struct SingleLanes {
    /// The points to evaluate, or the roots.
    x: Lane,
    /// Sizes of the last updates.
    previous: Lane,
    /// The solutions in the limit of no noise and h → 0, for the bounds of the Jacobian.
    limit: Lane,
    state: [u64; LANES],
    tolerance: f64,
    evaluations_left: u32,
}

impl SingleLanes {
    /// Returns iterations without guesses.
    #[inline(always)]
    pub fn new(newton: &Newton) -> Self {
        Self {
            x: [0.0; LANES],
            previous: [0.0; LANES],
            limit: [0.0; LANES],
            state: [ITERATING; LANES],
            tolerance: newton.tolerance,
            evaluations_left: newton.max_iterations.min(MAX_ITERATIONS),
        }
    }

    /// Makes the first update of a lane, by the evaluation at its guess, and records its solution
    /// in the limit of no noise and h → 0.
    #[inline(always)]
    pub fn start(&mut self, lane: usize, guess: [f64; 1], limit: [f64; 1], at: &Evaluation<1>) {
        let update = Update::of(at);
        self.x[lane] = guess[0] - update.by;
        self.previous[lane] = update.newton.abs();
        self.limit[lane] = limit[0];
    }

    /// Returns the limit of a lane.
    #[inline(always)]
    pub fn limit(&self, lane: usize) -> [f64; 1] {
        [self.limit[lane]]
    }

    /// Returns the point of a lane: the point to evaluate, or the root.
    #[inline(always)]
    pub fn point(&self, lane: usize) -> [f64; 1] {
        [self.x[lane]]
    }

    /// Returns whether a lane is at its root.
    #[inline(always)]
    pub fn has_converged(&self, lane: usize) -> bool {
        self.state[lane] == CONVERGED
    }

    /// Fails a lane whose root is not accepted.
    #[inline(always)]
    pub fn accept(&mut self, lane: usize, is_accepted: bool) {
        self.state[lane] = if is_accepted {
            self.state[lane]
        } else {
            FAILED
        };
    }

    /// Counts an evaluation. Returns whether it has to be made: a lane iterates, and the limit is
    /// not reached.
    #[inline(always)]
    pub fn next_iteration(&mut self) -> bool {
        let mut all_ended = 1;
        for lane in 0..LANES {
            all_ended &= u64::from(self.state[lane] != ITERATING);
        }
        self.evaluations_left = self.evaluations_left.saturating_sub(1);
        all_ended == 0 && self.evaluations_left > 0
    }

    /// Updates a lane by the evaluation at its point, which is not the guess.
    #[inline(always)]
    pub fn update(&mut self, lane: usize, at: &Evaluation<1>) {
        let update = Update::of(at);
        let (x, previous) = (self.x[lane], self.previous[lane]);
        let (residual, magnitude) = (at.residual[0].abs(), at.magnitude[0]);
        let size = update.newton.abs();
        let negligible = self.tolerance * magnitude;
        // No residual is small relative to infinity.
        let is_finite = magnitude < f64::INFINITY;
        let is_below_tolerance = residual <= negligible;
        let has_halved = size <= STALL * previous;
        // u₁³ · u₁/u₀³ times the slope. A product that underflows on the right predicts nothing.
        let square = size * size;
        let predicted = (square * at.jacobian[0][0].abs()) * square;
        let largest = (NEGLIGIBLE * negligible) * (previous * previous * previous);
        let is_last = (predicted < largest) & update.is_third_order;
        let has_converged = is_finite & (is_below_tolerance | (has_halved & is_last));
        // A residual that does not halve at this size is its own rounding error.
        let is_stalled = !has_halved & is_finite & (residual < ROOT_OF_ROUNDING * magnitude);
        let iterates = self.state[lane] == ITERATING;
        let factor = if is_below_tolerance {
            tie_breaking_factor(x)
        } else {
            1.0
        };
        let moved = x - update.by * factor;
        self.x[lane] = if iterates & has_halved { moved } else { x };
        self.previous[lane] = size;
        let unconverged = if has_halved { ITERATING } else { FAILED };
        let state = if has_converged | is_stalled {
            CONVERGED
        } else {
            unconverged
        };
        self.state[lane] = if iterates { state } else { self.state[lane] };
    }
}

/// An update of one unknown, see
/// [`Evaluation::update`](crate::solve::newton::convergence::Evaluation) of the scalar method.
struct Update {
    /// Newton's update.
    newton: f64,
    /// Chebyshev's update if its correction is small, otherwise Newton's update.
    by: f64,
    is_third_order: bool,
}

impl Update {
    #[inline(always)]
    fn of(at: &Evaluation<1>) -> Self {
        // one division for two quotients
        let inverse = 1.0 / at.jacobian[0][0];
        let newton = at.residual[0] * inverse;
        let correction = 0.5 * at.curvature * inverse * newton;
        let is_third_order = correction.abs() <= LARGEST_CORRECTION;
        let by = newton
            + if is_third_order {
                correction * newton
            } else {
                0.0
            };
        Self {
            newton,
            by,
            is_third_order,
        }
    }
}
