//! What is wrong with the settings of an ensemble, or with what is merged. Each message says what to write instead.

use super::failure::Failure;
use crate::error::StepError;
use crate::noise::NoiseError;

/// Why an ensemble could not be run, or summaries could not be merged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EnsembleError {
    /// A setting that has no sensible default was not given.
    #[error("the ensemble does not know its {what}: add `{write}`")]
    Missing {
        /// What is missing.
        what: &'static str,
        /// A call that gives it.
        write: &'static str,
    },
    /// A number that has to be at least 1 is 0.
    #[error("`{setting}` was given 0 and needs at least 1; {remedy}")]
    Zero {
        /// The setting.
        setting: &'static str,
        /// What to write instead.
        remedy: &'static str,
    },
    /// The method refused the step size.
    #[error("`steps(h, …)`: {0}")]
    Prepare(#[source] StepError),
    /// The time of the last step is not a finite number.
    #[error(
        "{steps} steps of {h:e} from t = {start} end at a time that is not finite; take fewer or shorter steps"
    )]
    Time {
        /// Time of the start.
        start: f64,
        /// Step size.
        h: f64,
        /// Steps asked for.
        steps: u64,
    },
    /// The truncation of the increments is not possible.
    #[error("`truncated`: {0}")]
    Truncation(#[source] NoiseError),
    /// Two observables have one name.
    #[error("two observables are called `{name}`: give each a name of its own")]
    TwiceNamed {
        /// The name.
        name: String,
    },
    /// A histogram of an observable that does not exist.
    #[error(
        "there is no observable `{name}` to make a histogram of, only {known:?}: add `.observe(\"{name}\", …)`"
    )]
    UnknownObservable {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: Vec<String>,
    },
    /// A histogram without room.
    #[error(
        "the histogram of `{name}` over {low:e}..{high:e} with {bins} bins needs finite bounds, the lower below the upper, and a bin"
    )]
    Histogram {
        /// The observable.
        name: String,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
        /// Bins.
        bins: usize,
    },
    /// A shard that does not exist.
    #[error("`shard({index}, {of})`: of {of} shards the numbers are 0 to {of} − 1")]
    Shard {
        /// Shard asked for.
        index: u64,
        /// How many there are.
        of: u64,
    },
    /// A path that the ensemble does not have.
    #[error("path {path} cannot be replayed: the paths are numbered from 0 to {paths} − 1")]
    Path {
        /// Path asked for.
        path: u64,
        /// Paths of the ensemble.
        paths: u64,
    },
    /// A path failed, and `stop_on_failure` was asked for.
    #[error("{0}")]
    Failed(#[source] Failure),
    /// The threads could not be started.
    #[error("the threads could not be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// Summaries of different runs were to be merged.
    #[error(
        "the summaries differ in their {what}, so they are of different runs; merge shards of one ensemble alone"
    )]
    OtherRun {
        /// In what they differ.
        what: &'static str,
    },
    /// Summaries with common paths were to be merged.
    #[error("both summaries have the paths {first} to {last}; merge each shard once")]
    Overlap {
        /// First common path.
        first: u64,
        /// Last of a run of common paths.
        last: u64,
    },
    /// The file of a checkpoint could not be read or written.
    #[cfg(feature = "checkpoint")]
    #[error("the checkpoint {} could not be read or written: {source}", path.display())]
    Checkpoint {
        /// The file.
        path: std::path::PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file to continue from is none.
    #[cfg(feature = "checkpoint")]
    #[error(
        "{} is not a checkpoint of this version; remove it, or give another path", path.display()
    )]
    NotACheckpoint {
        /// The file.
        path: std::path::PathBuf,
    },
}
