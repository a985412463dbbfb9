//! The method that reaches an error in the least time.
//!
//! Input: times and errors of methods. Output: the range of errors divided among the fastest
//! methods. Between two measured points a method follows the straight line through them, in
//! logarithms; beyond its points nothing is claimed. An error counts as reached if the next finer
//! step reaches it too.

use sve_runtime::plot::page::number;

/// A method's measured points, times in seconds.
pub(crate) struct Curve {
    pub(crate) name: String,
    /// Time and error.
    pub(crate) points: Vec<(f64, f64)>,
}

/// A range of errors and the method that reaches them in the least time.
#[derive(Clone, Debug)]
pub(crate) struct Winner {
    pub(crate) name: String,
    /// Times in seconds and errors, from the largest to the smallest.
    pub(crate) trace: Vec<(f64, f64)>,
}

impl Winner {
    /// Returns the first and the last point of the trace.
    pub(crate) fn ends(&self) -> [(f64, f64); 2] {
        // A winner has won at some error.
        [self.trace[0], self.trace[self.trace.len() - 1]]
    }
}

/// Number of errors in a decade for which the fastest method is found.
const IN_A_DECADE: i32 = 8;

/// Fraction of the previous winner's time below which a method replaces it; smaller differences are
/// scatter of the times.
const CLEARLY: f64 = 0.9;

/// Returns the points, each with the larger of its error and the next finer one: an error that is
/// small by chance, where its sign changes, does not count.
fn lasting(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let next = points.iter().skip(1).chain(points.last());
    points
        .iter()
        .zip(next)
        .map(|(&(time, error), &(_, finer))| (time, error.max(finer)))
        .collect()
}

/// Returns the least time in which a method reaches an error.
fn time_to(points: &[(f64, f64)], error: f64) -> Option<f64> {
    let points = &lasting(points)[..];
    let coarse = points
        .iter()
        .filter(|(_, e)| *e <= error)
        .map(|(time, _)| *time);
    let between = points.windows(2).filter_map(|pair| {
        let [(t0, e0), (t1, e1)] = pair else {
            return None;
        };
        let (high, low) = (e0.max(*e1), e0.min(*e1));
        (low < error && error <= high).then(|| {
            let part = (error / e0).ln() / (e1 / e0).ln();
            t0 * (t1 / t0).powf(part)
        })
    });
    coarse.chain(between).min_by(f64::total_cmp)
}

/// Returns the winners from the largest error to the smallest, up to `largest`.
pub(crate) fn winners(curves: &[Curve], largest: f64) -> Vec<Winner> {
    let errors = || curves.iter().flat_map(|curve| &curve.points).map(|p| p.1);
    let (Some(low), Some(high)) = (
        errors().min_by(f64::total_cmp),
        errors().max_by(f64::total_cmp),
    ) else {
        return Vec::new();
    };
    let ticks = f64::from(IN_A_DECADE);
    let grid = |x: f64| (ticks * x.log10()).floor() as i32;
    let mut winners: Vec<Winner> = Vec::new();
    for k in (grid(low) + 1..=grid(high.min(largest))).rev() {
        let error = 10_f64.powf(f64::from(k) / ticks);
        let time = |curve: &Curve| time_to(&curve.points, error);
        let fastest = curves
            .iter()
            .filter_map(|curve| Some((curve, time(curve)?)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((curve, best)) = fastest else {
            continue;
        };
        if let Some(last) = winners.last_mut() {
            let same = curves.iter().find(|curve| curve.name == last.name);
            if let Some(time) = same.and_then(time)
                && best > CLEARLY * time
            {
                last.trace.push((time, error));
                continue;
            }
        }
        winners.push(Winner {
            name: curve.name.clone(),
            trace: vec![(best, error)],
        });
    }
    winners
}

/// Returns a time with a unit.
pub(crate) fn duration(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 1e-6 => (1e9 * s, "ns"),
        s if s < 1e-3 => (1e6 * s, "µs"),
        s if s < 1.0 => (1e3 * s, "ms"),
        s => (s, "s"),
    };
    let decimals = usize::from(value < 9.95);
    format!("{value:.decimals$} {unit}")
}

/// Returns an error to one digit.
pub(crate) fn rounded(error: f64) -> String {
    number(error, 1)
}
