//! One run of a method: its states until the horizon, or until an overflow.

use sve_runtime::noise::Noise;
use sve_runtime::system::{Dims, System};
use sve_runtime::{Method, State, StepError};

/// A run.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// The states, the start first.
    pub(crate) states: Vec<State<[f64; 1]>>,
    /// The time that the method could not reach, because its result was not a finite number.
    pub(crate) overflow: Option<f64>,
}

/// Makes `steps` steps of length `h` from `start`. An overflow ends a run and is not an error,
/// since figure 4 shows overflows.
pub(crate) fn run<I, const M: usize>(
    method: &I,
    start: State<[f64; 1]>,
    h: f64,
    noise: impl Noise,
    steps: usize,
) -> Result<Run, StepError>
where
    I: Method,
    I::System: System<Dims = Dims<1, M>>,
{
    let mut states = Vec::with_capacity(steps + 1);
    states.push(start);
    for state in method.trajectory(start, h, noise).take(steps) {
        match state {
            Ok(state) => states.push(state),
            Err(StepError::NonFiniteResult { t, .. }) => {
                return Ok(Run {
                    states,
                    overflow: Some(t + h),
                });
            }
            Err(error) => return Err(error),
        }
    }
    Ok(Run {
        states,
        overflow: None,
    })
}

/// Returns ln √(q² + p²), even if the root itself is above the range of f64.
pub(crate) fn ln_radius(z: &State<[f64; 1]>) -> f64 {
    let (q, p) = (z.q[0].abs(), z.p[0].abs());
    q.max(p).ln() + 0.5 * (q.min(p) / q.max(p)).powi(2).ln_1p()
}

impl Run {
    /// Returns `(q, p)` of every state.
    pub(crate) fn orbit(&self) -> Vec<(f64, f64)> {
        self.states.iter().map(|z| (z.q[0], z.p[0])).collect()
    }

    /// Returns `(t, f)` of every state.
    pub(crate) fn over_time(&self, f: impl Fn(&State<[f64; 1]>) -> f64) -> Vec<(f64, f64)> {
        self.states.iter().map(|z| (z.t, f(z))).collect()
    }

    /// Returns the states up to and including the first state outside `|q|, |p| ≤ size`.
    pub(crate) fn inside(&self, size: f64) -> &[State<[f64; 1]>] {
        let outside = |z: &State<[f64; 1]>| z.q[0].abs().max(z.p[0].abs()) > size;
        match self.states.iter().position(outside) {
            Some(k) => &self.states[..=k],
            None => &self.states,
        }
    }
}
