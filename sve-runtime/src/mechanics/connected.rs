//! The velocity of a momentum, from ∂L/∂v and its derivatives at a velocity: of a system, and of a
//! site of a scene.
//!
//! If ∂L/∂v is affine in v, this is a linear system. Otherwise the solution is the velocity
//! connected with a reference velocity, which is rest if L is defined there. Continuation follows
//! it along `p(s) = (1 − s) ∂L/∂v(q, v_ref) + s p` from s = 0, where it is known, to s = 1. Each
//! point is reached from the point before by Newton's method with contracting updates within the
//! domain of L. If such updates do not exist, the stride is halved.
//!
//! Source: Allgower, Georg, *Introduction to Numerical Continuation Methods* (2003), chapter 2.

use crate::solve::deficiency::{Deficiency, deficiency};
use crate::solve::dense::{self, DeterminantSign, Matrix, WITHOUT_DIGITS};
use crate::solve::newton::{Evaluation, Newton};
use crate::solve::{MomentumVelocities, SolveError};

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

/// Relative change of a velocity that is only rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Number of powers of two, up and down, that are tried for a reference velocity if L is not
/// defined at rest.
const SCALES: i32 = 40;

/// Returns the velocity of a momentum that is affine in it, from the momentum of rest and the mass
/// matrix.
///
/// # Errors
/// [`SolveError::SingularMass`] if the mass matrix has no inverse; [`SolveError::NonFinite`].
#[inline]
pub(crate) fn affine_velocity<const N: usize>(
    p: &[f64; N],
    of_rest: &[f64; N],
    mass: &[[f64; N]; N],
) -> Result<[f64; N], SolveError> {
    let mut rhs = *p;
    for i in 0..N {
        rhs[i] -= of_rest[i];
    }
    let solved = mass.solve_above(WITHOUT_DIGITS, &rhs);
    let (v, _) = solved.ok_or_else(|| {
        singular_mass(mass, &rhs, |rest| match rest {
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

/// Returns the velocity of the momentum `p` that is connected with the velocity `near`, or with a
/// reference velocity if L is not defined there. `at` evaluates ∂L/∂v less a momentum at a
/// velocity.
///
/// # Errors
/// [`SolveError::SingularMass`] if the mass matrix is singular at all reference velocities;
/// [`SolveError::NonFinite`] if L is not defined at any; [`SolveError::NoVelocity`].
pub(crate) fn connected_velocity<const N: usize>(
    p: &[f64; N],
    near: &[f64; N],
    at: impl Fn(&[f64; N], &[f64; N]) -> Evaluation<N>,
) -> Result<[f64; N], SolveError> {
    let Reference {
        mut v,
        p: from,
        mut sign,
    } = reference(p, near, &at)?;
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

/// Finds a velocity at which L is defined and its mass matrix is regular: `near`, otherwise rest,
/// the momentum or a diagonal direction times a power of two.
fn reference<const N: usize>(
    p: &[f64; N],
    near: &[f64; N],
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
    for v in [*near, [0.0; N]].into_iter().chain(candidates) {
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
pub(super) fn contract<const N: usize>(
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

pub(super) fn finite<const N: usize>(v: [f64; N]) -> Result<[f64; N], SolveError> {
    if v.iter().all(|x| x.is_finite()) {
        Ok(v)
    } else {
        Err(SolveError::NonFinite)
    }
}
