//! The gradient of a function of the states along a path, by the discrete adjoint.
//!
//! Input: a trajectory, a number of steps and a loss. Output: the loss with its derivatives by the
//! state at the start and by each parameter. Invariant: the derivatives belong to the steps as they
//! are computed, so they agree with the tangent maps of the steps to rounding.
//!
//! The steps are walked backwards: λ ← Mᵀλ + ∂ℓ/∂x for the tangent map M of a step. The states that
//! this needs are kept, or computed again from checkpoints.

use core::fmt;

use super::Trajectory;
use super::checkpoints::enough;
use super::sweep::{Kept, Sweep};
use crate::error::StepError;
use crate::method::{Differentiable, DimsOf, OneStepMethod};
use crate::noise::{Noise, Replayable};
use crate::phase::Field;
use crate::phase::dual::Dual;
use crate::system::{ConfigurationOf, DualStateOf, MomentumOf, StateOf, System};

/// Steps of a trajectory along which a loss is differentiated, with the options of
/// [`Trajectory::adjoint`].
pub struct Adjoint<'a, I: OneStepMethod, W> {
    trajectory: Trajectory<'a, I, W>,
    steps: u64,
    checkpoints: Option<usize>,
    piece: u64,
}

impl<I: OneStepMethod, W> fmt::Debug for Adjoint<'_, I, W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Adjoint")
            .field("steps", &self.steps)
            .field("checkpoints", &self.checkpoints)
            .field("pieces_of", &self.piece)
            .finish_non_exhaustive()
    }
}

/// A loss with its derivatives, from [`Trajectory::gradient`]. `V` is the type of momenta.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient<V> {
    loss: f64,
    start: Field<V>,
    names: &'static [&'static str],
    /// The number of inputs, which are the first parameters.
    inputs: usize,
    pieces: usize,
    /// The derivatives, piece by piece, parameter by parameter.
    parameters: Vec<f64>,
}

impl<V> Gradient<V> {
    /// Returns the loss.
    pub fn loss(&self) -> f64 {
        self.loss
    }

    /// Returns the derivatives by the coordinates and momenta of the first state.
    ///
    /// Under constraints, and for a degenerate Lagrangian, they are derivatives along the allowed
    /// states. For a rotation they are derivatives along the canonical coordinates of a
    /// [`Tangent`](crate::Tangent).
    pub fn start(&self) -> &Field<V> {
        &self.start
    }

    /// Returns the derivative by a parameter, by its name in the source without `self`: `k`,
    /// `l[0]`, `body.mass`. `None` if L, the noises and the force have no such parameter. The start
    /// stays as it is.
    #[must_use]
    pub fn get(&self, parameter: &str) -> Option<f64> {
        Some(self.pieces(parameter)?.sum())
    }

    /// Returns the derivatives by the values that a parameter has in each
    /// [piece](Adjoint::pieces_of).
    #[must_use]
    pub fn pieces(&self, parameter: &str) -> Option<impl Iterator<Item = f64>> {
        let number = self.names.iter().position(|&name| name == parameter)?;
        Some(self.of(number))
    }

    /// Returns the derivatives by the inputs of each step, with a number for each in `u`; with
    /// [`pieces_of`](Adjoint::pieces_of), by inputs that are the same for all steps of a piece. A
    /// feedback is not differentiated. Without inputs there are no numbers.
    pub fn inputs(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        let rows = self.parameters.chunks_exact(self.names.len().max(1));
        rows.take(self.pieces).map(|row| &row[..self.inputs])
    }

    /// Returns the parameters with their derivatives.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let all = self.names.iter().enumerate();
        all.map(|(number, &name)| (name, self.of(number).sum()))
    }

    fn of(&self, number: usize) -> impl Iterator<Item = f64> {
        // Without parameters there is no number.
        let rows = self.parameters.chunks_exact(self.names.len().max(1));
        rows.map(move |row| row[number])
    }
}

impl<'a, I: OneStepMethod, W: Noise> Trajectory<'a, I, W> {
    /// Returns a loss with its derivatives by the present state and by all parameters, along the
    /// next `steps` steps.
    ///
    /// The loss is the sum of the numbers that a function returns for the number of a state, from 0
    /// for the present one, and the state, written with [dual numbers](Dual); `None` where a state
    /// does not count. A gradient takes about 3 times the time of the steps by
    /// [`Midpoint`](crate::Midpoint), 7 to 8 times by [`Gauss<8>`](crate::Gauss), and up to one
    /// such time more for paths whose states are not all [kept](Adjoint::checkpoints). See
    /// [`adjoint`](Self::adjoint) for memory, and for parameters that are step functions of time.
    /// To differentiate by a few parameters only,
    /// [`step_with_derivatives`](crate::Integrator::step_with_derivatives) goes forwards.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Pendulum { g: f64, sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Pendulum {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.g * q.cos() }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let pendulum = Integrator::new(Pendulum { g: 9.8, sigma: 0.1 }, Midpoint);
    /// let path = pendulum.trajectory(State::new([1.0], [0.0]), 0.01, Wiener::new(7));
    /// let at_end = path.gradient(1000, |k, state| (k == 1000).then(|| state.q[0]))?;
    /// println!("∂q/∂g = {:?}, ∂q/∂q₀ = {}", at_end.get("g"), at_end.start().q[0]);
    ///
    /// // squares of the distances to data, one in each ten steps
    /// let data = |k: u64| (3.0 * 0.01 * k as f64).cos();
    /// let path = pendulum.trajectory(State::new([1.0], [0.0]), 0.01, Wiener::new(7));
    /// let fit = path.gradient(1000, |k, state| {
    ///     (k % 10 == 0).then(|| (state.q[0] - data(k)).powi(2))
    /// })?;
    /// println!("{} {:?}", fit.loss(), fit.get("g"));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// The states are those of the trajectory, bit for bit, except of one with compensated sums,
    /// with which they agree to rounding. The noise is asked for the increments of a step several
    /// times.
    ///
    /// # Errors
    /// A [`StepError`] if a step fails, if the noise has no increments for it, or if its equations
    /// are singular; [`StepError::NonFiniteLoss`] if the loss is not finite;
    /// [`StepError::UnknownParameter`] if the loss asks for a parameter that the system does not
    /// have.
    pub fn gradient(
        self,
        steps: u64,
        loss: impl Fn(u64, &DualStateOf<'_, I::System>) -> Option<Dual>,
    ) -> Result<Gradient<MomentumOf<I::System>>, StepError>
    where
        I: Differentiable,
        W: Replayable,
    {
        self.adjoint(steps).gradient(loss)
    }

    /// Returns the next `steps` steps, to differentiate a loss along them with options.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A mass that is pulled by a force u(t).
    /// struct Pulled { u: f64 }
    ///
    /// #[variational(stormer_verlet)]
    /// impl Pulled {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.u * q }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let pulled = Integrator::new(Pulled { u: 0.0 }, StormerVerlet);
    /// let path = pulled.trajectory(State::new([0.0], [0.0]), 0.01, NoNoise);
    /// let adjoint = path.adjoint(100).pieces_of(25).checkpoints(5);
    /// let gradient = adjoint.gradient(|k, state| (k == 100).then(|| state.q[0]))?;
    /// // a force in a quarter of the time 1 moves the end by the distance of its middle from the
    /// // end, times ¼
    /// for (gained, left) in gradient.pieces("u").unwrap().zip([0.875, 0.625, 0.375, 0.125]) {
    ///     assert!((gained - 0.25 * left).abs() < 1e-14);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    pub fn adjoint(self, steps: u64) -> Adjoint<'a, I, W>
    where
        I: Differentiable,
        W: Replayable,
    {
        Adjoint {
            trajectory: self,
            steps,
            checkpoints: None,
            piece: if I::System::INPUTS > 0 {
                1
            } else {
                steps.max(1)
            },
        }
    }
}

impl<I: Differentiable, W: Replayable> Adjoint<'_, I, W> {
    /// Sets the number of states that are kept at the same time, besides the first one. By default
    /// all states are kept if they take 16 MiB at most, and each step is made twice; else as many
    /// as fit there, at least √(2 steps), with which a step is made three times at most. With fewer
    /// states the steps are made more often: `c` states are enough for (c + r)!/(c! r!) steps that
    /// are made `r` + 1 times. [`Trajectory::adjoint`] has an example.
    #[must_use]
    pub fn checkpoints(mut self, states: usize) -> Self {
        self.checkpoints = Some(states);
        self
    }

    /// Differentiates by the values of the parameters in each piece of so many steps, as if the
    /// parameters were step functions of time: [`Gradient::pieces`]. A parameter that the loss
    /// itself reads belongs to the step before the state. With 0 there is one piece.
    /// [`Trajectory::adjoint`] has an example.
    #[must_use]
    pub fn pieces_of(mut self, steps: u64) -> Self {
        self.piece = if steps == 0 { self.steps.max(1) } else { steps };
        self
    }

    /// Returns a loss with its derivatives, see [`Trajectory::gradient`].
    ///
    /// # Errors
    /// As [`Trajectory::gradient`].
    pub fn gradient(
        self,
        loss: impl Fn(u64, &DualStateOf<'_, I::System>) -> Option<Dual>,
    ) -> Result<Gradient<MomentumOf<I::System>>, StepError> {
        let Self {
            trajectory,
            steps,
            checkpoints,
            piece,
        } = self;
        trajectory.check_sizes()?;
        let (parameters, pieces) = (
            I::System::PARAMETERS.len(),
            steps.div_ceil(piece).max(1) as usize,
        );
        let size = size_of::<Kept<StateOf<I::System>>>();
        let checkpoints = checkpoints.unwrap_or_else(|| enough(steps, size));
        trajectory.method.keep_held(trajectory.step);
        let carried = trajectory.prepared.filter(|_| trajectory.low.is_none());
        let prepared = carried.map_or_else(|| trajectory.method.prepare(trajectory.h), Ok)?;
        let mut sweep = Sweep {
            prepared,
            at: 0,
            first: trajectory.step,
            method: trajectory.method,
            noise: trajectory.noise,
            start: trajectory.start,
            h: trajectory.h,
            piece,
            loss,
            value: 0.0,
            by_state: Field::zero::<DimsOf<I>>(),
            by_parameters: vec![0.0; parameters * pieces],
        };
        sweep.back(trajectory.state, steps, checkpoints)?;
        Ok(Gradient {
            loss: sweep.value,
            start: sweep.by_state.of::<ConfigurationOf<I::System>>(),
            names: I::System::PARAMETERS,
            inputs: I::System::INPUTS,
            pieces: steps.div_ceil(piece) as usize,
            parameters: sweep.by_parameters,
        })
    }
}
