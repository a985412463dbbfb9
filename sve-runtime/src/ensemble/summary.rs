//! What is known of an ensemble after a run.
//!
//! Input: the nodes of a tree. Output: statistics by name, at each recorded time. Invariant: a whole run has one node; the
//! numbers shown of several are their merge from left to right.

use core::fmt;
use core::ops::Index;

use super::failure::Failure;
use super::histogram::{Bins, Request};
use super::moments::Column;
use super::statistics::{Histogram, Statistics};
use super::tree::{Node, Tree};
use super::{BLOCK_PATHS, EnsembleError};
use crate::state::State;

/// What summaries of the same run have in common.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Info {
    pub(super) names: Vec<String>,
    pub(super) histograms: Vec<Request>,
    pub(super) times: Vec<f64>,
    pub(super) paths: u64,
    pub(super) fingerprint: u64,
}

/// Statistics of the paths of an [`Ensemble`](super::Ensemble): of all, or of the shards merged so far.
#[derive(Clone)]
pub struct Summary {
    pub(super) info: Info,
    pub(super) tree: Tree,
    statistics: Vec<Statistics>,
    histograms: Vec<Histogram>,
    counts: Vec<u64>,
    failed: u64,
    failures: Vec<Failure>,
}

impl Info {
    /// Whether another summary is of the same run.
    pub(super) fn same_run(&self, other: &Self) -> Result<(), EnsembleError> {
        let same = [
            (self.names == other.names, "observables"),
            (self.histograms == other.histograms, "histograms"),
            (self.times == other.times, "recorded times"),
            (self.paths == other.paths, "number of paths"),
            (
                self.fingerprint == other.fingerprint,
                "seed, noise, start, parameters, method or observables",
            ),
        ];
        match same.into_iter().find(|(same, _)| !same) {
            None => Ok(()),
            Some((_, what)) => Err(EnsembleError::OtherRun { what }),
        }
    }
}

impl Summary {
    pub(super) fn new(info: Info, tree: Tree) -> Self {
        let mut nodes = tree.nodes.values();
        let whole = nodes.next().cloned().map(|first| {
            nodes.fold(first, |mut whole, node| {
                whole.join(node);
                whole
            })
        });
        let mut summary = Self {
            statistics: Vec::new(),
            histograms: Vec::new(),
            counts: vec![0; info.times.len()],
            failed: 0,
            failures: Vec::new(),
            info,
            tree,
        };
        if let Some(whole) = whole {
            summary.show(whole);
        } else {
            summary.show_nothing();
        }
        summary
    }

    fn show(&mut self, node: Node) {
        let columns = self.info.names.iter().zip(node.columns);
        self.statistics = columns
            .map(|(name, column)| Statistics::new(name.clone(), node.counts.clone(), column))
            .collect();
        let bins = self.info.histograms.iter().zip(node.histograms);
        self.histograms = bins
            .map(|(request, bins)| Histogram::new(request.clone(), bins))
            .collect();
        self.counts = node.counts;
        self.failed = node.failed;
        self.failures = node.failures;
    }

    /// No paths, where a shard has none.
    fn show_nothing(&mut self) {
        let records = self.info.times.len();
        let names = self.info.names.iter();
        self.statistics = names
            .map(|name| Statistics::new(name.clone(), vec![0; records], Column::new(records)))
            .collect();
        let requests = self.info.histograms.iter();
        self.histograms = requests
            .map(|request| Histogram::new(request.clone(), Bins::new(request, records)))
            .collect();
    }

    /// The recorded times: the start, the time after each `record_every` steps, and the end.
    pub fn times(&self) -> &[f64] {
        &self.info.times
    }

    /// How many paths were run, those that failed among them.
    pub fn paths(&self) -> u64 {
        let of = |node: &Node| {
            let end = ((node.first + node.blocks) * BLOCK_PATHS).min(self.info.paths);
            end - node.first * BLOCK_PATHS
        };
        self.tree.nodes.values().map(of).sum()
    }

    /// Whether these are all paths of the ensemble, not only those of some shards.
    pub fn is_complete(&self) -> bool {
        self.paths() == self.info.paths
    }

    /// How many paths are in the statistics, at each recorded time: those that have not failed until then.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// How many paths failed.
    pub fn failed(&self) -> u64 {
        self.failed
    }

    /// The failures of the lowest paths, at most [`FAILURES_KEPT`](super::FAILURES_KEPT), in their order.
    pub fn failures(&self) -> &[Failure] {
        &self.failures
    }

    /// The statistics of an observable; `summary["name"]` is the same for a name that is known to be there.
    pub fn get(&self, name: &str) -> Option<&Statistics> {
        self.statistics.iter().find(|s| s.name() == name)
    }

    /// The statistics of all observables, in the order in which they were given.
    pub fn statistics(&self) -> &[Statistics] {
        &self.statistics
    }

    /// The histograms, in the order in which they were asked for.
    pub fn histograms(&self) -> &[Histogram] {
        &self.histograms
    }

    /// The first histogram of an observable.
    pub fn histogram(&self, name: &str) -> Option<&Histogram> {
        self.histograms.iter().find(|h| h.name() == name)
    }

    /// The final states of the paths that did not fail, with their numbers, in their order; none unless
    /// [`keep_final_states`](super::Ensemble::keep_final_states) was asked for.
    ///
    /// # Panics
    /// Where `N` is not the system's number of coordinates.
    pub fn final_states<const N: usize>(&self) -> impl Iterator<Item = (u64, State<N>)> {
        self.tree.nodes.values().flat_map(|node| {
            let (paths, width) = (&node.final_paths, 2 * N + 1);
            let numbers = node.final_states.len();
            assert!(
                numbers == paths.len() * width,
                "final states of {} numbers each are not those of {N} coordinates",
                numbers / paths.len().max(1)
            );
            let state = |row: &[f64]| {
                let (q, p) = row[1..].split_at(N);
                let of = |x: &[f64]| core::array::from_fn(|i| x[i]);
                State::at(row[0], of(q), of(p))
            };
            let rows = node.final_states.chunks_exact(width).map(state);
            paths.iter().copied().zip(rows)
        })
    }

    /// Adds the paths of another shard of the same run.
    ///
    /// Shards may be merged in any order; all together give the bits of the whole run.
    ///
    /// # Errors
    /// [`EnsembleError::OtherRun`] where the settings differ, [`EnsembleError::Overlap`] where paths are in both; nothing is
    /// merged then.
    pub fn merge(&mut self, other: Self) -> Result<(), EnsembleError> {
        self.info.same_run(&other.info)?;
        let blocks = |node: &Node| node.first..node.first + node.blocks;
        let nodes = other.tree.nodes.values();
        if let Some(block) = nodes.flat_map(blocks).find(|&block| self.tree.has(block)) {
            let first = block * BLOCK_PATHS;
            let last = (first + BLOCK_PATHS).min(self.info.paths) - 1;
            return Err(EnsembleError::Overlap { first, last });
        }
        for node in other.tree.nodes.into_values() {
            self.tree.insert(node);
        }
        let blocks = self.tree.blocks;
        let tree = core::mem::replace(&mut self.tree, Tree::new(blocks));
        *self = Self::new(self.info.clone(), tree);
        Ok(())
    }
}

/// Equal where all they know is equal: settings, statistics, failures, final states.
impl PartialEq for Summary {
    fn eq(&self, other: &Self) -> bool {
        self.info == other.info && self.tree == other.tree
    }
}

impl Index<&str> for Summary {
    type Output = Statistics;

    /// The statistics of an observable.
    ///
    /// # Panics
    /// Where there is none of that name; [`get`](Summary::get) returns `None` then.
    fn index(&self, name: &str) -> &Statistics {
        match self.get(name) {
            Some(statistics) => statistics,
            None => panic!(
                "there is no observable `{name}`; there are {:?}",
                self.info.names
            ),
        }
    }
}

impl fmt::Debug for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Summary")
            .field("paths", &self.paths())
            .field("failed", &self.failed)
            .field("times", &self.info.times.len())
            .field("observables", &self.info.names)
            .finish_non_exhaustive()
    }
}

impl fmt::Display for Summary {
    /// A short table: each observable at the end.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (paths, failed) = (self.paths(), self.failed);
        write!(f, "{paths} paths")?;
        if !self.is_complete() {
            write!(f, " of {}", self.info.paths)?;
        }
        if failed > 0 {
            write!(f, ", of which {failed} failed")?;
        }
        if let Some(t) = self.info.times.last() {
            write!(f, ", at t = {t}")?;
        }
        let width = self.info.names.iter().map(|n| n.chars().count()).max();
        let width = width.unwrap_or(0);
        for s in &self.statistics {
            let last = |values: &[f64]| values.last().copied().unwrap_or(f64::NAN);
            write!(
                f,
                "\n  {:width$}  {:.6e} ± {:.1e}, from {:.6e} to {:.6e}",
                s.name(),
                last(s.mean()),
                last(&s.standard_error()),
                last(s.min()),
                last(s.max())
            )?;
        }
        if let Some(first) = self.failures.first() {
            write!(f, "\n  first failure: {first}")?;
        }
        Ok(())
    }
}
