//! The motion of a system with constraints, without noise: `dp/dt = ∂L/∂q + F + ∂φ/∂qᵀ λ` with the
//! λ that keeps `∂φ/∂t + ∂φ/∂q v = 0`.
//!
//! Differentiating this equation for v along the motion gives
//!
//! ```text
//! ∂φ/∂q a + c = 0    c = ∂²φ/∂t² + 2 ⟨∂²φ/∂t∂q, v⟩ + ⟨v, ∂²φ/∂q² v⟩
//! L_vv a = ∂L/∂q + F − L_vq v − L_vt + ∂φ/∂qᵀ λ
//! ```
//!
//! and so `∂φ/∂q L_vv⁻¹ ∂φ/∂qᵀ λ = −c − ∂φ/∂q a₀` with the acceleration a₀ of the motion without
//! constraints.

use nalgebra::DVector;

use super::Linearised;
use super::consistent::rank_error;
use super::explain::inconsistent_start;
use crate::error::{StepError, step_error};
use crate::mechanics::legendre;
use crate::phase::Field;
use crate::phase::configuration::Coordinates;
use crate::phase::state::State;
use crate::solve::SolveError;
use crate::system::{Dims, System};

/// Returns the drift with the forces of the constraints. The part of the momentum across the
/// constraints is left out, as in a step.
///
/// # Errors
/// [`StepError::InconsistentStart`] if the state violates a constraint;
/// [`StepError::ConstraintRank`] and [`StepError::ConstraintGradient`] if the gradients do not
/// determine forces; otherwise the errors of the velocity.
pub(crate) fn drift<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
) -> Result<Field<[f64; N]>, StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let failed = |error| step_error(error, state, 0.0, &[]);
    let singular = || failed(SolveError::Singular { iteration: 0 });
    let (t, q) = (state.t, &state.q);
    let mut v = legendre::velocity(system, state).map_err(failed)?;
    let here = Linearised::at(system, t, q).ok_or_else(singular)?;
    if let Some(error) = inconsistent_start::<S, N>(&here, t) {
        return Err(error);
    }
    if let Some(error) = rank_error::<S, Q, N, M>(system, &here, t, q) {
        return Err(error);
    }
    // the second pass removes the rounding errors of the first
    for _ in 0..2 {
        let rates = here.rates(&v).into_iter().zip(&here.jets);
        let rates = rates.map(|(rate, jet)| rate + jet.dt).collect();
        let rates = here.solve(&DVector::from_vec(rates)).ok_or_else(singular)?;
        let normal = &here.directions * rates;
        for i in 0..N {
            v[i] -= normal[i];
        }
    }
    let p = force(system, state, &v, &here).ok_or_else(singular)?;
    let field = Field { q: v, p };
    if field.q.iter().chain(&field.p).all(|x| x.is_finite()) {
        Ok(field)
    } else {
        Err(failed(SolveError::NonFinite))
    }
}

/// Returns `∂L/∂q + F + ∂φ/∂qᵀ λ` at a velocity along the constraints; `None` if a matrix is
/// singular.
fn force<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
    v: &[f64; N],
    here: &Linearised<N>,
) -> Option<[f64; N]>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let (t, q) = (state.t, &state.q);
    let jet = system.lagrangian_jet(t, q, v);
    let applied = system.force_jet(t, q, v).value;
    let mut p: [f64; N] = core::array::from_fn(|i| jet.dq[i] + applied[i]);
    let free = DVector::from_fn(N, |i, _| {
        let moved: f64 = (0..N).map(|j| jet.dqv[j][i] * v[j]).sum();
        p[i] - moved - jet.dvt[i]
    });
    let free = here.mass.clone().lu().solve(&free)?;
    let mut rest = here.rates(&core::array::from_fn(|i| free[i]));
    let mut k = 0;
    system.constraint_curvatures(t, q, v, &mut |curvature| {
        rest[k] += curvature;
        k += 1;
    });
    let multipliers = here.solve(&DVector::from_vec(rest))?;
    for (jet, multiplier) in here.jets.iter().zip(multipliers.iter()) {
        for i in 0..N {
            p[i] -= multiplier * jet.dq[i];
        }
    }
    Some(p)
}

impl<const N: usize> Linearised<N> {
    /// Returns `∂φ/∂q v`.
    fn rates(&self, v: &[f64; N]) -> Vec<f64> {
        let along = self.jets.iter().map(|jet| jet.dq.iter().zip(v));
        along.map(|terms| terms.map(|(a, v)| a * v).sum()).collect()
    }
}
