//! How an integrator makes steps, by the kind of its system.
//!
//! Input: a system, a rule and a state. Output: the state after one step or several. A kind of
//! systems implements [`Steps`] for all its systems and rules; here, systems of fixed sizes, whose
//! steps are walks in the modes of this folder.

use super::compensated::Compensate;
use super::modes::{Lanes, LanesMode, Single, SingleMode};
use super::start::AdvanceLanes;
use super::step::{Advance, Count};
use crate::error::StepError;
use crate::lanes::{ALL, Mask};
use crate::phase::configuration::Coordinates;
use crate::phase::state::State;
use crate::rule::{Rule, Walker};
use crate::system::equations::Memory;
use crate::system::{
    AnySystem, Dims, FixedSizes, IncrementLanesOf, Kind, StateLanesOf, StateOf, System,
};

/// How an integrator makes the steps of a rule for systems of a kind.
///
/// The functions are those of [`OneStepMethod`](crate::OneStepMethod), of systems behind all
/// references. `cache` belongs to the integrator, and is empty for a changed system.
#[doc(hidden)]
pub trait Steps<S: AnySystem, R: Rule<S>>: Kind {
    /// Values that depend on parameters and step size only, and the numbers that a trajectory
    /// carries from step to step.
    type Prepared: Clone;

    /// Computes the values that depend on the step size, which is finite and not zero.
    fn prepare(walker: Walker<'_, S, R>, cache: &Self::Cache, h: f64) -> Self::Prepared;

    /// Makes one step.
    ///
    /// # Errors
    /// A [`StepError`] if the step fails.
    fn step(
        walker: Walker<'_, S, R>,
        cache: &Self::Cache,
        prepared: &Self::Prepared,
        state: &mut StateOf<S>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError>;

    /// Makes the next step of a trajectory.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    fn next_step(
        walker: Walker<'_, S, R>,
        cache: &Self::Cache,
        prepared: &mut Self::Prepared,
        state: &mut StateOf<S>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError>;

    /// Makes up to `count` steps of a trajectory at once; see
    /// [`OneStepMethod::next_steps`](crate::OneStepMethod::next_steps).
    #[allow(clippy::too_many_arguments)] // those of the next step, and of several
    #[inline(always)]
    fn next_steps(
        walker: Walker<'_, S, R>,
        cache: &Self::Cache,
        prepared: &mut Self::Prepared,
        state: &mut StateOf<S>,
        h: f64,
        dw: &mut R::Increments,
        count: u64,
        draw: &mut dyn FnMut(u64, &mut R::Increments) -> Option<f64>,
    ) -> u64 {
        let _ = (walker, cache, prepared, state, h, dw, count, draw);
        0
    }

    /// Returns the number of increments of a step, if they are a slice.
    ///
    /// # Errors
    /// A [`StepError`] if the number cannot be computed.
    fn processes(
        walker: Walker<'_, S, R>,
        cache: &Self::Cache,
        state: &StateOf<S>,
    ) -> Result<usize, StepError> {
        let _ = (walker, cache, state);
        Ok(0)
    }

    /// Returns the numbers that a trajectory carries from step to step.
    fn memory(prepared: &Self::Prepared) -> Vec<f64> {
        let _ = prepared;
        Vec::new()
    }

    /// Replaces the numbers that a trajectory carries. Returns whether their count is right.
    fn recall(prepared: &mut Self::Prepared, numbers: &[f64]) -> bool {
        let _ = prepared;
        numbers.is_empty()
    }

    /// Advances every lane. Returns the mask of lanes that were not solved.
    #[inline(always)]
    fn step_lanes(
        walker: Walker<'_, S, R>,
        prepared: &Self::Prepared,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<R::Increments>,
    ) -> Mask {
        let _ = (walker, prepared, h, dw);
        next.clone_from(states);
        ALL
    }

    /// Makes one step that adds the low parts of the state, and writes its rounding errors to them.
    ///
    /// # Errors
    /// As [`step`](Self::step); [`StepError::Uncompensated`] if there are no such steps.
    fn compensated_step(
        walker: Walker<'_, S, R>,
        prepared: &mut Self::Prepared,
        state: &mut StateOf<S>,
        low: &mut StateOf<S>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError> {
        let _ = (walker, prepared, low, h, dw);
        Err(StepError::Uncompensated { t: state.t })
    }

    /// Returns the largest number of Newton iterations of a block in a step.
    fn newton_iterations(
        walker: Walker<'_, S, R>,
        prepared: &Self::Prepared,
        state: &StateOf<S>,
        h: f64,
        dw: &R::Increments,
    ) -> Option<u32> {
        let _ = (walker, prepared, state, h, dw);
        None
    }
}

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

impl<S, R, Q, const N: usize, const M: usize> Steps<S, R> for FixedSizes
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S>,
    Q: Coordinates<N>,
{
    type Prepared = Prepared<R::Prepared, R::Memory>;

    #[inline(always)]
    fn prepare(walker: Walker<'_, S, R>, (): &(), h: f64) -> Self::Prepared {
        Prepared {
            coefficients: R::prepare(walker.system, h),
            memory: R::Memory::none(),
        }
    }

    #[inline(always)]
    fn step(
        walker: Walker<'_, S, R>,
        (): &(),
        prepared: &Self::Prepared,
        state: &mut State<Q>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError> {
        Q::in_coordinates(state, |state| {
            walk_from(walker, prepared, state, h, dw, Advance).map(|_| ())
        })
    }

    // Always inlined, for the reason given at `solve_step`.
    #[inline(always)]
    fn next_step(
        walker: Walker<'_, S, R>,
        (): &(),
        prepared: &mut Self::Prepared,
        state: &mut State<Q>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError> {
        Q::in_coordinates(state, |state| {
            walk_on(walker, prepared, state, h, dw, Advance)
        })
    }

    fn memory(prepared: &Self::Prepared) -> Vec<f64> {
        prepared.memory.numbers().to_vec()
    }

    fn recall(prepared: &mut Self::Prepared, numbers: &[f64]) -> bool {
        let memory = R::Memory::from_numbers(numbers);
        let is_valid = memory.is_some();
        prepared.memory = memory.unwrap_or(R::Memory::none());
        is_valid
    }

    #[inline(always)]
    fn step_lanes(
        walker: Walker<'_, S, R>,
        prepared: &Self::Prepared,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<R::Increments>,
    ) -> Mask {
        let (unsolved, _) = walk_in_lanes(walker, prepared, states, next, h, dw, AdvanceLanes);
        unsolved
    }

    #[inline(always)]
    fn compensated_step(
        walker: Walker<'_, S, R>,
        prepared: &mut Self::Prepared,
        state: &mut State<Q>,
        low: &mut State<Q>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError> {
        Q::in_coordinates(state, |state| {
            Q::in_coordinates(low, |low| {
                moved::<S, R, _, _>(low, |low| {
                    walk_on(walker, prepared, state, h, dw, Compensate { low })
                })
            })
        })
    }

    fn newton_iterations(
        walker: Walker<'_, S, R>,
        prepared: &Self::Prepared,
        state: &State<Q>,
        h: f64,
        dw: &R::Increments,
    ) -> Option<u32> {
        let (state, mode) = (&mut state.to_coordinates(), Count { most: 0 });
        let walk = walk_from(walker, prepared, state, h, dw, mode);
        walk.ok().map(|mode| mode.most)
    }
}

/// Makes one step from a state in a mode, and carries nothing. Returns the mode.
///
/// # Errors
/// A [`StepError`] if the step fails; `state` is then unchanged.
#[inline(always)]
pub(super) fn walk_from<S, R, Q, K, const N: usize, const M: usize>(
    walker: Walker<'_, S, R>,
    prepared: &Prepared<R::Prepared, R::Memory>,
    state: &mut State<Q::Flat>,
    h: f64,
    dw: &R::Increments,
    mode: K,
) -> Result<K, StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S>,
    Q: Coordinates<N>,
    K: SingleMode<S, R::Increments>,
{
    let (prepared, memory) = (&prepared.coefficients, &mut R::Memory::none());
    moved::<S, R, _, _>(state, |state| {
        let mut single = Single { state, mode };
        R::walk(walker, prepared, memory, h, dw, &mut single)?;
        Ok(single.mode)
    })
}

/// Makes one step from a state in a mode, with the numbers that the step before left in `prepared`.
///
/// # Errors
/// As [`walk_from`].
#[inline(always)]
pub(super) fn walk_on<S, R, Q, const N: usize, const M: usize>(
    walker: Walker<'_, S, R>,
    prepared: &mut Prepared<R::Prepared, R::Memory>,
    state: &mut State<Q::Flat>,
    h: f64,
    dw: &R::Increments,
    mode: impl SingleMode<S, R::Increments>,
) -> Result<(), StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S>,
    Q: Coordinates<N>,
{
    let Prepared {
        coefficients,
        memory,
    } = prepared;
    moved::<S, R, _, _>(state, |state| {
        let mut single = Single { state, mode };
        R::walk(walker, coefficients, memory, h, dw, &mut single)
    })
}

/// Changes a state by a walk, which works on a copy if a later substep may fail.
#[inline(always)]
fn moved<S, R: Rule<S>, F: Copy, T>(
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

/// Makes one step in lanes in a mode. Returns the mask of lanes that were not solved, and the mode.
#[inline(always)]
pub(super) fn walk_in_lanes<S, R, Q, K, const N: usize, const M: usize>(
    walker: Walker<'_, S, R>,
    prepared: &Prepared<R::Prepared, R::Memory>,
    states: &StateLanesOf<S>,
    next: &mut StateLanesOf<S>,
    h: f64,
    dw: &IncrementLanesOf<R::Increments>,
    mode: K,
) -> (Mask, K)
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S>,
    Q: Coordinates<N>,
    K: LanesMode<S>,
{
    let (prepared, memory) = (&prepared.coefficients, &mut R::Memory::none());
    let mut lanes = Lanes::new(states, next, mode);
    let Ok(()) = R::walk(walker, prepared, memory, h, dw, &mut lanes);
    lanes.finished()
}
