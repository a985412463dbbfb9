//! The first zero of a function within a step.
//!
//! Input: the state before a step, its increments, and the path of the noise within the step; the function has different signs at both ends. Output: the
//! state at the zero. Invariant: the result is a function of these inputs.
//!
//! The step is halved on the same path of the noise, towards the earlier half in which the sign changes. Within the last part the function is taken as linear and
//! so is the path, so for a smooth motion the zero is off by 2⁻²⁴ of the square of the step, times the second derivative over the first.

use crate::error::StepError;
use crate::method::Method;
use crate::noise::{DyadicInterval, Halves};
use crate::system::{Increments, IncrementsOf, StateOf};
use crate::time::is_next_time;

use super::super::memory::crosses;
use super::super::observe::Observable;

/// Number of halvings of a step. Each costs a scalar step and four random words a process.
const HALVINGS: u32 = 12;

/// A step within which a function has different signs.
pub(super) struct Crossing<'a, I: Method> {
    pub(super) method: &'a I,
    pub(super) noise: &'a dyn Halves,
    /// The number of the step.
    pub(super) step: u64,
    pub(super) h: f64,
    /// The state before the step.
    pub(super) before: StateOf<I::System>,
    /// The increments over the step.
    pub(super) whole: IncrementsOf<I::System>,
}

/// A zero within a step.
pub(super) struct Zero<T> {
    /// The part of the step before it.
    pub(super) fraction: f64,
    pub(super) state: T,
}

impl<I: Method> Crossing<'_, I> {
    /// Finds the first zero of function `number`, with these values before and after the step.
    pub(super) fn first_zero(
        &self,
        number: usize,
        function: &dyn Observable<I::System>,
        [before, after]: [f64; 2],
    ) -> Result<Zero<StateOf<I::System>>, StepError> {
        let (mut low, mut width) = (0.0, 1.0);
        let (mut at_low, mut at_high) = (before, after);
        let mut sum = IncrementsOf::<I::System>::NONE;
        let (mut part, mut interval) = (self.whole, DyadicInterval::whole(self.step));
        for _ in 0..HALVINGS {
            let Some([first, second]) = interval.halves() else {
                break;
            };
            let (mut left, mut right) = (part, part);
            let length = width * self.h;
            let (to_left, to_right) = (left.as_mut(), right.as_mut());
            (self.noise).halves_of(interval, length, part.as_ref(), to_left, to_right);
            width *= 0.5;
            let middle = added(&sum, 1.0, &left);
            let state = self.state_at(low + width, &middle)?;
            let value = function.value(self.method.system(), &state)?;
            if !value.is_finite() {
                let t = state.t;
                return Err(StepError::EventFunction { t, number, value });
            }
            if crosses(before, value) {
                at_high = value;
                (interval, part) = (first, left);
            } else {
                (low, at_low, sum) = (low + width, value, middle);
                (interval, part) = (second, right);
            }
        }
        let within = at_low / (at_low - at_high);
        let fraction = within.mul_add(width, low);
        let state = self.state_at(fraction, &added(&sum, within, &part))?;
        Ok(Zero { fraction, state })
    }

    /// Makes a part of the step with its increments.
    fn state_at(
        &self,
        fraction: f64,
        dw: &IncrementsOf<I::System>,
    ) -> Result<StateOf<I::System>, StepError> {
        let mut state = self.before;
        let h = fraction * self.h;
        let t = fraction.mul_add(self.h, state.t);
        // A part that is too short to change the time changes nothing else.
        if h != 0.0 && is_next_time(state.t, state.t + h) {
            let prepared = self.method.prepare(h)?;
            self.method.step_prepared(&prepared, &mut state, h, dw)?;
        }
        state.t = t;
        Ok(state)
    }
}

/// Returns increments plus a multiple of others.
fn added<D: Increments>(sum: &D, factor: f64, part: &D) -> D {
    let mut added = *sum;
    for (sum, part) in added.as_mut().iter_mut().zip(part.as_ref()) {
        *sum += factor * part;
    }
    added
}
