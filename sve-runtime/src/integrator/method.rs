//! An integrator is a [`OneStepMethod`].

use core::any::type_name;
use core::hash::Hasher;

use super::Integrator;
use super::accept::check_step_size;
use crate::configuration::Coordinates;
use crate::error::StepError;
use crate::lanes::{Lane, Mask};
use crate::method::OneStepMethod;
use crate::plan::{Plan, StrongOrder, Substeps};
use crate::state::State;
use crate::system::{Dims, StateLanesOf, System};
use crate::variational::{Discretised, Memory};

/// What an integrator computes before the first step, and carries from step to step.
#[derive(Clone, Copy, Debug)]
pub struct Prepared<C, K> {
    /// Values that depend on parameters and step size only.
    coefficients: C,
    memory: K,
}

impl<C, K> Prepared<C, K> {
    /// The values that depend on parameters and step size only.
    pub(super) fn coefficients(&self) -> &C {
        &self.coefficients
    }
}

impl<S, R, Q, const N: usize, const M: usize> OneStepMethod for Integrator<S, R>
where
    S: Discretised<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    type System = S;
    type Increments = S::Increments;
    type Prepared = Prepared<S::Prepared, S::Memory>;

    fn system(&self) -> &S {
        Integrator::system(self)
    }

    #[inline]
    fn prepare(&self, h: f64) -> Result<Self::Prepared, StepError> {
        check_step_size(h)?;
        Ok(Prepared {
            coefficients: Integrator::system(self).prepare(h),
            memory: S::Memory::none(),
        })
    }

    #[inline]
    fn step_prepared(
        &self,
        prepared: &Self::Prepared,
        state: &mut State<Q>,
        h: f64,
        dw: &S::Increments,
    ) -> Result<(), StepError> {
        Q::in_coordinates(state, |state| {
            let (system, memory) = (Integrator::system(self), &mut S::Memory::none());
            system.advance(self.newton(), &prepared.coefficients, memory, state, h, dw)
        })
    }

    #[inline]
    fn stages(&self) -> usize {
        S::STAGES
    }

    // see `solve_step`
    #[inline(always)]
    fn next_step(
        &self,
        prepared: &mut Self::Prepared,
        state: &mut State<Q>,
        h: f64,
        dw: &S::Increments,
    ) -> Result<(), StepError> {
        Q::in_coordinates(state, |state| {
            let Prepared {
                coefficients,
                memory,
            } = prepared;
            Integrator::system(self).advance(self.newton(), coefficients, memory, state, h, dw)
        })
    }

    fn memory(&self, prepared: &Self::Prepared) -> Vec<f64> {
        prepared.memory.numbers().to_vec()
    }

    fn recall(&self, prepared: &mut Self::Prepared, numbers: &[f64]) -> bool {
        let memory = S::Memory::from_numbers(numbers);
        let is_valid = memory.is_some();
        prepared.memory = memory.unwrap_or(S::Memory::none());
        is_valid
    }

    #[inline(always)]
    fn step_lanes(
        &self,
        prepared: &Self::Prepared,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &[Lane; M],
    ) -> Mask {
        let prepared = &prepared.coefficients;
        Integrator::system(self).advance_lanes(self.newton(), prepared, states, next, h, dw)
    }

    fn has_compensated_step(&self) -> bool {
        S::HAS_INCREMENTS
    }

    #[inline]
    fn compensated_step(
        &self,
        prepared: &mut Self::Prepared,
        state: &mut State<Q>,
        low: &mut State<Q>,
        h: f64,
        dw: &S::Increments,
    ) -> Result<(), StepError> {
        let Prepared {
            coefficients,
            memory,
        } = prepared;
        Q::in_coordinates(state, |state| {
            Q::in_coordinates(low, |low| {
                let state = [state, low];
                Integrator::system(self).advance_compensated(
                    self.newton(),
                    coefficients,
                    memory,
                    state,
                    h,
                    dw,
                )
            })
        })
    }

    fn identify(&self, to: &mut dyn Hasher) {
        to.write(type_name::<R>().as_bytes());
        // the printed form of a number is the shortest one that reads back as the same number
        to.write(format!("{:?}", self.newton()).as_bytes());
    }

    fn describe(&self) -> String {
        let Plan { rule, substeps, .. } = self.plan();
        match substeps {
            None => (*rule).to_owned(),
            Some(Substeps { composition, count }) => {
                format!("{composition} of {rule}, {count} substeps")
            }
        }
    }

    fn order(&self) -> Option<f64> {
        let plan = self.plan();
        Some(match plan.strong_order {
            StrongOrder::Deterministic => f64::from(plan.deterministic_order),
            StrongOrder::One => 1.0,
            StrongOrder::OneAndAHalf => 1.5,
            StrongOrder::Two => 2.0,
            StrongOrder::Three => 3.0,
            StrongOrder::Half { .. } => 0.5,
        })
    }

    fn newton_iterations(
        &self,
        prepared: &Self::Prepared,
        state: &State<Q>,
        h: f64,
        dw: &S::Increments,
    ) -> Option<u32> {
        let (newton, state) = (self.newton(), &state.to_coordinates());
        Integrator::system(self).newton_iterations(newton, &prepared.coefficients, state, h, dw)
    }
}
