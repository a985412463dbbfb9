//! One-step methods, which trajectories and ensembles run.

mod within;

use core::any::type_name;
use core::hash::Hasher;

use crate::error::StepError;
use crate::lanes::{ALL, LANES, Mask};
use crate::phase::tangents::LaneDirections;
use crate::system::linearisation::{Covector, Directions};
use crate::system::{
    AnyIncrements, AnySystem, IncrementLanesOf, StateLanesOf, StateOf, System, TangentLanesOf,
    VectorOf,
};

pub use within::Shared;
pub(crate) use within::Within;

/// The sizes and types of the system of a method.
pub(crate) type DimsOf<I> = <<I as OneStepMethod>::System as System>::Dims;

/// A one-step method for a system, with increments of any kind: an
/// [`Integrator`](crate::Integrator) or a [`baseline`](crate::baseline).
pub trait OneStepMethod {
    /// The system that the method integrates.
    type System: AnySystem;
    /// The increments of a step: [`IncrementsOf`](crate::system::IncrementsOf) the system for
    /// methods that take one for each Wiener process.
    type Increments: AnyIncrements + ?Sized;
    /// Values that depend on parameters and step size only, and the numbers that a trajectory
    /// carries from step to step.
    type Prepared: Clone;

    /// True if a step writes the time at its end, which is not `h` after its start.
    #[doc(hidden)]
    const HAS_OWN_TIME: bool = false;

    /// Returns the time that passes in a unit of the step size, which is 1 unless steps write the
    /// time at their end.
    #[doc(hidden)]
    fn rate(&self, _state: &StateOf<Self::System>) -> f64 {
        1.0
    }

    /// Returns the system that the method integrates.
    fn system(&self) -> &Self::System;

    /// Checks the step size and computes the values that depend on it only.
    ///
    /// # Errors
    /// [`StepError::StepSize`] if `h` is zero or not finite.
    fn prepare(&self, h: f64) -> Result<Self::Prepared, StepError>;

    /// Makes one step, with the values that [`prepare`](Self::prepare) returned for the same `h`
    /// and the same parameters.
    ///
    /// # Errors
    /// A [`StepError`] if the step fails; `state` is then unchanged.
    fn step_prepared(
        &self,
        prepared: &Self::Prepared,
        state: &mut StateOf<Self::System>,
        h: f64,
        dw: &Self::Increments,
    ) -> Result<(), StepError>;

    /// Holds what the next step of a path is given besides its increments: the inputs of step
    /// `step`, from the state at its start.
    ///
    /// # Errors
    /// A [`StepError`] if they are not finite.
    #[doc(hidden)]
    #[inline(always)]
    fn hold(
        &self,
        prepared: &mut Self::Prepared,
        path: u64,
        step: u64,
        state: &StateOf<Self::System>,
    ) -> Result<(), StepError> {
        let _ = (prepared, path, step, state);
        Ok(())
    }

    /// Holds what the next step is given in each active lane, as [`hold`](Self::hold) does. Returns
    /// the lanes for which it fails.
    #[doc(hidden)]
    #[inline(always)]
    fn hold_lanes(
        &self,
        prepared: &mut Self::Prepared,
        paths: (&[u64; LANES], Mask),
        step: u64,
        states: &StateLanesOf<Self::System>,
    ) -> Mask {
        let _ = (prepared, paths, step, states);
        0
    }

    /// Computes the values for a step of length `h` within a step, which holds the same.
    ///
    /// # Errors
    /// As [`prepare`](Self::prepare).
    #[doc(hidden)]
    #[inline]
    fn prepare_within(&self, step: &Self::Prepared, h: f64) -> Result<Self::Prepared, StepError> {
        let _ = step;
        self.prepare(h)
    }

    /// Returns the system in a step, with what it holds.
    #[doc(hidden)]
    #[inline(always)]
    fn system_in<'p>(&'p self, prepared: &'p Self::Prepared) -> &'p Self::System {
        let _ = prepared;
        self.system()
    }

    /// Returns the system with what it holds in a step of a path, from the state at its start;
    /// `None` if steps hold nothing.
    ///
    /// # Errors
    /// As [`hold`](Self::hold).
    #[doc(hidden)]
    #[inline(always)]
    fn system_of_step(
        &self,
        path: u64,
        step: u64,
        state: &StateOf<Self::System>,
    ) -> Result<Option<Self::System>, StepError> {
        let _ = (path, step, state);
        Ok(None)
    }

    /// Keeps what the steps from a number on are given, for steps that are made again.
    #[doc(hidden)]
    fn keep_held(&self, first: u64) {
        let _ = first;
    }

    /// Returns the number of increments of a process in a step: 1, or the number of stages of a
    /// rule with stage noise.
    #[doc(hidden)]
    #[inline]
    fn stages(&self) -> usize {
        1
    }

    /// Makes the next step of a trajectory. Keeps in `prepared` the numbers that the following step
    /// can use. For a method that carries nothing it is the same as
    /// [`step_prepared`](Self::step_prepared).
    ///
    /// # Errors
    /// As [`step_prepared`](Self::step_prepared).
    #[doc(hidden)]
    #[inline]
    fn next_step(
        &self,
        prepared: &mut Self::Prepared,
        state: &mut StateOf<Self::System>,
        h: f64,
        dw: &Self::Increments,
    ) -> Result<(), StepError> {
        self.step_prepared(prepared, state, h, dw)
    }

    /// Makes up to `count` of the next steps of a trajectory at once. Returns the number of steps
    /// that were made, which have the bits of single steps; 0 if the method makes no steps at once,
    /// or if one of them fails: the state is then unchanged, and the trajectory makes single steps.
    ///
    /// `draw` fills the increments of a step, by its number among these steps, and returns the time
    /// at its end, which the method writes to the state. If `draw` returns `None`, the steps end
    /// before. A step can be drawn again.
    #[doc(hidden)]
    #[inline(always)]
    fn next_steps(
        &self,
        prepared: &mut Self::Prepared,
        state: &mut StateOf<Self::System>,
        h: f64,
        dw: &mut Self::Increments,
        count: u64,
        draw: &mut dyn FnMut(u64, &mut Self::Increments) -> Option<f64>,
    ) -> u64 {
        let _ = (prepared, state, h, dw, count, draw);
        0
    }

    /// Returns the number of increments of a step from a state, if they are a slice.
    ///
    /// # Errors
    /// A [`StepError`] if the number cannot be computed.
    #[doc(hidden)]
    #[inline(always)]
    fn processes(&self, state: &StateOf<Self::System>) -> Result<usize, StepError> {
        let _ = state;
        Ok(0)
    }

    /// Returns the numbers that the method carries from step to step.
    #[doc(hidden)]
    fn memory(&self, prepared: &Self::Prepared) -> Vec<f64> {
        let _ = prepared;
        Vec::new()
    }

    /// Replaces the numbers that the method carries from step to step. Returns whether their count
    /// is right.
    #[doc(hidden)]
    fn recall(&self, prepared: &mut Self::Prepared, numbers: &[f64]) -> bool {
        let _ = prepared;
        numbers.is_empty()
    }

    /// Advances every lane on the fast path and writes the result to `next`. Returns the mask of
    /// lanes that the fast path could not solve; their states are copied unchanged, and the caller
    /// steps them with [`step_prepared`](Self::step_prepared). The default implementation solves no
    /// lane.
    ///
    /// Times in `next` are not written: the caller sets them.
    #[doc(hidden)]
    #[inline(always)]
    fn step_lanes(
        &self,
        prepared: &Self::Prepared,
        states: &StateLanesOf<Self::System>,
        next: &mut StateLanesOf<Self::System>,
        h: f64,
        dw: &IncrementLanesOf<Self::Increments>,
    ) -> Mask {
        let _ = (prepared, h, dw);
        next.clone_from(states);
        ALL
    }

    /// Writes the method's name and options to a hasher: everything that determines the steps
    /// besides system, step size and increments. The hash identifies the method of shards and
    /// checkpoints of ensembles.
    ///
    /// The default implementation writes the name of the type. A method with options has to add
    /// them.
    fn identify(&self, to: &mut dyn Hasher) {
        // The arguments of the type are dropped: the system has its own hash.
        let name = type_name::<Self>();
        to.write(name.split('<').next().unwrap_or(name).as_bytes());
    }

    /// Returns the name of the method with its options, as pages of ensembles and studies show it.
    /// The default implementation returns the name of the type.
    fn describe(&self) -> String {
        let name = type_name::<Self>();
        let name = name.split('<').next().unwrap_or(name);
        name.rsplit("::").next().unwrap_or(name).to_owned()
    }

    /// Returns the largest number of Newton iterations of a block in a step from `state`; 0 if the
    /// equations are explicit or linear. `None` if the method does not count iterations, or the
    /// step fails.
    ///
    /// For measurements only: it costs several steps, since a step does not count its iterations.
    fn newton_iterations(
        &self,
        prepared: &Self::Prepared,
        state: &StateOf<Self::System>,
        h: f64,
        dw: &Self::Increments,
    ) -> Option<u32> {
        let _ = (prepared, state, h, dw);
        None
    }

    /// Returns the order of convergence at a fixed time, if it is known: the strong order with
    /// noise, otherwise the deterministic order.
    fn order(&self) -> Option<f64> {
        None
    }

    /// Returns whether [`compensated_step`](Self::compensated_step) makes steps.
    #[doc(hidden)]
    fn has_compensated_step(&self) -> bool {
        false
    }

    /// Makes one step that adds the low parts `low` of the state, and writes its rounding errors to
    /// `low`.
    ///
    /// # Errors
    /// As [`step_prepared`](Self::step_prepared); [`StepError::Uncompensated`] if the method makes
    /// no such steps.
    #[doc(hidden)]
    fn compensated_step(
        &self,
        prepared: &mut Self::Prepared,
        state: &mut StateOf<Self::System>,
        low: &mut StateOf<Self::System>,
        h: f64,
        dw: &Self::Increments,
    ) -> Result<(), StepError> {
        let _ = (prepared, low, h, dw);
        Err(StepError::Uncompensated { t: state.t })
    }
}

/// A method whose steps can be differentiated by their start and the parameters: every
/// [`Integrator`](crate::Integrator).
///
/// Gradients along paths require it: `gradient` of an ensemble, and
/// [`Trajectory::gradient`](crate::Trajectory::gradient).
#[diagnostic::on_unimplemented(
    message = "the steps of `{Self}` have no derivatives",
    label = "gradients need the derivatives of each step",
    note = "the steps of an `Integrator` have them, with any rule and composition; those of a baseline have not"
)]
pub trait Differentiable: OneStepMethod<System: System> {
    /// Makes one step and carries tangent vectors along it. `prepared` has the values of
    /// [`prepare`](OneStepMethod::prepare) for this `h`.
    ///
    /// # Errors
    /// As [`step_prepared`](OneStepMethod::step_prepared), and [`StepError::Singular`] if the
    /// Jacobian of the equations is singular at their solution. The vectors are then invalid.
    #[doc(hidden)]
    fn push_forward(
        &self,
        prepared: &Self::Prepared,
        state: &mut StateOf<Self::System>,
        h: f64,
        dw: &Self::Increments,
        directions: Directions<'_, VectorOf<Self::System>>,
    ) -> Result<(), StepError>;

    /// Makes one step in every lane as [`step_lanes`](OneStepMethod::step_lanes) does, bit for bit,
    /// and carries tangent vectors along it. Returns the mask of lanes that were not solved, and
    /// the mask of lanes whose vectors are invalid.
    #[doc(hidden)]
    fn push_forward_lanes(
        &self,
        prepared: &Self::Prepared,
        states: &StateLanesOf<Self::System>,
        next: &mut StateLanesOf<Self::System>,
        h: f64,
        dw: &IncrementLanesOf<Self::Increments>,
        tangents: LaneDirections<'_, TangentLanesOf<Self::System>>,
    ) -> [Mask; 2];

    /// Carries the derivatives of a function by the result of a step back to `state`, the start of
    /// the step.
    ///
    /// # Errors
    /// As [`push_forward`](Self::push_forward).
    #[doc(hidden)]
    fn pull_back(
        &self,
        prepared: &Self::Prepared,
        state: &StateOf<Self::System>,
        h: f64,
        dw: &Self::Increments,
        covector: Covector<'_, VectorOf<Self::System>>,
    ) -> Result<(), StepError>;
}
