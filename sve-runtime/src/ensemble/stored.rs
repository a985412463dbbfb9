//! The stored form of summaries, for serde.
//!
//! Input: the stored data of a summary. Output: the summary, or an error if the data are
//! inconsistent. Invariant: consistent data from any source give a summary whose functions do not
//! panic. Data of another format give an error that names the format.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::info::Info;
use super::merge_tree::{MergeTree, PartialResult};
use super::summary::Summary;
use super::{BLOCK_PATHS, FAILURES_KEPT, path_at};

/// Version of the stored form of summaries and checkpoints.
pub(super) const FORMAT: u32 = 6;

/// The version of stored data, which is read only if it is [`FORMAT`].
#[derive(Serialize)]
struct Format(u32);

impl<'de> Deserialize<'de> for Format {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match u32::deserialize(deserializer)? {
            FORMAT => Ok(Self(FORMAT)),
            other => Err(D::Error::custom(format_args!(
                "this summary has format {other}, and this version of sve reads format {FORMAT}; read it with the version that wrote it"
            ))),
        }
    }
}

/// The data that are written. Data without a `format` are of versions before 5, whose lists have
/// other names.
#[derive(Serialize)]
pub(super) struct StoredSummary<'a> {
    format: Format,
    #[serde(rename = "settings")]
    run: &'a Info,
    #[serde(rename = "results")]
    nodes: Vec<&'a PartialResult>,
}

impl<'a> StoredSummary<'a> {
    pub(super) fn new(run: &'a Info, tree: &'a MergeTree) -> Self {
        let nodes = tree.nodes.values().collect();
        Self {
            format: Format(FORMAT),
            run,
            nodes,
        }
    }
}

/// The data that are read.
#[derive(Deserialize)]
pub(super) struct LoadedSummary {
    #[serde(rename = "format")]
    _format: Format,
    #[serde(rename = "settings")]
    pub(super) run: Info,
    #[serde(rename = "results")]
    nodes: Vec<PartialResult>,
}

impl LoadedSummary {
    /// Returns the run and its results, if the data are consistent.
    pub(super) fn checked(self) -> Option<(Info, MergeTree)> {
        let Self { run, nodes, .. } = self;
        if !is_valid(&run) || nodes.is_empty() {
            return None;
        }
        let tree = checked_tree(&run, nodes)?;
        Some((run, tree))
    }
}

/// Returns the tree of nodes of a run, if they are consistent with it.
pub(super) fn checked_tree(run: &Info, nodes: Vec<PartialResult>) -> Option<MergeTree> {
    let mut tree = MergeTree::new(run.paths.div_ceil(BLOCK_PATHS));
    for node in nodes {
        if !fits(run, &tree, &node) {
            return None;
        }
        tree.nodes.insert(node.first, node);
    }
    Some(tree)
}

impl Serialize for Summary {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        StoredSummary::new(&self.info, &self.tree).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Summary {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let parts = LoadedSummary::deserialize(deserializer)?;
        let (run, tree) = parts
            .checked()
            .ok_or_else(|| D::Error::custom("the parts of this summary do not fit together"))?;
        Ok(Self::new(run, tree))
    }
}

fn is_valid(run: &Info) -> bool {
    run.paths > 0
        && run.passage_bins > 0
        && !run.times.is_empty()
        && (run.statistics.iter()).all(|request| request.check(&run.names).is_ok())
}

/// Returns whether a node can belong to this run, after the nodes of the tree.
fn fits(run: &Info, tree: &MergeTree, node: &PartialResult) -> bool {
    let after = tree.nodes.values().next_back();
    let from = after.map_or(0, |node| node.first + node.blocks);
    // the number of blocks from the node to the end of the ensemble
    let left = tree.blocks.checked_sub(node.first);
    let span = 1_u64.checked_shl(node.level);
    let is_of_tree = node.first >= from
        && left.zip(span).is_some_and(|(left, span)| {
            left > 0 && node.first.is_multiple_of(span) && node.blocks == span.min(left)
        });
    if !is_of_tree {
        return false;
    }
    let first = path_at(node.first, run.paths);
    let end = path_at(node.first + node.blocks, run.paths);
    let width = 1 + run.coordinates as u128 + run.momenta as u128;
    let states = node.final_paths.len() as u128 * width == node.final_states.len() as u128;
    let extent = run.extent(end - first);
    let mut statistics = run.statistics.iter().zip(&node.statistics);
    node.counts.len() == run.times.len()
        && node.counts.iter().all(|&count| count <= end - first)
        && node.statistics.len() == run.statistics.len()
        && statistics.all(|(request, own)| own.fits(request, &extent, &node.counts))
        && node.failures.len() as u64 == node.failed.min(FAILURES_KEPT as u64)
        && node.failed <= end - first
        && states
        && node.final_paths.is_sorted()
        && node
            .final_paths
            .iter()
            .all(|path| (first..end).contains(path))
}
