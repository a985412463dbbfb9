//! One step of a derived rule: the fast path, continuation where it fails, and what a failure is called.
//!
//! Input: an integrator, a state, a step size and increments. Output: the state after the step, or a [`StepError`]; the state is then
//! unchanged. Invariant: nothing is allocated but in errors, and no state is written that is not finite.

use crate::Integrator;
use crate::configuration::Coordinates;
use crate::continuation::{self, Lost};
use crate::error::StepError;
use crate::linear;
use crate::newton::{SolveError, Solver};
use crate::plan::{BlockKind, Plan};
use crate::state::State;
use crate::system::{Dims, System, Variational};

/// One step of an integrator; what its blocks were solved for.
#[inline]
pub(crate) fn solve_step<S, R, Q, const N: usize, const M: usize>(
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
    let solver = Solver::new(integrator.newton());
    let error = match integrator
        .system()
        .increment(prepared, state, h, dw, &solver)
    {
        Ok((q, p, x)) if S::RETURNS.is_state() && replace(state, h, &q, &p) => return Ok(x),
        Ok((dq, dp, x)) if !S::RETURNS.is_state() && add(state, h, &dq, &dp) => return Ok(x),
        Ok(_) => SolveError::NonFinite,
        Err(error) => error,
    };
    // asked of the plan at compile time: a step that does not iterate keeps its state in registers
    if const { iterates(S::PLAN) } {
        let (end, x) = solve_by_continuation(integrator, error, &{ *state }, h, &{ *dw })?;
        *state = end;
        return Ok(x);
    }
    Err(explain_step(integrator, error, &{ *state }, h, &{ *dw }))
}

/// Whether a block of the step is solved by Newton's method.
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

/// One step that keeps in `rest` what rounding takes from the state.
#[inline]
pub(crate) fn compensated_step<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    prepared: &S::Prepared,
    state: &mut State<Q>,
    rest: &mut State<Q>,
    h: f64,
    dw: &[f64; M],
) -> Result<(), StepError>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    Q::in_coordinates(state, |state| {
        Q::in_coordinates(rest, |rest| {
            compensated(integrator, prepared, state, rest, h, dw)
        })
    })
}

/// One step in coordinates that keeps in `rest` what rounding takes from the state.
#[inline]
fn compensated<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    prepared: &S::Prepared,
    state: &mut State<[f64; N]>,
    rest: &mut State<[f64; N]>,
    h: f64,
    dw: &[f64; M],
) -> Result<(), StepError>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let solver = Solver::new(integrator.newton());
    let system = integrator.system();
    let Ok((dq, dp, _)) = system.increment(prepared, state, h, dw, &solver) else {
        // rare: nothing is gained from the increments that are followed to
        return solve_step(integrator, prepared, state, h, dw).map(|_| ());
    };
    let (mut q, mut p, mut low) = (state.q, state.p, *rest);
    for i in 0..N {
        (q[i], low.q[i]) = two_sum(q[i], dq[i] + rest.q[i]);
        (p[i], low.p[i]) = two_sum(p[i], dp[i] + rest.p[i]);
    }
    if !replace(state, h, &q, &p) {
        let error = explain(SolveError::NonFinite, &{ *state }, h, &{ *dw });
        return Err(look_at_the_mass(system, error));
    }
    *rest = low;
    Ok(())
}

/// A sum and its rounding error, exactly (Knuth).
#[inline]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let second = sum - a;
    (sum, (a - (sum - second)) + (b - second))
}

/// A step on which the fast path failed: its solution followed by continuation from no noise and h → 0. Where the mass matrix is
/// singular at the start there is nothing to follow, and Newton's result is accepted without that check. `failure` is that of the fast
/// path.
///
/// # Errors
/// Why neither gives a solution.
#[cold]
#[inline(never)]
fn solve_by_continuation<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    failure: SolveError,
    state: &State<[f64; N]>,
    h: f64,
    dw: &[f64; M],
) -> Result<(State<[f64; N]>, S::Unknowns), StepError>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let system = integrator.system();
    let found = match continuation::follow(integrator, state, h, dw) {
        Ok(found) => Ok(found),
        // not even the smallest step: what failed on the fast path says more
        Err(Lost::Ends { step: 0.0, .. }) if failure != SolveError::OtherBranch => Err(failure),
        Err(Lost::Ends { step, noise }) => {
            return Err(StepError::BranchLost {
                t: state.t,
                h,
                dw: dw.to_vec(),
                step,
                reached: noise,
            });
        }
        Err(Lost::NoStart(SolveError::Singular { .. })) => {
            let solver = Solver::trusting(integrator.newton());
            system.increment(&system.prepare(h), state, h, dw, &solver)
        }
        Err(Lost::NoStart(error)) => Err(error),
    };
    let mut end = *state;
    let error = match found {
        Ok((q, p, x)) if S::RETURNS.is_state() && replace(&mut end, h, &q, &p) => {
            return Ok((end, x));
        }
        Ok((q, p, x)) if !S::RETURNS.is_state() && add(&mut end, h, &q, &p) => return Ok((end, x)),
        Ok(_) => SolveError::NonFinite,
        Err(error) => error,
    };
    Err(explain_step(integrator, error, state, h, dw))
}

/// The error of a step, with what the system knows of it: its conditions, and its mass matrix.
#[cold]
fn explain_step<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    error: SolveError,
    state: &State<[f64; N]>,
    h: f64,
    dw: &[f64; M],
) -> StepError
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let explained = explain(error, state, h, dw);
    match (error, explained) {
        (SolveError::OutsideDomain { condition }, StepError::NonFiniteResult { t, h, q, .. }) => {
            let condition = S::DOMAIN.get(condition).copied().unwrap_or("L is defined");
            StepError::OutsideDomain {
                t,
                h,
                q,
                condition: condition.into(),
            }
        }
        (_, explained) => look_at_the_mass(integrator.system(), explained),
    }
}

/// Accepts positive finite step sizes.
#[inline]
pub(crate) fn check_step_size(h: f64) -> Result<(), StepError> {
    if h > 0.0 && h < f64::INFINITY {
        Ok(())
    } else {
        Err(StepError::StepSize { h })
    }
}

/// Adds the increments to the state where the result is finite.
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
        Err(explain(SolveError::NonFinite, &{ *state }, h, &{ *dw }))
    }
}

/// Adds the increments to the state where the result is finite; whether it was.
#[inline]
fn add<const N: usize>(state: &mut State<[f64; N]>, h: f64, dq: &[f64; N], dp: &[f64; N]) -> bool {
    let (mut q, mut p) = (state.q, state.p);
    for i in 0..N {
        q[i] += dq[i];
        p[i] += dp[i];
    }
    replace(state, h, &q, &p)
}

/// Replaces the state where the result is finite; whether it was.
#[inline]
fn replace<const N: usize>(
    state: &mut State<[f64; N]>,
    h: f64,
    q: &[f64; N],
    p: &[f64; N],
) -> bool {
    // One test of the sum finds every NaN and infinity; that it may overflow by itself is sorted out off the path.
    let mut sum = 0.0;
    for i in 0..N {
        sum += q[i] + p[i];
    }
    if !sum.is_finite() && !all_finite(&{ *q }, &{ *p }) {
        return false;
    }
    // After the branch: beside the additions of q the compiler would put both into one vector, which makes the chain of
    // operations from q to q longer.
    let t = state.t + h;
    if !is_time(state.t, t) {
        return false;
    }
    *state = State::at(t, *q, *p);
    true
}

/// Whether a step may lead from the time `t` to this one.
#[inline]
pub(crate) fn is_time(t: f64, end: f64) -> bool {
    end.is_finite() && end != t
}

/// Says `Singular` where a result is not finite because the mass matrix has no inverse: a formula divides by it unasked.
#[cold]
fn look_at_the_mass<S, Q, const N: usize, const M: usize>(system: &S, error: StepError) -> StepError
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let StepError::NonFiniteResult { t, h, q, p } = error else {
        return error;
    };
    let at: [f64; N] = core::array::from_fn(|i| q[i]);
    let mass = system.lagrangian_jet(t, &at, &[0.0; N]).dvv;
    if mass.iter().flatten().all(|x| x.is_finite()) && linear::solve(&mass, &[0.0; N]).is_none() {
        let iteration = 0;
        StepError::Singular { t, h, q, iteration }
    } else {
        StepError::NonFiniteResult { t, h, q, p }
    }
}

#[cold]
fn all_finite(q: &[f64], p: &[f64]) -> bool {
    q.iter().chain(p).all(|x| x.is_finite())
}

/// The error of a step from `state`: a non-finite input first, then what the solver said.
///
/// The hot path hands copies in, so that the state itself can stay in registers.
#[cold]
pub(crate) fn explain<const N: usize, const M: usize>(
    error: SolveError,
    state: &State<[f64; N]>,
    h: f64,
    dw: &[f64; M],
) -> StepError {
    let t = state.t;
    if !h.is_finite() {
        return StepError::StepSize { h };
    }
    let named = |name: &'static str, values: &[f64]| {
        let at = values.iter().position(|x| !x.is_finite())?;
        Some(StepError::NonFiniteInput {
            what: format!("{name}[{at}]"),
            value: values[at],
            t,
        })
    };
    if !t.is_finite() {
        return StepError::NonFiniteInput {
            what: "t".to_owned(),
            value: t,
            t,
        };
    }
    if let Some(bad) = named("q", &state.q)
        .or_else(|| named("p", &state.p))
        .or_else(|| named("dw", dw))
    {
        return bad;
    }
    match error {
        SolveError::NotConverged {
            iterations,
            residual,
            tolerance,
        } => StepError::NotConverged {
            t,
            h,
            iterations,
            residual,
            tolerance,
        },
        SolveError::OtherBranch => StepError::BranchLost {
            t,
            h,
            dw: dw.to_vec(),
            step: 0.0,
            reached: 0.0,
        },
        SolveError::NoVelocity { reached } => StepError::NoVelocity {
            t,
            p: state.p.to_vec(),
            reached,
        },
        SolveError::Singular { iteration } => StepError::Singular {
            t,
            h,
            q: state.q.to_vec(),
            iteration,
        },
        // the state after the step is finite with a time that is not, or that stands; outside of a step h is 0
        SolveError::NonFinite if h != 0.0 && !is_time(t, t + h) => {
            StepError::Time { t, h, end: t + h }
        }
        SolveError::NonFinite | SolveError::OutsideDomain { .. } => StepError::NonFiniteResult {
            t,
            h,
            q: state.q.to_vec(),
            p: state.p.to_vec(),
        },
    }
}
