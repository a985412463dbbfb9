//! The differences between two runs, and the damage of a checkpoint.

use crate::readable::debug_is_display;

/// The damage of a checkpoint.
#[cfg(feature = "checkpoint")]
#[derive(Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Damage {
    /// The length of the file differs from the length in its header.
    #[error("it has {found} bytes where {expected} were written")]
    Length {
        /// Number of bytes that were written. If the header is incomplete, the least possible
        /// number.
        expected: u64,
        /// Number of bytes in the file.
        found: u64,
    },
    /// The checksum of the content differs from the checksum in the header.
    #[error("its content has the checksum {found:016x} where {expected:016x} was written")]
    Checksum {
        /// Checksum that was written.
        expected: u64,
        /// Checksum of the content of the file.
        found: u64,
    },
    /// The checksum is right, but the content is not the results of a run.
    #[error("its content does not fit together, though its checksum is right")]
    Content,
}

/// A difference between two runs.
#[derive(Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Difference {
    /// Names or order of the observables.
    #[error("observables (their names and order)")]
    Observables,
    /// The requests of a statistic, as `"histograms"`, `"covariances"` or `"quantiles"`.
    #[error("{0}")]
    Statistic(&'static str),
    /// The recorded times.
    #[error("recorded times")]
    Times,
    /// The number of paths.
    #[error("a number of paths")]
    Paths,
    /// The part of the run.
    #[error("a shard")]
    Shard,
    /// The seed.
    #[error("a seed")]
    Seed,
    /// The noise.
    #[error("a law of the noise (truncation, three points, antithetic pairs or none)")]
    Noise,
    /// Other settings of the ensemble: step size, number of steps, bounds, kinds of observables,
    /// stops, `settle`, `refine`, whether final states are kept.
    #[error(
        "settings (step size, number of steps, bounds, kinds of observables, stops, `settle`, `refine`, or whether final states are kept)"
    )]
    Settings,
    /// The formulas of the system: another program.
    #[error("formulas of the system (another program)")]
    Formulas,
    /// The values of the system's parameters.
    #[error("values of the system's parameters")]
    Parameters,
    /// The method or its options.
    #[error("a method (rule, options of Newton's method, or the name of the inputs)")]
    Method,
    /// The starts of the paths.
    #[error("starts of the paths")]
    Starts,
    /// The values along the paths.
    #[error("values along its paths (observables, or functions of another machine)")]
    Values,
}

debug_is_display!(Difference);
#[cfg(feature = "checkpoint")]
debug_is_display!(Damage);
