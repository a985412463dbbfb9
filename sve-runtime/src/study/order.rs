//! The measured order of convergence: the slope of error over step size, both as logarithms.
//!
//! Input: squared errors of each path for each step size. Output: an [`Order`] where the slopes between consecutive step sizes have
//! settled, and the slopes themselves, [`NotAsymptotic`], where they have not.
//!
//! The slope is that of least squares through the finest step sizes, at least three. Its error has two parts. That of the paths is
//! from leaving out a batch of them at a time (the jackknife: the errors of all step sizes are on the same paths, so their scatter
//! around the line says nothing; B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, SIAM (1982), chapter 2). That of
//! the step sizes is a bias: where the error is `C hᵖ (1 + b hʳ)` and steps are halved, the local slopes tend to `p`, and each change
//! of them is `ρ = 2⁻ʳ` of the one before, so what is left is `ρ/(1 − ρ)` of the last change. Changes that grow instead say that
//! one power is taking the place of another.

use core::ops::Range;

use super::estimate::Estimate;

/// Batches of paths that are left out in turn.
const BATCHES: usize = 10;

/// Errors below this part of the solution's size may be rounding errors of the method or of its reference …
const ROUNDING: f64 = 4096.0 * f64::EPSILON;

/// … and so may those below this part for each step: rounding errors of a phase grow with the number of steps.
const ROUNDING_A_STEP: f64 = 16.0 * f64::EPSILON;

/// Errors above this part of the solution's size are not yet in proportion to a power of the step size.
const SATURATED: f64 = 0.25;

/// Changes of the local slope below this may have any ratio.
const SETTLED: f64 = 0.005;

/// Largest change of the local slope where there is no other to compare it with.
const SETTLED_ALONE: f64 = 0.05;

/// Ratios of a change of the local slope to the one before that are believed: of a next power that is one away or more, to one that is
/// less than half away.
const RATIOS: Range<f64> = 0.5..0.75;

/// What the changes of the local slope leave to expect is taken so many times: their ratio is not quite the same.
const CAUTION: f64 = 2.0;

/// The largest error of an order: with a larger one it would not tell orders from each other that are ½ apart.
const LARGEST_ERROR: f64 = 0.25;

/// Step sizes that an order takes at least: fewer have no two local slopes to compare.
const FEWEST: usize = 3;

/// The measured order of a method.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// The name of the method.
    pub method: String,
    /// The slope of the strong error. Its error contains the scatter between paths and the bias of step sizes that are not small
    /// enough; it is at most ¼.
    pub order: Estimate,
    /// Step sizes that it was fitted to: the finest ones, where no path failed, the error is at most a quarter of the solution's size
    /// and more than rounding, and the local slopes are stable.
    pub points: usize,
    /// The order that the method has, where it tells ([`Method::order`](crate::Method::order)).
    pub of_method: Option<f64>,
}

impl Order {
    /// Whether the errors at the horizon fall faster than the method's order says, by more than the error of the measurement.
    ///
    /// So they do where the errors of the method's own order cancel at that time. They do at the end of whole periods where a rule is
    /// conjugate to one of higher order, as `initial_point` and `endpoint` are to the Störmer–Verlet rule for `L = T(v) − V(q)`: a change of
    /// coordinates of the size of `h` takes one into the other, and does not grow.
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
    /// Slopes between consecutive step sizes, from the largest to the smallest, of those whose errors are neither of the size of the
    /// solution nor rounding. Their standard errors are those of the scatter between paths, NaN for a single one.
    pub slopes: Vec<Estimate>,
    /// The order that the method has, where it tells.
    pub of_method: Option<f64>,
}

impl NotAsymptotic {
    /// Whether the errors still fall faster than the method's order says, as in [`Order::exceeds_method`].
    pub fn exceeds_method(&self) -> bool {
        let last = self.slopes.last();
        self.of_method
            .zip(last)
            .is_some_and(|(order, last)| last.value > order + 2.0 * LARGEST_ERROR)
    }
}

/// What the errors of a method tell of its order.
pub(super) enum Convergence {
    /// An order, and the number of step sizes that it was fitted to.
    Asymptotic(Estimate, usize),
    /// The local slopes.
    Unsettled(Vec<Estimate>),
}

/// Errors of a step size: its logarithm, the number of its steps, and the square of each path.
pub(super) struct Level {
    pub(super) ln_h: f64,
    pub(super) steps: usize,
    pub(super) squares: Vec<f64>,
}

/// The order of errors. `size` is that of the solution.
pub(super) fn fit(levels: Vec<Level>, size: f64, random: bool) -> Convergence {
    let fit = Fit::new(levels, size, random);
    let points = fit.x.len();
    let Some(left) = fit.left() else {
        return Convergence::Unsettled(fit.slopes());
    };
    let best = (0..(points + 1).saturating_sub(FEWEST))
        .map(|first| (fit.order(first, left), points - first))
        .min_by(|(a, _), (b, _)| a.standard_error.total_cmp(&b.standard_error));
    match best {
        // what is not a number is not below
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
    fn new(levels: Vec<Level>, size: f64, random: bool) -> Self {
        let converging = |level: &Level| {
            let error = root_mean(&level.squares, &(0..0));
            let rounding = ROUNDING.max(ROUNDING_A_STEP * level.steps as f64);
            error > rounding * size && error < SATURATED * size
        };
        let mut levels: Vec<Level> = levels.into_iter().filter(converging).collect();
        levels.sort_by(|a, b| b.ln_h.total_cmp(&a.ln_h));
        let ln_errors = |left_out: &Range<usize>| -> Vec<f64> {
            let ln_error = |level: &Level| root_mean(&level.squares, left_out).ln();
            levels.iter().map(ln_error).collect()
        };
        let paths = levels.first().map_or(0, |level| level.squares.len());
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
        // of the mean of b values it would be the deviation over √b; leaving one out moves the mean by 1/(b − 1) of that
        let standard_error = (b - 1.0) * Estimate::mean(&values).standard_error;
        Estimate {
            value,
            standard_error,
        }
    }

    /// The slope between a level and the next finer one.
    fn local(&self, level: usize, y: &[f64]) -> f64 {
        (y[level + 1] - y[level]) / (self.x[level + 1] - self.x[level])
    }

    /// All local slopes.
    fn slopes(&self) -> Vec<Estimate> {
        let levels = 0..self.x.len().saturating_sub(1);
        levels
            .map(|level| self.estimate(|y| self.local(level, y)))
            .collect()
    }

    /// How far the last local slope may be from the order, if the slopes have settled.
    fn left(&self) -> Option<f64> {
        let last = self.x.len().checked_sub(FEWEST)?;
        let change = |level| self.estimate(|y| self.local(level + 1, y) - self.local(level, y));
        let Estimate {
            value,
            standard_error,
        } = change(last);
        let size = value.abs();
        if size <= 2.0 * standard_error {
            // it is scatter
            return Some(size.max(standard_error));
        }
        let before = last.checked_sub(1).map(|level| change(level).value);
        let ratio = match before {
            // with noise up and down is scatter too, of paths that the jackknife does not have
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

    /// The slope through the levels from the first given. `left` is how far the last local slope may be from the order.
    fn order(&self, first: usize, left: f64) -> Estimate {
        let through = |y: &[f64]| slope(&self.x[first..], &y[first..]);
        let Estimate {
            value,
            standard_error,
        } = self.estimate(through);
        let last = self.local(self.x.len() - 2, &self.y);
        Estimate {
            value,
            standard_error: standard_error.hypot((last - value).abs() + left),
        }
    }
}

/// The root of the mean square without some paths.
fn root_mean(squares: &[f64], left_out: &Range<usize>) -> f64 {
    let kept = |path: &usize| !left_out.contains(path);
    let (mut sum, mut count) = (0.0, 0.0);
    for path in (0..squares.len()).filter(kept) {
        sum += squares[path];
        count += 1.0;
    }
    (sum / count).sqrt()
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
