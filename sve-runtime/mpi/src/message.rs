//! The messages between rank 0, which hands out blocks, and the other ranks, which run them.
//!
//! A rank sends a [`Report`] and waits for the [`Answer`]. Rank 0 sends nothing but answers, so a
//! message always has a rank that waits for it, and no order of events makes two ranks wait for one
//! another, even if the MPI does not buffer messages.

use core::ops::Range;

use serde::{Deserialize, Serialize};
use sve_runtime::ensemble::Failure;

/// The state of a rank and its changes since the last report.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct Report {
    /// Number of blocks that the rank wants to have waiting.
    pub(crate) wanted: u64,
    /// Number of blocks below which a message is not worth its cost.
    pub(crate) least: u64,
    /// Number of blocks that were handed to the rank and have not begun.
    pub(crate) waiting: u64,
    /// Number of blocks that were handed to the rank and have not ended.
    pub(crate) unfinished: u64,
    /// Number of paths that have ended since the last report.
    pub(crate) paths: u64,
    /// The reason to end the run, if this rank knows one.
    pub(crate) stop: Option<Stop>,
    /// The results of the blocks that have ended since results were last sent. Sent only if the
    /// last answer asked for them.
    pub(crate) results: Option<Vec<u8>>,
}

/// The answer of rank 0 to a report.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Answer {
    /// Blocks to run.
    pub(crate) blocks: Range<u64>,
    /// True if there are blocks that no rank has begun.
    pub(crate) has_more: bool,
    /// The first block that must not be begun any more.
    pub(crate) limit: u64,
    /// True if the next report has to be sent at once, with results.
    pub(crate) wants_results: bool,
    /// True if the run has ended.
    pub(crate) has_ended: bool,
}

/// The reason to end a run early, and its limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Stop {
    /// The first block that must not be begun any more. Blocks before it still run: one of their
    /// paths may fail first.
    pub(crate) limit: u64,
    pub(crate) cause: Option<Cause>,
}

/// The error that ends a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Cause {
    /// A path failed, and `stop_on_failure` was set.
    Failed(Box<Failure>),
    /// A rank has an error.
    Error { rank: i32, message: String },
    /// A rank panicked.
    Panic { rank: i32, message: String },
}

impl Cause {
    /// Returns the order of causes: errors of a whole rank first, by their ranks, then failures, by
    /// their paths.
    fn order(&self) -> (bool, u64) {
        match self {
            Self::Error { rank, .. } | Self::Panic { rank, .. } => {
                (false, u64::from(rank.unsigned_abs()))
            }
            Self::Failed(failure) => (true, failure.path),
        }
    }
}

/// Adds a reason to end to an earlier one, if there is one. The result does not depend on the order
/// of reasons.
pub(crate) fn add_stop(stop: &mut Option<Stop>, other: Stop) {
    let Some(stop) = stop else {
        *stop = Some(other);
        return;
    };
    stop.limit = stop.limit.min(other.limit);
    let is_first = match (&stop.cause, &other.cause) {
        (Some(old), Some(new)) => new.order() < old.order(),
        (old, new) => old.is_none() && new.is_some(),
    };
    if is_first {
        stop.cause = other.cause;
    }
}

#[cfg(test)]
mod tests {
    use super::{Cause, Stop, add_stop};

    fn error(rank: i32) -> Stop {
        let message = String::new();
        Stop {
            limit: 0,
            cause: Some(Cause::Error { rank, message }),
        }
    }

    #[test]
    fn the_order_of_reasons_does_not_matter() {
        let asked = Stop {
            limit: 3,
            cause: None,
        };
        let reasons = [asked, error(2), error(1)];
        for order in [
            [0, 1, 2],
            [0, 2, 1],
            [1, 0, 2],
            [1, 2, 0],
            [2, 0, 1],
            [2, 1, 0],
        ] {
            let mut stop = None;
            for k in order {
                add_stop(&mut stop, reasons[k].clone());
            }
            assert_eq!(stop, Some(error(1)));
        }
    }
}
