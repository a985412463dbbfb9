//! Sources that can be entered at a step.
//!
//! Input: a source and a step. Output: the source's increments from this step on. Invariant: step
//! `k` is step `first + k` of the source, bit for bit.

use super::{DyadicInterval, Halves, Noise, NoiseError, WithinSteps};

/// A source whose increments are a function of the step number, so that its path can be entered
/// anywhere.
///
/// A trajectory begins at step 0 of its source. To continue from a state reached after `k` steps of
/// a path, enter the path at step `k`:
///
/// ```
/// use sve_runtime::prelude::*;
///
/// struct Oscillator { sigma: f64 }
///
/// #[variational(endpoint)]
/// impl Oscillator {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
///     #[gamma]
///     fn push(&self, q: f64) -> f64 { self.sigma * q }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let oscillator = Integrator::new(Oscillator { sigma: 1.0 }, Endpoint);
/// let (h, noise) = (0.125, Wiener::new(1).path(3));
/// let mut whole = oscillator.trajectory(State::new([1.0], [0.0]), h, noise);
/// let middle = whole.nth(39).unwrap()?;
/// // without `from_step` the increments of the first 40 steps would be repeated
/// let mut rest = oscillator.trajectory(middle, h, noise.from_step(40));
/// assert_eq!(rest.next().unwrap()?, whole.next().unwrap()?);
/// # Ok(())
/// # }
/// ```
///
/// A trajectory that is stored and continued with
/// [`Trajectory::snapshot`](crate::Trajectory::snapshot) counts its steps itself.
#[diagnostic::on_unimplemented(
    message = "the increments of `{Self}` follow one another",
    label = "this source cannot be entered at a step",
    note = "`Wiener`, `ThreePoint` and what is built on them, `Recorded` and `NoNoise` can; of another source, implement `Replayable` if its increments are a function of the step"
)]
pub trait Replayable: Noise {
    /// Returns the same path from step number `first` on; this step becomes step 0.
    #[allow(clippy::wrong_self_convention)] // a path from a step on, not a conversion
    fn from_step(self, first: u64) -> FromStep<Self>
    where
        Self: Sized,
    {
        FromStep { noise: self, first }
    }
}

impl<W: Replayable> Replayable for FromStep<W> {}
impl<W: Replayable + ?Sized> Replayable for &mut W {}
impl<W: Replayable + ?Sized> Replayable for Box<W> {}

/// A source entered at a step, from [`Replayable::from_step`].
///
/// Its errors are the errors of the source, and [`NoiseError::StepNumber`] for a step of the source
/// above 2⁶⁴ − 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FromStep<W> {
    noise: W,
    first: u64,
}

impl<W: Noise> Noise for FromStep<W> {
    #[inline]
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        let first = self.first;
        match first.checked_add(step) {
            Some(of_source) => self.noise.increments(of_source, h, dw),
            None => Err(NoiseError::StepNumber { step, first }),
        }
    }

    fn stage_increments(
        &mut self,
        step: u64,
        h: f64,
        stages: usize,
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        let first = self.first;
        match first.checked_add(step) {
            Some(of_source) => self.noise.stage_increments(of_source, h, stages, dw),
            None => Err(NoiseError::StepNumber { step, first }),
        }
    }

    fn within_steps(&self) -> Option<WithinSteps<'_>> {
        let path = self.noise.within_steps()?;
        Some(path.later(self.first))
    }

    fn is_replayable(&self) -> bool {
        self.noise.is_replayable()
    }
}

impl<W: Halves> Halves for FromStep<W> {
    fn halves_of(
        &self,
        interval: DyadicInterval,
        h: f64,
        whole: &[f64],
        left: &mut [f64],
        right: &mut [f64],
    ) {
        self.noise
            .halves_of(interval.later(self.first), h, whole, left, right);
    }
}
