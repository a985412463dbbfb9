//! Functions of a state whose zeros are events.
//!
//! Input: the system and a state. Output: a finite value and the side of the zero on which it is.
//! Invariant: a value that is not finite is an error, so that every stored value can be compared.

use core::f64::consts::{PI, TAU};

use crate::error::StepError;
use crate::system::{AnySystem, StateOf};

/// A function of the system and a state.
pub(super) type Function<'a, S> = Box<dyn Fn(&S, &StateOf<S>) -> Result<f64, StepError> + 'a>;

/// A change of the state at an event.
pub(super) type Change<'a, S> = Box<dyn FnMut(&S, &mut StateOf<S>) + 'a>;

/// The action at an event.
pub(super) enum Action<'a, S: AnySystem> {
    /// The state is yielded.
    Yield,
    /// The trajectory ends.
    Stop,
    /// The state is changed, and the trajectory goes on from the changed state.
    Change(Change<'a, S>),
}

/// The sign changes that count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Both,
    Rising,
    Falling,
}

/// The side of zero on which a value is. A value of 0 is on none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Below,
    None,
    Above,
}

impl Side {
    pub(super) fn of(value: f64) -> Self {
        if value > 0.0 {
            Self::Above
        } else if value < 0.0 {
            Self::Below
        } else {
            Self::None
        }
    }
}

/// A function with its options, and its value where the search for the next event begins.
pub(super) struct EventFunction<'a, S: AnySystem> {
    function: Function<'a, S>,
    pub(super) action: Action<'a, S>,
    pub(super) direction: Direction,
    /// The function is an angle, which has a zero at every multiple of 2π.
    pub(super) is_angle: bool,
    /// The value at the last point at which the function was evaluated.
    pub(super) value: f64,
    /// The side of the motion after that point. Right after an event it differs from the side of
    /// the value.
    pub(super) side: Side,
    /// The fraction of the step at that point.
    pub(super) at: f64,
    /// The value at the next point of the search.
    pub(super) next: f64,
    /// Time of the last change that this function caused.
    pub(super) changed_at: f64,
}

impl<'a, S: AnySystem> EventFunction<'a, S> {
    pub(super) fn new(function: Function<'a, S>, action: Action<'a, S>) -> Self {
        Self {
            function,
            action,
            direction: Direction::Both,
            is_angle: false,
            value: 0.0,
            side: Side::None,
            at: 0.0,
            next: 0.0,
            changed_at: f64::NAN,
        }
    }

    /// Evaluates the function, function `number` of the events. An angle is reduced to (−π, π].
    pub(super) fn evaluate(
        &self,
        number: usize,
        system: &S,
        state: &StateOf<S>,
    ) -> Result<f64, StepError> {
        let value = (self.function)(system, state)?;
        if !value.is_finite() {
            let t = state.t;
            return Err(StepError::EventFunction { t, number, value });
        }
        Ok(if self.is_angle { reduced(value) } else { value })
    }

    /// Stores the value at a point, and its side.
    pub(super) fn arrive(&mut self, value: f64) {
        self.value = value;
        self.side = Side::of(value);
    }

    /// Returns whether the motion from the stored value to `next` crosses zero in a direction that
    /// counts. A motion that arrives at exactly 0 crosses zero, a motion that leaves from 0 does
    /// not.
    pub(super) fn crosses_before(&self, next: f64) -> bool {
        let is_new_side = match self.side {
            Side::None => return false,
            Side::Below => next >= 0.0,
            Side::Above => next <= 0.0,
        };
        let counts = match self.direction {
            Direction::Both => true,
            Direction::Rising => self.side == Side::Below,
            Direction::Falling => self.side == Side::Above,
        };
        // An angle that jumps by nearly 2π passed through ±π.
        let wraps = self.is_angle && (next - self.value).abs() > PI;
        is_new_side && counts && !wraps
    }
}

/// Returns an angle in (−π, π] that differs by a multiple of 2π.
fn reduced(angle: f64) -> f64 {
    let reduced = angle - TAU * (angle / TAU).round();
    if reduced <= -PI {
        reduced + TAU
    } else {
        reduced
    }
}

#[cfg(test)]
mod tests {
    use super::{PI, TAU, reduced};

    #[test]
    fn angles_are_reduced_to_half_a_turn_on_each_side() {
        for (angle, expected) in [
            (0.0, 0.0),
            (1.0, 1.0),
            (PI, PI),
            (-PI, PI),
            (TAU, 0.0),
            (TAU + 1.0, 1.0),
            (-3.0 * TAU - 0.5, -0.5),
            (3.5, 3.5 - TAU),
        ] {
            assert!((reduced(angle) - expected).abs() < 1e-14, "{angle}");
        }
    }
}
