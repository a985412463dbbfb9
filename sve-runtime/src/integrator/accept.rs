//! The accepted step: tests of step size, time and result, common to derived rules and baselines.
//!
//! Invariant: a state is only replaced by a finite one at another time.

use crate::error::{StepError, step_error};
use crate::solve::SolveError;
use crate::state::State;
use crate::time::is_next_time;

/// Checks that the step size is finite and not zero. A negative one leads back in time.
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
pub(crate) fn advance<const N: usize, const M: usize>(
    state: &mut State<[f64; N]>,
    h: f64,
    dw: &[f64; M],
    dq: &[f64; N],
    dp: &[f64; N],
) -> Result<(), StepError> {
    if add(state, h, dq, dp) {
        Ok(())
    } else {
        Err(step_error(SolveError::NonFinite, &{ *state }, h, &{ *dw }))
    }
}

/// Adds the increments to the state if the result is finite. Returns whether it is.
#[inline(always)]
pub(super) fn add<const N: usize>(
    state: &mut State<[f64; N]>,
    h: f64,
    dq: &[f64; N],
    dp: &[f64; N],
) -> bool {
    let (mut q, mut p) = (state.q, state.p);
    for i in 0..N {
        q[i] += dq[i];
        p[i] += dp[i];
    }
    replace(state, h, &q, &p)
}

/// Replaces the state if the new one is finite and its time changes. Returns whether this is so.
#[inline(always)]
pub(super) fn replace<const N: usize>(
    state: &mut State<[f64; N]>,
    h: f64,
    q: &[f64; N],
    p: &[f64; N],
) -> bool {
    // One test of the sum finds every NaN and infinity. A sum that overflows by itself is excluded off the fast path.
    let mut sum = 0.0;
    for i in 0..N {
        sum += q[i] + p[i];
    }
    if !sum.is_finite() && !all_finite(&{ *q }, &{ *p }) {
        return false;
    }
    // The time is added after the branch. Before it, the compiler would put this addition and those of q into one vector, which lengthens the
    // chain of operations from q to q.
    let t = state.t + h;
    if !is_next_time(state.t, t) {
        return false;
    }
    *state = State::at(t, *q, *p);
    true
}

#[cold]
fn all_finite(q: &[f64], p: &[f64]) -> bool {
    q.iter().chain(p).all(|x| x.is_finite())
}
