//! Steps of systems with inputs.

use super::Integrator;
use crate::error::StepError;
use crate::method::OneStepMethod;
use crate::rule::Rule;
use crate::system::{StateOf, WithInputs};

/// An integrator of a system while its inputs are held.
pub type Holding<'a, S, R> = Integrator<<S as WithInputs>::Held<'a>, R>;

impl<S: WithInputs, R: Copy> Integrator<S, R> {
    /// Returns the integrator of the system while its inputs have these values: an integrator as
    /// any other, whose parameters include the inputs, `u[0]`, `u[1]`, ….
    ///
    /// Its `system()` has what depends on `u`: the velocity of a momentum, the energy. Its
    /// `step_with_derivatives` gives the derivatives of a step by the start and by the inputs.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A cart that is pushed.
    /// struct Cart { m: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Cart {
    ///     fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 { 0.5 * self.m * v * v + u * q }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let cart = Integrator::new(Cart { m: 2.0 }, Midpoint);
    /// let mut state = State::new([0.0], [0.0]);
    /// let pushed = cart.holding(&3.0);
    /// let (_, by_parameters) = pushed.step_with_derivatives(&mut state, 0.1, &[])?;
    /// // p₁ = p₀ + h u
    /// assert!((by_parameters.get("u[0]").unwrap().p[0] - 0.1).abs() < 1e-15);
    /// assert!((pushed.system().velocity(&state)?[0] - 0.15).abs() < 1e-15);
    /// # Ok(())
    /// # }
    /// ```
    pub fn holding<'a>(&'a self, u: &S::Input) -> Holding<'a, S, R>
    where
        R: Rule<S::Held<'a>>,
    {
        Integrator::new(self.system.held(u), self.rule).with_newton(self.newton)
    }

    /// Makes one step of length `h` with the given Wiener increments, while the inputs have the
    /// values `u` in L, forces and noises at every node, stage and substep.
    ///
    /// The momentum is continuous where an input jumps from one step to the next, the velocity is
    /// not if ∂L/∂v reads the input.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A particle that a hand pushes, in two directions.
    /// struct Particle;
    ///
    /// #[variational(stormer_verlet)]
    /// impl Particle {
    ///     fn lagrangian(&self, _q: [f64; 2], v: [f64; 2]) -> f64 { 0.5 * (v[0] * v[0] + v[1] * v[1]) }
    ///     #[force]
    ///     fn hand(&self, _q: [f64; 2], _v: [f64; 2], u: [f64; 2]) -> [f64; 2] { u }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let particle = Integrator::new(Particle, StormerVerlet);
    /// let mut state = State::new([0.0, 0.0], [0.0, 0.0]);
    /// particle.step_with(&mut state, 0.1, &[], &[1.0, -2.0])?;
    /// assert_eq!(state.p, [0.1, -0.2]);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// A [`StepError`] if an input is not finite, or the step fails; `state` is then unchanged.
    pub fn step_with<'a>(
        &'a self,
        state: &mut StateOf<S>,
        h: f64,
        dw: &<R as Rule<S::Held<'a>>>::Increments,
        u: &S::Input,
    ) -> Result<(), StepError>
    where
        R: Rule<S::Held<'a>>,
        Holding<'a, S, R>:
            OneStepMethod<System = S::Held<'a>, Increments = <R as Rule<S::Held<'a>>>::Increments>,
    {
        check_inputs::<S>(u, state.t)?;
        let held = self.holding(u);
        held.step_prepared(&held.prepare(h)?, state, h, dw)
    }
}

/// Reports an input that is not finite.
pub(crate) fn check_inputs<S: WithInputs>(u: &S::Input, t: f64) -> Result<(), StepError> {
    check_numbers(S::numbers(u).as_ref(), t)
}

/// Reports a number in inputs that is not finite.
pub(super) fn check_numbers(numbers: &[f64], t: f64) -> Result<(), StepError> {
    match numbers.iter().enumerate().find(|(_, x)| !x.is_finite()) {
        None => Ok(()),
        Some((k, &value)) => Err(StepError::NonFiniteInput {
            what: format!("u[{k}]"),
            value,
            t,
        }),
    }
}
