//! What is noted of the paths of a block: observables at a recorded time, failures and final states at the end.
//!
//! Input: the states of a block. Output: entries of its node. Invariant: a path that fails an observable is in none of the
//! statistics of that time, so one count a time serves them all.

use super::BLOCK_PATHS;
use super::failure::{Cause, FAILURES_KEPT};
use super::flight::{Flight, lanes};
use super::observe::{not_finite, outside};
use super::tree::Node;
use crate::configuration::Coordinates;
use crate::lanes::{LANES, Lane, Mask};
use crate::method::Method;
use crate::system::{Dimensions, Dims, System};

impl<I, S, Q, const N: usize, const M: usize> Flight<'_, I, N, M>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Adds the observables of the living paths to the statistics of a recorded time.
    pub(super) fn record(&mut self, record: usize, node: &mut Node) {
        let run = self.run;
        let requests = &run.ensemble.histograms;
        for tile in 0..self.tiles.len() {
            let mut values = core::mem::take(&mut self.values);
            let alive = self.observe(tile, &mut values);
            let count = node.counts[record];
            for (column, values) in node.columns.iter_mut().zip(&values) {
                column.add(record, count, values, alive);
            }
            for (bins, request) in node.histograms.iter_mut().zip(requests) {
                let row = request.row(record, run.records);
                let column = run.ensemble.names.iter().position(|n| *n == request.name);
                if let (Some(row), Some(column)) = (row, column) {
                    bins.add(request, row, &values[column], alive);
                }
            }
            node.counts[record] += u64::from(alive.count_ones());
            self.values = values;
        }
    }

    /// Lets the paths that fail an observable fail.
    pub(super) fn observe_all(&mut self) {
        let mut values = core::mem::take(&mut self.values);
        for tile in 0..self.tiles.len() {
            self.observe(tile, &mut values);
        }
        self.values = values;
    }

    /// Evaluates the observables of a tile; the lanes that live after that.
    pub(super) fn observe(&mut self, tile: usize, values: &mut [Lane]) -> Mask {
        let ensemble = self.run.ensemble;
        let system = ensemble.method.system();
        if self.tiles[tile].alive == 0 {
            return 0;
        }
        for (k, observable) in ensemble.observables.iter().enumerate() {
            observable.tile(system, self.tiles[tile].states(), &mut values[k]);
            for lane in lanes(not_finite(&values[k]) & self.tiles[tile].alive) {
                let name = ensemble.names[k].clone();
                let state = S::Dims::get(self.tiles[tile].states(), lane);
                let cause = match observable.value(system, &state) {
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
            let left = outside(&values[column], *low, *high);
            for lane in lanes(left & self.tiles[tile].alive) {
                let cause = Cause::OutOfBound {
                    name: name.clone(),
                    value: values[column][lane],
                    low: *low,
                    high: *high,
                };
                self.fail(tile, lane, self.step, cause);
            }
        }
        self.tiles[tile].alive
    }

    /// Adds failures and, where they are asked for, final states.
    pub(super) fn finish(mut self, node: &mut Node) {
        self.failures.sort_by_key(|failure| failure.path);
        node.failed = self.failures.len() as u64;
        node.failures = self.failures;
        if !self.run.ensemble.keep_final_states {
            return;
        }
        for (number, tile) in self.tiles.iter().enumerate() {
            for lane in lanes(tile.alive) {
                let state = tile.states().get(lane);
                let path = self.first_path + (number * LANES + lane) as u64;
                node.final_paths.push(path);
                node.final_states.push(state.t);
                node.final_states.extend(state.q.iter().chain(&state.p));
            }
        }
    }
}

// the failures of a block are all kept
const _: () = assert!(BLOCK_PATHS as usize <= FAILURES_KEPT);
