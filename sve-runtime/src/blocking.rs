//! Averages over one long path, with their statistical error.
//!
//! Input: values in the order of time, which may depend on one another. Output: their mean, its
//! standard error, and the number of values that count as one independent value. Invariant: the
//! memory grows with the logarithm of the number of values only; every value is used once.
//!
//! Values are averaged in pairs, pairs of pairs, and so on. Each level gives the standard error
//! that would hold if its averages were independent. This standard error grows from level to level
//! until the blocks are longer than the memory of the path, and then stays constant.
//!
//! Source: H. Flyvbjerg, H. G. Petersen, *Error estimates on averages of correlated data*, J. Chem.
//! Phys. 91 (1989) 461–466. The choice of the level: R. M. Lee, G. J. Conduit, N. Nemec, P. López
//! Ríos, N. D. Drummond, *Strategies for improving the efficiency of quantum Monte Carlo
//! calculations*, Phys. Rev. E 83, 066706 (2011), section IV, after U. Wolff, Comput. Phys. Commun.
//! 156 (2004) 143–153.

/// The mean of the values along one long path, and its standard error from blocks of growing length
/// (Flyvbjerg and Petersen).
///
/// Values along a path are not independent: the standard error computed from their variance is too
/// small. Blocks that are longer than the memory of the path are nearly independent, and give the
/// right error.
///
/// ```
/// use sve_runtime::Blocking;
/// use sve_runtime::prelude::*;
///
/// /// An oscillator in a bath of temperature kT = σ²/2ν.
/// struct Langevin { nu: f64, sigma: f64 }
///
/// #[variational(midpoint)]
/// impl Langevin {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
///     #[force]
///     fn friction(&self, _q: f64, v: f64) -> f64 { -self.nu * v }
///     #[gamma]
///     fn kicks(&self, q: f64) -> f64 { self.sigma * q }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let langevin = Integrator::new(Langevin { nu: 1.0, sigma: 2.0 }, Midpoint);
/// let h = 0.2;
/// let mut temperature = Blocking::new();
/// let path = langevin.trajectory(State::new([0.0], [0.0]), h, Wiener::new(1));
/// for state in path.skip(100).take(100_000) {
///     temperature.push(langevin.system().temperature(&state?)?);
/// }
/// let error = temperature.standard_error().expect("a path that is long enough");
/// assert!(error < 0.06 && (temperature.mean() - 2.0).abs() < 4.0 * error);
/// let forgotten = h * temperature.correlation_time().expect("likewise");
/// assert!((0.3..2.0).contains(&forgotten));
/// # Ok(())
/// # }
/// ```
///
/// For many paths see `Ensemble::average`, with the feature `ensemble`: the averages of different
/// paths are independent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blocking {
    /// Moments of the averages over 2ᵏ values, for each level k.
    levels: Vec<Level>,
}

/// Moments of the averages of blocks of one length.
#[derive(Clone, Debug, Default, PartialEq)]
struct Level {
    count: u64,
    mean: f64,
    /// Sum of squared deviations from the mean.
    squares: f64,
    /// The first average of a pair.
    waiting: Option<f64>,
}

/// The standard error that blocks of one length give, from [`Blocking::estimates`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockEstimate {
    /// Number of values in a block.
    pub length: u64,
    /// Number of blocks.
    pub blocks: u64,
    /// Standard error of the mean if the averages of blocks are independent.
    pub standard_error: f64,
    /// Standard deviation of this standard error.
    pub uncertainty: f64,
}

impl Level {
    /// Adds an average (Welford). Returns the average of a pair that is complete.
    fn add(&mut self, value: f64) -> Option<f64> {
        self.count += 1;
        let deviation = value - self.mean;
        self.mean += deviation / self.count as f64;
        self.squares += deviation * (value - self.mean);
        match self.waiting.take() {
            Some(first) => Some(0.5 * first + 0.5 * value),
            None => {
                self.waiting = Some(value);
                None
            }
        }
    }

    /// Returns the variance of the mean if the averages are independent.
    fn variance_of_mean(&self) -> f64 {
        self.squares / (self.count as f64 * (self.count - 1) as f64)
    }
}

impl Blocking {
    /// Returns an average without values.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the next value along the path. After a value that is not finite, mean and errors are
    /// not finite.
    pub fn push(&mut self, value: f64) {
        let mut carried = Some(value);
        let mut levels = self.levels.iter_mut();
        while let Some(value) = carried {
            match levels.next() {
                Some(level) => carried = level.add(value),
                None => {
                    let mut level = Level::default();
                    level.add(value);
                    self.levels.push(level);
                    return;
                }
            }
        }
    }

    /// Returns the number of values.
    pub fn count(&self) -> u64 {
        self.levels.first().map_or(0, |level| level.count)
    }

    /// Returns the mean of all values; NaN without values.
    pub fn mean(&self) -> f64 {
        self.levels.first().map_or(f64::NAN, |level| level.mean)
    }

    /// Returns the variance of the values: the sum of squared deviations over the number of values
    /// less one; NaN for fewer than two.
    pub fn variance(&self) -> f64 {
        match self.levels.first() {
            Some(level) if level.count > 1 => level.squares / (level.count - 1) as f64,
            _ => f64::NAN,
        }
    }

    /// Returns the standard error of the mean; `None` if there are too few values, compared with
    /// the memory of the path.
    ///
    /// It is the standard error from the shortest blocks, of length B, with B³ > 2n g², where n is
    /// the number of values and g the [`inefficiency`](Self::inefficiency) of these blocks. At this
    /// length the systematic error, of blocks that are too short, and the statistical error, of too
    /// few blocks, are about equal.
    pub fn standard_error(&self) -> Option<f64> {
        self.plateau().map(|level| level.variance_of_mean().sqrt())
    }

    /// Returns the number of values that count as one independent value: the squared ratio of the
    /// standard error to the standard error of independent values. `None` as for the
    /// [`standard_error`](Self::standard_error).
    pub fn inefficiency(&self) -> Option<f64> {
        let first = self.levels.first()?.variance_of_mean();
        let level = self.plateau()?;
        Some(if first == 0.0 {
            1.0
        } else {
            level.variance_of_mean() / first
        })
    }

    /// Returns the integrated correlation time ½ + Σ ρ(k), where ρ is the autocorrelation: half of
    /// the [`inefficiency`](Self::inefficiency). Its unit is the time between two values.
    pub fn correlation_time(&self) -> Option<f64> {
        self.inefficiency().map(|g| 0.5 * g)
    }

    /// Returns the standard errors from blocks of 1, 2, 4, … values, as long as there are two
    /// blocks. A plot of them shows the plateau.
    pub fn estimates(&self) -> impl Iterator<Item = BlockEstimate> + '_ {
        let levels = self.levels.iter().enumerate();
        levels
            .filter(|(_, level)| level.count > 1)
            .map(|(k, level)| {
                let standard_error = level.variance_of_mean().sqrt();
                BlockEstimate {
                    length: 1 << k,
                    blocks: level.count,
                    standard_error,
                    uncertainty: standard_error / (2.0 * (level.count - 1) as f64).sqrt(),
                }
            })
    }

    /// Returns the first level whose blocks are long enough.
    fn plateau(&self) -> Option<&Level> {
        let values = self.count() as f64;
        let first = self.levels.first().filter(|level| level.count > 1)?;
        if first.squares == 0.0 {
            return Some(first);
        }
        let usable = self.levels.iter().enumerate();
        let mut usable = usable.filter(|(_, level)| level.count > 1);
        let long_enough = |k: usize, level: &Level| {
            let inefficiency = level.variance_of_mean() / first.variance_of_mean();
            (3.0 * k as f64).exp2() > 2.0 * values * inefficiency * inefficiency
        };
        usable
            .find(|(k, level)| long_enough(*k, level))
            .map(|(_, level)| level)
    }
}

impl Extend<f64> for Blocking {
    fn extend<T: IntoIterator<Item = f64>>(&mut self, values: T) {
        values.into_iter().for_each(|value| self.push(value));
    }
}

#[cfg(test)]
mod tests {
    use super::Blocking;
    use crate::noise::Wiener;

    /// Returns the values x ← ρx + √(1 − ρ²) ξ, with variance 1.
    fn autoregressive(rho: f64, seed: u64, count: u64) -> Blocking {
        let noise = Wiener::new(seed);
        let mut blocking = Blocking::new();
        let mut x = noise.increment(0, 1, 1.0);
        for step in 0..count {
            x = rho * x + (1.0 - rho * rho).sqrt() * noise.increment(step, 0, 1.0);
            blocking.push(x);
        }
        blocking
    }

    /// The variance of the mean of n values is g/n with g = (1 + ρ)/(1 − ρ) for long paths.
    #[test]
    fn the_error_of_correlated_values_is_that_of_their_mean() {
        for rho in [0.0, 0.5, 0.9, -0.5] {
            let (paths, values) = (300, 4096);
            let exact = (1.0 + rho) / (1.0 - rho);
            let (mut errors, mut squares) = (0.0, 0.0);
            for seed in 0..paths {
                let blocking = autoregressive(rho, seed, values);
                errors += blocking.standard_error().unwrap().powi(2);
                squares += (blocking.mean() / blocking.standard_error().unwrap()).powi(2);
            }
            let found = errors / paths as f64 * values as f64;
            // blocks of a finite length have a systematic error of the size of values^(−1/3)
            assert!((found / exact - 1.0).abs() < 0.12, "{rho}: {found} {exact}");
            // The squares of the mean in standard errors have the mean 1, with a standard deviation
            // of √(2/300).
            let spread = squares / paths as f64;
            assert!((spread - 1.0).abs() < 0.35, "{rho}: {spread}");
        }
    }

    #[test]
    fn a_path_that_is_too_short_has_no_error() {
        assert_eq!(Blocking::new().standard_error(), None);
        assert!(Blocking::new().mean().is_nan());
        // every block of a ramp differs from the next by as much as its length, so that no plateau
        // exists
        let mut ramp = Blocking::new();
        ramp.extend((0..256).map(f64::from));
        assert_eq!(ramp.standard_error(), None);
        assert!(autoregressive(0.5, 1, 256).standard_error().is_some());
        let mut constant = Blocking::new();
        constant.extend([3.0; 10]);
        assert_eq!(
            (constant.mean(), constant.standard_error()),
            (3.0, Some(0.0))
        );
        assert_eq!(constant.inefficiency(), Some(1.0));
    }

    #[test]
    fn levels_have_the_averages_of_blocks() {
        let mut blocking = Blocking::new();
        blocking.extend([1.0, 3.0, 5.0, 11.0, 2.0]);
        assert_eq!((blocking.count(), blocking.mean()), (5, 4.4));
        let estimates: Vec<_> = blocking.estimates().collect();
        let sizes: Vec<_> = estimates.iter().map(|e| (e.length, e.blocks)).collect();
        assert_eq!(sizes, [(1, 5), (2, 2)]);
        // averages 2 and 8: variance 18, over 2 blocks 9
        assert!((estimates[1].standard_error - 3.0).abs() < 1e-15);
        assert!((blocking.variance() - 15.8).abs() < 1e-14);
        // memory of a path of a million values
        let long = autoregressive(0.5, 2, 1 << 20);
        assert_eq!(long.levels.len(), 21);
    }
}
