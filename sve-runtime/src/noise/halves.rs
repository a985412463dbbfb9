//! Sources that know their path within a step.
//!
//! Input: the increments over a dyadic interval of a step. Output: the increments over its halves. Invariant: they sum to those of the interval up to rounding, and are
//! a pure function of the source, the interval and its increments.

use super::{DyadicInterval, NoNoise, Noise, Wiener};
use crate::system::Increments;

/// Number of halvings of a step within which the path is known. Between two neighbouring points it is linear.
const LEVELS: u32 = 32;

/// A source that knows its path within steps, so that a step can be divided into smaller steps on the same path.
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
    /// Computes the increments of every process over the two halves of an interval of length `h`; `whole` are those over the interval.
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

/// Returns the increments over the first `fraction` of a step of length `h`; `whole` are those over the step.
///
/// The path within a step is a function of seed, path, step and process: its values at the multiples of 2⁻³² of the step are those of the halved intervals.
pub(crate) fn increments_until<W: Halves, D: Increments>(
    noise: &W,
    step: u64,
    h: f64,
    fraction: f64,
    whole: &D,
) -> D {
    let halve = |interval, length, part: &D, left: &mut D, right: &mut D| {
        noise.halves_of(
            interval,
            length,
            part.as_ref(),
            left.as_mut(),
            right.as_mut(),
        );
        true
    };
    // every interval is halved
    bisected(halve, step, h, fraction, whole).unwrap_or(*whole)
}

/// Returns the same as [`increments_until`]; `None` if the source does not know its path within steps.
pub(crate) fn increments_until_if_known<W: Noise, D: Increments>(
    noise: &W,
    step: u64,
    h: f64,
    fraction: f64,
    whole: &D,
) -> Option<D> {
    let halve = |interval, length, part: &D, left: &mut D, right: &mut D| {
        noise.halves_if_known(
            interval,
            length,
            part.as_ref(),
            left.as_mut(),
            right.as_mut(),
        )
    };
    bisected(halve, step, h, fraction, whole)
}

/// Adds up the increments of the intervals before a fraction of a step. `halve` computes the increments of the halves of an interval and returns whether it can.
fn bisected<D: Increments>(
    halve: impl Fn(DyadicInterval, f64, &D, &mut D, &mut D) -> bool,
    step: u64,
    h: f64,
    fraction: f64,
    whole: &D,
) -> Option<D> {
    let (mut sum, mut part) = (D::NONE, *whole);
    if fraction >= 1.0 || part.as_ref().is_empty() {
        return Some(part);
    }
    let (mut interval, mut length) = (DyadicInterval::whole(step), h);
    let scaled = fraction * (1_u64 << LEVELS) as f64;
    #[allow(clippy::cast_sign_loss)] // fractions are not negative
    let cell = scaled as u64;
    for level in (0..LEVELS).rev() {
        let Some([first, second]) = interval.halves() else {
            break;
        };
        let (mut left, mut right) = (D::NONE, D::NONE);
        if !halve(interval, length, &part, &mut left, &mut right) {
            return None;
        }
        length *= 0.5;
        if cell >> level & 1 == 1 {
            add(&mut sum, 1.0, &left);
            (interval, part) = (second, right);
        } else {
            (interval, part) = (first, left);
        }
    }
    add(&mut sum, scaled - cell as f64, &part);
    Some(sum)
}

/// Adds a multiple of increments.
fn add<D: Increments>(sum: &mut D, factor: f64, part: &D) {
    for (sum, part) in sum.as_mut().iter_mut().zip(part.as_ref()) {
        *sum += factor * part;
    }
}
