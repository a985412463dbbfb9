//! Replay of a single path of an ensemble.
//!
//! Input: the number of a path. Output: its states after each step, up to the end or to its
//! failure, with the bits that it had in the ensemble: the same code steps it in the same lane, and
//! the other lanes copy it.

use super::failure::Failure;
use super::path_block::PathBlock;
use super::settings::Settings;
use super::tile::lanes;
use super::{BLOCK_PATHS, Ensemble, EnsembleError};
use crate::ensemble::PathMethod;
use crate::method::DimsOf;
use crate::system::{Dimensions, StateOf};

impl<I: PathMethod> Ensemble<'_, I> {
    /// Returns the states of a single path after each step, with the same bits as in the ensemble,
    /// for example to find the reason of its failure.
    ///
    /// If the path is [stopped](Self::stop_at), the last item is the state where it stopped. If the
    /// path fails, in a step or in an observable at a recorded time, the last item is the
    /// [`Failure`].
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
    ///     .paths(100).steps(0.01, 500)
    ///     .start(State::new([0.1], [0.0]))
    ///     .keep_final_states(true);
    /// let summary = ensemble.run()?;
    /// let (path, end) = summary.final_states().last().expect("a hundred paths");
    /// let again = ensemble.replay(path)?.last().expect("five hundred steps")?;
    /// assert_eq!(again, end);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`run`](Self::run); [`EnsembleError::Path`] for a number that no path has.
    pub fn replay<'e>(
        &'e self,
        path: u64,
    ) -> Result<impl Iterator<Item = Result<StateOf<I::System>, Failure>>, EnsembleError>
    where
        I::System: 'e,
    {
        let settings = Settings::new(self)?;
        if path >= settings.paths {
            let paths = settings.paths;
            return Err(EnsembleError::Path { path, paths });
        }
        let first = path / BLOCK_PATHS;
        let mut block = PathBlock::new(settings, first..first + 1, Some(path))?;
        let (mut step, mut record, mut has_ended) = (0, 0, false);
        Ok(core::iter::from_fn(move || {
            while step <= settings.steps && !has_ended {
                block.advance(step);
                if step == settings.step_of(record) {
                    record += 1;
                    block.observe_all();
                }
                if let Some(failure) = block.ends.failures.pop() {
                    has_ended = true;
                    return Some(Err(failure));
                }
                step += 1;
                if let Some((_, state)) = block.ends.stopped.pop() {
                    has_ended = true;
                    return Some(Ok(state));
                }
                if step > 1 {
                    return block.first_active_state().map(Ok);
                }
                // the start can fail, but is not an item
            }
            None
        }))
    }
}

impl<I: PathMethod> PathBlock<'_, I> {
    /// Returns the state of the first active path.
    pub(super) fn first_active_state(&self) -> Option<StateOf<I::System>> {
        let mut tiles = self.tiles.iter();
        tiles.find_map(|tile| {
            let lane = lanes(tile.active).next()?;
            Some(DimsOf::<I>::get(tile.states(), lane))
        })
    }
}
