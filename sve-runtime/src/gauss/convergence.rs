//! Convergence of a fixed-point iteration of stages, and the criterion for Newton's method to take
//! over.
//!
//! Input: the change of each sweep, relative to the sizes of the coordinates. Output: the verdict
//! to continue, to stop, or to leave the step to Newton's method. The iteration starts from the
//! limit of no noise and h → 0 or from the stages of the step before. Changes that do not grow, and
//! that fall by the contraction factor after the first few sweeps, keep the iterates within a ball
//! around the start. In this ball Banach's theorem allows one fixed point only. The contraction is
//! sampled along the iterates, as Newton's method samples its Jacobian, and not proved. A proof by
//! bounds (`connected.rs`) would take a tenth of the time of a step, and fail at long steps whose
//! stages contract well.
//!
//! Source of the test: Hairer, `McLachlan`, Razakarivony, *Achieving Brouwer's law with implicit
//! Runge–Kutta methods*, BIT 48 (2008).

/// Largest contraction factor. A slower iteration costs more than Newton's method, and its limit is
/// less surely the connected root.
const LARGEST_FACTOR: f64 = 0.6;

/// Number of sweeps whose changes may fall more slowly, as long as they do not grow. An iteration
/// reaches its linear rate only near the solution, and Newton's method costs more than these
/// sweeps.
const SLOW_SWEEPS: u32 = 2;

/// Largest number of sweeps.
const MOST_SWEEPS: u32 = 30;

/// Size of the predicted next change, relative to the coordinates, at which the iteration ends. The
/// error that remains has the same sign in many steps and adds up. If it is at most a tenth of half
/// a unit of rounding, ten million steps of a pendulum show no drift of the energy beyond the
/// random walk of rounding errors. With a whole half unit the drift is twice as large as the walk.
const NEGLIGIBLE: f64 = 1e-17;

/// Changes that no longer fall below this size are rounding errors.
const STAGNATION: f64 = 1e-14;

/// The state of an iteration.
#[derive(Clone, Copy)]
pub(crate) struct Course {
    /// The last change.
    last: f64,
    sweeps: u32,
    /// Sweeps whose changes fell by less than the contraction factor.
    slow: u32,
    /// The size of the change after the next one at which the iteration ends early; `None` if it
    /// goes on to rounding errors.
    level: Option<f64>,
}

/// The decision after a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Continue,
    Converged,
    /// The iteration does not contract, or is not finite: Newton's method has to solve the step.
    Leave,
}

impl Course {
    pub(crate) const fn new() -> Self {
        Self {
            last: f64::INFINITY,
            sweeps: 0,
            slow: 0,
            level: None,
        }
    }

    /// Returns an iteration that ends as soon as the change after the next one is below a level.
    /// The caller evaluates the stages once more, so the next change is made too. An iteration that
    /// ends early does not keep the structure of a step.
    pub(super) const fn down_to(level: f64) -> Self {
        Self {
            level: Some(level),
            ..Self::new()
        }
    }

    /// Returns whether no sweep has been judged.
    #[inline(always)]
    pub(super) const fn is_new(&self) -> bool {
        self.sweeps == 0
    }

    /// Returns whether the changes that follow are negligible. Convergence is linear: the next
    /// change is about `change² / last`, and the change after it `change³ / last²`.
    #[inline(always)]
    fn is_negligible(&self, change: f64, last: f64) -> bool {
        match self.level {
            None => change * change <= NEGLIGIBLE * last,
            Some(level) => change * (change / last) * (change / last) <= level,
        }
    }

    /// Judges a sweep by its change. The first sweep says nothing about the rate, unless it changes
    /// nothing.
    #[inline(always)]
    pub(crate) fn judge(&mut self, change: f64) -> Verdict {
        let last = self.last;
        self.last = change;
        self.sweeps += 1;
        if self.is_negligible(change, last) && self.sweeps > 1 || change == 0.0 {
            // `last` is infinite on the first sweep alone
            return Verdict::Converged;
        }
        let contracts = change <= LARGEST_FACTOR * last;
        if !contracts {
            self.slow += 1;
        }
        let may_be_slow = self.slow <= SLOW_SWEEPS && change <= last && change >= STAGNATION;
        if (contracts || may_be_slow) && self.sweeps < MOST_SWEEPS {
            return Verdict::Continue;
        }
        if change < STAGNATION && last < STAGNATION / LARGEST_FACTOR {
            Verdict::Converged
        } else {
            Verdict::Leave
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Course, Verdict};

    /// Returns the verdict on changes that fall by a factor down to a level, and the number of
    /// sweeps.
    fn run(factor: f64, level: f64) -> (Verdict, u32) {
        let (mut course, mut change) = (Course::new(), 0.1_f64);
        loop {
            let verdict = course.judge(change.max(level));
            if verdict != Verdict::Continue {
                return (verdict, course.sweeps);
            }
            change *= factor;
        }
    }

    #[test]
    fn contracting_iterations_converge() {
        // 0.1 · 0.01^k: the change after the ninth would be 1e-19
        assert_eq!(run(0.01, 0.0), (Verdict::Converged, 9));
        assert_eq!(run(0.1, 0.0).0, Verdict::Converged);
    }

    #[test]
    fn slow_iterations_are_left() {
        assert_eq!(run(0.7, 0.0), (Verdict::Leave, 4));
        // The iteration would take more sweeps than Newton's method costs.
        assert_eq!(run(0.55, 0.0), (Verdict::Leave, 30));
    }

    #[test]
    fn the_first_changes_may_fall_slowly_but_not_grow() {
        let verdicts = |changes: &[f64]| {
            let mut course = Course::new();
            let all = changes.iter().map(|&change| course.judge(change));
            all.last()
        };
        assert_eq!(verdicts(&[1.0, 0.8, 0.7, 0.1]), Some(Verdict::Continue));
        assert_eq!(verdicts(&[1.0, 0.8, 0.7, 0.6]), Some(Verdict::Leave));
        assert_eq!(verdicts(&[1.0, 1.1]), Some(Verdict::Leave));
    }

    #[test]
    fn rounding_errors_end_an_iteration() {
        assert_eq!(run(0.1, 2e-16).0, Verdict::Converged);
        assert_eq!(run(0.1, 1e-12).0, Verdict::Leave);
    }

    #[test]
    fn the_first_sweep_does_not_converge_unless_nothing_changes() {
        assert_eq!(Course::new().judge(1e-300), Verdict::Continue);
        assert_eq!(Course::new().judge(0.0), Verdict::Converged);
    }

    #[test]
    fn what_is_not_finite_is_left() {
        assert_eq!(Course::new().judge(f64::NAN), Verdict::Leave);
        let mut course = Course::new();
        assert_eq!(course.judge(0.1), Verdict::Continue);
        assert_eq!(course.judge(f64::NAN), Verdict::Leave);
        let mut course = Course::new();
        course.judge(0.1);
        assert_eq!(course.judge(f64::INFINITY), Verdict::Leave);
    }
}
