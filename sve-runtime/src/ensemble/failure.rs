//! A path that failed: which, when and why.

use crate::error::StepError;

/// How many failures a summary describes, with number, time and error: those of the lowest paths. All are counted.
pub const FAILURES_KEPT: usize = 256;

/// A path that failed. It has no part in the statistics from the next record on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("path {path} failed after {step} steps, at t = {t}: {cause}")]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Failure {
    /// Which path, from 0; [`replay`](super::Ensemble::replay) repeats it.
    pub path: u64,
    /// Steps that it had made.
    pub step: u64,
    /// The time that it had reached.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
    pub t: f64,
    /// Why it failed.
    #[source]
    pub cause: Cause,
}

/// Why a path failed.
#[derive(Clone, Debug, thiserror::Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Cause {
    /// Its state could not be stepped.
    #[error("{0}")]
    Step(#[source] StepError),
    /// It starts at another time than path 0.
    #[error(
        "it starts at t = {t}, and path 0 at t = {expected}: the paths of an ensemble start together"
    )]
    StartTime {
        /// Its own time.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// The time of path 0.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        expected: f64,
    },
    /// An observable returned an error.
    #[error("the observable `{name}` failed: {error}")]
    Observable {
        /// Which.
        name: String,
        /// What it returned.
        #[source]
        error: StepError,
    },
    /// An observable returned a number that is not finite.
    #[error(
        "the observable `{name}` is {value}: statistics need finite numbers; look at what it computes there"
    )]
    NotFinite {
        /// Which.
        name: String,
        /// What it returned.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        value: f64,
    },
    /// An observable left the range that was given for it.
    #[error(
        "the observable `{name}` is {value:e}, outside of the bound {low:e}..={high:e} that was given for it"
    )]
    OutOfBound {
        /// Which.
        name: String,
        /// What it returned.
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

/// Equal in all numbers; NaN, which many causes have, equals NaN.
impl PartialEq for Cause {
    fn eq(&self, other: &Self) -> bool {
        // the printed form of a number is the shortest that gives it back
        format!("{self:?}") == format!("{other:?}")
    }
}
