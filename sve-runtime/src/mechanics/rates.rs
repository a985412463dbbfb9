//! Drift, motion, noise and Itô correction in coordinates, as methods compute them.
//!
//! Input: a system and a flat state, or its derivatives there. Output: rates of change of (q, p).
//! Errors are [`SolveError`]s: a method reports the error of a whole step, not of one stage.

use crate::mechanics::legendre;
use crate::phase::Field;
use crate::phase::configuration::{Coordinates, FlatConfiguration};
use crate::phase::state::State;
use crate::solve::{SolveError, dense};
use crate::system::jets::{ForceJet, NoiseJet};
use crate::system::{Dims, System};

/// Returns the drift `(v, ∂L/∂q + F)`. Only the velocity is checked to be finite.
#[inline]
pub(crate) fn solve_drift<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
) -> Result<Field<[f64; N]>, SolveError>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    let q = legendre::velocity(system, state)?;
    let mut p = system.lagrangian_jet(state.t, &state.q, &q).dq;
    if S::FORCED {
        let force = system.force_jet(state.t, &state.q, &q).value;
        for i in 0..N {
            p[i] += force[i];
        }
    }
    Q::Flat::add_transport(&state.p, &q, &mut p);
    Ok(Field { q, p })
}

/// First and second time derivatives of `(q, p)` without noise.
pub(crate) struct Motion<const N: usize> {
    pub(crate) first: Field<[f64; N]>,
    pub(crate) second: Field<[f64; N]>,
}

/// Returns the time derivatives of the motion with velocity `v`.
#[inline]
pub(crate) fn solve_motion<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
    v: [f64; N],
) -> Result<Motion<N>, SolveError>
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    let jet = system.lagrangian_jet(state.t, &state.q, &v);
    let force = system.force_jet(state.t, &state.q, &v);
    // d/dt ∂L/∂v = ∂L/∂q + F:  L_vv a = L_q + F − L_vq v − L_vt
    let mut total = jet.dq;
    let mut rhs = [0.0; N];
    Q::Flat::add_transport(&jet.dv, &v, &mut total);
    for i in 0..N {
        total[i] += force.value[i];
        rhs[i] = total[i] - jet.dvt[i];
        for j in 0..N {
            rhs[i] -= jet.dqv[j][i] * v[j];
        }
    }
    let a = dense::solve(&jet.dvv, &rhs).ok_or(SolveError::Singular { iteration: 0 })?;
    // d/dt (∂L/∂q + F) = (L_qq + F_q) v + (L_qv + F_v) a + L_qt + F_t
    let mut p = jet.dqt;
    for i in 0..N {
        p[i] += force.dt[i];
        for j in 0..N {
            p[i] += (jet.dqq[i][j] + force.dq[i][j]) * v[j];
            p[i] += (jet.dqv[i][j] + force.dv[i][j]) * a[j];
        }
    }
    Q::Flat::add_transport(&total, &v, &mut p);
    Q::Flat::add_transport(&jet.dv, &a, &mut p);
    Ok(Motion {
        first: Field { q: v, p: total },
        second: Field { q: a, p },
    })
}

/// Returns a bound of the eigenvalues of `Σ ΔW_a ∂f_a/∂v M⁻¹` at a state: how far the forces of
/// noises turn and stretch the momentum. A step by any rule has no pole below 1.
#[inline]
pub(crate) fn reach_of_noise<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
    dw: &[f64],
) -> f64
where
    S: System<Dims = Dims<N, M, Q>> + ?Sized,
    Q: Coordinates<N>,
{
    if !S::NOISE_READS_VELOCITY {
        return 0.0;
    }
    let Ok(v) = legendre::velocity(system, state) else {
        return f64::INFINITY;
    };
    let forces = system.noise_force_jets(state.t, &state.q, &v);
    // with stage noise, the increment of a process is the sum of those at its stages
    let stages = dw.len() / M.max(1);
    let mut slopes = [[0.0; N]; N];
    for (force, parts) in forces.iter().zip(dw.chunks(stages.max(1))) {
        let size: f64 = parts.iter().map(|part| part.abs()).sum();
        let dw: f64 = if stages == 1 { parts[0] } else { size };
        for (row, dv) in slopes.iter_mut().zip(&force.dv) {
            for j in 0..N {
                row[j] += dw * dv[j];
            }
        }
    }
    if slopes.as_flattened().iter().all(|&slope| slope == 0.0) {
        return 0.0;
    }
    let mass = system.lagrangian_jet(state.t, &state.q, &v).dvv;
    let Some(mass) = dense::factored(&mass) else {
        return f64::INFINITY;
    };
    let sizes = slopes.map(|row| mass.solve(&row).iter().map(|x| x.abs()).sum::<f64>());
    sizes.into_iter().fold(0.0, f64::max)
}

/// The noises at a state.
pub(crate) struct Noises<const N: usize, const M: usize> {
    /// The Hamiltonians.
    pub(crate) jets: [NoiseJet<N>; M],
    /// The forces; `None` if no noise is a force.
    forces: Option<[ForceJet<N>; M]>,
    /// The mass matrix; `None` if no force depends on the velocity.
    mass: Option<[[f64; N]; N]>,
}

impl<const N: usize, const M: usize> Noises<N, M> {
    /// Evaluates the noises. If no velocity has the momentum, forces that depend on it are NaN.
    #[inline]
    pub(crate) fn at<S, Q>(system: &S, state: &State<Q::Flat>) -> Self
    where
        S: System<Dims = Dims<N, M, Q>> + ?Sized,
        Q: Coordinates<N>,
    {
        let jets = system.noise_jets(state.t, &state.q, &state.p);
        let mut v = [0.0; N];
        let mut mass = None;
        if S::NOISE_READS_VELOCITY {
            v = legendre::velocity(system, state).unwrap_or([f64::NAN; N]);
            mass = Some(system.lagrangian_jet(state.t, &state.q, &v).dvv);
        }
        let forces = S::NOISE_FORCED.then(|| system.noise_force_jets(state.t, &state.q, &v));
        Self { jets, forces, mass }
    }

    /// Returns `Σ_a g_a dW_a`.
    #[inline]
    pub(crate) fn field(&self, dw: &[f64; M]) -> Field<[f64; N]> {
        let mut sum = Field {
            q: [0.0; N],
            p: [0.0; N],
        };
        for (jet, dw) in self.jets.iter().zip(dw) {
            for i in 0..N {
                sum.q[i] += jet.dp[i] * dw;
                sum.p[i] -= jet.dq[i] * dw;
            }
        }
        for (force, dw) in self.forces.iter().flatten().zip(dw) {
            for i in 0..N {
                sum.p[i] += force.value[i] * dw;
            }
        }
        sum
    }

    /// Returns the rates of the momentum by each noise, `f_a − ∂G_a/∂q`.
    pub(crate) fn kicks(&self) -> [[f64; N]; M] {
        core::array::from_fn(|a| {
            let mut dw = [0.0; M];
            dw[a] = 1.0;
            self.field(&dw).p
        })
    }

    /// Returns `½ Σ_a (Dg_a) g_a`. A noise is either a Hamiltonian or a force.
    #[inline]
    pub(crate) fn correction(&self) -> Field<[f64; N]> {
        let mut sum = Field {
            q: [0.0; N],
            p: [0.0; N],
        };
        for g in &self.jets {
            for i in 0..N {
                for j in 0..N {
                    sum.q[i] += 0.5 * (g.dqp[j][i] * g.dp[j] - g.dpp[i][j] * g.dq[j]);
                    sum.p[i] -= 0.5 * (g.dqq[i][j] * g.dp[j] - g.dqp[i][j] * g.dq[j]);
                }
            }
        }
        let Some(mass) = &self.mass else {
            return sum;
        };
        for force in self.forces.iter().flatten() {
            // the change of the velocity by the force
            let change = dense::solve(mass, &force.value).unwrap_or([f64::NAN; N]);
            for i in 0..N {
                for j in 0..N {
                    sum.p[i] += 0.5 * force.dv[i][j] * change[j];
                }
            }
        }
        sum
    }
}
