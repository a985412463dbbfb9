//! The errors of runs on several ranks.
//!
//! Invariant: all ranks return the same error. On the rank where it occurred it has its source as
//! well.

use serde::{Deserialize, Serialize};
use sve_runtime::ensemble::{EnsembleError, Failure};

use super::message::Cause;

/// The reason why a run on several ranks gave no summary. All ranks return the same error, with the
/// rank where it occurred.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A rank has an error: an invalid setting, or a checkpoint that cannot be read or written when
    /// the run starts.
    #[error("rank {rank}: {message}")]
    OnRank {
        /// The rank.
        rank: i32,
        /// The message of its error.
        message: String,
        /// The error itself, on the rank where it occurred.
        #[source]
        source: Option<Box<EnsembleError>>,
    },
    /// A closure or a function of the system panicked.
    #[error("rank {rank} panicked: {message}")]
    Panicked {
        /// The rank.
        rank: i32,
        /// The message of the panic.
        message: String,
    },
    /// A rank runs another ensemble than rank 0.
    #[error(
        "rank {rank} has {what} of its own, and rank 0 others: every rank has to be given the same ensemble, by the same program"
    )]
    Differs {
        /// The rank.
        rank: i32,
        /// The difference.
        what: String,
    },
    /// MPI was initialised for a program without threads.
    #[error(
        "rank {rank}: MPI was initialised without threads, and an ensemble has some; write \
         `mpi::initialize_with_threading(mpi::Threading::Funneled)`"
    )]
    ThreadLevel {
        /// The rank.
        rank: i32,
    },
    /// A path failed, and `stop_on_failure` was set. The error describes the failing path with the
    /// lowest number, as on one machine.
    #[error("{0}")]
    Failed(#[source] Box<Failure>),
    /// The run was stopped before a path ended.
    #[error("{0}")]
    NothingRun(#[source] Box<EnsembleError>),
    /// Results of some paths are missing, which is a mistake of this package.
    #[error("the ranks returned {found} of {expected} paths: report this as an error of sve-mpi")]
    Lost {
        /// Paths in the results.
        found: u64,
        /// Paths of the run.
        expected: u64,
    },
}

/// Prints the message: a `main` that returns the error prints it in this form.
impl core::fmt::Debug for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        core::fmt::Display::fmt(self, f)
    }
}

/// An error in the form in which it is sent.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum SentError {
    Cause(Cause),
    Differs { rank: i32, what: String },
    ThreadLevel { rank: i32 },
    NothingRun,
    Lost { found: u64, expected: u64 },
}

impl SentError {
    /// Returns the error on a rank, with the source that this rank knows.
    pub(crate) fn received(self, here: i32, known: Option<EnsembleError>) -> Error {
        match self {
            Self::Cause(Cause::Error { rank, message }) => Error::OnRank {
                rank,
                message,
                source: known.filter(|_| rank == here).map(Box::new),
            },
            Self::Cause(Cause::Panic { rank, message }) => Error::Panicked { rank, message },
            Self::Cause(Cause::Failed(failure)) => Error::Failed(failure),
            Self::Differs { rank, what } => Error::Differs { rank, what },
            Self::ThreadLevel { rank } => Error::ThreadLevel { rank },
            Self::NothingRun => Error::NothingRun(Box::new(EnsembleError::NothingRun)),
            Self::Lost { found, expected } => Error::Lost { found, expected },
        }
    }
}
