//! Errors of studies: invalid settings, failed references, files of results. Each message says what
//! to write instead.

use crate::error::StepError;
use crate::noise::NoiseError;
use crate::readable::debug_is_display;

/// The reason why a study could not be run, or a file of results could not be read.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// A setting that has no sensible default was not given.
    #[error("the study does not know its {what}: add `{write}`")]
    Missing {
        /// The missing setting.
        what: &'static str,
        /// A call that gives it.
        write: &'static str,
    },
    /// A number that has to be at least 1 is 0.
    #[error("`{setting}` was given 0 and needs at least 1")]
    Zero {
        /// The setting.
        setting: &'static str,
    },
    /// The horizon is not a positive finite time.
    #[error("the horizon {horizon} must be positive and finite")]
    Horizon {
        /// The horizon given.
        horizon: f64,
    },
    /// A number of steps that cannot share the path of the largest.
    #[error(
        "{steps} steps do not divide the {finest} of the finest run: increments are summed from it; \
         take numbers that do, such as powers of two"
    )]
    Steps {
        /// The number of steps.
        steps: usize,
        /// The largest number of steps.
        finest: usize,
    },
    /// The steps of a fine reference are more than can be counted.
    #[error(
        "`fine(…, {factor})` asks for {factor} times {finest} steps of the reference, which are more than 2^64; take a smaller factor"
    )]
    TooFine {
        /// The largest number of steps.
        finest: usize,
        /// Steps of the reference for each of these.
        factor: usize,
    },
    /// The reference is one of the methods, with the same steps.
    #[error(
        "the reference is the method `{method}` with the same {steps} steps: its error would be 0, and orders wrong; \
         take a factor of 16 or more in `fine`, or another reference"
    )]
    OwnReference {
        /// The method.
        method: String,
        /// The largest number of steps.
        steps: usize,
    },
    /// Two methods or two observables have the same name, or a number of steps is listed twice.
    #[error("there are two of `{name}` among the {what}: each needs a name of its own")]
    Twice {
        /// The list that contains both.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// The paths could not be recorded.
    #[error("the Brownian path {path} could not be recorded: {source}")]
    Noise {
        /// Which path.
        path: u64,
        /// The error of the noise.
        source: NoiseError,
    },
    /// `exact_paths` returned a path that does not fit.
    #[error(
        "`exact_paths` returned path {path} with {steps} steps of {h:e} and {processes} processes; \
         wanted are {wanted} steps of {length:e}, and as many processes as the system has"
    )]
    Drawn {
        /// Which path.
        path: u64,
        /// Its steps.
        steps: usize,
        /// Its step size.
        h: f64,
        /// Its processes.
        processes: usize,
        /// The steps wanted.
        wanted: usize,
        /// The step size wanted.
        length: f64,
    },
    /// The reference could not be computed, so there is nothing to compare with.
    #[error(
        "the reference of path {path} failed: {source}; take a larger `factor`, or a shorter horizon"
    )]
    Reference {
        /// Which path.
        path: u64,
        /// The reason.
        source: StepError,
    },
    /// A value of the reference is not a finite number.
    #[error(
        "the reference of path {path} is not finite: look at the solution that was given as exact, and at the observables there"
    )]
    NotFinite {
        /// Which path.
        path: u64,
    },
    /// A line of a file of results could not be read.
    #[error("line {line}: {what}")]
    Csv {
        /// Which line, from 1.
        line: usize,
        /// The mistake in it.
        what: String,
    },
    /// Reading or writing failed.
    #[error("{0}")]
    Io(#[from] std::io::Error),
}

debug_is_display!(StudyError);
