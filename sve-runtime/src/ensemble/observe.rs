//! What is observed of a path: closures over the system and a state, evaluated for a tile at once.
//!
//! Input: a tile of states. Output: a number each, and which of them are not finite. The loop over the lanes is compiled
//! with the closure in it, for the vectors of the machine, so a closure without branches is vectorised.

use core::marker::PhantomData;

use crate::error::StepError;
use crate::lanes::dispatch::{Kernel, dispatch};
use crate::lanes::{LANES, Lane, Mask};
use crate::system::{Dimensions, StateLanesOf, StateOf, System};

/// What an observable may return: a number, or a number unless it fails.
#[diagnostic::on_unimplemented(
    message = "an observable returns `f64` or `Result<f64, StepError>`, not `{Self}`",
    label = "the closure of this observable has another result",
    note = "end it with a number, or with what `system.hamiltonian(state)` returns"
)]
pub trait Observed {
    /// The value, or why there is none.
    ///
    /// # Errors
    /// As the observable says.
    fn observed(self) -> Result<f64, StepError>;
}

impl Observed for f64 {
    #[inline(always)]
    fn observed(self) -> Result<f64, StepError> {
        Ok(self)
    }
}

impl Observed for Result<f64, StepError> {
    #[inline(always)]
    fn observed(self) -> Result<f64, StepError> {
        self
    }
}

/// An observable of a system, whatever its closure.
pub(super) trait Observable<S: System>: Sync {
    /// Its values in all lanes; NaN where it fails.
    fn tile(&self, system: &S, states: &StateLanesOf<S>, values: &mut Lane);
    /// Its value at a state.
    ///
    /// # Errors
    /// As the closure says.
    fn value(&self, system: &S, state: &StateOf<S>) -> Result<f64, StepError>;
}

/// An observable made of a closure that returns an `O`.
pub(super) struct Closure<F, O>(F, PhantomData<fn() -> O>);

impl<F, O> Closure<F, O> {
    pub(super) fn new(observable: F) -> Self {
        Self(observable, PhantomData)
    }
}

impl<S, F, O> Observable<S> for Closure<F, O>
where
    S: System,
    F: Fn(&S, &StateOf<S>) -> O + Sync,
    O: Observed,
{
    fn tile(&self, system: &S, states: &StateLanesOf<S>, values: &mut Lane) {
        dispatch(Tile {
            observable: self,
            system,
            states,
            values,
        });
    }

    #[inline(always)]
    fn value(&self, system: &S, state: &StateOf<S>) -> Result<f64, StepError> {
        (self.0)(system, state).observed()
    }
}

struct Tile<'a, S: System, T> {
    observable: &'a T,
    system: &'a S,
    states: &'a StateLanesOf<S>,
    values: &'a mut Lane,
}

impl<S: System, T: Observable<S>> Kernel for Tile<'_, S, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for lane in 0..LANES {
            let state = <S::Dims as Dimensions>::get(self.states, lane);
            let value = self.observable.value(self.system, &state);
            self.values[lane] = value.unwrap_or(f64::NAN);
        }
    }
}

/// The lanes whose values are not finite.
#[inline]
pub(super) fn not_finite(values: &Lane) -> Mask {
    let mut lanes = 0;
    for lane in 0..LANES {
        lanes |= Mask::from(!values[lane].is_finite()) << lane;
    }
    lanes
}

/// The lanes whose values are outside of a range, both of whose bounds are inside.
#[inline]
pub(super) fn outside(values: &Lane, low: f64, high: f64) -> Mask {
    let mut lanes = 0;
    for lane in 0..LANES {
        lanes |= Mask::from(values[lane] < low || values[lane] > high) << lane;
    }
    lanes
}
