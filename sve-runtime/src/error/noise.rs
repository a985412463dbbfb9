//! Errors of noise sources. Each message has the numbers in question and what to change.

use crate::readable::debug_is_display;

/// Why a noise source could not be made, or could not give the increments of a step.
///
/// ```
/// use sve_runtime::noise::{NoiseError, Recorded};
///
/// let error = Recorded::new(0.0, [[0.2]]).unwrap_err();
/// assert_eq!(error, NoiseError::InvalidStep { h: 0.0 });
/// assert_eq!(error.to_string(), "the step size h = 0 must be finite and not zero");
/// ```
#[derive(Clone, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum NoiseError {
    /// A recorded path is over. A [`Trajectory`](crate::Trajectory) ends there without an error.
    #[error(
        "the recorded path has {recorded} steps and step {step} (from 0) was asked for; record more steps"
    )]
    Exhausted {
        /// Step asked for, from 0.
        step: u64,
        /// Steps recorded.
        recorded: u64,
    },
    /// A recorded path was made for another step size.
    #[error(
        "the path was recorded with h = {recorded:e}, and h = {h:e} was asked for; use the recorded step, or `coarsen` the path"
    )]
    StepSize {
        /// Step size asked for.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// Step size of the recording.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        recorded: f64,
    },
    /// A recorded path has another number of processes.
    #[error(
        "the path was recorded with {recorded} Wiener processes, and the system has {asked}; record {asked}"
    )]
    Processes {
        /// Processes that the system has.
        asked: usize,
        /// Processes recorded.
        recorded: usize,
    },
    /// Truncation with a time τ needs `h < τ`.
    #[error(
        "increments truncated at √(2k ln(τ/h)) standard deviations need h < τ, and h = {h}, τ = {tau}; \
         give their number with `deviations`, which has no such limit, or take a smaller step"
    )]
    TruncationStep {
        /// Step size asked for.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// The time τ.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        tau: f64,
    },
    /// The exponent of a truncation is below 1 or not finite, or its time is not positive and
    /// finite.
    #[error(
        "the truncation exponent k = {k} must be finite and at least 1, where 2 keeps strong order 1, \
         and the time τ = {tau} positive and finite"
    )]
    TruncationExponent {
        /// Exponent given.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        k: f64,
        /// The time τ.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        tau: f64,
    },
    /// The bound of a truncation is not a positive finite number of standard deviations.
    #[error(
        "increments cannot be truncated at {deviations} standard deviations: the bound must be positive and finite, for example 6"
    )]
    TruncationDeviations {
        /// Standard deviations given.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        deviations: f64,
    },
    /// A path that was entered at a step has no step with such a number.
    #[error(
        "step {step} of a path that was entered at its step {first} has a number above 2^64 − 1: enter it earlier"
    )]
    StepNumber {
        /// Step asked for, from 0 where the path was entered.
        step: u64,
        /// Step at which the path was entered.
        first: u64,
    },
    /// The step size is zero or not finite.
    #[error("the step size h = {h} must be finite and not zero")]
    InvalidStep {
        /// The step size given.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
    },
    /// An increment to be recorded is NaN or infinite.
    #[error(
        "the increment of process {process} over step {step} (both from 0) is {value}: increments must be finite; \
         look at what produced this value"
    )]
    NonFinite {
        /// Step, from 0.
        step: u64,
        /// Process, from 0.
        process: usize,
        /// Value given.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        value: f64,
    },
    /// The source draws no increments for stages.
    #[error(
        "this source has no increments of stages, for which the rule with {stages} stages asks: \
         use `Wiener`, `Truncated`, `FromRng`, or a path of `Recorded::record_stages`"
    )]
    NoStages {
        /// The stages of the rule.
        stages: usize,
    },
    /// A path was recorded with fewer stages, or its rows cannot be divided into stages.
    #[error(
        "the path was recorded with {recorded} stages a step, and the rule has {asked}; record {asked} or more"
    )]
    Stages {
        /// The stages of the rule.
        asked: usize,
        /// The stages of the path, 1 where it has an increment for each process only.
        recorded: usize,
    },
    /// The steps of a recorded path cannot be grouped by that factor.
    #[error(
        "a path of {recorded} steps cannot be coarsened by {factor}; \
         take a divisor of {recorded}, or record a multiple of the factor"
    )]
    Coarsen {
        /// Steps recorded.
        recorded: u64,
        /// Steps that were to become one.
        factor: u64,
    },
    /// A step cannot be halved that often.
    #[error(
        "a step can be halved at most 63 times, and a refinement of depth {depth} was asked for"
    )]
    Depth {
        /// Depth asked for.
        depth: u32,
    },
    /// A recording does not fit into memory.
    #[error(
        "{steps} steps of {processes} Wiener processes do not fit into memory; \
         record fewer, or let the trajectory draw its increments as it goes"
    )]
    TooLong {
        /// Steps that were to be recorded.
        steps: u64,
        /// Processes that were to be recorded.
        processes: usize,
    },
}

debug_is_display!(NoiseError);

/// Accepts finite step sizes other than zero. Increments over a step back in time have the
/// variance |h|.
#[inline]
pub(crate) fn check_step(h: f64) -> Result<(), NoiseError> {
    if h != 0.0 && h.is_finite() {
        Ok(())
    } else {
        Err(NoiseError::InvalidStep { h })
    }
}
