//! One step of a derived rule: the fast path.
//!
//! Input: an integrator, a state, a step size and increments. Output: the state after the step, or a [`StepError`]; the state is then
//! unchanged. Invariant: nothing is allocated except in errors, and a state that is not finite is never written.

use super::DerivedStep;
use super::accept::{add, refusal, replace};
use super::rescue::{explain_step, solve_by_continuation};
use super::start;
use crate::configuration::{Coordinates, FlatConfiguration};
use crate::equations::StepEquations;
use crate::error::StepError;
use crate::plan::{BlockKind, Plan};
use crate::solve::SolveError;
use crate::start::Tested;
use crate::state::State;
use crate::system::{Dims, System};
use crate::variational::Memory;

/// Makes one step. Returns the unknowns of its blocks.
///
/// A step without iterations is short: where it is called it becomes part of the loop, which then keeps state and memory in registers.
///
/// # Errors
/// As [`Discretised::advance`](crate::Discretised::advance).
#[inline(always)]
pub fn solve_step<S, R, Q, const N: usize, const M: usize>(
    derived: DerivedStep<'_, S, R>,
    prepared: &Tested<S::Prepared>,
    memory: &mut S::Memory,
    state: &mut State<Q::Flat>,
    h: f64,
    dw: &S::Increments,
) -> Result<S::Unknowns, StepError>
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    if const { iterates(S::PLAN) } {
        return solve_iterating_step(derived, prepared, memory, state, h, dw);
    }
    match fast_step(derived, prepared, memory, state, h, dw) {
        Ok(x) => Ok(x),
        Err(error) => Err(explain_step(derived, error, &{ *state }, h, &{ *dw })),
    }
}

/// Makes one step with iterations, which are followed from the limit of no noise and h → 0 where they fail.
#[inline]
fn solve_iterating_step<S, R, Q, const N: usize, const M: usize>(
    derived: DerivedStep<'_, S, R>,
    prepared: &Tested<S::Prepared>,
    memory: &mut S::Memory,
    state: &mut State<Q::Flat>,
    h: f64,
    dw: &S::Increments,
) -> Result<S::Unknowns, StepError>
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    match fast_step(derived, prepared, memory, state, h, dw) {
        Ok(x) => Ok(x),
        Err(error) => {
            let (end, x) = solve_by_continuation(derived, error, &{ *state }, h, &{ *dw })?;
            *state = end;
            *memory = S::Memory::none();
            Ok(x)
        }
    }
}

/// Solves the equations and changes the state, if the result is finite.
#[inline(always)]
fn fast_step<S, R, Q, const N: usize, const M: usize>(
    derived: DerivedStep<'_, S, R>,
    prepared: &Tested<S::Prepared>,
    memory: &mut S::Memory,
    state: &mut State<Q::Flat>,
    h: f64,
    dw: &S::Increments,
) -> Result<S::Unknowns, SolveError>
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let (q, p, x) = start::increment(derived, prepared, memory, state, h, dw)?;
    let is_accepted = if S::RETURNS.is_state() {
        replace(state, h, &Q::Flat::of_row(&q), &p)
    } else {
        add(state, h, &q, &p)
    };
    if is_accepted {
        Ok(x)
    } else {
        Err(refusal::<Q::Flat, N>(&q))
    }
}

/// Returns whether a block of the step is solved by Newton's method.
const fn iterates(plan: &Plan) -> bool {
    let mut at = 0;
    while at < plan.blocks.len() {
        if matches!(plan.blocks[at].kind, BlockKind::Newton) {
            return true;
        }
        at += 1;
    }
    false
}
