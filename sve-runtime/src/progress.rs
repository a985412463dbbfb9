//! The progress of a run, on the terminal.
//!
//! Input: the numbers of finished paths of an ensemble, or of saved states of a trajectory. Output:
//! a bar with the feature `progress`, otherwise a percentage, on standard error if it is a
//! terminal. Results do not depend on it.

#[cfg(not(feature = "progress"))]
pub(crate) use plain::Progress;

#[cfg(feature = "progress")]
pub(crate) use bar::Progress;

#[cfg(feature = "progress")]
mod bar {
    use indicatif::{ProgressBar, ProgressStyle};

    /// A bar, or nothing.
    #[derive(Debug)]
    pub(crate) struct Progress(ProgressBar);

    impl Progress {
        pub(crate) fn new(shown: bool, whole: u64, unit: &'static str) -> Self {
            let bar = if shown {
                ProgressBar::new(whole)
            } else {
                ProgressBar::hidden()
            };
            let template =
                format!("{{bar:40}} {{pos}}/{{len}} {unit}, {{elapsed}} of {{duration}}");
            if let Ok(style) = ProgressStyle::with_template(&template) {
                bar.set_style(style);
            }
            Self(bar)
        }

        pub(crate) fn add(&self, more: u64) {
            self.0.inc(more);
        }

        pub(crate) fn end(&self) {
            self.0.finish_and_clear();
        }
    }
}

#[cfg(not(feature = "progress"))]
mod plain {
    use std::io::IsTerminal;
    use std::sync::atomic::{AtomicU64, Ordering};

    /// A percentage, or nothing.
    #[derive(Debug)]
    pub(crate) struct Progress {
        shown: bool,
        whole: u64,
        unit: &'static str,
        done: AtomicU64,
    }

    impl Progress {
        pub(crate) fn new(shown: bool, whole: u64, unit: &'static str) -> Self {
            Self {
                shown: shown && std::io::stderr().is_terminal(),
                whole,
                unit,
                done: AtomicU64::new(0),
            }
        }

        pub(crate) fn add(&self, more: u64) {
            let before = self.done.fetch_add(more, Ordering::Relaxed);
            let percent = |done: u64| u128::from(done) * 100 / u128::from(self.whole.max(1));
            let now = percent(before + more);
            if self.shown && now > percent(before) {
                eprint!("\r{now} % of {} {}", self.whole, self.unit);
            }
        }

        pub(crate) fn end(&self) {
            if self.shown {
                eprintln!();
            }
        }
    }
}
