//! The blocks of a run on all threads.
//!
//! Input: a [`Run`]. Output: its [`Summary`]. Invariant: what a block gives depends on its number alone, and the tree
//! fixes how blocks are merged, so threads decide nothing but how long it takes.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::flight::Flight;
use super::progress::Progress;
use super::run::Run;
use super::summary::Summary;
use super::tree::{Node, Tree, joined};
use super::{BLOCK_PATHS, EnsembleError};
use crate::method::Method;
use crate::system::{Dims, System};

impl<I, S, const N: usize, const M: usize> Run<'_, I>
where
    I: Method<System = S> + Sync,
    S: System<Dims = Dims<N, M>>,
{
    /// Runs the blocks of the shard.
    pub(super) fn go(&self) -> Result<Summary, EnsembleError> {
        let blocks = self.paths.div_ceil(BLOCK_PATHS);
        let [start, end] = self.shard;
        let paths = (end * BLOCK_PATHS).min(self.paths) - (start * BLOCK_PATHS).min(self.paths);
        let shared = Shared {
            next: AtomicU64::new(start),
            tree: Mutex::new(Tree::new(blocks)),
            stop: Mutex::new(None),
            progress: Progress::new(self.ensemble.progress, paths),
        };
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
        shared.progress.end();
        if let Some(error) = shared
            .stop
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner)
        {
            return Err(error);
        }
        let tree = shared.tree.into_inner();
        Ok(Summary::new(
            self.info(self.fingerprint()),
            tree.unwrap_or_else(PoisonError::into_inner),
        ))
    }

    /// Runs blocks until there are none.
    fn work(&self, shared: &Shared) {
        loop {
            let block = shared.next.fetch_add(1, Ordering::Relaxed);
            if block >= self.shard[1] || shared.stops_before(block) {
                return;
            }
            match self.block(block) {
                Ok(node) => {
                    let paths = self.paths - block * BLOCK_PATHS;
                    shared.progress.add(paths.min(BLOCK_PATHS));
                    shared.insert(node);
                }
                Err(error) => shared.stop(error),
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
    /// The error of the first path that failed, where that ends the run.
    stop: Mutex<Option<EnsembleError>>,
    progress: Progress,
}

impl Shared {
    /// Takes the result of a block in. What can be joined is joined outside the lock.
    fn insert(&self, node: Node) {
        let mut node = Some(node);
        loop {
            let other = locked(&self.tree).place(&mut node);
            match (node.take(), other) {
                (Some(new), Some(other)) => node = Some(joined(new, other)),
                _ => return,
            }
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
