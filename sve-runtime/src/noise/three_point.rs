//! Increments of three values, for weak solutions.
//!
//! Input: seed, path, step, process and step size. Output: ±√(3h) or 0.
//! Invariant: a pure function of (seed, path, step, process), the same bits on every machine.
//!
//! Source: Kloeden, Platen, *Numerical Solution of Stochastic Differential Equations*, Springer
//! (1992), section 14.2.

use super::counter_path::CounterPath;
use super::distribution::Distribution;
#[cfg(feature = "ensemble")]
use super::many_paths::{DistributionKind, ManyPaths, PathData, PathDistribution};
use super::{Noise, NoiseError, Replayable};

/// Increments ±√(3h) with probability 1/6 each and 0 with 2/3, counter-based as
/// [`Wiener`](super::Wiener).
///
/// The moments up to the fifth equal the moments of a normal increment, so expectations converge
/// with the same weak order, up to 2. The increments are cheap and bounded by 1.74 √h, which keeps
/// implicit steps solvable. They are not increments of a Brownian path: solutions do not converge
/// path by path, and paths with two step sizes are unrelated. Draws are independent of the draws of
/// a `Wiener` with the same seed.
///
/// Its only error is [`NoiseError::InvalidStep`], for an `h` that is zero or not finite.
///
/// ```
/// use sve_runtime::noise::{Noise, ThreePoint};
///
/// let mut path = ThreePoint::new(42).path(3);
/// let mut dw = [0.0; 2];
/// path.increments(7, 0.01, &mut dw)?;
/// for (process, dw) in dw.into_iter().enumerate() {
///     assert!(dw == 0.0 || dw.abs() == 3.0_f64.sqrt() * 0.1);
///     assert_eq!(dw, path.increment(7, process, 0.01));
/// }
/// # Ok::<(), sve_runtime::noise::NoiseError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ThreePoint(pub(super) CounterPath<ThreePoints>);

impl ThreePoint {
    /// Returns path 0 of a seed.
    pub fn new(seed: u64) -> Self {
        Self(CounterPath::new(seed))
    }

    /// Returns path number `path` of the same seed.
    #[must_use]
    pub fn path(&self, path: u64) -> Self {
        Self(self.0.path(path))
    }

    /// Returns the increment of a process (from 0) over step number `step` (from 0) of length `h`.
    /// Its variance is |h|. If `h` is NaN, returns NaN or 0.
    #[inline]
    pub fn increment(&self, step: u64, process: usize, h: f64) -> f64 {
        self.0.increment(step, process, h)
    }
}

impl Noise for ThreePoint {
    #[inline]
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.0.increments(step, h, dw)
    }

    fn is_replayable(&self) -> bool {
        true
    }
}

impl Replayable for ThreePoint {}

#[cfg(feature = "ensemble")]
impl ManyPaths for ThreePoint {
    fn many_paths(self) -> PathData {
        PathData::of(&self.0, &ThreePoints)
    }
}

/// Increments ±√(3h) with probability 1/6 each, otherwise 0: the first five moments equal the
/// moments of normal increments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ThreePoints;

impl ThreePoints {
    /// Smallest positive signed word that gives an increment. The words from it on and their mirror
    /// images are a third of all words, to 2⁻⁶⁴.
    const BOUND: i64 = (2 * (1_u128 << 63) / 3) as i64 + 1;
}

impl Distribution for ThreePoints {
    const DOMAIN: u64 = u64::from_le_bytes(*b"3-points");

    #[inline(always)]
    fn four(words: [u64; 4], scale: f64) -> [f64; 4] {
        let step = (ROOT_3 * scale).to_bits();
        words.map(|word| {
            let signs = word.cast_signed() >> 63;
            // The magnitude, less 1 for negative words: both signs have as many values. Old vectors
            // have no fast comparisons, hence the bits.
            let size = word.cast_signed() ^ signs;
            let small = (size - Self::BOUND) >> 63;
            f64::from_bits((step | (word & (1 << 63))) & !small.cast_unsigned())
        })
    }
}

/// √3, rounded.
const ROOT_3: f64 = 1.732_050_807_568_877_2;

#[cfg(feature = "ensemble")]
impl PathDistribution for ThreePoints {
    const KIND: DistributionKind = DistributionKind::ThreePoint;
    const NAME: &'static str = "increments of three values";
}

#[cfg(test)]
mod tests {
    use super::{Distribution, ROOT_3, ThreePoints};

    /// Checks that ⌊2⁶⁴/6⌋ words give each sign: the words at the ends of the signed range.
    #[test]
    fn a_sixth_of_the_words_has_each_sign() {
        let sixth = ((1_u128 << 64) / 6) as u64;
        let top = (1_u64 << 63) - 1;
        let bottom = 1_u64 << 63;
        let of = |words: [u64; 4]| ThreePoints::four(words, 2.0);
        let step = 2.0 * ROOT_3;
        assert_eq!(
            of([top, top - sixth + 1, top - sixth, 0]),
            [step, step, 0.0, 0.0]
        );
        let low = [bottom, bottom + sixth - 1, bottom + sixth, u64::MAX];
        assert_eq!(of(low), [-step, -step, 0.0, 0.0]);
        assert!(of(low)[2..].iter().all(|z| z.is_sign_positive()));
        assert_eq!(ROOT_3, 3.0_f64.sqrt());
    }
}
