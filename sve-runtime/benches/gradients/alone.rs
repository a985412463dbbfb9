//! A method that carries tangent vectors along one state after the other.

use sve_runtime::__private::lane::{LaneDirections, TangentLanesOf};
use sve_runtime::__private::{Covector, Directions};
use sve_runtime::__private::{
    Differentiable, IncrementLanesOf, LANES, Mask, StateLanesOf, VectorOf,
};
use sve_runtime::system::StateOf;
use sve_runtime::{OneStepMethod, StepError};

/// The steps of a method, in lanes, with tangent vectors of single states.
#[derive(Debug)]
pub(crate) struct Alone<I>(pub(crate) I);

impl<I: OneStepMethod> OneStepMethod for Alone<I> {
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

    #[inline(always)]
    fn step_lanes(
        &self,
        prepared: &I::Prepared,
        states: &StateLanesOf<I::System>,
        next: &mut StateLanesOf<I::System>,
        h: f64,
        dw: &IncrementLanesOf<I::Increments>,
    ) -> Mask {
        self.0.step_lanes(prepared, states, next, h, dw)
    }
}

impl<I: Differentiable> Differentiable for Alone<I> {
    #[inline]
    fn push_forward(
        &self,
        prepared: &I::Prepared,
        state: &mut StateOf<I::System>,
        h: f64,
        dw: &I::Increments,
        directions: Directions<'_, VectorOf<I::System>>,
    ) -> Result<(), StepError> {
        self.0.push_forward(prepared, state, h, dw, directions)
    }

    #[inline(always)]
    fn push_forward_lanes(
        &self,
        prepared: &I::Prepared,
        states: &StateLanesOf<I::System>,
        next: &mut StateLanesOf<I::System>,
        h: f64,
        dw: &IncrementLanesOf<I::Increments>,
        _: LaneDirections<'_, TangentLanesOf<I::System>>,
    ) -> [Mask; 2] {
        let unsolved = self.0.step_lanes(prepared, states, next, h, dw);
        [unsolved, Mask::MAX >> (Mask::BITS as usize - LANES)]
    }

    #[inline]
    fn pull_back(
        &self,
        prepared: &I::Prepared,
        state: &StateOf<I::System>,
        h: f64,
        dw: &I::Increments,
        covector: Covector<'_, VectorOf<I::System>>,
    ) -> Result<(), StepError> {
        self.0.pull_back(prepared, state, h, dw, covector)
    }
}
