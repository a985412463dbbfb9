//! A system with a rule: the step, and what it is called with.

use crate::configuration::Coordinates;
use crate::error::StepError;
use crate::method::Method;
use crate::newton::Newton;
use crate::noise::Noise;
use crate::plan::Plan;
use crate::snapshot::Snapshot;
use crate::state::State;
use crate::system::{DerivedFor, Dims, System, Variational};
use crate::tangent::{self, Sensitivity, Tangent};
use crate::trajectory::Trajectory;

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
/// It owns the system, or borrows it: `Integrator::new(&pendulum, Midpoint)` leaves it to other methods too.
#[derive(Clone, Copy, Debug)]
pub struct Integrator<S, R> {
    system: S,
    rule: R,
    newton: Newton,
}

impl<S, R> Integrator<S, R> {
    /// The integrator of `system` by `rule`, which has to be one that the attribute lists.
    pub fn new(system: S, rule: R) -> Self
    where
        R: DerivedFor<S>,
    {
        Self {
            system,
            rule,
            newton: Newton::default(),
        }
    }
}

impl<S: Variational<R>, R> Integrator<S, R> {
    /// Replaces the options of the Newton iteration.
    #[must_use]
    pub fn with_newton(mut self, newton: Newton) -> Self {
        self.newton = newton;
        self
    }

    /// The system.
    pub fn system(&self) -> &S {
        &self.system
    }

    /// The rule.
    pub fn rule(&self) -> &R {
        &self.rule
    }

    /// The options of the Newton iteration.
    pub fn newton(&self) -> &Newton {
        &self.newton
    }

    /// What the step became.
    pub fn plan(&self) -> &'static Plan {
        S::PLAN
    }
}

/// What [`Method`] offers, without having to import it.
impl<S, R, Q, const N: usize, const M: usize> Integrator<S, R>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// One step of length `h` with the given Wiener increments, one a process in source order.
    ///
    /// # Errors
    /// A [`StepError`] when an input is not finite, `h ≤ 0`, or the step fails; `state` is then unchanged.
    #[inline]
    pub fn step(&self, state: &mut State<Q>, h: f64, dw: &[f64; M]) -> Result<(), StepError> {
        Method::step(self, state, h, dw)
    }

    /// The tangent map of one step, `∂(q₁,p₁)/∂(q₀,p₀)` at fixed increments: a symplectic matrix, where no force acts.
    ///
    /// From the derivatives of the step's own equations by the implicit-function theorem, so it is exact to rounding.
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
    /// As [`step`](Self::step); [`StepError::Singular`] where the equations have no regular Jacobian at their solution.
    pub fn tangent(
        &self,
        state: &State<Q>,
        h: f64,
        dw: &[f64; M],
    ) -> Result<Tangent<N>, StepError> {
        self.step_with_derivatives(&mut { *state }, h, dw)
            .map(|(tangent, _)| tangent)
    }

    /// The derivatives of the result of one step in each parameter, at fixed start and increments.
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
        dw: &[f64; M],
    ) -> Result<Sensitivity<N>, StepError> {
        self.step_with_derivatives(&mut { *state }, h, dw)
            .map(|(_, sensitivity)| sensitivity)
    }

    /// One step with its [`tangent`](Self::tangent) and [`sensitivity`](Self::sensitivity), from one solution of its equations.
    ///
    /// # Errors
    /// As [`tangent`](Self::tangent); `state` is then unchanged.
    pub fn step_with_derivatives(
        &self,
        state: &mut State<Q>,
        h: f64,
        dw: &[f64; M],
    ) -> Result<(Tangent<N>, Sensitivity<N>), StepError> {
        tangent::derivatives(self, state, h, dw)
    }

    /// The states after each step of length `h` from `state`; see [`Method::trajectory`].
    pub fn trajectory<W: Noise>(
        &self,
        state: State<Q>,
        h: f64,
        noise: W,
    ) -> Trajectory<'_, Self, W> {
        Method::trajectory(self, state, h, noise)
    }

    /// Continues a trajectory from a snapshot; see [`Method::resume`].
    ///
    /// # Errors
    /// As there.
    pub fn resume<W: Noise>(
        &self,
        snapshot: Snapshot<State<Q>>,
        noise: W,
    ) -> Result<Trajectory<'_, Self, W>, StepError> {
        Method::resume(self, snapshot, noise)
    }
}
