//! The measured order of convergence: the slope of error over step size, both as logarithms, by least squares.
//!
//! Input: squared errors of each path for each step size. Output: the slope with its standard error: from leaving out a batch of
//! paths at a time (the jackknife; the errors of all step sizes are on the same paths, so their scatter around the line says nothing),
//! or, without noise, from the distances of the points to the line.
//! B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, SIAM (1982), chapter 2.

use super::estimate::Estimate;

/// Batches of paths that are left out in turn.
const BATCHES: usize = 10;

/// Errors below this part of the solution's size may be rounding errors of the method or of its reference.
const ROUNDING: f64 = 4096.0 * f64::EPSILON;

/// Errors above this part of the solution's size are not yet in proportion to a power of the step size.
const SATURATED: f64 = 0.25;

/// The measured order of a method.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// The name of the method.
    pub method: String,
    /// The slope of the strong error; its standard error is NaN where two points without noise leave nothing to estimate it from.
    pub order: Estimate,
    /// Step sizes that it was fitted to: those where no path failed, and the error is at most a quarter of the solution's size and
    /// more than rounding.
    pub points: usize,
}

/// Errors of a step size: its logarithm, and the square of each path.
pub(super) struct Level {
    pub(super) ln_h: f64,
    pub(super) squares: Vec<f64>,
}

/// The slope, and how many levels it was fitted to; `None` for fewer than two. `size` is that of the solution.
pub(super) fn fit(levels: &[Level], size: f64, random: bool) -> Option<(Estimate, usize)> {
    let converging = |level: &&Level| {
        let error = root_mean(&level.squares, &(0..0));
        error > ROUNDING * size && error < SATURATED * size
    };
    let levels: Vec<&Level> = levels.iter().filter(converging).collect();
    if levels.len() < 2 {
        return None;
    }
    let x: Vec<f64> = levels.iter().map(|level| level.ln_h).collect();
    let without = |left_out: &core::ops::Range<usize>| -> Vec<f64> {
        let ln_error = |level: &&Level| root_mean(&level.squares, left_out).ln();
        levels.iter().map(ln_error).collect()
    };
    let y = without(&(0..0));
    let value = slope(&x, &y);
    let standard_error = if random {
        let paths = levels[0].squares.len();
        let batches = BATCHES.min(paths);
        let slopes: Vec<f64> = (0..batches)
            .map(|b| b * paths / batches..(b + 1) * paths / batches)
            .map(|batch| slope(&x, &without(&batch)))
            .collect();
        let b = batches as f64;
        // of the mean of b values it would be the deviation over √b; leaving one out moves the mean by 1/(b − 1) of that
        (b - 1.0) * Estimate::mean(&slopes).standard_error
    } else {
        scatter(&x, &y, value)
    };
    Some((
        Estimate {
            value,
            standard_error,
        },
        levels.len(),
    ))
}

/// The root of the mean square without some paths.
fn root_mean(squares: &[f64], left_out: &core::ops::Range<usize>) -> f64 {
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

/// Σ (x − x̄)².
fn width(x: &[f64]) -> f64 {
    let middle = mean(x);
    x.iter().map(|x| (x - middle).powi(2)).sum()
}

fn slope(x: &[f64], y: &[f64]) -> f64 {
    let (mx, my) = (mean(x), mean(y));
    let covariance: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    covariance / width(x)
}

/// The standard error of a slope from the distances to the line; two points have none.
fn scatter(x: &[f64], y: &[f64], slope: f64) -> f64 {
    let (mx, my) = (mean(x), mean(y));
    let distances = x
        .iter()
        .zip(y)
        .map(|(x, y)| (y - my - slope * (x - mx)).powi(2));
    if x.len() == 2 {
        return f64::NAN;
    }
    (distances.sum::<f64>() / (x.len() as f64 - 2.0) / width(x)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::{Level, fit};

    #[test]
    fn a_power_has_its_order() {
        let level = |k: i32| {
            let h = 0.5_f64.powi(k);
            Level {
                ln_h: h.ln(),
                squares: vec![h.powi(3)],
            }
        };
        // the first is saturated, the last is rounding
        let levels: Vec<Level> = [1, 4, 5, 6, 28].map(level).into();
        let (order, points) = fit(&levels, 1.0, false).unwrap();
        assert_eq!(points, 3);
        assert!((order.value - 1.5).abs() < 1e-14 && order.standard_error < 1e-14);
        assert!(fit(&levels[..2], 1.0, false).is_none());
    }

    /// Errors in proportion to h on each path: all slopes are 1. Errors that are shared between step sizes do not blur the slope, others do.
    #[test]
    fn the_scatter_between_paths_is_the_error() {
        let shared = |path: usize| 1e-3 * (1.0 + (path % 7) as f64);
        let level = |h: f64, tilt: f64| Level {
            ln_h: h.ln(),
            squares: (0..100)
                .map(|path| h * h * shared(path) * (1.0 + tilt * (path % 3) as f64))
                .collect(),
        };
        let (order, _) = fit(&[level(0.1, 0.0), level(0.2, 0.0)], 1.0, true).unwrap();
        assert!((order.value - 1.0).abs() < 1e-13 && order.standard_error < 1e-13);
        let (order, _) = fit(&[level(0.1, 0.0), level(0.2, 1.0)], 1.0, true).unwrap();
        // of squares u and w u: the variance of Σwu/Σu − w̄ is Σ(w − w̄)²u²/(Σu)², and the slope is its logarithm over 2 ln 2
        let (mut s, mut sw) = (0.0, 0.0);
        for path in 0..100 {
            s += shared(path);
            sw += shared(path) * (1.0 + (path % 3) as f64);
        }
        let w = sw / s;
        let variance: f64 = (0..100)
            .map(|path| ((1.0 + (path % 3) as f64 - w) * shared(path) / s).powi(2))
            .sum();
        let expected = variance.sqrt() / w / (2.0 * 2.0_f64.ln());
        assert!((order.value - 1.0 - w.ln() / (2.0 * 2.0_f64.ln())).abs() < 1e-13);
        // ten batches of such regular paths know it to a factor, not to a digit
        assert!(order.standard_error < 2.0 * expected && order.standard_error > 0.1 * expected);
    }
}
