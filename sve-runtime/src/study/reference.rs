//! What errors are measured against.
//!
//! Input: the number of a path. Output: its increments over the finest steps, and the state at the horizon that counts as exact.

use super::StudyError;
use super::subject::Subject;
use crate::noise::{NoNoise, Recorded, Wiener};
use crate::system::{StateOf, System};

/// An exact solution of the increments of a path.
type Solution<'a, S> = Box<dyn Fn(&Recorded) -> StateOf<S> + Sync + 'a>;
/// A path of that number and so many steps, with its exact solution.
type Draw<'a, S> = Box<dyn Fn(u64, usize) -> (Recorded, StateOf<S>) + Sync + 'a>;

pub(super) enum Reference<'a, S: System> {
    Exact(Solution<'a, S>),
    Drawn(Draw<'a, S>),
    /// A method, and how many of its steps are one of the finest.
    Fine(&'a dyn Subject<S>, usize),
}

/// Which path is wanted.
pub(super) struct Wanted<'a, S: System> {
    pub(super) path: u64,
    pub(super) seed: u64,
    pub(super) start: &'a StateOf<S>,
    pub(super) horizon: f64,
    pub(super) finest: usize,
    pub(super) processes: usize,
}

impl<S: System> Wanted<'_, S> {
    /// The path in `steps` steps.
    fn record(&self, steps: usize) -> Result<Recorded, StudyError> {
        let h = self.horizon / steps as f64;
        let recorded = if self.processes == 0 {
            Recorded::record(NoNoise, h, 0, steps)
        } else {
            let path = Wiener::new(self.seed).path(self.path);
            Recorded::record(path, h, self.processes, steps)
        };
        recorded.map_err(|source| self.noise(source))
    }

    fn noise(&self, source: crate::noise::NoiseError) -> StudyError {
        let path = self.path;
        StudyError::Noise { path, source }
    }
}

impl<S: System> Reference<'_, S> {
    /// The path, and the state at its end.
    pub(super) fn get(&self, wanted: &Wanted<'_, S>) -> Result<(Recorded, StateOf<S>), StudyError> {
        let &Wanted { path, finest, .. } = wanted;
        match self {
            Self::Exact(solution) => {
                let recorded = wanted.record(finest)?;
                let state = solution(&recorded);
                Ok((recorded, state))
            }
            Self::Drawn(draw) => {
                let (recorded, state) = draw(path, finest);
                let length = wanted.horizon / finest as f64;
                let fits = recorded.len() == finest
                    && recorded.processes() == wanted.processes
                    // h = T/n and T = h n may each have been rounded
                    && (recorded.h() - length).abs() <= 4.0 * f64::EPSILON * length;
                if fits {
                    return Ok((recorded, state));
                }
                Err(StudyError::Drawn {
                    path,
                    steps: recorded.len(),
                    h: recorded.h(),
                    processes: recorded.processes(),
                    wanted: finest,
                    length,
                })
            }
            Self::Fine(method, factor) => {
                let fine = wanted.record(finest * factor)?;
                let state = method
                    .walk(wanted.start, &fine, &mut |_| Ok(()))
                    .map_err(|source| StudyError::Reference { path, source })?;
                let recorded = fine
                    .coarsen(*factor)
                    .map_err(|source| wanted.noise(source))?;
                Ok((recorded, state))
            }
        }
    }
}
