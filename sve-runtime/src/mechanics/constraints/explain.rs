//! The error of a step that lost the constraints. Called off the fast path, when a step has failed.

use super::Linearised;
use super::consistent::rank_error;
use crate::error::StepError;
use crate::mechanics::Noises;
use crate::mechanics::legendre;
use crate::phase::configuration::{Coordinates, FlatConfiguration};
use crate::phase::state::State;
use crate::system::{Dims, System};

/// Largest violation of a constraint at the start of a step, relative to its terms. The macro has
/// the same number in the conditions of a step.
const INCONSISTENT: f64 = 1e-8;

/// Returns the error in terms of the constraints, if they are the reason; `None` otherwise, and for
/// systems without constraints.
#[cold]
pub(crate) fn constraint_error<S, Q, const N: usize, const M: usize>(
    system: &S,
    error: &StepError,
    state: &State<Q::Flat>,
    h: f64,
    dw: &[f64],
) -> Option<StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let is_input = matches!(
        error,
        StepError::NonFiniteInput { .. } | StepError::StepSize { .. } | StepError::Time { .. }
    );
    if S::CONSTRAINTS.is_empty() || is_input {
        return None;
    }
    let here = Linearised::at(system, state.t, &state.q)?;
    if let Some(error) = inconsistent_start::<S, N>(&here, state.t) {
        return Some(error);
    }
    if let Some(error) = rank_error::<S, Q, N, M>(system, &here, state.t, &state.q) {
        return Some(error);
    }
    let (step, noise) = match *error {
        StepError::BranchLost { step, reached, .. } => (step, reached),
        StepError::NotConverged { .. } | StepError::Singular { .. } => (0.0, 0.0),
        _ => return None,
    };
    let velocity = legendre::velocity(system, state).ok()?;
    let shift = Noises::at(system, state).field(dw.try_into().ok()?).q;
    let moved: [f64; N] = core::array::from_fn(|i| h * velocity[i] + shift[i]);
    let (end, _) = Q::Flat::moved(state, &moved, &[0.0; N]);
    let there = Linearised::at(system, state.t + h, &end)?;
    let (k, violation) = there.worst();
    Some(StepError::ConstraintLost {
        t: state.t,
        h,
        step,
        noise,
        distance: moved.iter().map(|d| d * d).sum::<f64>().sqrt(),
        constraint: S::CONSTRAINTS[k].into(),
        violation,
    })
}

/// Returns the error of a start at which the gradient of a constraint vanishes with the constraint;
/// `None` for systems without constraints.
#[cold]
pub(crate) fn gradient_error<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
) -> Option<StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    if S::CONSTRAINTS.is_empty() {
        return None;
    }
    let is_finite = state.t.is_finite() && state.q.values().iter().all(|x| x.is_finite());
    if !is_finite {
        return None;
    }
    let here = Linearised::at(system, state.t, &state.q)?;
    if !here.matrix.iter().all(|x| x.is_finite()) {
        return None;
    }
    let error = rank_error::<S, Q, N, M>(system, &here, state.t, &state.q)?;
    let is_inconsistent = inconsistent_start::<S, N>(&here, state.t);
    Some(is_inconsistent.unwrap_or(error))
}

/// Returns the error of a state that violates a constraint.
pub(super) fn inconsistent_start<S: System, const N: usize>(
    here: &Linearised<N>,
    t: f64,
) -> Option<StepError> {
    let (k, violation) = here.worst();
    (violation > INCONSISTENT).then(|| StepError::InconsistentStart {
        t,
        constraint: S::CONSTRAINTS[k].into(),
        value: here.jets[k].value,
        magnitude: here.jets[k].magnitude,
    })
}
