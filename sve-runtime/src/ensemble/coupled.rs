//! Several runs of an ensemble whose paths have common noise, stepped together: the rows of a
//! sweep, the two steps of a level.
//!
//! Input: the settings of the runs, which have the same recorded times. Output: for each block the
//! results of each run, and the results of the differences of each two runs. Invariant: a run has
//! the same results as alone, bit for bit. A difference has the paths that have failed in neither
//! run.

use super::EnsembleError;
use super::fingerprint::Fingerprint;
use super::info::Info;
use super::merge_tree::PartialResult;
use super::path_block::PathBlock;
use super::settings::Settings;
use super::statistic::AnyRequest;
use crate::ensemble::PathMethod;
use crate::lanes::Lane;

/// Runs with common noise.
pub(super) struct Coupled<'a, I: PathMethod> {
    pub(super) legs: Vec<Settings<'a, I>>,
}

/// Returns the number of the difference of two runs, `from` before `to`, among all differences.
pub(super) fn difference_number(from: usize, to: usize) -> usize {
    to * to.saturating_sub(1) / 2 + from
}

impl<I: PathMethod> Coupled<'_, I> {
    /// Returns the number of differences.
    pub(super) fn differences(&self) -> usize {
        difference_number(0, self.legs.len())
    }

    /// Returns the data of the differences to a run.
    pub(super) fn info_of_differences(&self, to: usize, fingerprint: Fingerprint) -> Info {
        let mut info = self.legs[to].info(fingerprint);
        info.statistics.retain(AnyRequest::is_of_differences);
        Info {
            coordinates: 0,
            momenta: 0,
            ..info
        }
    }
}

impl<I: PathMethod> Coupled<'_, I> {
    /// Runs the paths of a block in all runs. Returns the results of the runs, then the results of
    /// the differences.
    pub(super) fn run_block(&self, block: u64) -> Result<Vec<PartialResult>, EnsembleError> {
        let legs = self.legs.iter();
        let paths: Result<Vec<_>, _> = legs
            .map(|leg| PathBlock::new(*leg, block..block + 1, None))
            .collect();
        let mut paths = paths?;
        let mut results: Vec<_> = self.legs.iter().map(|leg| leg.empty(block)).collect();
        let mut differences: Vec<_> = (0..self.differences())
            .map(|_| self.legs[0].empty(block).of_differences())
            .collect();
        for record in 0..self.legs[0].records {
            for ((leg, paths), result) in self.legs.iter().zip(&mut paths).zip(&mut results) {
                paths.advance(leg.step_of(record));
                paths.record(record, core::slice::from_mut(result));
            }
            for to in 1..paths.len() {
                for from in 0..to {
                    let result = &mut differences[difference_number(from, to)];
                    add_difference(&paths[from], &paths[to], record, result);
                }
            }
        }
        for (paths, result) in paths.into_iter().zip(&mut results) {
            paths.finish(core::slice::from_mut(result));
        }
        let mut failures = results.iter().filter_map(|result| result.failures.first());
        if self.legs[0].ensemble.stop_on_failure
            && let Some(first) = failures.by_ref().min_by_key(|failure| failure.path)
        {
            return Err(EnsembleError::Failed(Box::new(first.clone())));
        }
        results.append(&mut differences);
        Ok(results)
    }
}

/// Adds the differences of the observables that two runs have just recorded.
fn add_difference<I: PathMethod>(
    from: &PathBlock<'_, I>,
    to: &PathBlock<'_, I>,
    record: usize,
    result: &mut PartialResult,
) {
    let [from, to] = [&from.records, &to.records];
    let counted = from.counted.iter().zip(&to.counted);
    for ((from, to), counted) in from.values.iter().zip(&to.values).zip(counted) {
        let pairs = to.iter().zip(from);
        let values: Vec<Lane> = pairs
            .map(|(to, from)| core::array::from_fn(|lane| to[lane] - from[lane]))
            .collect();
        result.add(record, &values, counted.0 & counted.1, &[]);
    }
}
