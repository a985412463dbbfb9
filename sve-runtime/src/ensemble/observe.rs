//! Functions of a state: closures over the system and a state, evaluated for all lanes of a tile.
//!
//! Input: the states of a tile. Output: a number for each lane, and the lanes whose numbers are not
//! finite. The loop over the lanes contains the closure and is compiled for the vectors of the
//! machine, so a closure without branches is vectorised.

use core::marker::PhantomData;

use super::systems::Systems;
use crate::error::StepError;
use crate::error::observed::Observed;
use crate::lanes::dispatch::{Kernel, dispatch};
use crate::lanes::{LANES, Lane, Mask};
use crate::system::{Dimensions, StateLanesOf, StateOf, System};

/// A function of a system and a state, with a closure of any type.
pub(super) trait Function<S: System>: Sync {
    /// Evaluates all lanes; NaN where the function fails.
    fn tile(&self, systems: &Systems<'_, S>, states: &StateLanesOf<S>, values: &mut Lane);
    /// Returns the value at a state.
    ///
    /// # Errors
    /// The error of the closure.
    fn value(&self, system: &S, state: &StateOf<S>) -> Result<f64, StepError>;
}

/// A function made of a closure that returns an `O`.
pub(super) struct Closure<F, O>(F, PhantomData<fn() -> O>);

impl<F, O> Closure<F, O> {
    pub(super) fn new(function: F) -> Self {
        Self(function, PhantomData)
    }
}

impl<S, F, O> Function<S> for Closure<F, O>
where
    S: System,
    F: Fn(&S, &StateOf<S>) -> O + Sync,
    O: Observed,
{
    fn tile(&self, systems: &Systems<'_, S>, states: &StateLanesOf<S>, values: &mut Lane) {
        dispatch(ObserveTile {
            function: self,
            systems,
            states,
            values,
        });
    }

    #[inline(always)]
    fn value(&self, system: &S, state: &StateOf<S>) -> Result<f64, StepError> {
        (self.0)(system, state).observed()
    }
}

/// The evaluation of a function in all lanes.
struct ObserveTile<'a, S: System, T> {
    function: &'a T,
    systems: &'a Systems<'a, S>,
    states: &'a StateLanesOf<S>,
    values: &'a mut Lane,
}

impl<S: System, T: Function<S>> Kernel for ObserveTile<'_, S, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.systems.each(
            #[inline(always)]
            |lane, system| {
                let state = <S::Dims as Dimensions>::get(self.states, lane);
                let value = self.function.value(system, &state);
                self.values[lane] = value.unwrap_or(f64::NAN);
            },
        );
    }
}

/// Returns the lanes whose values are not finite.
#[inline]
pub(super) fn not_finite(values: &Lane) -> Mask {
    let mut lanes = 0;
    for lane in 0..LANES {
        lanes |= Mask::from(!values[lane].is_finite()) << lane;
    }
    lanes
}

/// Returns the lanes whose values are outside of a range; both ends belong to the range.
#[inline]
pub(super) fn outside(values: &Lane, low: f64, high: f64) -> Mask {
    let mut lanes = 0;
    for lane in 0..LANES {
        lanes |= Mask::from(values[lane] < low || values[lane] > high) << lane;
    }
    lanes
}
