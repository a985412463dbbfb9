//! Checks that the results of a run fit into memory, before they are allocated. A failed allocation would abort the process.
//!
//! Input: checked settings. Output: the number of records, or an error that names the number that is too large.

use super::histogram::HistogramRequest;
use super::joint::ROW_BYTES;
use super::moments::COLUMN_BYTES;
use super::{Ensemble, EnsembleError};
use crate::method::Method;
use crate::system::StateOf;

/// Bytes of a number.
const NUMBER: u128 = 8;

/// Smallest number of results of blocks in memory at the same time: one that is filled, and one into which it is merged.
const AT_ONCE: u128 = 2;

/// Checks that the recorded observables and histograms of an ensemble fit into memory, and, if they are kept, the final states of so many
/// paths. Returns the number of recorded times.
pub(super) fn records<I: Method>(
    ensemble: &Ensemble<'_, I>,
    steps: u64,
    every: u64,
    paths: u64,
) -> Result<usize, EnsembleError> {
    let records = u128::from(steps.div_ceil(every)) + 1;
    let observables = ensemble.names.len();
    let of_paths = NUMBER + u128::from(COLUMN_BYTES) * observables as u128;
    let of_record = AT_ONCE * of_paths * (1 + u128::from(ensemble.antithetic)) + NUMBER;
    check(records * of_record, || {
        let what = format!("{records} recorded times of {observables} observables");
        (what, "record less often with `record_every`")
    })?;
    // records that fit into memory can be counted by a `usize`
    let length = usize::try_from(records).unwrap_or(usize::MAX);
    for request in &ensemble.histograms {
        let HistogramRequest { name, bins, .. } = request;
        let bytes = request.counts(length).saturating_mul(AT_ONCE * NUMBER);
        check(bytes, || {
            let what = format!(
                "the histogram of `{name}` with {bins} bins at {} recorded times",
                if request.always { records } else { 1 }
            );
            (what, "take fewer bins, or `final_histogram`")
        })?;
    }
    for request in &ensemble.joints {
        let bytes = request.rows(length).saturating_mul(AT_ONCE * ROW_BYTES);
        check(bytes, || {
            let (first, second) = (&request.first, &request.second);
            let what = format!("the covariances of `{first}` and `{second}`");
            (what, "record less often with `record_every`")
        })?;
    }
    for request in &ensemble.quantiles {
        // all values of a level, for each time
        let values = u128::from(paths).min(request.size as u128);
        let bytes = records
            .saturating_mul(values)
            .saturating_mul(AT_ONCE * NUMBER);
        check(bytes, || {
            let (name, size) = (&request.name, request.size);
            let what =
                format!("quantiles of `{name}` with {size} values at {records} recorded times");
            (
                what,
                "keep fewer values, or record less often with `record_every`",
            )
        })?;
    }
    if ensemble.keep_final_states {
        let state = size_of::<StateOf<I::System>>() as u128;
        check(u128::from(paths) * (NUMBER + state), || {
            let what = format!("the final states of {paths} paths");
            (what, "run fewer paths, or take them in shards")
        })?;
    }
    Ok(length)
}

/// Checks that the differences of the rows of a sweep fit into memory.
pub(super) fn differences<I: Method>(
    ensemble: &Ensemble<'_, I>,
    records: usize,
    differences: usize,
) -> Result<(), EnsembleError> {
    let of_record = NUMBER + u128::from(COLUMN_BYTES) * ensemble.names.len() as u128;
    let bytes = AT_ONCE * of_record * records as u128 * differences as u128;
    check(bytes, || {
        let what = format!("{differences} differences of rows at {records} recorded times");
        (
            what,
            "take a shorter table, or record less often with `record_every`",
        )
    })
}

/// Checks that so many bytes can be allocated.
fn check(bytes: u128, described: impl Fn() -> (String, &'static str)) -> Result<(), EnsembleError> {
    let fits =
        usize::try_from(bytes).is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok());
    if fits {
        return Ok(());
    }
    let (what, remedy) = described();
    Err(EnsembleError::TooLarge {
        what,
        bytes,
        remedy,
    })
}
