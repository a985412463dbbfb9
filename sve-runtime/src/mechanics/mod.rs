//! Mechanics that follow from the Lagrangian: Legendre transform, energy, first-order form.
//!
//! Input: the derivatives that the macro generated ([`System`]). Output: functions of a state, for
//! users and baselines. The equations of motion describe a stochastic Hamilton–Pontryagin system
//! (`docs/mathematics.md`, sections 1 and 4), `dq = v dt + Σ ∂G_a/∂p ∘ dW_a`,
//! `dp = (∂L/∂q + F) dt − Σ ∂G_a/∂q ∘ dW_a`, `p = ∂L/∂v`, with `G = −γ` or `G = H₁`.

pub(crate) mod connected;
pub(crate) mod constraints;
pub(crate) mod degenerate;
mod dual_state;
pub(crate) mod legendre;
mod rates;
mod starts;
pub(crate) mod time_scale;

pub(crate) use dual_state::with_dual_state;
pub(crate) use rates::{Motion, Noises, reach_of_noise, solve_drift, solve_motion};

use crate::error::{StepError, step_error};
use crate::phase::Field;
use crate::phase::configuration::{Coordinates, FlatConfiguration, VectorSpace};
use crate::phase::state::State;
use crate::solve::SolveError;
use crate::system::{ConfigurationOf, Dims, IncrementsOf, MomentumOf, StateOf, System};
use constraints::LEAVES_OUT_FORCES;
use degenerate::{NEEDS_REGULAR, is_degenerate};

/// Mechanical quantities of a Lagrangian and its noises; implemented for every [`System`].
///
/// Quantities of a state are functions of `&state`. The momentum of a velocity is a function of `q`
/// and `v`, which [`State::from_velocity`] calls.
///
/// ```
/// use sve_runtime::prelude::*;
/// struct Pendulum { m: f64, g: f64 }
/// #[variational(midpoint)]
/// impl Pendulum {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 {
///         0.5 * self.m * v * v + self.m * self.g * q.cos()
///     }
/// }
/// # fn main() -> Result<(), StepError> {
/// let pendulum = Pendulum { m: 2.0, g: 9.8 };
/// let state = State::from_velocity(&pendulum, [0.0], [3.0])?;
/// assert_eq!(state.p, [6.0]);
/// assert_eq!(pendulum.velocity(&state)?, [3.0]);
/// assert_eq!(pendulum.hamiltonian(&state)?, 9.0 - 2.0 * 9.8);
/// assert_eq!(pendulum.momentum([0.0], [3.0]), [6.0]);
/// # Ok(())
/// # }
/// ```
pub trait Mechanics: System {
    /// Returns the momentum by the Legendre transform `p = ∂L/∂v(0, q, v)`. If L depends on time,
    /// see [`momentum_at`](Self::momentum_at).
    fn momentum(&self, q: ConfigurationOf<Self>, v: MomentumOf<Self>) -> MomentumOf<Self> {
        self.momentum_at(0.0, q, v)
    }

    /// Returns the momentum by the Legendre transform at time `t`.
    fn momentum_at(
        &self,
        t: f64,
        q: ConfigurationOf<Self>,
        v: MomentumOf<Self>,
    ) -> MomentumOf<Self>;

    /// Returns the velocity of a state by the inverse Legendre transform; [`State::from_velocity`]
    /// does the opposite.
    ///
    /// # Errors
    /// [`StepError::SingularMass`] if the mass matrix `∂²L/∂v²` has no inverse;
    /// [`StepError::NonFiniteInput`] if a number of the state is not finite;
    /// [`StepError::NoVelocity`] if L is not quadratic in v and no velocity with this momentum is
    /// found.
    fn velocity(&self, state: &StateOf<Self>) -> Result<MomentumOf<Self>, StepError>;

    /// Returns the energy `H = ⟨p, v⟩ − L`, in the units of L.
    ///
    /// # Errors
    /// As [`velocity`](Self::velocity).
    fn hamiltonian(&self, state: &StateOf<Self>) -> Result<f64, StepError>;

    /// Returns the instantaneous temperature `⟨p, v⟩/n` of `n` degrees of freedom, in the units of
    /// L (kT, with Boltzmann's constant). For a quadratic kinetic energy K it is 2K/n. Each
    /// constraint takes one degree of freedom; the momentum then must not have a part across the
    /// constraints, which is the case after a step.
    ///
    /// Its mean over the distribution exp(−H/kT) is kT, for any Lagrangian whose mass matrix is
    /// regular (equipartition). If L is linear in velocities, the temperature has no meaning. The
    /// mean along the steps of a rule has the error of the rule. For a force of friction −νp and
    /// γ = σq with σ² = 2νkT, in a harmonic potential of frequency ω:
    ///
    /// | rule | mean of p² over kT, less 1 | mean of q² |
    /// | --- | --- | --- |
    /// | `midpoint` | 0 | exact |
    /// | `stormer_verlet` | −(hω)²/4 | exact |
    /// | `initial_point` | −νh/2 + (hω)²/4 + … | kT + O(h²) |
    /// | `endpoint` | νh/2 + (hω)²/4 + … | kT + O(h²) |
    ///
    /// So compute the temperature with `midpoint`. With `stormer_verlet` and a harmonic potential
    /// divide by 1 − (hω)²/4. Do not compute temperatures with the one-sided rules. Other
    /// potentials change the error at order h².
    ///
    /// [`Blocking`](crate::Blocking) averages along a path, `Ensemble::average` over many paths.
    ///
    /// # Errors
    /// As [`velocity`](Self::velocity); [`StepError::Degenerate`] if L is degenerate.
    fn temperature(&self, state: &StateOf<Self>) -> Result<f64, StepError>;

    /// Returns the drift of the (Stratonovich) first-order form, `(v, ∂L/∂q + F)`. For a system
    /// with constraints, returns the drift of the motion on the constraints, with their forces
    /// `∂φ/∂qᵀ λ` and without the part of the momentum across them, which has no effect on the
    /// motion.
    ///
    /// # Errors
    /// As [`velocity`](Self::velocity); [`StepError::InconsistentStart`],
    /// [`StepError::ConstraintRank`] and [`StepError::ConstraintGradient`] as in a step.
    fn drift(&self, state: &StateOf<Self>) -> Result<Field<MomentumOf<Self>>, StepError>;

    /// Returns the second time derivatives `(q̈, p̈)` of the motion without noise. Does not compile
    /// for a system with constraints, whose multipliers would have to be differentiated too.
    ///
    /// # Errors
    /// As [`velocity`](Self::velocity).
    fn acceleration(&self, state: &StateOf<Self>) -> Result<Field<MomentumOf<Self>>, StepError>;

    /// Returns `Σ_a g_a dW_a`, the noise fields `g_a = (∂G_a/∂p, f_a − ∂G_a/∂q)` combined with the
    /// given increments. A force f that depends on the velocity is NaN if no velocity has the
    /// momentum. Does not compile for a system with constraints, whose forces balance a part of the
    /// noise:
    ///
    /// ```compile_fail
    /// use sve_runtime::prelude::*;
    /// struct Rod { s: f64 }
    /// #[variational(midpoint)]
    /// impl Rod {
    ///     fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
    ///         0.5 * (v[0] * v[0] + v[1] * v[1])
    ///     }
    ///     #[gamma]
    ///     fn push(&self, q: [f64; 2]) -> f64 { self.s * q[0] }
    ///     #[constraint]
    ///     fn rod(&self, q: [f64; 2]) -> f64 { 0.5 * (q[0] * q[0] + q[1] * q[1] - 1.0) }
    /// }
    /// # fn main() {
    /// // error: this function is for systems without constraints …
    /// Rod { s: 0.1 }.noise(&State::new([1.0, 0.0], [0.0, 1.0]), &[0.2]);
    /// # }
    /// ```
    fn noise(&self, state: &StateOf<Self>, dw: &IncrementsOf<Self>) -> Field<MomentumOf<Self>>;

    /// Returns the Itô correction `½ Σ_a (Dg_a) g_a`: the Itô drift minus the Stratonovich drift.
    /// Like [`noise`](Self::noise), does not compile for a system with constraints.
    fn ito_correction(&self, state: &StateOf<Self>) -> Field<MomentumOf<Self>>
    where
        ConfigurationOf<Self>: VectorSpace;
}

impl<S, Q, const N: usize, const M: usize> Mechanics for S
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    #[inline]
    fn momentum_at(&self, t: f64, q: Q, v: Q::Momentum) -> Q::Momentum {
        let jet = self.lagrangian_jet(t, &q.coordinates(), &Q::components(&v));
        Q::from_components(&jet.dv)
    }

    #[inline]
    fn velocity(&self, state: &State<Q>) -> Result<Q::Momentum, StepError> {
        let state = state.to_coordinates();
        if const { is_degenerate::<S>() } {
            degenerate::check_consistent(self, &state)?;
        }
        let v = velocity(self, &state)?;
        Ok(Q::from_components(&v))
    }

    #[inline]
    fn hamiltonian(&self, state: &State<Q>) -> Result<f64, StepError> {
        let state = &state.to_coordinates();
        if const { is_degenerate::<S>() } {
            degenerate::check_consistent(self, state)?;
        }
        let v = velocity(self, state)?;
        let mut energy = -self.lagrangian_jet(state.t, &state.q, &v).value;
        for i in 0..N {
            energy += state.p[i] * v[i];
        }
        if energy.is_finite() {
            Ok(energy)
        } else {
            Err(outside_a_step(self, SolveError::NonFinite, state))
        }
    }

    #[inline]
    fn temperature(&self, state: &State<Q>) -> Result<f64, StepError> {
        let state = &state.to_coordinates();
        if const { is_degenerate::<S>() } {
            return Err(StepError::Degenerate {
                what: "the temperature".to_owned(),
                t: state.t,
            });
        }
        let v = velocity(self, state)?;
        let twice_kinetic: f64 = state.p.iter().zip(&v).map(|(p, v)| p * v).sum();
        let degrees_of_freedom = N.saturating_sub(Self::CONSTRAINTS.len());
        let temperature = twice_kinetic / degrees_of_freedom as f64;
        if temperature.is_finite() {
            Ok(temperature)
        } else {
            Err(outside_a_step(self, SolveError::NonFinite, state))
        }
    }

    #[inline]
    fn drift(&self, state: &State<Q>) -> Result<Field<Q::Momentum>, StepError> {
        let state = &state.to_coordinates();
        if const { is_degenerate::<S>() } {
            degenerate::check_consistent(self, state)?;
        }
        if const { !S::CONSTRAINTS.is_empty() } {
            return constraints::drift::drift(self, state).map(Field::of::<Q>);
        }
        solve_drift(self, state)
            .and_then(finite)
            .map(Field::of::<Q>)
            .map_err(|error| outside_a_step(self, error, state))
    }

    #[inline]
    fn acceleration(&self, state: &State<Q>) -> Result<Field<Q::Momentum>, StepError> {
        const { assert!(S::CONSTRAINTS.is_empty(), "{}", LEAVES_OUT_FORCES) };
        let state = &state.to_coordinates();
        if const { is_degenerate::<S>() } {
            return Err(StepError::Degenerate {
                what: "the acceleration".to_owned(),
                t: state.t,
            });
        }
        legendre::velocity(self, state)
            .and_then(|v| solve_motion(self, state, v))
            .and_then(|motion| finite(motion.second))
            .map(Field::of::<Q>)
            .map_err(|error| outside_a_step(self, error, state))
    }

    #[inline]
    fn noise(&self, state: &State<Q>, dw: &[f64; M]) -> Field<Q::Momentum> {
        const { assert!(S::ROLES.is_empty(), "{}", NEEDS_REGULAR) };
        const { assert!(S::CONSTRAINTS.is_empty(), "{}", LEAVES_OUT_FORCES) };
        let state = state.to_coordinates();
        let mut noise = Noises::at(self, &state).field(dw);
        Q::Flat::add_transport(&state.p, &noise.q, &mut noise.p);
        noise.of::<Q>()
    }

    #[inline]
    fn ito_correction(&self, state: &State<Q>) -> Field<Q::Momentum>
    where
        Q: VectorSpace,
    {
        const { assert!(S::ROLES.is_empty(), "{}", NEEDS_REGULAR) };
        const { assert!(S::CONSTRAINTS.is_empty(), "{}", LEAVES_OUT_FORCES) };
        Noises::at(self, &state.to_coordinates())
            .correction()
            .of::<Q>()
    }
}

/// Returns the velocity with the momentum of `state`.
#[inline]
fn velocity<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q::Flat>,
) -> Result<[f64; N], StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    legendre::velocity(system, state).map_err(|error| outside_a_step(system, error, state))
}

fn finite<const N: usize>(field: Field<[f64; N]>) -> Result<Field<[f64; N]>, SolveError> {
    if field.q.iter().chain(&field.p).all(|x| x.is_finite()) {
        Ok(field)
    } else {
        Err(SolveError::NonFinite)
    }
}

#[cold]
fn outside_a_step<S, Q, const N: usize, const M: usize>(
    system: &S,
    error: SolveError,
    state: &State<Q::Flat>,
) -> StepError
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let error = step_error(error, state, 0.0, &[]);
    if const { is_degenerate::<S>() } {
        return degenerate::explained(system, state, error);
    }
    error
}
