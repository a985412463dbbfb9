//! States along a path, one for each step.
//!
//! Input: a method, a start, a step size and a noise. Output: an iterator over the states. Three
//! options change how a step is made: [`refine`](Trajectory::refine) divides steps that fail;
//! [`tolerance`](Trajectory::tolerance) adapts the step size;
//! [`compensated`](Trajectory::compensated) carries the low parts of the state. The first two
//! change the kind of the trajectory. The adapter [`Events`] yields the states at zeros of
//! functions, and ends or changes the trajectory at them; the adapter [`Saved`] yields every n-th
//! state, or the states at given times.

mod accurate;
mod adapted;
mod checkpoints;
mod compensated;
mod driven;
mod events;
mod gradient;
mod kind;
mod method;
mod refined;
mod saved;
mod snapshot;
mod sweep;
mod time_scale;

pub use accurate::{AccurateTrajectory, WithoutNoise};
pub use compensated::CompensatedSums;
pub use driven::{DrivenPaths, DrivenTrajectory, NeedsInputs, StepsWithoutInputs};
pub use events::{Events, WithoutEvents};
pub use gradient::{Adjoint, Gradient};
pub use kind::{AdaptedSteps, EqualSteps, FixedSteps, RefinedSteps, StepKind, WholeSteps};
pub use method::Method;
#[cfg(feature = "ensemble")]
pub(crate) use refined::Halving;
pub use refined::{RefinedTrajectory, Refinements};
pub use saved::Saved;
pub use snapshot::Snapshot;
pub use time_scale::{ScaledPaths, ScaledTrajectory};

use core::borrow::{Borrow as _, BorrowMut as _};

use adapted::Sizes;

use crate::error::StepError;
use crate::integrator::accept::time_of_next;
use crate::method::{OneStepMethod, Shared, Within};
use crate::noise::{Noise, NoiseError, draw};
use crate::system::{AnyIncrements, StateOf};
use crate::time::{is_next_time, time_after};

/// The states after each step, from [`Method::trajectory`](crate::Method::trajectory).
///
/// Ends after an error, and at the end of a recorded path; otherwise it has no end: `take` as many
/// as needed, or give a time with [`until`](Self::until). [`every`](Self::every) and
/// [`at`](Self::at) save some of the states.
///
/// The kind `K` of its steps is that of steps of one size, unless it is a [`RefinedTrajectory`] or
/// an [`AccurateTrajectory`].
#[derive(Debug)]
pub struct Trajectory<'a, I: OneStepMethod, W, K = EqualSteps> {
    kind: K,
    method: Shared<'a, I>,
    noise: W,
    state: StateOf<I::System>,
    /// Time before the first step.
    start: f64,
    /// The size of a step; of the last step if the sizes are adapted.
    h: f64,
    /// The values that the method prepares for steps of one size; `None` if the sizes are adapted.
    prepared: Option<I::Prepared>,
    /// The memory of the increments of a step.
    buffer: <I::Increments as AnyIncrements>::Buffer,
    /// Number of steps made.
    step: u64,
    has_ended: bool,
    refinements: Refinements,
    /// The low parts of the state, if rounding errors are compensated.
    low: Option<StateOf<I::System>>,
    sizes: Sizes<I::System>,
}

impl<'a, I: OneStepMethod, W: Noise> Trajectory<'a, I, W> {
    pub(crate) fn new(
        method: impl Into<Shared<'a, I>>,
        state: StateOf<I::System>,
        h: f64,
        noise: W,
    ) -> Self {
        Self {
            kind: EqualSteps,
            start: state.t,
            method: method.into(),
            noise,
            state,
            h,
            prepared: None,
            buffer: Default::default(),
            step: 0,
            has_ended: false,
            refinements: Refinements::default(),
            low: None,
            sizes: Sizes::Fixed,
        }
    }
}

impl<'a, I: OneStepMethod, W: Noise, K: StepKind<I, W>> Trajectory<'a, I, W, K> {
    /// Returns the trajectory with steps of another kind.
    fn of_kind<L>(self, kind: L) -> Trajectory<'a, I, W, L> {
        Trajectory {
            kind,
            method: self.method,
            noise: self.noise,
            state: self.state,
            start: self.start,
            h: self.h,
            prepared: self.prepared,
            buffer: self.buffer,
            step: self.step,
            has_ended: self.has_ended,
            refinements: self.refinements,
            low: self.low,
            sizes: self.sizes,
        }
    }

    /// Returns the number of steps made so far, including the steps before a snapshot. The next
    /// step has the increments of this step of the noise.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Returns the numbers of refined steps so far, including the steps before a snapshot.
    pub fn refinements(&self) -> Refinements {
        self.refinements
    }

    /// Returns the state reached so far.
    pub fn state(&self) -> &StateOf<I::System> {
        &self.state
    }

    /// Computes the values that depend on the step size alone, if it is the same in all steps.
    #[cold]
    fn prepare(&mut self) -> Result<(), StepError> {
        self.check_sizes()?;
        if !self.is_adapted() {
            self.prepared = Some(self.method.prepare(self.h)?);
        }
        Ok(())
    }

    /// Checks that steps of a snapshot whose sizes were adapted have a tolerance again.
    fn check_sizes(&self) -> Result<(), StepError> {
        match self.sizes {
            Sizes::Stored(_) => Err(StepError::ToleranceMissing { t: self.state.t }),
            Sizes::Fixed | Sizes::Adapted(_) => Ok(()),
        }
    }

    /// Holds what the next step is given besides its increments.
    #[inline(always)]
    fn hold(&mut self) -> Result<(), StepError> {
        if self.prepared.is_none() {
            self.prepare()?;
        }
        match &mut self.prepared {
            Some(prepared) => self.method.hold(prepared, 0, self.step, &self.state),
            None => Ok(()),
        }
    }

    /// Returns the method within the last step.
    fn within(&self) -> Within<'_, I> {
        Within {
            method: &self.method,
            step: self.prepared.as_ref(),
        }
    }

    /// Forgets the numbers that the method carries from step to step, which belong to a state that
    /// was not reached.
    #[cold]
    fn forget(&mut self) {
        if let Some(prepared) = &mut self.prepared {
            self.method.recall(prepared, &[]);
        }
        self.sizes.forget(self.h);
    }

    /// Makes `steps` steps. Returns the state after them; the states between are not copied.
    ///
    #[doc = include_str!("../example.md")]
    /// let mut path = pendulum.trajectory(start, 0.01, Wiener::new(42));
    /// let state = path.advance(1000)?;
    /// assert_eq!(state.t, 10.0);
    /// assert_eq!(path.step(), 1000);
    #[doc = include_str!("../example_end.md")]
    ///
    /// # Errors
    /// The error of the first step that fails, or [`StepError::Noise`] at the end of a recorded
    /// path. The trajectory then has the state before this step, and as an iterator it has ended.
    pub fn advance(&mut self, steps: u64) -> Result<&StateOf<I::System>, StepError> {
        let made = self.make_steps(steps);
        self.has_ended |= made.is_err();
        made.map(|()| &self.state)
    }

    fn make_steps(&mut self, steps: u64) -> Result<(), StepError> {
        let mut left = steps;
        loop {
            match self.make_block(left)? {
                0 => break,
                made => left -= made,
            }
        }
        (0..left).try_for_each(|_| self.make_step())
    }

    /// Makes some of the next `count` steps at once, if noise and method can. Returns the number of
    /// steps that were made.
    #[inline(always)]
    fn make_block(&mut self, count: u64) -> Result<u64, StepError> {
        if count == 0 || !self.noise.is_replayable() || self.low.is_some() {
            return Ok(0);
        }
        if self.prepared.is_none() {
            self.prepare()?;
        }
        let (method, h, start, first) = (&*self.method, self.h, self.start, self.step);
        let (noise, state, buffer) = (&mut self.noise, &mut self.state, &mut self.buffer);
        let Some(prepared) = &mut self.prepared else {
            return Ok(0);
        };
        let mut draw = |step: u64, dw: &mut I::Increments| {
            let step = first + step;
            let end = time_after(start, step + 1, h);
            let is_later = is_next_time(time_after(start, step, h), end);
            let drawn = is_later && noise.increments(step, h, dw.as_mut()).is_ok();
            drawn.then_some(end)
        };
        let mut dw = I::Increments::take(buffer, || method.processes(state))?;
        let made = method.next_steps(prepared, state, h, dw.borrow_mut(), count, &mut draw);
        I::Increments::give(buffer, dw);
        self.step += made;
        Ok(made)
    }

    /// Returns the increments of the next step.
    ///
    /// # Errors
    /// [`StepError::Noise`], also at the end of a recorded path.
    #[inline(always)]
    fn draw(&mut self) -> Result<<I::Increments as ToOwned>::Owned, StepError> {
        let (method, state) = (&*self.method, &self.state);
        let mut dw = I::Increments::take(&mut self.buffer, || method.processes(state))?;
        match draw(
            &mut self.noise,
            self.step,
            self.h,
            method.stages(),
            dw.as_mut(),
        ) {
            Ok(()) => Ok(dw),
            Err(source) => {
                let t = self.state.t;
                Err(StepError::Noise { t, source })
            }
        }
    }

    /// Makes the next step. If the step fails, makes it as the kind of the trajectory does.
    #[inline(always)]
    fn make_step(&mut self) -> Result<(), StepError> {
        if self.prepared.is_none() {
            self.prepare()?;
            if self.prepared.is_none() {
                return self.adapted_step(adapted::Limit::None).map(|_| ());
            }
        }
        let drawn = self.draw()?;
        let dw: &I::Increments = drawn.borrow();
        let end = if const { I::HAS_OWN_TIME } {
            None
        } else {
            Some(time_of_next(
                self.start,
                self.step + 1,
                self.h,
                self.state.t,
            )?)
        };
        // behind the end of a recorded path, so that a table of inputs needs no entry there
        self.hold()?;
        // The rare cases are calls with copies of the increments, so that the compiler optimises
        // the plain step as if it were alone.
        let made = if self.low.is_some() {
            self.compensated_step(dw.to_owned().borrow())
        } else {
            match &mut self.prepared {
                Some(prepared) => self.method.next_step(prepared, &mut self.state, self.h, dw),
                None => Ok(()),
            }
        };
        if let Err(error) = made {
            (self.kind).retry(self, error, dw.to_owned().borrow())?;
            self.forget();
        }
        I::Increments::give(&mut self.buffer, drawn);
        self.step += 1;
        // The time is rounded once: repeated addition of `h` would drift.
        if let Some(end) = end {
            self.state.t = end;
        }
        Ok(())
    }
}

/// Returns whether a step was not made since a recorded path has ended.
#[cold]
fn is_end_of_path(error: &StepError) -> bool {
    let StepError::Noise { source, .. } = error else {
        return false;
    };
    matches!(source, NoiseError::Exhausted { .. })
}

impl<I: OneStepMethod, W: Noise, K: StepKind<I, W>> Iterator for Trajectory<'_, I, W, K> {
    type Item = Result<StateOf<I::System>, StepError>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        if self.has_ended {
            return None;
        }
        match self.make_step() {
            Ok(()) => Some(Ok(self.state.clone())),
            Err(error) => {
                self.has_ended = true;
                (!is_end_of_path(&error)).then_some(Err(error))
            }
        }
    }

    /// Makes the steps up to the state without copying the states that are skipped.
    fn nth(&mut self, n: usize) -> Option<Self::Item> {
        if self.has_ended || self.advance(n as u64).is_err() {
            return None;
        }
        self.next()
    }
}
