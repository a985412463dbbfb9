//! One step of a derived rule: the fast path.
//!
//! Input: an integrator, a state, a step size and increments. Output: the state after the step, or a [`StepError`]; the state is then
//! unchanged. Invariant: nothing is allocated except in errors, and a state that is not finite is never written.

use super::DerivedStep;
use super::accept::{add, refusal, replace};
use super::rescue::{explain_step, solve_by_continuation};
use crate::configuration::{Coordinates, FlatConfiguration};
use crate::equations::StepEquations;
use crate::error::StepError;
use crate::plan::{BlockKind, Plan};
use crate::solve::newton::BlockSolver;
use crate::state::State;
use crate::system::{Dims, System};
use crate::variational::Memory;

/// Makes one step. Returns the unknowns of its blocks.
///
/// # Errors
/// As [`Discretised::advance`](crate::Discretised::advance).
#[inline]
pub fn solve_step<S, R, Q, const N: usize, const M: usize>(
    derived: DerivedStep<'_, S, R>,
    prepared: &S::Prepared,
    memory: &mut S::Memory,
    state: &mut State<Q::Flat>,
    h: f64,
    dw: &S::Increments,
) -> Result<S::Unknowns, StepError>
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let solver = BlockSolver::new(derived.newton);
    let error = match derived
        .system
        .increment(prepared, memory, state, h, dw, &solver)
    {
        Ok((q, p, x)) if S::RETURNS.is_state() && replace(state, h, &Q::Flat::of_row(&q), &p) => {
            return Ok(x);
        }
        Ok((dq, dp, x)) if !S::RETURNS.is_state() && add(state, h, &dq, &dp) => return Ok(x),
        Ok((dq, ..)) => refusal::<Q::Flat, N>(&dq),
        Err(error) => error,
    };
    // Decided at compile time: a step without iterations keeps its state in registers.
    if const { iterates(S::PLAN) } {
        let (end, x) = solve_by_continuation(derived, error, &{ *state }, h, &{ *dw })?;
        *state = end;
        *memory = S::Memory::none();
        return Ok(x);
    }
    Err(explain_step(derived, error, &{ *state }, h, &{ *dw }))
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
