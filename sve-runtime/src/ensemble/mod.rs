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
mod edges;
mod error;
mod failure;
mod final_state;
pub(crate) mod fingerprint;
mod flight;
mod histogram;
mod increments;
mod law;
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
mod sizes;
mod start;
mod statistics;
mod summary;
mod tree;
mod warning;
mod work;

#[cfg(feature = "checkpoint")]
pub use error::Damage;
pub use error::{Difference, EnsembleError};
pub use failure::{Cause, FAILURES_KEPT, Failure};
pub use final_state::FinalState;
pub use observe::Observed;
pub use start::StartRng;
pub use statistics::{Histogram, Statistics};
pub use summary::Summary;
pub use warning::Warning;

use core::fmt;
use core::ops::{Bound, Range, RangeBounds};

use self::histogram::Request;
use self::law::Wanted;
use self::observe::{Closure, Observable};
use self::run::Run;
use self::start::Start;
use crate::configuration::Coordinates;
use crate::lanes::LANES;
use crate::method::Method;
use crate::state::State;
use crate::system::{Dims, StateOf, System};

/// Paths of a block, which one thread runs and whose statistics are merged with those of other blocks in a fixed order.
/// Part of the contract: another number would change the last bits of statistics. Few enough that a thousand paths keep several threads busy.
pub const BLOCK_PATHS: u64 = 64;

/// The first path of a block, or the number of paths where there is no such block.
fn path_at(block: u64, paths: u64) -> u64 {
    (block.checked_mul(BLOCK_PATHS)).map_or(paths, |first| first.min(paths))
}

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
    law: Wanted,
    names: Vec<String>,
    observables: Vec<Box<dyn Observable<I::System> + 'a>>,
    histograms: Vec<Request>,
    /// Observables with their least and greatest values.
    bounds: Vec<(String, [f64; 2])>,
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

impl<'a, I, S, Q, const N: usize, const M: usize> Ensemble<'a, I>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
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
            law: Wanted::default(),
            names: Vec::new(),
            observables: Vec::new(),
            histograms: Vec::new(),
            bounds: Vec::new(),
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
    pub fn start(mut self, state: State<Q>) -> Self {
        self.start = Some(Start::Same(state));
        self
    }

    /// Where each path starts: a function of its number and of a generator of its own. All have to start at one time.
    #[must_use]
    pub fn start_with(mut self, draw: impl Fn(u64, &mut StartRng) -> State<Q> + Sync + 'a) -> Self {
        self.start = Some(Start::Drawn(Box::new(draw)));
        self
    }

    /// Clips the increments as [`Truncated`](crate::noise::Truncated) does, at so many standard deviations √h, for example 6.
    ///
    /// The bound of Milstein, Repin and Tretyakov with the exponent k and a time τ of the system is `(2.0 * k * (tau / h).ln()).sqrt()` of them.
    /// Excludes [`three_point`](Self::three_point), whose increments are bounded.
    #[must_use]
    pub fn truncated(mut self, deviations: f64) -> Self {
        self.law.truncated = Some(deviations);
        self
    }

    /// Draws increments of three values, those of [`ThreePoint`](crate::noise::ThreePoint): for means, not for paths.
    #[must_use]
    pub fn three_point(mut self) -> Self {
        self.law.three_point = true;
        self
    }

    /// Makes all increments zero, whatever else was asked for.
    #[must_use]
    pub fn no_noise(mut self) -> Self {
        self.law.no_noise = true;
        self
    }

    /// Takes statistics of a function of the system and a state, which returns `f64` or `Result<f64, StepError>`.
    ///
    /// Its value has to depend on its arguments alone. A path where it fails or is not finite has failed.
    #[must_use]
    pub fn observe<F, O>(mut self, name: impl Into<String>, observable: F) -> Self
    where
        F: Fn(&S, &State<Q>) -> O + Sync + 'a,
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

    /// Lets a path fail that has an observable outside of a range at a recorded time, as `.bound("energy", ..=1e3)`: a motion that has lost
    /// all meaning is then a [`Failure`] that is counted, and no part of the statistics. Bounds of the range are inside, and
    /// several ranges may be given.
    ///
    /// Without it, a path fails where its state or an observable is no longer finite. [`Summary::warnings`] reports observables that diverge.
    #[must_use]
    pub fn bound(mut self, name: impl Into<String>, range: impl RangeBounds<f64>) -> Self {
        let number = |bound, none| match bound {
            Bound::Included(&x) | Bound::Excluded(&x) => x,
            Bound::Unbounded => none,
        };
        let low = number(range.start_bound(), f64::NEG_INFINITY);
        let high = number(range.end_bound(), f64::INFINITY);
        self.bounds.push((name.into(), [low, high]));
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

    /// Runs part `index` (from 0) of `of` parts, at most one for each [`BLOCK_PATHS`] paths. The summaries of all parts [merge](Summary::merge) into that of the whole.
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
    /// The file is always a whole one: it is written beside the old one, brought to the disk and then renamed. A run without `resume`
    /// writes over what is there, once a block of paths has ended.
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
    /// The file has to be as it was written, which its length and a checksum show, and of the same run: settings, formulas and parameters
    /// of the system, method and starts. [`run`](Self::run) refuses the file otherwise, and says whether it is damaged or in what
    /// the runs differ. Closures are sampled only: what is not seen of them is said at [`Summary::merge`].
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
    /// An [`EnsembleError`] for settings that make no sense or do not fit into memory; [`EnsembleError::Failed`] where
    /// [`stop_on_failure`](Self::stop_on_failure) was asked for; [`EnsembleError::NothingRun`] where [`stop_when`](Self::stop_when) ended
    /// the run before its first block of paths. A path that fails is no error of the run: see [`Summary::failures`].
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
