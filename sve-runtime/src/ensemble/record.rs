//! The records of a block of paths: observables at a recorded time, failures and final states at the end.
//!
//! Input: the states of a block. Output: its partial result. Invariant: a path on which an observable fails is in none of the
//! statistics of that time, so one count for each time serves all observables.

use super::BLOCK_PATHS;
use super::failure::{Cause, FAILURES_KEPT};
use super::merge_tree::PartialResult;
use super::observe::{not_finite, outside};
use super::path_block::{PathBlock, lanes};
use crate::configuration::{Configuration, Coordinates};
use crate::lanes::{LANES, Lane, Mask};
use crate::method::Method;
use crate::system::{Dimensions, Dims, System};

impl<I, S, Q, const N: usize, const M: usize> PathBlock<'_, I, N, M>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Adds the observables of the active paths to the statistics of a recorded time.
    pub(super) fn record(&mut self, record: usize, result: &mut PartialResult) {
        let settings = self.settings;
        let requests = &settings.ensemble.histograms;
        let column_of =
            |name: &String| (settings.ensemble.names.iter()).position(|known| known == name);
        for tile in 0..self.tiles.len() {
            let mut values = core::mem::take(&mut self.observed[tile].values);
            let active = self.observe(tile, &mut values);
            self.observed[tile].lanes = active;
            for (bins, request) in result.histograms.iter_mut().zip(requests) {
                let row = request.row(record, settings.records);
                if let (Some(row), Some(column)) = (row, column_of(&request.name)) {
                    bins.add(request, row, &values[column], active);
                }
            }
            self.observed[tile].values = values;
            let observed = &self.observed[tile];
            for (column, request) in result.joints.iter_mut().zip(&settings.ensemble.joints) {
                let history: Vec<_> = self.history.iter().map(|then| &then[tile]).collect();
                let columns = [&request.first, &request.second].map(column_of);
                if let [Some(first), Some(second)] = columns {
                    let counts = &result.counts;
                    column.add([first, second], record, counts, observed, &history);
                }
            }
            for (column, request) in (result.quantiles.iter_mut()).zip(&settings.ensemble.quantiles)
            {
                if let Some(of) = column_of(&request.name) {
                    column.add(record, &observed.values[of], active);
                }
            }
            result.add(record, &observed.values, active);
        }
        if settings
            .ensemble
            .joints
            .iter()
            .any(|joint| joint.is_two_time)
        {
            self.history.push(self.observed.clone());
        }
    }

    /// Evaluates the observables of all tiles. A path on which an observable fails, fails.
    pub(super) fn observe_all(&mut self) {
        for tile in 0..self.tiles.len() {
            let mut values = core::mem::take(&mut self.observed[tile].values);
            self.observe(tile, &mut values);
            self.observed[tile].values = values;
        }
    }

    /// Evaluates the observables of a tile. Returns the lanes that remain active.
    pub(super) fn observe(&mut self, tile: usize, values: &mut [Lane]) -> Mask {
        let ensemble = self.settings.ensemble;
        let system = self.settings.method.system();
        if self.tiles[tile].active == 0 {
            return 0;
        }
        for (k, observable) in ensemble.observables.iter().enumerate() {
            observable.tile(system, self.tiles[tile].states(), &mut values[k]);
            self.convert(k, tile, &mut values[k]);
            for lane in lanes(not_finite(&values[k]) & self.tiles[tile].active) {
                let name = ensemble.names[k].clone();
                let state = S::Dims::get(self.tiles[tile].states(), lane);
                let cause = match observable.value(system, &state) {
                    // the weight of the path may not be finite where the value is
                    Ok(value) if value.is_finite() => Cause::NotFinite {
                        name,
                        value: values[k][lane],
                    },
                    Ok(value) => Cause::NotFinite { name, value },
                    Err(error) => Cause::Observable { name, error },
                };
                self.fail(tile, lane, self.step, cause);
            }
        }
        for (name, [low, high]) in &ensemble.bounds {
            let Some(column) = ensemble.names.iter().position(|known| known == name) else {
                continue;
            };
            let outside = outside(&values[column], *low, *high);
            for lane in lanes(outside & self.tiles[tile].active) {
                let cause = Cause::OutOfBound {
                    name: name.clone(),
                    value: values[column][lane],
                    low: *low,
                    high: *high,
                };
                self.fail(tile, lane, self.step, cause);
            }
        }
        self.tiles[tile].active
    }

    /// Adds failures and, if they are kept, final states.
    pub(super) fn finish(mut self, result: &mut PartialResult) {
        self.failures.sort_by_key(|failure| failure.path);
        result.failed = self.failures.len() as u64;
        result.failures = self.failures;
        if !self.settings.ensemble.keep_final_states {
            return;
        }
        for (number, tile) in self.tiles.iter().enumerate() {
            for lane in lanes(tile.active) {
                let state = S::Dims::get(tile.states(), lane);
                let path = self.first_path + (number * LANES + lane) as u64;
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
}

// all failures of a block are kept
const _: () = assert!(BLOCK_PATHS as usize <= FAILURES_KEPT);
