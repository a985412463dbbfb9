//! Monte Carlo over many paths: statistics of observables, on all cores, in lanes of vector registers.
//!
//! Input: a method, a start, a step size, numbers of steps and paths, observables. Output: a [`Summary`].
//! Invariant: all results are functions of the settings, with the same bits for any number of threads, and for the merge of
//! shards as for the whole run.
//!
//! A run cuts its paths into blocks of [`BLOCK_PATHS`], each of a few tiles of `LANES` lanes. The blocks are the unit of
//! work, and their results are merged pairwise in a fixed tree.

#[cfg(feature = "checkpoint")]
mod checkpoint;
mod csv;
mod error;
mod failure;
mod fingerprint;
mod flight;
mod histogram;
mod increments;
mod moments;
#[cfg(feature = "npy")]
mod npy;
mod observe;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(feature = "serde")]
mod parts;
mod progress;
mod record;
mod replay;
mod run;
mod start;
mod statistics;
mod summary;
mod tree;
mod work;

pub use error::EnsembleError;
pub use failure::{Cause, FAILURES_KEPT, Failure};
pub use observe::Observed;
pub use start::StartRng;
pub use statistics::{Histogram, Statistics};
pub use summary::Summary;

use core::fmt;
use core::ops::Range;

use self::histogram::Request;
use self::increments::Law;
use self::observe::{Closure, Observable};
use self::run::Run;
use self::start::Start;
use crate::lanes::LANES;
use crate::method::Method;
use crate::noise::lanes::Increments as Source;
use crate::state::State;
use crate::system::{Dims, StateOf, System};

/// Paths of a block, which one thread runs and whose statistics are merged with those of other blocks in a fixed order.
/// Part of the contract: another number would change the last bits of statistics. Few enough that a thousand paths keep several threads busy.
pub const BLOCK_PATHS: u64 = 64;

/// Tiles of lanes in a block.
const BLOCK_TILES: usize = BLOCK_PATHS as usize / LANES;

const _: () = assert!(BLOCK_TILES * LANES == BLOCK_PATHS as usize);

/// Many paths of one method, and what is to be known of them.
///
/// Path `k`, from 0, has the increments of [`Wiener::new(seed).path(k)`](crate::noise::Wiener). Paths, steps and a start have to be given; the seed is 0
/// unless it is given, and without [`record_every`](Self::record_every) the start and the end are recorded.
///
/// ```
/// use sve_runtime::prelude::*;
///
/// struct Oscillator { sigma: f64 }
///
/// #[variational(endpoint)]
/// impl Oscillator {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
///     #[gamma]
///     fn push(&self, q: f64) -> f64 { self.sigma * q }
/// }
///
/// # fn main() -> Result<(), EnsembleError> {
/// let integrator = Integrator::new(Oscillator { sigma: 1.0 }, Endpoint);
/// let summary = Ensemble::new(&integrator)
///     .paths(1000).seed(7)
///     .steps(0.1, 200).record_every(50)
///     .start(State::new([1.0], [0.0]))
///     .observe("energy", |system, state| system.hamiltonian(state))
///     .run()?;
/// let energy = &summary["energy"];
/// for (t, (mean, error)) in summary.times().iter().zip(energy.mean().iter().zip(energy.standard_error())) {
///     // the exact mean is 1/2 + σ²t/2
///     assert!((mean - 0.5 - 0.5 * t).abs() < 0.1 + 4.0 * error);
/// }
/// # Ok(())
/// # }
/// ```
#[allow(clippy::struct_excessive_bools)] // switches, each with a function of its name
pub struct Ensemble<'a, I: Method> {
    method: &'a I,
    paths: Option<u64>,
    seed: u64,
    steps: Option<(f64, u64)>,
    every: Option<u64>,
    start: Option<Start<'a, StateOf<I::System>>>,
    law: Law,
    names: Vec<String>,
    observables: Vec<Box<dyn Observable<I::System> + 'a>>,
    histograms: Vec<Request>,
    keep_final_states: bool,
    stop_on_failure: bool,
    shard: (u64, u64),
    threads: Option<usize>,
    progress: bool,
    stop_when: Option<Box<dyn Fn() -> bool + Sync + 'a>>,
    #[cfg(feature = "checkpoint")]
    checkpoint: Option<(std::path::PathBuf, core::time::Duration)>,
    #[cfg(feature = "checkpoint")]
    resume: bool,
}

impl<'a, I, S, const N: usize, const M: usize> Ensemble<'a, I>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M>>,
{
    /// Paths of a method: an [`Integrator`](crate::Integrator) or a [`baseline`](crate::baseline).
    pub fn new(method: &'a I) -> Self {
        Self {
            method,
            paths: None,
            seed: 0,
            steps: None,
            every: None,
            start: None,
            law: Law::Drawn(Source::Normal),
            names: Vec::new(),
            observables: Vec::new(),
            histograms: Vec::new(),
            keep_final_states: false,
            stop_on_failure: false,
            shard: (0, 1),
            threads: None,
            progress: false,
            stop_when: None,
            #[cfg(feature = "checkpoint")]
            checkpoint: None,
            #[cfg(feature = "checkpoint")]
            resume: false,
        }
    }

    /// How many paths.
    #[must_use]
    pub fn paths(mut self, paths: u64) -> Self {
        self.paths = Some(paths);
        self
    }

    /// The seed of their increments, and of starts drawn at random.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// How long a step is, and how many a path makes.
    #[must_use]
    pub fn steps(mut self, h: f64, steps: u64) -> Self {
        self.steps = Some((h, steps));
        self
    }

    /// Records the observables at the start, after each `steps` steps and at the end.
    #[must_use]
    pub fn record_every(mut self, steps: u64) -> Self {
        self.every = Some(steps);
        self
    }

    /// Where all paths start.
    #[must_use]
    pub fn start(mut self, state: State<N>) -> Self {
        self.start = Some(Start::Same(state));
        self
    }

    /// Where each path starts: a function of its number and of a generator of its own. All have to start at one time.
    #[must_use]
    pub fn start_with(mut self, draw: impl Fn(u64, &mut StartRng) -> State<N> + Sync + 'a) -> Self {
        self.start = Some(Start::Drawn(Box::new(draw)));
        self
    }

    /// Clips the increments as [`Truncated`](crate::noise::Truncated) does, with its exponent (2 keeps the strong order 1).
    #[must_use]
    pub fn truncated(mut self, exponent: f64) -> Self {
        self.law = Law::Truncated { exponent };
        self
    }

    /// Draws increments of three values, those of [`ThreePoint`](crate::noise::ThreePoint): for means, not for paths.
    #[must_use]
    pub fn three_point(mut self) -> Self {
        self.law = Law::Drawn(Source::ThreePoint);
        self
    }

    /// Makes all increments zero.
    #[must_use]
    pub fn no_noise(mut self) -> Self {
        self.law = Law::None;
        self
    }

    /// Takes statistics of a function of the system and a state, which returns `f64` or `Result<f64, StepError>`.
    ///
    /// Its value has to depend on its arguments alone. A path where it fails or is not finite has failed.
    #[must_use]
    pub fn observe<F, O>(mut self, name: impl Into<String>, observable: F) -> Self
    where
        F: Fn(&S, &State<N>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.names.push(name.into());
        self.observables.push(Box::new(Closure::new(observable)));
        self
    }

    /// Counts how many paths have an observable in each of `bins` equal parts of a range, at each recorded time.
    #[must_use]
    pub fn histogram(self, name: impl Into<String>, range: Range<f64>, bins: usize) -> Self {
        self.request(name.into(), &range, bins, true)
    }

    /// As [`histogram`](Self::histogram), at the end alone.
    #[must_use]
    pub fn final_histogram(self, name: impl Into<String>, range: Range<f64>, bins: usize) -> Self {
        self.request(name.into(), &range, bins, false)
    }

    fn request(mut self, name: String, range: &Range<f64>, bins: usize, always: bool) -> Self {
        let range = [range.start, range.end];
        self.histograms.push(Request {
            name,
            range,
            bins,
            always,
        });
        self
    }

    /// Keeps the state of each path at the end. The memory of a run then grows with its paths.
    #[must_use]
    pub fn keep_final_states(mut self, keep: bool) -> Self {
        self.keep_final_states = keep;
        self
    }

    /// Ends the run with an error when a path fails: that of the failing path with the lowest number.
    #[must_use]
    pub fn stop_on_failure(mut self, stop: bool) -> Self {
        self.stop_on_failure = stop;
        self
    }

    /// Runs part `index` (from 0) of `of` parts. The summaries of all parts [merge](Summary::merge) into that of the whole.
    #[must_use]
    pub fn shard(mut self, index: u64, of: u64) -> Self {
        self.shard = (index, of);
        self
    }

    /// Runs on so many threads of its own, instead of those of the surrounding `rayon` pool: one a core, usually.
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = Some(threads);
        self
    }

    /// Shows on standard error, where that is a terminal, how far the run is: with the feature `progress` as a bar.
    #[must_use]
    pub fn progress(mut self, shown: bool) -> Self {
        self.progress = shown;
        self
    }

    /// Writes the results of finished blocks into a file, now and then and at the end, for [`resume`](Self::resume).
    ///
    /// The file is always a whole one: it is written beside the old one and then renamed. A run without `resume` writes over what is there.
    #[cfg(feature = "checkpoint")]
    #[must_use]
    pub fn checkpoint(
        mut self,
        path: impl Into<std::path::PathBuf>,
        every: core::time::Duration,
    ) -> Self {
        self.checkpoint = Some((path.into(), every));
        self
    }

    /// Continues from the file of [`checkpoint`](Self::checkpoint) where there is one, with the bits of a run that was not stopped.
    ///
    /// The settings have to be those of the run that wrote it; [`run`](Self::run) refuses the file otherwise. What cannot be looked at, parameters and closures, is
    /// compared by the first steps of path 0.
    #[cfg(feature = "checkpoint")]
    #[must_use]
    pub fn resume(mut self, resume: bool) -> Self {
        self.resume = resume;
        self
    }

    /// Ends the run early when this says so, as after a signal or with the time of a batch system: no further block is begun, and
    /// the summary has the paths that were run.
    #[must_use]
    pub fn stop_when(mut self, stop: impl Fn() -> bool + Sync + 'a) -> Self {
        self.stop_when = Some(Box::new(stop));
        self
    }

    /// Makes the steps of all paths.
    ///
    /// # Errors
    /// An [`EnsembleError`] for settings that make no sense; [`EnsembleError::Failed`] where
    /// [`stop_on_failure`](Self::stop_on_failure) was asked for.
    pub fn run(&self) -> Result<Summary, EnsembleError>
    where
        I: Sync,
    {
        Run::new(self)?.go()
    }
}

impl<I: Method> fmt::Debug for Ensemble<'_, I> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Ensemble")
            .field("paths", &self.paths)
            .field("seed", &self.seed)
            .field("steps", &self.steps)
            .field("record_every", &self.every)
            .field("observables", &self.names)
            .field("shard", &self.shard)
            .finish_non_exhaustive()
    }
}
