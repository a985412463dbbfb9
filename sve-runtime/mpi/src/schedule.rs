//! The distribution of blocks over ranks.
//!
//! Input: the blocks to run, and requests of ranks. Output: ranges of blocks. Invariant: each block
//! is handed out once.
//!
//! Each rank has a region of consecutive blocks and takes ranges from its front, so that nearly all
//! results merge where they are computed. A rank whose region is empty takes ranges from the back
//! of the largest region. Ranges end or begin at multiples of a power of two near their length, so
//! that the results of a range are few nodes of the tree. Toward the end ranges get shorter (guided
//! self-scheduling).
//!
//! Source: C. D. Polychronopoulos, D. J. Kuck, *Guided self-scheduling*, IEEE Transactions on
//! Computers C-36 (1987).

use core::ops::Range;
use std::collections::{BTreeSet, VecDeque};

/// A range has at most this fraction, one over `PARTS`, of a rank's share of the remaining blocks.
const PARTS: u64 = 4;

/// A range of the rank's own region has at least this fraction, one over `LEAST_PARTS`, of the
/// blocks that are worth a message.
const LEAST_PARTS: u64 = 8;

/// Borders of regions are multiples of a power of two, which is about a region divided by this
/// number.
const BORDER: u64 = 16;

/// The request of a rank.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wish {
    /// Number of blocks that wait at the rank.
    pub(crate) waiting: u64,
    /// Number of blocks below which a message is not worth its cost.
    pub(crate) least: u64,
    /// Number of blocks that the rank wants to have waiting.
    pub(crate) wanted: u64,
}

/// The blocks that have not been handed out.
#[derive(Debug)]
pub(crate) struct Schedule {
    /// The region of each rank.
    regions: Vec<VecDeque<Range<u64>>>,
    /// The number of blocks of each region, with its rank.
    sizes: BTreeSet<(u64, usize)>,
    /// Number of blocks in all regions.
    left: u64,
}

impl Schedule {
    /// Divides the blocks among ranks, except those whose results exist already; these are in
    /// order.
    pub(crate) fn new(
        blocks: Range<u64>,
        done: impl Iterator<Item = Range<u64>>,
        ranks: usize,
    ) -> Self {
        let mut missing = Vec::new();
        let mut next = blocks.start;
        for range in done {
            missing.push(next..range.start);
            next = range.end;
        }
        missing.push(next..blocks.end);
        missing.retain(|range| !range.is_empty());
        let left: u64 = missing.iter().map(length).sum();
        let mut schedule = Self {
            regions: vec![VecDeque::new(); ranks],
            sizes: (0..ranks).map(|rank| (0, rank)).collect(),
            left: 0,
        };
        let unit = power_of_two(left / (ranks as u64 * BORDER));
        let (mut rank, mut before) = (0, 0);
        for mut range in missing {
            while !range.is_empty() {
                // The region of this rank ends after this number of missing blocks.
                let end = u128::from(left) * (rank as u128 + 1) / ranks as u128;
                let room = (end as u64).saturating_sub(before);
                let border = (range.start.saturating_add(room)).next_multiple_of(unit);
                let cut = border.min(range.end);
                let is_last = rank + 1 == ranks;
                let cut = if is_last { range.end } else { cut };
                schedule.push(rank, range.start..cut);
                before += cut - range.start;
                range.start = cut;
                if before >= end as u64 && !is_last {
                    rank += 1;
                }
            }
        }
        schedule
    }

    fn push(&mut self, rank: usize, range: Range<u64>) {
        if range.is_empty() {
            return;
        }
        let size = self.size(rank);
        self.resize(rank, size, size + length(&range));
        self.left += length(&range);
        self.regions[rank].push_back(range);
    }

    fn size(&self, rank: usize) -> u64 {
        self.regions[rank].iter().map(length).sum()
    }

    fn resize(&mut self, rank: usize, old: u64, new: u64) {
        self.sizes.remove(&(old, rank));
        self.sizes.insert((new, rank));
    }

    /// Returns whether every block has been handed out.
    pub(crate) fn is_empty(&self) -> bool {
        self.left == 0
    }

    /// Returns the number of remaining blocks per rank.
    pub(crate) fn left_per_rank(&self) -> u64 {
        self.left / self.regions.len() as u64
    }

    /// Removes and returns consecutive blocks for a rank, so that up to `wanted` blocks wait at the
    /// rank; `waiting` blocks wait there already. Toward the end the number is smaller, but up to
    /// `least` from the rank's own region. Returns an empty range if the rank has enough blocks, or
    /// if no blocks remain.
    pub(crate) fn take(
        &mut self,
        rank: usize,
        Wish {
            waiting,
            least,
            wanted,
        }: Wish,
    ) -> Range<u64> {
        let share = self.left_per_rank() / PARTS;
        let own = self.size(rank);
        // Blocks may take longer than the blocks that the rank has seen, so even `least` blocks are
        // only a part of a region.
        let least = least.min(own.div_ceil(2).max(least / LEAST_PARTS));
        let least = if own > 0 { least.max(1) } else { 1 };
        let wanted = wanted.min(share.max(least)).saturating_sub(waiting);
        if wanted == 0 || self.left == 0 {
            return 0..0;
        }
        let (victim, size) = if own > 0 {
            (rank, own)
        } else {
            let Some(&(size, victim)) = self.sizes.last() else {
                return 0..0;
            };
            (victim, size)
        };
        let region = &mut self.regions[victim];
        let taken = if victim == rank {
            region.pop_front().map(|range| {
                let cut = front(&range, wanted);
                if cut < range.end {
                    region.push_front(cut..range.end);
                }
                range.start..cut
            })
        } else {
            region.pop_back().map(|range| {
                let cut = back(&range, wanted);
                if range.start < cut {
                    region.push_back(range.start..cut);
                }
                cut..range.end
            })
        };
        let taken = taken.unwrap_or(0..0);
        self.resize(victim, size, size - length(&taken));
        self.left -= length(&taken);
        taken
    }

    /// Removes all blocks from this one on.
    pub(crate) fn cut(&mut self, limit: u64) {
        for rank in 0..self.regions.len() {
            let old = self.size(rank);
            for range in &mut self.regions[rank] {
                range.end = range.end.min(limit);
                range.start = range.start.min(range.end);
            }
            self.regions[rank].retain(|range| !range.is_empty());
            let new = self.size(rank);
            self.resize(rank, old, new);
            self.left -= old - new;
        }
    }
}

fn length(range: &Range<u64>) -> u64 {
    range.end - range.start
}

/// Returns the largest power of two that is not above a number, or 1.
fn power_of_two(x: u64) -> u64 {
    x.max(1).next_power_of_two() >> u32::from(!x.max(1).is_power_of_two())
}

/// Returns the place where a range is cut to take up to so many blocks from its front.
fn front(range: &Range<u64>, wanted: u64) -> u64 {
    if wanted >= length(range) {
        return range.end;
    }
    let (end, unit) = (range.start + wanted, power_of_two(wanted));
    let aligned = end / unit * unit;
    if aligned > range.start { aligned } else { end }
}

/// Returns the place where a range is cut to take up to so many blocks from its back.
fn back(range: &Range<u64>, wanted: u64) -> u64 {
    if wanted >= length(range) {
        return range.start;
    }
    let (start, unit) = (range.end - wanted, power_of_two(wanted));
    let aligned = start.next_multiple_of(unit);
    if aligned < range.end { aligned } else { start }
}

#[cfg(test)]
mod tests {
    use core::ops::Range;

    use super::{Schedule, Wish, power_of_two};

    fn wish(least: u64, wanted: u64) -> Wish {
        Wish {
            waiting: 0,
            least,
            wanted,
        }
    }

    /// A generator of small numbers, the same on every run.
    fn numbers(mut seed: u64) -> impl FnMut(u64) -> u64 {
        move |below| {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) % below
        }
    }

    fn handed_out(schedule: &mut Schedule, ranks: usize, seed: u64) -> Vec<u64> {
        let mut random = numbers(seed);
        let mut blocks = Vec::new();
        while !schedule.is_empty() {
            let rank = random(ranks as u64) as usize;
            let range = schedule.take(rank, wish(random(4), random(20)));
            blocks.extend(range);
        }
        blocks.sort_unstable();
        blocks
    }

    #[test]
    fn every_missing_block_is_handed_out_once() {
        let done: [&[Range<u64>]; 3] = [&[], &[3..7, 7..8, 20..31], &[0..2, 2..32]];
        for ranks in [1, 2, 3, 4, 7, 100] {
            for (seed, blocks) in [(1, 0..1), (2, 0..1000), (3, 17..333), (4, 0..64)] {
                for done in done {
                    let done = done
                        .iter()
                        .filter(|range| blocks.contains(&range.start) && range.end <= blocks.end);
                    let done: Vec<_> = done.cloned().collect();
                    let missing = |block: &u64| !done.iter().any(|range| range.contains(block));
                    let expected: Vec<u64> = blocks.clone().filter(missing).collect();
                    let mut schedule = Schedule::new(blocks.clone(), done.iter().cloned(), ranks);
                    assert_eq!(handed_out(&mut schedule, ranks, seed), expected);
                    assert_eq!(schedule.take(0, wish(1, 5)), 0..0);
                }
            }
        }
    }

    #[test]
    fn regions_have_equal_sizes() {
        for ranks in [2, 3, 48, 1000] {
            let schedule = Schedule::new(0..1_562_500, core::iter::empty(), ranks);
            let share = 1_562_500.0 / ranks as f64;
            for rank in 0..ranks {
                let size = schedule.size(rank) as f64;
                assert!((size / share - 1.0).abs() < 0.15, "{rank} {size} {share}");
            }
        }
    }

    #[test]
    fn a_limit_removes_later_blocks_alone() {
        for limit in [0, 1, 50, 99, 200] {
            let mut schedule = Schedule::new(0..100, core::iter::once(40..45), 3);
            schedule.cut(limit);
            let expected: Vec<u64> = (0..limit.min(100))
                .filter(|block| !(40..45).contains(block))
                .collect();
            assert_eq!(handed_out(&mut schedule, 3, 9), expected);
        }
    }

    /// Checks that a rank that works alone on its region takes neighbouring ranges. Ranges get
    /// short at the end, so that other ranks can share them.
    #[test]
    fn ranges_are_neighbours_and_shrink() {
        let mut schedule = Schedule::new(0..4096, core::iter::empty(), 2);
        let (mut end, mut last) = (0, u64::MAX);
        for _ in 0..8 {
            let range = schedule.take(0, wish(1, 300));
            assert_eq!(range.start, end);
            let length = range.end - range.start;
            assert!(length <= 300 && length <= last.max(256), "{range:?}");
            (end, last) = (range.end, length);
        }
        while !schedule.is_empty() {
            let range = schedule.take(1, wish(1, 300));
            last = range.end - range.start;
        }
        assert_eq!(last, 1);
    }

    /// Checks that a rank whose first blocks were fast does not take the slow blocks of other
    /// ranks, however often it asks.
    #[test]
    fn a_rank_with_blocks_gets_no_more_than_its_share() {
        let mut schedule = Schedule::new(0..256, core::iter::empty(), 2);
        let mut held = 0;
        for _ in 0..1000 {
            let wish = Wish {
                waiting: held,
                least: 100,
                wanted: 5000,
            };
            let range = schedule.take(0, wish);
            held += range.end - range.start;
        }
        assert!((32..=100).contains(&held), "{held}");
    }

    #[test]
    fn powers_of_two() {
        let powers = [0, 1, 2, 3, 4, 7, 8, 9].map(power_of_two);
        assert_eq!(powers, [1, 1, 2, 2, 4, 4, 8, 8]);
    }
}
