//! Newton's method in lanes: the fast path of [`Newton`], without branches.
//!
//! Input and output are those of the scalar method, for each lane. A lane that has converged no longer changes, whatever its neighbours do. A
//! lane fails, and the scalar step treats it, if a residual does not halve, a Jacobian is singular, a number is NaN, or the root is
//! not accepted by the bounds of the Jacobian. Blocks without such bounds have no lanes.
//! A residual passes the same tests in a lane and in the scalar method ([`judge`]). The last digit of a root may differ: quotients share a division, and
//! a converged residual leads to the last update without a test of the Jacobian.

#![allow(clippy::needless_bitwise_bool)] // both sides are computed: a branch would prevent vector instructions

use super::solve::solve;
use super::{LANES, Lane};
use crate::solve::newton::Newton;
use crate::solve::newton::convergence::{Evaluation, judge, predicts_negligible};
use crate::solve::newton::update::{LARGEST_CORRECTION, tie_breaking_factor};

/// Iterations after which a lane fails: slow lanes must not delay the others.
const MAX_ITERATIONS: u32 = 12;

/// State of a lane, as a number of the width of the others so that a comparison gives a mask of the same width.
const ITERATING: u64 = 0;
const CONVERGED: u64 = 1;
const FAILED: u64 = 2;

/// Iterations in `K` unknowns, one for each lane.
#[repr(C, align(64))]
pub struct NewtonLanes<const K: usize> {
    /// The points to evaluate, or the roots.
    x: [Lane; K],
    /// The solutions in the limit of no noise and h → 0, for the bounds of the Jacobian.
    limit: [Lane; K],
    /// Relative residuals of the last evaluation.
    previous_residual: Lane,
    state: [u64; LANES],
    tolerance: f64,
    iterations_left: u32,
}

impl<const K: usize> NewtonLanes<K> {
    /// Iterations without guesses.
    #[inline(always)]
    pub fn new(newton: &Newton) -> Self {
        Self {
            x: [[0.0; LANES]; K],
            limit: [[0.0; LANES]; K],
            // any finite residual is smaller than half of this one
            previous_residual: [f64::MAX; LANES],
            state: [ITERATING; LANES],
            tolerance: newton.tolerance,
            iterations_left: newton.max_iterations.min(MAX_ITERATIONS) + 1,
        }
    }

    /// Sets the guess of a lane, and its solution in the limit of no noise and h → 0.
    #[inline(always)]
    pub fn start(&mut self, lane: usize, guess: [f64; K], limit: [f64; K]) {
        for i in 0..K {
            self.x[i][lane] = guess[i];
            self.limit[i][lane] = limit[i];
        }
    }

    /// Returns the limit of a lane.
    #[inline(always)]
    pub fn limit(&self, lane: usize) -> [f64; K] {
        core::array::from_fn(|i| self.limit[i][lane])
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

    /// Counts an iteration, and returns whether it has to be made: a lane iterates, and the limit is not reached.
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
    pub fn update(&mut self, lane: usize, at: &Evaluation<K>) {
        let (residual, update, is_third_order) = updates(at);
        let previous = self.previous_residual[lane];
        let verdict = judge(residual, previous, self.tolerance);
        let is_last = predicts_negligible(residual, previous, is_third_order, self.tolerance);
        let has_converged = verdict.has_halved & (is_last | verdict.is_converged);
        let iterates = self.state[lane] == ITERATING;
        for i in 0..K {
            let x = self.x[i][lane];
            let factor = if verdict.is_converged {
                tie_breaking_factor(x)
            } else {
                1.0
            };
            let by = update[i] * factor;
            self.x[i][lane] = if iterates & verdict.has_halved {
                x - by
            } else {
                x
            };
        }
        self.previous_residual[lane] = residual;
        let unconverged = if verdict.has_halved {
            ITERATING
        } else {
            FAILED
        };
        let state = if has_converged | verdict.is_stalled_by_rounding {
            CONVERGED
        } else {
            unconverged
        };
        self.state[lane] = if iterates { state } else { self.state[lane] };
    }
}

/// Returns the relative residual, the update, and whether the update is of third order.
#[inline(always)]
fn updates<const K: usize>(at: &Evaluation<K>) -> (f64, [f64; K], bool) {
    if K == 1 {
        let (residual, slope) = (at.residual[0], at.jacobian[0][0]);
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
        return (relative, [update; K], is_third_order);
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
    (relative, solve(&at.jacobian, &at.residual), false)
}

#[cfg(test)]
mod tests {
    use super::{Evaluation, LANES, Lane, Newton, NewtonLanes};

    /// `x³ + x = a` from `x = a` with Chebyshev's update, all lanes.
    fn cubic(a: &Lane, newton: &Newton) -> NewtonLanes<1> {
        let mut iterations = NewtonLanes::<1>::new(newton);
        for lane in 0..LANES {
            iterations.start(lane, [a[lane]], [0.0]);
        }
        while iterations.next_iteration() {
            for lane in 0..LANES {
                let [x] = iterations.point(lane);
                let at = Evaluation {
                    residual: [x * x * x + x - a[lane]],
                    magnitude: [(x * x * x).abs() + x.abs() + a[lane].abs()],
                    jacobian: [[3.0 * x * x + 1.0]],
                    curvature: 6.0 * x,
                };
                iterations.update(lane, &at);
            }
        }
        iterations
    }

    fn values() -> Lane {
        core::array::from_fn(|lane| 0.07 * lane as f64 - 1.1)
    }

    #[test]
    fn roots_are_those_of_the_scalar_method() {
        let (a, newton) = (values(), Newton::default());
        let iterations = cubic(&a, &newton);
        for lane in 0..LANES {
            assert!(iterations.has_converged(lane));
            let x = iterations.point(lane)[0];
            let [expected] = newton
                .solve([a[lane]], |&[x]| Evaluation {
                    residual: [x * x * x + x - a[lane]],
                    magnitude: [(x * x * x).abs() + x.abs() + a[lane].abs()],
                    jacobian: [[3.0 * x * x + 1.0]],
                    curvature: 6.0 * x,
                })
                .unwrap();
            assert!(
                (x - expected).abs() <= 2.0 * f64::EPSILON * x.abs(),
                "{x} {expected}"
            );
        }
    }

    #[test]
    fn converged_lanes_do_not_change() {
        let newton = Newton::default();
        let together = cubic(&values(), &newton);
        for lane in 0..LANES {
            let alone = cubic(&[values()[lane]; LANES], &newton);
            assert_eq!(alone.point(0), together.point(lane));
        }
    }

    #[test]
    fn a_lane_that_does_not_converge_fails() {
        let newton = Newton::default();
        let mut a = values();
        a[3] = f64::NAN;
        a[5] = f64::INFINITY;
        let iterations = cubic(&a, &newton);
        for lane in 0..LANES {
            assert_eq!(
                iterations.has_converged(lane),
                ![3, 5].contains(&lane),
                "{lane}"
            );
        }
        // The scalar method's limit of iterations holds for lanes too.
        let few = Newton {
            max_iterations: 1,
            ..newton
        };
        let iterations = cubic(&[4.0; LANES], &few);
        assert!((0..LANES).all(|lane| !iterations.has_converged(lane)));
    }

    #[test]
    fn a_lane_whose_root_is_not_accepted_fails() {
        let mut iterations = cubic(&values(), &Newton::default());
        for lane in 0..LANES {
            iterations.accept(lane, lane % 3 != 0);
        }
        assert!((0..LANES).all(|lane| iterations.has_converged(lane) == (lane % 3 != 0)));
        // An accepted root does not revive a lane that did not converge.
        let mut a = values();
        a[3] = f64::NAN;
        let mut iterations = cubic(&a, &Newton::default());
        iterations.accept(3, true);
        assert!(!iterations.has_converged(3));
    }

    #[test]
    fn a_lane_with_a_singular_jacobian_fails() {
        let mut iterations = NewtonLanes::<1>::new(&Newton::default());
        while iterations.next_iteration() {
            for lane in 0..LANES {
                iterations.update(
                    lane,
                    &Evaluation {
                        residual: [1.0],
                        magnitude: [1.0],
                        jacobian: [[0.0]],
                        curvature: 1.0,
                    },
                );
            }
        }
        assert!(
            (0..LANES)
                .all(|lane| !iterations.has_converged(lane)
                    || !iterations.point(lane)[0].is_finite())
        );
    }

    #[test]
    fn several_unknowns_converge() {
        // the intersection of a circle and a diagonal
        let mut iterations = NewtonLanes::<2>::new(&Newton::default());
        for lane in 0..LANES {
            iterations.start(lane, [1.0 + 0.01 * lane as f64, 1.1], [0.0; 2]);
        }
        while iterations.next_iteration() {
            for lane in 0..LANES {
                let [x, y] = iterations.point(lane);
                iterations.update(
                    lane,
                    &Evaluation {
                        residual: [x * x + y * y - 2.0, x - y],
                        magnitude: [x * x + y * y + 2.0, x.abs() + y.abs()],
                        jacobian: [[2.0 * x, 2.0 * y], [1.0, -1.0]],
                        curvature: f64::NAN,
                    },
                );
            }
        }
        for lane in 0..LANES {
            assert!(iterations.has_converged(lane));
            for x in iterations.point(lane) {
                assert!((x - 1.0).abs() <= 4.0 * f64::EPSILON, "{x}");
            }
        }
    }
}
