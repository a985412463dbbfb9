//! A single path of an ensemble, again.
//!
//! Input: a path's number. Output: its states after each step, up to the end or to its failure, with the bits that it had in the
//! ensemble: it goes through the same code in the same lane, beside lanes that copy it.

use super::failure::Failure;
use super::flight::{Flight, lanes};
use super::run::Run;
use super::{BLOCK_PATHS, Ensemble, EnsembleError};
use crate::configuration::Coordinates;
use crate::method::Method;
use crate::state::State;
use crate::system::{Dimensions, Dims, System};

impl<I, S, Q, const N: usize, const M: usize> Ensemble<'_, I>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// The states of a single path after each step, with the same bits as in the ensemble: to see why it failed, or where it went.
    ///
    /// The last item is the [`Failure`] where the path fails, in a step or, at a recorded time, in an observable.
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
    pub fn replay(
        &self,
        path: u64,
    ) -> Result<impl Iterator<Item = Result<State<Q>, Failure>>, EnsembleError> {
        let run = Run::new(self)?;
        if path >= run.paths {
            let paths = run.paths;
            return Err(EnsembleError::Path { path, paths });
        }
        let mut flight = Flight::new(run, path / BLOCK_PATHS, Some(path))?;
        let (mut step, mut record, mut over) = (0, 0, false);
        Ok(core::iter::from_fn(move || {
            while step <= run.steps && !over {
                flight.advance(step);
                if step == run.step_of(record) {
                    record += 1;
                    flight.observe_all();
                }
                if let Some(failure) = flight.failures.pop() {
                    over = true;
                    return Some(Err(failure));
                }
                step += 1;
                if step > 1 {
                    return flight.only().map(Ok);
                }
                // the start can fail, but is no item
            }
            None
        }))
    }
}

impl<I, S, Q, const N: usize, const M: usize> Flight<'_, I, N, M>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// The state of the first living path.
    pub(super) fn only(&self) -> Option<State<Q>> {
        let mut tiles = self.tiles.iter();
        tiles.find_map(|tile| {
            let lane = lanes(tile.alive).next()?;
            Some(S::Dims::get(tile.states(), lane))
        })
    }
}
