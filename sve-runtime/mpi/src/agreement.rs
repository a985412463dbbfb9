//! The start of a run: all ranks have the same settings, or all have the same error.
//!
//! Input: an ensemble on each rank. Output: its checked settings, or the error of the lowest rank
//! with an error.

use std::panic::{AssertUnwindSafe, catch_unwind};

use mpi::Threading;
use sve_runtime::ensemble::PathMethod;
use sve_runtime::ensemble::{Checkpoint, Distribution, Ensemble, EnsembleError, PartialResults};

use super::error::{Error, SentError};
use super::link::Link;
use super::message::Cause;
use super::pool::panic_message;

/// The checked ensemble and the loaded results with which a rank begins.
pub(crate) struct Beginning<'a, I: PathMethod> {
    pub(crate) distribution: Distribution<'a, I>,
    /// The checkpoint, on rank 0.
    pub(crate) checkpoint: Option<Checkpoint>,
    /// The results of the checkpoint.
    pub(crate) loaded: Option<PartialResults>,
}

/// Checks the settings on all ranks.
pub(crate) fn agree<'a, I: PathMethod + Sync>(
    ensemble: &'a Ensemble<'a, I>,
    link: &Link,
) -> Result<Beginning<'a, I>, Error> {
    let rank = link.rank();
    let mut known = None;
    let mut here = match catch_unwind(AssertUnwindSafe(|| begin(ensemble, rank))) {
        Ok(Ok(beginning)) => Ok(beginning),
        Ok(Err(error)) => {
            let message = error.to_string();
            known = Some(error);
            Err(SentError::Cause(Cause::Error { rank, message }))
        }
        Err(payload) => {
            let message = panic_message(payload.as_ref());
            Err(SentError::Cause(Cause::Panic { rank, message }))
        }
    };
    if mpi::environment::threading_support() < Threading::Funneled {
        here = Err(SentError::ThreadLevel { rank });
    }
    let own = here.as_ref().ok().map(|here| here.distribution.identity());
    let first: Option<Vec<u8>> = link.broadcast(0, (rank == 0).then_some(own));
    if let (Ok(beginning), Some(first)) = (&here, &first)
        && let Some(what) = beginning.distribution.difference(first)
    {
        let what = what.to_string();
        here = Err(SentError::Differs { rank, what });
    }
    let lowest = link.least(if here.is_err() { rank } else { link.size() });
    if lowest == link.size() {
        // No rank has an error.
        return here.map_err(|error| error.received(rank, known));
    }
    let own = here.err();
    let error: Option<SentError> = link.broadcast(lowest, (rank == lowest).then_some(own));
    match error {
        Some(error) => Err(error.received(rank, known)),
        None => link.abort(),
    }
}

fn begin<'a, I: PathMethod + Sync>(
    ensemble: &'a Ensemble<'a, I>,
    rank: i32,
) -> Result<Beginning<'a, I>, EnsembleError> {
    if rank == 0 {
        ensemble.try_checkpoint()?;
    }
    let distribution = ensemble.distribute()?;
    let checkpoint = distribution.checkpoint().filter(|_| rank == 0);
    let loaded = match &checkpoint {
        Some(checkpoint) => checkpoint.load()?,
        None => None,
    };
    Ok(Beginning {
        distribution,
        checkpoint,
        loaded,
    })
}
