//! Inputs of the paths of an ensemble.
//!
//! Input: a function of the number of a path, the number of a step and the state at its start.
//! Output: the inputs of the step, in each lane. Invariant: the function is called for existing
//! paths only.

use core::hash::Hasher;
use core::marker::PhantomData;

use super::settings::{Leg, missing};
use super::{Ensemble, EnsembleError, Summary};
use crate::ensemble::PathMethod;
use crate::integrator::Integrator;
use crate::integrator::driven::{Driven, Source};
use crate::lanes::{LANES, Mask};
use crate::method::Shared;
use crate::rule::Rule;
use crate::system::{StateOf, System, WithInputs};
use crate::trajectory::StepsWithoutInputs;

/// A source of the paths of an ensemble: a method, or an integrator of a system with inputs.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no paths for an ensemble",
    note = "an ensemble runs a reference to a method for a system of fixed sizes: an `Integrator` or a baseline",
    note = "systems whose `q` is a slice, and systems with a time scale, have single steps and trajectories: let `rayon` or another library run trajectories side by side"
)]
#[doc(hidden)]
pub trait Runs<'a, K> {
    type Method: PathMethod;
    /// Returns the method.
    fn shared(self) -> Shared<'a, Self::Method>;
}

/// Marks methods, which need no inputs.
#[doc(hidden)]
#[derive(Debug)]
pub struct Complete;

/// Marks integrators of systems with inputs.
#[doc(hidden)]
#[derive(Debug)]
pub struct NeedsInputs;

impl<'a, I: PathMethod> Runs<'a, Complete> for &'a I {
    type Method = I;

    fn shared(self) -> Shared<'a, I> {
        self.into()
    }
}

#[diagnostic::do_not_recommend]
impl<'a, S, R> Runs<'a, NeedsInputs> for &'a Integrator<S, R>
where
    S: WithInputs,
    R: Copy + Rule<S::Held<'a>>,
    Driven<'a, S, R, PathInputs<'a, S>>: PathMethod,
{
    type Method = Driven<'a, S, R, PathInputs<'a, S>>;

    fn shared(self) -> Shared<'a, Self::Method> {
        Shared::Owned(Box::new(Driven::new(self, PathInputs(None))))
    }
}

/// The inputs of paths, with their name.
#[doc(hidden)]
pub struct PathInputs<'a, S: WithInputs>(Option<(String, Box<dyn Source<S> + Send + Sync + 'a>)>);

impl<S: WithInputs> Source<S> for PathInputs<'_, S> {
    fn numbers(&self, path: u64, step: u64, state: &StateOf<S>) -> S::Numbers {
        let source = self.0.as_ref();
        source.map_or(S::OPEN, |(_, source)| source.numbers(path, step, state))
    }

    fn lanes(
        &self,
        paths: (&[u64; LANES], Mask),
        step: u64,
        states: &S::Lanes,
        inputs: &mut [S::Numbers; LANES],
    ) -> Mask {
        let source = self.0.as_ref();
        source.map_or(paths.1, |(_, source)| {
            source.lanes(paths, step, states, inputs)
        })
    }

    fn identify(&self, to: &mut dyn Hasher) {
        if let Some((name, _)) = &self.0 {
            to.write(name.as_bytes());
        }
    }
}

/// A function of path, step and state.
struct OfPath<F>(F);

impl<S, F> Source<S> for OfPath<F>
where
    S: WithInputs,
    F: Fn(u64, u64, &StateOf<S>) -> S::Input,
{
    #[inline(always)]
    fn numbers(&self, path: u64, step: u64, state: &StateOf<S>) -> S::Numbers {
        S::numbers(&(self.0)(path, step, state))
    }
}

impl<'a, S, R, K> Ensemble<'a, Driven<'a, S, R, PathInputs<'a, S>>, K>
where
    S: WithInputs,
    R: Copy + Rule<S::Held<'a>>,
    Driven<'a, S, R, PathInputs<'a, S>>: PathMethod,
{
    /// Sets the inputs of each step: a function of the number of the path, of the number of the
    /// step, both from 0, and of the state at its start. They are held over the step.
    ///
    /// The function may depend on its arguments only; it is called several times for a step. A
    /// function of the path alone makes a random parameter. A path fails on which an input is not
    /// finite, or the function panics, with the number of the step. The name stands for the
    /// function in shards and checkpoints: other inputs need another name.
    ///
    /// Observables see the system with the inputs of the step that was made last; at the start,
    /// with those of the first step. So the energy of a Lagrangian with inputs is the energy at the
    /// end of a step, before the inputs change. Integrals, averages, weights, crossings and the
    /// functions of passages see the inputs of a step at both of its ends: a function that jumps
    /// where the inputs change does not pass there. The function is called again for this, from the
    /// state before the step.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A particle in a bath, with a force.
    /// struct Particle { sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Particle {
    ///     fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 { 0.5 * v * v + u * q }
    ///     #[gamma]
    ///     fn kick(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// // cold damping: a controller that measures the momentum
    /// let particle = Integrator::new(Particle { sigma: 1.0 }, Midpoint);
    /// let summary = Ensemble::new(&particle)
    ///     .inputs("damping", |_, _, state| -state.p[0])
    ///     .paths(10_000).seed(1)
    ///     .steps(0.1, 100)
    ///     .start(State::new([0.0], [0.0]))
    ///     .observe("p2", |_, state| state.p[0] * state.p[0])
    ///     .run()?;
    /// // p₁ = (1 − h) p₀ + σΔW
    /// let exact = 0.1 / (1.0 - 0.9 * 0.9);
    /// let (mean, error) = (summary["p2"].mean()[1], summary["p2"].standard_error()[1]);
    /// assert!((mean - exact).abs() < 4.0 * error && error < 0.01);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn inputs<F>(
        self,
        name: impl Into<String>,
        inputs: F,
    ) -> Ensemble<'a, Driven<'a, S, R, PathInputs<'a, S>>>
    where
        F: Fn(u64, u64, &StateOf<S>) -> S::Input + Send + Sync + 'a,
    {
        let mut ensemble = Ensemble {
            method: self.method,
            kind: PhantomData,
            paths: self.paths,
            seed: self.seed,
            noise: self.noise,
            steps: self.steps,
            every: self.every,
            start: self.start,
            keep_final_states: self.keep_final_states,
            refine: self.refine,
            stop_on_failure: self.stop_on_failure,
            observed: self.observed,
            execution: self.execution,
        };
        if let Shared::Owned(method) = &mut ensemble.method {
            method.source = PathInputs(Some((name.into(), Box::new(OfPath(inputs)))));
        }
        ensemble
    }
}

impl<'a, S, R> Ensemble<'a, Driven<'a, S, R, PathInputs<'a, S>>, NeedsInputs>
where
    S: WithInputs,
    R: Copy + Rule<S::Held<'a>>,
    Driven<'a, S, R, PathInputs<'a, S>>: PathMethod,
{
    /// Does not compile, and names the call that does: [`inputs`](Self::inputs).
    ///
    /// # Errors
    /// None: it is never called.
    #[doc(hidden)]
    pub fn run(&self) -> Result<Summary, EnsembleError>
    where
        S: StepsWithoutInputs,
    {
        let write = ".inputs(\"push\", |path, step, state| 0.0)";
        Err(missing("function of the inputs", write))
    }
}

/// Checks that the steps of a system with inputs are not divided.
pub(super) fn check_inputs<I: PathMethod>(leg: &Leg<'_, I>) -> Result<(), EnsembleError> {
    match leg.of {
        Some(first) if I::System::INPUTS > 0 => Err(EnsembleError::NotTogether {
            settings: [first, "inputs"],
            why: "an input is held over a step, and levels have steps of different lengths",
        }),
        _ => Ok(()),
    }
}
