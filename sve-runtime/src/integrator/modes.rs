//! Common parts of all modes of a walk: how they treat the state in a sequence of substeps.
//!
//! Invariant: the time after a sequence is rounded once. A sequence that fails leaves its state at
//! the substep that failed: the integrator walks along a copy.

use core::convert::Infallible;
use core::mem::replace;

use crate::error::StepError;
use crate::lanes::{LANES, Mask};
use crate::phase::configuration::Coordinates;
use crate::phase::state::State;
use crate::rule::{Mode, Walker};
use crate::system::equations::StepEquations;
use crate::system::start::Tested;
use crate::system::{
    AnyIncrements, Dimensions, Dims, FlatStateOf, IncrementLanesOf, StateLanesOf, System,
};

/// A mode of walks from a single state.
pub(crate) trait SingleMode<S: System, I: ?Sized> {
    /// Makes a substep.
    ///
    /// # Errors
    /// A [`StepError`] if the substep fails; `state` is then unchanged.
    fn substep<R>(
        &mut self,
        walker: Walker<'_, S, R>,
        prepared: &Tested<S::Prepared>,
        memory: &mut S::Memory,
        state: &mut FlatStateOf<S>,
        h: f64,
        dw: &I,
    ) -> Result<(), StepError>
    where
        S: StepEquations<R, Increments = I>;
}

/// A state that moves with each substep, in a mode.
pub(super) struct Single<'a, F, K> {
    pub(super) state: &'a mut F,
    pub(super) mode: K,
}

impl<S, I, K, Q, const N: usize, const M: usize> Mode<S, I> for Single<'_, State<Q::Flat>, K>
where
    S: System<Dims = Dims<N, M, Q>>,
    I: AnyIncrements + ?Sized,
    K: SingleMode<S, I>,
    Q: Coordinates<N>,
{
    type Increments = I;
    type Part = I::Owned;
    type Failure = StepError;
    type Start = f64;

    #[inline(always)]
    fn substep<R>(
        &mut self,
        walker: Walker<'_, S, R>,
        prepared: &Tested<S::Prepared>,
        memory: &mut S::Memory,
        h: f64,
        dw: &I,
    ) -> Result<(), StepError>
    where
        S: StepEquations<R, Increments = I>,
    {
        (self.mode).substep(walker, prepared, memory, self.state, h, dw)
    }

    #[inline(always)]
    fn begin(&mut self) -> f64 {
        self.state.t
    }

    #[inline(always)]
    fn end(&mut self, t: f64, h: f64) {
        self.state.t = t + h;
    }

    #[inline(always)]
    fn part(dw: &I, part: f64) -> I::Owned {
        dw.times(part)
    }
}

/// A mode of walks from a state in each lane.
pub(super) trait LanesMode<S: System> {
    /// Makes a substep in each lane. Returns the mask of lanes that the fast path could not solve,
    /// whose states are copied unchanged. Times in `next` are not written.
    fn substep<R>(
        &mut self,
        walker: Walker<'_, S, R>,
        prepared: &Tested<S::Prepared>,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<S::Increments>,
    ) -> Mask
    where
        S: StepEquations<R>;
}

/// The states before a walk and after it.
pub(super) struct Lanes<'a, L, K> {
    states: &'a L,
    next: &'a mut L,
    mode: K,
    /// The lanes that a substep could not solve.
    unsolved: Mask,
    has_begun: bool,
    is_sequence: bool,
}

impl<'a, L: Copy, K> Lanes<'a, L, K> {
    #[inline(always)]
    pub(super) fn new(states: &'a L, next: &'a mut L, mode: K) -> Self {
        Self {
            states,
            next,
            mode,
            unsolved: 0,
            has_begun: false,
            is_sequence: false,
        }
    }

    /// Returns the mask of lanes that were not solved, and the mode.
    #[inline(always)]
    pub(super) fn finished(self) -> (Mask, K) {
        (self.unsolved, self.mode)
    }
}

/// A sequence of substeps in lanes that has begun.
pub(super) struct SequenceInLanes<L> {
    start: L,
    /// The sequence is no part of another sequence.
    is_whole: bool,
}

impl<S, I, K, Q, const N: usize, const M: usize> Mode<S, I> for Lanes<'_, StateLanesOf<S>, K>
where
    S: System<Dims = Dims<N, M, Q>>,
    I: AnyIncrements + ?Sized,
    K: LanesMode<S>,
    Q: Coordinates<N>,
{
    type Increments = IncrementLanesOf<I>;
    type Part = IncrementLanesOf<I>;
    type Failure = Infallible;
    type Start = SequenceInLanes<StateLanesOf<S>>;

    #[inline(always)]
    fn substep<R>(
        &mut self,
        walker: Walker<'_, S, R>,
        prepared: &Tested<S::Prepared>,
        _: &mut S::Memory,
        h: f64,
        dw: &IncrementLanesOf<I>,
    ) -> Result<(), Infallible>
    where
        S: StepEquations<R, Increments = I>,
    {
        let before;
        let states = if self.has_begun {
            before = *self.next;
            &before
        } else {
            self.states
        };
        self.unsolved |= (self.mode).substep(walker, prepared, states, self.next, h, dw);
        // A single step leaves the times to its caller.
        if self.is_sequence {
            set_times::<S>(self.next, states, h);
        }
        self.has_begun = true;
        Ok(())
    }

    #[inline(always)]
    fn begin(&mut self) -> SequenceInLanes<StateLanesOf<S>> {
        SequenceInLanes {
            start: if self.has_begun {
                *self.next
            } else {
                *self.states
            },
            is_whole: !replace(&mut self.is_sequence, true),
        }
    }

    #[inline(always)]
    fn end(&mut self, sequence: SequenceInLanes<StateLanesOf<S>>, h: f64) {
        let SequenceInLanes { start, is_whole } = sequence;
        set_times::<S>(self.next, &start, h);
        if is_whole {
            for lane in (0..LANES).filter(|lane| self.unsolved >> lane & 1 == 1) {
                S::Dims::set(self.next, lane, &S::Dims::get(self.states, lane));
            }
        }
    }

    #[inline(always)]
    fn part(dw: &IncrementLanesOf<I>, part: f64) -> IncrementLanesOf<I> {
        let mut dw = *dw;
        for w in dw.as_mut().as_flattened_mut() {
            *w *= part;
        }
        dw
    }
}

/// Sets the times a substep later than the times of `start`.
#[inline(always)]
fn set_times<S: System>(next: &mut StateLanesOf<S>, start: &StateLanesOf<S>, h: f64) {
    let mut start = *start;
    let times = S::Dims::times(next).iter_mut();
    for (t, start) in times.zip(S::Dims::times(&mut start)) {
        *t = *start + h;
    }
}
