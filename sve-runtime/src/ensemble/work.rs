//! The blocks of a run on all threads.
//!
//! Input: a [`Run`]. Output: its [`Summary`]. Invariant: what a block gives depends on its number alone, and the tree
//! fixes how blocks are merged, so threads decide nothing but how long it takes.

use core::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

#[cfg(feature = "checkpoint")]
use super::checkpoint::Keeper;
use super::flight::Flight;
use super::progress::Progress;
use super::run::Run;
#[cfg(feature = "checkpoint")]
use super::summary::Info;
use super::summary::Summary;
use super::tree::{Node, Tree, joined};
use super::{BLOCK_PATHS, EnsembleError};
use crate::configuration::Coordinates;
use crate::method::Method;
use crate::system::{Dims, System};

impl<I, S, Q, const N: usize, const M: usize> Run<'_, I>
where
    I: Method<System = S> + Sync,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Runs the blocks of the shard.
    pub(super) fn go(&self) -> Result<Summary, EnsembleError> {
        let info = self.info(self.fingerprint());
        let shared = Shared::new(self);
        #[cfg(feature = "checkpoint")]
        let shared = shared.load(self, &info)?;
        let work = || {
            rayon::scope(|scope| {
                for _ in 0..rayon::current_num_threads() {
                    scope.spawn(|_| self.work(&shared));
                }
            });
        };
        match self.ensemble.threads {
            None => work(),
            Some(threads) => rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()?
                .install(work),
        }
        let tree = shared.end()?;
        if tree.nodes.is_empty() {
            return Err(EnsembleError::NothingRun);
        }
        Ok(Summary::new(info.clone(), tree))
    }

    /// Runs blocks until there are none.
    fn work(&self, shared: &Shared) {
        loop {
            let block = shared.next.fetch_add(1, Ordering::Relaxed);
            if block >= self.shard[1] || shared.stops_before(block) {
                return;
            }
            if shared.loaded.iter().any(|range| range.contains(&block)) {
                continue;
            }
            if self.ensemble.stop_when.as_ref().is_some_and(|stop| stop()) {
                return;
            }
            let done = self.block(block).and_then(|node| {
                shared.progress.add(self.paths_of(block..block + 1));
                shared.insert(node)
            });
            if let Err(error) = done {
                shared.stop(error);
            }
        }
    }

    /// The paths of a block, from start to end.
    fn block(&self, block: u64) -> Result<Node, EnsembleError> {
        let mut flight = Flight::new(*self, block, None)?;
        let mut node = Node::new(block, self);
        for record in 0..self.records {
            flight.advance(self.step_of(record));
            flight.record(record, &mut node);
        }
        flight.finish(&mut node);
        match node.failures.first() {
            Some(first) if self.ensemble.stop_on_failure => {
                Err(EnsembleError::Failed(first.clone()))
            }
            _ => Ok(node),
        }
    }
}

/// What the threads share.
struct Shared {
    /// The block to be run next.
    next: AtomicU64,
    tree: Mutex<Tree>,
    /// Blocks that another run has done.
    loaded: Vec<Range<u64>>,
    /// The error of the first path that failed, where that ends the run.
    stop: Mutex<Option<EnsembleError>>,
    progress: Progress,
    #[cfg(feature = "checkpoint")]
    keeper: Option<Keeper>,
}

impl Shared {
    fn new<I: Method>(run: &Run<'_, I>) -> Self {
        let [start, end] = run.shard;
        let paths = run.paths_of(start..end);
        Self {
            next: AtomicU64::new(start),
            tree: Mutex::new(Tree::new(run.paths.div_ceil(BLOCK_PATHS))),
            loaded: Vec::new(),
            stop: Mutex::new(None),
            progress: Progress::new(run.ensemble.progress, paths),
            #[cfg(feature = "checkpoint")]
            keeper: None,
        }
    }

    /// Takes the result of a block in. What can be joined is joined outside the lock, unless the tree is to be written, which
    /// has to have all blocks.
    fn insert(&self, node: Node) -> Result<(), EnsembleError> {
        #[cfg(feature = "checkpoint")]
        if let Some(keeper) = &self.keeper {
            let mut tree = locked(&self.tree);
            tree.insert(node);
            return if keeper.is_due() {
                keeper.save(&tree)
            } else {
                Ok(())
            };
        }
        let mut node = Some(node);
        loop {
            let other = locked(&self.tree).place(&mut node);
            match (node.take(), other) {
                (Some(new), Some(other)) => node = Some(joined(new, other)),
                _ => return Ok(()),
            }
        }
    }

    /// The results, when all threads are done.
    fn end(self) -> Result<Tree, EnsembleError> {
        self.progress.end();
        let tree = (self.tree.into_inner()).unwrap_or_else(PoisonError::into_inner);
        #[cfg(feature = "checkpoint")]
        if let Some(keeper) = &self.keeper {
            keeper.save(&tree)?;
        }
        match (self.stop.into_inner()).unwrap_or_else(PoisonError::into_inner) {
            Some(error) => Err(error),
            None => Ok(tree),
        }
    }

    /// Keeps the error of the lowest path.
    fn stop(&self, error: EnsembleError) {
        let mut stop = locked(&self.stop);
        if stop.as_ref().is_none_or(|old| path(&error) < path(old)) {
            *stop = Some(error);
        }
    }

    /// Whether a path before this block has ended the run.
    fn stops_before(&self, block: u64) -> bool {
        locked(&self.stop)
            .as_ref()
            .is_some_and(|error| path(error) < block * BLOCK_PATHS)
    }
}

#[cfg(feature = "checkpoint")]
impl Shared {
    /// Begins with what a checkpoint has, where there is one.
    fn load<I: Method>(mut self, run: &Run<'_, I>, info: &Info) -> Result<Self, EnsembleError> {
        let Some((path, every)) = &run.ensemble.checkpoint else {
            return Ok(self);
        };
        let keeper = Keeper::new(path.clone(), *every, info.clone(), run.shard);
        if run.ensemble.resume
            && let Some(tree) = keeper.load()?
        {
            for node in tree.nodes.values() {
                let blocks = node.first..node.first + node.blocks;
                self.progress.add(run.paths_of(blocks.clone()));
                self.loaded.push(blocks);
            }
            self.tree = Mutex::new(tree);
        }
        self.keeper = Some(keeper);
        Ok(self)
    }
}

/// The path that an error is of; errors of the whole run come first.
fn path(error: &EnsembleError) -> u64 {
    match error {
        EnsembleError::Failed(failure) => failure.path,
        _ => 0,
    }
}

/// What a mutex holds. A thread that panicked ends the whole run, so what it left is of no matter.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
