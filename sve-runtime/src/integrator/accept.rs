//! The accepted step: tests of step size, time and result, common to derived rules and baselines.
//!
//! Invariant: a state is only replaced by a finite one at another time.

use crate::error::{StepError, step_error};
use crate::phase::configuration::FlatConfiguration;
use crate::phase::state::State;
use crate::solve::SolveError;
use crate::time::{is_next_time, time_after};

/// Largest square of the angle of a rotation in a step, which is 229 degrees. The equations have a
/// pole at 360 degrees, and beyond this limit a step is no approximation of the motion.
const MAX_TURN_SQUARE: f64 = 16.0;

/// Returns the reason why an increment is not accepted.
#[cold]
pub(super) fn refusal<F: FlatConfiguration<N>, const N: usize>(dq: &[f64; N]) -> SolveError {
    let square = F::turn_square(dq);
    if square > MAX_TURN_SQUARE {
        let angle = square.sqrt();
        SolveError::LargeRotation { angle }
    } else {
        SolveError::NonFinite
    }
}

/// Returns the time after a number of steps from `start`, the last of which begins at `t`.
///
/// # Errors
/// [`StepError::Time`] if it is not another time than `t`. The step reports a `t` that is not
/// finite.
#[inline(always)]
pub(crate) fn time_of_next(start: f64, steps: u64, h: f64, t: f64) -> Result<f64, StepError> {
    let end = time_after(start, steps, h);
    if !is_next_time(t, end) && t.is_finite() {
        return Err(StepError::Time { t, h, end });
    }
    Ok(end)
}

/// Checks that the step size is finite and not zero. A negative step size leads back in time.
#[inline]
pub(crate) fn check_step_size(h: f64) -> Result<(), StepError> {
    if h != 0.0 && h.is_finite() {
        Ok(())
    } else {
        Err(StepError::StepSize { h })
    }
}

/// Adds the increments to the state.
///
/// # Errors
/// A [`StepError`] if the result is not finite; the state is then unchanged.
#[inline]
pub(crate) fn advance<F: FlatConfiguration<N>, const N: usize, const M: usize>(
    state: &mut State<F>,
    h: f64,
    dw: &[f64; M],
    dq: &[f64; N],
    dp: &[f64; N],
) -> Result<(), StepError> {
    if add(state, h, dq, dp) {
        Ok(())
    } else {
        Err(step_error(refusal::<F, N>(dq), &{ *state }, h, &{ *dw }))
    }
}

/// Adds the increments to the state if the result is finite. Returns whether the result is finite.
#[inline(always)]
pub(super) fn add<F: FlatConfiguration<N>, const N: usize>(
    state: &mut State<F>,
    h: f64,
    dq: &[f64; N],
    dp: &[f64; N],
) -> bool {
    if F::turn_square(dq) > MAX_TURN_SQUARE {
        return false;
    }
    let (q, p) = F::moved(state, dq, dp);
    replace(state, h, &q, &p)
}

/// Replaces the state if the new state is finite and its time changes. Returns whether the state
/// was replaced.
#[inline(always)]
pub(super) fn replace<F: FlatConfiguration<N>, const N: usize>(
    state: &mut State<F>,
    h: f64,
    q: &F,
    p: &[f64; N],
) -> bool {
    // One test of the sum finds every NaN and infinity. Off the fast path, finite numbers whose sum
    // overflows are recognised.
    let sum = q.sum_with(p);
    if !sum.is_finite() && !all_finite(&{ *q }.values(), &{ *p }) {
        return false;
    }
    // The time is added after the branch. Before it, the compiler would put this addition and the
    // additions to q into one vector, which lengthens the chain of operations from q to q.
    let t = state.t + h;
    if !is_next_time(state.t, t) {
        return false;
    }
    *state = State::at(t, *q, *p);
    true
}

/// Replaces the state of a vector space by a finite one.
///
/// # Errors
/// [`SolveError::NonFinite`] if the time does not change; the state is then unchanged.
#[inline(always)]
pub(crate) fn replace_by_finite<const N: usize>(
    state: &mut State<[f64; N]>,
    h: f64,
    q: [f64; N],
    p: [f64; N],
) -> Result<(), SolveError> {
    let t = state.t + h;
    if !is_next_time(state.t, t) {
        return Err(SolveError::NonFinite);
    }
    *state = State::at(t, q, p);
    Ok(())
}

#[cold]
pub(super) fn all_finite(q: &[f64], p: &[f64]) -> bool {
    q.iter().chain(p).all(|x| x.is_finite())
}
