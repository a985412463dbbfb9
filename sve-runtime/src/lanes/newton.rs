//! Newton's method in lanes: the fast path of [`Newton`], branch-free.
//!
//! Input and output as there, a lane each. A lane whose iteration arrives is left alone from then on, whatever its
//! neighbours do. A lane is given up, for the scalar step to treat, where a residual does not halve, a Jacobian is singular, a
//! number is NaN, or the judge does not accept the root, by bounds of the Jacobian as in the scalar step. Blocks without bounds have no lanes.
//! Where a lane arrives, its residual passed the same tests as there; the last digit may differ:
//! quotients share a division, and a satisfied equation gets its last update without a test of its Jacobian.

#![allow(clippy::needless_bitwise_bool)] // both sides are computed: a branch would end the vectors

use super::solve::solve;
use super::{LANES, Lane};
use crate::newton::{BENT, Evaluation, NEAR, Newton, QUADRATIC, UNSEEN, last_factor};

/// Iterations after which lanes on their way are given up, so that they do not hold up the others.
const LIMIT: u32 = 12;

const ACTIVE: u64 = 0;
const ARRIVED: u64 = 1;
const GIVEN_UP: u64 = 2;

/// Iterations in `K` unknowns, a lane each.
#[repr(C, align(64))]
pub struct Course<const K: usize> {
    x: [Lane; K],
    /// The solution in the limit of no noise and h → 0, for the judge.
    limit: [Lane; K],
    /// Relative residuals of the last evaluation.
    previous: Lane,
    end: [u64; LANES],
    tolerance: f64,
    left: u32,
}

impl<const K: usize> Course<K> {
    /// Before the first guess.
    #[inline(always)]
    pub fn new(newton: &Newton) -> Self {
        Self {
            x: [[0.0; LANES]; K],
            limit: [[0.0; LANES]; K],
            // so large that the first residual passes for smaller, if it is finite
            previous: [f64::MAX; LANES],
            end: [ACTIVE; LANES],
            tolerance: newton.tolerance,
            left: newton.max_iterations.min(LIMIT) + 1,
        }
    }

    /// Sets the guess of a lane, and the solution of its equations without noise and step.
    #[inline(always)]
    pub fn begin(&mut self, lane: usize, guess: [f64; K], limit: [f64; K]) {
        for i in 0..K {
            self.x[i][lane] = guess[i];
            self.limit[i][lane] = limit[i];
        }
    }

    /// The limit of a lane.
    #[inline(always)]
    pub fn limit(&self, lane: usize) -> [f64; K] {
        core::array::from_fn(|i| self.limit[i][lane])
    }

    /// Gives up a lane whose solution is not accepted.
    #[inline(always)]
    pub fn judge(&mut self, lane: usize, accepted: bool) {
        self.end[lane] = if accepted { self.end[lane] } else { GIVEN_UP };
    }

    /// The point of a lane: to evaluate, or the root.
    #[inline(always)]
    pub fn at(&self, lane: usize) -> [f64; K] {
        core::array::from_fn(|i| self.x[i][lane])
    }

    /// Whether a lane is at its root.
    #[inline(always)]
    pub fn arrived(&self, lane: usize) -> bool {
        self.end[lane] == ARRIVED
    }

    /// Whether a lane is on its way; counts the iterations.
    #[inline(always)]
    pub fn goes_on(&mut self) -> bool {
        let mut ended = 1;
        for lane in 0..LANES {
            ended &= u64::from(self.end[lane] != ACTIVE);
        }
        self.left = self.left.wrapping_sub(1);
        ended == 0 && self.left > 0
    }

    /// Moves a lane on by an evaluation at its point.
    #[inline(always)]
    pub fn update(&mut self, lane: usize, at: &Evaluation<K>) {
        let (relative, update, cubic) = updates(at);
        let previous = self.previous[lane];
        let improves = relative <= 0.5 * previous;
        // as in `Newton::update`
        let (r2, p2) = (relative * relative, previous * previous);
        let next = r2 * if cubic { r2 } else { relative };
        let ratio = p2 * if cubic { previous } else { 1.0 };
        let foreseen = (next <= UNSEEN * self.tolerance * ratio) & (previous < NEAR);
        let last = relative <= self.tolerance;
        let arrives = improves & (foreseen | last);
        let is_rounding = !improves & (relative < QUADRATIC);
        let moves = improves;
        let active = self.end[lane] == ACTIVE;
        for i in 0..K {
            let x = self.x[i][lane];
            let by = update[i] * if last { last_factor(x) } else { 1.0 };
            self.x[i][lane] = if active & moves { x - by } else { x };
        }
        self.previous[lane] = relative;
        let on = if moves { ACTIVE } else { GIVEN_UP };
        let end = if arrives | is_rounding { ARRIVED } else { on };
        self.end[lane] = if active { end } else { self.end[lane] };
    }
}

/// The residual relative to its terms, the update, and whether it is of third order.
#[inline(always)]
fn updates<const K: usize>(at: &Evaluation<K>) -> (f64, [f64; K], bool) {
    if K == 1 {
        let (residual, slope) = (at.residual[0], at.jacobian[0][0]);
        let magnitude = at.magnitude[0] + f64::MIN_POSITIVE;
        // one division for three quotients
        let inverse = 1.0 / (magnitude * slope);
        let inverse_slope = magnitude * inverse;
        let newton = residual * inverse_slope;
        let bend = 0.5 * at.curvature * inverse_slope * newton;
        let cubic = bend.abs() <= BENT;
        let update = newton + if cubic { bend * newton } else { 0.0 };
        let relative = (residual * (slope * inverse)).abs();
        return (relative, [update; K], cubic);
    }
    let (mut largest, mut magnitude, mut sum) = (0.0, 1.0, 0.0);
    for i in 0..K {
        let (r, m) = (at.residual[i].abs(), at.magnitude[i] + f64::MIN_POSITIVE);
        let larger = r * magnitude > largest * m;
        (largest, magnitude) = if larger { (r, m) } else { (largest, magnitude) };
        sum += r + 0.0 * m;
    }
    // the comparison drops a NaN, the sum does not
    let relative = largest / magnitude + 0.0 * sum;
    (relative, solve(&at.jacobian, &at.residual), false)
}

#[cfg(test)]
mod tests {
    use super::{Course, Evaluation, LANES, Lane};
    use crate::newton::Newton;

    /// `x³ + x = a` from `x = a` with Chebyshev's update, all lanes.
    fn cubic(a: &Lane, newton: &Newton) -> Course<1> {
        let mut course = Course::<1>::new(newton);
        for lane in 0..LANES {
            course.begin(lane, [a[lane]], [0.0]);
        }
        while course.goes_on() {
            for lane in 0..LANES {
                let [x] = course.at(lane);
                let at = Evaluation {
                    residual: [x * x * x + x - a[lane]],
                    magnitude: [(x * x * x).abs() + x.abs() + a[lane].abs()],
                    jacobian: [[3.0 * x * x + 1.0]],
                    curvature: 6.0 * x,
                };
                course.update(lane, &at);
            }
        }
        course
    }

    fn values() -> Lane {
        core::array::from_fn(|lane| 0.07 * lane as f64 - 1.1)
    }

    #[test]
    fn roots_are_those_of_the_scalar_method() {
        let (a, newton) = (values(), Newton::default());
        let course = cubic(&a, &newton);
        for lane in 0..LANES {
            assert!(course.arrived(lane));
            let x = course.at(lane)[0];
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
    fn finished_lanes_are_left_alone() {
        let newton = Newton::default();
        let together = cubic(&values(), &newton);
        for lane in 0..LANES {
            let alone = cubic(&[values()[lane]; LANES], &newton);
            assert_eq!(alone.at(0), together.at(lane));
        }
    }

    #[test]
    fn what_does_not_arrive_is_given_up() {
        let newton = Newton::default();
        let mut a = values();
        a[3] = f64::NAN;
        a[5] = f64::INFINITY;
        let course = cubic(&a, &newton);
        for lane in 0..LANES {
            assert_eq!(course.arrived(lane), ![3, 5].contains(&lane), "{lane}");
        }
        // the limit of the scalar method holds here too
        let few = Newton {
            max_iterations: 1,
            ..newton
        };
        let course = cubic(&[4.0; LANES], &few);
        assert!((0..LANES).all(|lane| !course.arrived(lane)));
    }

    #[test]
    fn what_the_judge_refuses_is_given_up() {
        let mut course = cubic(&values(), &Newton::default());
        for lane in 0..LANES {
            course.judge(lane, lane % 3 != 0);
        }
        assert!((0..LANES).all(|lane| course.arrived(lane) == (lane % 3 != 0)));
        // nor does the judge help a lane that did not arrive
        let mut a = values();
        a[3] = f64::NAN;
        let mut course = cubic(&a, &Newton::default());
        course.judge(3, true);
        assert!(!course.arrived(3));
    }

    #[test]
    fn a_singular_jacobian_is_given_up() {
        let mut course = Course::<1>::new(&Newton::default());
        while course.goes_on() {
            for lane in 0..LANES {
                course.update(
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
        assert!((0..LANES).all(|lane| !course.arrived(lane) || !course.at(lane)[0].is_finite()));
    }

    #[test]
    fn several_unknowns() {
        // the intersection of a circle and a diagonal
        let mut course = Course::<2>::new(&Newton::default());
        for lane in 0..LANES {
            course.begin(lane, [1.0 + 0.01 * lane as f64, 1.1], [0.0; 2]);
        }
        while course.goes_on() {
            for lane in 0..LANES {
                let [x, y] = course.at(lane);
                course.update(
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
            assert!(course.arrived(lane));
            for x in course.at(lane) {
                assert!((x - 1.0).abs() <= 4.0 * f64::EPSILON, "{x}");
            }
        }
    }
}
