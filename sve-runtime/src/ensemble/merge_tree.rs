//! The merge tree: partial results of consecutive blocks, merged pairwise in a fixed order.
//!
//! Input: results of blocks, in any order. Output: partial results, each of consecutive blocks.
//! Invariant: the node of level `l` over the blocks `i 2ˡ … (i + 1) 2ˡ − 1`, as far as they exist,
//! is the merge of its two nodes of level `l − 1`, the lower one first. So the root does not depend
//! on the order of the blocks, on threads or on shards. For consecutive blocks without gaps, the
//! number of nodes that are kept is at most twice the number of levels of the tree.

use std::collections::BTreeMap;
use std::sync::Mutex;

use super::execution::locked;
use super::failure::{FAILURES_KEPT, Failure};
use super::statistic::{AnyRequest, AnyStatistic, Extent, Recorded};
use crate::lanes::{Lane, Mask};

/// The merged results of consecutive blocks: a node of the tree.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct PartialResult {
    /// First block.
    pub(super) first: u64,
    /// Level in the tree.
    pub(super) level: u32,
    /// Number of blocks.
    pub(super) blocks: u64,
    /// Number of paths in the statistics, at each recorded time.
    pub(super) counts: Vec<u64>,
    /// The statistics of the run, in the order of their requests.
    pub(super) statistics: Vec<AnyStatistic>,
    /// Number of steps that were made in smaller steps.
    pub(super) refined: u64,
    /// Number of paths that failed.
    pub(super) failed: u64,
    /// The first failures.
    pub(super) failures: Vec<Failure>,
    /// Final states, if they are kept: the number of each path, and `t`, `q…`, `p…` in a row.
    pub(super) final_paths: Vec<u64>,
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    pub(super) final_states: Vec<f64>,
}

impl PartialResult {
    /// The empty result of a block.
    pub(super) fn new(block: u64, requests: &[AnyRequest], extent: &Extent<'_>) -> Self {
        let empty = requests.iter().map(|request| request.empty(extent));
        Self {
            first: block,
            level: 0,
            blocks: 1,
            counts: vec![0; extent.rows()],
            statistics: empty.collect(),
            refined: 0,
            failed: 0,
            failures: Vec::new(),
            final_paths: Vec::new(),
            final_states: Vec::new(),
        }
    }

    /// Removes the statistics that are not taken of the differences of runs.
    pub(super) fn of_differences(mut self) -> Self {
        self.statistics.retain(AnyStatistic::is_of_differences);
        self
    }

    /// Adds the observables of a tile at a recorded time, with the observables at the recorded
    /// times before if a statistic needs them.
    pub(super) fn add(&mut self, record: usize, values: &[Lane], lanes: Mask, history: &[&[Lane]]) {
        let at = Recorded {
            record,
            counts: &self.counts,
            values,
            lanes,
            history,
        };
        for statistic in &mut self.statistics {
            statistic.add(&at);
        }
        self.counts[record] += u64::from(lanes.count_ones());
    }

    /// Adds the results of the next blocks.
    pub(super) fn merge(&mut self, next: &Self) {
        for (statistic, other) in self.statistics.iter_mut().zip(&next.statistics) {
            statistic.merge(&self.counts, other, &next.counts);
        }
        for (count, other) in self.counts.iter_mut().zip(&next.counts) {
            *count += other;
        }
        self.refined = self.refined.saturating_add(next.refined);
        self.failed += next.failed;
        let room = FAILURES_KEPT - self.failures.len();
        self.failures
            .extend(next.failures.iter().take(room).cloned());
        self.final_paths.extend_from_slice(&next.final_paths);
        self.final_states.extend_from_slice(&next.final_states);
        self.blocks += next.blocks;
        self.level += 1;
    }
}

/// The partial results that cannot be merged yet, by their first block.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MergeTree {
    /// Number of blocks of the whole ensemble.
    pub(super) blocks: u64,
    pub(super) nodes: BTreeMap<u64, PartialResult>,
}

impl MergeTree {
    pub(super) fn new(blocks: u64) -> Self {
        Self {
            blocks,
            nodes: BTreeMap::new(),
        }
    }

    /// Inserts a node, or removes and returns the neighbour to merge it with.
    pub(super) fn place(&mut self, node: &mut Option<PartialResult>) -> Option<PartialResult> {
        let new = node.as_mut()?;
        loop {
            let span = 1 << new.level;
            if span >= self.blocks {
                break;
            }
            let even = new.first / span % 2 == 0;
            if even && new.first + span >= self.blocks {
                // The last node of a level has no neighbour: it becomes a node of the next level.
                new.level += 1;
                continue;
            }
            let other = if even {
                new.first + span
            } else {
                new.first - span
            };
            if self.nodes.get(&other).is_some_and(|o| o.level == new.level) {
                return self.nodes.remove(&other);
            }
            break;
        }
        let first = new.first;
        self.nodes.extend(node.take().map(|node| (first, node)));
        None
    }

    /// Inserts a node and merges all nodes that can be merged.
    pub(super) fn insert(&mut self, node: PartialResult) {
        let mut node = Some(node);
        while let Some(other) = self.place(&mut node) {
            node = node.map(|node| merged(node, other));
        }
    }

    /// Returns whether a block is in one of the nodes.
    pub(super) fn has(&self, block: u64) -> bool {
        self.nodes
            .range(..=block)
            .next_back()
            .is_some_and(|(first, node)| block < first + node.blocks)
    }
}

/// Inserts a node into a tree that threads share, and merges all nodes that can be merged. Nodes
/// are merged outside of the lock.
pub(super) fn insert_shared(tree: &Mutex<MergeTree>, node: PartialResult) {
    let mut node = Some(node);
    loop {
        let other = locked(tree).place(&mut node);
        match (node.take(), other) {
            (Some(new), Some(other)) => node = Some(merged(new, other)),
            _ => return,
        }
    }
}

/// Merges two nodes in the order of their blocks.
pub(super) fn merged(a: PartialResult, b: PartialResult) -> PartialResult {
    let (mut left, right) = if a.first < b.first { (a, b) } else { (b, a) };
    left.merge(&right);
    left
}
