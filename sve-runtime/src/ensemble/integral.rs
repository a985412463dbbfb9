//! Integrals over time along each path: averages, and the weight of Feynman and Kac.
//!
//! Input: functions of the system and a state. Output: observables of their integrals so far, and
//! of other functions times the weight.
//!
//! The trapezoidal rule keeps weak order 2 of a rule; a sum over the left ends of steps would make
//! every rule of order 1.

use super::Ensemble;
use super::memory::{Accumulate, Accumulated};
use super::observe::Closure;
use super::observer::{Kind, LastStep, Plain};
use crate::ensemble::PathMethod;
use crate::error::observed::Observed;
use crate::system::StateOf;

impl<'a, I: PathMethod, K> Ensemble<'a, I, K> {
    /// Takes statistics of the integral ∫f dt of a function along each path, from the start to the
    /// recorded time, by the trapezoidal rule over all steps.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Oscillator;
    ///
    /// #[variational(midpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let oscillator = Integrator::new(Oscillator, Midpoint);
    /// let summary = Ensemble::new(&oscillator)
    ///     .paths(10).steps(0.01, 1000)
    ///     .start(State::new([1.0], [0.0]))
    ///     .integral("area", |_, state| state.q[0])
    ///     .maximum("speed", |_, state| state.p[0].abs())
    ///     .crossings("turns", |_, state| state.p[0])
    ///     .run()?;
    /// // q = cos t, p = −sin t, until t = 10
    /// assert!((summary["area"].mean()[1] - 10_f64.sin()).abs() < 1e-3);
    /// assert!((summary["speed"].mean()[1] - 1.0).abs() < 1e-4);
    /// assert_eq!(summary["turns"].mean()[1], 3.0);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn integral<F, O>(self, name: impl Into<String>, function: F) -> Self
    where
        F: Fn(&I::System, &StateOf<I::System>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.add(name, Accumulated::new(function, Integral))
    }

    /// Takes statistics of the average of a function over time, along each path: from the start, or
    /// from the step of [`settle`](Self::settle), to the recorded time, by the trapezoidal rule
    /// over all steps.
    ///
    /// The averages of different paths are independent, so the [standard
    /// error](super::Statistics::standard_error) between them is right for every length of a path's
    /// memory. At the time from which it is taken, the average is the value itself. For one long
    /// path see [`Blocking`](crate::Blocking).
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
        F: Fn(&I::System, &StateOf<I::System>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.add(name, Accumulated::new(function, Average { from: 0 }))
    }

    /// Begins the [averages](Self::average) after so many steps, when the paths have forgotten
    /// their start.
    ///
    #[doc = include_str!("example.md")]
    /// // the average from t = 0.5 on; before there is none
    /// let ensemble = ensemble().every(5).settle(5).average("mean of q", |_, state| state.q[0]);
    /// let summary = ensemble.run()?;
    /// assert_eq!(summary["mean of q"].mean()[1], summary["q"].mean()[1]);
    /// assert_ne!(summary["mean of q"].mean()[2], summary["q"].mean()[2]);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn settle(mut self, steps: u64) -> Self {
        self.observed.settle = steps;
        self
    }

    /// Gives each path the weight exp(−∫V dt) of a function V of the system and the state,
    /// integrated from the start by the trapezoidal rule over all steps. The weight multiplies the
    /// [`terminal`](Self::terminal) functions. The V that was given last counts.
    ///
    /// By the formula of Feynman and Kac the mean of `f(X_t)` exp(−∫V dt) over paths from x is the
    /// solution u(t, x) of ∂u/∂t = 𝓛u − Vu with u(0, x) = f(x), where 𝓛 is the generator of the
    /// motion. u has the weak order of the rule: 2 for `midpoint` and `stormer_verlet` with
    /// additive noise and constant masses, and for the rules with the option
    /// [`Weak2`](crate::Weak2); 1 for `initial_point`, `endpoint` and Euler–Maruyama.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Oscillator { sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// // ∂u/∂t = p ∂u/∂q − q ∂u/∂p + ½σ² ∂²u/∂p² − ½κq²u,  u(0) = 1
    /// let oscillator = Integrator::new(Oscillator { sigma: 0.8 }, Midpoint);
    /// let kappa = 1.3;
    /// let points = [State::new([0.7], [-0.4]), State::new([0.0], [0.0])];
    /// for (point, number) in points.into_iter().zip(0..) {
    ///     let summary = Ensemble::new(&oscillator)
    ///         .paths(20_000)
    ///         .noise(Wiener::new(1).path(20_000 * number)) // paths of its own for each point
    ///         .steps(1.0 / 16.0, 32)
    ///         .start(point)
    ///         .weight(|_, state| 0.5 * kappa * state.q[0].powi(2))
    ///         .terminal("u", |_, _| 1.0)
    ///         .run()?;
    ///     let (u, error) = (summary["u"].mean()[1], summary["u"].standard_error()[1]);
    ///     if number == 0 {
    ///         assert!(error < 0.002 && (u - 0.627173387859).abs() < 4.0 * error + 1e-4);
    ///     }
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// Without the line of the noise all points have the same paths. Means at points that lie close
    /// together then have nearly the same sampling error, so that their differences have a small
    /// error, as a gradient needs; a mean over the points has a larger error.
    ///
    #[doc = include_str!("example.md")]
    /// // a constant V = 2 discounts: u(t, x) = exp(−2t) for f = 1
    /// let summary = ensemble().weight(|_, _| 2.0).terminal("u", |_, _| 1.0).run()?;
    /// assert!((summary["u"].mean()[1] - (-2.0_f64).exp()).abs() < 1e-12);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn weight<F, O>(mut self, potential: F) -> Self
    where
        F: Fn(&I::System, &StateOf<I::System>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.observed.weight = Some(Box::new(Accumulated::new(potential, Integral)));
        self
    }

    /// Takes statistics of a function times the [`weight`](Self::weight) of the path. Each recorded
    /// time is a time t of the solution u(t, x).
    ///
    #[doc = include_str!("example.md")]
    /// // without a weight it is an observable
    /// let summary = ensemble().terminal("u", |_, state| state.q[0]).run()?;
    /// assert_eq!(summary["u"].mean(), summary["q"].mean());
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn terminal<F, O>(self, name: impl Into<String>, function: F) -> Self
    where
        F: Fn(&I::System, &StateOf<I::System>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        let function = Closure::new(function);
        self.add(
            name,
            Plain {
                function,
                is_weighted: true,
            },
        )
    }
}

/// An integral over time by the trapezoidal rule.
#[derive(Clone, Copy)]
struct Integral;

impl Accumulate for Integral {
    const KIND: Kind = Kind::Integral;

    fn after(self, sum: f64, [last, now]: [f64; 2], step: &LastStep, lane: usize) -> f64 {
        sum + 0.5 * step.lengths[lane] * (last + now)
    }
}

/// An average over time.
#[derive(Clone, Copy)]
struct Average {
    /// The step at which it begins.
    from: u64,
}

impl Accumulate for Average {
    const KIND: Kind = Kind::Average;

    fn settled(self, from: u64) -> Self {
        Self { from }
    }

    fn after(self, sum: f64, ends: [f64; 2], step: &LastStep, lane: usize) -> f64 {
        if step.number <= self.from {
            return sum;
        }
        Integral.after(sum, ends, step, lane)
    }

    fn read(self, sum: f64, now: f64, step: &LastStep, lane: usize) -> f64 {
        if step.number <= self.from {
            return now;
        }
        sum / step.time_since(self.from, lane)
    }
}
