//! Sources that can tell their path between the ends of a step.
//!
//! Input: the increments over a part of a step. Output: those over its halves. Invariant: they sum to it up to rounding, and are
//! a pure function of the source, the part and the whole.

use super::{NoNoise, Noise, Part, Wiener};

/// A source that knows its path within steps, so that a step can be made in smaller ones on the same path.
///
/// ```
/// use sve_runtime::noise::{Halves, Noise, Part, Wiener};
///
/// let mut path = Wiener::new(42);
/// let (mut whole, mut left, mut right) = ([0.0; 2], [0.0; 2], [0.0; 2]);
/// path.increments(7, 0.1, &mut whole)?;
/// path.halves_of(Part::whole(7), 0.1, &whole, &mut left, &mut right);
/// assert!((left[1] + right[1] - whole[1]).abs() < 1e-15);
/// # Ok::<(), sve_runtime::noise::NoiseError>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not know its path within a step",
    label = "steps of this source cannot be halved",
    note = "`Wiener` and `NoNoise` know theirs; increments that are recorded, clipped or drawn one after another belong to whole steps"
)]
pub trait Halves: Noise {
    /// The increments of every process over the two halves of a part of length `h` whose own are `whole`.
    fn halves_of(&self, part: Part, h: f64, whole: &[f64], left: &mut [f64], right: &mut [f64]);
}

impl Halves for Wiener {
    fn halves_of(&self, part: Part, h: f64, whole: &[f64], left: &mut [f64], right: &mut [f64]) {
        for (process, &whole) in whole.iter().enumerate() {
            [left[process], right[process]] = self.halves(part, process, h, whole);
        }
    }
}

impl Halves for NoNoise {
    fn halves_of(&self, _: Part, _: f64, _: &[f64], left: &mut [f64], right: &mut [f64]) {
        left.fill(0.0);
        right.fill(0.0);
    }
}

impl<W: Halves + ?Sized> Halves for &mut W {
    fn halves_of(&self, part: Part, h: f64, whole: &[f64], left: &mut [f64], right: &mut [f64]) {
        (**self).halves_of(part, h, whole, left, right);
    }
}
