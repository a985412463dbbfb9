//! The result of the multilevel method.
//!
//! Input: the numbers of all levels. Output: the mean with its errors, and the contribution of each
//! level.

use core::fmt;

/// A level of a multilevel estimate. The mean and the variance belong to the difference to the
/// level before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Step size.
    pub h: f64,
    /// Steps of a path, including the steps of the coarse path.
    pub steps: u64,
    /// Number of paths.
    pub paths: u64,
    /// Number of paths that failed in one of the two runs.
    pub failed: u64,
    /// Mean of the observable on level 0, of its difference to the level before on others.
    pub mean: f64,
    /// Variance for each path.
    pub variance: f64,
    /// Standard error of the mean.
    pub standard_error: f64,
}

/// A mean by the multilevel method, from [`Multilevel::run`](super::Multilevel::run).
#[derive(Clone, Debug, PartialEq)]
pub struct MultilevelEstimate {
    pub(super) name: String,
    pub(super) levels: Vec<Level>,
    pub(super) bias: f64,
}

impl MultilevelEstimate {
    /// The mean of the observable at the end: the sum of the means of all levels.
    pub fn mean(&self) -> f64 {
        self.levels.iter().map(|level| level.mean).sum()
    }

    /// The standard error of the mean.
    pub fn standard_error(&self) -> f64 {
        let squares = self.levels.iter().map(|level| level.standard_error.powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// The estimated size of the bias, which steps of the last level leave.
    pub fn bias(&self) -> f64 {
        self.bias
    }

    /// The estimated root of the mean squared error: standard error and bias.
    pub fn error(&self) -> f64 {
        self.standard_error().hypot(self.bias)
    }

    /// The levels, from the longest steps to the shortest.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// The number of steps of all paths.
    pub fn steps(&self) -> u64 {
        let steps = self.levels.iter().map(|level| level.steps * level.paths);
        steps.sum()
    }
}

impl fmt::Display for MultilevelEstimate {
    /// The estimate, and a line for each level.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (mean, error, bias) = (self.mean(), self.standard_error(), self.bias);
        write!(
            f,
            "{}: {mean:.6e} ± {error:.1e}, bias about {bias:.1e}",
            self.name
        )?;
        for (number, level) in self.levels.iter().enumerate() {
            write!(
                f,
                "\n  level {number}: h = {:e}, {} paths, mean {:.3e} ± {:.1e}, variance {:.2e}",
                level.h, level.paths, level.mean, level.standard_error, level.variance
            )?;
            if level.failed > 0 {
                write!(f, ", {} paths failed", level.failed)?;
            }
        }
        Ok(())
    }
}

/// Returns the numbers of paths that give the mean this standard error for the smallest number of
/// steps: proportional to √(variance / steps).
pub(super) fn paths_of_levels(levels: &[Level], standard_error: f64) -> Vec<f64> {
    let all = levels.iter();
    let sum: f64 = all.map(|l| (l.variance * l.steps as f64).sqrt()).sum();
    let each = |l: &Level| (l.variance / l.steps as f64).sqrt() * sum / standard_error.powi(2);
    levels.iter().map(each).collect()
}

/// Returns the bias of the last level if errors fall like hʷ. Each of the last three differences
/// gives an estimate, and the largest estimate is returned, since a single difference may be small
/// by chance.
pub(super) fn bias(levels: &[Level], weak_order: f64) -> f64 {
    let factor = weak_order.exp2();
    let differences = levels[1..].iter().rev().take(3).zip(0..);
    let estimates = differences.map(|(l, before): (_, i32)| l.mean.abs() / factor.powi(before));
    estimates.fold(0.0, f64::max) / (factor - 1.0)
}
