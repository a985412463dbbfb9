//! Checks that the results of a run fit into memory, before they are allocated. A failed allocation
//! would abort the process.
//!
//! Input: checked settings. Output: an error that names the number that is too large.

use super::moments::COLUMN_BYTES;
use super::statistic::{Extent, Size};
use super::{Ensemble, EnsembleError};
use crate::ensemble::PathMethod;
use crate::system::StateOf;

/// Bytes of a number.
pub(super) const NUMBER: u128 = 8;

/// Smallest number of results of blocks in memory at the same time: a result that is filled, and a
/// result into which it is merged.
pub(super) const AT_ONCE: u128 = 2;

/// Checks that the statistics of an ensemble fit into memory and, if they are kept, the final
/// states.
pub(super) fn check_all<I: PathMethod>(
    ensemble: &Ensemble<'_, I>,
    extent: &Extent<'_>,
) -> Result<(), EnsembleError> {
    for request in &ensemble.observed.statistics {
        check(request.size(extent))?;
    }
    if !ensemble.keep_final_states {
        return Ok(());
    }
    let (paths, state) = (extent.paths, size_of::<StateOf<I::System>>() as u128);
    check(Size {
        bytes: u128::from(paths) * (NUMBER + state),
        what: format!("the final states of {paths} paths"),
        remedy: "run fewer paths, or take them in shards",
    })
}

/// Checks that the differences of the rows of a sweep fit into memory.
pub(super) fn differences<I: PathMethod>(
    ensemble: &Ensemble<'_, I>,
    records: usize,
    differences: usize,
) -> Result<(), EnsembleError> {
    let of_record = NUMBER + u128::from(COLUMN_BYTES) * ensemble.observed.names.len() as u128;
    let bytes = AT_ONCE * of_record * records as u128 * differences as u128;
    check(Size {
        bytes,
        what: format!("{differences} differences of rows at {records} recorded times"),
        remedy: "take a shorter table, or record less often with `every`",
    })
}

/// Checks that so many bytes can be allocated.
fn check(size: Size) -> Result<(), EnsembleError> {
    let Size {
        bytes,
        what,
        remedy,
    } = size;
    let fits =
        usize::try_from(bytes).is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok());
    if fits {
        return Ok(());
    }
    Err(EnsembleError::TooLarge {
        what,
        bytes,
        remedy,
    })
}
