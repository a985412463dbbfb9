//! Integrals over time along each path: averages, and the weight of Feynman and Kac.
//!
//! Input: functions of the system and a state. Output: the settings of an ensemble; [`memory`](super::memory) integrates.
//!
//! The trapezoidal rule keeps weak order 2 of a rule; a sum over the left ends of steps would make every rule of order 1.

use super::Ensemble;
use super::memory::Kind;
use super::observe::Closure;
use crate::error::Observed;
use crate::phase::configuration::Coordinates;
use crate::phase::state::State;
use crate::system::{Dims, System};
use crate::trajectory::Method;

impl<'a, I, S, Q, const N: usize, const M: usize> Ensemble<'a, I>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Takes statistics of the average of a function over time, along each path: from the start, or from the step of [`settle`](Self::settle), to the recorded time, by the
    /// trapezoidal rule over all steps.
    ///
    /// The averages of different paths are independent, so the [standard error](super::Statistics::standard_error) between them is right however long a path remembers its past. Where no time has
    /// passed yet the average is the value itself. For one long path see [`Blocking`](crate::Blocking).
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// An oscillator in a bath of temperature kT = σ²/2ν.
    /// struct Langevin { nu: f64, sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Langevin {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
    ///     #[force]
    ///     fn friction(&self, _q: f64, v: f64) -> f64 { -self.nu * v }
    ///     #[gamma]
    ///     fn kicks(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let langevin = Integrator::new(Langevin { nu: 1.0, sigma: 2.0 }, Midpoint);
    /// let summary = Ensemble::new(&langevin)
    ///     .paths(200).seed(1)
    ///     .steps(0.2, 1100).settle(100)
    ///     .start(State::new([0.0], [0.0]))
    ///     .average("kT", |system, state| system.temperature(state))
    ///     .run()?;
    /// let (temperature, error) = (summary["kT"].mean()[1], summary["kT"].standard_error()[1]);
    /// assert!(error < 0.03 && (temperature - 2.0).abs() < 4.0 * error);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn average<F, O>(self, name: impl Into<String>, function: F) -> Self
    where
        F: Fn(&S, &State<Q>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.add(name.into(), Closure::new(function), Kind::Average)
    }

    /// Begins the [averages](Self::average) after so many steps, when the paths have forgotten their start.
    ///
    #[doc = include_str!("example.md")]
    /// // the average from t = 0.5 on; before there is none
    /// let summary = ensemble().record_every(5).settle(5).average("mean of q", |_, state| state.q[0]).run()?;
    /// assert_eq!(summary["mean of q"].mean()[1], summary["q"].mean()[1]);
    /// assert_ne!(summary["mean of q"].mean()[2], summary["q"].mean()[2]);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn settle(mut self, steps: u64) -> Self {
        self.settle = steps;
        self
    }

    /// Gives each path the weight exp(−∫V dt) of a function V of the system and the state, integrated from the start by the trapezoidal rule over all steps.
    /// The weight multiplies the [`terminal`](Self::terminal) functions. The V that was given last counts.
    ///
    /// By the formula of Feynman and Kac the mean of `f(X_t)` exp(−∫V dt) over paths from x is the solution u(t, x) of ∂u/∂t = 𝓛u − Vu with u(0, x) = f(x), where 𝓛 is the generator
    /// of the motion. The weak order of a rule is that of u: 2 for `midpoint` and `stormer_verlet` with additive noise and constant masses, and for the rules with the
    /// option [`Weak2`](crate::Weak2); 1 for `initial_point`, `endpoint` and Euler–Maruyama. [`run_from`](Self::run_from) has an example.
    ///
    #[doc = include_str!("example.md")]
    /// // a constant V = 2 discounts: u(t, x) = exp(−2t) for f = 1
    /// let summary = ensemble().weight(|_, _| 2.0).terminal("u", |_, _| 1.0).run()?;
    /// assert!((summary["u"].mean()[1] - (-2.0_f64).exp()).abs() < 1e-12);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn weight<F, O>(mut self, potential: F) -> Self
    where
        F: Fn(&S, &State<Q>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.weight = Some(Box::new(Closure::new(potential)));
        self
    }

    /// Takes statistics of a function times the [`weight`](Self::weight) of the path. Each recorded time is a time t of the solution u(t, x).
    ///
    #[doc = include_str!("example.md")]
    /// // without a weight it is an observable
    /// let summary = ensemble().terminal("u", |_, state| state.q[0]).run()?;
    /// assert_eq!(summary["u"].mean(), summary["q"].mean());
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn terminal<F, O>(self, name: impl Into<String>, function: F) -> Self
    where
        F: Fn(&S, &State<Q>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.add(name.into(), Closure::new(function), Kind::Weighted)
    }
}
