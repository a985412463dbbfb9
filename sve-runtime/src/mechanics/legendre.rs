//! The inverse Legendre transform: the velocity of a momentum.
//!
//! Input: time, configuration, momentum. Output: v with ∂L/∂v(q, v) = p. Invariant: L is defined at
//! every point that is accepted.
//!
//! If ∂L/∂v is affine in v, this is a linear system. Otherwise the solution is the velocity
//! connected with a reference velocity, which is rest if L is defined there. Continuation follows
//! it along `p(s) = (1 − s) ∂L/∂v(q, v_ref) + s p` from s = 0, where it is known, to s = 1. Each
//! point is reached from the point before by Newton's method with contracting updates within the
//! domain of L. If such updates do not exist, the stride is halved.
//!
//! Source: Allgower, Georg, *Introduction to Numerical Continuation Methods* (2003), chapter 2.

use crate::error::{StepError, step_error};
use crate::mechanics::degenerate::{self, is_degenerate};
use crate::phase::configuration::{Coordinates, FlatConfiguration};
use crate::phase::state::State;
use crate::solve::deficiency::{Deficiency, deficiency};
use crate::solve::dense::{self, DeterminantSign, Matrix, WITHOUT_DIGITS};
use crate::solve::newton::{Evaluation, Newton};
use crate::solve::{MomentumVelocities, SolveError};
use crate::system::jets::LagrangianJet;
use crate::system::{Dims, System};

/// Largest number of strides. A relativistic momentum of 10⁶ mc needs about 50.
const MAX_STRIDES: u32 = 2000;

/// Smallest stride, relative to the length of the path before it.
const SMALLEST: f64 = 1e-10;

/// Smallest first stride. If L grows exponentially with v, a momentum can be e³⁰⁰ times the
/// momentum of the reference velocity.
const SMALLEST_FIRST: f64 = 1e-200;

/// Largest number of updates within a stride: a contracting iteration needs fewer to reach
/// rounding.
const MAX_UPDATES: u32 = 12;

/// Largest ratio of successive residuals of a contracting iteration (Kantorovich).
const CONTRACTION: f64 = 0.25;

/// Relative residual at which a point of the path before its end is accepted.
const INTERMEDIATE_TOLERANCE: f64 = 1e-9;

/// Relative residual at which a velocity counts as having the momentum: some thousand units of
/// rounding, which functions of L may lose.
const EXISTENCE_TOLERANCE: f64 = 1e-12;

/// Relative change of a velocity that is only rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Number of powers of two, up and down, that are tried for a reference velocity if L is not
/// defined at rest.
const SCALES: i32 = 40;

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
    let mut rhs = *p;
    for i in 0..N {
        rhs[i] -= at_rest.dv[i];
    }
    let solved = at_rest.dvv.solve_above(WITHOUT_DIGITS, &rhs);
    let (v, _) = solved.ok_or_else(|| {
        singular_mass(&at_rest.dvv, &rhs, |rest| match rest {
            0.0 => MomentumVelocities::Many,
            distance => MomentumVelocities::None { distance },
        })
    })?;
    finite(v)
}

/// Returns the error at a singular mass matrix. The velocities that have the momentum follow from
/// the right-hand side after elimination.
#[cold]
fn singular_mass<const N: usize>(
    mass: &[[f64; N]; N],
    rhs: &[f64; N],
    velocities: impl FnOnce(f64) -> MomentumVelocities,
) -> SolveError {
    if !mass.as_flattened().iter().chain(rhs).all(|x| x.is_finite()) {
        return SolveError::NonFinite;
    }
    let Deficiency {
        row,
        pivot,
        terms,
        rest,
    } = deficiency(mass, rhs);
    SolveError::SingularMass {
        row,
        pivot,
        terms,
        velocities: velocities(rest),
    }
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
    let at =
        |v: &[f64; N], target: &[f64; N]| momentum_equation::<S, Q, N, M>(system, state, v, target);
    let Reference {
        mut v,
        p: from,
        mut sign,
    } = reference(p, &at)?;
    let newton = Newton::default();
    let (mut here, mut stride) = (0.0, 1.0);
    for _ in 0..MAX_STRIDES {
        let there = if stride >= 1.0 - here {
            1.0
        } else {
            here + stride
        };
        let target: [f64; N] = core::array::from_fn(|i| (1.0 - there) * from[i] + there * p[i]);
        match contract(v, sign, INTERMEDIATE_TOLERANCE, |v| at(v, &target)) {
            Some((found, sign_there)) => {
                (v, here, sign) = (found, there, sign_there);
                stride *= 2.0;
                if here >= 1.0 {
                    // The last point is iterated to rounding.
                    return newton.solve(v, |v| at(v, p)).and_then(finite);
                }
            }
            None => stride = 0.5 * stride.min(1.0 - here),
        }
        if stride < SMALLEST * here || stride < SMALLEST_FIRST {
            break;
        }
    }
    let distances = at(&v, p).residual.map(f64::abs);
    Err(SolveError::NoVelocity {
        reached: here,
        distance: distances.into_iter().fold(0.0, f64::max),
    })
}

/// The start of the continuation.
struct Reference<const N: usize> {
    v: [f64; N],
    /// The momentum of `v`.
    p: [f64; N],
    /// The sign of the mass matrix's determinant.
    sign: DeterminantSign,
}

/// Finds a velocity at which L is defined and its mass matrix is regular: rest, otherwise the
/// momentum or a diagonal direction times a power of two.
fn reference<const N: usize>(
    p: &[f64; N],
    at: &impl Fn(&[f64; N], &[f64; N]) -> Evaluation<N>,
) -> Result<Reference<N>, SolveError> {
    let mut undefined = SolveError::NonFinite;
    let rest = at(&[0.0; N], p);
    let has_momentum = (0..N).all(|i| rest.residual[i].abs() <= ROUNDING * rest.magnitude[i]);
    let scales = (0..=SCALES).flat_map(|k| [f64::from(k).exp2(), f64::from(-k).exp2()]);
    let candidates = scales.flat_map(|scale| {
        let along = p.map(|p| scale * p);
        [along, [scale; N], [-scale; N]]
    });
    for v in [[0.0; N]].into_iter().chain(candidates) {
        let point = at(&v, &[0.0; N]);
        let is_defined = point.residual.iter().all(|x| x.is_finite())
            && point.jacobian.as_flattened().iter().all(|x| x.is_finite());
        if !is_defined {
            continue;
        }
        match dense::solve_with_sign(&point.jacobian, &[0.0; N]) {
            Some((_, sign)) => {
                let p = point.residual;
                return Ok(Reference { v, p, sign });
            }
            None if has_momentum => {
                let rest_has = |_| MomentumVelocities::Rest;
                return Err(singular_mass(&point.jacobian, &point.residual, rest_has));
            }
            None => {
                let unknown = |_| MomentumVelocities::Unknown;
                undefined = singular_mass(&point.jacobian, &point.residual, unknown);
            }
        }
    }
    Err(undefined)
}

/// Iterates by Newton's method. Every update has to decrease the residual by the contraction factor
/// and to keep the sign of the Jacobian's determinant. Returns the root and the sign, or `None` if
/// an update fails one of these conditions.
fn contract<const N: usize>(
    mut v: [f64; N],
    expected: DeterminantSign,
    tolerance: f64,
    at: impl Fn(&[f64; N]) -> Evaluation<N>,
) -> Option<([f64; N], DeterminantSign)> {
    let mut previous = f64::INFINITY;
    for _ in 0..MAX_UPDATES {
        let point = at(&v);
        let relative = sum_of_relative_residuals(&point);
        let (update, sign) = dense::solve_with_sign(&point.jacobian, &point.residual)?;
        if sign.is_opposite_to(expected) || relative.is_nan() {
            return None;
        }
        // If ∂L/∂v is steep, it changes by more than the tolerance between two neighbouring
        // floating-point velocities.
        let at_rounding = |i: usize| update[i].abs() <= ROUNDING * v[i].abs();
        if relative <= tolerance || (0..N).all(at_rounding) {
            return Some((v, sign));
        }
        if relative > CONTRACTION * previous {
            return None;
        }
        previous = relative;
        for i in 0..N {
            v[i] -= update[i];
        }
    }
    None
}

/// Returns the sum of the residuals, each relative to the sum of its terms' magnitudes. The sum is
/// NaN if a residual is NaN.
fn sum_of_relative_residuals<const N: usize>(at: &Evaluation<N>) -> f64 {
    let mut sum = 0.0;
    for i in 0..N {
        sum += at.residual[i].abs() / (at.magnitude[i] + f64::MIN_POSITIVE);
    }
    sum
}

fn finite<const N: usize>(v: [f64; N]) -> Result<[f64; N], SolveError> {
    if v.iter().all(|x| x.is_finite()) {
        Ok(v)
    } else {
        Err(SolveError::NonFinite)
    }
}
