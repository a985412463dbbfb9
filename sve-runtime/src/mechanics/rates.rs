//! Drift, motion, noise and Itô correction in coordinates, as methods compute them.
//!
//! Input: a system and a flat state, or its derivatives there. Output: rates of change of (q, p).
//! Errors are [`SolveError`]s: a method reports the error of a whole step, not of one stage.

use crate::mechanics::legendre;
use crate::phase::Field;
use crate::phase::configuration::{Coordinates, FlatConfiguration};
use crate::phase::state::State;
use crate::solve::{SolveError, dense};
use crate::system::jets::NoiseJet;
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

/// Returns `Σ_a g_a dW_a`.
#[inline]
pub(crate) fn noise_of<const N: usize, const M: usize>(
    jets: &[NoiseJet<N>; M],
    dw: &[f64; M],
) -> Field<[f64; N]> {
    let mut sum = Field {
        q: [0.0; N],
        p: [0.0; N],
    };
    for (jet, dw) in jets.iter().zip(dw) {
        for i in 0..N {
            sum.q[i] += jet.dp[i] * dw;
            sum.p[i] -= jet.dq[i] * dw;
        }
    }
    sum
}

/// Returns `½ Σ_a (Dg_a) g_a`.
#[inline]
pub(crate) fn correction_of<const N: usize, const M: usize>(
    jets: &[NoiseJet<N>; M],
) -> Field<[f64; N]> {
    let mut sum = Field {
        q: [0.0; N],
        p: [0.0; N],
    };
    for g in jets {
        for i in 0..N {
            for j in 0..N {
                sum.q[i] += 0.5 * (g.dqp[j][i] * g.dp[j] - g.dpp[i][j] * g.dq[j]);
                sum.p[i] -= 0.5 * (g.dqq[i][j] * g.dp[j] - g.dqp[i][j] * g.dq[j]);
            }
        }
    }
    sum
}
