//! One step with compensated summation: the rounding errors of the state are kept and added at the next step.
//!
//! Source: Kahan's sum as in Hairer, Lubich, Wanner, *Geometric Numerical Integration* (2006), section VIII.5.

use super::Integrator;
use super::accept::replace;
use super::rescue::check_mass_matrix;
use super::step::solve_step;
use crate::configuration::Coordinates;
use crate::error::{StepError, step_error};
use crate::solve::SolveError;
use crate::solve::newton::BlockSolver;
use crate::state::State;
use crate::system::{Dims, System, Variational};

/// Makes one step. Adds the low parts `low` of the state, and writes its new rounding errors to `low`.
#[inline]
pub(super) fn compensated_step<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    prepared: &S::Prepared,
    state: &mut State<Q>,
    low: &mut State<Q>,
    h: f64,
    dw: &[f64; M],
) -> Result<(), StepError>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    Q::in_coordinates(state, |state| {
        Q::in_coordinates(low, |low| {
            step_in_coordinates(integrator, prepared, state, low, h, dw)
        })
    })
}

/// Makes the step in coordinates.
#[inline]
fn step_in_coordinates<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    prepared: &S::Prepared,
    state: &mut State<[f64; N]>,
    low: &mut State<[f64; N]>,
    h: f64,
    dw: &[f64; M],
) -> Result<(), StepError>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let solver = BlockSolver::new(integrator.newton());
    let system = integrator.system();
    let Ok((dq, dp, _)) = system.increment(prepared, state, h, dw, &solver) else {
        // Continuation is rare, and returns a state without the digits that compensation needs.
        return solve_step(integrator, prepared, state, h, dw).map(|_| ());
    };
    let (mut q, mut p, mut new_low) = (state.q, state.p, *low);
    for i in 0..N {
        (q[i], new_low.q[i]) = two_sum(q[i], dq[i] + low.q[i]);
        (p[i], new_low.p[i]) = two_sum(p[i], dp[i] + low.p[i]);
    }
    if !replace(state, h, &q, &p) {
        let error = step_error(SolveError::NonFinite, &{ *state }, h, &{ *dw });
        return Err(check_mass_matrix(system, error));
    }
    *low = new_low;
    Ok(())
}

/// Returns the sum and its rounding error, exactly (Knuth).
#[inline]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let second = sum - a;
    (sum, (a - (sum - second)) + (b - second))
}
