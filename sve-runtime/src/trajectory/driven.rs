//! Trajectories of systems with inputs, and the derivatives of a loss by each input.
//!
//! Invariant: an input is computed once a step, from the state at its start, and held over it.
//! Nothing that depends on it is carried to the next step.

use core::borrow::Borrow as _;
use core::fmt;

use super::sweep::Sweep;
use crate::error::StepError;
use crate::integrator::Integrator;
use crate::integrator::accept::time_of_next;
use crate::integrator::inputs::{Holding, check_inputs};
use crate::method::{Differentiable, OneStepMethod};
use crate::noise::{Noise, Replayable, draw};
use crate::phase::Field;
use crate::phase::dual::Dual;
use crate::rule::Rule;
use crate::system::{
    AnyIncrements as _, ConfigurationOf, DualStateOf, MomentumOf, StateOf, System, WithInputs,
};

/// Trajectories of systems with inputs.
pub trait DrivenPaths<S: WithInputs, R> {
    /// Returns a path that still needs the [`inputs`](NeedsInputs::inputs) of its steps.
    fn trajectory<W: Noise>(&self, state: StateOf<S>, h: f64, noise: W)
    -> NeedsInputs<'_, S, R, W>;
}

impl<S: WithInputs, R: Copy> DrivenPaths<S, R> for Integrator<S, R> {
    fn trajectory<W: Noise>(
        &self,
        state: StateOf<S>,
        h: f64,
        noise: W,
    ) -> NeedsInputs<'_, S, R, W> {
        NeedsInputs {
            integrator: self,
            state,
            h,
            noise,
        }
    }
}

/// A path of a system with inputs, without their values.
#[must_use = "a system with inputs needs their values: `.inputs(|step, state| …)`"]
pub struct NeedsInputs<'a, S: WithInputs, R, W> {
    integrator: &'a Integrator<S, R>,
    state: StateOf<S>,
    h: f64,
    noise: W,
}

impl<S: WithInputs, R, W> fmt::Debug for NeedsInputs<'_, S, R, W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NeedsInputs")
            .field("h", &self.h)
            .finish_non_exhaustive()
    }
}

impl<'a, S: WithInputs, R, W> NeedsInputs<'a, S, R, W> {
    /// Returns the states after each step, with the inputs that a function returns for the number of
    /// a step, from 0, and the state at its start. A table is `|step, _| table[step as usize]`; it
    /// needs an entry for each step that is made, and panics beyond its end.
    ///
    /// A function of the state is a feedback, which does not see the increments of its step. Where such an input multiplies increments, the limit h → 0 is that of Itô in
    /// the input, and no order of convergence is claimed. Against a feedback without hold a step is
    /// late by h/2, an error of order 1: continuous friction belongs into `#[force]`.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A pendulum with a motor at its pivot.
    /// struct Pendulum { g: f64, sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Pendulum {
    ///     fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 {
    ///         0.5 * v * v + self.g * q.cos() + u * q
    ///     }
    ///     #[gamma]
    ///     fn shake(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// // the motor holds the pendulum upright, against gravity and noise
    /// let pendulum = Integrator::new(Pendulum { g: 9.8, sigma: 0.1 }, Midpoint);
    /// let path = pendulum
    ///     .trajectory(State::new([3.0], [0.0]), 0.01, Wiener::new(1))
    ///     .inputs(|_, state| -40.0 * (state.q[0] - std::f64::consts::PI) - 8.0 * state.p[0]);
    /// let end = path.take(1000).last().unwrap()?;
    /// assert!((end.q[0] - std::f64::consts::PI).abs() < 0.1);
    /// # Ok(())
    /// # }
    /// ```
    pub fn inputs<F>(self, inputs: F) -> DrivenTrajectory<'a, S, R, W, F>
    where
        F: FnMut(u64, &StateOf<S>) -> S::Input,
    {
        DrivenTrajectory {
            start: self.state.t,
            path: self,
            inputs,
            step: 0,
            has_failed: false,
        }
    }
}

/// A trajectory of a system with inputs: the states after each step, without end, or to the end of
/// a recorded path or the first error.
#[must_use = "an iterator does nothing until it is used"]
pub struct DrivenTrajectory<'a, S: WithInputs, R, W, F> {
    path: NeedsInputs<'a, S, R, W>,
    inputs: F,
    /// Time before the first step.
    start: f64,
    step: u64,
    has_failed: bool,
}

impl<S: WithInputs, R, W, F> fmt::Debug for DrivenTrajectory<'_, S, R, W, F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DrivenTrajectory")
            .field("step", &self.step)
            .finish_non_exhaustive()
    }
}

impl<'a, S, R, W, F> DrivenTrajectory<'a, S, R, W, F>
where
    S: WithInputs,
    R: Copy + Rule<S::Held<'a>>,
    W: Noise,
    F: FnMut(u64, &StateOf<S>) -> S::Input,
    Holding<'a, S, R>: OneStepMethod<System = S::Held<'a>>,
{
    /// Makes the next step. Returns its inputs.
    fn make_step(&mut self) -> Result<S::Input, StepError> {
        let NeedsInputs {
            integrator,
            state,
            h,
            noise,
        } = &mut self.path;
        let (integrator, t) = (*integrator, state.t);
        let mut dw = <Holding<'a, S, R> as OneStepMethod>::Increments::take(
            &mut Default::default(),
            || Ok::<_, StepError>(0),
        )?;
        let drawn = draw(noise, self.step, *h, R::STAGES, dw.as_mut());
        drawn.map_err(|source| StepError::Noise { t, source })?;
        let end = time_of_next(self.start, self.step + 1, *h, t)?;
        // behind the end of a recorded path, so that a table needs no entry there
        let u = (self.inputs)(self.step, state);
        check_inputs::<S>(&u, t)?;
        let held = integrator.holding(&u);
        held.step_prepared(&held.prepare(*h)?, state, *h, dw.borrow())?;
        state.t = end;
        self.step += 1;
        Ok(u)
    }
}

impl<'a, S, R, W, F> Iterator for DrivenTrajectory<'a, S, R, W, F>
where
    S: WithInputs,
    R: Copy + Rule<S::Held<'a>>,
    W: Noise,
    F: FnMut(u64, &StateOf<S>) -> S::Input,
    Holding<'a, S, R>: OneStepMethod<System = S::Held<'a>>,
{
    type Item = Result<StateOf<S>, StepError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.has_failed {
            return None;
        }
        match self.make_step() {
            Ok(_) => Some(Ok(self.path.state)),
            Err(error) => {
                self.has_failed = true;
                (!super::is_end_of_path(&error)).then_some(Err(error))
            }
        }
    }
}

/// A loss with its derivatives along a path with inputs, from [`DrivenTrajectory::gradient`]. `V` is
/// the type of momenta.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivenGradient<V> {
    loss: f64,
    start: Field<V>,
    names: &'static [&'static str],
    /// The number of numbers in the inputs of a step; they are the first parameters.
    width: usize,
    inputs: Vec<f64>,
    parameters: Vec<f64>,
}

impl<V> DrivenGradient<V> {
    /// Returns the loss.
    pub fn loss(&self) -> f64 {
        self.loss
    }

    /// Returns the derivatives by the coordinates and momenta of the first state.
    pub fn start(&self) -> &Field<V> {
        &self.start
    }

    /// Returns the derivatives by the inputs of each step, with a number for each in `u`. They are
    /// those of inputs that are given: a feedback is not differentiated.
    pub fn inputs(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.inputs.chunks_exact(self.width)
    }

    /// Returns the derivative by a parameter, by its name in the source without `self`; `None` if L,
    /// the noises and the forces have no such parameter.
    #[must_use]
    pub fn get(&self, parameter: &str) -> Option<f64> {
        let at = self.names.iter().position(|&name| name == parameter)?;
        self.parameters.get(at.checked_sub(self.width)?).copied()
    }
}

impl<'a, S, R, W, F> DrivenTrajectory<'a, S, R, W, F>
where
    S: WithInputs,
    R: Copy + Rule<S::Held<'a>>,
    W: Replayable,
    F: FnMut(u64, &StateOf<S>) -> S::Input,
    Holding<'a, S, R>: Differentiable<System = S::Held<'a>>,
{
    /// Returns a loss with its derivatives by the inputs of each of the next `steps` steps, by the
    /// present state and by all parameters.
    ///
    /// The loss is the sum of the numbers that a function returns for the number of a state, from 0
    /// for the present one, and the state, written with [dual numbers](Dual); `None` where a state
    /// does not count. A loss of the inputs themselves, such as their squares, is added by the
    /// caller. A loss that reads the input as a parameter of the state, `u[0]`, sees that of the step
    /// before the state, and at the present state that of the step behind it. The path is walked once forwards and once backwards, so that the price of a step does
    /// not depend on their number; the states and inputs of all steps are kept.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A particle that is pushed.
    /// struct Particle;
    ///
    /// #[variational(midpoint)]
    /// impl Particle {
    ///     fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 { 0.5 * v * v + u * q }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let particle = Integrator::new(Particle, Midpoint);
    /// let path = particle.trajectory(State::new([0.0], [0.0]), 0.1, NoNoise).inputs(|_, _| 1.0);
    /// let place = path.gradient(10, |k, state| (k == 10).then(|| state.q[0]))?;
    /// // ∂q_N/∂u_k = h² (N − k − ½)
    /// for (k, by_input) in place.inputs().enumerate() {
    ///     assert!((by_input[0] - 0.01 * (9.5 - k as f64)).abs() < 1e-14);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// A [`StepError`] if a step fails or cannot be differentiated, if an input is not finite, or
    /// the noise has no increments; [`StepError::NonFiniteLoss`].
    pub fn gradient(
        mut self,
        steps: u64,
        loss: impl Fn(u64, &DualStateOf<'_, S::Held<'a>>) -> Option<Dual>,
    ) -> Result<DrivenGradient<MomentumOf<S::Held<'a>>>, StepError> {
        let (first, h) = (self.step, self.path.h);
        let mut kept = Vec::new();
        for _ in 0..steps {
            let state = self.path.state;
            let u = self.make_step()?;
            kept.push((state, u));
        }
        if steps == 0 {
            // the loss of the present state may read the inputs
            let state = self.path.state;
            let u = (self.inputs)(first, &state);
            check_inputs::<S>(&u, state.t)?;
            kept.push((state, u));
        }
        let names = <S::Held<'a> as System>::PARAMETERS;
        let Self { path, start, .. } = self;
        let NeedsInputs {
            integrator,
            state: mut next,
            mut noise,
            ..
        } = path;
        let width = kept
            .first()
            .map_or(1, |(_, u)| S::numbers(u).as_ref().len());
        let mut by_inputs = vec![0.0; kept.len() * width];
        let mut by_parameters = vec![0.0; names.len().saturating_sub(width)];
        let mut value = 0.0;
        let mut by_state = Field::zero::<<S::Held<'a> as System>::Dims>();
        for (k, (state, u)) in kept.iter().enumerate().rev() {
            let held = integrator.holding(u);
            let mut sweep = Sweep {
                method: &held,
                prepared: held.prepare(h)?,
                noise,
                start,
                h,
                first,
                piece: u64::MAX,
                loss: &loss,
                value,
                by_state,
                by_parameters: vec![0.0; names.len()],
            };
            if steps > 0 {
                sweep.add_loss(k as u64 + 1, &next)?;
                sweep.pull_back(k as u64, state)?;
            }
            if k == 0 {
                sweep.add_loss(0, state)?;
            }
            next = *state;
            (noise, by_state, value) = (sweep.noise, sweep.by_state, sweep.value);
            let (inputs, parameters) = sweep.by_parameters.split_at(width);
            by_inputs[k * width..][..width].copy_from_slice(inputs);
            for (sum, more) in by_parameters.iter_mut().zip(parameters) {
                *sum += more;
            }
        }
        by_inputs.truncate(steps as usize * width);
        Ok(DrivenGradient {
            loss: value,
            start: by_state.of::<ConfigurationOf<S::Held<'a>>>(),
            names,
            width,
            inputs: by_inputs,
            parameters: by_parameters,
        })
    }
}
