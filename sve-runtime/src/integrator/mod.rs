//! Integrators: a system with a rule.
//!
//! | file | part of a step |
//! | --- | --- |
//! | `method.rs` | the integrator as a method |
//! | `steps.rs` | steps by the kind of the system: walks over the substeps of a rule |
//! | `scenes.rs` | steps of scenes |
//! | `modes.rs` | the common parts of the modes of a walk |
//! | `start.rs` | the test of the start; steps in lanes |
//! | `step.rs` | the fast path; the number of iterations, the impulses of constraints |
//! | `accept.rs` | the tests of a result |
//! | `rescue.rs` | the continuation after a failure of the fast path |
//! | `continuation.rs` | following the solution from the limit of no noise and h → 0 |
//! | `compensated.rs` | compensated summation |
//! | `tangent.rs` | the derivatives of a step |
//! | `gradient.rs` | derivatives along paths |
//! | `inputs.rs` | steps of systems with inputs |
//! | `driven.rs` | the method whose inputs come from a function |
//! | `adapted.rs` | attempts at steps whose size is adapted |
//! | `time_scale.rs` | the method of a system with a time scale |

pub(crate) mod accept;
pub(crate) mod adapted;
mod compensated;
mod consistent;
mod constraint_forces;
mod continuation;
pub(crate) mod driven;
mod gradient;
pub(crate) mod inputs;
mod method;
pub(crate) mod modes;
mod rescue;
pub(crate) mod scenes;
mod start;
pub(crate) mod step;
pub(crate) mod steps;
mod tangent;
pub(crate) mod time_scale;

use core::fmt;

pub use constraint_forces::{ConstraintForce, ConstraintForces};
pub use inputs::Holding;
use step::Advance;
use steps::{Steps, walk_from};
pub use tangent::{Sensitivity, Tangent};

use crate::error::StepError;
use crate::method::OneStepMethod;
use crate::phase::configuration::{Coordinates, Reduced, WithRotations};
use crate::phase::state::State;
use crate::rule::Rule;
use crate::solve::newton::Newton;
use crate::system::plan::Plan;
use crate::system::{AnySystem, Dims, Kind, StateOf, System};

/// A system and the rule that discretises its action.
///
/// ```
/// use sve_runtime::prelude::*;
///
/// /// A pendulum whose pivot is shaken.
/// struct Pendulum { g: f64, sigma: f64 }
///
/// #[variational(midpoint)]
/// impl Pendulum {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.g * q.cos() }
///     #[gamma]
///     fn shake(&self, q: f64) -> f64 { self.sigma * q.sin() }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let pendulum = Integrator::new(Pendulum { g: 9.8, sigma: 0.1 }, Midpoint);
/// let mut state = State::new([1.0], [0.0]);
/// pendulum.step(&mut state, 0.01, &[0.02])?;
/// assert_eq!(state.t, 0.01);
/// # Ok(())
/// # }
/// ```
///
/// It owns the system, or borrows it: with `Integrator::new(&pendulum, Midpoint)`, other methods
/// can use the system too.
pub struct Integrator<S: AnySystem, R> {
    system: S,
    rule: R,
    newton: Newton,
    cache: <S::Kind as Kind>::Cache,
}

#[allow(clippy::expl_impl_clone_on_copy)] // a cache with a clone may have no copy
impl<S: AnySystem + Clone, R: Clone> Clone for Integrator<S, R> {
    fn clone(&self) -> Self {
        Self {
            system: self.system.clone(),
            rule: self.rule.clone(),
            newton: self.newton,
            cache: self.cache.clone(),
        }
    }
}

impl<S: AnySystem<Kind: Kind<Cache: Copy>> + Copy, R: Copy> Copy for Integrator<S, R> {}

#[allow(clippy::missing_fields_in_debug)] // the cache follows from the other fields
impl<S: AnySystem + fmt::Debug, R: fmt::Debug> fmt::Debug for Integrator<S, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Integrator")
            .field("system", &self.system)
            .field("rule", &self.rule)
            .field("newton", &self.newton)
            .finish()
    }
}

impl<S: AnySystem, R: Rule<S::Stepped>> Integrator<S, R> {
    /// Returns the integrator of `system` with a rule that the attribute lists.
    pub fn new(system: S, rule: R) -> Self {
        Self {
            system,
            rule,
            newton: Newton::default(),
            cache: Default::default(),
        }
    }

    /// Returns the plan of the step: its equations, their solution, and their cost.
    ///
    #[doc = include_str!("../example.md")]
    /// let plan = pendulum.plan();
    /// println!("{plan}");
    /// assert_eq!((plan.degrees_of_freedom, plan.noises, plan.deterministic_order), (1, 1, 2));
    #[doc = include_str!("../example_end.md")]
    pub fn plan(&self) -> &'static Plan {
        R::PLAN
    }
}

impl<S: AnySystem, R> Integrator<S, R> {
    /// Replaces the options of the Newton iteration.
    ///
    #[doc = include_str!("../example.md")]
    /// let newton = Newton { max_iterations: 20, ..Newton::default() };
    /// let pendulum = pendulum.with_newton(newton);
    /// assert_eq!(pendulum.newton().max_iterations, 20);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn with_newton(mut self, newton: Newton) -> Self {
        self.newton = newton;
        self
    }

    /// Returns the system.
    pub fn system(&self) -> &S {
        &self.system
    }

    /// Returns the system, so that parameters can be changed between steps: a control, or a value
    /// from a table over time.
    ///
    /// A parameter is constant within a step. Each [`step`](Self::step) computes anew the values
    /// that depend on parameters alone; a [`trajectory`](Self::trajectory) borrows the integrator,
    /// so its parameters do not change.
    ///
    /// ```
    /// use sve_runtime::noise::Noise as _;
    /// use sve_runtime::prelude::*;
    ///
    /// /// A pendulum with a motor at its pivot.
    /// struct Pendulum { g: f64, torque: f64, sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Pendulum {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 {
    ///         0.5 * v * v + self.g * q.cos() + self.torque * q
    ///     }
    ///     #[gamma]
    ///     fn shake(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// // the motor holds the pendulum upright, against gravity and noise
    /// let mut pendulum = Integrator::new(Pendulum { g: 9.8, torque: 0.0, sigma: 0.1 }, Midpoint);
    /// let (mut path, mut dw) = (Wiener::new(1), [0.0]);
    /// let mut state = State::new([3.0], [0.0]);
    /// for step in 0..1000 {
    ///     let (angle, speed) = (state.q[0] - std::f64::consts::PI, state.p[0]);
    ///     pendulum.system_mut().torque = -40.0 * angle - 8.0 * speed;
    ///     path.increments(step, 0.01, &mut dw).expect("a step size that is finite");
    ///     pendulum.step(&mut state, 0.01, &dw)?;
    /// }
    /// assert!((state.q[0] - std::f64::consts::PI).abs() < 0.1);
    /// # Ok(())
    /// # }
    /// ```
    pub fn system_mut(&mut self) -> &mut S {
        self.cache = Default::default();
        &mut self.system
    }

    /// Returns the rule.
    pub fn rule(&self) -> &R {
        &self.rule
    }

    /// Returns the options of the Newton iteration.
    pub fn newton(&self) -> &Newton {
        &self.newton
    }
}

/// The functions of [`Method`](crate::Method), for programs that do not import the trait.
impl<S, R> Integrator<S, R>
where
    S: AnySystem,
    S::Kind: Steps<S::Target, R>,
    R: Rule<S::Target>,
{
    /// Makes one step of length `h` with the given Wiener increments, one for each process in
    /// source order.
    ///
    #[doc = include_str!("../example.md")]
    /// let mut state = start;
    /// pendulum.step(&mut state, 0.01, &[0.02])?;
    /// assert_eq!(state.t, 0.01);
    #[doc = include_str!("../example_end.md")]
    ///
    /// # Errors
    /// A [`StepError`] if an input is not finite, `h` is zero, or the step fails; `state` is then
    /// unchanged. A step of a system of any length may already have moved sites in place when a
    /// number is not finite. It moves them back: each momentum is then restored to rounding errors
    /// of the largest impulse that was added to it, and each place to the motion with that error.
    #[inline]
    pub fn step(
        &self,
        state: &mut StateOf<S>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError> {
        let prepared = OneStepMethod::prepare(self, h)?;
        self.step_prepared(&prepared, state, h, dw)
    }
}

impl<S, R, Q, const N: usize, const M: usize> Integrator<S, R>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
    Q: Coordinates<N>,
{
    /// Returns the tangent map of one step, `∂(q₁,p₁)/∂(q₀,p₀)` at fixed increments: a symplectic
    /// matrix, if no force acts.
    ///
    /// The implicit-function theorem gives it from the derivatives of the step's own equations,
    /// exact to rounding. Momenta of massless coordinates of a degenerate Lagrangian are functions
    /// of the configuration: their columns are zero, and the map preserves the two-form on
    /// consistent states.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Pendulum { g: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Pendulum {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.g * q.cos() }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let pendulum = Integrator::new(Pendulum { g: 9.8 }, Midpoint);
    /// let tangent = pendulum.tangent(&State::new([1.0], [0.0]), 0.1, &[])?;
    /// let determinant = tangent[0][0] * tangent[1][1] - tangent[0][1] * tangent[1][0];
    /// assert!((determinant - 1.0).abs() < 1e-15);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`step`](Self::step); [`StepError::Singular`] if the Jacobian of the equations is
    /// singular at their solution.
    pub fn tangent(
        &self,
        state: &State<Q>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<Tangent<N>, StepError> {
        self.step_with_derivatives(&mut { *state }, h, dw)
            .map(|(tangent, _)| tangent)
    }

    /// Returns the derivatives of the result of one step with respect to each parameter, at fixed
    /// start and increments.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Oscillator { k: f64 }
    ///
    /// #[variational(endpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * self.k * q * q }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let oscillator = Integrator::new(Oscillator { k: 4.0 }, Endpoint);
    /// // q₁ = q₀ + h p₀, p₁ = p₀ − h k q₁
    /// let sensitivity = oscillator.sensitivity(&State::new([1.0], [0.0]), 0.1, &[])?;
    /// assert_eq!(sensitivity.get("k").unwrap().p, [-0.1]);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`tangent`](Self::tangent).
    pub fn sensitivity(
        &self,
        state: &State<Q>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<Sensitivity<Q::Momentum>, StepError> {
        self.step_with_derivatives(&mut { *state }, h, dw)
            .map(|(_, sensitivity)| sensitivity)
    }

    /// Makes one step and returns its [`tangent`](Self::tangent) and
    /// [`sensitivity`](Self::sensitivity), from one solution of its equations.
    ///
    #[doc = include_str!("../example.md")]
    /// let mut state = start;
    /// let (tangent, sensitivity) = pendulum.step_with_derivatives(&mut state, 0.01, &[0.02])?;
    /// let (by_start, by_g) = (tangent[0][0], sensitivity.get("g").expect("a parameter").q[0]);
    #[doc = include_str!("../example_end.md")]
    ///
    /// # Errors
    /// As [`tangent`](Self::tangent); `state` is then unchanged.
    pub fn step_with_derivatives(
        &self,
        state: &mut State<Q>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(Tangent<N>, Sensitivity<Q::Momentum>), StepError> {
        tangent::derivatives(self, state, h, dw)
    }
}

impl<S, R, Q, const N: usize, const M: usize> Integrator<S, R>
where
    S: System<Dims = Dims<N, M, Reduced<Q>>>,
    R: Rule<S::Itself>,
    Q: Coordinates<N, Flat = WithRotations<Q, N>>,
{
    /// Makes one step of a reduced system and turns the attitude, which its states do not contain.
    ///
    /// The attitude has the bits of the full system: a step of the full system from this attitude
    /// ends in the same attitude.
    ///
    /// # Errors
    /// As [`step`](Self::step); `state` and `attitude` are then unchanged.
    pub fn step_with_attitude(
        &self,
        state: &mut State<Reduced<Q>>,
        attitude: &mut Q,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError> {
        let prepared = OneStepMethod::prepare(self, h)?;
        let mut flat: State<WithRotations<Q, N>> = State {
            t: state.t,
            q: attitude.coordinates(),
            p: Q::components(&state.p),
        };
        walk_from(self.walker(), &prepared, &mut flat, h, dw, Advance)?;
        *attitude = Q::from_coordinates(&flat.q);
        state.t = flat.t;
        state.p = Q::from_components(&flat.p);
        Ok(())
    }
}
