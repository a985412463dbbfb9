//! A step, or the part of a step after an event, and the states within it.
//!
//! Input: the state at the beginning, and the path of the noise within the step. Output: the state
//! at any fraction of the step. Invariant: a state is a function of the state at the beginning, the
//! fraction and the path, so the same fraction gives the same bits.

use crate::error::StepError;
use crate::method::Within;
use crate::noise::{Halves, WithinSteps, increments_until};
use crate::system::{IncrementsOf, StateOf, System};
use crate::time::is_next_time;
use crate::trajectory::Method;

/// The fraction of a step after an event at which the function is evaluated to find the side on
/// which the motion continues.
pub(super) const PROBE: f64 = 1.0 / (1_u64 << 24) as f64;

/// The part of a step from a fraction to its end.
pub(super) struct Rest<S: System> {
    /// Number of the step.
    pub(super) step: u64,
    /// True for the first step in which events are searched for.
    pub(super) is_first: bool,
    /// Length of the whole step.
    pub(super) h: f64,
    /// Times at both ends of the whole step.
    pub(super) times: [f64; 2],
    /// The fraction of the step at which this part begins.
    pub(super) from: f64,
    /// The state at the beginning of this part.
    pub(super) state: StateOf<S>,
    /// Increments over the whole step.
    pub(super) whole: IncrementsOf<S>,
    /// Increments up to the beginning of this part.
    pub(super) before: IncrementsOf<S>,
}

impl<S: System> Rest<S> {
    /// Returns the part from a fraction on, with the given state at this fraction.
    pub(super) fn after<W: Halves>(&self, from: f64, state: StateOf<S>, noise: &W) -> Self {
        Self {
            from,
            state,
            before: self.until(from, noise),
            ..*self
        }
    }

    /// Returns the increments from the beginning of the whole step to a fraction of it.
    fn until<W: Halves>(&self, fraction: f64, noise: &W) -> IncrementsOf<S> {
        let path = Some(WithinSteps::of(noise));
        increments_until(path, self.step, self.h, fraction, &self.whole).unwrap_or(self.whole)
    }

    /// Returns whether the part ends before a function can tell on which side the motion continues.
    pub(super) fn is_short(&self) -> bool {
        1.0 - self.from <= PROBE
    }

    /// Returns whether a fraction of the step counts as the start of the path: a function that is
    /// zero there has its zero at the start, up to rounding.
    pub(super) fn is_start(&self, fraction: f64) -> bool {
        let rounding = 4.0 * f64::EPSILON * self.times[0].abs();
        self.is_first && (fraction <= PROBE || (fraction * self.h).abs() <= rounding)
    }

    /// Returns the time at a fraction of the whole step.
    pub(super) fn time_at(&self, fraction: f64) -> f64 {
        if fraction == 1.0 {
            self.times[1]
        } else {
            fraction.mul_add(self.h, self.times[0])
        }
    }

    /// Solves the step anew from the beginning of this part to a fraction of the whole step.
    /// Returns the state at this fraction.
    pub(super) fn state_at<I, W>(
        &self,
        method: Within<'_, I>,
        noise: &W,
        fraction: f64,
    ) -> Result<StateOf<S>, StepError>
    where
        I: Method<System = S>,
        W: Halves,
    {
        let mut state = self.state;
        let h = (fraction - self.from) * self.h;
        // A part that is too short to change the time changes nothing else.
        if h != 0.0 && (I::HAS_OWN_TIME || is_next_time(state.t, state.t + h)) {
            let mut dw = self.until(fraction, noise);
            for (dw, before) in dw.as_mut().iter_mut().zip(self.before.as_ref()) {
                *dw -= before;
            }
            method.make(&mut state, h, &dw)?;
        }
        if const { !I::HAS_OWN_TIME } {
            state.t = self.time_at(fraction);
        }
        Ok(state)
    }
}
