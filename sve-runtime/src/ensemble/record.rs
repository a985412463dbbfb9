//! The records of blocks of paths: observables at a recorded time, failures and final states at the end.
//!
//! Input: the states of some blocks. Output: their partial results. Invariant: a path on which an observable fails is in none of the
//! statistics of that time, so one count for each time serves all observables.

use super::failure::{Cause, FAILURES_KEPT};
use super::memory::{LastStep, not_finite_cause};
use super::merge_tree::PartialResult;
use super::observe::{not_finite, outside};
use super::passage::counts::PathEnds;
use super::path_block::PathBlock;
use super::statistic::AnyRequest;
use super::tile::lanes;
use super::{BLOCK_PATHS, BLOCK_TILES};
use crate::lanes::{ALL, Lane, Mask};
use crate::phase::configuration::{Configuration, Coordinates};
use crate::system::{Dimensions, Dims, System};
use crate::trajectory::Method;

impl<I, S, Q, const N: usize, const M: usize> PathBlock<'_, I, N, M>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Adds the observables of the paths that have not failed to the statistics of a recorded time, block by block.
    pub(super) fn record(&mut self, record: usize, results: &mut [PartialResult]) {
        self.observe_all();
        let mut history = Vec::new();
        for (tile, (values, &counted)) in self.values.iter().zip(&self.counted).enumerate() {
            history.clear();
            history.extend(self.history.iter().map(|then| &then[tile][..]));
            results[tile / BLOCK_TILES].add(record, values, counted, &history);
        }
        let mut requests = self.settings.ensemble.statistics.iter();
        if requests.any(AnyRequest::needs_history) {
            self.history.push(self.values.clone());
        }
    }

    /// Evaluates the observables of all active paths. A path on which an observable fails, fails.
    pub(super) fn observe_all(&mut self) {
        let last = LastStep::whole(self.step, self.settings.h);
        for tile in 0..self.tiles.len() {
            self.observe(tile, ALL, &last);
        }
    }

    /// Evaluates the observables of active paths in some lanes of a tile, after its last step.
    pub(super) fn observe(&mut self, tile: usize, among: Mask, last: &LastStep) {
        let among = among & self.tiles[tile].active;
        if among == 0 {
            return;
        }
        // where all paths are in their lanes, no value has to be moved
        let is_at_home = self.tiles[tile].is_at_home && self.counted[tile] == among;
        let home = if is_at_home {
            &mut self.values[tile]
        } else {
            &mut self.work
        };
        let mut values = core::mem::take(home);
        self.evaluate_all(tile, among, last, &mut values);
        if is_at_home {
            self.values[tile] = values;
            return;
        }
        for lane in lanes(among & self.tiles[tile].active) {
            let home = self.home_of(self.tiles[tile].paths[lane]);
            for (to, from) in self.values[home.tile].iter_mut().zip(&values) {
                to[home.lane] = from[lane];
            }
        }
        self.work = values;
    }

    /// Evaluates the observables of a tile, and lets paths of these lanes fail, at the times of their states.
    fn evaluate_all(&mut self, tile: usize, among: Mask, last: &LastStep, values: &mut [Lane]) {
        let ensemble = self.settings.ensemble;
        let system = self.settings.method.system();
        for (k, observable) in ensemble.observables.iter().enumerate() {
            self.evaluate(k, tile, last, &mut values[k]);
            for lane in lanes(not_finite(&values[k]) & among & self.tiles[tile].active) {
                let name = &ensemble.names[k];
                let state = S::Dims::get(self.tiles[tile].states(), lane);
                let value = match observable.value(system, &state) {
                    // the weight of the path, or a memory, may not be finite where the value is
                    Ok(value) if value.is_finite() => Ok(values[k][lane]),
                    other => other,
                };
                let cause = not_finite_cause(name, value);
                self.fail_at(state.t, tile, lane, last.number, cause);
            }
        }
        for (name, [low, high]) in &ensemble.bounds {
            let Some(column) = ensemble.names.iter().position(|known| known == name) else {
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
                let t = S::Dims::get(self.tiles[tile].states(), lane).t;
                self.fail_at(t, tile, lane, last.number, cause);
            }
        }
    }

    /// Adds failures, passages and, if they are kept, final states, block by block.
    pub(super) fn finish(mut self, results: &mut [PartialResult]) {
        let first = self.first_path;
        let block_of = |path: u64| ((path - first) / BLOCK_PATHS) as usize;
        self.failures.sort_by_key(|failure| failure.path);
        for failure in core::mem::take(&mut self.failures) {
            let result = &mut results[block_of(failure.path)];
            result.failed += 1;
            result.failures.push(failure);
        }
        for &path in &self.refined {
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
        let mut states = core::mem::take(&mut self.stopped);
        for tile in &self.tiles {
            let of_lane = |lane| (tile.paths[lane], S::Dims::get(tile.states(), lane));
            states.extend(lanes(tile.active).map(of_lane));
        }
        states.sort_by_key(|(path, _)| *path);
        for (path, state) in states {
            let result = &mut results[block_of(path)];
            result.final_paths.push(path);
            result.final_states.push(state.t);
            let mut values = vec![0.0; Q::STORED_VALUES + N];
            let (q, p) = values.split_at_mut(Q::STORED_VALUES);
            state.q.store(q);
            state.p.store(p);
            result.final_states.extend(values);
        }
    }
}

// all failures of a block are kept
const _: () = assert!(BLOCK_PATHS as usize <= FAILURES_KEPT);
