//! A step of a derived rule: the fast path.
//!
//! Input: an integrator, a state, a step size and increments. Output: the state after the step, or
//! a [`StepError`]; the state is then unchanged. Invariant: nothing is allocated except in errors,
//! and a state that is not finite is never written.

use super::accept::{add, refusal, replace};
use super::modes::SingleMode;
use super::rescue::{explain_step, solve_by_continuation};
use super::start;
use crate::error::{StepError, step_error};
use crate::phase::configuration::{Coordinates, FlatConfiguration};
use crate::phase::state::State;
use crate::rule::Walker;
use crate::solve::SolveError;
use crate::solve::newton::Newton;
use crate::system::equations::{Memory, StepEquations};
use crate::system::plan::{BlockKind, Plan};
use crate::system::start::Tested;
use crate::system::{AnyIncrements, Dims, System};

/// The mode that makes steps.
pub(super) struct Advance;

impl<S, I, Q, const N: usize, const M: usize> SingleMode<S, I> for Advance
where
    S: System<Dims = Dims<N, M, Q>>,
    I: AnyIncrements + ?Sized,
    Q: Coordinates<N>,
{
    // Always inlined, for the reason given at `solve_step`.
    #[inline(always)]
    fn substep<R>(
        &mut self,
        walker: Walker<'_, S, R>,
        prepared: &Tested<S::Prepared>,
        memory: &mut S::Memory,
        state: &mut State<Q::Flat>,
        h: f64,
        dw: &I,
    ) -> Result<(), StepError>
    where
        S: StepEquations<R, Increments = I>,
    {
        solve_step(walker, prepared, memory, state, h, dw).map(|_| ())
    }
}

/// The mode that counts the iterations of Newton's method.
pub(super) struct Count {
    /// The largest number of iterations of a block so far.
    pub(super) most: u32,
}

impl<S, I, Q, const N: usize, const M: usize> SingleMode<S, I> for Count
where
    S: System<Dims = Dims<N, M, Q>>,
    I: AnyIncrements + ?Sized,
    Q: Coordinates<N>,
{
    fn substep<R>(
        &mut self,
        walker: Walker<'_, S, R>,
        prepared: &Tested<S::Prepared>,
        memory: &mut S::Memory,
        state: &mut State<Q::Flat>,
        h: f64,
        dw: &I,
    ) -> Result<(), StepError>
    where
        S: StepEquations<R, Increments = I>,
    {
        // With a lower limit an attempt fails, and the next attempt reaches the root along another
        // path, with other bits.
        let increment = |max_iterations| {
            let newton = Newton {
                max_iterations,
                ..*walker.newton
            };
            let walker = Walker::new(walker.system, &newton);
            let memory = &mut S::Memory::none();
            start::increment::<S, R, Q, N, M>(walker, prepared, memory, state, h, dw)
                .map(|(q, p, _)| (q, p))
        };
        let limit = walker.newton.max_iterations;
        let failed = |error| step_error(error, state, h, dw.as_ref());
        let step = increment(limit).map_err(failed)?;
        let count = (0..=limit).find(|&limit| increment(limit) == Ok(step));
        self.most = self.most.max(count.unwrap_or(limit));
        solve_step(walker, prepared, memory, state, h, dw).map(|_| ())
    }
}

/// The mode that visits the multipliers of the constraints.
pub(crate) struct Impulses<'a> {
    pub(crate) visit: &'a mut dyn FnMut(f64),
}

impl<S, I, Q, const N: usize, const M: usize> SingleMode<S, I> for Impulses<'_>
where
    S: System<Dims = Dims<N, M, Q>>,
    I: AnyIncrements + ?Sized,
    Q: Coordinates<N>,
{
    fn substep<R>(
        &mut self,
        walker: Walker<'_, S, R>,
        prepared: &Tested<S::Prepared>,
        memory: &mut S::Memory,
        state: &mut State<Q::Flat>,
        h: f64,
        dw: &I,
    ) -> Result<(), StepError>
    where
        S: StepEquations<R, Increments = I>,
    {
        let start = *state;
        let unknowns = solve_step(walker, prepared, memory, state, h, dw)?;
        (walker.system).multipliers(&start, h, dw, &unknowns, self.visit);
        Ok(())
    }
}

/// Makes one step. Returns the unknowns of its blocks.
///
/// A step without iterations is short: it is inlined into the loop that calls it, which then keeps
/// state and memory in registers.
///
/// # Errors
/// As [`Integrator::step`](crate::Integrator::step).
#[inline(always)]
pub(super) fn solve_step<S, R, Q, const N: usize, const M: usize>(
    walker: Walker<'_, S, R>,
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
        return solve_iterating_step(walker, prepared, memory, state, h, dw);
    }
    match fast_step(walker, prepared, memory, state, h, dw) {
        Ok(x) => Ok(x),
        Err(error) => Err(explain_step(walker, error, &{ *state }, h, &{ *dw })),
    }
}

/// Makes one step with iterations. If they fail, follows the solution from the limit of no noise
/// and h → 0.
#[inline]
fn solve_iterating_step<S, R, Q, const N: usize, const M: usize>(
    walker: Walker<'_, S, R>,
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
    match fast_step(walker, prepared, memory, state, h, dw) {
        Ok(x) => Ok(x),
        Err(error) => {
            let (end, x) = solve_by_continuation(walker, error, &{ *state }, h, &{ *dw })?;
            *state = end;
            *memory = S::Memory::none();
            Ok(x)
        }
    }
}

/// Solves the equations and changes the state, if the result is finite.
#[inline(always)]
fn fast_step<S, R, Q, const N: usize, const M: usize>(
    walker: Walker<'_, S, R>,
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
    let (q, p, x) = start::increment(walker, prepared, memory, state, h, dw)?;
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
pub(super) const fn iterates(plan: &Plan) -> bool {
    let mut at = 0;
    while at < plan.blocks.len() {
        if matches!(plan.blocks[at].kind, BlockKind::Newton) {
            return true;
        }
        at += 1;
    }
    false
}
