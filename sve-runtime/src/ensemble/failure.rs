//! Failures of paths.

use core::mem::discriminant;

use crate::error::StepError;
use crate::readable::debug_is_display;

/// Largest number of failures that a summary keeps, with number, time and error: the failures of
/// the paths with the lowest numbers. All failures are counted.
pub const FAILURES_KEPT: usize = 256;

/// The failure of a path. The path is not in the statistics of later records.
#[derive(Clone, PartialEq, thiserror::Error)]
#[error("path {path} failed after {step} steps, at t = {t}: {cause}")]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Failure {
    /// Number of the path, from 0; [`replay`](super::Ensemble::replay) repeats it.
    pub path: u64,
    /// Number of steps before the failure. If the path was about to stop, the last step is a part
    /// of a step.
    pub step: u64,
    /// Time of the failure.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
    pub t: f64,
    /// The cause of the failure.
    #[source]
    pub cause: Cause,
}

/// The cause of the failure of a path.
#[derive(Clone, thiserror::Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Cause {
    /// A step failed.
    #[error("{0}")]
    Step(#[source] StepError),
    /// The path starts at another time than path 0.
    #[error(
        "it starts at t = {t}, and path 0 at t = {expected}: the paths of an ensemble start together"
    )]
    StartTime {
        /// Its start time.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// The time of path 0.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        expected: f64,
    },
    /// An observable returned an error.
    #[error("the observable `{name}` failed: {error}")]
    Observable {
        /// Its name.
        name: String,
        /// The error that it returned.
        #[source]
        error: StepError,
    },
    /// An observable returned a number that is not finite.
    #[error(
        "the observable `{name}` is {value}: statistics need finite numbers; look at what it computes there"
    )]
    NotFinite {
        /// Its name.
        name: String,
        /// The value that it returned.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        value: f64,
    },
    /// An observable is outside of the range that was given for it, at a recorded time or where the
    /// path was to stop.
    #[error(
        "the observable `{name}` is {value:e}, outside of the bound {low:e}..={high:e} that was given for it"
    )]
    OutOfBound {
        /// Its name.
        name: String,
        /// The value that it returned.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        value: f64,
        /// Lower bound.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        low: f64,
        /// Upper bound.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        high: f64,
    },
}

debug_is_display!(Failure, Cause);

/// Causes are equal if all numbers are equal; NaN equals NaN.
impl PartialEq for Cause {
    fn eq(&self, other: &Self) -> bool {
        // A message has all digits of its numbers, except the message of a step, which rounds
        // fractions.
        let text = self.to_string();
        let same_step = match (self, other) {
            (Self::Step(a), Self::Step(b))
            | (Self::Observable { error: a, .. }, Self::Observable { error: b, .. }) => {
                a == b || text.contains("NaN")
            }
            _ => discriminant(self) == discriminant(other),
        };
        same_step && text == other.to_string()
    }
}
