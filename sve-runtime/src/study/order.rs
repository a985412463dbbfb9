//! The measured order of convergence: the slope of error over step size, both as logarithms.
//!
//! Input: squared errors of each path, or differences of an observable, for each step size. Output:
//! an [`Order`] if the local slopes, those between consecutive step sizes, have converged;
//! otherwise [`NotAsymptotic`] with the local slopes.
//!
//! The order is the slope of the least-squares line through the finest step sizes, at least three.
//! Its error has two parts. The error of the paths is found by leaving out one batch of paths at a
//! time (jackknife; B. Efron, *The Jackknife, the Bootstrap and Other Resampling Plans*, SIAM
//! (1982), chapter 2). The scatter around the line would not show it, since all step sizes have the
//! same paths. The error of the step sizes is a bias. If the error is `C hᵖ (1 + b hʳ)` and steps
//! are halved, the local slopes tend to `p`, and each change of the slope is `ρ = 2⁻ʳ` of the
//! change before, so the remaining change is `ρ/(1 − ρ)` of the last one. Growing changes mean that
//! one power is replacing another.

use core::ops::Range;

use super::estimate::Estimate;

/// Number of batches of paths for the jackknife.
const BATCHES: usize = 10;

/// Errors below this fraction of the solution's size can be rounding errors of the method or of its
/// reference.
const ROUNDING: f64 = 4096.0 * f64::EPSILON;

/// Errors below this fraction for each step can be rounding errors too: rounding errors of a phase
/// grow with the number of steps.
const ROUNDING_A_STEP: f64 = 16.0 * f64::EPSILON;

/// Weak errors below this many standard errors can be scatter of the paths.
const SCATTER: f64 = 4.0;

/// Errors above this fraction of the solution's size are not yet proportional to a power of the
/// step size.
const SATURATED: f64 = 0.25;

/// Change of the local slope below which the ratio of changes is not tested.
const SETTLED: f64 = 0.005;

/// Largest change of the local slope if there is no other change to compare it with.
const SETTLED_ALONE: f64 = 0.05;

/// Range of the ratio of two changes of the local slope: from a next power that differs by one or
/// more, to one that differs by less than a half.
const RATIOS: Range<f64> = 0.5..0.75;

/// Safety factor of the remaining change: the ratio of changes is not constant.
const CAUTION: f64 = 2.0;

/// Largest error of an order: a larger one could not distinguish orders that differ by ½.
const LARGEST_ERROR: f64 = 0.25;

/// Smallest number of step sizes of an order: fewer do not have two local slopes to compare.
const FEWEST: usize = 3;

/// The measured order of a method.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// The name of the method.
    pub method: String,
    /// The observable, for a weak order.
    pub observable: Option<String>,
    /// The slope of the strong error, or of the weak error. Its error contains the scatter between
    /// paths and the bias of step sizes that are not small enough; it is at most ¼.
    pub order: Estimate,
    /// Step sizes that it was fitted to: the finest ones, where no path failed, the error is at
    /// most a quarter of the solution's size and more than rounding, and the local slopes are
    /// stable. A weak error is also more than scatter of the paths, and of one sign.
    pub points: usize,
    /// The strong order of the method, if it is known
    /// ([`OneStepMethod::order`](crate::OneStepMethod::order)); `None` beside a weak order.
    pub of_method: Option<f64>,
}

impl Order {
    /// Returns whether the errors at the horizon decrease faster than with the method's order, by
    /// more than the error of the measurement.
    ///
    /// The errors of the method's own order can cancel at this time. They cancel at the end of
    /// whole periods if a rule is conjugate to a rule of higher order, as `initial_point` and
    /// `endpoint` are to the Störmer–Verlet rule for `L = T(v) − V(q)`: a change of coordinates of
    /// the size of `h` transforms one rule into the other, and does not grow.
    pub fn exceeds_method(&self) -> bool {
        let Estimate {
            value,
            standard_error,
        } = self.order;
        self.of_method
            .is_some_and(|order| value - standard_error > order + LARGEST_ERROR)
    }
}

/// A method whose errors have no order yet at the step sizes of the study.
#[derive(Clone, Debug, PartialEq)]
pub struct NotAsymptotic {
    /// The name of the method.
    pub method: String,
    /// The observable, for a weak order.
    pub observable: Option<String>,
    /// Slopes between consecutive step sizes, from the largest to the smallest, for step sizes
    /// whose errors are neither of the size of the solution nor rounding errors. Their standard
    /// errors come from the scatter between paths, and are NaN for a single path.
    pub slopes: Vec<Estimate>,
    /// The strong order of the method, if it is known; `None` beside a weak order.
    pub of_method: Option<f64>,
}

impl NotAsymptotic {
    /// Returns whether the errors decrease faster than with the method's order, as in
    /// [`Order::exceeds_method`].
    pub fn exceeds_method(&self) -> bool {
        let last = self.slopes.last();
        self.of_method
            .zip(last)
            .is_some_and(|(order, last)| last.value > order + 2.0 * LARGEST_ERROR)
    }
}

/// The result of a fit.
pub(super) enum Convergence {
    /// An order, and the number of step sizes that it was fitted to.
    Asymptotic(Estimate, usize),
    /// The local slopes.
    Unsettled(Vec<Estimate>),
}

/// Errors of a step size: its logarithm, the number of its steps, and a number of each path.
pub(super) struct Level {
    pub(super) ln_h: f64,
    pub(super) steps: usize,
    pub(super) of_paths: Vec<f64>,
}

/// How the numbers of the paths give an error.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum ErrorOf {
    /// The root of the mean of squares.
    Squares,
    /// The mean of differences.
    Differences,
}

impl ErrorOf {
    /// Returns the error without some paths.
    fn without(self, level: &Level, left_out: &Range<usize>) -> f64 {
        let mean = mean_without(&level.of_paths, left_out);
        match self {
            Self::Squares => mean.sqrt(),
            Self::Differences => mean,
        }
    }

    /// Returns whether an error can be scatter of the paths.
    fn is_scatter(self, level: &Level, random: bool) -> bool {
        let Estimate {
            value,
            standard_error,
        } = Estimate::mean(&level.of_paths);
        let limit = if random {
            SCATTER * standard_error
        } else {
            0.0
        };
        // a NaN is no scatter: one path says nothing of it
        self == Self::Differences && value.abs() < limit
    }
}

/// Fits the order of errors; `size` is the size of the solution.
pub(super) fn fit(levels: Vec<Level>, of: ErrorOf, size: f64, random: bool) -> Convergence {
    let fit = Fit::new(levels, of, size, random);
    let points = fit.x.len();
    let Some(remaining) = fit.remaining_change() else {
        return Convergence::Unsettled(fit.slopes());
    };
    let best = (0..(points + 1).saturating_sub(FEWEST))
        .map(|first| (fit.order(first, remaining), points - first))
        .min_by(|(a, _), (b, _)| a.standard_error.total_cmp(&b.standard_error));
    match best {
        // a NaN is not below the limit
        Some((order, points)) if order.standard_error <= LARGEST_ERROR => {
            Convergence::Asymptotic(order, points)
        }
        _ => Convergence::Unsettled(fit.slopes()),
    }
}

/// Logarithms of step sizes, from the largest, and of errors: of all paths, and without each batch.
struct Fit {
    x: Vec<f64>,
    y: Vec<f64>,
    without: Vec<Vec<f64>>,
    random: bool,
}

impl Fit {
    fn new(levels: Vec<Level>, of: ErrorOf, size: f64, random: bool) -> Self {
        let error = |level: &Level| of.without(level, &(0..0));
        let converging = |level: &Level| {
            let error = error(level).abs();
            let rounding = ROUNDING.max(ROUNDING_A_STEP * level.steps as f64);
            let is_power = error > rounding * size && error < SATURATED * size;
            is_power && !of.is_scatter(level, random)
        };
        let mut levels: Vec<Level> = levels.into_iter().filter(converging).collect();
        levels.sort_by(|a, b| b.ln_h.total_cmp(&a.ln_h));
        let last = levels.last().map_or(1.0, error);
        let other_sign = levels.iter().rposition(|level| last * error(level) < 0.0);
        levels.drain(..other_sign.map_or(0, |at| at + 1));
        let ln_errors = |left_out: &Range<usize>| -> Vec<f64> {
            let ln_error = |level: &Level| of.without(level, left_out).abs().ln();
            levels.iter().map(ln_error).collect()
        };
        let paths = levels.first().map_or(0, |level| level.of_paths.len());
        let batches = if random { BATCHES.min(paths) } else { 0 };
        let without = (0..batches)
            .map(|b| b * paths / batches..(b + 1) * paths / batches)
            .map(|batch| ln_errors(&batch));
        Self {
            without: without.collect(),
            x: levels.iter().map(|level| level.ln_h).collect(),
            y: ln_errors(&(0..0)),
            random,
        }
    }

    /// A number that logarithms of errors give, with the error of the paths.
    fn estimate(&self, of: impl Fn(&[f64]) -> f64) -> Estimate {
        let value = of(&self.y);
        if !self.random {
            return Estimate::certain(value);
        }
        let values: Vec<f64> = self.without.iter().map(|y| of(y)).collect();
        let b = values.len() as f64;
        // The error of the mean of b values would be the deviation over √b. Leaving one value out
        // moves the mean by 1/(b − 1) of this value's deviation.
        let standard_error = (b - 1.0) * Estimate::mean(&values).standard_error;
        Estimate {
            value,
            standard_error,
        }
    }

    /// Returns the slope between a level and the next finer one.
    fn local(&self, level: usize, y: &[f64]) -> f64 {
        (y[level + 1] - y[level]) / (self.x[level + 1] - self.x[level])
    }

    /// Returns all local slopes.
    fn slopes(&self) -> Vec<Estimate> {
        let levels = 0..self.x.len().saturating_sub(1);
        levels
            .map(|level| self.estimate(|y| self.local(level, y)))
            .collect()
    }

    /// Returns a bound of the distance of the last local slope from the order; `None` if the slopes
    /// have not converged.
    fn remaining_change(&self) -> Option<f64> {
        let last = self.x.len().checked_sub(FEWEST)?;
        let change = |level| self.estimate(|y| self.local(level + 1, y) - self.local(level, y));
        let Estimate {
            value,
            standard_error,
        } = change(last);
        let size = value.abs();
        if size <= 2.0 * standard_error {
            // the change is scatter of the paths
            return Some(size.max(standard_error));
        }
        let before = last.checked_sub(1).map(|level| change(level).value);
        let ratio = match before {
            // With noise, changes of opposite sign are scatter too, which the jackknife
            // underestimates.
            Some(before) if self.random && before * value < 0.0 => {
                return Some(size.max(before.abs()));
            }
            Some(before) => size / before.abs(),
            None if size <= SETTLED_ALONE => RATIOS.end,
            None => return None,
        };
        if ratio > RATIOS.end && size > SETTLED {
            return None;
        }
        let ratio = ratio.clamp(RATIOS.start, RATIOS.end);
        Some(CAUTION * size * ratio / (1.0 - ratio))
    }

    /// Returns the slope through the levels from `first` on. `remaining` bounds the distance of the
    /// last local slope from the order.
    fn order(&self, first: usize, remaining: f64) -> Estimate {
        let through = |y: &[f64]| slope(&self.x[first..], &y[first..]);
        let Estimate {
            value,
            standard_error,
        } = self.estimate(through);
        let last = self.local(self.x.len() - 2, &self.y);
        Estimate {
            value,
            standard_error: standard_error.hypot((last - value).abs() + remaining),
        }
    }
}

/// Returns the mean without some paths.
fn mean_without(of_paths: &[f64], left_out: &Range<usize>) -> f64 {
    let kept = |path: &usize| !left_out.contains(path);
    let (mut sum, mut count) = (0.0, 0.0);
    for path in (0..of_paths.len()).filter(kept) {
        sum += of_paths[path];
        count += 1.0;
    }
    sum / count
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

fn slope(x: &[f64], y: &[f64]) -> f64 {
    let (mx, my) = (mean(x), mean(y));
    let covariance: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    covariance / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>()
}

#[cfg(test)]
#[path = "order_tests.rs"]
mod tests;
