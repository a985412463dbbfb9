//! Systems whose Lagrangian does not determine every velocity.
//!
//! Input: the derivatives that the macro generated, and the role of each coordinate. Output:
//! velocities, states and errors of such systems.
//!
//! ```text
//! L = L₀(t, q, v_massive) + ⟨α(q), v_massless⟩        p = α(q)        ω v = ∇H,  ω = Dαᵀ − Dα
//! ```
//!
//! The Euler–Lagrange equation of a massless coordinate is an equation for the velocities of
//! massless coordinates. An algebraic coordinate follows from `0 = ∂L/∂q`, and its velocity from
//! the derivative of this equation along the motion (`docs/mathematics.md`, section 1).

use nalgebra::DMatrix;

use crate::error::{StepError, step_error};
use crate::phase::configuration::{Coordinates, FlatConfiguration, VectorCoordinates};
use crate::phase::state::State;
use crate::solve::SolveError;
use crate::solve::dense;
use crate::solve::newton::{Evaluation, Newton};
use crate::system::jets::{CoordinateRole, LagrangianJet};
use crate::system::{Dims, System};

use CoordinateRole::{Algebraic, Massive, Massless};

/// Largest difference of a momentum from α(q), relative to the terms of both. Steps use the same
/// bound.
const CONSISTENT: f64 = 1e-8;

/// The message for a function of regular systems that is used with a degenerate system.
pub(crate) const NEEDS_REGULAR: &str = "this Lagrangian is degenerate, p = α(q): momenta are no free variables, so there is no first-order form in (q, p) for baselines, noise fields and Itô corrections; use a derived rule";

/// Returns whether the Lagrangian of a system does not determine every velocity. The function is
/// constant, so that regular systems have no code for the other case.
pub(crate) const fn is_degenerate<S: System + ?Sized>() -> bool {
    !S::ROLES.is_empty()
}

/// Returns whether a coordinate has a role.
fn is<S: System + ?Sized>(i: usize, role: CoordinateRole) -> bool {
    S::ROLES.get(i) == Some(&role)
}

/// Replaces the momenta of coordinates without mass by their velocities, so that the Legendre
/// transform is regular. If these momenta are zero, the inverse transform gives the velocities of
/// the massive coordinates and zero for the others.
pub(crate) fn with_unit_masses<S: System + ?Sized, const N: usize>(
    mut jet: LagrangianJet<N>,
    v: &[f64; N],
) -> LagrangianJet<N> {
    for i in 0..N {
        if is::<S>(i, Massive) {
            continue;
        }
        jet.dv[i] = v[i];
        for j in 0..N {
            jet.dvv[i][j] = f64::from(u8::from(i == j));
            jet.dvv[j][i] = jet.dvv[i][j];
        }
    }
    jet
}

/// Returns the momenta with zero for the coordinates without mass.
pub(crate) fn massive_momenta<S: System + ?Sized, const N: usize>(p: &[f64; N]) -> [f64; N] {
    core::array::from_fn(|i| if is::<S>(i, Massive) { p[i] } else { 0.0 })
}

/// Returns the velocities of all coordinates. `v` has the velocities of the massive coordinates,
/// and zero for the others.
///
/// # Errors
/// [`SolveError::Singular`] if ω or ∂²L/∂q² of the algebraic coordinates has no inverse.
pub(crate) fn complete_velocity<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
    mut v: [f64; N],
) -> Result<[f64; N], SolveError>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    let jet = system.lagrangian_jet(state.t, &state.q, &v);
    let singular = SolveError::Singular { iteration: 0 };
    // Σ_k (∂_iα_k − ∂_kα_i) v_k = Σ_x ∂_xα_i v_x − ∂L₀/∂q_i
    let mut rhs = [0.0; N];
    for i in (0..N).filter(|&i| is::<S>(i, Massless)) {
        rhs[i] = -jet.dq[i];
        for x in (0..N).filter(|&x| is::<S>(x, Massive)) {
            rhs[i] += jet.dqv[x][i] * v[x];
        }
    }
    let massless = dense::solve(&form_matrix::<S, N>(&jet), &rhs).ok_or(singular)?;
    for i in (0..N).filter(|&i| is::<S>(i, Massless)) {
        v[i] = massless[i];
    }
    // The equation d/dt ∂L/∂y = 0 of an algebraic coordinate y.
    let mut hessian = [[0.0; N]; N];
    let mut rhs = [0.0; N];
    for i in 0..N {
        hessian[i][i] = 1.0;
        if !is::<S>(i, Algebraic) {
            continue;
        }
        rhs[i] = -jet.dqt[i];
        for k in 0..N {
            if is::<S>(k, Algebraic) {
                hessian[i][k] = jet.dqq[i][k];
            } else {
                rhs[i] -= jet.dqq[i][k] * v[k];
            }
        }
    }
    let algebraic = dense::solve(&hessian, &rhs).ok_or(singular)?;
    for i in (0..N).filter(|&i| is::<S>(i, Algebraic)) {
        v[i] = algebraic[i];
    }
    Ok(v)
}

/// Returns ω on the massless coordinates, `ω_ij = ∂_iα_j − ∂_jα_i`, and the identity on the others.
fn form_matrix<S: System + ?Sized, const N: usize>(jet: &LagrangianJet<N>) -> [[f64; N]; N] {
    core::array::from_fn(|i| {
        core::array::from_fn(|j| {
            if is::<S>(i, Massless) && is::<S>(j, Massless) {
                jet.dqv[i][j] - jet.dqv[j][i]
            } else {
                f64::from(u8::from(i == j))
            }
        })
    })
}

/// Checks that the momenta of massless coordinates are α(q), and that algebraic coordinates solve
/// their equation.
///
/// # Errors
/// [`StepError::Inconsistent`] with the two values of the first coordinate that fails the check.
pub(crate) fn check_consistent<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
) -> Result<(), StepError>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    let State { t, q, p } = state;
    let jet = system.lagrangian_jet(*t, q, &[0.0; N]);
    let is_far = |value: f64, expected: f64, slopes: [f64; N]| {
        let values = q.values();
        let terms = slopes
            .iter()
            .zip(&values)
            .map(|(slope, q)| (slope * q).abs());
        let scale = value.abs() + expected.abs() + terms.sum::<f64>();
        (value - expected).abs() > CONSISTENT * scale
    };
    for i in (0..N).filter(|&i| !is::<S>(i, Massive)) {
        let slopes = core::array::from_fn(|k| jet.dqv[k][i]);
        if is_far(p[i], jet.dv[i], slopes) {
            return Err(StepError::Inconsistent {
                t: *t,
                what: format!("p[{i}]"),
                value: p[i],
                expected: jet.dv[i],
            });
        }
        if is::<S>(i, Algebraic) && is_far(0.0, jet.dq[i], jet.dqq[i]) {
            return Err(StepError::Inconsistent {
                t: *t,
                what: format!("∂L/∂q[{i}]"),
                value: jet.dq[i],
                expected: 0.0,
            });
        }
    }
    Ok(())
}

/// Returns the error of a step, or of a function of a state, in terms of degenerate systems: the
/// start is inconsistent, or ω is singular there.
#[cold]
pub(crate) fn explained<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
    error: StepError,
) -> StepError
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    let (h, is_certain) = match error {
        StepError::Singular { h, .. } | StepError::SingularMass { h, .. } => (h, true),
        StepError::NonFiniteResult { h, .. }
        | StepError::NotConverged { h, .. }
        | StepError::OutsideDomain { h, .. }
        | StepError::BranchLost { h, .. } => (h, false),
        other => return other,
    };
    if let Err(inconsistent) = check_consistent(system, state) {
        return inconsistent;
    }
    let jet = system.lagrangian_jet(state.t, &state.q, &[0.0; N]);
    let form = form_matrix::<S, N>(&jet);
    if !form.as_flattened().iter().all(|x| x.is_finite()) {
        return error;
    }
    if is_certain || dense::solve(&form, &[0.0; N]).is_none() {
        return StepError::SingularForm {
            t: state.t,
            h,
            q: state.q.values(),
            determinant: DMatrix::from_fn(N, N, |i, j| form[i][j]).determinant(),
        };
    }
    error
}

/// Returns the state of a configuration at rest. Algebraic coordinates are solved for.
///
/// # Errors
/// A [`StepError`] if the result is not finite, or an algebraic coordinate is not found.
pub(crate) fn state_at_rest<S, Q, const N: usize, const M: usize>(
    system: &S,
    q: &[f64; N],
) -> Result<State<Q::Flat>, StepError>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: VectorCoordinates<N>,
{
    let mut state = State::new(*q, [0.0; N]);
    let of = |error, state: &State<Q::Flat>| step_error(error, state, 0.0, &[]);
    if const { is_degenerate::<S>() } && S::ROLES.contains(&Algebraic) {
        let found = Newton::default().solve(*q, |at| algebraic_equations(system, q, at));
        state.q = found.map_err(|error| of(error, &state))?;
    }
    let jet = system.lagrangian_jet(0.0, &state.q, &[0.0; N]);
    state.p = jet.dv;
    // Outside of its domain L is NaN, while its derivatives may be finite.
    let numbers = state.q.iter().chain(&state.p).chain([&jet.value]);
    if numbers.into_iter().all(|x| x.is_finite()) {
        Ok(state)
    } else {
        let state = State::new(*q, [0.0; N]);
        Err(of(SolveError::NonFinite, &state))
    }
}

/// Evaluates the equations of algebraic coordinates at rest; the other coordinates keep their
/// values.
fn algebraic_equations<S, Q, const N: usize, const M: usize>(
    system: &S,
    q: &[f64; N],
    at: &[f64; N],
) -> Evaluation<N>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: VectorCoordinates<N>,
{
    let jet = system.lagrangian_jet(0.0, at, &[0.0; N]);
    let mut equations = Evaluation {
        residual: [0.0; N],
        magnitude: [1.0; N],
        jacobian: [[0.0; N]; N],
        curvature: f64::NAN,
    };
    for i in 0..N {
        if is::<S>(i, Algebraic) {
            equations.residual[i] = jet.dq[i];
            equations.jacobian[i] = jet.dqq[i];
            let terms = jet.dqq[i]
                .iter()
                .zip(at)
                .map(|(slope, q)| (slope * q).abs());
            equations.magnitude[i] = jet.dq[i].abs() + terms.sum::<f64>();
        } else {
            equations.residual[i] = at[i] - q[i];
            equations.magnitude[i] = at[i].abs() + q[i].abs();
            equations.jacobian[i][i] = 1.0;
        }
    }
    equations
}
