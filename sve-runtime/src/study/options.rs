//! The settings of a study, each a function that returns it.
//!
//! Examples in the documentation begin with the hidden lines of `example.md`: a closure `study`
//! that makes a complete study of an oscillator with noise.

use std::borrow::Cow;

use super::reference::Reference;
use super::{Candidate, Observable, Study};
use crate::ensemble::Observed;
use crate::method::OneStepMethod;
use crate::noise::Recorded;
use crate::system::{Increments, StateOf, System};

impl<'a, S: System> Study<'a, S> {
    /// Sets the start of all paths.
    ///
    #[doc = include_str!("example.md")]
    /// let report = study().start(State::new([2.0], [0.0])).run()?;
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn start(mut self, state: StateOf<S>) -> Self {
        self.start = Some(state);
        self
    }

    /// Sets the length of the solution, in the unit of time.
    ///
    #[doc = include_str!("example.md")]
    /// assert_eq!(study().horizon(2.0).run()?.row("endpoint", 8).expect("it is there").h, 0.25);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn horizon(mut self, horizon: f64) -> Self {
        self.horizon = Some(horizon);
        self
    }

    /// Sets the numbers of steps to the horizon. With noise each has to divide the largest, so that
    /// all step sizes share their paths.
    ///
    #[doc = include_str!("example.md")]
    /// let report = study().step_counts([4, 8, 16, 32]).run()?;
    /// assert_eq!(report.rows().len(), 4);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn step_counts(mut self, numbers: impl IntoIterator<Item = usize>) -> Self {
        self.steps = numbers.into_iter().collect();
        self
    }

    /// Sets the number of Brownian paths.
    ///
    #[doc = include_str!("example.md")]
    /// assert_eq!(study().paths(20).run()?.paths(), 20);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn paths(mut self, paths: u64) -> Self {
        self.paths = paths;
        self
    }

    /// Sets the seed of the paths: path `k` has the increments of
    /// [`Wiener::new(seed).path(k)`](crate::noise::Wiener) over the finest steps. A study takes no
    /// other noise, since it makes steps of several sizes along each path; ensembles with another
    /// [`noise`](crate::ensemble::Ensemble::noise) compare means.
    ///
    #[doc = include_str!("example.md")]
    /// let error = |seed| study().seed(seed).run().map(|report| report.rows()[0].error);
    /// assert_ne!(error(1)?, error(2)?);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Adds a method: an [`Integrator`](crate::Integrator), a [`baseline`](crate::baseline), or any
    /// other [`OneStepMethod`]. Rules with [stage noise](crate::StageNoise) have the same paths as
    /// all others.
    ///
    #[doc = include_str!("example.md")]
    /// let uncorrected = EulerMaruyama::new(&system).uncorrected();
    /// let report = study().method("uncorrected", &uncorrected).run()?;
    /// assert_eq!(report.rows().len(), 6);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn method<I>(mut self, name: impl Into<Cow<'a, str>>, method: &'a I) -> Self
    where
        I: OneStepMethod<System = S, Increments: Increments> + Sync,
    {
        self.methods.push(Candidate {
            name: name.into(),
            method,
            steps: None,
        });
        self
    }

    /// Adds a method with its own numbers of steps to the horizon, in place of the
    /// [`step_counts`](Self::step_counts) of the study: a method of high order needs fewer steps.
    ///
    /// ```
    /// use sve_runtime::baseline::RungeKutta4;
    /// use sve_runtime::prelude::*;
    /// use sve_runtime::study::{Study, StudyError};
    ///
    /// #[derive(Clone, Copy)]
    /// struct Oscillator;
    ///
    /// #[variational(midpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
    /// }
    ///
    /// # fn main() -> Result<(), StudyError> {
    /// let midpoint = Integrator::new(Oscillator, Midpoint);
    /// let runge_kutta = RungeKutta4::new(Oscillator);
    /// let report = Study::new("oscillator")
    ///     .start(State::new([1.0], [0.0]))
    ///     .horizon(1.0)
    ///     .step_counts([100, 200, 400])
    ///     .method("midpoint", &midpoint)
    ///     .method_with_step_counts("Runge–Kutta 4", &runge_kutta, [7, 15])
    ///     .exact(|_| State::at(1.0, [1.0_f64.cos()], [-1.0_f64.sin()]))
    ///     .repeats(0) // no times
    ///     .run()?;
    /// assert_eq!(report.rows().len(), 5);
    /// assert!(report.row("Runge–Kutta 4", 15).is_some());
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn method_with_step_counts<I>(
        mut self,
        name: impl Into<Cow<'a, str>>,
        method: &'a I,
        numbers: impl IntoIterator<Item = usize>,
    ) -> Self
    where
        I: OneStepMethod<System = S, Increments: Increments> + Sync,
    {
        self.methods.push(Candidate {
            name: name.into(),
            method,
            steps: Some(numbers.into_iter().collect()),
        });
        self
    }

    /// Compares with the exact state at the horizon, a function of the increments over the finest
    /// steps.
    ///
    #[doc = include_str!("example.md")]
    /// // additive noise: the exact mean path alone is no solution, so leave the noise out
    /// let quiet = Oscillator { sigma: 0.0 };
    /// let endpoint = Integrator::new(quiet, Endpoint);
    /// let report = Study::new("without noise")
    ///     .start(State::new([1.0], [0.0])).horizon(1.0).step_counts([8, 16, 32])
    ///     .method("endpoint", &endpoint)
    ///     .exact(|_| State::at(1.0, [1.0_f64.cos()], [-1.0_f64.sin()]))
    ///     .repeats(0)
    ///     .run()?;
    /// assert!(report.rows()[0].error.expect("no failure").value < 0.1);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn exact(mut self, solution: impl Fn(&Recorded) -> StateOf<S> + Sync + 'a) -> Self {
        self.reference = Some(Reference::Exact(Box::new(solution)));
        self
    }

    /// Compares with the exact state at the horizon, drawn jointly with the increments over the
    /// finest steps.
    ///
    /// For solutions that are not functions of the increments alone, such as integrals of
    /// `f(s) dW(s)`. The closure gets the number of the path and of the steps, and has to return a
    /// path of that many steps up to the horizon; the seed is its own. If a method has [stage
    /// noise](crate::StageNoise), the path has its stages ([`Recorded::with_stages`]), or more.
    ///
    #[doc = include_str!("example.md")]
    /// // the increment of a free particle, and the integral that moves it, drawn together
    /// use sve_runtime::noise::Wiener;
    /// let report = Study::new("free particle")
    ///     .start(State::new([0.0], [0.0])).horizon(1.0).step_counts([8, 16, 32]).paths(20)
    ///     .method("endpoint", &Integrator::new(Free, Endpoint))
    ///     .exact_paths(|path, steps| {
    ///         let h = 1.0 / steps as f64;
    ///         let (noise, other) = (Wiener::new(1).path(path), Wiener::new(2).path(path));
    ///         let (mut q, mut p) = (0.0, 0.0);
    ///         let increments: Vec<[f64; 1]> = (0..steps as u64)
    ///             .map(|step| {
    ///                 let dw = noise.increment(step, 0, h);
    ///                 // ∫ W ds over the step, given ΔW
    ///                 let area = other.increment(step, 0, h) / 12.0_f64.sqrt();
    ///                 q += h * p + 0.5 * h * dw + h * area;
    ///                 p += dw;
    ///                 [dw]
    ///             })
    ///             .collect();
    ///         (Recorded::new(h, increments).expect("finite numbers"), State::at(1.0, [q], [p]))
    ///     })
    ///     .repeats(0)
    ///     .run()?;
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn exact_paths(
        mut self,
        draw: impl Fn(u64, usize) -> (Recorded, StateOf<S>) + Sync + 'a,
    ) -> Self {
        self.reference = Some(Reference::Drawn(Box::new(draw)));
        self
    }

    /// Compares with a method whose steps are `factor` times shorter than the finest ones, on the
    /// same paths.
    ///
    /// With strong order 1 and a factor of 16, the error of the reference is 1/16 of the smallest
    /// measured error. A factor of 1 is for another, more accurate method: a reference that equals
    /// one of the methods with the same steps is refused.
    ///
    #[doc = include_str!("example.md")]
    /// let accurate = Heun::new(&system);
    /// let report = study().fine(&accurate, 64).run()?;
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn fine<I>(mut self, method: &'a I, factor: usize) -> Self
    where
        I: OneStepMethod<System = S, Increments: Increments> + Sync,
    {
        self.reference = Some(Reference::Fine(method, factor));
        self
    }

    /// Sets the distance that measures errors. The default is the Euclidean distance of the
    /// `(q, p)`.
    ///
    #[doc = include_str!("example.md")]
    /// let report = study().distance(|a, b| (a.q[0] - b.q[0]).abs()).run()?; // positions alone
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn distance(
        mut self,
        distance: impl Fn(&StateOf<S>, &StateOf<S>) -> f64 + Sync + 'a,
    ) -> Self {
        self.distance = Box::new(distance);
        self
    }

    /// Measures the weak error of a function of the system and a state, which returns `f64` or
    /// `Result<f64, StepError>`: the difference of its means at the horizon, from common random
    /// numbers, so that its standard error is the error of the mean of the differences.
    ///
    #[doc = include_str!("example.md")]
    /// let report = study().observe("q²", |_, state| state.q[0].powi(2)).run()?;
    /// assert_eq!(report.rows()[0].weak_errors.len(), 1);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn observe<F, O>(mut self, name: impl Into<Cow<'a, str>>, observable: F) -> Self
    where
        F: Fn(&S, &StateOf<S>) -> O + Sync + 'a,
        O: Observed,
    {
        self.observables.push(Observable {
            name: name.into(),
            value: Box::new(move |system, state| observable(system, state).observed()),
            mean: None,
        });
        self
    }

    /// As [`observe`](Self::observe), against the exact mean, for references that are not exact.
    /// The standard error belongs to the mean over the paths.
    ///
    #[doc = include_str!("example.md")]
    /// let report = study().observe_mean("q", |_, state| state.q[0], 1.0_f64.cos()).run()?;
    /// assert_eq!(report.observables(), ["q"]);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn observe_mean<F, O>(self, name: impl Into<Cow<'a, str>>, observable: F, mean: f64) -> Self
    where
        F: Fn(&S, &StateOf<S>) -> O + Sync + 'a,
        O: Observed,
    {
        let mut study = self.observe(name, observable);
        if let Some(last) = study.observables.last_mut() {
            last.mean = Some(mean);
        }
        study
    }

    /// Measures the change of an invariant of the exact solution, such as the energy where there is
    /// neither noise nor force, or a momentum map.
    ///
    #[doc = include_str!("example.md")]
    /// let report = study().invariant(|system, state| system.hamiltonian(state)).run()?;
    /// let invariant = report.rows()[0].invariant.expect("measured");
    /// assert!(invariant.largest > 0.0); // noise changes the energy
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn invariant<F, O>(mut self, invariant: F) -> Self
    where
        F: Fn(&S, &StateOf<S>) -> O + Sync + 'a,
        O: Observed,
    {
        self.invariant = Some(Box::new(move |system, state| {
            invariant(system, state).observed()
        }));
        self
    }

    /// Sets how often each time is measured; 0 for no times. The methods alternate, so that a
    /// disturbance of the machine affects all of them.
    ///
    #[doc = include_str!("example.md")]
    /// let report = study().repeats(3).run()?;
    /// assert!(report.rows()[0].timing.expect("measured").ns_per_step > 0.0);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn repeats(mut self, repeats: u32) -> Self {
        self.repeats = repeats;
        self
    }
}
