//! The kinds of trajectories: the choice of the sizes of steps, and the treatment of a step that
//! fails.

use super::Trajectory;
use crate::error::StepError;
use crate::method::OneStepMethod;

/// Steps of one size.
#[derive(Clone, Copy, Debug)]
pub struct EqualSteps;

/// Steps of one size, of which those that fail are divided.
#[derive(Clone, Copy, Debug)]
pub struct RefinedSteps {
    /// Largest number of halvings of a step.
    pub(super) depth: u32,
}

/// Steps whose size is adapted to a tolerance.
#[derive(Clone, Copy, Debug)]
pub struct AdaptedSteps;

/// A kind of trajectories of a method with a source of increments.
pub trait StepKind<I: OneStepMethod, W>: Copy {
    /// Makes a step that failed with `error` in another way, or returns the error.
    ///
    /// # Errors
    /// The error, or that of a part of the step.
    #[inline(always)]
    fn retry(
        self,
        _: &mut Trajectory<'_, I, W, Self>,
        error: StepError,
        _: &I::Increments,
    ) -> Result<(), StepError> {
        Err(error)
    }
}

impl<I: OneStepMethod, W> StepKind<I, W> for EqualSteps {}

impl<I: OneStepMethod, W> StepKind<I, W> for AdaptedSteps {}

/// Kinds whose steps have one size, which those of paths with a tolerance have not.
#[diagnostic::on_unimplemented(
    message = "a path with a tolerance has neither `refine` nor `compensated`",
    label = "the path chooses the size of its steps",
    note = "a step that fails is tried again with a smaller size, and rounding errors are compensated in any case: leave out `.refine(…)` and `.compensated()`, or `.tolerance(tol)`"
)]
pub trait FixedSteps {}

impl FixedSteps for EqualSteps {}

impl FixedSteps for RefinedSteps {}

/// Kinds whose steps are not divided where they fail.
#[diagnostic::on_unimplemented(
    message = "a path with `refine` has no events",
    label = "the path divides steps that fail",
    note = "an event is found within a step that the path makes, and a step that fails has no part: leave out `.refine(…)`"
)]
pub trait WholeSteps {}

impl WholeSteps for EqualSteps {}

impl WholeSteps for AdaptedSteps {}
