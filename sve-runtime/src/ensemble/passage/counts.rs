//! Counts of passages: how many paths passed, and how many were lost from sight, between two recorded times.
//!
//! Input: the passages and failures of the paths of a block. Output: counts and sums of times, which merge by addition. Invariant: the passages of a block
//! are added in the order of its paths, so the sums have the same bits for any layout of the lanes.

use std::collections::{BTreeMap, BTreeSet};

use super::super::failure::Failure;
use super::super::settings::Settings;
use crate::method::Method;

/// What is counted of a function between recorded times: entry `j` is about the times after record `j − 1` until record `j`, entry 0 about the start.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in super::super) struct PassageCounts {
    /// Paths that passed.
    pub(in super::super) passed: Vec<u64>,
    /// The sum of their times since record `j − 1`.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    pub(in super::super) passed_time: Vec<f64>,
    /// Paths that ended before they passed: they failed, or were stopped by another function.
    pub(in super::super) censored: Vec<u64>,
    /// The sum of their times since record `j − 1`.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    pub(in super::super) censored_time: Vec<f64>,
}

impl PassageCounts {
    pub(in super::super) fn new(records: usize) -> Self {
        Self {
            passed: vec![0; records],
            passed_time: vec![0.0; records],
            censored: vec![0; records],
            censored_time: vec![0.0; records],
        }
    }

    /// Adds the counts of other paths.
    pub(in super::super) fn merge(&mut self, other: &Self) {
        for record in 0..self.passed.len() {
            self.passed[record] += other.passed[record];
            self.passed_time[record] += other.passed_time[record];
            self.censored[record] += other.censored[record];
            self.censored_time[record] += other.censored_time[record];
        }
    }

    /// Returns whether the counts have so many records and at most so many paths.
    #[cfg(feature = "serde")]
    pub(in super::super) fn fit(&self, records: usize, paths: u64) -> bool {
        let counts = self.passed.iter().chain(&self.censored);
        let counted = counts.fold(0_u64, |sum, &count| sum.saturating_add(count));
        let lengths = [self.passed.len(), self.censored.len()];
        let times = [&self.passed_time, &self.censored_time];
        lengths.iter().all(|&length| length == records)
            && times.iter().all(|times| times.len() == records)
            && counted <= paths
    }
}

/// The end of the observation of a path: after so many steps, the last of which may be a part of one, at a time.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct End {
    pub(in super::super) path: u64,
    pub(in super::super) step: u64,
    pub(in super::super) t: f64,
}

/// The passage of a path.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Passage {
    pub(in super::super) end: End,
    /// The number of the function.
    pub(in super::super) function: usize,
    pub(in super::super) stops: bool,
}

/// Counts the passages and failures of the paths of a block, for each of so many functions.
pub(in super::super) fn count<I: Method>(
    settings: &Settings<'_, I>,
    mut passages: Vec<Passage>,
    failures: &[Failure],
    functions: usize,
) -> Vec<PassageCounts> {
    let mut counts = vec![PassageCounts::new(settings.records); functions];
    let place = |end: End| {
        let record = settings.record_after(end.step);
        let from = settings.time(settings.step_of(record.saturating_sub(1)));
        (record, (end.t - from).abs())
    };
    let mut ends = BTreeMap::new();
    for &Failure { path, step, t, .. } in failures {
        ends.insert(path, End { path, step, t });
    }
    // a path that failed where it was to stop has not passed
    passages.retain(|passage| !(passage.stops && ends.contains_key(&passage.end.path)));
    passages.sort_by_key(|passage| passage.end.path);
    let mut passed = BTreeSet::new();
    for passage in passages {
        let (record, time) = place(passage.end);
        let counts = &mut counts[passage.function];
        counts.passed[record] += 1;
        counts.passed_time[record] += time;
        passed.insert((passage.end.path, passage.function));
        if passage.stops {
            ends.insert(passage.end.path, passage.end);
        }
    }
    for (path, end) in ends {
        let (record, time) = place(end);
        for (function, counts) in counts.iter_mut().enumerate() {
            if !passed.contains(&(path, function)) {
                counts.censored[record] += 1;
                counts.censored_time[record] += time;
            }
        }
    }
    counts
}
