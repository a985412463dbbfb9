//! Methods for a study: one whose trajectories compensate the rounding errors of the state, and one
//! whose iterations are not counted.

use core::hash::Hasher;

use sve_runtime::OneStepMethod;
use sve_runtime::prelude::*;
use sve_runtime::system::{StateOf, System};

/// A method with compensated sums: the same as `trajectory(…).compensated()`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Compensated<I, Z> {
    method: I,
    /// The state zero: the low parts before the first step.
    zero: Z,
}

impl<I: OneStepMethod> Compensated<I, StateOf<I::System>> {
    pub(crate) fn new(method: I, zero: StateOf<I::System>) -> Self {
        Self { method, zero }
    }
}

impl<I> OneStepMethod for Compensated<I, StateOf<I::System>>
where
    I: OneStepMethod,
    I::System: System,
    StateOf<I::System>: Copy,
{
    type System = I::System;
    type Increments = I::Increments;
    /// The values that the method prepares, and the low parts of the state.
    type Prepared = (I::Prepared, StateOf<I::System>);

    fn system(&self) -> &I::System {
        self.method.system()
    }

    fn prepare(&self, h: f64) -> Result<Self::Prepared, StepError> {
        Ok((self.method.prepare(h)?, self.zero))
    }

    fn step_prepared(
        &self,
        prepared: &Self::Prepared,
        state: &mut StateOf<I::System>,
        h: f64,
        dw: &I::Increments,
    ) -> Result<(), StepError> {
        self.method.step_prepared(&prepared.0, state, h, dw)
    }

    #[inline]
    fn next_step(
        &self,
        (prepared, low): &mut Self::Prepared,
        state: &mut StateOf<I::System>,
        h: f64,
        dw: &I::Increments,
    ) -> Result<(), StepError> {
        self.method.compensated_step(prepared, state, low, h, dw)
    }

    fn identify(&self, to: &mut dyn Hasher) {
        to.write(b"compensated");
        self.method.identify(to);
    }

    fn order(&self) -> Option<f64> {
        self.method.order()
    }
}

/// A method whose iterations are not counted: a Gauss rule with many unknowns is solved by
/// fixed-point iteration in a trajectory, and counting the iterations of Newton's method from a
/// cold start takes longer than all measurements.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Uncounted<I>(pub(crate) I);

impl<I: OneStepMethod> OneStepMethod for Uncounted<I> {
    type System = I::System;
    type Increments = I::Increments;
    type Prepared = I::Prepared;

    fn system(&self) -> &I::System {
        self.0.system()
    }

    fn prepare(&self, h: f64) -> Result<I::Prepared, StepError> {
        self.0.prepare(h)
    }

    fn step_prepared(
        &self,
        prepared: &I::Prepared,
        state: &mut StateOf<I::System>,
        h: f64,
        dw: &I::Increments,
    ) -> Result<(), StepError> {
        self.0.step_prepared(prepared, state, h, dw)
    }

    #[inline]
    fn next_step(
        &self,
        prepared: &mut I::Prepared,
        state: &mut StateOf<I::System>,
        h: f64,
        dw: &I::Increments,
    ) -> Result<(), StepError> {
        self.0.next_step(prepared, state, h, dw)
    }

    fn identify(&self, to: &mut dyn Hasher) {
        self.0.identify(to);
    }

    fn order(&self) -> Option<f64> {
        self.0.order()
    }
}
