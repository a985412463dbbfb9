//! The threads of a rank, and the blocks that were handed to it.
//!
//! Input: answers of rank 0. Output: results of blocks, and reports. Invariant: no thread here
//! calls MPI. Only the thread that started the run calls it, as the thread level `Funneled`
//! requires.

use core::any::Any;
use core::ops::Range;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use sve_runtime::ensemble::PathMethod;
use sve_runtime::ensemble::SharedResults;
use sve_runtime::ensemble::{BLOCK_PATHS, Distribution, EnsembleError, PartialResults};

use super::message::{Answer, Cause, Report, Stop, add_stop};

/// A rank asks for blocks when it has blocks for less than this time, in seconds. The time is
/// several times as long as an answer takes.
const RESERVE: f64 = 4e-3;

/// Toward the end a rank gets blocks for about this time, in seconds.
const LEAST: f64 = 1e-3;

/// Weight of the last block in the mean time of a block.
const WEIGHT: f64 = 0.25;

/// The threads of a rank.
pub(crate) struct Pool {
    rank: i32,
    threads: usize,
    /// The time for which a rank asks for blocks.
    interval: Duration,
    pub(crate) results: SharedResults,
    state: Mutex<State>,
    /// Wakes threads for blocks.
    has_blocks: Condvar,
    /// Wakes the thread that reports.
    is_due: Condvar,
}

#[derive(Default)]
struct State {
    waiting: VecDeque<Range<u64>>,
    /// Number of blocks in `waiting`.
    waiting_blocks: u64,
    /// Number of blocks that run.
    running: u64,
    /// Half of the number of blocks that waited after the last answer. Toward the end rank 0 hands
    /// out fewer blocks than a rank wants.
    half: u64,
    /// True if rank 0 has more blocks.
    has_more: bool,
    /// True if rank 0 knows that this rank has no block.
    is_known_idle: bool,
    has_ended: bool,
    /// The first block that must not be begun any more.
    limit: Option<u64>,
    /// Paths that have ended since the last report.
    paths: u64,
    /// A reason to end that rank 0 does not know.
    stop: Option<Stop>,
    /// The error of this rank.
    error: Option<EnsembleError>,
    /// Mean time of a block, in seconds.
    block_time: Option<f64>,
}

impl Pool {
    pub(crate) fn new(
        rank: i32,
        threads: usize,
        interval: Duration,
        results: SharedResults,
    ) -> Self {
        let state = State {
            has_more: true,
            half: 1,
            ..State::default()
        };
        Self {
            rank,
            threads,
            interval,
            results,
            state: Mutex::new(state),
            has_blocks: Condvar::new(),
            is_due: Condvar::new(),
        }
    }

    /// Returns the report of this rank to rank 0.
    pub(crate) fn report(&self) -> Report {
        let mut state = self.state();
        let unfinished = state.waiting_blocks + state.running;
        state.is_known_idle = unfinished == 0;
        let blocks_in = |time: f64| self.blocks_in(&state, time);
        let threads = self.threads as u64;
        let many =
            blocks_in(self.interval.as_secs_f64()).map_or(threads, |blocks| blocks.max(threads));
        let wanted = many + self.reserve(&state);
        Report {
            wanted,
            waiting: state.waiting_blocks,
            least: blocks_in(LEAST).unwrap_or(1).max(1),
            unfinished,
            paths: core::mem::take(&mut state.paths),
            stop: state.stop.take(),
            results: None,
        }
    }

    /// Returns the number of blocks that this rank runs in a time, if it has run one.
    #[allow(clippy::cast_sign_loss)] // a count
    fn blocks_in(&self, state: &State, time: f64) -> Option<u64> {
        let of_block = state.block_time?.max(1e-9);
        Some((self.threads as f64 * time / of_block).ceil() as u64)
    }

    fn reserve(&self, state: &State) -> u64 {
        self.blocks_in(state, RESERVE).unwrap_or(1)
    }

    /// Begins the blocks in an answer of rank 0, or ends the run.
    pub(crate) fn accept(&self, answer: &Answer) {
        let mut state = self.state();
        state.has_more = answer.has_more;
        if !answer.blocks.is_empty() {
            state.is_known_idle = false;
            state.waiting.push_back(answer.blocks.clone());
        }
        state.drop_from(answer.limit);
        state.half = state.waiting_blocks.div_ceil(2).max(1);
        drop(state);
        self.has_blocks.notify_all();
    }

    /// Waits until this rank has to report, or for this time.
    pub(crate) fn wait(&self, time: Duration) {
        let is_quiet = |state: &mut State| !self.has_to_report(state);
        let state = self.state();
        drop(self.is_due.wait_timeout_while(state, time, is_quiet));
    }

    fn has_to_report(&self, state: &State) -> bool {
        let is_low = state.has_more && state.waiting_blocks < self.reserve(state).min(state.half);
        let is_idle = state.waiting_blocks + state.running == 0 && !state.is_known_idle;
        is_low || is_idle || state.stop.is_some()
    }

    /// Returns whether this rank runs so many blocks in less than a time.
    pub(crate) fn is_short(&self, blocks: u64, time: f64) -> bool {
        self.blocks_in(&self.state(), time)
            .is_some_and(|many| blocks < many)
    }

    /// Ends the threads.
    pub(crate) fn end(&self) {
        self.state().has_ended = true;
        self.has_blocks.notify_all();
    }

    /// Removes and returns the error of this rank.
    pub(crate) fn take_error(&self) -> Option<EnsembleError> {
        self.state().error.take()
    }

    /// Runs blocks until the run has ended. Each thread calls this function.
    pub(crate) fn run<I: PathMethod + Sync>(&self, distribution: &Distribution<'_, I>) {
        while let Some(block) = self.begin() {
            let start = Instant::now();
            let ran = catch_unwind(AssertUnwindSafe(|| {
                if distribution.is_stopped() {
                    return Ok(None);
                }
                distribution.run_block(block).map(Some)
            }));
            let (paths, time) = (distribution.paths_of(block..block + 1), start.elapsed());
            self.finish(ran, paths, time);
        }
    }

    /// Waits for a block. Returns `None` at the end of the run.
    fn begin(&self) -> Option<u64> {
        let mut state = self.state();
        loop {
            if state.has_ended {
                return None;
            }
            if let Some(block) = state.next() {
                if self.has_to_report(&state) {
                    self.is_due.notify_one();
                }
                return Some(block);
            }
            let woken = self.has_blocks.wait(state);
            state = woken.unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Takes the outcome of a block.
    fn finish(
        &self,
        ran: Result<Result<Option<PartialResults>, EnsembleError>, Box<dyn Any + Send>>,
        paths: u64,
        time: Duration,
    ) {
        let rank = self.rank;
        let (stop, error) = match ran {
            Ok(Ok(Some(results))) => {
                // Adds the results outside of the lock, and before the block counts as ended.
                self.results.add(results);
                self.state().add_block(paths, time);
                (None, None)
            }
            Ok(Ok(None)) => (Some((0, None)), None),
            Ok(Err(EnsembleError::Failed(failure))) => {
                let limit = failure.path / BLOCK_PATHS + 1;
                (Some((limit, Some(Cause::Failed(failure)))), None)
            }
            Ok(Err(error)) => {
                let message = error.to_string();
                (Some((0, Some(Cause::Error { rank, message }))), Some(error))
            }
            Err(payload) => {
                let message = panic_message(payload.as_ref());
                (Some((0, Some(Cause::Panic { rank, message }))), None)
            }
        };
        let mut state = self.state();
        state.running -= 1;
        if let Some((limit, cause)) = stop {
            state.drop_from(limit);
            add_stop(&mut state.stop, Stop { limit, cause });
        }
        if state.error.is_none() {
            state.error = error;
        }
        if self.has_to_report(&state) {
            self.is_due.notify_one();
        }
    }

    /// Locks the state. A panic of a block is caught outside of the lock, so the state is valid.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Removes and returns the next block.
    fn next(&mut self) -> Option<u64> {
        let range = self.waiting.front_mut()?;
        let block = range.start;
        range.start += 1;
        if range.is_empty() {
            self.waiting.pop_front();
        }
        self.waiting_blocks -= 1;
        self.running += 1;
        Some(block)
    }

    fn add_block(&mut self, paths: u64, time: Duration) {
        self.paths += paths;
        let time = time.as_secs_f64();
        let mean = self.block_time.unwrap_or(time);
        self.block_time = Some(mean + WEIGHT * (time - mean));
    }

    /// Drops the blocks from a limit on, or from an earlier limit that is known.
    fn drop_from(&mut self, limit: u64) {
        let limit = self.limit.map_or(limit, |known| known.min(limit));
        self.limit = Some(limit);
        for range in &mut self.waiting {
            range.end = range.end.min(limit);
        }
        self.waiting.retain(|range| !range.is_empty());
        self.waiting_blocks = (self.waiting.iter())
            .map(|range| range.end - range.start)
            .sum();
    }
}

/// Returns the message of a panic.
pub(crate) fn panic_message(payload: &(dyn Any + Send)) -> String {
    let text = payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    text.unwrap_or_else(|| "a panic without a message".to_owned())
}
