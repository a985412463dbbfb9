//! The data of a step of a Gauss rule, and the forces at its stages.
//!
//! With velocities `V_i`, positions `Q_i` and momenta `P_i = L_v(Q_i, V_i)` of the stages,
//!
//! ```text
//! Y_i = h b_i V_i + Σ_a ∂G_a/∂p ω_ai      F_i = h b_i (L_q + F) − Σ_a ∂G_a/∂q ω_ai  (at stage i)
//! Q_i = q₀ + Σ_j μ_ij Y_j                 P_i = p₀ + Σ_j μ_ij F_j
//! q₁ = q₀ + Σ Y_j                         p₁ = p₀ + Σ F_j
//! ```
//!
//! where `μ_ij = a_ij / b_j`, and `ω_ai` is the increment of process a at stage i: `b_i ΔW_a`, or
//! with stage noise the increment of `stage_noise.rs`. The equations follow from the action in
//! `docs/mathematics.md`, section 2; the momenta need `1 − μ_ji`, which is `μ_ij`.

use super::tableau::Tableau;
use crate::phase::configuration::VectorCoordinates;
use crate::phase::state::State;
use crate::system::{Dims, ForceJet, LagrangianJet, System};

/// A step of the rule with `S` stages.
pub(super) struct Step<'a, Sys, const S: usize, const N: usize, const M: usize> {
    pub(super) system: &'a Sys,
    pub(super) state: &'a State<[f64; N]>,
    pub(super) h: f64,
    /// The coefficients of the rule. Behind a reference they are data instead of constants, so the
    /// compiler multiplies with whole rows.
    pub(super) tableau: &'static Tableau<S>,
    /// Times of the stages.
    pub(super) times: [f64; S],
    /// `h b_i`.
    pub(super) weights: [f64; S],
    /// `ω_ai`, the parts of the increments at the stages.
    pub(super) noise: [[f64; S]; M],
}

impl<Sys, const S: usize, const N: usize, const M: usize> Clone for Step<'_, Sys, S, N, M> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<Sys, const S: usize, const N: usize, const M: usize> Copy for Step<'_, Sys, S, N, M> {}

/// Jets at a stage, and the impulses and displacements with their derivatives.
#[derive(Clone, Copy)]
pub(super) struct Stage<const N: usize> {
    pub(super) lagrangian: LagrangianJet<N>,
    /// `F_i`.
    pub(super) impulse: Response<N>,
    /// `Σ_a ∂G_a/∂p ω_ai`, the displacement by noise.
    pub(super) shift: Response<N>,
    /// A bound of the rounding error of the impulse, due to the rounding errors of position and
    /// velocity.
    pub(super) rounding: [f64; N],
}

impl<const N: usize> Stage<N> {
    /// A stage before its evaluation.
    pub(super) const EMPTY: Self = Self {
        lagrangian: LagrangianJet {
            value: 0.0,
            dq: [0.0; N],
            dv: [0.0; N],
            dqq: [[0.0; N]; N],
            dqv: [[0.0; N]; N],
            dvv: [[0.0; N]; N],
            dqt: [0.0; N],
            dvt: [0.0; N],
        },
        impulse: Response::ZERO,
        shift: Response::ZERO,
        rounding: [0.0; N],
    };
}

/// A vector with its derivatives by position and velocity of the stage.
#[derive(Clone, Copy)]
pub(super) struct Response<const N: usize> {
    pub(super) value: [f64; N],
    /// Derivatives by position, with rows by component.
    pub(super) by_position: [[f64; N]; N],
    /// Derivatives by velocity, with rows by component.
    pub(super) by_velocity: [[f64; N]; N],
}

impl<const N: usize> Response<N> {
    const ZERO: Self = Self {
        value: [0.0; N],
        by_position: [[0.0; N]; N],
        by_velocity: [[0.0; N]; N],
    };

    /// Adds `part` times a force.
    #[inline(always)]
    fn add(&mut self, part: f64, force: &ForceJet<N>) {
        for m in 0..N {
            self.value[m] += part * force.value[m];
            for n in 0..N {
                self.by_position[m][n] += part * force.dq[m][n];
                self.by_velocity[m][n] += part * force.dv[m][n];
            }
        }
    }
}

impl<'a, Sys, Q, const S: usize, const N: usize, const M: usize> Step<'a, Sys, S, N, M>
where
    Sys: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    /// Returns the step with these increments at the stages.
    #[inline(always)]
    pub(super) fn new(
        system: &'a Sys,
        state: &'a State<[f64; N]>,
        h: f64,
        noise: [[f64; S]; M],
    ) -> Self {
        let tableau = const { &Tableau::<S>::VALUES };
        let Tableau { c, b, .. } = tableau;
        Self {
            tableau,
            system,
            state,
            h,
            times: c.map(|c| state.t + c * h),
            weights: b.map(|b| h * b),
            noise,
        }
    }

    /// Evaluates the jets at stage `i`.
    #[inline]
    pub(super) fn stage(&self, i: usize, q: &[f64; N], v: &[f64; N]) -> Stage<N> {
        let (t, weight) = (self.times[i], self.weights[i]);
        let lagrangian = self.system.lagrangian_jet(t, q, v);
        let mut impulse = Response::ZERO;
        // Outside of its domain L is NaN, while its derivatives may be finite.
        let undefined = 0.0 * lagrangian.value;
        for m in 0..N {
            impulse.value[m] = weight * lagrangian.dq[m] + undefined;
            for n in 0..N {
                impulse.by_position[m][n] = weight * lagrangian.dqq[m][n];
                impulse.by_velocity[m][n] = weight * lagrangian.dqv[m][n];
            }
        }
        if Sys::FORCED {
            impulse.add(weight, &self.system.force_jet(t, q, v));
        }
        if Sys::NOISE_FORCED {
            let forces = self.system.noise_force_jets(t, q, v);
            for (force, parts) in forces.iter().zip(&self.noise) {
                impulse.add(parts[i], force);
            }
        }
        let mut shift = Response::ZERO;
        self.add_noise(i, q, &lagrangian, &mut impulse, &mut shift);
        let mut rounding = [0.0; N];
        for m in 0..N {
            for n in 0..N {
                rounding[m] += (impulse.by_position[m][n] * q[n]).abs()
                    + (impulse.by_velocity[m][n] * v[n]).abs();
            }
            rounding[m] *= f64::EPSILON;
        }
        Stage {
            lagrangian,
            impulse,
            shift,
            rounding,
        }
    }

    /// Adds the impulses and displacements by noise at stage `i`. The noise Hamiltonians take the
    /// momentum of the stage, which depends on position and velocity.
    #[inline]
    fn add_noise(
        &self,
        i: usize,
        q: &[f64; N],
        lagrangian: &LagrangianJet<N>,
        impulse: &mut Response<N>,
        shift: &mut Response<N>,
    ) {
        if M == 0 {
            return;
        }
        let jets = self.system.noise_jets(self.times[i], q, &lagrangian.dv);
        for (jet, part) in jets.iter().zip(&self.noise) {
            let part = part[i];
            for m in 0..N {
                impulse.value[m] -= part * jet.dq[m];
                shift.value[m] += part * jet.dp[m];
                for n in 0..N {
                    let (mut qq, mut qv) = (jet.dqq[m][n], 0.0);
                    let (mut pq, mut pv) = (jet.dqp[n][m], 0.0);
                    for k in 0..N {
                        // ∂p_k/∂q_n and ∂p_k/∂v_n
                        let (by_q, by_v) = (lagrangian.dqv[n][k], lagrangian.dvv[k][n]);
                        qq += jet.dqp[m][k] * by_q;
                        qv += jet.dqp[m][k] * by_v;
                        pq += jet.dpp[m][k] * by_q;
                        pv += jet.dpp[m][k] * by_v;
                    }
                    impulse.by_position[m][n] -= part * qq;
                    impulse.by_velocity[m][n] -= part * qv;
                    shift.by_position[m][n] += part * pq;
                    shift.by_velocity[m][n] += part * pv;
                }
            }
        }
    }
}

/// Returns `Σ_j μ_ij z_j` at stage `i`.
#[inline]
pub(super) fn at_stage<const S: usize, const N: usize>(i: usize, z: &[[f64; N]; S]) -> [f64; N] {
    let ratio = const { &Tableau::<S>::VALUES.ratio };
    let mut sum = [0.0; N];
    for j in 0..S {
        for n in 0..N {
            sum[n] += ratio[j][i] * z[j][n];
        }
    }
    sum
}

/// Returns `Σ_j z_j`, from both ends to the middle. The order is the same for the step backwards.
#[inline]
pub(super) fn total<const S: usize, const N: usize>(z: &[[f64; N]; S]) -> [f64; N] {
    let mut sum = [0.0; N];
    for n in 0..N {
        for j in 0..S / 2 {
            sum[n] += z[j][n] + z[S - 1 - j][n];
        }
        if S % 2 == 1 {
            sum[n] += z[S / 2][n];
        }
    }
    sum
}
