//! Results of blocks of paths, merged pairwise in a fixed tree.
//!
//! Input: results of blocks, in any order. Output: nodes, each the merged results of blocks in a row.
//! Invariant: the node of level `l` over the blocks `i 2ˡ … (i + 1) 2ˡ − 1`, as far as they exist, is the join of the two of
//! level `l − 1`, the lower one first. So what the root has does not depend on the order in which blocks came, on threads or on shards; and of
//! blocks in a row, of which all are there, no more nodes are kept than twice the tree's depth.

use std::collections::BTreeMap;

use super::failure::{FAILURES_KEPT, Failure};
use super::histogram::Bins;
use super::moments::Column;
use super::run::Run;
use crate::method::Method;

/// What is known of the paths of some blocks in a row.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Node {
    /// First block.
    pub(super) first: u64,
    /// Level in the tree.
    pub(super) level: u32,
    /// Blocks of it.
    pub(super) blocks: u64,
    /// Paths that have a part in the statistics, at each recorded time.
    pub(super) counts: Vec<u64>,
    /// One an observable.
    pub(super) columns: Vec<Column>,
    /// One a histogram.
    pub(super) histograms: Vec<Bins>,
    /// Paths that failed.
    pub(super) failed: u64,
    /// The first of them.
    pub(super) failures: Vec<Failure>,
    /// Final states, where they are kept: the path's number for each, and `t`, `q…`, `p…` in a row.
    pub(super) final_paths: Vec<u64>,
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    pub(super) final_states: Vec<f64>,
}

impl Node {
    /// Nothing yet of the paths of a block.
    pub(super) fn new<I: Method>(block: u64, run: &Run<'_, I>) -> Self {
        let requests = run.ensemble.histograms.iter();
        Self {
            first: block,
            level: 0,
            blocks: 1,
            counts: vec![0; run.records],
            columns: vec![Column::new(run.records); run.ensemble.names.len()],
            histograms: requests.map(|r| Bins::new(r, run.records)).collect(),
            failed: 0,
            failures: Vec::new(),
            final_paths: Vec::new(),
            final_states: Vec::new(),
        }
    }

    /// Adds what the next blocks have.
    pub(super) fn join(&mut self, next: &Self) {
        for (column, other) in self.columns.iter_mut().zip(&next.columns) {
            column.merge(&self.counts, other, &next.counts);
        }
        for (count, other) in self.counts.iter_mut().zip(&next.counts) {
            *count += other;
        }
        for (bins, other) in self.histograms.iter_mut().zip(&next.histograms) {
            bins.merge(other);
        }
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

/// The nodes that could not be joined yet, by their first block.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tree {
    /// Blocks of the whole ensemble.
    pub(super) blocks: u64,
    pub(super) nodes: BTreeMap<u64, Node>,
}

impl Tree {
    pub(super) fn new(blocks: u64) -> Self {
        Self {
            blocks,
            nodes: BTreeMap::new(),
        }
    }

    /// Takes a node in, or gives back the one to join it with, before or after it.
    pub(super) fn place(&mut self, node: &mut Option<Node>) -> Option<Node> {
        let new = node.as_mut()?;
        loop {
            let span = 1 << new.level;
            if span >= self.blocks {
                break;
            }
            let even = new.first / span % 2 == 0;
            if even && new.first + span >= self.blocks {
                // nothing follows at the end of the ensemble
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

    /// Takes a node in and joins what can be joined.
    pub(super) fn insert(&mut self, node: Node) {
        let mut node = Some(node);
        while let Some(other) = self.place(&mut node) {
            node = node.map(|node| joined(node, other));
        }
    }

    /// Whether a block is in one of the nodes.
    pub(super) fn has(&self, block: u64) -> bool {
        self.nodes
            .range(..=block)
            .next_back()
            .is_some_and(|(first, node)| block < first + node.blocks)
    }
}

/// Two nodes, the one that comes first and the other.
pub(super) fn joined(a: Node, b: Node) -> Node {
    let (mut left, right) = if a.first < b.first { (a, b) } else { (b, a) };
    left.join(&right);
    left
}
