//! Counts of passages: how many paths passed, and how many were lost from sight, in each of many
//! short bins of time.
//!
//! Input: the passages and failures of the paths of a block. Output: counts and sums of times,
//! which merge by addition. Invariant: the passages of a block are added in the order of its paths,
//! so the sums have the same bits for any layout of the lanes.
//!
//! The bins belong to the run, so counts of different blocks add up, and their number does not grow
//! with the paths. All recorded times and, in runs of up to [`BINS`] steps, the times of all steps
//! are ends of bins. Within a bin the order of the ends is not kept.

use std::collections::{BTreeMap, BTreeSet};

use super::super::difference::Difference;
use super::super::failure::Failure;
use super::super::settings::Settings;
use super::super::sizes::{AT_ONCE, NUMBER};
use super::super::statistic::{Extent, Size, Statistic};
use super::super::summary::Summary;
use super::survival::Passages;
use crate::ensemble::PathMethod;

/// Number of bins of a run, unless it has more recorded times. The effect of the order of the ends
/// within a bin is at most of the order of 1/4096 of the run, and a bin has 5 to 40 bytes.
const BINS: u64 = 4096;

/// The bins of a run. Bin 0 is the start; of the bins after it, as many are between each two
/// recorded times.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Grid {
    /// Steps between two recorded times.
    every: u64,
    /// Equal parts of a step.
    parts: u64,
    /// Parts in a bin: 1 if a step has several of them.
    group: u64,
}

impl Grid {
    pub(in super::super) fn new(steps: u64, every: u64) -> Self {
        Self {
            every: every.min(steps),
            parts: (BINS / steps).max(1),
            group: steps.div_ceil(BINS),
        }
    }

    /// Returns the number of bins between two recorded times.
    pub(in super::super) fn between_records(self) -> u64 {
        (self.every * self.parts).div_ceil(self.group)
    }
}

/// The paths whose observation ends in a bin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in super::super) struct Ends {
    /// Paths that passed.
    pub(in super::super) passed: u64,
    /// Paths that ended within the bin before they passed: they failed, or were stopped by another
    /// function.
    pub(in super::super) censored: u64,
    /// Paths that failed at the end of the bin, after all its passages.
    pub(in super::super) censored_at_end: u64,
}

/// The request of the passages of a function.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in super::super) struct PassageRequest {
    pub(in super::super) name: String,
    /// Number of the function.
    pub(in super::super) function: usize,
}

/// The counts of the passages of a function.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in super::super) struct PassageCounts {
    request: PassageRequest,
    /// Number of bins between two recorded times.
    pub(in super::super) between_records: u64,
    /// The bins in which a path ends.
    pub(in super::super) bins: BTreeMap<u64, Ends>,
    /// The times since record `j − 1` of the paths that end after it until record `j`, added up;
    /// entry 0 is about the start.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    pub(in super::super) times: Vec<f64>,
}

impl Statistic for PassageCounts {
    type Request = PassageRequest;

    const DIFFERENCE: Difference = Difference::Observables;

    fn size(request: &PassageRequest, extent: &Extent<'_>) -> Size {
        let records = extent.records;
        Size {
            bytes: u128::from(records) * AT_ONCE * NUMBER,
            what: format!(
                "the passages of `{}` at {records} recorded times",
                request.name
            ),
            remedy: "record less often with `every`",
        }
    }

    fn empty(request: &PassageRequest, extent: &Extent<'_>) -> Self {
        Self {
            request: request.clone(),
            between_records: extent.passage_bins,
            bins: BTreeMap::new(),
            times: vec![0.0; extent.rows()],
        }
    }

    fn end(&mut self, ends: &PathEnds) {
        let mut passed = BTreeSet::new();
        let function = self.request.function;
        let own = (ends.passages.iter()).filter(|(passage, _)| passage.function == function);
        for (passage, place) in own {
            self.count(place, |ends| &mut ends.passed);
            passed.insert(passage.end.path);
        }
        let others = ends.last.iter().filter(|(path, _)| !passed.contains(path));
        for (_, place) in others {
            self.count(place, |ends| {
                if place.is_at_end {
                    &mut ends.censored_at_end
                } else {
                    &mut ends.censored
                }
            });
        }
    }

    fn merge(&mut self, _: &[u64], other: &Self, _: &[u64]) {
        for (bin, other) in &other.bins {
            let ends = self.bins.entry(*bin).or_default();
            ends.passed += other.passed;
            ends.censored += other.censored;
            ends.censored_at_end += other.censored_at_end;
        }
        for (sum, time) in self.times.iter_mut().zip(&other.times) {
            *sum += time;
        }
    }

    #[cfg(feature = "serde")]
    fn fits(&self, request: &PassageRequest, extent: &Extent<'_>, _: &[u64]) -> bool {
        let counts = self.bins.values();
        let counts = counts.flat_map(|ends| [ends.passed, ends.censored, ends.censored_at_end]);
        let counted = counts.fold(0, u64::saturating_add);
        let last = extent.passage_bins.saturating_mul(extent.records - 1);
        self.request == *request
            && self.between_records == extent.passage_bins
            && self.times.len() == extent.rows()
            && self.bins.keys().all(|&bin| bin <= last)
            && counted <= extent.paths
    }

    fn show(self, summary: &mut Summary) {
        let name = self.request.name.clone();
        let passages = Passages::new(name, summary.times().to_vec(), summary.paths(), self);
        summary.shown.push(passages);
    }
}

impl PassageCounts {
    fn count(&mut self, place: &Place, count: impl FnOnce(&mut Ends) -> &mut u64) {
        *count(self.bins.entry(place.bin).or_default()) += 1;
        self.times[place.record] += place.time;
    }
}

impl Summary {
    /// The first passages through the zeros of functions, in the order in which they were given.
    pub fn passages(&self) -> &[Passages] {
        self.shown.all()
    }

    /// The first passages through the zero of a function, from
    /// [`stop_at`](super::super::Ensemble::stop_at) or
    /// [`first_passage`](super::super::Ensemble::first_passage).
    pub fn passage(&self, name: &str) -> Option<&Passages> {
        self.passages().iter().find(|p| p.name() == name)
    }
}

/// The end of the observation of a path: a number of steps, the last of which may be a part of a
/// step, and a time.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct End {
    pub(in super::super) path: u64,
    pub(in super::super) step: u64,
    pub(in super::super) t: f64,
}

/// The place of an end among the records and bins of a run.
#[derive(Clone, Copy)]
struct Place {
    /// The first recorded time that is not before it.
    record: usize,
    /// The time since the record before.
    time: f64,
    bin: u64,
    /// The place is the end of the bin.
    is_at_end: bool,
}

impl Place {
    fn of<I: PathMethod>(end: End, settings: &Settings<'_, I>) -> Self {
        let (grid, step) = (settings.passage_grid(), end.step);
        let record = settings.record_after(step);
        let from = settings.step_of(record.saturating_sub(1));
        let time = (end.t - settings.time(from)).abs();
        if step == 0 {
            let (bin, is_at_end) = (0, true);
            return Self {
                record,
                time,
                bin,
                is_at_end,
            };
        }
        let fraction = (end.t - settings.time(step - 1)) / settings.h;
        let parts = grid.parts as f64;
        // a number from 1 to `parts`
        #[allow(clippy::cast_sign_loss)]
        let within = (fraction * parts).ceil().clamp(1.0, parts) as u64;
        let part = (step - 1 - from) * grid.parts + within;
        let is_step = end.t == settings.time(step);
        Self {
            record,
            time,
            bin: (record as u64 - 1) * grid.between_records() + part.div_ceil(grid.group),
            is_at_end: is_step && (part.is_multiple_of(grid.group) || settings.records_after(step)),
        }
    }
}

/// The passage of a path.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Passage {
    pub(in super::super) end: End,
    /// The number of the function.
    pub(in super::super) function: usize,
    pub(in super::super) stops: bool,
}

/// The ends of the observation of the paths of a block, in the order of the paths.
pub(in super::super) struct PathEnds {
    /// The passages, with their places.
    passages: Vec<(Passage, Place)>,
    /// The places at which paths failed or were stopped, by path.
    last: BTreeMap<u64, Place>,
}

impl PathEnds {
    /// Sorts the passages of a block. A path that failed where it was to stop has not passed.
    pub(in super::super) fn new<I: PathMethod>(
        settings: &Settings<'_, I>,
        passages: impl Iterator<Item = Passage>,
        failures: &[Failure],
    ) -> Self {
        let of_failure = |&Failure { path, step, t, .. }: &Failure| {
            (path, Place::of(End { path, step, t }, settings))
        };
        let mut last: BTreeMap<u64, Place> = failures.iter().map(of_failure).collect();
        let has_passed = |p: &Passage| !(p.stops && last.contains_key(&p.end.path));
        let with_place = |p: Passage| (p, Place::of(p.end, settings));
        let mut passages: Vec<_> = passages.filter(has_passed).map(with_place).collect();
        passages.sort_by_key(|(passage, _)| passage.end.path);
        let stops = passages.iter().filter(|(passage, _)| passage.stops);
        last.extend(stops.map(|(passage, place)| (passage.end.path, *place)));
        Self { passages, last }
    }
}
