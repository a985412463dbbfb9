//! The decisions of rank 0: the blocks of each rank, the collection of results for a checkpoint,
//! and the end of the run.
//!
//! Input: the reports of all ranks, rank 0 included. Output: answers. Invariant: a rank has an
//! answer, or is idle and waits for it. This file does not use MPI, so that its tests can let any
//! number of ranks report in any order.

use super::message::{Answer, Report, Stop, add_stop};
use super::schedule::{Schedule, Wish};

/// The state of a run on rank 0.
#[derive(Debug)]
pub(crate) struct Coordinator {
    schedule: Schedule,
    ranks: Vec<Rank>,
    /// Ranks that are idle, with all their blocks ended and their answers outstanding.
    idle: usize,
    /// The reason why the run ends early.
    stop: Option<Stop>,
    /// Number of ranks whose results the collection in progress lacks.
    missing: usize,
    /// The results received since they were taken last.
    received: Vec<Vec<u8>>,
}

/// The state of a rank, as far as rank 0 knows it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Rank {
    is_idle: bool,
    collection: Collection,
}

/// The part of a rank in the collection of results in progress.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Collection {
    #[default]
    None,
    /// The next answer asks for results.
    Wanted,
    /// The results will come with the next report.
    Asked,
}

impl Coordinator {
    pub(crate) fn new(schedule: Schedule, ranks: usize) -> Self {
        Self {
            schedule,
            ranks: vec![Rank::default(); ranks],
            idle: 0,
            stop: None,
            missing: 0,
            received: Vec::new(),
        }
    }

    /// Takes the report of a rank. Returns the answer; `None` if the rank is idle and has to wait.
    pub(crate) fn answer(&mut self, rank: usize, report: Report) -> Option<Answer> {
        if self.ranks[rank].is_idle {
            self.ranks[rank].is_idle = false;
            self.idle -= 1;
        }
        if let Some(stop) = report.stop {
            self.schedule.cut(stop.limit);
            add_stop(&mut self.stop, stop);
        }
        if let Some(results) = report.results {
            self.received.push(results);
            if self.ranks[rank].collection == Collection::Asked {
                self.ranks[rank].collection = Collection::None;
                self.missing -= 1;
            }
        }
        let wish = Wish {
            waiting: report.waiting,
            least: report.least,
            wanted: report.wanted,
        };
        let blocks = self.schedule.take(rank, wish);
        let is_idle = blocks.is_empty() && report.unfinished == 0 && self.schedule.is_empty();
        let wants_results = self.ranks[rank].collection == Collection::Wanted;
        if is_idle && !wants_results {
            self.ranks[rank].is_idle = true;
            self.idle += 1;
            return None;
        }
        if wants_results {
            self.ranks[rank].collection = Collection::Asked;
        }
        Some(Answer {
            blocks,
            has_more: !self.schedule.is_empty(),
            limit: self.limit(),
            wants_results,
            has_ended: false,
        })
    }

    /// Returns the number of blocks per rank that have not been handed out.
    pub(crate) fn left_per_rank(&self) -> u64 {
        self.schedule.left_per_rank()
    }

    fn limit(&self) -> u64 {
        self.stop.as_ref().map_or(u64::MAX, |stop| stop.limit)
    }

    /// Begins to collect the results of all ranks but rank 0. Returns the answers to idle ranks.
    pub(crate) fn collect(&mut self) -> Vec<(usize, Answer)> {
        self.missing = self.ranks.len() - 1;
        let mut answers = Vec::new();
        for rank in 1..self.ranks.len() {
            self.ranks[rank].collection = Collection::Wanted;
            if self.ranks[rank].is_idle {
                let again = Report::default();
                answers.extend(self.answer(rank, again).map(|answer| (rank, answer)));
            }
        }
        answers
    }

    /// Returns whether results of a rank are still to come.
    pub(crate) fn is_collecting(&self) -> bool {
        self.missing > 0
    }

    /// Removes and returns the results that ranks have sent.
    pub(crate) fn take_received(&mut self) -> Vec<Vec<u8>> {
        core::mem::take(&mut self.received)
    }

    /// Returns whether all blocks have ended on all ranks.
    pub(crate) fn has_ended(&self) -> bool {
        self.schedule.is_empty() && self.idle == self.ranks.len()
    }

    /// Returns the last answer, which all ranks get.
    pub(crate) fn last_answer(&self) -> Answer {
        Answer {
            blocks: 0..0,
            has_more: false,
            limit: self.limit(),
            wants_results: false,
            has_ended: true,
        }
    }

    /// Returns the reason why the run ended early, if it did.
    pub(crate) fn into_stop(self) -> Option<Stop> {
        self.stop
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::time::Instant;

    use super::{Answer, Coordinator, Report, Schedule, Stop};

    /// A rank that runs its blocks one at a time.
    #[derive(Clone, Default)]
    struct Simulated {
        blocks: Vec<u64>,
        has_more: bool,
        sends_results: bool,
        waits: bool,
    }

    struct Simulation {
        coordinator: Coordinator,
        ranks: Vec<Simulated>,
        done: Vec<u64>,
        /// The numbers of the blocks whose results have not been sent.
        unsent: Vec<Vec<u64>>,
        reports: u64,
    }

    impl Simulation {
        fn new(blocks: u64, ranks: usize) -> Self {
            let schedule = Schedule::new(0..blocks, core::iter::empty(), ranks);
            let rank = Simulated {
                has_more: true,
                ..Simulated::default()
            };
            Self {
                coordinator: Coordinator::new(schedule, ranks),
                ranks: vec![rank; ranks],
                done: Vec::new(),
                unsent: vec![Vec::new(); ranks],
                reports: 0,
            }
        }

        fn accept(&mut self, rank: usize, answer: Answer) {
            let simulated = &mut self.ranks[rank];
            simulated.waits = false;
            simulated.blocks.extend(answer.blocks);
            simulated.blocks.retain(|&block| block < answer.limit);
            simulated.has_more = answer.has_more;
            simulated.sends_results = answer.wants_results;
        }

        /// Lets a rank end a block or report.
        fn turn(&mut self, rank: usize, stop: Option<Stop>) {
            let simulated = &mut self.ranks[rank];
            if simulated.waits {
                return;
            }
            if let Some(block) = simulated.blocks.pop().filter(|_| stop.is_none()) {
                self.done.push(block);
                self.unsent[rank].push(block);
                if !simulated.sends_results && !simulated.blocks.is_empty() {
                    return;
                }
            }
            let of = |block: u64| block.to_le_bytes();
            let report = Report {
                wanted: 8,
                least: 1,
                waiting: simulated.blocks.len() as u64,
                unfinished: simulated.blocks.len() as u64,
                paths: 0,
                stop,
                results: (simulated.sends_results)
                    .then(|| self.unsent[rank].drain(..).flat_map(of).collect()),
            };
            self.reports += 1;
            self.ranks[rank].waits = true;
            if let Some(answer) = self.coordinator.answer(rank, report) {
                self.accept(rank, answer);
            }
        }

        fn collect(&mut self) {
            for (rank, answer) in self.coordinator.collect() {
                self.accept(rank, answer);
            }
        }

        fn received(&mut self) -> Vec<u64> {
            let received = self.coordinator.take_received().concat();
            let words = received.chunks_exact(8);
            words
                .map(|word| u64::from_le_bytes(word.try_into().unwrap()))
                .collect()
        }
    }

    /// Returns turns of ranks in an irregular order.
    fn turns(ranks: usize, seed: u64) -> impl Iterator<Item = usize> {
        let next = |x: &u64| {
            Some(
                x.wrapping_mul(0x5851_f42d_4c95_7f2d)
                    .wrapping_add(0x1405_7b7e_f767_814f),
            )
        };
        let numbers = core::iter::successors(Some(seed), next).take(10_000_000);
        numbers.map(move |x| (x >> 33) as usize % ranks)
    }

    #[test]
    fn every_block_runs_once_and_the_run_ends() {
        for ranks in [1, 2, 3, 8, 50] {
            for blocks in [1, 5, 64, 1000] {
                let mut simulation = Simulation::new(blocks, ranks);
                for rank in turns(ranks, 1) {
                    simulation.turn(rank, None);
                    if simulation.coordinator.has_ended() {
                        break;
                    }
                }
                assert!(simulation.coordinator.has_ended());
                let mut done = simulation.done;
                done.sort_unstable();
                assert_eq!(done, (0..blocks).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn collections_have_all_results_once_and_idle_ranks_answer() {
        for ranks in [2, 5, 16] {
            let mut simulation = Simulation::new(4000, ranks);
            let (mut received, mut collections) = (Vec::new(), 0);
            for (k, rank) in turns(ranks, 2).enumerate() {
                // The last rank is so slow that all other ranks become idle before it.
                if rank + 1 < ranks || k % 11 == 0 {
                    simulation.turn(rank, None);
                }
                if !simulation.coordinator.is_collecting() {
                    let done = simulation.received();
                    received.extend(done);
                    if simulation.coordinator.has_ended() {
                        break;
                    }
                    simulation.collect();
                    collections += 1;
                }
            }
            assert!(simulation.coordinator.has_ended());
            assert!(collections >= 2, "{collections}");
            received.extend(simulation.unsent.concat());
            let once: BTreeSet<u64> = received.iter().copied().collect();
            assert_eq!((received.len(), once.len()), (4000, 4000));
        }
    }

    #[test]
    fn a_stop_keeps_earlier_blocks_and_drops_later_ones() {
        let mut simulation = Simulation::new(300, 4);
        let stop = Stop {
            limit: 100,
            cause: None,
        };
        simulation.turn(1, None);
        simulation.turn(2, Some(stop.clone()));
        for rank in turns(4, 3).take(100_000) {
            simulation.turn(rank, None);
        }
        assert!(simulation.coordinator.has_ended());
        let done: BTreeSet<u64> = simulation.done.iter().copied().collect();
        assert!((0..100).all(|block| done.contains(&block)), "{done:?}");
        // Blocks that the other ranks had begun are done too.
        assert!(done.len() < 140, "{done:?}");
        assert_eq!(simulation.coordinator.into_stop(), Some(stop));
    }

    /// Checks that a report costs little even if rank 0 answers a hundred thousand ranks.
    #[test]
    fn a_report_of_many_ranks_is_cheap() {
        let ranks = 100_000;
        let mut simulation = Simulation::new(16 * ranks as u64, ranks);
        let start = Instant::now();
        'run: loop {
            for rank in 0..ranks {
                simulation.turn(rank, None);
                if simulation.coordinator.has_ended() {
                    break 'run;
                }
            }
        }
        let each = start.elapsed().as_secs_f64() / simulation.reports as f64;
        println!("{} reports, {:.2} µs each", simulation.reports, 1e6 * each);
        assert!(each < 1e-4, "{each}");
        assert_eq!(simulation.done.len(), 16 * ranks);
    }
}
