//! Reference solutions, against which errors are measured.
//!
//! Input: the number of a path. Output: its increments over the finest steps, and its reference
//! state at the horizon.

use super::StudyError;
use super::any_method::AnyMethod;
use crate::noise::{NoNoise, NoiseError, Recorded, Wiener};
use crate::system::{StateOf, System};

/// Computes the exact solution from the increments of a path.
type Solution<'a, S> = Box<dyn Fn(&Recorded) -> StateOf<S> + Sync + 'a>;
/// Draws the path of a number with so many steps. Returns it and its exact solution.
type Draw<'a, S> = Box<dyn Fn(u64, usize) -> (Recorded, StateOf<S>) + Sync + 'a>;

pub(super) enum Reference<'a, S: System> {
    Exact(Solution<'a, S>),
    Drawn(Draw<'a, S>),
    /// A method, and the number of its steps in one of the finest steps.
    Fine(&'a dyn AnyMethod<S>, usize),
}

/// The path for which a reference is requested.
pub(super) struct PathRequest<'a, S: System> {
    pub(super) path: u64,
    pub(super) seed: u64,
    pub(super) start: &'a StateOf<S>,
    pub(super) horizon: f64,
    pub(super) finest: usize,
    pub(super) processes: usize,
    /// The most stages of a method with stage noise; 1 without.
    pub(super) stages: usize,
}

impl<S: System> PathRequest<'_, S> {
    /// Records the path in `steps` steps.
    fn record(&self, steps: usize) -> Result<Recorded, StudyError> {
        let h = self.horizon / steps as f64;
        let recorded = if self.processes == 0 {
            Recorded::record_stages(NoNoise, h, 0, self.stages, steps)
        } else {
            let path = Wiener::new(self.seed).path(self.path);
            Recorded::record_stages(path, h, self.processes, self.stages, steps)
        };
        recorded.map_err(|source| self.noise(source))
    }

    fn noise(&self, source: NoiseError) -> StudyError {
        let path = self.path;
        StudyError::Noise { path, source }
    }
}

impl<S: System> Reference<'_, S> {
    /// Returns a description of the reference for readers.
    pub(super) fn describe(&self) -> String {
        match self {
            Self::Exact(_) | Self::Drawn(_) => "the exact solution".to_owned(),
            Self::Fine(method, factor) => {
                format!(
                    "{} in steps {factor} times shorter than the finest ones",
                    method.describe()
                )
            }
        }
    }

    /// Returns whether the seed of the study decides the paths of so many processes.
    pub(super) fn has_seed(&self, processes: usize) -> bool {
        processes > 0 && !matches!(self, Self::Drawn(_))
    }

    /// Returns the path and the reference state at its end.
    pub(super) fn get(
        &self,
        request: &PathRequest<'_, S>,
    ) -> Result<(Recorded, StateOf<S>), StudyError> {
        let &PathRequest { path, finest, .. } = request;
        match self {
            Self::Exact(solution) => {
                let recorded = request.record(finest)?;
                let whole = Recorded::record(&recorded, recorded.h(), request.processes, finest);
                let state = solution(&whole.map_err(|source| request.noise(source))?);
                Ok((recorded, state))
            }
            Self::Drawn(draw) => {
                let (recorded, state) = draw(path, finest);
                let length = request.horizon / finest as f64;
                let matches = recorded.len() == finest
                    && recorded.processes() == request.processes
                    // h = T/n and T = h n may each have been rounded
                    && (recorded.h() - length).abs() <= 4.0 * f64::EPSILON * length;
                if matches && recorded.stages() < request.stages {
                    return Err(request.noise(NoiseError::Stages {
                        asked: request.stages,
                        recorded: recorded.stages(),
                    }));
                }
                if matches {
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
                let fine = request.record(finest * factor)?;
                let state = method
                    .solve(request.start, &fine, &mut |_| Ok(()))
                    .map_err(|source| StudyError::Reference { path, source })?;
                let recorded = fine
                    .coarsen(*factor)
                    .map_err(|source| request.noise(source))?;
                Ok((recorded, state))
            }
        }
    }
}
