//! The settings of an ensemble, each a function that returns it.
//!
//! Examples in the documentation begin with the hidden lines of `example.md`: a closure `ensemble`
//! that makes an ensemble of 100 paths with the observable `q`.

use core::ops::{Bound, RangeBounds};

use super::Ensemble;
use super::starts::Starts;
use crate::ensemble::PathMethod;
use crate::noise::ManyPaths;
use crate::system::StateOf;

impl<'a, I: PathMethod, K> Ensemble<'a, I, K> {
    /// Sets the number of paths.
    ///
    #[doc = include_str!("example.md")]
    /// assert_eq!(ensemble().paths(300).run()?.paths(), 300);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn paths(mut self, paths: u64) -> Self {
        self.paths = Some(paths);
        self
    }

    /// Sets the seed of random starts, and of the increments unless [`noise`](Self::noise) is
    /// given. If a noise is given, it has its own seed, and this function sets the seed of the
    /// random starts only: with one start for all paths it then has no effect. Without it, random
    /// starts have the seed of the noise, or 0.
    ///
    #[doc = include_str!("example.md")]
    /// let mean = |seed| ensemble().seed(seed).run().map(|summary| summary["q"].mean()[1]);
    /// assert_ne!(mean(1)?, mean(2)?);
    /// assert_eq!(mean(1)?, mean(1)?);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = Some(seed);
        self
    }

    /// Sets the length of a step, and the number of steps of a path.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().steps(0.25, 8).run()?;
    /// assert_eq!(summary.times(), [0.0, 2.0]);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn steps(mut self, h: f64, steps: u64) -> Self {
        self.steps = Some((h, steps));
        self
    }

    /// Records the observables at the start, after every `steps` steps and at the end, as
    /// [`Trajectory::every`](crate::Trajectory::every) saves states.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().steps(0.25, 8).every(4).run()?;
    /// assert_eq!(summary.times(), [0.0, 1.0, 2.0]);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn every(mut self, steps: u64) -> Self {
        self.every = Some(steps);
        self
    }

    /// Sets the start: a state for all paths, or [`Starts::each`] for a function that draws the
    /// state of each path.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().start(State::new([0.0], [2.0])).run()?;
    /// assert_eq!(summary["q"].mean()[0], 0.0);
    /// let drawn = Starts::each(|_path, rng| State::new([rng.normal()], [2.0]));
    /// assert_ne!(ensemble().start(drawn).run()?["q"].mean()[0], 0.0);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn start(mut self, starts: impl Into<Starts<'a, StateOf<I::System>>>) -> Self {
        self.start = Some(starts.into().0);
        self
    }

    /// Sets the noise. Path `k` has the increments of path `k` of the source. The default is
    /// [`Wiener::new(seed)`](crate::noise::Wiener) with the [`seed`](Self::seed) of the ensemble. A
    /// rule with [stage noise](crate::StageNoise) takes `Wiener`, not refined, `Truncated<Wiener>`
    /// and `NoNoise`; with other noise a run returns
    /// [`NoStages`](super::EnsembleError::NoStages).
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Rotor;
    ///
    /// #[variational(midpoint)]
    /// impl Rotor {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + q.cos() }
    ///     #[h1]
    ///     fn jitter(&self, _q: f64, p: f64) -> f64 { 0.1 * p * p }
    /// }
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let rotor = Integrator::new(Rotor, Midpoint);
    /// let summary = Ensemble::new(&rotor)
    ///     .paths(100)
    ///     .noise(Truncated::new(Wiener::new(7)).deviations(4.0)?)
    ///     .steps(0.1, 10)
    ///     .start(State::new([1.0], [0.0]))
    ///     .run()?;
    /// assert_eq!(summary.paths(), 100);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn noise(mut self, noise: impl ManyPaths) -> Self {
        self.noise = Some(noise.many_paths());
        self
    }

    /// Bounds an observable, as in `.bound("energy", ..=1e3)`. A path fails if the observable is
    /// outside of the range at a recorded time, or at the place where the path
    /// [stops](Self::stop_at): a motion without physical meaning then counts as a
    /// [`Failure`](super::Failure) and does not enter the statistics, nor does its passage. The
    /// ends belong to the range, and several ranges can be given.
    ///
    /// Without a bound, a path fails if its state or an observable is not finite.
    /// [`Summary::warnings`](super::Summary::warnings) reports observables that diverge.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().bound("q", -9.0..=0.5).run()?;
    /// assert_eq!(summary.failed(), 100); // all start at q = 1
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn bound(mut self, name: impl Into<String>, range: impl RangeBounds<f64>) -> Self {
        let number = |bound, none| match bound {
            Bound::Included(&x) | Bound::Excluded(&x) => x,
            Bound::Unbounded => none,
        };
        let low = number(range.start_bound(), f64::NEG_INFINITY);
        let high = number(range.end_bound(), f64::INFINITY);
        self.observed.bounds.push((name.into(), [low, high]));
        self
    }

    /// Keeps the state of each path at the end. The memory of a run then grows with its paths.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().keep_final_states(true).run()?;
    /// for (path, end) in summary.final_states() {
    ///     println!("{path} {} {}", end.q[0], end.p[0]);
    /// }
    /// assert_eq!(summary.final_states().count(), 100);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn keep_final_states(mut self, keep: bool) -> Self {
        self.keep_final_states = keep;
        self
    }

    /// Ends the run with an error when a path fails. The error belongs to the failing path with the
    /// lowest number.
    ///
    #[doc = include_str!("example.md")]
    /// let run = ensemble().bound("q", ..=0.5).stop_on_failure(true).run();
    /// assert!(matches!(run, Err(EnsembleError::Failed(failure)) if failure.path == 0));
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn stop_on_failure(mut self, stop: bool) -> Self {
        self.stop_on_failure = stop;
        self
    }

    /// Runs part `index` (from 0) of `of` parts, at most one for each
    /// [`BLOCK_PATHS`](super::BLOCK_PATHS) paths. The summaries of all parts
    /// [merge](super::Summary::merge) into the summary of the whole.
    ///
    #[doc = include_str!("example.md")]
    /// let mut summary = ensemble().shard(0, 2).run()?; // on one machine
    /// summary.merge(ensemble().shard(1, 2).run()?)?; // and on another
    /// assert!(summary.is_complete());
    /// assert_eq!(summary["q"].mean(), ensemble().run()?["q"].mean());
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn shard(mut self, index: u64, of: u64) -> Self {
        self.execution.shard = Some((index, of));
        self
    }

    /// Runs on the given number of threads, started for this run. The default is the surrounding
    /// `rayon` pool, usually with one thread for each core.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().threads(1).run()?;
    /// assert_eq!(summary["q"].mean(), ensemble().run()?["q"].mean());
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.execution.threads = Some(threads);
        self
    }

    /// Shows the progress of the run on standard error if it is a terminal, with the feature
    /// `progress` as a bar.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().progress(true).run()?;
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn progress(mut self, shown: bool) -> Self {
        self.execution.progress = shown;
        self
    }

    /// Ends the run early when a function returns `true`, for example after a signal or before the
    /// time limit of a batch system. No further block is begun, and the summary has the paths that
    /// were run.
    ///
    #[doc = include_str!("example.md")]
    /// use std::time::{Duration, Instant};
    /// let limit = Instant::now() + Duration::from_secs(3600);
    /// let summary = ensemble().stop_when(move || Instant::now() > limit).run()?;
    /// assert!(summary.is_complete());
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn stop_when(mut self, stop: impl Fn() -> bool + Sync + 'a) -> Self {
        self.execution.stop_when = Some(Box::new(stop));
        self
    }
}
