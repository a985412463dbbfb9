//! The multilevel method: a mean from many cheap paths with long steps, corrected by few paths with
//! short steps.
//!
//! Input: an ensemble, an observable and an error. Output: the mean at the end, with its standard
//! error, an estimate of its bias and a line for each level. Invariant: the numbers of paths are
//! functions of earlier results, which do not depend on threads, so the estimate has the same bits
//! for any number of threads.
//!
//! Level l has steps of h/2ˡ. Its contribution is the mean of the difference between level l and
//! level l − 1 along common paths: an increment of the coarse step is the sum of the two of the
//! fine steps. Different levels have different paths of the noise.
//!
//! Files: [`runs`] has the paths of a level, [`checks`] the settings and the levels that give no
//! mean.
//!
//! Source: M. B. Giles, *Multilevel Monte Carlo path simulation*, Oper. Res. 56 (2008) 607–617, and
//! *Multilevel Monte Carlo methods*, Acta Numerica 24 (2015) 259–328, section 3.

mod checks;
mod runs;

use core::fmt;

use self::checks::{check_fall, check_values, least_size};
use self::runs::{PATHS_OF_LEVEL, Run, largest_range, levels};
use super::estimate::{Level, MultilevelEstimate, bias, paths_of_levels};
use super::{BLOCK_PATHS, Ensemble, EnsembleError};
use crate::ensemble::PathMethod;

/// Number of levels that are always run: a bias is estimated from two differences at least.
const FIRST_LEVELS: u32 = 3;

/// The name of the method in messages.
const MULTILEVEL: &str = "multilevel";

/// Number of standard errors by which a bias is too large for certain.
const SURE: f64 = 4.0;

/// Part of the paths of a level by which their wanted number has to exceed them, so that more are
/// run.
const TOLERANCE: f64 = 0.01;

/// Largest factor by which the paths of a level become more at once: the variance that asks for
/// them is known better with each time.
const GROWTH: f64 = 16.0;

/// Largest number of times that the paths of a level are doubled in search of more that carry its
/// variance. A rare event that was seen once is seen a thousand times then.
const DOUBLINGS: u32 = 10;

impl<I: PathMethod + Sync> Ensemble<'_, I> {
    /// Computes the mean of an observable at the end by the multilevel method. The
    /// [`steps`](Self::steps) of the ensemble are the steps of the coarsest level, and its
    /// [`paths`](Self::paths) are the number of first paths of each level.
    ///
    /// For an error ε it needs about ε⁻² path-steps if the variance of the differences between
    /// levels falls faster than h, as with rules of strong order 1. Plain Monte Carlo needs
    /// ε^(−2−1/w), where w is the weak order of the rule.
    ///
    /// **Limits of the gain.** The gain over plain Monte Carlo with the same rule is about the
    /// number of plain steps that a bias of ε needs, divided by the cost of the coarse levels. If a
    /// few steps suffice, for large ε or with a rule of weak order 2, plain Monte Carlo is as fast
    /// or faster. The method does not help for indicators and other observables with jumps, whose
    /// differences between levels have a large variance; nor if the coarse steps are unstable, or
    /// lose the features of the motion.
    ///
    /// **Rare events.** A level on which fewer than 8 paths carry the variance gets twice the
    /// paths, until 8 paths carry it, or until 8 more paths would change the mean by less than its
    /// error. If an event occurs on no path of any level, the result is an error,
    /// [`EnsembleError::OneValue`]. An event that changes few of otherwise different values, and
    /// that does not occur among the first [`paths`](Self::paths), cannot be detected: let their
    /// number be many times the number of paths in which the event occurs once.
    ///
    /// Settings that count steps, such as [`settle`](Self::settle), count steps of the coarsest
    /// level. Histograms, covariances and quantiles are not taken. A path that fails on either of
    /// its two levels does not count, so where paths fail the sum of the levels has a bias of the
    /// size of their part; [`Level::failed`] has their numbers.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A pendulum in a gusty wind.
    /// struct Pendulum { g: f64, sigma: f64 }
    ///
    /// #[variational(endpoint)]
    /// impl Pendulum {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.g * q.cos() }
    ///     #[gamma]
    ///     fn gusts(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let pendulum = Integrator::new(Pendulum { g: 1.0, sigma: 0.5 }, Endpoint);
    /// let estimate = Ensemble::new(&pendulum)
    ///     .paths(1024).seed(1)
    ///     .steps(0.25, 4)
    ///     .start(State::new([1.0], [0.0]))
    ///     .observe("energy", |system, state| system.hamiltonian(state))
    ///     .multilevel("energy")
    ///     .run(0.01)?;
    /// // the exact mean is −g cos 1 + σ²t/2
    /// let exact = -1.0_f64.cos() + 0.125;
    /// assert!((estimate.mean() - exact).abs() < 4.0 * estimate.error());
    /// println!("{estimate}");
    /// # Ok(())
    /// # }
    /// ```
    pub fn multilevel(&self, name: impl Into<String>) -> Multilevel<'_, I> {
        Multilevel {
            ensemble: self,
            name: name.into(),
            weak_order: 1.0,
            deepest: 12,
        }
    }
}

/// A multilevel estimate that is to be made, from [`Ensemble::multilevel`].
pub struct Multilevel<'a, I: PathMethod> {
    ensemble: &'a Ensemble<'a, I>,
    name: String,
    weak_order: f64,
    deepest: u32,
}

impl<'a, I: PathMethod + Sync> Multilevel<'a, I> {
    /// Sets the order of the rule's errors of means, from which the bias is estimated. The default
    /// of 1 holds for all rules, and overestimates the bias of rules of higher order.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Oscillator { sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let oscillator = Integrator::new(Oscillator { sigma: 1.0 }, Midpoint);
    /// let estimate = Ensemble::new(&oscillator)
    ///     .paths(1024).seed(1).steps(0.25, 4)
    ///     .start(State::new([1.0], [0.0]))
    ///     .observe("q²", |_, state| state.q[0].powi(2))
    ///     .multilevel("q²")
    ///     .weak_order(2.0) // midpoint, additive noise
    ///     .deepest(5)
    ///     .run(0.03)?;
    /// // cos² 1 + ∫ sin² over the time 1
    /// let exact = 1.0_f64.cos().powi(2) + 0.5 - 0.25 * 2.0_f64.sin();
    /// assert!((estimate.mean() - exact).abs() < 4.0 * estimate.error());
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn weak_order(mut self, order: f64) -> Self {
        self.weak_order = order;
        self
    }

    /// Sets the number of the deepest level, with steps of `h / 2^level`: at least 2. The default
    /// is 12. [`weak_order`](Self::weak_order) has an example.
    #[must_use]
    pub fn deepest(mut self, level: u32) -> Self {
        self.deepest = level;
        self
    }

    /// Adds paths and levels until the root of the mean squared error is estimated to be at most
    /// `error`: half of its square is left to the variance of the mean, half to its bias.
    ///
    /// # Errors
    /// As [`Ensemble::run`]; [`EnsembleError::Bias`] if the deepest level is not deep enough;
    /// [`EnsembleError::NoLimit`] if the differences between levels do not fall;
    /// [`EnsembleError::OneValue`] if all paths have the same value; [`EnsembleError::HeavyTails`]
    /// if a few paths have the whole variance of a level, for every number of paths;
    /// [`EnsembleError::NoLevel`] if the paths of a level fail; [`EnsembleError::NoSums`] with
    /// [`ThreePoint`](crate::noise::ThreePoint) increments; [`EnsembleError::MultilevelInParts`]
    /// with a shard, a checkpoint or `stop_when`; [`EnsembleError::NotTogether`] with refined
    /// noise, `refine`, stops, passages or kept final states.
    pub fn run(&self, error: f64) -> Result<MultilevelEstimate, EnsembleError> {
        let first_blocks = self.checked(error)?;
        let wanted = error / f64::sqrt(2.0);
        let mut runs: Vec<Run<'a, I>> = Vec::new();
        while runs.len() < FIRST_LEVELS as usize {
            runs.push(self.begin(runs.len() as u32, first_blocks)?);
        }
        check_values(self, &runs)?;
        loop {
            let sure = self.sure_bias(&levels(&runs));
            if sure > wanted {
                // more paths would not help
                check_fall(&self.name, &levels(&runs))?;
                let level = self.next_level(&runs, sure, wanted)?;
                runs.push(self.begin(level, first_blocks)?);
                continue;
            }
            if self.extend_all(&mut runs, wanted)? {
                continue;
            }
            let levels = levels(&runs);
            let bias = bias(&levels, self.weak_order);
            if bias <= wanted {
                return Ok(MultilevelEstimate {
                    name: self.name.clone(),
                    levels,
                    bias,
                });
            }
            let level = self.next_level(&runs, bias, wanted)?;
            runs.push(self.begin(level, first_blocks)?);
        }
    }

    /// Adds paths to the levels that need more for a standard error of the mean, or before their
    /// variances are trusted. Returns whether any paths were added.
    fn extend_all(&self, runs: &mut [Run<'a, I>], error: f64) -> Result<bool, EnsembleError> {
        let largest = largest_range(runs);
        let wanted = paths_of_levels(&levels(runs), error);
        let mut are_more = false;
        for (run, mut paths) in runs.iter_mut().zip(wanted) {
            let counted = (run.level.paths - run.level.failed) as f64;
            let least = run.spread.least_paths(largest, error);
            if least > counted {
                // The variance of the level is not known, so it does not determine the number of
                // paths.
                paths = least.min(2.0 * counted);
                run.doublings += u32::from(run.spread.range > 0.0);
                if run.doublings > DOUBLINGS {
                    return Err(EnsembleError::HeavyTails {
                        name: self.name.clone(),
                        level: run.number,
                        carriers: run.spread.carriers,
                        paths: run.level.paths,
                    });
                }
            }
            if paths > (1.0 + TOLERANCE) * counted {
                let most = (PATHS_OF_LEVEL / BLOCK_PATHS) as f64;
                // as large a part of the further paths will fail
                let more = (paths / counted).min(GROWTH) * run.blocks as f64;
                #[allow(clippy::cast_sign_loss)] // a number of blocks
                let blocks = more.ceil().min(most) as u64;
                self.extend(run, blocks)?;
                are_more = true;
            }
        }
        Ok(are_more)
    }

    /// Returns the number of the next level, or an error if there is no next level.
    fn next_level(
        &self,
        runs: &[Run<'_, I>],
        bias: f64,
        wanted: f64,
    ) -> Result<u32, EnsembleError> {
        let level = runs.len() as u32;
        if level <= self.deepest {
            return Ok(level);
        }
        Err(EnsembleError::Bias {
            name: self.name.clone(),
            level: level - 1,
            bias,
            wanted,
        })
    }

    /// Returns the size that the bias has for certain, beyond the statistical error of the
    /// differences.
    fn sure_bias(&self, levels: &[Level]) -> f64 {
        let at_least = |l: &Level| Level {
            mean: least_size(l),
            ..*l
        };
        let least: Vec<_> = levels.iter().map(at_least).collect();
        bias(&least, self.weak_order)
    }
}

impl<I: PathMethod> fmt::Debug for Multilevel<'_, I> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Multilevel")
            .field("observable", &self.name)
            .field("weak_order", &self.weak_order)
            .field("deepest", &self.deepest)
            .finish_non_exhaustive()
    }
}
