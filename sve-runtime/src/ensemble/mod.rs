//! Monte Carlo over many paths: statistics of observables, on all cores, in lanes of vector
//! registers.
//!
//! Input: a method, a start, a step size, numbers of steps and paths, observables. Output: a
//! [`Summary`]. Invariant: all results are functions of the settings, with the same bits for any
//! number of threads, and for the merged shards as for the whole run.
//!
//! A run divides its paths into blocks of [`BLOCK_PATHS`], each of a few tiles of `LANES` lanes. A
//! block is the unit of work of a thread; where paths can stop, several blocks are run together, so
//! that their paths keep the lanes full. The results of blocks are merged pairwise in a fixed tree.

mod antithetic;
#[cfg(feature = "checkpoint")]
mod attempts;
mod by;
#[cfg(feature = "checkpoint")]
mod checkpoint;
mod columns;
mod coupled;
mod covariance;
mod crossings;
mod difference;
#[cfg(feature = "distributed")]
mod distribution;
mod edges;
mod energy;
mod error;
mod estimate;
mod execution;
mod failure;
mod final_state;
mod fingerprint;
mod fold;
mod gradient;
mod histogram;
mod increment_buffer;
mod info;
mod inputs;
mod integral;
mod joint;
mod maximum;
mod memory;
mod merge_tree;
mod moments;
mod multilevel;
mod observe;
mod observer;
mod packing;
mod passage;
mod path_block;
mod path_method;
mod path_noise;
mod path_table;
mod quantiles;
mod record;
mod refine;
mod replay;
mod setters;
mod settings;
mod sizes;
mod sketch;
mod spread;
mod starts;
mod statistic;
mod statistics;
#[cfg(feature = "serde")]
mod stored;
mod summary;
mod sweep;
mod systems;
mod tangents;
mod tile;
mod warning;

pub use crate::error::observed::Observed;
pub use by::By;
pub use covariance::{Covariance, TwoTime};
#[cfg(feature = "checkpoint")]
pub use difference::Damage;
pub use difference::Difference;
#[cfg(feature = "distributed")]
pub use distribution::{Checkpoint, Distribution, PartialResults, SharedResults};
pub use error::EnsembleError;
pub use estimate::{Level, MultilevelEstimate};
pub use failure::{Cause, FAILURES_KEPT, Failure};
pub use final_state::FinalState;
pub use histogram::{Bins, Histogram};
pub use inputs::{Complete, NeedsInputs, Runs};
pub use multilevel::Multilevel;
pub use passage::{Passages, Rate};
pub use path_method::PathMethod;
pub use quantiles::Quantiles;
pub use starts::{StartRng, Starts};
pub use statistics::Statistics;
pub use summary::Summary;
pub use sweep::{Sweep, SweepRow};
pub use warning::Warning;

use core::fmt;
use core::marker::PhantomData;

use self::gradient::Gradients;
use self::observe::Closure;
use self::observer::{Observable, Plain};
use self::passage::PassageFunction;
use self::settings::Settings;
use self::starts::Start;
use self::statistic::AnyRequest;
use self::statistics::MomentsRequest;
use crate::lanes::LANES;
use crate::method::Shared;
use crate::noise::PathData;
use crate::system::StateOf;

/// Number of paths of a block. One thread runs a block, and the statistics of all blocks are merged
/// in a fixed order. The number is part of the contract: another number would change the last bits
/// of statistics. It is small, so that a thousand paths occupy several threads.
pub const BLOCK_PATHS: u64 = 64;

/// Returns the first path of a block, or the number of paths if there is no such block.
fn path_at(block: u64, paths: u64) -> u64 {
    (block.checked_mul(BLOCK_PATHS)).map_or(paths, |first| first.min(paths))
}

/// Number of tiles of a block.
const BLOCK_TILES: usize = BLOCK_PATHS as usize / LANES;

const _: () = assert!(BLOCK_TILES * LANES == BLOCK_PATHS as usize);

/// Many paths of one method, and the statistics to be taken of them.
///
/// Path `k`, from 0, has the increments of [`Wiener::new(seed).path(k)`](crate::noise::Wiener), or
/// of another [`noise`](Self::noise). Paths, steps and a start have to be given. The default seed
/// is 0. Without [`every`](Self::every) the start and the end are recorded.
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
///     .steps(0.1, 200).every(50)
///     .start(State::new([1.0], [0.0]))
///     .observe("energy", |system, state| system.hamiltonian(state))
///     .run()?;
/// let energy = &summary["energy"];
/// let means = energy.mean().iter().zip(energy.standard_error());
/// for (t, (mean, error)) in summary.times().iter().zip(means) {
///     // the exact mean is 1/2 + σ²t/2
///     assert!((mean - 0.5 - 0.5 * t).abs() < 0.1 + 4.0 * error);
/// }
/// # Ok(())
/// # }
/// ```
pub struct Ensemble<'a, I: PathMethod, K = Complete> {
    method: Shared<'a, I>,
    /// Marks whether the method needs inputs.
    kind: PhantomData<K>,
    paths: Option<u64>,
    seed: Option<u64>,
    noise: Option<PathData>,
    steps: Option<(f64, u64)>,
    every: Option<u64>,
    start: Option<Start<'a, StateOf<I::System>>>,
    keep_final_states: bool,
    /// Largest number of halvings of a step that fails.
    refine: u32,
    stop_on_failure: bool,
    observed: Observations<'a, I>,
    execution: Execution<'a>,
}

/// The observables of the paths, and the statistics that are taken of them.
struct Observations<'a, I: PathMethod> {
    /// The observables and their names.
    names: Vec<String>,
    observables: Vec<Box<dyn Observable<I::System> + 'a>>,
    /// The integral of the rate at which the logarithm of the weight of a path decreases.
    weight: Option<Box<dyn Observable<I::System> + 'a>>,
    /// The step at which averages begin.
    settle: u64,
    gradients: Gradients<'a, I>,
    /// Functions whose first zero is recorded.
    passages: Vec<PassageFunction<'a, I::System>>,
    /// The statistics that are taken of the observables.
    statistics: Vec<AnyRequest>,
    /// Observables with their least and greatest values.
    bounds: Vec<(String, [f64; 2])>,
}

/// The options of the execution, which do not change the results.
#[derive(Default)]
struct Execution<'a> {
    shard: Option<(u64, u64)>,
    threads: Option<usize>,
    progress: bool,
    stop_when: Option<Box<dyn Fn() -> bool + Sync + 'a>>,
    #[cfg(feature = "checkpoint")]
    checkpoint: Option<(std::path::PathBuf, core::time::Duration)>,
    #[cfg(feature = "checkpoint")]
    resume: bool,
}

impl Execution<'_> {
    /// Returns whether the function that was given asks to end the run.
    fn is_stopped(&self) -> bool {
        self.stop_when.as_ref().is_some_and(|stop| stop())
    }
}

impl<I: PathMethod> Observations<'_, I> {
    /// Returns the number of an observable.
    fn column(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }
}

impl<'a, I: PathMethod, K> Ensemble<'a, I, K> {
    /// Paths of a method: an [`Integrator`](crate::Integrator) or a [`baseline`](crate::baseline).
    /// The paths of a system with inputs need [`inputs`](Self::inputs).
    pub fn new(method: impl Runs<'a, K, Method = I>) -> Self {
        Self {
            method: method.shared(),
            kind: PhantomData,
            paths: None,
            seed: None,
            noise: None,
            steps: None,
            every: None,
            start: None,
            keep_final_states: false,
            refine: 0,
            stop_on_failure: false,
            observed: Observations {
                names: Vec::new(),
                observables: Vec::new(),
                weight: None,
                settle: 0,
                gradients: Gradients::default(),
                passages: Vec::new(),
                statistics: vec![AnyRequest::Moments(MomentsRequest)],
                bounds: Vec::new(),
            },
            execution: Execution::default(),
        }
    }

    /// Takes statistics of a function of the system and a state, which returns `f64` or
    /// `Result<f64, StepError>`.
    ///
    /// Its value may depend on its arguments only. A path on which it fails or is not finite fails.
    /// [`observe_energy`](Self::observe_energy) has the energy in lanes, and
    /// [`integral`](Self::integral), [`maximum`](Self::maximum), [`crossings`](Self::crossings) and
    /// [`fold`](Self::fold) remember the path until the recorded time.
    ///
    #[doc = include_str!("example.md")]
    /// let ensemble = ensemble().observe("energy", |system, state| system.hamiltonian(state));
    /// let summary = ensemble.run()?;
    /// assert_eq!(summary["energy"].mean()[0], 0.5);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn observe<F, O>(self, name: impl Into<String>, observable: F) -> Self
    where
        F: Fn(&I::System, &StateOf<I::System>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        let function = Closure::new(observable);
        let is_weighted = false;
        self.add(
            name,
            Plain {
                function,
                is_weighted,
            },
        )
    }

    fn add(mut self, name: impl Into<String>, observable: impl Observable<I::System> + 'a) -> Self {
        self.observed.names.push(name.into());
        self.observed.observables.push(Box::new(observable));
        self
    }
}

impl<I: PathMethod> Ensemble<'_, I> {
    /// Runs all paths.
    ///
    /// # Errors
    /// An [`EnsembleError`] for invalid settings, if the results do not fit into memory, or if a
    /// checkpoint cannot be read and written; [`EnsembleError::Failed`] with
    /// [`stop_on_failure`](Self::stop_on_failure); [`EnsembleError::NothingRun`] if
    /// [`stop_when`](Self::stop_when) ended the run before its first block of paths. A path that
    /// fails is not an error of the run, see [`Summary::failures`].
    pub fn run(&self) -> Result<Summary, EnsembleError>
    where
        I: Sync,
    {
        Settings::new(self)?.execute()
    }
}

impl<I: PathMethod, K> fmt::Debug for Ensemble<'_, I, K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Ensemble")
            .field("paths", &self.paths)
            .field("seed", &self.seed)
            .field("steps", &self.steps)
            .field("every", &self.every)
            .field("observables", &self.observed.names)
            .field("shard", &self.execution.shard)
            .finish_non_exhaustive()
    }
}
