//! Errors of ensembles: invalid settings, files, merges. Each message says what to write instead.

#[cfg(feature = "checkpoint")]
use super::difference::Damage;
use super::difference::Difference;
use super::failure::Failure;
use crate::error::StepError;
use crate::noise::NoiseError;
use crate::readable::debug_is_display;

/// The reason why an ensemble could not be run, or summaries could not be merged.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum EnsembleError {
    /// A setting without a default is missing.
    #[error("the ensemble does not know its {what}: add `{write}`")]
    Missing {
        /// The missing setting.
        what: &'static str,
        /// A call that gives it.
        write: &'static str,
    },
    /// A number that has to be at least 1 is 0.
    #[error("`{setting}` was given 0 and needs at least 1; {remedy}")]
    Zero {
        /// The setting.
        setting: &'static str,
        /// The remedy.
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
    /// A step is too short to change the time.
    #[error(
        "{steps} steps of {h:e} from t = {start}: at t = {t} a step does not change the time, whose next number is {next} away; \
         take longer steps, or measure time from a nearer origin"
    )]
    TimeStands {
        /// Time of the start.
        start: f64,
        /// Step size.
        h: f64,
        /// Steps asked for.
        steps: u64,
        /// Time that a step does not change.
        t: f64,
        /// Distance from this time to the next number.
        next: f64,
    },
    /// The results do not fit into memory.
    #[error("{what} take {bytes} bytes, more than this machine gives; {remedy}")]
    TooLarge {
        /// The results that need the memory, with their numbers.
        what: String,
        /// Bytes that it takes, at the least.
        bytes: u128,
        /// The remedy.
        remedy: &'static str,
    },
    /// The noise has no increments for this step size.
    #[error("`noise`: {0}")]
    Noise(#[source] NoiseError),
    /// The rule has stage noise, and the noise has no increments at its stages.
    #[error(
        "`noise`: {noise} are not drawn at the {stages} stages of the rule: take `Wiener`, not refined, or `Truncated<Wiener>`, or the rule without stage noise"
    )]
    NoStages {
        /// The increments of the noise.
        noise: &'static str,
        /// The stages of the rule.
        stages: usize,
    },
    /// Steps are to be divided, and the noise is not known within steps.
    #[error(
        "`{setting}` divides steps, within which this noise has no increments: take `Wiener`, also refined, or `NoNoise`; increments of three values and clipped ones belong to whole steps"
    )]
    NoiseWithinSteps {
        /// The setting.
        setting: &'static str,
    },
    /// Two settings that exclude each other.
    #[error("`{}` and `{}` do not go together: {why}; leave one of them out", settings[0], settings[1])]
    NotTogether {
        /// The settings.
        settings: [&'static str; 2],
        /// The reason.
        why: &'static str,
    },
    /// Averages that would begin when the paths end.
    #[error(
        "`settle({settle})` leaves nothing to average: a path makes {steps} steps, so settle for fewer"
    )]
    Settle {
        /// Steps after which averages begin.
        settle: u64,
        /// Steps of a path.
        steps: u64,
    },
    /// Two observables have the same name.
    #[error("two observables are called `{name}`: give each a name of its own")]
    TwiceNamed {
        /// The name.
        name: String,
    },
    /// A histogram or a bound of an observable that does not exist.
    #[error(
        "there is no observable `{name}` to {purpose}, only {known:?}: add `.observe(\"{name}\", …)`"
    )]
    UnknownObservable {
        /// The name asked for.
        name: String,
        /// The purpose for which it was named.
        purpose: &'static str,
        /// The names of the observables.
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
    /// A bound that no value satisfies.
    #[error(
        "`bound(\"{name}\", {low:e}..={high:e})` leaves no value: the lower bound must not be above the upper one, and neither NaN"
    )]
    Bound {
        /// The observable.
        name: String,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// A gradient by a quantity that the system does not have.
    #[error("there is no gradient by {by}: {why}")]
    Gradient {
        /// The quantity.
        by: String,
        /// The reason.
        why: String,
    },
    /// The function of a gradient cannot be evaluated at the start of the first path.
    #[error("the function of the gradient `{name}`: {error}")]
    GradientFunction {
        /// Name of the function.
        name: String,
        /// The reason.
        #[source]
        error: Box<StepError>,
    },
    /// Quantiles from too few values.
    #[error("`quantiles(\"{name}\", {size})` keeps {size} values; quantiles need at least 2")]
    Quantiles {
        /// The observable.
        name: String,
        /// Number of values to be kept.
        size: usize,
    },
    /// An odd number of paths that are to be antithetic pairs.
    #[error("{paths} paths are not pairs; `antithetic` needs an even number of paths")]
    OddPaths {
        /// Number of paths.
        paths: u64,
    },
    /// Covariances or quantiles of antithetic paths.
    #[error(
        "`covariance`, `two_time` and `quantiles` have errors of independent paths, and `antithetic` makes paths depend on one another; leave one of them out"
    )]
    AntitheticPairs,
    /// Coarse steps whose noise has no sums.
    #[error(
        "two increments of `ThreePoint` do not add up to one of a step twice as long, so a coarse and a fine step have no common path; take `Wiener`"
    )]
    NoSums,
    /// A sweep over no rows.
    #[error("the table of the sweep has no row; give it the methods or starts to compare")]
    EmptyTable,
    /// A sweep over starts at different times.
    #[error(
        "row {row} of the sweep starts at t = {t}, row 0 at {first}: rows are compared at common times, so give all starts one time"
    )]
    SweepTimes {
        /// The row.
        row: usize,
        /// Its time.
        t: f64,
        /// The time of the first row.
        first: f64,
    },
    /// A sweep with a checkpoint.
    #[error(
        "a sweep has a run for each row of its table, and a checkpoint is the file of one: leave `checkpoint` out, or take the sweep in shards"
    )]
    SweepInOneFile,
    /// Sweeps over different tables were to be merged.
    #[error(
        "the sweeps have {rows} and {others} rows, so they are of different tables; merge shards of one sweep alone"
    )]
    OtherTable {
        /// Number of rows of one sweep.
        rows: usize,
        /// Number of rows of the other sweep.
        others: usize,
    },
    /// A multilevel estimate of a part of a run.
    #[error(
        "`multilevel` decides itself how many paths each level has, in one run: leave `shard`, `checkpoint` and `stop_when` out"
    )]
    MultilevelInParts,
    /// A multilevel estimate with an impossible error or order.
    #[error("`multilevel` was given the {what} {value:e}, which has to be a positive number")]
    MultilevelTarget {
        /// The setting.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A multilevel estimate with too few levels to estimate a bias from.
    #[error(
        "`deepest({deepest})`: `multilevel` estimates the bias from two differences of levels, so the deepest level is 2 at least"
    )]
    TooFewLevels {
        /// The deepest level.
        deepest: u32,
    },
    /// A level of a multilevel estimate without an estimate.
    #[error(
        "no mean and variance of `{name}` on level {level} of `multilevel`, with steps of {h:e}: {failed} of {paths} paths failed; take shorter steps"
    )]
    NoLevel {
        /// The observable.
        name: String,
        /// The level.
        level: u32,
        /// Its step size.
        h: f64,
        /// Paths that failed.
        failed: u64,
        /// Paths that were run.
        paths: u64,
    },
    /// A multilevel estimate of an observable that has the same value on all paths that were run.
    #[error(
        "`multilevel`: all of the first {paths} paths of each level have one value of `{name}`, {value:e} on the longest steps, so nothing tells its error: it is a constant, whose mean `run` gives, \
         or what changes it happens on fewer than one path in {}; begin with more `paths`, several times as many as it needs to happen once", paths / 3
    )]
    OneValue {
        /// The observable.
        name: String,
        /// Its value on level 0.
        value: f64,
        /// Paths of a level.
        paths: u64,
    },
    /// A level of a multilevel estimate whose variance comes from a few paths, however many are
    /// run.
    #[error(
        "`multilevel`: on level {level} the variance of `{name}` is that of about {carriers:.0} of {paths} paths, and more paths did not give it more: its tails are too heavy for a variance; \
         take an observable with a bounded range, or let paths fail that leave one with `bound`"
    )]
    HeavyTails {
        /// The observable.
        name: String,
        /// The level.
        level: u32,
        /// Number of paths that have the variance.
        carriers: f64,
        /// Paths that were run.
        paths: u64,
    },
    /// A multilevel estimate of a mean whose differences between levels do not fall.
    #[error(
        "`multilevel`: halving the steps changes the mean of `{name}` by {:.2e}, then by {:.2e} and {:.2e} at level {level}: the changes do not fall, so the mean has no limit for short steps, as that of a sum over \
         steps, or the first steps are too long for the motion; divide the observable by the number of steps, or start from shorter steps",
        changes[0], changes[1], changes[2]
    )]
    NoLimit {
        /// The observable.
        name: String,
        /// The last level.
        level: u32,
        /// The sizes of the last three differences of means.
        changes: [f64; 3],
    },
    /// A multilevel estimate that needs more levels than it may have.
    #[error(
        "`multilevel`: at level {level} the bias of the mean of `{name}` is estimated as {bias:.1e}, above {wanted:.1e}; allow more levels with `deepest`, start from shorter steps, or ask for a larger error"
    )]
    Bias {
        /// The observable.
        name: String,
        /// The last level.
        level: u32,
        /// The estimate of the bias.
        bias: f64,
        /// The largest bias that the wanted error allows.
        wanted: f64,
    },
    /// A shard that does not exist.
    #[error("`shard({index}, {of})`: of {of} shards the numbers are 0 to {of} − 1")]
    Shard {
        /// Shard asked for.
        index: u64,
        /// Number of shards.
        of: u64,
    },
    /// A shard without a path.
    #[error(
        "`shard({index}, {of})` has no path: {paths} paths are {blocks} blocks, which are not divided; take at most {blocks} shards"
    )]
    EmptyShard {
        /// Shard asked for.
        index: u64,
        /// Number of shards.
        of: u64,
        /// Paths of the ensemble.
        paths: u64,
        /// Blocks of paths.
        blocks: u64,
    },
    /// A run was stopped before a path ended.
    #[error(
        "the run was stopped by `stop_when` before its first paths ended, so there is nothing to summarise; let it run longer"
    )]
    NothingRun,
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
    Failed(#[source] Box<Failure>),
    /// The threads could not be started.
    #[error("the threads could not be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// Summaries of different runs were to be merged.
    #[error(
        "the summaries differ in {what}, so they are of different runs; merge shards of one ensemble alone"
    )]
    OtherRun {
        /// The difference.
        what: Difference,
    },
    /// Summaries with common paths were to be merged.
    #[error("both summaries have the paths {first} to {last}; merge each shard once")]
    Overlap {
        /// First common path.
        first: u64,
        /// Last of a run of common paths.
        last: u64,
    },
    /// The file of a checkpoint could not be read, or written on trial, so that no path was
    /// computed.
    #[cfg(feature = "checkpoint")]
    #[error(
        "the checkpoint {} cannot be read and written, so no path was computed: {source}; make the file accessible, or give another path",
        path.display()
    )]
    Checkpoint {
        /// The file.
        path: std::path::PathBuf,
        /// The error of the system.
        source: std::io::Error,
    },
    /// The file to continue from is not a checkpoint.
    #[cfg(feature = "checkpoint")]
    #[error(
        "{} is not a checkpoint: it does not begin as one; remove it, or give another path", path.display()
    )]
    NotACheckpoint {
        /// The file.
        path: std::path::PathBuf,
    },
    /// The file to continue from was written in another format.
    #[cfg(feature = "checkpoint")]
    #[error(
        "the checkpoint {} has format {version}, and this version of sve reads format {expected}; remove it, or continue with the version that wrote it",
        path.display()
    )]
    CheckpointVersion {
        /// The file.
        path: std::path::PathBuf,
        /// Its format.
        version: u32,
        /// The format that is read.
        expected: u32,
    },
    /// The file to continue from is damaged.
    #[cfg(feature = "checkpoint")]
    #[error(
        "the checkpoint {} is damaged: {damage}; remove it, or put a sound copy in its place", path.display()
    )]
    DamagedCheckpoint {
        /// The file.
        path: std::path::PathBuf,
        /// The damage.
        damage: Damage,
    },
    /// The file to continue from belongs to another run.
    #[cfg(feature = "checkpoint")]
    #[error(
        "the checkpoint {} is of another run, with {what} of its own; continue it with its own settings and program, or remove it, or give another path",
        path.display()
    )]
    OtherCheckpoint {
        /// The file.
        path: std::path::PathBuf,
        /// The difference.
        what: Difference,
    },
}

debug_is_display!(EnsembleError);
