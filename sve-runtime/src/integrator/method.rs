//! An integrator is a [`OneStepMethod`]: each of its functions is a walk over the substeps of the
//! rule in a mode.

use core::any::type_name;
use core::hash::Hasher;

use super::Integrator;
use super::accept::check_step_size;
use super::compensated::Compensate;
use super::modes::{Lanes, LanesMode, Single, SingleMode};
use super::start::AdvanceLanes;
use super::step::{Advance, Count};
use crate::error::StepError;
use crate::lanes::Mask;
use crate::method::OneStepMethod;
use crate::phase::configuration::Coordinates;
use crate::phase::state::State;
use crate::rule::{Rule, Walker};
use crate::system::equations::Memory;
use crate::system::plan::{Plan, StrongOrder, Substeps};
use crate::system::{Dims, IncrementLanesOf, StateLanesOf, System};

/// The values that an integrator computes before the first step, and carries from step to step.
#[derive(Clone, Copy, Debug)]
pub struct Prepared<C, K> {
    /// Values that depend on parameters and step size only.
    coefficients: C,
    memory: K,
}

impl<C, K> Prepared<C, K> {
    /// Returns the values that depend on parameters and step size only.
    pub(super) fn coefficients(&self) -> &C {
        &self.coefficients
    }
}

impl<S, R, Q, const N: usize, const M: usize> Integrator<S, R>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
    Q: Coordinates<N>,
{
    /// Returns the walker over the substeps of a step.
    #[inline(always)]
    pub(super) fn walker(&self) -> Walker<'_, S::Itself, R> {
        Walker::new(self.system().itself(), self.newton())
    }

    /// Makes one step from a state in a mode, and carries nothing. Returns the mode.
    ///
    /// # Errors
    /// A [`StepError`] if the step fails; `state` is then unchanged.
    #[inline(always)]
    pub(crate) fn walk_from<K: SingleMode<S::Itself, R::Increments>>(
        &self,
        prepared: &Prepared<R::Prepared, R::Memory>,
        state: &mut State<Q::Flat>,
        h: f64,
        dw: &R::Increments,
        mode: K,
    ) -> Result<K, StepError> {
        let (prepared, memory) = (&prepared.coefficients, &mut R::Memory::none());
        Self::moved(state, |state| {
            let mut single = Single { state, mode };
            R::walk(self.walker(), prepared, memory, h, dw, &mut single)?;
            Ok(single.mode)
        })
    }

    /// Makes one step from a state in a mode, with the numbers that the step before left in
    /// `prepared`.
    ///
    /// # Errors
    /// As [`walk_from`](Self::walk_from).
    #[inline(always)]
    fn walk_on(
        &self,
        prepared: &mut Prepared<R::Prepared, R::Memory>,
        state: &mut State<Q::Flat>,
        h: f64,
        dw: &R::Increments,
        mode: impl SingleMode<S::Itself, R::Increments>,
    ) -> Result<(), StepError> {
        let Prepared {
            coefficients,
            memory,
        } = prepared;
        Self::moved(state, |state| {
            let mut single = Single { state, mode };
            R::walk(self.walker(), coefficients, memory, h, dw, &mut single)
        })
    }

    /// Changes a state by a walk, which works on a copy if a later substep may fail.
    #[inline(always)]
    fn moved<F: Copy, T>(
        state: &mut F,
        walk: impl FnOnce(&mut F) -> Result<T, StepError>,
    ) -> Result<T, StepError> {
        if const { R::SUBSTEPS == 1 } {
            return walk(state);
        }
        let mut end = *state;
        let made = walk(&mut end)?;
        *state = end;
        Ok(made)
    }

    /// Makes one step in lanes in a mode. Returns the mask of lanes that were not solved, and the
    /// mode.
    #[inline(always)]
    pub(super) fn walk_in_lanes<K: LanesMode<S::Itself>>(
        &self,
        prepared: &Prepared<R::Prepared, R::Memory>,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<S>,
        mode: K,
    ) -> (Mask, K) {
        let (prepared, memory) = (&prepared.coefficients, &mut R::Memory::none());
        let mut lanes = Lanes::new(states, next, mode);
        let Ok(()) = R::walk(self.walker(), prepared, memory, h, dw, &mut lanes);
        lanes.finished()
    }
}

impl<S, R, Q, const N: usize, const M: usize> OneStepMethod for Integrator<S, R>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
    Q: Coordinates<N>,
{
    type System = S;
    type Increments = R::Increments;
    type Prepared = Prepared<R::Prepared, R::Memory>;

    fn system(&self) -> &S {
        Integrator::system(self)
    }

    #[inline]
    fn prepare(&self, h: f64) -> Result<Self::Prepared, StepError> {
        check_step_size(h)?;
        Ok(Prepared {
            coefficients: R::prepare(Integrator::system(self).itself(), h),
            memory: R::Memory::none(),
        })
    }

    #[inline]
    fn step_prepared(
        &self,
        prepared: &Self::Prepared,
        state: &mut State<Q>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError> {
        Q::in_coordinates(state, |state| {
            self.walk_from(prepared, state, h, dw, Advance).map(|_| ())
        })
    }

    #[inline]
    fn stages(&self) -> usize {
        R::STAGES
    }

    // Always inlined, for the reason given at `solve_step`.
    #[inline(always)]
    fn next_step(
        &self,
        prepared: &mut Self::Prepared,
        state: &mut State<Q>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError> {
        Q::in_coordinates(state, |state| self.walk_on(prepared, state, h, dw, Advance))
    }

    fn memory(&self, prepared: &Self::Prepared) -> Vec<f64> {
        prepared.memory.numbers().to_vec()
    }

    fn recall(&self, prepared: &mut Self::Prepared, numbers: &[f64]) -> bool {
        let memory = R::Memory::from_numbers(numbers);
        let is_valid = memory.is_some();
        prepared.memory = memory.unwrap_or(R::Memory::none());
        is_valid
    }

    #[inline(always)]
    fn step_lanes(
        &self,
        prepared: &Self::Prepared,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<S>,
    ) -> Mask {
        let (unsolved, _) = self.walk_in_lanes(prepared, states, next, h, dw, AdvanceLanes);
        unsolved
    }

    fn has_compensated_step(&self) -> bool {
        R::HAS_INCREMENTS
    }

    #[inline]
    fn compensated_step(
        &self,
        prepared: &mut Self::Prepared,
        state: &mut State<Q>,
        low: &mut State<Q>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError> {
        Q::in_coordinates(state, |state| {
            Q::in_coordinates(low, |low| {
                Self::moved(low, |low| {
                    self.walk_on(prepared, state, h, dw, Compensate { low })
                })
            })
        })
    }

    fn identify(&self, to: &mut dyn Hasher) {
        to.write(type_name::<R>().as_bytes());
        // The printed form of a number is the shortest decimal number that reads back as the same
        // number.
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
        dw: &R::Increments,
    ) -> Option<u32> {
        let (state, mode) = (&mut state.to_coordinates(), Count { most: 0 });
        let walk = self.walk_from(prepared, state, h, dw, mode);
        walk.ok().map(|mode| mode.most)
    }
}
