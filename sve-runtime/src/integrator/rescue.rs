//! A step on which the fast path failed: continuation, and the error if continuation fails too.
//!
//! Input: the step and the failure of the fast path. Output: the state after the step, or a [`StepError`].

use super::DerivedStep;
use super::accept::{add, refusal, replace};
use super::continuation::{self, ContinuationError};
use crate::configuration::{Coordinates, FlatConfiguration};
use crate::constraints::explain::constraint_error;
use crate::degenerate::{self, is_degenerate};
use crate::equations::StepEquations;
use crate::error::{StepError, step_error};
use crate::solve::SolveError;
use crate::solve::dense;
use crate::solve::newton::BlockSolver;
use crate::state::State;
use crate::system::{Dims, System};
use crate::variational::Memory;

/// Solves a step on which the fast path failed with `failure`. First follows the solution by continuation from zero noise and h → 0. If the mass
/// matrix is singular at the start, continuation cannot start, and Newton's result is accepted without that check.
///
/// # Errors
/// The [`StepError`] if neither yields a solution.
#[cold]
#[inline(never)]
pub(super) fn solve_by_continuation<S, R, Q, const N: usize, const M: usize>(
    derived: DerivedStep<'_, S, R>,
    failure: SolveError,
    state: &State<Q::Flat>,
    h: f64,
    dw: &S::Increments,
) -> Result<(State<Q::Flat>, S::Unknowns), StepError>
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let system = derived.system;
    let explained = |error| {
        if const { is_degenerate::<S>() } {
            return degenerate::explained(system, state, error);
        }
        error
    };
    let found = match continuation::follow(derived, state, h, dw) {
        Ok(found) => Ok(found),
        // The path ends at once: the failure of the fast path says more.
        Err(ContinuationError::PathEnds { step: 0.0, .. })
            if failure != SolveError::OtherBranch =>
        {
            Err(failure)
        }
        Err(ContinuationError::PathEnds { step, noise }) => {
            let lost = StepError::BranchLost {
                t: state.t,
                h,
                dw: dw.as_ref().to_vec(),
                step,
                reached: noise,
            };
            let lost = explained(lost);
            return Err(constraint_error(system, &lost, state, h, dw.as_ref()).unwrap_or(lost));
        }
        Err(ContinuationError::NoStart(SolveError::Singular { .. }))
            if !const { is_degenerate::<S>() } =>
        {
            let solver = BlockSolver::unchecked(derived.newton);
            let memory = &mut S::Memory::none();
            system.increment(&system.prepare(h), memory, state, h, dw, &solver)
        }
        Err(ContinuationError::NoStart(error)) => Err(error),
    };
    let mut end = *state;
    let error = match found {
        Ok((q, p, x))
            if S::RETURNS.is_state() && replace(&mut end, h, &Q::Flat::of_row(&q), &p) =>
        {
            return Ok((end, x));
        }
        Ok((q, p, x)) if !S::RETURNS.is_state() && add(&mut end, h, &q, &p) => return Ok((end, x)),
        Ok((dq, ..)) => refusal::<Q::Flat, N>(&dq),
        Err(error) => error,
    };
    Err(explain_step(derived, error, state, h, dw))
}

/// Returns the error of a step, completed by the conditions of the domain and by a test of the mass matrix.
#[cold]
pub(super) fn explain_step<S, R, Q, const N: usize, const M: usize>(
    derived: DerivedStep<'_, S, R>,
    error: SolveError,
    state: &State<Q::Flat>,
    h: f64,
    dw: &S::Increments,
) -> StepError
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let plain = step_error(error, state, h, dw.as_ref());
    if let Some(error) = constraint_error(derived.system, &plain, state, h, dw.as_ref()) {
        return error;
    }
    if const { is_degenerate::<S>() } {
        let explained = degenerate::explained(derived.system, state, plain.clone());
        if explained != plain {
            return explained;
        }
    }
    match (error, plain) {
        (SolveError::OutsideDomain { condition }, StepError::NonFiniteResult { t, h, q, .. }) => {
            let condition = S::DOMAIN.get(condition).copied().unwrap_or("L is defined");
            StepError::OutsideDomain {
                t,
                h,
                q,
                condition: condition.into(),
            }
        }
        (_, plain) if const { is_degenerate::<S>() } => plain,
        (_, plain) => check_mass_matrix(derived.system, plain),
    }
}

/// Returns [`StepError::Singular`] in place of `error` if a result is not finite because the mass matrix has no inverse: explicit formulas divide by it
/// without a test.
#[cold]
pub(super) fn check_mass_matrix<S, Q, const N: usize, const M: usize>(
    system: &S,
    error: StepError,
) -> StepError
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let StepError::NonFiniteResult { t, h, q, p } = error else {
        return error;
    };
    let mut at = Q::origin();
    at.restore(&q);
    let mass = system.lagrangian_jet(t, &at.coordinates(), &[0.0; N]).dvv;
    if mass.iter().flatten().all(|x| x.is_finite()) && dense::solve(&mass, &[0.0; N]).is_none() {
        let iteration = 0;
        StepError::Singular { t, h, q, iteration }
    } else {
        StepError::NonFiniteResult { t, h, q, p }
    }
}
