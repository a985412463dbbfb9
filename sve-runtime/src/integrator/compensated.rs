//! One step with compensated summation: the rounding errors of the state are kept and added at the
//! next step.
//!
//! Source: Kahan's sum as in Hairer, Lubich, Wanner, *Geometric Numerical Integration* (2006),
//! section VIII.5.

use super::accept::replace;
use super::modes::SingleMode;
use super::rescue::explain_step;
use super::start;
use super::step::solve_step;
use crate::error::StepError;
use crate::phase::configuration::{Coordinates, FlatConfiguration};
use crate::phase::state::State;
use crate::rule::Walker;
use crate::solve::SolveError;
use crate::system::equations::StepEquations;
use crate::system::start::Tested;
use crate::system::{AnyIncrements, Dims, System};

/// The mode that makes steps with compensated sums. It adds the low parts of the state, and writes
/// its rounding errors to them. After a failure they are the errors of the substeps before the
/// failure.
pub(super) struct Compensate<'a, F> {
    pub(super) low: &'a mut F,
}

impl<S, I, Q, const N: usize, const M: usize> SingleMode<S, I> for Compensate<'_, State<Q::Flat>>
where
    S: System<Dims = Dims<N, M, Q>>,
    I: AnyIncrements + ?Sized,
    Q: Coordinates<N>,
{
    #[inline]
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
        let Ok((dq, dp, _)) = start::increment(walker, prepared, memory, state, h, dw) else {
            // Continuation is rare, and returns a state without the digits that compensation needs.
            return solve_step(walker, prepared, memory, state, h, dw).map(|_| ());
        };
        let mut new_low = *self.low;
        let (q, p) = Q::Flat::moved_with_low_parts(state, &mut new_low, &dq, &dp);
        if !replace(state, h, &q, &p) {
            let error = SolveError::NonFinite;
            return Err(explain_step(walker, error, &{ *state }, h, dw));
        }
        *self.low = new_low;
        Ok(())
    }
}
