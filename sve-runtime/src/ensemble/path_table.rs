//! Tables of the states of an ensemble: the states of some paths, and the final states of all.
//!
//! Input: numbers of paths, or a summary. Output: a [`StateTable`] with a column `path`. Invariant:
//! states have the bits that they had in the ensemble.

use super::path_block::PathBlock;
use super::settings::Settings;
use super::{BLOCK_PATHS, Ensemble, EnsembleError, Summary};
use crate::ensemble::PathMethod;
use crate::system::System;
use crate::table::StateTable;

impl<I: PathMethod> Ensemble<'_, I> {
    /// Returns the states of some paths at the recorded times, path by path, with the same bits as
    /// in the ensemble: to be written, or drawn.
    ///
    /// A path that [stops](Self::stop_at) has its last row at the stop. A path that fails has rows
    /// up to its failure; [`failures`](Summary::failures) and [`replay`](Self::replay) give the
    /// reason. Only these paths are computed.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Pendulum { g: f64, sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Pendulum {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.g * q.cos() }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let pendulum = Integrator::new(Pendulum { g: 9.8, sigma: 0.5 }, Midpoint);
    /// let ensemble = Ensemble::new(&pendulum)
    ///     .paths(100_000).steps(0.01, 500).every(100)
    ///     .start(State::new([0.1], [0.0]));
    /// let table = ensemble.path_table([0, 17])?;
    /// assert_eq!(table.rows(), 2 * 6);
    /// table.write_csv(std::io::sink())?; // `path,t,q,p`; `to_csv` writes a file
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`run`](Self::run); [`EnsembleError::Path`] for a number that no path has.
    pub fn path_table(
        &self,
        paths: impl IntoIterator<Item = u64>,
    ) -> Result<StateTable, EnsembleError> {
        let mut table = StateTable::new::<I::System>(true);
        for path in paths {
            self.record_path(path, &mut table)?;
        }
        Ok(table)
    }

    fn record_path(&self, path: u64, table: &mut StateTable) -> Result<(), EnsembleError> {
        let settings = Settings::new(self)?;
        if path >= settings.paths {
            let paths = settings.paths;
            return Err(EnsembleError::Path { path, paths });
        }
        let steps: Vec<u64> = (0..settings.records)
            .map(|record| settings.step_of(record))
            .collect();
        let first = path / BLOCK_PATHS;
        let mut block = PathBlock::new(settings, first..first + 1, Some(path))?;
        for step in steps {
            block.advance(step);
            block.observe_all();
            let stop = block.ends.stopped.pop().map(|(_, state)| state);
            let Some(state) = block.first_active_state().or(stop) else {
                break;
            };
            table.push(Some(path), &state);
            if stop.is_some() {
                break;
            }
        }
        Ok(())
    }
}

impl Summary {
    /// Returns the final states as a table, with the names of the system's coordinates; no rows
    /// unless [`keep_final_states`](Ensemble::keep_final_states) was asked for.
    ///
    /// # Panics
    /// If the summary is of a system with another number of coordinates.
    pub fn final_state_table<S: System + ?Sized>(&self, system: &S) -> StateTable {
        let _ = system;
        let mut table = StateTable::new::<S>(true);
        let columns = table.names().count();
        for (path, state) in self.final_states() {
            let values = [state.q, state.p].concat();
            assert_eq!(values.len() + 1, columns, "a summary of another system");
            table.push_values(Some(path), state.t, &values);
        }
        table
    }
}
