//! Newton's method in lanes: the fast path of [`Newton`], without branches.
//!
//! Input and output are the same as for the scalar method, for each lane. A lane that has converged
//! no longer changes, even if its neighbours iterate. A lane fails, and the scalar step treats it,
//! if a residual does not halve, a Jacobian is singular, a number is NaN, or the root is not
//! accepted. As in the scalar method a root is accepted either by bounds of the Jacobian
//! ([`ByBounds`]) or by the path of the iteration ([`ByContraction`]).
//!
//! A residual passes the same tests in a lane and in the scalar method ([`judge`]). The last digit
//! of a root may differ: quotients share a division, and a converged residual leads to the last
//! update without a test of the Jacobian. A single unknown with bounds has an iteration of its own,
//! [`SingleLanes`].

// Both sides are computed: a branch would prevent vector instructions.
#![allow(clippy::needless_bitwise_bool)]

mod acceptance;
mod single;

use super::solve::Solved;
use super::{LANES, Lane};
use crate::solve::newton::Newton;
use crate::solve::newton::convergence::{Evaluation, judge, predicts_negligible};
use crate::solve::newton::update::{LARGEST_CORRECTION, tie_breaking_factor};
use acceptance::{Acceptance, ByBounds, ByContraction};

pub use single::SingleLanes;

/// Iterations after which a lane fails: slow lanes must not delay the others.
const MAX_ITERATIONS: u32 = 12;

/// State of a lane. The numbers have the width of the other numbers, so that a comparison gives a
/// mask of the same width.
const ITERATING: u64 = 0;
const CONVERGED: u64 = 1;
const FAILED: u64 = 2;

/// Iterations in `K` unknowns, one for each lane. `A` is the criterion by which roots are accepted.
#[repr(C, align(64))]
pub struct NewtonLanes<const K: usize, A = ByBounds<K>> {
    /// The points to evaluate, or the roots.
    x: [Lane; K],
    acceptance: A,
    /// Relative residuals of the last evaluation.
    previous_residual: Lane,
    state: [u64; LANES],
    tolerance: f64,
    iterations_left: u32,
}

/// Iterations whose roots are accepted by the path of the iteration.
pub type ContractingLanes<const K: usize> = NewtonLanes<K, ByContraction<K>>;

impl<const K: usize> NewtonLanes<K> {
    /// Sets the guess of a lane, and its solution in the limit of no noise and h → 0.
    #[inline(always)]
    pub fn start(&mut self, lane: usize, guess: [f64; K], limit: [f64; K]) {
        self.set_guess(lane, guess);
        self.acceptance.set_limit(lane, limit);
    }

    /// Returns the limit of a lane.
    #[inline(always)]
    pub fn limit(&self, lane: usize) -> [f64; K] {
        self.acceptance.limit(lane)
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
}

impl<const K: usize> ContractingLanes<K> {
    /// Sets the guess of a lane, and the sign that the determinant of each Jacobian must have; NaN
    /// if the sign is unknown. A guess that is NaN fails the lane.
    #[inline(always)]
    pub fn start(&mut self, lane: usize, guess: [f64; K], sign: f64) {
        self.set_guess(lane, guess);
        self.acceptance.set_sign(lane, sign);
    }
}

impl<const K: usize, A: Acceptance<K>> NewtonLanes<K, A> {
    /// Returns iterations without guesses.
    #[inline(always)]
    pub fn new(newton: &Newton) -> Self {
        Self {
            x: [[0.0; LANES]; K],
            acceptance: A::new(),
            // any finite residual is smaller than half of this one
            previous_residual: [f64::MAX; LANES],
            state: [ITERATING; LANES],
            tolerance: newton.tolerance,
            iterations_left: newton.max_iterations.min(MAX_ITERATIONS) + 1,
        }
    }

    #[inline(always)]
    fn set_guess(&mut self, lane: usize, guess: [f64; K]) {
        for i in 0..K {
            self.x[i][lane] = guess[i];
        }
    }

    /// Returns the point of a lane: the point to evaluate, or the root.
    #[inline(always)]
    pub fn point(&self, lane: usize) -> [f64; K] {
        core::array::from_fn(|i| self.x[i][lane])
    }

    /// Returns whether a lane is at its root.
    #[inline(always)]
    pub fn has_converged(&self, lane: usize) -> bool {
        self.state[lane] == CONVERGED
    }

    /// Counts an iteration. Returns whether it has to be made: a lane iterates, and the limit is
    /// not reached.
    #[inline(always)]
    pub fn next_iteration(&mut self) -> bool {
        let mut all_ended = 1;
        for lane in 0..LANES {
            all_ended &= u64::from(self.state[lane] != ITERATING);
        }
        self.iterations_left = self.iterations_left.wrapping_sub(1);
        all_ended == 0 && self.iterations_left > 0
    }

    /// Updates a lane by the evaluation at its point.
    #[inline(always)]
    pub fn update(&mut self, lane: usize, at: &Evaluation<K, A::Jacobian>) {
        let (residual, update) = updates::<K, A>(at);
        let is_third_order = update.is_third_order;
        let previous = self.previous_residual[lane];
        let verdict = judge(residual, previous, self.tolerance);
        let is_last = predicts_negligible(residual, previous, is_third_order, self.tolerance);
        let passes = self.acceptance.passes(lane, at, previous, &update);
        let goes_on = verdict.has_halved & passes;
        let has_converged = goes_on & (is_last | verdict.is_converged);
        let iterates = self.state[lane] == ITERATING;
        for i in 0..K {
            let x = self.x[i][lane];
            let factor = if verdict.is_converged {
                tie_breaking_factor(x)
            } else {
                1.0
            };
            let by = update.solved.by[i] * factor;
            self.x[i][lane] = if iterates & verdict.has_halved {
                x - by
            } else {
                x
            };
        }
        self.previous_residual[lane] = residual;
        self.acceptance.note(lane, at, residual);
        let unconverged = if goes_on { ITERATING } else { FAILED };
        let state = if has_converged | verdict.is_stalled_by_rounding {
            CONVERGED
        } else {
            unconverged
        };
        self.state[lane] = if iterates { state } else { self.state[lane] };
    }
}

/// An update of a lane.
pub struct Update<const K: usize> {
    /// The vector to be subtracted from the unknowns, and the sign of the Jacobian's determinant.
    solved: Solved<K>,
    is_third_order: bool,
}

/// Returns the relative residual and the update.
#[inline(always)]
fn updates<const K: usize, A: Acceptance<K>>(at: &Evaluation<K, A::Jacobian>) -> (f64, Update<K>) {
    if K == 1 {
        let (residual, slope) = (at.residual[0], A::slope(&at.jacobian));
        let magnitude = at.magnitude[0] + f64::MIN_POSITIVE;
        // one division for three quotients
        let inverse = 1.0 / (magnitude * slope);
        let inverse_slope = magnitude * inverse;
        let newton = residual * inverse_slope;
        let correction = 0.5 * at.curvature * inverse_slope * newton;
        let is_third_order = correction.abs() <= LARGEST_CORRECTION;
        let update = newton
            + if is_third_order {
                correction * newton
            } else {
                0.0
            };
        let relative = (residual * (slope * inverse)).abs();
        let solved = Solved {
            by: [update; K],
            determinant: slope,
        };
        let update = Update {
            solved,
            is_third_order,
        };
        return (relative, update);
    }
    let (mut largest, mut magnitude, mut sum) = (0.0, 1.0, 0.0);
    for i in 0..K {
        let (r, m) = (at.residual[i].abs(), at.magnitude[i] + f64::MIN_POSITIVE);
        let is_larger = r * magnitude > largest * m;
        (largest, magnitude) = if is_larger {
            (r, m)
        } else {
            (largest, magnitude)
        };
        sum += r + 0.0 * m;
    }
    // the comparison drops a NaN, the sum does not
    let relative = largest / magnitude + 0.0 * sum;
    let is_third_order = false;
    let update = Update {
        solved: A::solve(&at.jacobian, &at.residual),
        is_third_order,
    };
    (relative, update)
}

#[cfg(test)]
mod tests;
