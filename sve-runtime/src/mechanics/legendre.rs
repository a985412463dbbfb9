//! The inverse Legendre transform: the velocity of a momentum.
//!
//! Input: time, configuration, momentum. Output: v with ∂L/∂v(q, v) = p. Invariant: L is defined at
//! every point that is accepted.
//!
//! How the velocity is found is in `connected.rs`.

use crate::error::{StepError, step_error};
use crate::mechanics::connected::{affine_velocity, connected_velocity, contract, finite};
use crate::mechanics::degenerate::{self, is_degenerate};
use crate::phase::configuration::{Coordinates, FlatConfiguration};
use crate::phase::state::State;
use crate::solve::SolveError;
use crate::solve::dense::DeterminantSign;
use crate::solve::newton::Evaluation;
use crate::system::jets::LagrangianJet;
use crate::system::{Dims, System};

/// Relative residual at which a velocity counts as having the momentum: some thousand units of
/// rounding, which functions of L may lose.
const EXISTENCE_TOLERANCE: f64 = 1e-12;

/// Returns the velocity with the momentum of `state`.
///
/// # Errors
/// [`SolveError::SingularMass`] if the mass matrix has no inverse; [`SolveError::NonFinite`] if L
/// is not defined; [`SolveError::NoVelocity`] if no velocity with this momentum is connected with
/// the reference.
#[inline]
pub(crate) fn velocity<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
) -> Result<[f64; N], SolveError>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    if const { is_degenerate::<S>() } {
        return velocity_of_degenerate(system, state);
    }
    solve(system, state)
}

/// Returns the velocity of a system whose momenta do not determine it: first the velocities of the
/// massive coordinates, then the others.
#[cold]
fn velocity_of_degenerate<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
) -> Result<[f64; N], SolveError>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    let p = degenerate::massive_momenta::<S, N>(&state.p);
    let massive = solve(system, &State { p, ..*state })?;
    finite(degenerate::complete_velocity(system, state, massive)?)
}

/// Returns the state with a velocity, p = ∂L/∂v.
///
/// # Errors
/// A [`StepError`] if a number is not finite, L is not defined, or an algebraic coordinate does not
/// solve its equation.
pub(crate) fn state_with_velocity<S, Q, const N: usize, const M: usize>(
    system: &S,
    t: f64,
    q: Q::Flat,
    v: [f64; N],
) -> Result<State<Q::Flat>, StepError>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    if let Some(i) = v.iter().position(|v| !v.is_finite()) {
        let (what, value) = (format!("v[{i}]"), v[i]);
        return Err(StepError::NonFiniteInput { what, value, t });
    }
    let jet = system.lagrangian_jet(t, &q, &v);
    let mut state = State::at(t, q, jet.dv);
    // Outside of its domain L is NaN, while its derivatives may be finite.
    let is_defined = jet.value.is_finite() && state.p.iter().all(|p| p.is_finite());
    if !is_defined || !t.is_finite() || !state.q.values().iter().all(|q| q.is_finite()) {
        // The message describes the start, whose momentum is not known.
        state.p = [0.0; N];
        return Err(step_error(SolveError::NonFinite, &state, 0.0, &[]));
    }
    if const { is_degenerate::<S>() } {
        degenerate::check_consistent(system, &state)?;
    }
    Ok(state)
}

/// Returns the jet of L at a velocity, with unit masses for coordinates without mass.
#[inline(always)]
fn jet<S, Q, const N: usize, const M: usize>(
    system: &S,
    t: f64,
    q: &Q::Flat,
    v: &[f64; N],
) -> LagrangianJet<N>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    let jet = system.lagrangian_jet(t, q, v);
    if const { is_degenerate::<S>() } {
        return degenerate::with_unit_masses::<S, N>(jet, v);
    }
    jet
}

/// Solves the Legendre transform for the velocity.
#[inline]
fn solve<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
) -> Result<[f64; N], SolveError>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    let State { t, q, p } = state;
    if !S::AFFINE_MOMENTUM {
        return velocity_by_continuation(system, state);
    }
    let at_rest = jet(system, *t, q, &[0.0; N]);
    affine_velocity(p, &at_rest.dv, &at_rest.dvv)
}

/// Returns whether an isolated velocity has the momentum of `state`. Newton's method reaches this
/// velocity from `guess` by contracting updates, or continuation connects it with the reference
/// velocity. A residual is compared with the momentum and its `change` in a step, since the
/// momentum itself may vanish.
#[inline]
pub(crate) fn has_velocity_near<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
    guess: &[f64; N],
    change: &[f64; N],
) -> bool
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let at = |v: &[f64; N]| Evaluation {
        magnitude: core::array::from_fn(|i| state.p[i].abs() + change[i].abs()),
        ..momentum_equation::<S, Q, N, M>(system, state, v, &state.p)
    };
    let found = contract(*guess, DeterminantSign::UNKNOWN, EXISTENCE_TOLERANCE, at);
    found.is_some() || velocity(system, state).is_ok()
}

/// Evaluates ∂L/∂v − `target` at the configuration of a state.
#[inline(always)]
fn momentum_equation<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
    v: &[f64; N],
    target: &[f64; N],
) -> Evaluation<N>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    let jet = jet(system, state.t, &state.q, v);
    let mut at = Evaluation {
        residual: jet.dv,
        magnitude: *target,
        jacobian: jet.dvv,
        curvature: f64::NAN,
    };
    // Outside of its domain L is NaN, while its derivatives may be finite.
    let undefined = 0.0 * jet.value;
    for i in 0..N {
        at.residual[i] += undefined - target[i];
        at.magnitude[i] = jet.dv[i].abs() + target[i].abs();
    }
    at
}

/// Returns the velocity by continuation from the reference velocity, for a momentum that is not
/// affine in it.
fn velocity_by_continuation<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
) -> Result<[f64; N], SolveError>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    let State { t, q, p } = state;
    if !q.sum_with(p).is_finite() && !q.values().iter().chain(p).all(|x| x.is_finite())
        || !t.is_finite()
    {
        return Err(SolveError::NonFinite);
    }
    connected_velocity(p, &[0.0; N], |v, target| {
        momentum_equation::<S, Q, N, M>(system, state, v, target)
    })
}
