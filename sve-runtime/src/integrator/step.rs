//! One step of a derived rule: the fast path.
//!
//! Input: an integrator, a state, a step size and increments. Output: the state after the step, or a [`StepError`]; the state is then
//! unchanged. Invariant: nothing is allocated except in errors, and a state that is not finite is never written.

use super::Integrator;
use super::accept::{add, replace};
use super::rescue::{explain_step, solve_by_continuation};
use crate::configuration::Coordinates;
use crate::error::StepError;
use crate::plan::{BlockKind, Plan};
use crate::solve::SolveError;
use crate::solve::newton::BlockSolver;
use crate::state::State;
use crate::system::{Dims, System, Variational};

/// Makes one step. Returns the unknowns of its blocks.
#[inline]
pub(super) fn solve_step<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    prepared: &S::Prepared,
    state: &mut State<[f64; N]>,
    h: f64,
    dw: &[f64; M],
) -> Result<S::Unknowns, StepError>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let solver = BlockSolver::new(integrator.newton());
    let error = match integrator
        .system()
        .increment(prepared, state, h, dw, &solver)
    {
        Ok((q, p, x)) if S::RETURNS.is_state() && replace(state, h, &q, &p) => return Ok(x),
        Ok((dq, dp, x)) if !S::RETURNS.is_state() && add(state, h, &dq, &dp) => return Ok(x),
        Ok(_) => SolveError::NonFinite,
        Err(error) => error,
    };
    // Decided at compile time: a step without iterations keeps its state in registers.
    if const { iterates(S::PLAN) } {
        let (end, x) = solve_by_continuation(integrator, error, &{ *state }, h, &{ *dw })?;
        *state = end;
        return Ok(x);
    }
    Err(explain_step(integrator, error, &{ *state }, h, &{ *dw }))
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
