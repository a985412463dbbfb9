//! Integrals over time along each path: the exponent of the weight, and averages.
//!
//! Input: the states of the tiles after each step. Output: for each lane the integral by the trapezoidal rule from the start, or from the step at which averages
//! begin. Invariant: the integral of a path depends on its states only, not on its lane, block or thread.
//!
//! The trapezoidal rule keeps weak order 2 of a rule; a sum over the left ends of steps would make every rule of order 1.

use super::Ensemble;
use super::failure::Cause;
use super::observe::{Closure, Observable, not_finite};
use super::path_block::{PathBlock, lanes};
use crate::configuration::Coordinates;
use crate::lanes::{LANES, Lane};
use crate::method::Method;
use crate::observed::Observed;
use crate::state::State;
use crate::system::{Dimensions, Dims, System};

/// The name of the weight in messages.
const WEIGHT: &str = "weight";

/// What becomes of an observable at a recorded time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Its value.
    Value,
    /// Its value times the weight of the path.
    Weighted,
    /// Its average over time.
    Average,
}

/// A function that is integrated along each path.
pub(super) struct Integrand<'e, S: System> {
    function: &'e dyn Observable<S>,
    name: &'e str,
    /// The step at which the integral begins.
    from: u64,
}

/// An integral in the lanes of a tile.
#[derive(Clone, Copy)]
pub(super) struct Integral {
    sum: Lane,
    /// The integrand after the last step.
    last: Lane,
}

impl Integral {
    pub(super) const ZERO: Self = Self {
        sum: [0.0; LANES],
        last: [0.0; LANES],
    };
}

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
    #[must_use]
    pub fn terminal<F, O>(self, name: impl Into<String>, function: F) -> Self
    where
        F: Fn(&S, &State<Q>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.add(name.into(), Closure::new(function), Kind::Weighted)
    }
}

impl<I: Method> Ensemble<'_, I> {
    /// Returns what is integrated: the exponent of the weight if there is one, then the averaged observables.
    pub(super) fn integrands(&self) -> impl Iterator<Item = Integrand<'_, I::System>> {
        let weight = self.weight.iter().map(|function| Integrand {
            function: &**function,
            name: WEIGHT,
            from: 0,
        });
        let all = self.names.iter().zip(&self.observables).zip(&self.kinds);
        let averages = all.filter(|(_, kind)| **kind == Kind::Average);
        weight.chain(averages.map(|((name, function), _)| Integrand {
            function: &**function,
            name,
            from: self.settle,
        }))
    }

    /// Returns the number of the integral of an averaged observable.
    fn integral_of(&self, observable: usize) -> usize {
        let before = &self.kinds[..observable];
        let averages = before.iter().filter(|kind| **kind == Kind::Average);
        usize::from(self.weight.is_some()) + averages.count()
    }
}

impl<I, S, Q, const N: usize, const M: usize> PathBlock<'_, I, N, M>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Adds the last step to the integrals of all tiles. At the start the integrands are evaluated only.
    pub(super) fn integrate(&mut self) {
        let settings = self.settings;
        let ensemble = settings.ensemble;
        let system = settings.method.system();
        let tiles = self.tiles.len();
        let mut values = [0.0; LANES];
        for (number, integrand) in ensemble.integrands().enumerate() {
            for tile in 0..tiles {
                if self.tiles[tile].active == 0 {
                    continue;
                }
                (integrand.function).tile(system, self.tiles[tile].states(), &mut values);
                for lane in lanes(not_finite(&values) & self.tiles[tile].active) {
                    let name = integrand.name.to_owned();
                    let state = S::Dims::get(self.tiles[tile].states(), lane);
                    let cause = match integrand.function.value(system, &state) {
                        Ok(value) => Cause::NotFinite { name, value },
                        Err(error) => Cause::Observable { name, error },
                    };
                    self.fail(tile, lane, self.step, cause);
                }
                let integral = &mut self.integrals[number * tiles + tile];
                if self.step > integrand.from {
                    for lane in 0..LANES {
                        let both = integral.last[lane] + values[lane];
                        integral.sum[lane] += 0.5 * settings.h * both;
                    }
                }
                integral.last = values;
            }
        }
    }

    /// Replaces the values of an observable in the lanes of a tile by what they count for at a recorded time.
    pub(super) fn convert(&self, observable: usize, tile: usize, values: &mut Lane) {
        let ensemble = self.settings.ensemble;
        let tiles = self.tiles.len();
        match ensemble.kinds[observable] {
            Kind::Value => {}
            Kind::Weighted if ensemble.weight.is_none() => {}
            Kind::Weighted => {
                for (value, exponent) in values.iter_mut().zip(self.integrals[tile].sum) {
                    *value *= (-exponent).exp();
                }
            }
            Kind::Average => {
                let integral = &self.integrals[ensemble.integral_of(observable) * tiles + tile];
                let steps = self.step.saturating_sub(ensemble.settle);
                *values = if steps == 0 {
                    integral.last
                } else {
                    let time = steps as f64 * self.settings.h;
                    integral.sum.map(|sum| sum / time)
                };
            }
        }
    }
}
