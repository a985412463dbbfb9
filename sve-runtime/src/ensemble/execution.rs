//! The execution of an ensemble: its blocks on all threads.
//!
//! Input: [`Settings`]. Output: a [`Summary`]. Invariant: the result of a block depends on its
//! number only, and the tree fixes how blocks are merged, so threads affect nothing but the
//! duration.

use core::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

#[cfg(feature = "checkpoint")]
use super::checkpoint::CheckpointFile;
#[cfg(feature = "checkpoint")]
use super::info::Info;
use super::merge_tree::{MergeTree, PartialResult, insert_shared};
use super::path_block::PathBlock;
use super::settings::Settings;
use super::summary::Summary;
use super::{BLOCK_PATHS, EnsembleError, Warning};
use crate::ensemble::PathMethod;
use crate::progress::Progress;

/// Largest number of blocks that are run together: with paths that stop at a constant rate, a
/// thousand paths keep nine of ten lanes full.
const GROUP: u64 = 16;

/// Least number of times that a thread gets blocks to run together, so that all threads end at
/// about the same time.
const TURNS: u64 = 4;

impl<I: PathMethod + Sync> Settings<'_, I> {
    /// Runs the blocks of the shard.
    pub(super) fn execute(&self) -> Result<Summary, EnsembleError> {
        #[cfg(feature = "checkpoint")]
        self.ensemble.try_checkpoint()?;
        let info = self.info(self.fingerprint());
        let shared = Shared::new(self, 1);
        #[cfg(feature = "checkpoint")]
        let shared = shared.with_checkpoint(self, &info)?;
        let finished = self.run_on_threads(shared, |blocks| {
            let results = self.run_some(blocks)?;
            Ok(results.into_iter().map(|result| vec![result]).collect())
        })?;
        let tree = finished.trees.into_iter().next();
        let tree = tree.ok_or(EnsembleError::NothingRun)?;
        Ok(Summary::new(info, tree).warned(finished.warning))
    }

    /// Runs the blocks of the shard with `results` results each, and returns a tree for each of
    /// them.
    pub(super) fn execute_with(
        &self,
        results: usize,
        run_block: impl Fn(u64) -> Result<Vec<PartialResult>, EnsembleError> + Sync,
    ) -> Result<Vec<MergeTree>, EnsembleError> {
        let run_some = |blocks: Range<u64>| blocks.map(&run_block).collect();
        let finished = self.run_on_threads(Shared::new(self, results), run_some)?;
        Ok(finished.trees)
    }

    /// Runs the blocks of the shard on all threads. `run_some` returns the results of each block;
    /// result number k becomes a part of tree number k.
    fn run_on_threads(
        &self,
        shared: Shared,
        run_some: impl Fn(Range<u64>) -> Result<Vec<Vec<PartialResult>>, EnsembleError> + Sync,
    ) -> Result<Finished, EnsembleError> {
        let run_blocks = || {
            rayon::scope(|scope| {
                for _ in 0..rayon::current_num_threads() {
                    scope.spawn(|_| self.run_blocks(&shared, &run_some));
                }
            });
        };
        match self.ensemble.execution.threads {
            None => run_blocks(),
            Some(threads) => rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()?
                .install(run_blocks),
        }
        let finished = shared.end()?;
        if finished.trees.iter().any(|tree| tree.nodes.is_empty()) {
            return Err(EnsembleError::NothingRun);
        }
        Ok(finished)
    }

    /// Runs blocks until none is left.
    fn run_blocks(
        &self,
        shared: &Shared,
        run_some: &impl Fn(Range<u64>) -> Result<Vec<Vec<PartialResult>>, EnsembleError>,
    ) {
        let group = self.group(rayon::current_num_threads());
        loop {
            let first = shared.next.fetch_add(group, Ordering::Relaxed);
            let end = self.shard[1].min(first.saturating_add(group));
            if first >= end || shared.stops_before(first) {
                return;
            }
            for blocks in shared.not_loaded(first..end) {
                if self.ensemble.execution.is_stopped() {
                    return;
                }
                match run_some(blocks.clone()) {
                    Ok(results) => {
                        shared.progress.add(self.paths_of(blocks));
                        for results in results {
                            shared.insert(results);
                        }
                    }
                    Err(error) => shared.stop(error),
                }
            }
        }
    }

    /// Returns the number of blocks that are run together. If paths stop, more blocks keep the
    /// lanes full; the results are the same.
    fn group(&self, threads: usize) -> u64 {
        if !self.ensemble.has_stops() {
            return 1;
        }
        let blocks = self.shard[1] - self.shard[0];
        (blocks / (TURNS * threads as u64)).clamp(1, GROUP)
    }

    /// Runs the paths of a block from start to end.
    #[cfg(feature = "distributed")]
    pub(super) fn run_block(&self, block: u64) -> Result<PartialResult, EnsembleError> {
        let results = self.run_some(block..block + 1)?;
        results.into_iter().next().ok_or(EnsembleError::NothingRun)
    }

    /// Runs the paths of some blocks from start to end. Returns the results of each block.
    fn run_some(&self, blocks: Range<u64>) -> Result<Vec<PartialResult>, EnsembleError> {
        let mut paths = PathBlock::new(*self, blocks.clone(), None)?;
        let mut results: Vec<_> = blocks.map(|block| self.empty(block)).collect();
        for record in 0..self.records {
            paths.advance(self.step_of(record));
            paths.record(record, &mut results);
        }
        paths.finish(&mut results);
        let mut failures = results.iter().flat_map(|result| &result.failures);
        match failures.next() {
            Some(first) if self.ensemble.stop_on_failure => {
                Err(EnsembleError::Failed(Box::new(first.clone())))
            }
            _ => Ok(results),
        }
    }
}

/// The results of all threads.
struct Finished {
    trees: Vec<MergeTree>,
    /// A checkpoint that could not be written.
    warning: Option<Warning>,
}

/// The state that the threads share.
struct Shared {
    /// The next block.
    next: AtomicU64,
    /// A tree for each result of a block.
    trees: Vec<Mutex<MergeTree>>,
    /// Blocks whose results a checkpoint has.
    loaded: Vec<Range<u64>>,
    /// The error that ends the run: the error of the first path that failed.
    stop: Mutex<Option<EnsembleError>>,
    progress: Progress,
    #[cfg(feature = "checkpoint")]
    checkpoint: Option<CheckpointFile>,
}

impl Shared {
    fn new<I: PathMethod>(settings: &Settings<'_, I>, results: usize) -> Self {
        let [start, end] = settings.shard;
        let paths = settings.paths_of(start..end);
        let blocks = settings.paths.div_ceil(BLOCK_PATHS);
        let trees = (0..results).map(|_| Mutex::new(MergeTree::new(blocks)));
        Self {
            next: AtomicU64::new(start),
            trees: trees.collect(),
            loaded: Vec::new(),
            stop: Mutex::new(None),
            progress: Progress::new(settings.ensemble.execution.progress, paths, "paths"),
            #[cfg(feature = "checkpoint")]
            checkpoint: None,
        }
    }

    /// Returns the blocks of a range whose results no checkpoint has, as ranges.
    fn not_loaded(&self, blocks: Range<u64>) -> Vec<Range<u64>> {
        let is_loaded = |block: &u64| self.loaded.iter().any(|range| range.contains(block));
        let mut parts: Vec<Range<u64>> = Vec::new();
        for block in blocks.filter(|block| !is_loaded(block)) {
            match parts.last_mut() {
                Some(part) if part.end == block => part.end += 1,
                _ => parts.push(block..block + 1),
            }
        }
        parts
    }

    /// Inserts the results of a block into their trees. Results are merged outside of the lock.
    /// With a checkpoint they are merged inside, since the written tree has to contain all blocks.
    fn insert(&self, results: Vec<PartialResult>) {
        for (tree, result) in self.trees.iter().zip(results) {
            #[cfg(feature = "checkpoint")]
            if let Some(checkpoint) = &self.checkpoint {
                let mut tree = locked(tree);
                tree.insert(result);
                if checkpoint.is_due() {
                    checkpoint.save(&tree);
                }
                continue;
            }
            insert_shared(tree, result);
        }
    }

    /// Returns the results, after all threads have ended.
    fn end(self) -> Result<Finished, EnsembleError> {
        self.progress.end();
        let trees = self.trees.into_iter().map(Mutex::into_inner);
        let trees: Vec<_> = trees
            .map(|tree| tree.unwrap_or_else(PoisonError::into_inner))
            .collect();
        #[cfg(feature = "checkpoint")]
        if let Some(checkpoint) = &self.checkpoint {
            for tree in &trees {
                checkpoint.save(tree);
            }
        }
        #[cfg(feature = "checkpoint")]
        let warning = self.checkpoint.and_then(|checkpoint| checkpoint.warning());
        #[cfg(not(feature = "checkpoint"))]
        let warning = None;
        match (self.stop.into_inner()).unwrap_or_else(PoisonError::into_inner) {
            Some(error) => Err(error),
            None => Ok(Finished { trees, warning }),
        }
    }

    /// Stores the error if no path with a lower number has failed.
    fn stop(&self, error: EnsembleError) {
        let mut stop = locked(&self.stop);
        if stop.as_ref().is_none_or(|old| path(&error) < path(old)) {
            *stop = Some(error);
        }
    }

    /// Returns whether the failure of an earlier path ends the run before this block.
    fn stops_before(&self, block: u64) -> bool {
        locked(&self.stop)
            .as_ref()
            .is_some_and(|error| path(error) < block * BLOCK_PATHS)
    }
}

#[cfg(feature = "checkpoint")]
impl Shared {
    /// Loads the results of a checkpoint, if there are results and the ensemble has to continue
    /// them.
    fn with_checkpoint<I: PathMethod>(
        mut self,
        settings: &Settings<'_, I>,
        info: &Info,
    ) -> Result<Self, EnsembleError> {
        let Some(checkpoint) = settings.checkpoint(info) else {
            return Ok(self);
        };
        if settings.ensemble.execution.resume
            && let Some(tree) = checkpoint.load()?
        {
            for part in tree.nodes.values() {
                let blocks = part.first..part.first + part.blocks;
                self.progress.add(settings.paths_of(blocks.clone()));
                self.loaded.push(blocks);
            }
            self.trees = vec![Mutex::new(tree)];
        }
        self.checkpoint = Some(checkpoint);
        Ok(self)
    }
}

/// Returns the path that an error belongs to. Errors of the whole run come first.
fn path(error: &EnsembleError) -> u64 {
    match error {
        EnsembleError::Failed(failure) => failure.path,
        _ => 0,
    }
}

/// Locks a mutex. A panic of another thread ends the whole run, so the state that it left does not
/// matter.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
