//! The way to the next saved state.
//!
//! Input: a trajectory and a point on it, a number of steps or a time. Output: the state there.
//! Invariant: steps of the trajectory are made in order, and no further than the last whole step
//! before the point.

use core::borrow::Borrow as _;

use super::{Saved, Wanted};
use crate::error::StepError;
use crate::method::OneStepMethod;
use crate::noise::{Noise, increments_until};
use crate::progress::Progress;
use crate::system::StateOf;
use crate::time::{WrittenTimes, is_next_time};
use crate::trajectory::events::zero_between;
use crate::trajectory::{StepKind, Trajectory, is_end_of_path};

/// Returns the number of whole steps before a time, and whether the time is the end of these steps.
///
/// # Errors
/// [`StepError::TimeOrder`] if the time is before the end of the step with the number `made`.
fn place_among(times: &WrittenTimes, t: f64, made: u64) -> Result<(u64, bool), StepError> {
    let position = times.position(t).filter(|(steps, _)| *steps >= made);
    position.ok_or(StepError::TimeOrder {
        t,
        after: times.after(made),
        h: times.h(),
    })
}

impl<I: OneStepMethod, W: Noise, K: StepKind<I, W>> Trajectory<'_, I, W, K> {
    /// Returns whether the times after its steps are not known ahead: they are those of the states,
    /// not multiples of the step size.
    fn has_own_times(&self) -> bool {
        I::HAS_OWN_TIME || self.is_adapted()
    }

    /// Returns the times after its steps.
    pub(super) fn times(&self) -> WrittenTimes {
        WrittenTimes::new(self.start, self.h)
    }

    /// Makes steps up to a number of steps. Returns whether it was reached before the end of the
    /// trajectory.
    fn go_on(&mut self, steps: u64) -> Result<bool, StepError> {
        let left = steps.saturating_sub(self.step);
        if left == 0 || self.has_ended {
            return Ok(left == 0);
        }
        match self.advance(left) {
            Ok(_) => Ok(true),
            Err(error) if is_end_of_path(&error) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Returns the number of whole steps before a time, and whether the time is the end of these
    /// steps. A path whose times are not known ahead makes them, and counts no further than `most`.
    fn place_of(
        &mut self,
        t: f64,
        times: &WrittenTimes,
        most: u64,
    ) -> Result<(u64, bool), StepError> {
        if self.is_adapted() {
            let is_whole = self.adapted_steps_before(t, most)?;
            return Ok((self.step, is_whole));
        }
        if const { I::HAS_OWN_TIME } {
            return self.place_in_own_time(t, most);
        }
        place_among(times, t, self.step)
    }

    /// Returns the state at a time within the next step.
    fn state_within(&mut self, t: f64) -> Result<StateOf<I::System>, StepError> {
        if self.is_adapted() {
            return self.adapted_state_at(t);
        }
        if const { I::HAS_OWN_TIME } {
            return self.state_at_own_time(t);
        }
        let mut state = self.state.clone();
        let h = t - state.t;
        // A part that is too short to change the time changes nothing else.
        if h != 0.0 && is_next_time(state.t, state.t + h) {
            let dw = self.increments_up_to(t)?;
            self.hold()?;
            self.within().make(&mut state, h, dw.borrow())?;
        }
        state.t = t;
        Ok(state)
    }

    /// Makes steps up to a number of steps, as long as none ends behind a time. Returns their
    /// number, and whether the last one ends at this time.
    fn place_in_own_time(&mut self, end: f64, most: u64) -> Result<(u64, bool), StepError> {
        let (after, h) = (self.state.t, self.h);
        let is_behind = |t: f64| (t - end) * h.signum() > 0.0;
        if !end.is_finite() || is_behind(after) {
            return Err(StepError::TimeOrder { t: end, after, h });
        }
        while self.step < most && self.state.t != end {
            let (state, prepared, step) = (self.state.clone(), self.prepared.clone(), self.step);
            self.advance(1)?;
            if is_behind(self.state.t) {
                (self.state, self.prepared, self.step) = (state, prepared, step);
                break;
            }
        }
        Ok((self.step, self.state.t == end))
    }

    /// Returns the state at a time within the next step, which a part of the step reaches. The
    /// length of the part is a root of the time that it takes.
    fn state_at_own_time(&mut self, t: f64) -> Result<StateOf<I::System>, StepError> {
        if self.state.t == t {
            return Ok(self.state.clone());
        }
        let drawn = self.draw()?;
        self.hold()?;
        let end = |fraction: f64| {
            let mut state = self.state.clone();
            if fraction != 0.0 {
                (self.within()).make(&mut state, fraction * self.h, drawn.borrow())?;
            }
            Ok::<_, StepError>(state)
        };
        let late = |fraction: f64| Ok::<_, StepError>(end(fraction)?.t - t);
        let bracket = [(0.0, self.state.t - t), (1.0, late(1.0)?)];
        let mut state = end(zero_between(late, bracket)?.at)?;
        state.t = t;
        Ok(state)
    }

    /// Returns the increments over the part of the next step up to a time.
    fn increments_up_to(&mut self, t: f64) -> Result<<I::Increments as ToOwned>::Owned, StepError> {
        let from = self.times().after(self.step);
        let whole = self.draw().map_err(|error| match error {
            error if is_end_of_path(&error) => StepError::PathEnded { t, end: from },
            error => error,
        })?;
        let (h, stages) = (self.h, self.method.stages());
        if stages > 1 && AsRef::<[f64]>::as_ref(&whole).iter().all(|dw| *dw == 0.0) {
            return Ok(whole);
        }
        let fraction = (t - self.state.t) / h;
        let whole: &I::Increments = whole.borrow();
        increments_until(self.noise.within_steps(), self.step, h, fraction, whole)
            .filter(|_| stages == 1)
            .ok_or(StepError::WithinStep { t, from, h, stages })
    }
}

/// A point of a trajectory.
enum Point {
    Step(u64),
    Time(f64),
}

impl<I: OneStepMethod, W: Noise, K: StepKind<I, W>> Saved<Trajectory<'_, I, W, K>> {
    /// Returns the next point to save; `None` after the last one.
    fn next_point(&mut self) -> Result<Option<Point>, StepError> {
        let point = match &mut self.wanted {
            Wanted::Steps { every: 0, .. } => {
                let t = self.path.state.t;
                return Err(StepError::SavedInterval { t });
            }
            Wanted::Steps { next, every } => {
                let step = *next;
                *next = step.saturating_add(*every);
                Some(Point::Step(step))
            }
            Wanted::Times(times) => times.pop_front().map(Point::Time),
        };
        let Some(end) = self.end else {
            return Ok(point);
        };
        let is_before_end = match point {
            Some(Point::Step(step)) => {
                let (last, is_whole) = self.path.place_of(end, &self.times, step)?;
                step < last || step == last && !is_whole
            }
            Some(Point::Time(t)) => self.times.is_before(t, end),
            None => false,
        };
        if is_before_end {
            return Ok(point);
        }
        self.has_ended = true;
        Ok(Some(Point::Time(end)))
    }

    /// Returns the number of states up to the end; `None` without an end, or if it depends on steps
    /// whose sizes are not known ahead.
    ///
    /// # Errors
    /// The error of an end or an interval that does not exist, which the next state has too.
    pub(super) fn count_states(&mut self) -> Result<Option<usize>, StepError> {
        let counts_steps = matches!(self.wanted, Wanted::Steps { .. });
        if counts_steps && (self.path.has_own_times() || self.end.is_none()) {
            return Ok(None);
        }
        let (wanted, has_ended) = (self.wanted.clone(), self.has_ended);
        let points = core::iter::from_fn(|| {
            let is_left = !self.has_ended;
            is_left.then(|| self.next_point().transpose()).flatten()
        });
        let counted: Result<usize, _> = points.map(|point| point.map(|_| 1)).sum();
        (self.wanted, self.has_ended) = (wanted, has_ended);
        counted.map(Some)
    }

    /// Goes to a point. Returns the state at it; `None` if a trajectory without an end has ended,
    /// for example at the end of a recorded path.
    fn go_to(&mut self, point: &Point) -> Result<Option<StateOf<I::System>>, StepError> {
        let (steps, t, is_whole) = match *point {
            Point::Step(step) => (step, self.times.after(step), true),
            Point::Time(t) => {
                let (steps, is_whole) = self.path.place_of(t, &self.times, u64::MAX)?;
                (steps, t, is_whole)
            }
        };
        if !self.path.go_on(steps)? {
            // A trajectory that has to end later ends with its recorded path otherwise.
            let wanted = match *point {
                Point::Time(t) => Some(t),
                Point::Step(_) => self.end,
            };
            let end = self.times.after(self.path.step);
            return wanted.map_or(Ok(None), |t| Err(StepError::PathEnded { t, end }));
        }
        if !is_whole {
            return self.path.state_within(t).map(Some);
        }
        let mut state = self.path.state.clone();
        if !self.path.has_own_times() {
            state.t = t;
        }
        Ok(Some(state))
    }

    fn advance(&mut self) -> Result<Option<StateOf<I::System>>, StepError> {
        if !self.times.are_known() {
            // The first step returns the reason.
            return self.path.next().transpose();
        }
        match self.next_point()? {
            Some(point) => self.go_to(&point),
            None => Ok(None),
        }
    }
}

impl<I: OneStepMethod, W: Noise, K: StepKind<I, W>> Iterator for Saved<Trajectory<'_, I, W, K>> {
    type Item = Result<StateOf<I::System>, StepError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.has_ended {
            return None;
        }
        if self.begins_progress {
            self.begins_progress = false;
            let count = self.count_states().ok().flatten();
            self.progress = count.map(|count| Progress::new(true, count as u64, "states"));
        }
        let item = self.advance().transpose();
        self.has_ended |= !matches!(item, Some(Ok(_)));
        if let Some(progress) = &self.progress {
            progress.add(u64::from(matches!(item, Some(Ok(_)))));
            if self.has_ended {
                progress.end();
            }
        }
        item
    }
}
