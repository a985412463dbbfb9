//! The multilevel method: a mean from many cheap paths with long steps, corrected by few paths with short steps.
//!
//! Input: an ensemble, an observable and an error. Output: the mean at the end, with its standard error, an estimate of its bias and a line for each level. Invariant: the numbers of paths are functions of
//! earlier results, which do not depend on threads, so the estimate has the same bits for any number of threads.
//!
//! Level l has steps of h/2ˡ. Its contribution is the mean of the difference between level l and level l − 1 along common paths: an increment of the coarse step is the sum of the two of the
//! fine steps. Different levels have different paths of the noise.
//!
//! Source: M. B. Giles, *Multilevel Monte Carlo path simulation*, Oper. Res. 56 (2008) 607–617, and *Multilevel Monte Carlo methods*, Acta Numerica 24 (2015) 259–328, section 3.

use core::fmt;

use super::coupled::Coupled;
use super::estimate::{Level, MultilevelEstimate, bias, paths_of_levels};
use super::fingerprint::Fingerprint;
use super::info::Info;
use super::merge_tree::{MergeTree, PartialResult};
use super::settings::{Leg, Settings};
use super::{BLOCK_PATHS, Ensemble, EnsembleError, Summary};
use crate::configuration::Coordinates;
use crate::method::Method;
use crate::system::{Dims, System};

/// Number of paths of the noise that are reserved for a level.
const PATHS_OF_LEVEL: u64 = 1 << 48;

/// Number of levels that are always run: a bias is estimated from two differences at least.
const FIRST_LEVELS: u32 = 3;

/// The name of the method in messages.
const MULTILEVEL: &str = "multilevel";

/// Number of standard errors by which a bias is too large for certain.
const SURE: f64 = 4.0;

/// Part of the paths of a level by which their wanted number has to exceed them, so that more are run.
const TOLERANCE: f64 = 0.01;

impl<I, S, Q, const N: usize, const M: usize> Ensemble<'_, I>
where
    I: Method<System = S> + Sync,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Computes the mean of an observable at the end by the multilevel method: the [`steps`](Self::steps) of the ensemble are those of the coarsest level, its [`paths`](Self::paths) the
    /// first ones of each level.
    ///
    /// For an error ε it needs about ε⁻² path-steps where the differences between levels have a variance that falls faster than h, as with rules of strong order 1. Plain Monte Carlo needs
    /// ε^(−2−1/w), where w is the weak order of the rule.
    ///
    /// **Where it does not win.** The gain over plain Monte Carlo with the same rule is about the number of plain steps that a bias of ε needs, divided by what the coarse levels cost.
    /// Where a few steps suffice, for large ε or with a rule of weak order 2, plain Monte Carlo is as fast or faster. It does not help for indicators and other observables with jumps, whose
    /// differences between levels have a large variance; nor where the coarse steps are unstable, or lose the features of the motion.
    ///
    /// Settings that count steps, such as [`settle`](Self::settle), count those of the coarsest level. Histograms, covariances and quantiles are not taken. A path that fails on either of its two
    /// levels does not count, so where paths fail the sum of the levels has a bias of the size of their part; [`Level::failed`] has their numbers.
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
pub struct Multilevel<'a, I: Method> {
    ensemble: &'a Ensemble<'a, I>,
    name: String,
    weak_order: f64,
    deepest: u32,
}

/// A level that has been run so far.
struct Run<'a, I: Method> {
    number: u32,
    /// The coarse and the fine run; on level 0 one run.
    legs: Coupled<'a, I>,
    info: Info,
    tree: Option<MergeTree>,
    blocks: u64,
    level: Level,
}

impl<'a, I, S, Q, const N: usize, const M: usize> Multilevel<'a, I>
where
    I: Method<System = S> + Sync,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Sets the order of the rule's errors of means, from which the bias is estimated. The default of 1 holds for all rules, and overestimates the bias of rules of higher order.
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

    /// Sets the number of the deepest level, with steps of `h / 2^level`: at least 2. The default is 12. [`weak_order`](Self::weak_order) has an example.
    #[must_use]
    pub fn deepest(mut self, level: u32) -> Self {
        self.deepest = level;
        self
    }

    /// Adds paths and levels until the root of the mean squared error is estimated to be at most `error`: half of its square is left to the variance of the mean, half to its bias.
    ///
    /// # Errors
    /// As [`Ensemble::run`]; [`EnsembleError::Bias`] if the deepest level is not deep enough; [`EnsembleError::NoLevel`] if the paths of a level fail; [`EnsembleError::NoSums`] with
    /// [`ThreePoint`](crate::noise::ThreePoint) increments; [`EnsembleError::MultilevelInParts`] with a shard, a checkpoint or `stop_when`;
    /// [`EnsembleError::NotTogether`] with refined noise, `refine`, stops, passages or kept final states.
    pub fn run(&self, error: f64) -> Result<MultilevelEstimate, EnsembleError> {
        let first_blocks = self.checked(error)?;
        let wanted = error / f64::sqrt(2.0);
        let mut runs: Vec<Run<'_, I>> = Vec::new();
        while runs.len() < FIRST_LEVELS as usize {
            runs.push(self.begin(runs.len() as u32, first_blocks)?);
        }
        loop {
            self.check_depth(&levels(&runs), wanted)?;
            let mut is_done = true;
            let paths = paths_of_levels(&levels(&runs), wanted);
            for (run, paths) in runs.iter_mut().zip(paths) {
                let Level {
                    paths: run_so_far,
                    failed,
                    ..
                } = run.level;
                let counted = (run_so_far - failed) as f64;
                if paths > (1.0 + TOLERANCE) * counted {
                    let most = (PATHS_OF_LEVEL / BLOCK_PATHS) as f64;
                    // as large a part of the further paths will fail
                    let more = paths / counted * run.blocks as f64;
                    #[allow(clippy::cast_sign_loss)] // a number of blocks
                    let blocks = more.ceil().min(most) as u64;
                    self.extend(run, blocks)?;
                    is_done = false;
                }
            }
            if !is_done {
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
            let level = runs.len() as u32;
            if level > self.deepest {
                return Err(EnsembleError::Bias {
                    name: self.name.clone(),
                    level: level - 1,
                    bias,
                    wanted,
                });
            }
            runs.push(self.begin(level, first_blocks)?);
        }
    }

    /// Returns an error if the deepest level is reached and its bias is too large, beyond the statistical error of the differences: more paths would not help.
    fn check_depth(&self, levels: &[Level], wanted: f64) -> Result<(), EnsembleError> {
        let level = levels.len() as u32 - 1;
        let at_least = |l: &Level| Level {
            mean: (l.mean.abs() - SURE * l.standard_error).max(0.0),
            ..*l
        };
        let least: Vec<_> = levels.iter().map(at_least).collect();
        let bias = bias(&least, self.weak_order);
        if level < self.deepest || bias <= wanted {
            return Ok(());
        }
        Err(EnsembleError::Bias {
            name: self.name.clone(),
            level,
            bias,
            wanted,
        })
    }

    /// Checks the settings. Returns the first number of blocks of each level.
    fn checked(&self, error: f64) -> Result<u64, EnsembleError> {
        let ensemble = self.ensemble;
        let settings = Settings::of_leg(
            ensemble,
            &Leg {
                of: Some(MULTILEVEL),
                ..Leg::of(ensemble)
            },
        )?;
        #[cfg(feature = "checkpoint")]
        let has_file = ensemble.checkpoint.is_some();
        #[cfg(not(feature = "checkpoint"))]
        let has_file = false;
        if ensemble.shard != (0, 1) || ensemble.stop_when.is_some() || has_file {
            return Err(EnsembleError::MultilevelInParts);
        }
        if self.deepest < FIRST_LEVELS - 1 {
            return Err(EnsembleError::TooFewLevels {
                deepest: self.deepest,
            });
        }
        let settings_without = [
            (settings.noise.depth > 0, "refined noise"),
            (ensemble.keep_final_states, "keep_final_states"),
        ];
        if let Some((_, setting)) = settings_without.into_iter().find(|(is_set, _)| *is_set) {
            return Err(EnsembleError::NotTogether {
                settings: [MULTILEVEL, setting],
                why: "each level has paths and steps of its own",
            });
        }
        for (what, value) in [("error", error), ("weak order", self.weak_order)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(EnsembleError::MultilevelTarget { what, value });
            }
        }
        if !ensemble.names.contains(&self.name) {
            return Err(EnsembleError::UnknownObservable {
                name: self.name.clone(),
                purpose: "take the mean of",
                known: ensemble.names.clone(),
            });
        }
        Ok(settings.paths.div_ceil(BLOCK_PATHS))
    }

    /// Runs the first blocks of a level.
    fn begin(&self, number: u32, blocks: u64) -> Result<Run<'a, I>, EnsembleError> {
        let leg = |halvings, is_coarsened| {
            let leg = Leg {
                halvings,
                is_coarsened,
                first_path: u64::from(number).wrapping_mul(PATHS_OF_LEVEL),
                paths: Some(PATHS_OF_LEVEL),
                of: Some(MULTILEVEL),
                ..Leg::of(self.ensemble)
            };
            Settings::of_leg(self.ensemble, &leg)
        };
        let fine = leg(number, false)?;
        let mut legs = Vec::new();
        if number > 0 {
            legs.push(leg(number - 1, true)?);
        }
        legs.push(fine);
        let steps = legs.iter().map(|leg| leg.steps).sum();
        let legs = Coupled { legs };
        // never merged with another run, so it needs no fingerprint
        let info = legs.info_of_differences(legs.legs.len() - 1, Fingerprint::default());
        let mut run = Run {
            number,
            legs,
            info,
            tree: None,
            blocks: 0,
            level: Level {
                h: fine.h,
                steps,
                paths: 0,
                failed: 0,
                mean: f64::NAN,
                variance: f64::NAN,
                standard_error: f64::NAN,
            },
        };
        self.extend(&mut run, blocks)?;
        Ok(run)
    }

    /// Runs the blocks of a level up to this number, and updates its numbers.
    fn extend(&self, run: &mut Run<'a, I>, blocks: u64) -> Result<(), EnsembleError> {
        let legs = &run.legs;
        let mut settings = legs.legs[0];
        settings.shard = [run.blocks, blocks];
        let trees = settings.execute_with(1, |block| {
            // the last result is the difference, or the only run
            let last = legs.run_block(block)?.pop();
            Ok(last.map(PartialResult::without_distributions))
                .map(|result| result.into_iter().collect())
        })?;
        for mut tree in trees {
            let old = run
                .tree
                .take()
                .into_iter()
                .flat_map(|old| old.nodes.into_values());
            old.for_each(|node| tree.insert(node));
            run.tree = Some(tree);
        }
        run.blocks = blocks;
        let Some(tree) = &run.tree else {
            return Err(EnsembleError::NothingRun);
        };
        let summary = Summary::new(run.info.clone(), tree.clone());
        let Some(statistics) = summary.get(&self.name) else {
            return Err(EnsembleError::NothingRun);
        };
        let last = summary.times().len() - 1;
        let paths = blocks * BLOCK_PATHS;
        let (counted, mean) = (summary.counts()[last], statistics.mean()[last]);
        let standard_error = statistics.standard_error()[last];
        run.level = Level {
            paths,
            failed: paths - counted,
            mean,
            // for each path also where paths are pairs
            variance: standard_error.powi(2) * counted as f64,
            standard_error,
            ..run.level
        };
        if !(mean.is_finite() && run.level.variance.is_finite()) {
            return Err(EnsembleError::NoLevel {
                name: self.name.clone(),
                level: run.number,
                h: run.level.h,
                failed: run.level.failed,
                paths,
            });
        }
        Ok(())
    }
}

fn levels<I: Method>(runs: &[Run<'_, I>]) -> Vec<Level> {
    runs.iter().map(|run| run.level).collect()
}

impl<I: Method> fmt::Debug for Multilevel<'_, I> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Multilevel")
            .field("observable", &self.name)
            .field("weak_order", &self.weak_order)
            .field("deepest", &self.deepest)
            .finish_non_exhaustive()
    }
}
