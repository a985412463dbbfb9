//! A step on which the fast path failed: continuation, and the error if continuation fails too.
//!
//! Input: the step and the failure of the fast path. Output: the state after the step, or a
//! [`StepError`].

use super::accept::{add, refusal, replace};
use super::continuation::{self, ContinuationError};
use super::start::NO_POLE;
use crate::error::{StepError, step_error};
use crate::mechanics::constraints::explain::{constraint_error, gradient_error};
use crate::mechanics::degenerate::{self, is_degenerate};
use crate::mechanics::{legendre, reach_of_noise};
use crate::phase::configuration::{Coordinates, FlatConfiguration};
use crate::phase::state::State;
use crate::rule::Walker;
use crate::solve::SolveError;
use crate::solve::newton::BlockSolver;
use crate::system::equations::Memory;
use crate::system::equations::StepEquations;
use crate::system::{Dims, System};

/// Solves a step on which the fast path failed with `failure`: follows the solution by continuation
/// from zero noise and h → 0. If constraints hold and the mass matrix is singular at the start,
/// continuation cannot start, and Newton's result is accepted without that check.
///
/// # Errors
/// The [`StepError`] if this yields no solution, or if no isolated velocity has the momentum at the
/// start.
#[cold]
#[inline(never)]
pub(super) fn solve_by_continuation<S, R, Q, const N: usize, const M: usize>(
    walker: Walker<'_, S, R>,
    failure: SolveError,
    state: &State<Q::Flat>,
    h: f64,
    dw: &S::Increments,
) -> Result<(State<Q::Flat>, S::Unknowns), StepError>
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let system = walker.system;
    if let Some(error) = gradient_error(system, state) {
        return Err(error);
    }
    if !S::CONSTRAINTS.is_empty() {
        let solver = BlockSolver::by_bounds(walker.newton);
        let memory = &mut S::Memory::none();
        let found = system.increment(&system.prepare(h), memory, state, h, dw, &solver);
        let mut end = *state;
        if let Ok((q, p, x)) = found
            && add(&mut end, h, &q, &p)
        {
            return Ok((end, x));
        }
    }
    let mut end = *state;
    let error = match followed(walker, failure, state, h, dw)? {
        Ok((q, p, x))
            if S::RETURNS.is_state() && replace(&mut end, h, &Q::Flat::of_row(&q), &p) =>
        {
            return Ok((end, x));
        }
        Ok((q, p, x)) if !S::RETURNS.is_state() && add(&mut end, h, &q, &p) => return Ok((end, x)),
        Ok((dq, ..)) => refusal::<Q::Flat, N>(&dq),
        Err(error) => error,
    };
    Err(explain_step(walker, error, state, h, dw))
}

/// The increments and unknowns of a step, or the failure of its solve.
type Solved<S, R, const N: usize> =
    Result<([f64; N], [f64; N], <S as StepEquations<R>>::Unknowns), SolveError>;

/// Follows the solution by continuation. The outer error says where it was lost.
fn followed<S, R, Q, const N: usize, const M: usize>(
    walker: Walker<'_, S, R>,
    failure: SolveError,
    state: &State<Q::Flat>,
    h: f64,
    dw: &S::Increments,
) -> Result<Solved<S, R, N>, StepError>
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let system = walker.system;
    Ok(match continuation::follow(walker, state, h, dw) {
        Ok(found) => Ok(found),
        // The path ends at once: the failure of the fast path says more.
        Err(ContinuationError::PathEnds { step: 0.0, .. })
            if failure != SolveError::OtherBranch =>
        {
            Err(failure)
        }
        Err(ContinuationError::PathEnds { step, noise }) => {
            let mut lost = StepError::BranchLost {
                t: state.t,
                h,
                dw: dw.as_ref().to_vec(),
                step,
                reached: noise,
            };
            if step == 1.0 && reach_of_noise(system, state, dw.as_ref()) >= NO_POLE {
                return Err(StepError::NoisePole {
                    t: state.t,
                    h,
                    dw: dw.as_ref().to_vec(),
                    reached: noise,
                });
            }
            if const { is_degenerate::<S>() } {
                lost = degenerate::explained(system, state, lost);
            }
            return Err(constraint_error(system, &lost, state, h, dw.as_ref()).unwrap_or(lost));
        }
        Err(ContinuationError::NearFold { step, noise, part }) => {
            return Err(StepError::NearFold {
                t: state.t,
                h,
                step,
                noise,
                part,
            });
        }
        // The mass matrix along the constraints decides whether a step exists.
        Err(ContinuationError::NoStart(SolveError::SingularMass { .. }))
            if !S::CONSTRAINTS.is_empty() =>
        {
            let solver = BlockSolver::unchecked(walker.newton);
            let memory = &mut S::Memory::none();
            system.increment(&system.prepare(h), memory, state, h, dw, &solver)
        }
        Err(ContinuationError::NoStart(error)) => Err(error),
    })
}

/// Returns the error of a step. It describes the first cause: the start, the domain, or the
/// solution.
#[cold]
pub(super) fn explain_step<S, R, Q, const N: usize, const M: usize>(
    walker: Walker<'_, S, R>,
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
    if let Some(error) = constraint_error(walker.system, &plain, state, h, dw.as_ref()) {
        return error;
    }
    if const { is_degenerate::<S>() } {
        let explained = degenerate::explained(walker.system, state, plain.clone());
        if explained != plain {
            return explained;
        }
    } else if (S::CONSTRAINTS.is_empty() || matches!(plain, StepError::NonFiniteResult { .. }))
        && let Some(error) = start_error(walker.system, state)
    {
        // Inputs that are not finite are reported first.
        return step_error(error, state, h, dw.as_ref());
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
        (_, plain) => plain,
    }
}

/// Returns the reason why no step starts from `state`: no velocity of its momentum was found, or no
/// isolated one.
fn start_error<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
) -> Option<SolveError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let error = legendre::velocity(system, state).err()?;
    let names_start = matches!(
        error,
        SolveError::SingularMass { .. } | SolveError::NoVelocity { .. }
    );
    names_start.then_some(error)
}
