//! The progress of a run on all ranks, as lines on standard error of rank 0.
//!
//! Standard error of a rank is no terminal, so there is no bar: `mpirun` and batch systems gather
//! lines.

use core::cell::Cell;
use std::time::{Duration, Instant};

/// Shortest time between two lines, except before the last line.
const PAUSE: Duration = Duration::from_secs(2);

/// The paths that have ended on all ranks.
pub(crate) struct Progress {
    is_shown: bool,
    paths: u64,
    done: Cell<u64>,
    start: Instant,
    last_line: Cell<Instant>,
}

impl Progress {
    pub(crate) fn new(is_shown: bool, paths: u64) -> Self {
        let now = Instant::now();
        Self {
            is_shown,
            paths,
            done: Cell::new(0),
            start: now,
            last_line: Cell::new(now),
        }
    }

    /// Adds paths that have ended, or whose results a checkpoint has.
    pub(crate) fn add(&self, paths: u64) {
        self.done.set(self.done.get() + paths);
        let is_last = self.done.get() == self.paths;
        let is_due = self.last_line.get().elapsed() >= PAUSE || is_last;
        if self.is_shown && paths > 0 && is_due {
            self.last_line.set(Instant::now());
            eprintln!("{}", self.line());
        }
    }

    fn line(&self) -> String {
        let percent = u128::from(self.done.get()) * 100 / u128::from(self.paths.max(1));
        let seconds = self.start.elapsed().as_secs();
        format!("{percent} % of {} paths after {seconds} s", self.paths)
    }
}
