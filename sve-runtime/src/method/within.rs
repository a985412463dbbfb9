//! A method as the runs of its steps have it: borrowed or owned, and within a step.

use core::ops::Deref;

use super::OneStepMethod;
use crate::error::StepError;
use crate::system::StateOf;

/// A method that is borrowed, or that belongs to the run of its steps.
#[doc(hidden)]
#[derive(Debug)]
pub enum Shared<'a, I> {
    Borrowed(&'a I),
    Owned(Box<I>),
}

impl<I> Deref for Shared<'_, I> {
    type Target = I;

    #[inline(always)]
    fn deref(&self) -> &I {
        match self {
            Self::Borrowed(method) => method,
            Self::Owned(method) => method,
        }
    }
}

impl<'a, I> From<&'a I> for Shared<'a, I> {
    #[inline(always)]
    fn from(method: &'a I) -> Self {
        Self::Borrowed(method)
    }
}

/// A method within a step: what the step holds stays.
pub(crate) struct Within<'a, I: OneStepMethod> {
    pub(crate) method: &'a I,
    /// The values of the step, if one has begun.
    pub(crate) step: Option<&'a I::Prepared>,
}

impl<I: OneStepMethod> Clone for Within<'_, I> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<I: OneStepMethod> Copy for Within<'_, I> {}

impl<'a, I: OneStepMethod> Within<'a, I> {
    /// Returns the system in the step.
    pub(crate) fn system(self) -> &'a I::System {
        match self.step {
            Some(step) => self.method.system_in(step),
            None => self.method.system(),
        }
    }

    /// Computes the values for a part of the step, of length `h`.
    pub(crate) fn prepare(self, h: f64) -> Result<I::Prepared, StepError> {
        match self.step {
            Some(step) => self.method.prepare_within(step, h),
            None => self.method.prepare(h),
        }
    }

    /// Makes a part of the step, of length `h`.
    pub(crate) fn make(
        self,
        state: &mut StateOf<I::System>,
        h: f64,
        dw: &I::Increments,
    ) -> Result<(), StepError> {
        let prepared = self.prepare(h)?;
        self.method.step_prepared(&prepared, state, h, dw)
    }
}
