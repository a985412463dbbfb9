//! The attempts to write a checkpoint: the time of the next one, and their outcomes.
//!
//! Input: the interval, and the outcome of each attempt. Output: whether the file is due, and a
//! warning. Invariant: no failed attempt is forgotten.

use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

use super::Warning;

/// Longest time from a failed attempt to the next one. Freeing room on a disk is manual work, which
/// takes minutes.
const RETRY: Duration = Duration::from_secs(10);

/// The attempts to write a checkpoint.
pub(super) struct Attempts {
    interval: Duration,
    /// Time of the last attempt, or of the start of the run.
    last: Instant,
    /// Time from the last attempt to the next one.
    wait: Duration,
    /// Number of attempts that failed.
    failed: u64,
    /// The error of the last attempt that failed.
    error: String,
    /// The last attempt failed.
    is_failing: bool,
}

impl Attempts {
    /// Returns the attempts of a run that starts now, before the first attempt.
    pub(super) fn new(interval: Duration) -> Self {
        Self {
            interval,
            last: Instant::now(),
            wait: interval,
            failed: 0,
            error: String::new(),
            is_failing: false,
        }
    }

    /// Returns whether the next attempt is due. The time to the attempt after it starts then.
    pub(super) fn is_due(&mut self, now: Instant) -> bool {
        let is_due = now.saturating_duration_since(self.last) >= self.wait;
        if is_due {
            self.last = now;
        }
        is_due
    }

    /// Stores the outcome of an attempt. Returns whether it is the first one of a series that
    /// failed.
    pub(super) fn add(&mut self, outcome: Result<(), io::Error>) -> bool {
        let was_failing = self.is_failing;
        self.is_failing = outcome.is_err();
        self.wait = self.interval;
        if let Err(error) = outcome {
            self.wait = self.interval.min(RETRY);
            self.failed += 1;
            self.error = error.to_string();
        }
        self.is_failing && !was_failing
    }

    /// Returns the warning about the attempts that failed, if there are some.
    pub(super) fn warning(&self, path: &Path) -> Option<Warning> {
        (self.failed > 0).then(|| Warning::Checkpoint {
            path: path.display().to_string(),
            failed: self.failed,
            error: self.error.clone(),
            is_written: !self.is_failing,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_attempt_is_followed_by_one_soon() {
        let hour = Duration::from_secs(3600);
        let mut attempts = Attempts::new(hour);
        let start = attempts.last;
        let full = || Err(io::Error::from(io::ErrorKind::StorageFull));
        assert!(!attempts.is_due(start + hour / 2));
        assert!(attempts.is_due(start + hour) && !attempts.is_due(start + hour + RETRY));
        assert!(attempts.warning(Path::new("x")).is_none());
        assert!(attempts.add(full()));
        assert!(!attempts.is_due(start + hour + RETRY / 2));
        assert!(attempts.is_due(start + hour + RETRY));
        // the next error of the series is not reported again
        assert!(!attempts.add(full()));
        assert!(attempts.is_due(start + hour + 2 * RETRY));
        assert!(!attempts.add(Ok(())));
        assert!(!attempts.is_due(start + hour + 3 * RETRY));
        let warning = attempts.warning(Path::new("x.sve"));
        let expected = Warning::Checkpoint {
            path: "x.sve".to_owned(),
            failed: 2,
            error: io::Error::from(io::ErrorKind::StorageFull).to_string(),
            is_written: true,
        };
        assert_eq!(warning, Some(expected));
        // a new series is reported
        assert!(attempts.add(full()));
        // a short interval stays
        let mut attempts = Attempts::new(RETRY / 4);
        let start = attempts.last;
        attempts.add(full());
        assert!(attempts.is_due(start + RETRY / 4));
    }
}
