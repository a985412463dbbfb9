//! The conversion of solver errors to errors of steps.

use super::StepError;
use crate::phase::configuration::FlatConfiguration;
use crate::phase::state::State;
use crate::solve::{SingularRow, SolveError};
use crate::time::is_next_time;

/// Converts the error of a solver to that of a step from `state`. An input that is not finite is
/// reported first.
///
/// The caller passes copies of state and increments, so that its own can stay in registers.
#[cold]
pub(crate) fn step_error<F: FlatConfiguration<N>, const N: usize>(
    error: SolveError,
    state: &State<F>,
    h: f64,
    dw: &[f64],
) -> StepError {
    let t = state.t;
    if !h.is_finite() {
        return StepError::StepSize { h };
    }
    let not_finite = |name: &'static str, values: &[f64]| {
        let at = values.iter().position(|x| !x.is_finite())?;
        Some(StepError::NonFiniteInput {
            what: format!("{name}[{at}]"),
            value: values[at],
            t,
        })
    };
    if !t.is_finite() {
        return StepError::NonFiniteInput {
            what: "t".to_owned(),
            value: t,
            t,
        };
    }
    let q = state.q.values();
    if let Some(bad) = not_finite("q", &q)
        .or_else(|| not_finite("p", &state.p))
        .or_else(|| not_finite("dw", dw))
    {
        return bad;
    }
    match error {
        SolveError::NotConverged {
            iterations,
            residual,
            tolerance,
        } => StepError::NotConverged {
            t,
            h,
            iterations,
            residual,
            tolerance,
        },
        SolveError::OtherBranch => StepError::BranchLost {
            t,
            h,
            dw: dw.to_vec(),
            step: 0.0,
            reached: 0.0,
        },
        SolveError::NoVelocity { reached, distance } => StepError::NoVelocity {
            t,
            q,
            p: state.p.to_vec(),
            reached,
            distance,
        },
        SolveError::SingularMass {
            row,
            pivot,
            terms,
            velocities,
        } => StepError::SingularMass {
            t,
            h,
            q,
            p: state.p.to_vec(),
            found: Box::new(SingularRow {
                row,
                pivot,
                terms,
                velocities,
            }),
        },
        SolveError::LargeRotation { angle } => StepError::LargeRotation { t, h, angle },
        SolveError::Singular { iteration } => StepError::Singular { t, h, q, iteration },
        // Configuration and momentum are finite, and the new time is not, or does not change.
        // Outside of a step h is 0.
        SolveError::NonFinite if h != 0.0 && !is_next_time(t, t + h) => {
            StepError::Time { t, h, end: t + h }
        }
        SolveError::NonFinite | SolveError::OutsideDomain { .. } => StepError::NonFiniteResult {
            t,
            h,
            q,
            p: state.p.to_vec(),
        },
    }
}

impl StepError {
    /// Returns the error of a step that was solved from another time than its own.
    pub(crate) fn at_time(mut self, time: f64) -> Self {
        if let Self::NonFiniteInput { t, .. }
        | Self::NonFiniteResult { t, .. }
        | Self::TimeScale { t, .. }
        | Self::NotConverged { t, .. }
        | Self::BranchLost { t, .. }
        | Self::NoVelocity { t, .. }
        | Self::OutsideDomain { t, .. }
        | Self::SingularMass { t, .. }
        | Self::Singular { t, .. }
        | Self::Time { t, .. } = &mut self
        {
            *t = time;
        }
        self
    }
}
