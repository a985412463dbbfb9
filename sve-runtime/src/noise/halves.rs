//! Sources that know their path within a step.
//!
//! Input: the increments over a dyadic interval of a step. Output: the increments over its halves.
//! Invariant: the halves sum to the increments of the interval up to rounding, and are a pure
//! function of the source, the interval and its increments.

use core::fmt;

use super::{DyadicInterval, NoNoise, Noise, Wiener};
use crate::system::AnyIncrements;

/// Number of halvings of a step within which the path is known. Between two neighbouring points it
/// is linear.
const LEVELS: u32 = 32;

/// A source that knows its path within steps, so that a step can be divided into smaller steps on
/// the same path.
///
/// ```
/// use sve_runtime::noise::{Halves, Noise, DyadicInterval, Wiener};
///
/// let mut path = Wiener::new(42);
/// let (mut whole, mut left, mut right) = ([0.0; 2], [0.0; 2], [0.0; 2]);
/// path.increments(7, 0.1, &mut whole)?;
/// path.halves_of(DyadicInterval::whole(7), 0.1, &whole, &mut left, &mut right);
/// assert!((left[1] + right[1] - whole[1]).abs() < 1e-15);
/// # Ok::<(), sve_runtime::noise::NoiseError>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not know its path within a step",
    label = "steps of this source cannot be divided",
    note = "`Wiener`, also refined, and `NoNoise` know theirs; increments that are recorded, clipped or drawn one after another belong to whole steps"
)]
pub trait Halves: Noise {
    /// Computes the increments of every process over the two halves of an interval of length `h`;
    /// `whole` has the increments over the interval.
    fn halves_of(
        &self,
        interval: DyadicInterval,
        h: f64,
        whole: &[f64],
        left: &mut [f64],
        right: &mut [f64],
    );
}

impl Halves for Wiener {
    fn halves_of(
        &self,
        interval: DyadicInterval,
        h: f64,
        whole: &[f64],
        left: &mut [f64],
        right: &mut [f64],
    ) {
        for (process, &whole) in whole.iter().enumerate() {
            [left[process], right[process]] = self.halves(interval, process, h, whole);
        }
    }
}

impl Halves for NoNoise {
    fn halves_of(&self, _: DyadicInterval, _: f64, _: &[f64], left: &mut [f64], right: &mut [f64]) {
        left.fill(0.0);
        right.fill(0.0);
    }
}

impl<W: Halves + ?Sized> Halves for &mut W {
    fn halves_of(
        &self,
        interval: DyadicInterval,
        h: f64,
        whole: &[f64],
        left: &mut [f64],
        right: &mut [f64],
    ) {
        (**self).halves_of(interval, h, whole, left, right);
    }
}

/// A path that is known within steps, from [`Noise::within_steps`].
#[derive(Clone, Copy)]
pub struct WithinSteps<'a> {
    path: &'a dyn Halves,
    /// The step of the path that counts as step 0.
    first: u64,
}

impl<'a> WithinSteps<'a> {
    /// Returns the path of a source.
    pub fn of(path: &'a dyn Halves) -> Self {
        Self { path, first: 0 }
    }

    /// Returns the same path from a step on; this step becomes step 0.
    pub(super) fn later(self, steps: u64) -> Self {
        let first = self.first.wrapping_add(steps);
        Self { first, ..self }
    }
}

impl fmt::Debug for WithinSteps<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("WithinSteps").finish_non_exhaustive()
    }
}

/// Returns the increments over the first `fraction` of a step of length `h`; `whole` has the
/// increments over the step. Returns `None` if the path within the step is needed and not known.
///
/// The path within a step is a function of seed, path, step and process: its values at the
/// multiples of 2⁻³² of the step follow from the halved intervals.
pub(crate) fn increments_until<D: AnyIncrements + ?Sized>(
    path: Option<WithinSteps<'_>>,
    step: u64,
    h: f64,
    fraction: f64,
    whole: &D,
) -> Option<D::Owned> {
    let mut part = whole.to_owned();
    if fraction >= 1.0 || whole.as_ref().is_empty() {
        return Some(part);
    }
    let path = path?;
    let none = || {
        let mut none = whole.to_owned();
        none.as_mut().fill(0.0);
        none
    };
    let mut sum = none();
    let (mut interval, mut length) = (DyadicInterval::whole(step), h);
    let scaled = fraction * (1_u64 << LEVELS) as f64;
    #[allow(clippy::cast_sign_loss)] // fractions are not negative
    let cell = scaled as u64;
    for level in (0..LEVELS).rev() {
        let Some([first, second]) = interval.halves() else {
            break;
        };
        let (mut left, mut right) = (none(), none());
        let (to_left, to_right) = (left.as_mut(), right.as_mut());
        let of_path = interval.later(path.first);
        (path.path).halves_of(of_path, length, part.as_ref(), to_left, to_right);
        length *= 0.5;
        if cell >> level & 1 == 1 {
            add(sum.as_mut(), 1.0, left.as_ref());
            (interval, part) = (second, right);
        } else {
            (interval, part) = (first, left);
        }
    }
    add(sum.as_mut(), scaled - cell as f64, part.as_ref());
    Some(sum)
}

/// Adds a multiple of the increments `part` to `sum`.
fn add(sum: &mut [f64], factor: f64, part: &[f64]) {
    for (sum, part) in sum.iter_mut().zip(part) {
        *sum += factor * part;
    }
}
