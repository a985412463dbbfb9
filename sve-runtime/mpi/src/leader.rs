//! The work of rank 0 during a run: it answers the ranks, runs blocks itself, shows the progress
//! and writes checkpoints.

use std::sync::{Mutex, PoisonError};
use std::thread::{Scope, ScopedJoinHandle};
use std::time::Duration;

use sve_runtime::ensemble::PathMethod;
use sve_runtime::ensemble::{Checkpoint, Distribution, PartialResults};

use super::coordinator::Coordinator;
use super::link::Link;
use super::message::{Report, Stop};
use super::pool::{Pool, panic_message};
use super::progress::Progress;

/// Time between two checks for messages. It is short compared with the time of the blocks that a
/// rank has in reserve.
const LOOK: Duration = Duration::from_millis(1);

/// Time between two checks for messages near the end, when ranks have no blocks in reserve.
const SHORT_LOOK: Duration = Duration::from_micros(50);

/// The end is near if the remaining blocks take less than this time, in seconds.
const NEAR_END: f64 = 10e-3;

/// Rank 0 during a run.
pub(crate) struct Leader<'r, I: PathMethod> {
    pub(crate) link: &'r Link,
    pub(crate) pool: &'r Pool,
    pub(crate) distribution: &'r Distribution<'r, I>,
    pub(crate) progress: &'r Progress,
    pub(crate) checkpoint: Option<&'r Checkpoint>,
    /// The results for a checkpoint: all results that ranks have sent.
    pub(crate) gathered: &'r Mutex<PartialResults>,
}

/// A checkpoint that is being written.
type Writing<'s> = ScopedJoinHandle<'s, ()>;

impl<'r, I: PathMethod + Sync> Leader<'r, I> {
    /// Leads the run until all blocks have ended. Returns the reason if it ended early.
    pub(crate) fn lead<'s>(
        &self,
        scope: &'s Scope<'s, '_>,
        mut coordinator: Coordinator,
    ) -> Option<Stop>
    where
        'r: 's,
    {
        let mut writing: Option<Writing<'s>> = None;
        let mut is_collecting = false;
        loop {
            while let Some((rank, report)) = self.link.try_receive::<Report>() {
                self.progress.add(report.paths);
                if let Some(answer) = coordinator.answer(rank.unsigned_abs() as usize, report) {
                    self.link.send(rank, &answer);
                }
            }
            let report = self.pool.report();
            self.progress.add(report.paths);
            let answer = coordinator.answer(0, report);
            let is_idle = answer.is_none();
            if let Some(answer) = answer {
                self.pool.accept(&answer);
            }
            if writing.as_ref().is_some_and(ScopedJoinHandle::is_finished)
                && let Some(ended) = writing.take()
                && let Err(payload) = ended.join()
            {
                panic!("{}", panic_message(payload.as_ref()));
            }
            if is_collecting && !coordinator.is_collecting() {
                is_collecting = false;
                writing = self.write(scope, coordinator.take_received());
            } else if coordinator.has_ended() && !is_collecting && writing.is_none() {
                break;
            }
            let may_collect = !is_collecting && writing.is_none();
            if may_collect && self.checkpoint.is_some_and(Checkpoint::is_due) {
                is_collecting = true;
                for (rank, answer) in coordinator.collect() {
                    self.link.send(rank as i32, &answer);
                }
            }
            let is_near_end = self.pool.is_short(coordinator.left_per_rank(), NEAR_END);
            let looks_often = is_idle || is_near_end;
            self.pool.wait(if looks_often { SHORT_LOOK } else { LOOK });
        }
        let last = coordinator.last_answer();
        for rank in 1..self.link.size() {
            self.link.send(rank, &last);
        }
        coordinator.into_stop()
    }

    /// Writes a checkpoint with all results that ranks have sent and the results of rank 0. Uses a
    /// separate thread, since disks are slow.
    fn write<'s>(&self, scope: &'s Scope<'s, '_>, received: Vec<Vec<u8>>) -> Option<Writing<'s>>
    where
        'r: 's,
    {
        let checkpoint = self.checkpoint?;
        let (pool, distribution, gathered) = (self.pool, self.distribution, self.gathered);
        Some(scope.spawn(move || {
            let mut gathered = gathered.lock().unwrap_or_else(PoisonError::into_inner);
            for bytes in received {
                gathered.merge(received_results(distribution, &bytes));
            }
            gathered.merge(pool.results.take());
            checkpoint.save(&gathered);
        }))
    }
}

/// Reads the results that a rank has sent.
pub(crate) fn received_results<I: PathMethod + Sync>(
    distribution: &Distribution<'_, I>,
    bytes: &[u8],
) -> PartialResults {
    match distribution.results_from(bytes) {
        Some(results) => results,
        None => panic!("a rank sent results that are not of this run"),
    }
}
