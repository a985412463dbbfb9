//! The inverse Legendre transform: the velocity of a momentum.
//!
//! Input: time, configuration, momentum. Output: v with ∂L/∂v(q, v) = p. Invariant: L is defined at every point that is accepted.
//!
//! Where ∂L/∂v is affine in v this is a linear system. Elsewhere the solution is the one that is connected with a
//! reference velocity, rest where L is defined there: along `p(s) = (1 − s) ∂L/∂v(q, v_ref) + s p` it is followed
//! from s = 0, where it is known, to s = 1. Each point is reached from the last by Newton's method with
//! contracting updates that stay where L is defined, or the stride is halved.
//!
//! Source: Allgower, Georg, *Introduction to Numerical Continuation Methods* (2003), chapter 2.

use crate::configuration::Coordinates;
use crate::linear;
use crate::newton::{Evaluation, Newton, SolveError, is_opposite};
use crate::state::State;
use crate::system::{Dims, System};

/// Strides tried. A relativistic momentum of 10⁶ mc takes some 50.
const STRIDES: u32 = 2000;

/// The smallest stride, relative to the part of the path that has been made.
const SMALLEST: f64 = 1e-10;

/// The smallest first stride: momenta of e³⁰⁰ times that of the reference have velocities where L grows like an exponential.
const FIRST: f64 = 1e-200;

/// Updates within a stride: a contracting iteration reaches rounding after fewer.
const UPDATES: u32 = 12;

/// Largest ratio of successive residuals of a contracting iteration (Kantorovich).
const CONTRACTION: f64 = 0.25;

/// Relative residual of a point on the way.
const ON_THE_WAY: f64 = 1e-9;

/// Relative change of a velocity that is its own rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Powers of two that are tried, up and down, for a reference velocity where L is not defined at rest.
const SCALES: i32 = 40;

/// The velocity with the momentum of `state`.
///
/// # Errors
/// [`SolveError::Singular`] where the mass matrix has no inverse; [`SolveError::NonFinite`] where L is not defined;
/// [`SolveError::NoVelocity`] where no velocity of this momentum is connected with the reference.
#[inline]
pub(crate) fn velocity<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<[f64; N]>,
) -> Result<[f64; N], SolveError>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    let State { t, q, p } = state;
    if !S::AFFINE_MOMENTUM {
        return follow(system, state);
    }
    let at_rest = system.lagrangian_jet(*t, q, &[0.0; N]);
    let mut rhs = *p;
    for i in 0..N {
        rhs[i] -= at_rest.dv[i];
    }
    let v = linear::solve(&at_rest.dvv, &rhs).ok_or(SolveError::Singular { iteration: 0 })?;
    finite(v)
}

/// The velocity where the momentum is not affine in it.
fn follow<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<[f64; N]>,
) -> Result<[f64; N], SolveError>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    let State { t, q, p } = state;
    if !p.iter().chain(q).chain([t]).all(|x| x.is_finite()) {
        return Err(SolveError::NonFinite);
    }
    let at = |v: &[f64; N], target: &[f64; N]| {
        let jet = system.lagrangian_jet(*t, q, v);
        let mut at = Evaluation {
            residual: jet.dv,
            magnitude: *target,
            jacobian: jet.dvv,
            curvature: f64::NAN,
        };
        // outside of its domain L is NaN where its derivatives need not be
        let undefined = 0.0 * jet.value;
        for i in 0..N {
            at.residual[i] += undefined - target[i];
            at.magnitude[i] = jet.dv[i].abs() + target[i].abs();
        }
        at
    };
    let (mut v, from, mut orientation) = reference(state, &at)?;
    let newton = Newton::default();
    let (mut here, mut stride) = (0.0, 1.0);
    for _ in 0..STRIDES {
        let there = if stride >= 1.0 - here {
            1.0
        } else {
            here + stride
        };
        let target: [f64; N] = core::array::from_fn(|i| (1.0 - there) * from[i] + there * p[i]);
        match contract(v, orientation, |v| at(v, &target)) {
            Some((found, sign)) => {
                (v, here, orientation) = (found, there, sign);
                stride *= 2.0;
                if here >= 1.0 {
                    // to rounding
                    return newton.solve(v, |v| at(v, p)).and_then(finite);
                }
            }
            None => stride = 0.5 * stride.min(1.0 - here),
        }
        if stride < SMALLEST * here || stride < FIRST {
            break;
        }
    }
    Err(SolveError::NoVelocity { reached: here })
}

/// A velocity at which L is defined and its mass matrix regular, with its momentum and a number of the sign of the determinant: rest, or
/// else the momentum or a diagonal direction by a power of two.
#[allow(clippy::type_complexity)]
fn reference<const N: usize>(
    state: &State<[f64; N]>,
    at: &impl Fn(&[f64; N], &[f64; N]) -> Evaluation<N>,
) -> Result<([f64; N], [f64; N], f64), SolveError> {
    let mut undefined = SolveError::NonFinite;
    let scales = (0..=SCALES).flat_map(|k| [f64::from(k).exp2(), f64::from(-k).exp2()]);
    let candidates = scales.flat_map(|scale| {
        let along = state.p.map(|p| scale * p);
        [along, [scale; N], [-scale; N]]
    });
    for v in [[0.0; N]].into_iter().chain(candidates) {
        let point = at(&v, &[0.0; N]);
        let is_defined = point.residual.iter().all(|x| x.is_finite())
            && point.jacobian.as_flattened().iter().all(|x| x.is_finite());
        if !is_defined {
            continue;
        }
        match linear::solve_oriented(&point.jacobian, &[0.0; N]) {
            Some((_, orientation)) => return Ok((v, point.residual, orientation)),
            None => undefined = SolveError::Singular { iteration: 1 },
        }
    }
    Err(undefined)
}

/// The root that updates reach which each reduce the residual by the contraction factor, with the orientation of its Jacobian.
fn contract<const N: usize>(
    mut v: [f64; N],
    orientation: f64,
    at: impl Fn(&[f64; N]) -> Evaluation<N>,
) -> Option<([f64; N], f64)> {
    let mut previous = f64::INFINITY;
    for _ in 0..UPDATES {
        let point = at(&v);
        let relative = relative(&point);
        let (update, sign) = linear::solve_oriented(&point.jacobian, &point.residual)?;
        if is_opposite(sign, orientation) || relative.is_nan() {
            return None;
        }
        // a steep momentum changes by more than its tolerance from one velocity to the next number
        let at_rounding = |i: usize| update[i].abs() <= ROUNDING * v[i].abs();
        if relative <= ON_THE_WAY || (0..N).all(at_rounding) {
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

/// Largest residual relative to its terms; NaN where one is.
fn relative<const N: usize>(at: &Evaluation<N>) -> f64 {
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
