//! The progress of a run, on the terminal.
//!
//! Input: the numbers of finished paths. Output: a bar with the feature `progress`, otherwise a
//! percentage, on standard error if it is a terminal. Results do not depend on it.

#[cfg(not(feature = "progress"))]
pub(super) use plain::Progress;

#[cfg(feature = "progress")]
pub(super) use bar::Progress;

#[cfg(feature = "progress")]
mod bar {
    use indicatif::{ProgressBar, ProgressStyle};

    /// A bar, or nothing.
    pub(in super::super) struct Progress(ProgressBar);

    impl Progress {
        pub(in super::super) fn new(shown: bool, paths: u64) -> Self {
            let bar = if shown {
                ProgressBar::new(paths)
            } else {
                ProgressBar::hidden()
            };
            let template = "{bar:40} {pos}/{len} paths, {elapsed} of {duration}";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style);
            }
            Self(bar)
        }

        pub(in super::super) fn add(&self, paths: u64) {
            self.0.inc(paths);
        }

        pub(in super::super) fn end(&self) {
            self.0.finish_and_clear();
        }
    }
}

#[cfg(not(feature = "progress"))]
mod plain {
    use std::io::IsTerminal;
    use std::sync::atomic::{AtomicU64, Ordering};

    /// A percentage, or nothing.
    pub(in super::super) struct Progress {
        shown: bool,
        paths: u64,
        done: AtomicU64,
    }

    impl Progress {
        pub(in super::super) fn new(shown: bool, paths: u64) -> Self {
            Self {
                shown: shown && std::io::stderr().is_terminal(),
                paths,
                done: AtomicU64::new(0),
            }
        }

        pub(in super::super) fn add(&self, paths: u64) {
            let before = self.done.fetch_add(paths, Ordering::Relaxed);
            let percent = |done: u64| u128::from(done) * 100 / u128::from(self.paths.max(1));
            let now = percent(before + paths);
            if self.shown && now > percent(before) {
                eprint!("\r{now} % of {} paths", self.paths);
            }
        }

        pub(in super::super) fn end(&self) {
            if self.shown {
                eprintln!();
            }
        }
    }
}
