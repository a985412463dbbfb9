//! Systems with a time scale, dt = s(q) dτ, and their states.
//!
//! The macro derives the steps of such a system for L̃(q, w) = s (L(q, w/s) + E), for a type that
//! holds the energy E beside the system. So all that a system has, a system with a held energy has
//! too, in the time τ. The quantities of L follow from those of L̃: the momenta are the same, the
//! velocity is w/s, and the energy is K/s + E with the Hamiltonian K = s (H − E) of L̃.

use core::ops::Deref;

use super::Mechanics;
use crate::error::StepError;
use crate::phase::configuration::Configuration;
use crate::phase::state::State;
use crate::system::{AnySystem, Kind, MomentumOf, StateOf, System};

/// The kind of systems with a time scale, whose steps need the energy of the path.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct ScaledTime;

impl Kind for ScaledTime {
    type Cache = ();
}

/// A system in the time τ, with the energy of a path: what
/// [`WithTimeScale::with_energy`] returns.
pub trait TimeScale: System {
    /// Returns s at a state: the time that passes in a unit of τ.
    fn time_scale(&self, state: &StateOf<Self>) -> f64;
}

/// A system with a `#[time_scale]`; `#[variational]` implements this trait.
///
/// Its quantities are those of its Lagrangian, in the time t.
///
/// ```
/// use sve_runtime::prelude::*;
///
/// /// A planet, with steps in proportion to r^{3/2}.
/// struct Planet { mu: f64 }
///
/// #[variational(gauss(4))]
/// impl Planet {
///     fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
///         0.5 * (v[0] * v[0] + v[1] * v[1]) + self.mu / q[0].hypot(q[1])
///     }
///     #[time_scale]
///     fn scale(&self, q: [f64; 2]) -> f64 { q[0].hypot(q[1]).powf(1.5) }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let planet = Planet { mu: 4.0 };
/// let state = State::new([4.0, 0.0], [0.0, 0.5]);
/// assert_eq!(planet.scale_at(&state)?, 8.0);
/// assert_eq!(planet.velocity(&state)?, [0.0, 0.5]);
/// assert_eq!(planet.hamiltonian(&state)?, 0.125 - 1.0);
/// # Ok(())
/// # }
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no time scale",
    note = "a system has a time scale if a function of its block has the attribute `#[time_scale]`, as in `fn scale(&self, q: [f64; 2]) -> f64`; without one, its states are `State::new(q, p)`"
)]
pub trait WithTimeScale: AnySystem<Kind = ScaledTime> {
    /// The system in the time τ, with the energy of a path.
    type Held<'a>: TimeScale
        + Mechanics
        + AnySystem<
            Configuration = <Self as AnySystem>::Configuration,
            Target = Self::Held<'a>,
            Stepped = Self::Held<'a>,
        > + Clone
    where
        Self: 'a;

    /// Returns the system in the time τ on a path of this energy. Its Lagrangian is L̃, so its
    /// velocities are dq/dτ, and its Hamiltonian is K = s (H − E).
    fn with_energy(&self, energy: f64) -> Self::Held<'_>;

    /// Returns the time scale s at a state.
    ///
    /// # Errors
    /// [`StepError::TimeScale`] if it is not positive and finite.
    fn scale_at(&self, state: &StateOf<Self>) -> Result<f64, StepError> {
        let scale = self.with_energy(0.0).time_scale(state);
        if is_time_scale(scale) {
            return Ok(scale);
        }
        let [q, p] = state.stored();
        let bad = |(name, values): (&str, &[f64])| {
            let at = values.iter().position(|x| !x.is_finite())?;
            Some(StepError::NonFiniteInput {
                what: format!("{name}[{at}]"),
                value: values[at],
                t: state.t,
            })
        };
        let scale = StepError::TimeScale {
            t: state.t,
            h: 0.0,
            scale,
            q: q.clone(),
        };
        let mut inputs = [("q", &q[..]), ("p", &p[..])].into_iter();
        Err(inputs.find_map(bad).unwrap_or(scale))
    }

    /// Returns the energy `H = ⟨p, v⟩ − L` of a state, in the units of L.
    ///
    /// # Errors
    /// As [`Mechanics::hamiltonian`], and as [`scale_at`](Self::scale_at).
    fn hamiltonian(&self, state: &StateOf<Self>) -> Result<f64, StepError> {
        let scale = self.scale_at(state)?;
        Ok(self.with_energy(0.0).hamiltonian(state)? / scale)
    }

    /// Returns the velocity dq/dt of a state.
    ///
    /// # Errors
    /// As [`Mechanics::velocity`], and as [`scale_at`](Self::scale_at).
    fn velocity(&self, state: &StateOf<Self>) -> Result<MomentumOf<Self>, StepError> {
        let scale = self.scale_at(state)?;
        let velocity = self.with_energy(0.0).velocity(state)?;
        Ok(times(velocity, 1.0 / scale))
    }
}

/// Returns a momentum or a velocity times a number.
fn times<P: Configuration>(mut vector: P, factor: f64) -> P {
    let mut values = vec![0.0; vector.stored_values()];
    vector.store(&mut values);
    for x in &mut values {
        *x *= factor;
    }
    vector.restore(&values);
    vector
}

/// Returns whether a value of a time scale is positive and finite.
#[inline]
pub(crate) fn is_time_scale(scale: f64) -> bool {
    scale > 0.0 && scale < f64::INFINITY
}

/// The state of a system with a time scale: time, configuration and momentum, and the energy on
/// which its path stays.
///
/// It dereferences to a [`State`], so it has the fields `t`, `q` and `p`, and functions of `&State`
/// take it. The energy is computed once, when the state is made, and steps hold it fixed:
/// recomputed in each step, it would make the steps lose their structure. The fields cannot be
/// written to, since the energy would no longer be theirs: after a change of `q` or `p` make
/// another state, by [`of`](Self::of).
///
/// ```
/// use sve_runtime::prelude::*;
///
/// /// A comet, with steps in proportion to r^{3/2}.
/// struct Comet;
///
/// #[variational(gauss(8))]
/// impl Comet {
///     fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
///         0.5 * (v[0] * v[0] + v[1] * v[1]) + 1.0 / q[0].hypot(q[1])
///     }
///     #[time_scale]
///     fn scale(&self, q: [f64; 2]) -> f64 { q[0].hypot(q[1]).powf(1.5) }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// // the perihelion of an orbit with the eccentricity 0.99
/// let comet = Integrator::new(Comet, Gauss::<8>);
/// let mut state = TimedState::new(comet.system(), [0.01, 0.0], [0.0, 199.0_f64.sqrt()])?;
/// assert!((state.energy() + 0.5).abs() < 1e-13);
/// comet.step(&mut state, 0.5, &[])?;
/// assert!(state.t > 0.0 && state.t < 0.001);
/// // back to the perihelion after a period
/// let end = comet.trajectory(state, 0.5, NoNoise).until(std::f64::consts::TAU).last().unwrap()?;
/// assert!((end.q[0] - 0.01).abs() < 1e-10);
/// # Ok(())
/// # }
/// ```
///
/// ```compile_fail,E0594
/// # use sve_runtime::prelude::*;
/// fn shift(state: &mut TimedState<[f64; 2]>) {
///     state.q[0] += 0.1;
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "Q: crate::phase::serialise::Serialised + Configuration<Momentum = P>")
)]
pub struct TimedState<Q: Configuration, P = <Q as Configuration>::Momentum> {
    pub(crate) state: State<Q, P>,
    #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
    energy: f64,
}

impl<Q: Configuration> TimedState<Q> {
    /// Returns the state `(q, p)` at `t = 0`, on the path of its energy.
    ///
    /// # Errors
    /// [`StepError::TimeScale`] if s is not positive and finite at `q`; otherwise as
    /// [`Mechanics::hamiltonian`].
    pub fn new<S>(system: &S, q: Q, p: Q::Momentum) -> Result<Self, StepError>
    where
        S: WithTimeScale<Configuration = Q> + ?Sized,
    {
        Self::of(system, State::new(q, p))
    }

    /// Returns the state with a velocity dq/dt, p = ∂L/∂v(q, v), at `t = 0`.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_velocity<S>(system: &S, q: Q, v: Q::Momentum) -> Result<Self, StepError>
    where
        S: WithTimeScale<Configuration = Q> + ?Sized,
    {
        let scale = system.scale_at(&State::new(q.clone(), v.clone()))?;
        let held = system.with_energy(0.0);
        let p = held.momentum(q.clone(), times(v, scale));
        Self::new(system, q, p)
    }

    /// Returns a state on the path of its energy, at its time.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of<S>(system: &S, state: State<Q>) -> Result<Self, StepError>
    where
        S: WithTimeScale<Configuration = Q> + ?Sized,
    {
        let energy = system.hamiltonian(&state)?;
        Ok(Self { state, energy })
    }

    /// Returns a state on the path of a given energy: that of a start whose path leads to this
    /// state.
    pub fn on_path(state: State<Q>, energy: f64) -> Self {
        Self { state, energy }
    }

    /// Returns the energy on which the path stays, that of its start.
    pub fn energy(&self) -> f64 {
        self.energy
    }

    /// Returns time, configuration and momentum.
    pub fn into_state(self) -> State<Q> {
        self.state
    }
}

impl<Q: Configuration> Deref for TimedState<Q> {
    type Target = State<Q>;

    #[inline(always)]
    fn deref(&self) -> &State<Q> {
        &self.state
    }
}
