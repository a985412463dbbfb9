//! The records of blocks of paths: observables at a recorded time, failures and final states at the
//! end.
//!
//! Input: the states of some blocks. Output: their partial results. Invariant: a path on which an
//! observable fails is excluded from all statistics of this time, so one count for each time serves
//! all observables.

use super::failure::{Cause, FAILURES_KEPT};
use super::merge_tree::PartialResult;
use super::observe::{not_finite, outside};
use super::observer::{LastStep, not_finite_cause};
use super::passage::counts::PathEnds;
use super::path_block::PathBlock;
use super::statistic::AnyRequest;
use super::systems::Systems;
use super::tile::lanes;
use super::{BLOCK_PATHS, BLOCK_TILES};
use crate::ensemble::PathMethod;
use crate::lanes::{ALL, Lane, Mask};
use crate::method::DimsOf;
use crate::system::Dimensions;

impl<I: PathMethod> PathBlock<'_, I> {
    /// Adds the observables of the paths that have not failed to the statistics of a recorded time,
    /// block by block.
    pub(super) fn record(&mut self, record: usize, results: &mut [PartialResult]) {
        self.observe_all();
        let records = &mut self.records;
        let mut history = Vec::new();
        let values = records.values.iter().zip(&records.counted);
        for (tile, (values, &counted)) in values.enumerate() {
            history.clear();
            history.extend(records.history.iter().map(|then| &then[tile][..]));
            results[tile / BLOCK_TILES].add(record, values, counted, &history);
        }
        let mut requests = self.settings.ensemble.observed.statistics.iter();
        if requests.any(AnyRequest::needs_history) {
            records.history.push(records.values.clone());
        }
    }

    /// Evaluates the observables of all active paths. A path on which an observable fails, fails.
    pub(super) fn observe_all(&mut self) {
        let last = LastStep::whole(self.step, self.settings.h);
        for tile in 0..self.tiles.len() {
            if self.tiles[tile].active != 0 {
                let systems = self.systems(tile, &last);
                self.observe(tile, ALL, &last, &systems);
            }
        }
    }

    /// Evaluates the observables of active paths in some lanes of a tile, after its last step.
    pub(super) fn observe(
        &mut self,
        tile: usize,
        among: Mask,
        last: &LastStep,
        systems: &Systems<'_, I::System>,
    ) {
        let among = among & self.tiles[tile].active;
        if among == 0 {
            return;
        }
        // If all paths are in their lanes, no value has to be moved.
        let is_at_home = self.tiles[tile].is_at_home && self.records.counted[tile] == among;
        let home = if is_at_home {
            &mut self.records.values[tile]
        } else {
            &mut self.records.work
        };
        let mut values = core::mem::take(home);
        self.evaluate_all((tile, among), last, systems, &mut values);
        if is_at_home {
            self.records.values[tile] = values;
            return;
        }
        for lane in lanes(among & self.tiles[tile].active) {
            let home = self.home_of(self.tiles[tile].paths[lane]);
            for (to, from) in self.records.values[home.tile].iter_mut().zip(&values) {
                to[home.lane] = from[lane];
            }
        }
        self.records.work = values;
    }

    /// Evaluates the observables of a tile, and lets paths of these lanes fail, at the times of
    /// their states.
    fn evaluate_all(
        &mut self,
        (tile, among): (usize, Mask),
        last: &LastStep,
        systems: &Systems<'_, I::System>,
        values: &mut [Lane],
    ) {
        let ensemble = self.settings.ensemble;
        self.evaluate(tile, last, systems, values);
        for (k, observable) in ensemble.observed.observables.iter().enumerate() {
            for lane in lanes(not_finite(&values[k]) & among & self.tiles[tile].active) {
                let name = &ensemble.observed.names[k];
                let state = DimsOf::<I>::get(self.tiles[tile].states(), lane);
                let value = match observable.function().value(systems.of(lane), &state) {
                    // the weight of the path, or a memory, may not be finite where the value is
                    Ok(value) if value.is_finite() => Ok(values[k][lane]),
                    other => other,
                };
                let cause = not_finite_cause(name, value);
                self.fail_at(state.t, tile, lane, last.number, cause);
            }
        }
        for (name, [low, high]) in &ensemble.observed.bounds {
            let Some(column) = ensemble.observed.column(name) else {
                continue;
            };
            let outside = outside(&values[column], *low, *high);
            for lane in lanes(outside & among & self.tiles[tile].active) {
                let cause = Cause::OutOfBound {
                    name: name.clone(),
                    value: values[column][lane],
                    low: *low,
                    high: *high,
                };
                let t = DimsOf::<I>::get(self.tiles[tile].states(), lane).t;
                self.fail_at(t, tile, lane, last.number, cause);
            }
        }
    }

    /// Adds failures, passages and, if they are kept, final states, block by block.
    pub(super) fn finish(mut self, results: &mut [PartialResult]) {
        let first = self.first_path;
        let block_of = |path: u64| ((path - first) / BLOCK_PATHS) as usize;
        self.ends.failures.sort_by_key(|failure| failure.path);
        for failure in core::mem::take(&mut self.ends.failures) {
            let result = &mut results[block_of(failure.path)];
            result.failed += 1;
            result.failures.push(failure);
        }
        for &path in &self.ends.refined {
            results[block_of(path)].refined += 1;
        }
        let passages = core::mem::take(&mut self.watch.passages);
        for (number, result) in results.iter_mut().enumerate() {
            let of_block = passages.iter().filter(|p| block_of(p.end.path) == number);
            let ends = PathEnds::new(&self.settings, of_block.copied(), &result.failures);
            for statistic in &mut result.statistics {
                statistic.end(&ends);
            }
        }
        if !self.settings.ensemble.keep_final_states {
            return;
        }
        let mut states = core::mem::take(&mut self.ends.stopped);
        for tile in &self.tiles {
            let of_lane = |lane| (tile.paths[lane], DimsOf::<I>::get(tile.states(), lane));
            states.extend(lanes(tile.active).map(of_lane));
        }
        states.sort_by_key(|(path, _)| *path);
        for (path, state) in states {
            let result = &mut results[block_of(path)];
            result.final_paths.push(path);
            result.final_states.push(state.t);
            result
                .final_states
                .extend(state.stored().into_iter().flatten());
        }
    }
}

// all failures of a block are kept
const _: () = assert!(BLOCK_PATHS as usize <= FAILURES_KEPT);
