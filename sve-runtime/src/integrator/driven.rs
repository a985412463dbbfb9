//! Steps of systems whose inputs come from a function.
//!
//! Input: an integrator of a system with inputs, and a source of their values. Output: a method
//! whose prepared values hold the inputs of a step. Invariant: the values that depend on the step
//! size, and those that are carried from step to step, do not depend on inputs.

use core::any::Any;
use core::fmt;
use core::hash::Hasher;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::Integrator;
use super::inputs::{Holding, check_numbers};
use crate::error::StepError;
use crate::lanes::{LANES, Mask};
use crate::method::{Differentiable, OneStepMethod};
use crate::phase::tangents::LaneDirections;
use crate::rule::Rule;
use crate::system::linearisation::{Covector, Directions};
use crate::system::{
    IncrementLanesOf, StateLanesOf, StateOf, System, TangentLanesOf, VectorOf, WithInputs,
};

/// A source of inputs.
#[doc(hidden)]
pub trait Source<S: WithInputs> {
    /// Returns the numbers in the inputs of a step of a path, from the state at its start.
    fn numbers(&self, path: u64, step: u64, state: &StateOf<S>) -> S::Numbers;

    /// Sets the inputs of a step in each lane of a set. Returns the lanes whose inputs are not
    /// finite.
    fn lanes(
        &self,
        (paths, lanes): (&[u64; LANES], Mask),
        step: u64,
        states: &S::Lanes,
        inputs: &mut [S::Numbers; LANES],
    ) -> Mask {
        let mut bad = 0;
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            let state = S::lane(states, lane);
            inputs[lane] = state.map_or(S::OPEN, |state| self.numbers(paths[lane], step, &state));
            let is_finite = inputs[lane].as_ref().iter().all(|u| u.is_finite());
            bad |= Mask::from(!is_finite) << lane;
        }
        bad
    }

    /// Keeps the inputs from a step on.
    fn keep(&self, first: u64) {
        let _ = first;
    }

    /// Writes what tells this source from others.
    fn identify(&self, to: &mut dyn Hasher) {
        let _ = to;
    }
}

/// The method of a system whose inputs come from a source.
#[doc(hidden)]
pub struct Driven<'a, S: WithInputs + 'a, R, F> {
    /// The integrator between steps: its inputs are not numbers.
    open: Holding<'a, S, R>,
    pub(crate) source: F,
}

impl<S: WithInputs, R, F> fmt::Debug for Driven<'_, S, R, F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Driven").finish_non_exhaustive()
    }
}

impl<'a, S: WithInputs + 'a, R: Copy + Rule<S::Held<'a>>, F> Driven<'a, S, R, F> {
    pub(crate) fn new(integrator: &'a Integrator<S, R>, source: F) -> Self {
        let held = integrator.system.held_numbers(S::OPEN);
        let open = Integrator::new(held, integrator.rule).with_newton(integrator.newton);
        Self { open, source }
    }
}

/// The values of steps that hold inputs.
#[doc(hidden)]
pub struct Held<I: OneStepMethod> {
    integrator: I,
    prepared: I::Prepared,
    /// The path and the step whose inputs are held.
    step: Option<(u64, u64)>,
}

impl<I: OneStepMethod + Clone> Clone for Held<I> {
    fn clone(&self) -> Self {
        Self {
            integrator: self.integrator.clone(),
            prepared: self.prepared.clone(),
            step: self.step,
        }
    }
}

impl<'a, S, R, F> OneStepMethod for Driven<'a, S, R, F>
where
    S: WithInputs + 'a,
    F: Source<S>,
    R: Copy + Rule<S::Held<'a>>,
    Holding<'a, S, R>: OneStepMethod<System = S::Held<'a>> + Clone,
{
    type System = S::Held<'a>;
    type Increments = <Holding<'a, S, R> as OneStepMethod>::Increments;
    type Prepared = Held<Holding<'a, S, R>>;

    fn system(&self) -> &S::Held<'a> {
        self.open.system()
    }

    fn prepare(&self, h: f64) -> Result<Self::Prepared, StepError> {
        Ok(Held {
            integrator: self.open.clone(),
            prepared: self.open.prepare(h)?,
            step: None,
        })
    }

    fn prepare_within(&self, step: &Self::Prepared, h: f64) -> Result<Self::Prepared, StepError> {
        Ok(Held {
            prepared: self.open.prepare(h)?,
            ..step.clone()
        })
    }

    fn system_in<'p>(&'p self, prepared: &'p Self::Prepared) -> &'p S::Held<'a> {
        prepared.integrator.system()
    }

    #[inline]
    fn hold(
        &self,
        prepared: &mut Self::Prepared,
        path: u64,
        step: u64,
        state: &StateOf<S::Held<'a>>,
    ) -> Result<(), StepError> {
        if prepared.step == Some((path, step)) {
            return Ok(());
        }
        let numbers = checked(&self.source, path, step, state)?;
        S::inputs_of(&mut prepared.integrator.system).set(numbers);
        prepared.step = Some((path, step));
        Ok(())
    }

    #[inline]
    fn hold_lanes(
        &self,
        prepared: &mut Self::Prepared,
        (paths, active): (&[u64; LANES], Mask),
        step: u64,
        states: &StateLanesOf<S::Held<'a>>,
    ) -> Mask {
        let inputs = S::inputs_of(&mut prepared.integrator.system).lanes();
        let set = || self.source.lanes((paths, active), step, states, inputs);
        let Ok(bad) = catch_unwind(AssertUnwindSafe(set)) else {
            // each path of its own finds whose inputs they were
            return active;
        };
        let first = inputs[active.trailing_zeros() as usize % LANES];
        for lane in (0..LANES).filter(|lane| active >> lane & 1 == 0) {
            inputs[lane] = first;
        }
        bad
    }

    fn system_of_step(
        &self,
        path: u64,
        step: u64,
        state: &StateOf<S::Held<'a>>,
    ) -> Result<Option<S::Held<'a>>, StepError> {
        let mut system = self.open.system().clone();
        S::inputs_of(&mut system).set(checked(&self.source, path, step, state)?);
        Ok(Some(system))
    }

    fn keep_held(&self, first: u64) {
        self.source.keep(first);
    }

    #[inline]
    fn step_prepared(
        &self,
        prepared: &Self::Prepared,
        state: &mut StateOf<S::Held<'a>>,
        h: f64,
        dw: &Self::Increments,
    ) -> Result<(), StepError> {
        (prepared.integrator).step_prepared(&prepared.prepared, state, h, dw)
    }

    fn stages(&self) -> usize {
        self.open.stages()
    }

    fn processes(&self, state: &StateOf<S::Held<'a>>) -> Result<usize, StepError> {
        self.open.processes(state)
    }

    #[inline]
    fn next_step(
        &self,
        prepared: &mut Self::Prepared,
        state: &mut StateOf<S::Held<'a>>,
        h: f64,
        dw: &Self::Increments,
    ) -> Result<(), StepError> {
        (prepared.integrator).next_step(&mut prepared.prepared, state, h, dw)
    }

    fn memory(&self, prepared: &Self::Prepared) -> Vec<f64> {
        self.open.memory(&prepared.prepared)
    }

    fn recall(&self, prepared: &mut Self::Prepared, numbers: &[f64]) -> bool {
        self.open.recall(&mut prepared.prepared, numbers)
    }

    fn has_compensated_step(&self) -> bool {
        self.open.has_compensated_step()
    }

    #[inline]
    fn compensated_step(
        &self,
        prepared: &mut Self::Prepared,
        state: &mut StateOf<S::Held<'a>>,
        low: &mut StateOf<S::Held<'a>>,
        h: f64,
        dw: &Self::Increments,
    ) -> Result<(), StepError> {
        (prepared.integrator).compensated_step(&mut prepared.prepared, state, low, h, dw)
    }

    #[inline(always)]
    fn step_lanes(
        &self,
        prepared: &Self::Prepared,
        states: &StateLanesOf<S::Held<'a>>,
        next: &mut StateLanesOf<S::Held<'a>>,
        h: f64,
        dw: &IncrementLanesOf<Self::Increments>,
    ) -> Mask {
        (prepared.integrator).step_lanes(&prepared.prepared, states, next, h, dw)
    }

    fn identify(&self, to: &mut dyn Hasher) {
        self.open.identify(to);
        self.source.identify(to);
    }

    fn describe(&self) -> String {
        self.open.describe()
    }

    fn order(&self) -> Option<f64> {
        self.open.order()
    }
}

/// Returns the numbers in the inputs of a step of a path, from the state at its start.
///
/// # Errors
/// [`StepError::Inputs`] if the source panics; [`StepError::NonFiniteInput`].
#[inline]
fn checked<S: WithInputs>(
    source: &impl Source<S>,
    path: u64,
    step: u64,
    state: &StateOf<S>,
) -> Result<S::Numbers, StepError> {
    let numbers = catch_unwind(AssertUnwindSafe(|| source.numbers(path, step, state)));
    let numbers = numbers.map_err(|panic| StepError::Inputs {
        step,
        t: state.t,
        message: message_of(&*panic),
    })?;
    check_numbers(numbers.as_ref(), state.t)?;
    Ok(numbers)
}

/// Returns the message of a panic.
#[cold]
fn message_of(panic: &dyn Any) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    text.unwrap_or("it has no message").to_owned()
}

#[diagnostic::do_not_recommend]
impl<'a, S, R, F> Differentiable for Driven<'a, S, R, F>
where
    S: WithInputs + 'a,
    F: Source<S>,
    R: Copy + Rule<S::Held<'a>>,
    S::Held<'a>: System,
    Holding<'a, S, R>: Differentiable<System = S::Held<'a>> + Clone,
{
    fn push_forward(
        &self,
        prepared: &Self::Prepared,
        state: &mut StateOf<S::Held<'a>>,
        h: f64,
        dw: &Self::Increments,
        directions: Directions<'_, VectorOf<S::Held<'a>>>,
    ) -> Result<(), StepError> {
        (prepared.integrator).push_forward(&prepared.prepared, state, h, dw, directions)
    }

    #[inline(always)]
    fn push_forward_lanes(
        &self,
        prepared: &Self::Prepared,
        states: &StateLanesOf<S::Held<'a>>,
        next: &mut StateLanesOf<S::Held<'a>>,
        h: f64,
        dw: &IncrementLanesOf<Self::Increments>,
        tangents: LaneDirections<'_, TangentLanesOf<S::Held<'a>>>,
    ) -> [Mask; 2] {
        let Held {
            integrator,
            prepared,
            ..
        } = prepared;
        integrator.push_forward_lanes(prepared, states, next, h, dw, tangents)
    }

    fn pull_back(
        &self,
        prepared: &Self::Prepared,
        state: &StateOf<S::Held<'a>>,
        h: f64,
        dw: &Self::Increments,
        covector: Covector<'_, VectorOf<S::Held<'a>>>,
    ) -> Result<(), StepError> {
        (prepared.integrator).pull_back(&prepared.prepared, state, h, dw, covector)
    }
}
