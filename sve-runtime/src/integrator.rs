//! A system with a rule: the step, and what it is called with.

use crate::newton::Newton;
use crate::plan::Plan;
use crate::system::{DerivedFor, Variational};

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
