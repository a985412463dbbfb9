//! Summaries for serde.
//!
//! Input: what a summary is made of. Output: the summary, or why the parts do not fit together.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::histogram::Bins;
use super::summary::{Info, Summary};
use super::tree::{Node, Tree};
use super::{BLOCK_PATHS, FAILURES_KEPT};

/// What is written of a summary.
#[derive(Serialize)]
struct Parts<'a> {
    run: &'a Info,
    nodes: Vec<&'a Node>,
}

/// What is read.
#[derive(Deserialize)]
struct OwnedParts {
    run: Info,
    nodes: Vec<Node>,
}

impl Serialize for Summary {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let nodes = self.tree.nodes.values().collect();
        let run = &self.info;
        Parts { run, nodes }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Summary {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let OwnedParts { run, nodes } = OwnedParts::deserialize(deserializer)?;
        let mut tree = Tree::new(run.paths.div_ceil(BLOCK_PATHS));
        for node in nodes {
            if !fits(&run, &tree, &node) {
                return Err(D::Error::custom(
                    "the parts of this summary do not fit together",
                ));
            }
            tree.nodes.insert(node.first, node);
        }
        Ok(Self::new(run, tree))
    }
}

/// Whether a node can be one of this run, behind those that are there.
fn fits(run: &Info, tree: &Tree, node: &Node) -> bool {
    let records = run.times.len();
    let after = tree.nodes.values().next_back();
    let from = after.map_or(0, |node| node.first + node.blocks);
    let end = node.first.checked_add(node.blocks);
    let columns = node.columns.iter().all(|column| {
        [&column.mean, &column.squares, &column.min, &column.max]
            .into_iter()
            .all(|values| values.len() == records)
    });
    let bins = |(request, bins): (_, &Bins)| Bins::new(request, records).0.len() == bins.0.len();
    let states = match node.final_paths.len() {
        0 => node.final_states.is_empty(),
        paths => node.final_states.len().is_multiple_of(paths),
    };
    records > 0
        && node.blocks > 0
        && node.first >= from
        && end.is_some_and(|end| end <= tree.blocks)
        && node.level < u64::BITS
        && node.counts.len() == records
        && node.columns.len() == run.names.len()
        && columns
        && node.histograms.len() == run.histograms.len()
        && run.histograms.iter().zip(&node.histograms).all(bins)
        && node.failures.len() <= FAILURES_KEPT
        && states
}
