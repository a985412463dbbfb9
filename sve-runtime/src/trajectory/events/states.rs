//! The states of [`Events`], one after the other, and the underlying trajectory.

use core::fmt;
use core::ops::Deref;

use super::Events;
use crate::error::StepError;
use crate::method::OneStepMethod;
use crate::noise::Halves;
use crate::system::StateOf;
use crate::trajectory::{Method, Trajectory};

/// Paths whose functions are still to be given: none that has events.
#[doc(hidden)]
#[diagnostic::on_unimplemented(
    message = "`.tolerance`, `.refine` and `.compensated` stand before the events of a path",
    label = "this path has its events already",
    note = "an event is found within the steps that the path makes: write `trajectory(…).tolerance(tol).change_at(…)`"
)]
pub trait WithoutEvents {}

impl<I: OneStepMethod, W> Events<'_, I, W> {
    /// Does not compile: the sizes of steps are given before the events.
    #[doc(hidden)]
    #[must_use]
    pub fn tolerance(self, _: f64) -> Self
    where
        Self: WithoutEvents,
    {
        self
    }

    /// Does not compile: as [`tolerance`](Self::tolerance).
    #[doc(hidden)]
    #[must_use]
    pub fn refine(self, _: u32) -> Self
    where
        Self: WithoutEvents,
    {
        self
    }

    /// Does not compile: as [`tolerance`](Self::tolerance).
    #[doc(hidden)]
    #[must_use]
    pub fn compensated(self) -> Self
    where
        Self: WithoutEvents,
    {
        self
    }
}

impl<'a, I: OneStepMethod, W> Deref for Events<'a, I, W> {
    type Target = Trajectory<'a, I, W>;

    fn deref(&self) -> &Trajectory<'a, I, W> {
        &self.trajectory
    }
}

impl<'a, I: OneStepMethod, W> fmt::Debug for Events<'a, I, W>
where
    Trajectory<'a, I, W>: fmt::Debug,
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Events")
            .field("trajectory", &self.trajectory)
            .field("functions", &self.functions.len())
            .field("event", &self.event)
            .finish_non_exhaustive()
    }
}

impl<I: Method, W: Halves> Iterator for Events<'_, I, W> {
    type Item = Result<StateOf<I::System>, StepError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some((state, event)) = self.found.pop_front() {
                self.event = event;
                return Some(Ok(state));
            }
            // States that were found before an error are yielded before it.
            if let Some(error) = self.failure.take() {
                return Some(Err(error));
            }
            if self.has_ended {
                return None;
            }
            match self.advance() {
                Ok(goes_on) => self.has_ended |= !goes_on,
                Err(error) => {
                    self.has_ended = true;
                    self.failure = Some(error);
                }
            }
        }
    }
}
