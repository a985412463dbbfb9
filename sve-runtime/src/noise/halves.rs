//! Sources that know their path within a step.
//!
//! Input: the increments over a dyadic interval of a step. Output: the increments over its halves. Invariant: they sum to those of the interval up to rounding, and are
//! a pure function of the source, the interval and its increments.

use super::{DyadicInterval, NoNoise, Noise, Wiener};

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
    label = "steps of this source cannot be halved",
    note = "`Wiener` and `NoNoise` know theirs; increments that are recorded, clipped or drawn one after another belong to whole steps"
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
