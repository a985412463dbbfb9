//! The walk of a discrete adjoint from the last state of a path to the first.
//!
//! Input: the first state and the number of steps. Output: the loss with its derivatives.
//! Invariant: the states that the walk reads are those of the trajectory, bit for bit, however many
//! of them are kept.

use core::borrow::Borrow as _;
use core::cell::RefCell;
use core::ops::Range;

use super::checkpoints::distance;
use crate::error::StepError;
use crate::integrator::accept::time_of_next;
use crate::mechanics::with_dual_state;
use crate::method::{Differentiable, DimsOf, Shared};
use crate::noise::{Replayable, draw};
use crate::phase::Field;
use crate::phase::configuration::FixedSize;
use crate::phase::dual::Dual;
use crate::system::linearisation::Covector;
use crate::system::{
    AnyIncrements as _, ConfigurationOf, DualStateOf, StateOf, System as _, VectorOf,
};

/// A state that is kept.
pub(super) struct Kept<S> {
    number: u64,
    state: S,
    /// The numbers that the method carries there.
    memory: Vec<f64>,
}

/// The walk backwards.
pub(super) struct Sweep<'a, I: Differentiable, W, F> {
    pub(super) method: Shared<'a, I>,
    /// Values of the step, and the numbers that the method carries at the state [`at`](Self::at).
    pub(super) prepared: I::Prepared,
    /// The number of the state that was walked to last.
    pub(super) at: u64,
    pub(super) noise: W,
    /// Time before the first step of the trajectory.
    pub(super) start: f64,
    pub(super) h: f64,
    /// Number of steps of the trajectory before the first state.
    pub(super) first: u64,
    /// Number of steps of a piece.
    pub(super) piece: u64,
    pub(super) loss: F,
    /// The loss of the states that have been passed.
    pub(super) value: f64,
    /// The derivative of the loss by the state that has been reached.
    pub(super) by_state: Field<VectorOf<I::System>>,
    pub(super) by_parameters: Vec<f64>,
}

impl<I, W, F> Sweep<'_, I, W, F>
where
    I: Differentiable,
    W: Replayable,
    F: Fn(u64, &DualStateOf<'_, I::System>) -> Option<Dual>,
{
    /// Walks from the end to the first state.
    pub(super) fn back(
        &mut self,
        first: StateOf<I::System>,
        steps: u64,
        checkpoints: usize,
    ) -> Result<(), StepError> {
        let memory = self.method.memory(&self.prepared);
        let (number, state) = (0, first);
        let mut kept = vec![Kept {
            number,
            state,
            memory,
        }];
        let mut reached = steps;
        if steps == 0 {
            self.add_loss(0, &first)?;
        }
        while let Some(last) = kept.last().filter(|_| reached > 0) {
            let left = reached - last.number;
            let free = checkpoints.saturating_sub(kept.len() - 1) as u64;
            if left > 1 && free > 0 {
                let number = last.number + distance(left, free);
                let state = self.state_at(number, last)?;
                // If each of the following states is kept, the walk begins at none of them.
                let memory = if left <= free + 1 {
                    Vec::new()
                } else {
                    self.method.memory(&self.prepared)
                };
                kept.push(Kept {
                    number,
                    state,
                    memory,
                });
                continue;
            }
            let before = self.state_at(reached - 1, last)?;
            if reached == steps {
                let end = self.steps(steps - 1..steps, before)?;
                self.add_loss(steps, &end)?;
            }
            self.pull_back(reached - 1, &before)?;
            self.add_loss(reached - 1, &before)?;
            reached -= 1;
            if left == 1 {
                kept.pop();
            }
        }
        Ok(())
    }

    /// Returns a state, by steps from a kept one.
    fn state_at(
        &mut self,
        number: u64,
        from: &Kept<StateOf<I::System>>,
    ) -> Result<StateOf<I::System>, StepError> {
        if from.number < number && from.number != self.at {
            let is_recalled = self.method.recall(&mut self.prepared, &from.memory);
            debug_assert!(is_recalled, "numbers of the same method");
        }
        self.steps(from.number..number, from.state)
    }

    /// Makes steps as the trajectory does.
    fn steps(
        &mut self,
        steps: Range<u64>,
        mut state: StateOf<I::System>,
    ) -> Result<StateOf<I::System>, StepError> {
        for step in steps {
            let dw = self.increments(step, state.t)?;
            let end = time_of_next(self.start, self.first + step + 1, self.h, state.t)?;
            let number = self.first + step;
            self.method.hold(&mut self.prepared, 0, number, &state)?;
            let (method, prepared) = (&*self.method, &mut self.prepared);
            method.next_step(prepared, &mut state, self.h, dw.borrow())?;
            state.t = end;
            self.at = step + 1;
        }
        Ok(state)
    }

    /// Returns the increments of a step that begins at time `t`.
    fn increments(
        &mut self,
        step: u64,
        t: f64,
    ) -> Result<<I::Increments as ToOwned>::Owned, StepError> {
        // An array, whose length its type knows.
        let mut dw = I::Increments::take(&mut Default::default(), || Ok::<_, StepError>(0))?;
        let step = self.first + step;
        let stages = self.method.stages();
        draw(&mut self.noise, step, self.h, stages, dw.as_mut())
            .map_err(|source| StepError::Noise { t, source })?;
        Ok(dw)
    }

    /// Carries the derivatives over a step back to its start.
    pub(super) fn pull_back(
        &mut self,
        step: u64,
        state: &StateOf<I::System>,
    ) -> Result<(), StepError> {
        let dw = self.increments(step, state.t)?;
        let number = self.first + step;
        self.method.hold(&mut self.prepared, 0, number, state)?;
        let piece = self.range_of(step);
        let covector = Covector {
            state: &mut self.by_state,
            parameters: &mut self.by_parameters[piece],
        };
        (self.method).pull_back(&self.prepared, state, self.h, dw.borrow(), covector)
    }

    /// Adds the loss of a state and its derivatives. It sees what the step before it was given, at
    /// the first state the step behind it.
    pub(super) fn add_loss(
        &mut self,
        number: u64,
        state: &StateOf<I::System>,
    ) -> Result<(), StepError> {
        let reads = RefCell::new(Vec::new());
        let read = |parameter| {
            let mut reads = reads.borrow_mut();
            if !reads.contains(&parameter) {
                reads.push(parameter);
            }
        };
        let before = self.first + number.saturating_sub(1);
        self.method.hold(&mut self.prepared, 0, before, state)?;
        let system = self.method.system_in(&self.prepared);
        let zero = Field::zero::<DimsOf<I>>;
        let along = |direction: &Field<VectorOf<I::System>>, varied| {
            with_dual_state(system, state, direction, varied, &read, |state| {
                (self.loss)(number, state)
            })
        };
        let Some(loss) = along(&zero(), None)? else {
            return Ok(());
        };
        let (mut by_state, mut by_parameters) = (zero(), Vec::new());
        let slope = |dual: Option<Dual>| dual.map_or(f64::NAN, Dual::slope);
        for i in 0..ConfigurationOf::<I::System>::DEGREES_OF_FREEDOM {
            let [mut q, mut p] = [zero(), zero()];
            (q.q.as_mut()[i], p.p.as_mut()[i]) = (1.0, 1.0);
            by_state.q.as_mut()[i] = slope(along(&q, None)?);
            by_state.p.as_mut()[i] = slope(along(&p, None)?);
        }
        for &parameter in &*{ reads.borrow().clone() } {
            let slope = slope(along(&zero(), Some(parameter))?);
            by_parameters.push((parameter, slope));
        }
        let mut sum = loss.value() + self.value;
        self.value = sum;
        self.by_state.add_scaled(1.0, &by_state);
        let piece = self.range_of(number.saturating_sub(1));
        for (parameter, slope) in by_parameters {
            self.by_parameters[piece.start + parameter] += slope;
            sum += slope;
        }
        let [q, p] = [by_state.q.as_ref(), by_state.p.as_ref()];
        sum += q.iter().chain(p).sum::<f64>();
        if sum.is_finite() {
            Ok(())
        } else {
            let (t, value) = (state.t, loss.value());
            Err(StepError::NonFiniteLoss { value, t })
        }
    }

    /// Returns the places of the derivatives by the parameters in the piece of a step.
    fn range_of(&self, step: u64) -> Range<usize> {
        let (parameters, piece) = (I::System::PARAMETERS.len(), (step / self.piece) as usize);
        piece * parameters..(piece + 1) * parameters
    }
}
