//! The merge tree: partial results of consecutive blocks, merged pairwise in a fixed order.
//!
//! Input: results of blocks, in any order. Output: partial results, each of consecutive blocks.
//! Invariant: the node of level `l` over the blocks `i 2ˡ … (i + 1) 2ˡ − 1`, as far as they exist, is the merge of the two of
//! level `l − 1`, the lower one first. So the root does not depend on the order of the blocks, on threads or on shards. For
//! consecutive blocks without gaps, at most twice as many nodes are kept as the tree has levels.

use std::collections::BTreeMap;
use std::sync::Mutex;

use super::Ensemble;
use super::antithetic::Pairs;
use super::execution::locked;
use super::failure::{FAILURES_KEPT, Failure};
use super::histogram::Bins;
use super::joint::JointColumn;
use super::moments::Column;
use super::passage::counts::PassageCounts;
use super::sketch::SketchColumn;
use crate::lanes::{Lane, Mask};
use crate::method::Method;

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
    /// Statistics of each observable.
    pub(super) columns: Vec<Column>,
    /// Counts of each histogram.
    pub(super) histograms: Vec<Bins>,
    /// Joint moments of pairs of observables.
    pub(super) joints: Vec<JointColumn>,
    /// Sketches of observables.
    pub(super) quantiles: Vec<SketchColumn>,
    /// Statistics of the means of antithetic pairs; no counts and no columns without such pairs.
    pub(super) pairs: Pairs,
    /// Counts of the passages of each function.
    pub(super) passages: Vec<PassageCounts>,
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
    pub(super) fn new<I: Method>(block: u64, records: usize, ensemble: &Ensemble<'_, I>) -> Self {
        let observables = ensemble.names.len();
        let requests = ensemble.histograms.iter();
        let joints = ensemble.joints.iter();
        let quantiles = ensemble.quantiles.iter();
        let pairs = if ensemble.antithetic {
            Pairs::new(records, observables)
        } else {
            Pairs::default()
        };
        Self {
            first: block,
            level: 0,
            blocks: 1,
            counts: vec![0; records],
            columns: vec![Column::new(records); observables],
            histograms: requests.map(|r| Bins::new(r, records)).collect(),
            joints: joints.map(|r| JointColumn::new(r, records)).collect(),
            quantiles: quantiles.map(|r| SketchColumn::new(r, records)).collect(),
            pairs,
            passages: Vec::new(),
            refined: 0,
            failed: 0,
            failures: Vec::new(),
            final_paths: Vec::new(),
            final_states: Vec::new(),
        }
    }

    /// Removes what is not a mean of observables: histograms, covariances, quantiles and passages.
    pub(super) fn without_distributions(self) -> Self {
        Self {
            histograms: Vec::new(),
            joints: Vec::new(),
            quantiles: Vec::new(),
            passages: Vec::new(),
            ..self
        }
    }

    /// Adds the observables of a tile at a recorded time.
    pub(super) fn add(&mut self, record: usize, values: &[Lane], lanes: Mask) {
        let count = self.counts[record];
        for (column, values) in self.columns.iter_mut().zip(values) {
            column.add(record, count, values, lanes);
        }
        self.pairs.add(record, values, lanes);
        self.counts[record] += u64::from(lanes.count_ones());
    }

    /// Adds the results of the next blocks.
    pub(super) fn merge(&mut self, next: &Self) {
        self.pairs.merge(&next.pairs);
        for (column, other) in self.joints.iter_mut().zip(&next.joints) {
            column.merge(&self.counts, other, &next.counts);
        }
        for (column, other) in self.quantiles.iter_mut().zip(&next.quantiles) {
            column.merge(other);
        }
        for (column, other) in self.columns.iter_mut().zip(&next.columns) {
            column.merge(&self.counts, other, &next.counts);
        }
        for (count, other) in self.counts.iter_mut().zip(&next.counts) {
            *count += other;
        }
        for (bins, other) in self.histograms.iter_mut().zip(&next.histograms) {
            bins.merge(other);
        }
        for (counts, other) in self.passages.iter_mut().zip(&next.passages) {
            counts.merge(other);
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

/// Inserts a node into a tree that threads share, and merges all nodes that can be merged. Nodes are merged outside of the lock.
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
