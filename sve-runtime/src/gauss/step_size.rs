//! The size of the next step, from the decay of the Legendre series of the steps before.
//!
//! Input: the size of a step, and the logarithm of the ratio of successive terms of its series.
//! Output: the step is accepted or not, and the size of the step to try next. The terms are those
//! of a function whose nearest singularity is a fixed distance away, so the ratio is proportional
//! to the step size. The end of a step with S stages has an error of the order of the ratio to the
//! power 2S; the size for which it is `δ` is the size that fits.
//!
//! The trend of the sizes that fit is carried on: towards a close encounter they fall from step to
//! step. It changes a size by a factor of 2 at most, since a trend without a bound runs to steps of
//! size zero after a start with a much too small step.

use crate::lanes::elementary::{exp2, log2};

/// The error of a step in units of the tolerance. The error after about one period of a regular
/// motion is then about the tolerance.
const STEP_PART: f64 = 1e-5;

/// Smallest error of a step that is aimed at.
const SMALLEST_ERROR: f64 = 1e-20;

/// Changes of the stages that are negligible, in units of the error of a step. The prediction of a
/// change is too small by a factor of 100 in some steps, and with a part of 30 such steps determine
/// the error of a path.
const CHANGE_PART: f64 = 1.0;

/// Smallest change that ends an iteration before its rounding errors do.
const SMALLEST_CHANGE: f64 = 1e-18;

/// Logarithm of the least size that fits, relative to the size of a step that is accepted. With
/// 8 stages the error of such a step is at most 2⁸ times the error that is aimed at.
const LEAST_FIT: f64 = -0.5;

/// Largest growth of the step size, and largest logarithm of the growth of a size that fits. A
/// series without terms of high degree fits steps of any size.
const MOST_GROWTH: f64 = 2.0;
const LARGEST_FIT: f64 = 4.0;

/// Largest decrease after a step that was accepted, after one that was not, and after one whose
/// iteration did not contract.
const MOST_DECREASE: f64 = 0.25;
const MOST_DECREASE_OF_RETRY: f64 = 0.125;
const DECREASE_WITHOUT_CONTRACTION: f64 = 0.25;

/// The control of the step size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StepSize {
    /// The logarithm to base 2 of the ratio of successive terms that is aimed at.
    target: f64,
    /// The relative change of stages that is negligible.
    level: f64,
    /// The size of the next step.
    h: f64,
    /// Largest size.
    most: f64,
    /// The step before: its size, and the logarithm of the size that fitted.
    before: Option<[f64; 2]>,
}

impl StepSize {
    /// Returns the control for a tolerance, of a rule with `stages` stages, with the size of the
    /// first step to try.
    pub(crate) fn new(tolerance: f64, stages: usize, h: f64) -> Self {
        let error = (STEP_PART * tolerance).max(SMALLEST_ERROR);
        Self {
            target: log2(error) / (2 * stages) as f64,
            level: (CHANGE_PART * error).max(SMALLEST_CHANGE),
            h,
            most: f64::INFINITY,
            before: None,
        }
    }

    /// Limits the size of all steps. With a limit that is not positive the next step has no size,
    /// which is an error.
    pub(crate) fn limit(&mut self, most: f64) {
        let is_size = most > 0.0;
        self.most = if is_size { most } else { f64::INFINITY };
        self.h = if is_size {
            self.at_most(most)
        } else {
            0.0 * most
        };
    }

    /// Returns the size of the next step, cut to another one.
    fn at_most(&self, most: f64) -> f64 {
        if self.h.abs() > most {
            most.copysign(self.h)
        } else {
            self.h
        }
    }

    /// Returns the size of the next step.
    pub(crate) fn h(&self) -> f64 {
        self.h
    }

    /// Returns the relative change of stages that is negligible.
    pub(crate) fn level(&self) -> f64 {
        self.level
    }

    /// Judges a step of size `h` by the decay of its series; `None` if the step was not solved.
    /// Returns whether it is accepted, and sets the size of the next step, or of the next attempt.
    pub(crate) fn judge(&mut self, h: f64, decay: Option<f64>) -> bool {
        let Some(decay) = decay else {
            self.h = DECREASE_WITHOUT_CONTRACTION * h;
            return false;
        };
        let fit = self.target - decay;
        // false for NaN
        let is_short_enough = fit >= LEAST_FIT;
        if !is_short_enough {
            self.h = h * exp2(fit.max(-LARGEST_FIT)).max(MOST_DECREASE_OF_RETRY);
            return false;
        }
        let fit = fit.min(LARGEST_FIT);
        let size = h.abs().max(f64::MIN_POSITIVE);
        let fitted = log2(size) + fit;
        let trend = self.before.map_or(0.0, |[size_before, fitted_before]| {
            let slope = (fitted - fitted_before) / (size + size_before);
            slope * (size + size * exp2(fit))
        });
        // a slope over times that underflow is not a number
        let trend = if trend.is_nan() {
            0.0
        } else {
            trend.clamp(-1.0, 1.0)
        };
        let growth = exp2(fit + trend).clamp(MOST_DECREASE, MOST_GROWTH);
        self.h = h * growth;
        self.h = self.at_most(self.most);
        self.before = Some([size, fitted]);
        true
    }

    /// Forgets the step before, after a change of the state, and makes the next step at most as
    /// long as this step of size `h`.
    pub(crate) fn forget(&mut self, h: f64) {
        self.before = None;
        self.h = self.at_most(h.abs());
    }

    /// Returns the numbers that are carried from step to step.
    pub(crate) fn numbers(&self) -> [f64; 3] {
        let [size, fitted] = self.before.unwrap_or([0.0; 2]);
        [self.h, size, fitted]
    }

    /// Replaces the numbers that are carried from step to step.
    pub(crate) fn recall(&mut self, [h, size, fitted]: [f64; 3]) {
        self.h = h;
        self.before = (size != 0.0).then_some([size, fitted]);
    }
}

#[cfg(test)]
mod tests {
    use super::StepSize;

    /// Makes steps of a motion whose series decay by `rate` per unit of time. Returns the sizes.
    fn steps(h: f64, count: usize, rate: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut size = StepSize::new(1e-10, 8, h);
        let (mut t, mut sizes) = (0.0, Vec::new());
        for _ in 0..count {
            let h = size.h();
            if size.judge(h, Some((h.abs() * rate(t)).log2())) {
                t += h;
                sizes.push(h);
            }
        }
        sizes
    }

    #[test]
    fn sizes_reach_the_size_that_fits() {
        // 1e-15 to the power 1/16
        let fit = 10.0_f64.powf(-15.0 / 16.0);
        for h in [1e-3, 1.0, -1e6, -1e-9] {
            let last = *steps(h, 100, |_| 0.5).last().unwrap();
            assert!((last.abs() / (2.0 * fit) - 1.0).abs() < 1e-9, "{h}: {last}");
            assert_eq!(last.signum(), h.signum());
        }
    }

    #[test]
    fn a_trend_is_followed_ahead() {
        // the decay changes by a factor e in 0.2: without the trend each step would be too long
        let sizes = steps(0.01, 200, |t| (5.0 * t).exp());
        let mut size = StepSize::new(1e-10, 8, 0.01);
        assert!(size.judge(0.01, Some(-10.0)));
        assert!(sizes.windows(2).skip(10).all(|pair| pair[1] < pair[0]));
    }

    #[test]
    fn no_start_runs_to_steps_of_size_zero() {
        for h in [1e-300, 1e-3, 1e10, 1e300] {
            let sizes = steps(h, 3000, |t| 1.0 + 0.5 * (0.3 * t).sin());
            assert!(sizes.last().is_some_and(|h| *h > 0.01), "{h:e}");
        }
    }

    #[test]
    fn what_is_not_a_number_is_not_accepted() {
        let mut size = StepSize::new(1e-10, 8, 1.0);
        assert!(!size.judge(1.0, Some(f64::NAN)) && size.h() < 1.0);
        assert!(!size.judge(1.0, Some(f64::INFINITY)) && size.h() < 1.0);
        assert!(!size.judge(1.0, None) && size.h() < 1.0);
        assert!(size.judge(1.0, Some(f64::NEG_INFINITY)) && size.h() == 2.0);
    }
}
