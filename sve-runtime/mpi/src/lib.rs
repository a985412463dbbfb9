//! Ensembles of [`sve_runtime`] on clusters, by MPI.
//!
//! [`run`] takes the same [`Ensemble`] on every rank and gives every rank the same [`Summary`],
//! with the bits of [`Ensemble::run`] on one machine, for any number of ranks and of threads on
//! each rank.
//!
//! ```no_run
//! use sve_runtime::prelude::*;
//!
//! struct Oscillator { sigma: f64 }
//!
//! #[variational(endpoint)]
//! impl Oscillator {
//!     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
//!     #[gamma]
//!     fn push(&self, q: f64) -> f64 { self.sigma * q }
//! }
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     let threading = mpi::Threading::Funneled;
//!     let (universe, _) = mpi::initialize_with_threading(threading).ok_or("MPI runs already")?;
//!     let world = universe.world();
//!     let integrator = Integrator::new(Oscillator { sigma: 1.0 }, Endpoint);
//!     let ensemble = Ensemble::new(&integrator)
//!         .paths(1_000_000).seed(7)
//!         .steps(0.1, 200).every(50)
//!         .start(State::new([1.0], [0.0]))
//!         .observe("energy", |system, state| system.hamiltonian(state));
//!     let summary = sve_mpi::run(&ensemble, &world)?;
//!     if mpi::traits::Communicator::rank(&world) == 0 {
//!         println!("{summary}");
//!     }
//!     Ok(())
//! }
//! ```
//!
//! # Settings of the ensemble on several ranks
//!
//! | setting | on several ranks |
//! | --- | --- |
//! | `threads` | the threads of each rank; may differ between ranks. By default as many as the cores that the rank may use |
//! | `checkpoint`, `resume` | of rank 0, which tries the write before the first path and writes one file for all ranks. [`Ensemble::run`] reads and writes the same file, and so does a run on another number of ranks. A write that fails later does not end the run: the summaries of all ranks have the [warning](Summary::warnings) |
//! | `progress` | of rank 0, which shows the paths of all ranks |
//! | `stop_when` | each rank asks its own function; the first `true` ends the run on all ranks |
//! | `stop_on_failure` | the error describes the failing path with the lowest number, as on one machine |
//! | `shard` | the same on all ranks, which run the blocks of this shard |
//! | all others | the same on all ranks; another value on one rank is an [`Error::Differs`] |
//!
//! Errors are the same on all ranks. A rank that dies, by a signal or by `exit`, ends the run
//! through `mpirun`; the file of the last checkpoint stays complete. If a rank returns before it
//! calls [`run`], the other ranks wait for it forever: it should call
//! [`abort`](mpi::traits::Communicator::abort).
//!
//! # How it works
//!
//! The paths of an ensemble are blocks, whose results merge in a fixed tree. Each rank has a region
//! of consecutive blocks and merges their results where it computes them. Rank 0 hands out ranges
//! of blocks, long ones first. A rank without blocks gets blocks of the rank with the most
//! remaining blocks, so paths may take unequal time. At the end results merge along a binomial tree
//! of ranks. `docs/cluster.md` gives the number of messages.

mod agreement;
mod coordinator;
mod error;
mod leader;
mod link;
mod message;
mod pool;
mod progress;
mod schedule;

use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use mpi::traits::Communicator;
use sve_runtime::ensemble::PathMethod;
use sve_runtime::ensemble::{Distribution, Ensemble, PartialResults, Summary};

pub use self::error::Error;

use self::agreement::{Beginning, agree};
use self::coordinator::Coordinator;
use self::error::SentError;
use self::leader::{Leader, received_results};
use self::link::Link;
use self::message::{Answer, Stop};
use self::pool::Pool;
use self::progress::Progress;
use self::schedule::Schedule;

/// A rank asks for blocks for about this time, as long as many blocks remain.
const INTERVAL: Duration = Duration::from_millis(50);

/// Time for which a rank asks for blocks, for each rank of the run. With many ranks it exceeds
/// [`INTERVAL`], so that rank 0 gets at most 20,000 messages per second.
const INTERVAL_OF_RANK: Duration = Duration::from_micros(50);

/// Number of intervals after which a rank reports even if it needs nothing. It sends its progress
/// and learns of errors.
const QUIET_INTERVALS: u32 = 5;

/// Runs an ensemble on all ranks of a communicator. Every rank has to call this function with the
/// same ensemble, on the thread that initialised MPI.
///
/// # Errors
/// An [`Error`], the same on all ranks. A path that fails is not an error of the run, see
/// [`Summary::failures`].
pub fn run<'a, I: PathMethod + Sync>(
    ensemble: &'a Ensemble<'a, I>,
    world: &impl Communicator,
) -> Result<Summary, Error> {
    run_in_pieces(ensemble, world, link::PIECE)
}

/// Runs an ensemble with messages that are cut into pieces of so many bytes, at least 8, for tests.
///
/// # Errors
/// As [`run`].
#[doc(hidden)]
pub fn run_in_pieces<'a, I: PathMethod + Sync>(
    ensemble: &'a Ensemble<'a, I>,
    world: &impl Communicator,
    piece: usize,
) -> Result<Summary, Error> {
    let link = Link::new(world, piece);
    let _guard = AbortOnPanic(&link);
    let beginning = agree(ensemble, &link)?;
    let distribution = &beginning.distribution;
    let rank = link.rank();
    let interval = INTERVAL.max(INTERVAL_OF_RANK * link.size().unsigned_abs());
    let threads = distribution.threads();
    let pool = Pool::new(rank, threads, interval, distribution.no_results());
    let ended = run_blocks(&link, &pool, &beginning, interval);
    let mut results = gather(&link, distribution, ended.results);
    let known = pool.take_error();
    let outcome = (rank == 0).then(|| {
        if let Some(checkpoint) = &beginning.checkpoint {
            checkpoint.save(&results);
            if let Some(warning) = checkpoint.warning() {
                results.warn(warning);
            }
        }
        outcome(distribution, &results, ended.stop)
    });
    let outcome: Result<Vec<u8>, SentError> = link.broadcast(0, outcome);
    match outcome {
        Err(error) => Err(error.received(rank, known)),
        Ok(bytes) => {
            let results = received_results(distribution, &bytes);
            distribution
                .summary(results)
                .map_err(|error| Error::NothingRun(Box::new(error)))
        }
    }
}

/// The results of a rank at the end of its blocks.
struct Ended {
    results: PartialResults,
    /// The reason why the run ended early, on rank 0.
    stop: Option<Stop>,
}

/// Runs blocks until no rank has any left.
fn run_blocks<I: PathMethod + Sync>(
    link: &Link,
    pool: &Pool,
    beginning: &Beginning<'_, I>,
    interval: Duration,
) -> Ended {
    let distribution = &beginning.distribution;
    let threads = distribution.threads();
    let gathered = match &beginning.loaded {
        Some(loaded) => loaded.clone(),
        None => distribution.no_results().take(),
    };
    if link.rank() > 0 {
        thread::scope(|scope| {
            let _guard = AbortOnPanic(link);
            for _ in 0..threads {
                scope.spawn(|| pool.run(distribution));
            }
            follow(link, pool, QUIET_INTERVALS * interval);
            pool.end();
        });
        return Ended {
            results: pool.results.take(),
            stop: None,
        };
    }
    let ranks = link.size().unsigned_abs() as usize;
    let schedule = Schedule::new(distribution.blocks(), gathered.blocks(), ranks);
    let paths = distribution.paths_of(distribution.blocks());
    let progress = Progress::new(distribution.shows_progress(), paths);
    for blocks in gathered.blocks() {
        progress.add(distribution.paths_of(blocks));
    }
    let gathered = Mutex::new(gathered);
    let leader = Leader {
        link,
        pool,
        distribution,
        progress: &progress,
        checkpoint: beginning.checkpoint.as_ref(),
        gathered: &gathered,
    };
    let stop = thread::scope(|scope| {
        let _guard = AbortOnPanic(link);
        for _ in 0..threads {
            scope.spawn(|| pool.run(distribution));
        }
        let ended = leader.lead(scope, Coordinator::new(schedule, ranks));
        pool.end();
        ended
    });
    let mut results = gathered
        .into_inner()
        .unwrap_or_else(PoisonError::into_inner);
    results.merge(pool.results.take());
    Ended { results, stop }
}

/// Asks rank 0 for blocks until the run has ended.
fn follow(link: &Link, pool: &Pool, quiet: Duration) {
    let mut wants_results = false;
    loop {
        if !wants_results {
            pool.wait(quiet);
        }
        let mut report = pool.report();
        if wants_results {
            report.results = Some(pool.results.take().to_bytes());
        }
        link.send(0, &report);
        let answer: Answer = link.receive(0);
        if answer.has_ended {
            return;
        }
        pool.accept(&answer);
        wants_results = answer.wants_results;
    }
}

/// Merges the results of all ranks along a binomial tree: rank `r` receives from `r + 1`, `r + 2`,
/// `r + 4`, …, and sends to `r` less its lowest bit. The ranks below one another have neighbouring
/// regions, so each message contains few nodes of the tree of blocks. Returns all results on
/// rank 0.
fn gather<I: PathMethod + Sync>(
    link: &Link,
    distribution: &Distribution<'_, I>,
    mut results: PartialResults,
) -> PartialResults {
    let (rank, size) = (link.rank(), link.size());
    let mut bit = 1;
    while bit < size {
        if rank & bit != 0 {
            link.send(rank - bit, &results.to_bytes());
            break;
        }
        if rank + bit < size {
            let bytes: Vec<u8> = link.receive(rank + bit);
            results.merge(received_results(distribution, &bytes));
        }
        bit *= 2;
    }
    results
}

/// Returns the results in the form in which they are sent to all ranks, or the reason why there are
/// none.
fn outcome<I: PathMethod + Sync>(
    distribution: &Distribution<'_, I>,
    results: &PartialResults,
    stop: Option<Stop>,
) -> Result<Vec<u8>, SentError> {
    let is_stopped = stop.is_some();
    if let Some(cause) = stop.and_then(|stop| stop.cause) {
        return Err(SentError::Cause(cause));
    }
    if results.is_empty() {
        return Err(SentError::NothingRun);
    }
    let found = results
        .blocks()
        .map(|blocks| distribution.paths_of(blocks))
        .sum();
    let expected = distribution.paths_of(distribution.blocks());
    if found != expected && !is_stopped {
        return Err(SentError::Lost { found, expected });
    }
    Ok(results.to_bytes())
}

/// Ends the program on all ranks if a panic outside of the paths would leave the other ranks
/// waiting.
struct AbortOnPanic<'l>(&'l Link);

impl Drop for AbortOnPanic<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.abort();
        }
    }
}
