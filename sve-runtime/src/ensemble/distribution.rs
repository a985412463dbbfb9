//! A run whose blocks are distributed over processes by another program, such as the package
//! `sve-mpi`.
//!
//! Input: an [`Ensemble`]. Output: results of single blocks, their merge, and the summary.
//! Invariant: results of blocks merge in the tree of the ensemble, so the summary has the bits of
//! [`Ensemble::run`], whoever runs a block and in whatever order results merge.

use core::fmt;
use core::ops::Range;
use std::sync::Mutex;

use serde::{Deserialize, Serialize};

use super::checkpoint::CheckpointFile;
use super::difference::Difference;
use super::execution::locked;
use super::info::Info;
use super::merge_tree::{MergeTree, PartialResult, insert_shared};
use super::settings::Settings;
use super::stored::checked_tree;
use super::summary::Summary;
use super::{BLOCK_PATHS, Ensemble, EnsembleError, Warning};
use crate::ensemble::PathMethod;

/// The settings of a run, which two processes compare before they run blocks of the same ensemble.
#[derive(Serialize, Deserialize)]
struct Identity {
    info: Info,
    shard: [u64; 2],
    stop_on_failure: bool,
}

/// An ensemble with checked settings, whose blocks of [`BLOCK_PATHS`] paths can be run anywhere.
/// From [`Ensemble::distribute`].
///
/// ```
/// use sve_runtime::prelude::*;
///
/// struct Oscillator;
///
/// #[variational(endpoint)]
/// impl Oscillator {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
///     #[gamma]
///     fn push(&self, q: f64) -> f64 { q }
/// }
///
/// # fn main() -> Result<(), EnsembleError> {
/// let integrator = Integrator::new(Oscillator, Endpoint);
/// let ensemble = Ensemble::new(&integrator)
///     .paths(1000).steps(0.1, 20)
///     .start(State::new([1.0], [0.0]))
///     .observe("q", |_, state| state.q[0]);
/// let distribution = ensemble.distribute()?;
/// // two processes, each with some of the blocks, in any order
/// let (here, there) = (distribution.no_results(), distribution.no_results());
/// for block in distribution.blocks().rev() {
///     let of = if block % 3 == 0 { &here } else { &there };
///     of.add(distribution.run_block(block)?);
/// }
/// let message = there.take().to_bytes();
/// here.add(distribution.results_from(&message).expect("the results of the same run"));
/// assert_eq!(distribution.summary(here.take())?, ensemble.run()?);
/// # Ok(())
/// # }
/// ```
pub struct Distribution<'a, I: PathMethod> {
    settings: Settings<'a, I>,
    info: Info,
}

impl<'a, I: PathMethod> Ensemble<'a, I> {
    /// Checks the settings for a run whose blocks are distributed by the caller.
    ///
    /// # Errors
    /// An [`EnsembleError`] for invalid settings, as [`run`](Self::run).
    pub fn distribute(&'a self) -> Result<Distribution<'a, I>, EnsembleError> {
        let settings = Settings::new(self)?;
        let info = settings.info(settings.fingerprint());
        Ok(Distribution { settings, info })
    }
}

impl<I: PathMethod + Sync> Distribution<'_, I> {
    /// The blocks of the run, or of its shard.
    pub fn blocks(&self) -> Range<u64> {
        self.settings.shard[0]..self.settings.shard[1]
    }

    /// Returns the number of paths of some blocks.
    pub fn paths_of(&self, blocks: Range<u64>) -> u64 {
        self.settings.paths_of(blocks)
    }

    /// Returns the number of threads that the ensemble asks for; by default the number of threads
    /// of the surrounding `rayon` pool.
    pub fn threads(&self) -> usize {
        (self.settings.ensemble.execution.threads).unwrap_or_else(rayon::current_num_threads)
    }

    /// Asks the function of [`stop_when`](Ensemble::stop_when) whether the run is to end.
    pub fn is_stopped(&self) -> bool {
        self.settings.ensemble.execution.is_stopped()
    }

    /// Returns a description of the run, for [`difference`](Self::difference) in another process.
    pub fn identity(&self) -> Vec<u8> {
        bytes(&Identity {
            info: self.info.clone(),
            shard: self.settings.shard,
            stop_on_failure: self.settings.ensemble.stop_on_failure,
        })
    }

    /// Returns the first difference to the run of another process; `None` for the same run.
    /// Closures are compared by samples, as in [`Summary::merge`].
    pub fn difference(&self, identity: &[u8]) -> Option<Difference> {
        let Ok((other, [])) = postcard::take_from_bytes::<Identity>(identity) else {
            return Some(Difference::Formulas);
        };
        let of_run = self.info.difference(&other.info);
        let of_shard = (self.settings.shard != other.shard).then_some(Difference::Shard);
        let stops = self.settings.ensemble.stop_on_failure;
        let of_stop = (stops != other.stop_on_failure).then_some(Difference::Settings);
        of_run.or(of_shard).or(of_stop)
    }

    /// Runs the paths of a block.
    ///
    /// # Errors
    /// [`EnsembleError::Failed`] for a path that fails with
    /// [`stop_on_failure`](Ensemble::stop_on_failure).
    ///
    /// # Panics
    /// Unless the block is in [`blocks`](Self::blocks).
    pub fn run_block(&self, block: u64) -> Result<PartialResults, EnsembleError> {
        assert!(self.blocks().contains(&block), "no block {block}");
        let mut results = self.no_results().take();
        results.tree.insert(self.settings.run_block(block)?);
        Ok(results)
    }

    /// Returns results without a block, to add others to.
    pub fn no_results(&self) -> SharedResults {
        let blocks = self.info.paths.div_ceil(BLOCK_PATHS);
        SharedResults(Mutex::new(MergeTree::new(blocks)))
    }

    /// Returns the results that another process has written by [`PartialResults::to_bytes`], or
    /// `None` if they are not of this run.
    pub fn results_from(&self, bytes: &[u8]) -> Option<PartialResults> {
        let (nodes, rest) = postcard::take_from_bytes::<Vec<PartialResult>>(bytes).ok()?;
        let (warnings, rest) = postcard::take_from_bytes(rest).ok()?;
        let tree = checked_tree(&self.info, nodes)?;
        rest.is_empty().then_some(PartialResults { tree, warnings })
    }

    /// Returns the file of [`checkpoint`](Ensemble::checkpoint), if the ensemble has one.
    pub fn checkpoint(&self) -> Option<Checkpoint> {
        Some(Checkpoint {
            file: self.settings.checkpoint(&self.info)?,
            is_resumed: self.settings.ensemble.execution.resume,
        })
    }

    /// Returns whether [`progress`](Ensemble::progress) is to be shown.
    pub fn shows_progress(&self) -> bool {
        self.settings.ensemble.execution.progress
    }

    /// Returns the summary of results.
    ///
    /// # Errors
    /// [`EnsembleError::NothingRun`] if there are none.
    pub fn summary(&self, results: PartialResults) -> Result<Summary, EnsembleError> {
        if results.is_empty() {
            return Err(EnsembleError::NothingRun);
        }
        Ok(Summary::new(self.info.clone(), results.tree).warned(results.warnings))
    }
}

impl<I: PathMethod> fmt::Debug for Distribution<'_, I> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let settings = &self.settings;
        f.debug_struct("Distribution")
            .field("ensemble", settings.ensemble)
            .finish_non_exhaustive()
    }
}

/// The results of some blocks of a run, merged as far as they are neighbours.
#[derive(Clone, Debug, PartialEq)]
pub struct PartialResults {
    tree: MergeTree,
    /// Warnings about the run.
    warnings: Vec<Warning>,
}

impl PartialResults {
    /// Returns the ranges of blocks whose results are merged, in their order.
    pub fn blocks(&self) -> impl Iterator<Item = Range<u64>> {
        let nodes = self.tree.nodes.values();
        nodes.map(|node| node.first..node.first + node.blocks)
    }

    /// Returns whether there is no block.
    pub fn is_empty(&self) -> bool {
        self.tree.nodes.is_empty()
    }

    /// Returns the results with all their bits, for [`Distribution::results_from`] in another
    /// process.
    pub fn to_bytes(&self) -> Vec<u8> {
        let nodes: Vec<_> = self.tree.nodes.values().collect();
        bytes(&(nodes, &self.warnings))
    }

    /// Adds a warning that the summary is to have, such as the warning of a
    /// [checkpoint](Checkpoint::warning).
    pub fn warn(&mut self, warning: Warning) {
        self.warnings.push(warning);
    }

    /// Adds the results of other blocks.
    pub fn merge(&mut self, other: Self) {
        self.warnings.extend(other.warnings);
        for node in other.tree.nodes.into_values() {
            self.tree.insert(node);
        }
    }
}

/// Results to which several threads add.
#[derive(Debug)]
pub struct SharedResults(Mutex<MergeTree>);

impl SharedResults {
    /// Adds the results of other blocks. They are merged outside of the lock.
    pub fn add(&self, results: PartialResults) {
        for node in results.tree.nodes.into_values() {
            insert_shared(&self.0, node);
        }
    }

    /// Removes and returns the results that were added. Results that another thread is about to add
    /// are not among them.
    pub fn take(&self) -> PartialResults {
        let mut tree = locked(&self.0);
        let empty = MergeTree::new(tree.blocks);
        PartialResults {
            tree: core::mem::replace(&mut *tree, empty),
            warnings: Vec::new(),
        }
    }
}

/// The file of [`Ensemble::checkpoint`]. [`Ensemble::run`] and distributed runs of the same
/// ensemble can read the files of each other.
pub struct Checkpoint {
    file: CheckpointFile,
    is_resumed: bool,
}

impl Checkpoint {
    /// Reads the results of the file if it exists and the ensemble is to
    /// [`resume`](Ensemble::resume).
    ///
    /// # Errors
    /// As [`Ensemble::resume`].
    pub fn load(&self) -> Result<Option<PartialResults>, EnsembleError> {
        if !self.is_resumed {
            return Ok(None);
        }
        let tree = self.file.load()?;
        let warnings = Vec::new();
        Ok(tree.map(|tree| PartialResults { tree, warnings }))
    }

    /// Returns whether the file is due to be written, and starts the next interval if it is.
    pub fn is_due(&self) -> bool {
        self.file.is_due()
    }

    /// Replaces the file, if there are results. If this fails, prints a message on standard error,
    /// [`warning`](Self::warning) returns a warning, and the file is [due](Self::is_due) again
    /// soon.
    pub fn save(&self, results: &PartialResults) {
        self.file.save(&results.tree);
    }

    /// Returns a warning if the file could not be written. Check before the run by
    /// [`Ensemble::try_checkpoint`] that it can.
    pub fn warning(&self) -> Option<Warning> {
        self.file.warning()
    }
}

impl fmt::Debug for Checkpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Checkpoint").finish_non_exhaustive()
    }
}

/// Returns the stored form of a value.
fn bytes(value: &impl Serialize) -> Vec<u8> {
    // Numbers, strings and lists of known length always have a stored form. No reader accepts an
    // empty form.
    postcard::to_stdvec(value).unwrap_or_default()
}
