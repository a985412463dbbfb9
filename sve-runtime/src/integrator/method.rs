//! An integrator is a [`OneStepMethod`]: the kind of its system makes the steps.

use core::any::type_name;
use core::hash::Hasher;

use super::Integrator;
use super::accept::check_step_size;
use super::steps::Steps;
use crate::error::StepError;
use crate::lanes::Mask;
use crate::method::OneStepMethod;
use crate::rule::{Rule, Walker};
use crate::system::plan::{Plan, StrongOrder, Substeps};
use crate::system::{AnySystem, IncrementLanesOf, StateLanesOf, StateOf};

impl<S: AnySystem, R: Rule<S::Target>> Integrator<S, R> {
    /// Returns the walker over the substeps of a step.
    #[inline(always)]
    pub(super) fn walker(&self) -> Walker<'_, S::Target, R> {
        Walker::new(self.system().target(), self.newton())
    }
}

impl<S, R> OneStepMethod for Integrator<S, R>
where
    S: AnySystem,
    S::Kind: Steps<S::Target, R>,
    R: Rule<S::Target>,
{
    type System = S;
    type Increments = R::Increments;
    type Prepared = <S::Kind as Steps<S::Target, R>>::Prepared;

    fn system(&self) -> &S {
        Integrator::system(self)
    }

    #[inline]
    fn prepare(&self, h: f64) -> Result<Self::Prepared, StepError> {
        check_step_size(h)?;
        Ok(S::Kind::prepare(self.walker(), &self.cache, h))
    }

    #[inline]
    fn step_prepared(
        &self,
        prepared: &Self::Prepared,
        state: &mut StateOf<S>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError> {
        S::Kind::step(self.walker(), &self.cache, prepared, state, h, dw)
    }

    #[inline]
    fn stages(&self) -> usize {
        R::STAGES
    }

    #[inline(always)]
    fn next_step(
        &self,
        prepared: &mut Self::Prepared,
        state: &mut StateOf<S>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError> {
        S::Kind::next_step(self.walker(), &self.cache, prepared, state, h, dw)
    }

    #[inline(always)]
    fn next_steps(
        &self,
        prepared: &mut Self::Prepared,
        state: &mut StateOf<S>,
        h: f64,
        dw: &mut R::Increments,
        count: u64,
        draw: &mut dyn FnMut(u64, &mut R::Increments) -> Option<f64>,
    ) -> u64 {
        let (walker, cache) = (self.walker(), &self.cache);
        S::Kind::next_steps(walker, cache, prepared, state, h, dw, count, draw)
    }

    #[inline(always)]
    fn processes(&self, state: &StateOf<S>) -> Result<usize, StepError> {
        S::Kind::processes(self.walker(), &self.cache, state)
    }

    fn memory(&self, prepared: &Self::Prepared) -> Vec<f64> {
        S::Kind::memory(prepared)
    }

    fn recall(&self, prepared: &mut Self::Prepared, numbers: &[f64]) -> bool {
        S::Kind::recall(prepared, numbers)
    }

    #[inline(always)]
    fn step_lanes(
        &self,
        prepared: &Self::Prepared,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<R::Increments>,
    ) -> Mask {
        S::Kind::step_lanes(self.walker(), prepared, states, next, h, dw)
    }

    fn has_compensated_step(&self) -> bool {
        R::HAS_INCREMENTS
    }

    #[inline]
    fn compensated_step(
        &self,
        prepared: &mut Self::Prepared,
        state: &mut StateOf<S>,
        low: &mut StateOf<S>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError> {
        S::Kind::compensated_step(self.walker(), prepared, state, low, h, dw)
    }

    fn identify(&self, to: &mut dyn Hasher) {
        to.write(type_name::<R>().as_bytes());
        // The printed form of a number is the shortest decimal number that reads back as the same
        // number.
        to.write(format!("{:?}", self.newton()).as_bytes());
    }

    fn describe(&self) -> String {
        let Plan { rule, substeps, .. } = R::PLAN;
        match substeps {
            None => (*rule).to_owned(),
            Some(Substeps { composition, count }) => {
                format!("{composition} of {rule}, {count} substeps")
            }
        }
    }

    fn order(&self) -> Option<f64> {
        let plan = R::PLAN;
        Some(match plan.strong_order {
            StrongOrder::Deterministic => f64::from(plan.deterministic_order),
            StrongOrder::One => 1.0,
            StrongOrder::OneAndAHalf => 1.5,
            StrongOrder::Two => 2.0,
            StrongOrder::TwoAndAHalf => 2.5,
            StrongOrder::Three => 3.0,
            StrongOrder::Half { .. } => 0.5,
        })
    }

    fn newton_iterations(
        &self,
        prepared: &Self::Prepared,
        state: &StateOf<S>,
        h: f64,
        dw: &R::Increments,
    ) -> Option<u32> {
        S::Kind::newton_iterations(self.walker(), prepared, state, h, dw)
    }
}
