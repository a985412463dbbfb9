//! A system with a rule: the step, and what it is called with.

use crate::error::StepError;
use crate::method::Method;
use crate::newton::Newton;
use crate::noise::Noise;
use crate::plan::Plan;
use crate::state::State;
use crate::system::{DerivedFor, Dims, System, Variational};
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
impl<S, R, const N: usize, const M: usize> Integrator<S, R>
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    /// One step of length `h` with the given Wiener increments, one a process in source order.
    ///
    /// # Errors
    /// A [`StepError`] when an input is not finite, `h ≤ 0`, or the step fails; `state` is then unchanged.
    #[inline]
    pub fn step(&self, state: &mut State<N>, h: f64, dw: &[f64; M]) -> Result<(), StepError> {
        Method::step(self, state, h, dw)
    }

    /// The states after each step of length `h` from `state`; see [`Method::trajectory`].
    pub fn trajectory<W: Noise>(
        &self,
        state: State<N>,
        h: f64,
        noise: W,
    ) -> Trajectory<'_, Self, W> {
        Method::trajectory(self, state, h, noise)
    }
}
