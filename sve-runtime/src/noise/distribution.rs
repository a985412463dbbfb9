//! Distributions of increments: random words to increments.
//!
//! Input: seed, path, block of four steps, process and scale √h. Output: the increments of one process over these four steps.
//! Invariant: a pure function with the same bits for one path and for lanes of paths.
//!
//! Layout: the key of [`threefry`] is (seed, path, domain, 0), the counter is (step / 4, process, 0, 0), and the four words of
//! that block belong to the steps 4k … 4k+3 of one process. A change of the layout changes every published result: the layout is
//! part of the public contract, and tests fix its values.

use super::{box_muller, threefry};
#[cfg(feature = "ensemble")]
use crate::lanes::{LANES, Lane};

/// Steps that share a block.
pub(crate) const STEPS: u64 = 4;

/// A distribution of increments with variance h.
pub(crate) trait Distribution: Copy {
    /// Part of the generator's key that separates these draws from other uses of the seed.
    const DOMAIN: u64;

    /// Converts four words to four increments; `scale` is √h.
    fn four(words: [u64; 4], scale: f64) -> [f64; 4];

    /// Converts the words of each lane. `DIRECT` says whether the vectors of the machine convert words to numbers.
    #[cfg(feature = "ensemble")]
    #[inline(always)]
    fn fill_lanes<const DIRECT: bool>(
        words: impl Fn(usize) -> [u64; 4],
        scale: f64,
        out: &mut [Lane; 4],
    ) {
        let [a, b, c, d] = out;
        for lane in 0..LANES {
            [a[lane], b[lane], c[lane], d[lane]] = Self::four(words(lane), scale);
        }
    }
}

/// Normal increments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Normal;

impl Distribution for Normal {
    const DOMAIN: u64 = u64::from_le_bytes(*b"wiener  ");

    #[inline(always)]
    fn four(words: [u64; 4], scale: f64) -> [f64; 4] {
        box_muller::four(words, scale)
    }

    #[cfg(feature = "ensemble")]
    #[inline(always)]
    fn fill_lanes<const DIRECT: bool>(
        words: impl Fn(usize) -> [u64; 4],
        scale: f64,
        out: &mut [Lane; 4],
    ) {
        box_muller::fill_lanes::<DIRECT>(words, scale, out);
    }
}

/// Increments ±√(3h) with probability 1/6 each, otherwise 0: the first five moments are those of normal increments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ThreePoints;

impl ThreePoints {
    /// Smallest positive signed word that gives an increment. These words and their mirror images are a third of all words, to 2⁻⁶⁴.
    const BOUND: i64 = (2 * (1_u128 << 63) / 3) as i64 + 1;
}

impl Distribution for ThreePoints {
    const DOMAIN: u64 = u64::from_le_bytes(*b"3-points");

    #[inline(always)]
    fn four(words: [u64; 4], scale: f64) -> [f64; 4] {
        let step = (ROOT_3 * scale).to_bits();
        words.map(|word| {
            let signs = word.cast_signed() >> 63;
            // The magnitude, less 1 for negative words: both signs have as many values. Old vectors have no fast comparisons, hence the bits.
            let size = word.cast_signed() ^ signs;
            let small = (size - Self::BOUND) >> 63;
            f64::from_bits((step | (word & (1 << 63))) & !small.cast_unsigned())
        })
    }
}

/// √3, rounded.
const ROOT_3: f64 = 1.732_050_807_568_877_2;

/// Returns the block of a step, and its place in the block.
#[inline(always)]
pub(crate) fn block_of(step: u64) -> (u64, usize) {
    (step / STEPS, (step % STEPS) as usize)
}

/// Returns the random words of one process for the four steps of a block.
#[inline(always)]
pub(crate) fn words<D: Distribution>(seed: u64, path: u64, block: u64, process: u64) -> [u64; 4] {
    threefry::block([block, process, 0, 0], [seed, path, D::DOMAIN, 0])
}

/// Returns the increments of one process over the four steps of a block.
#[inline(always)]
pub(crate) fn increments<D: Distribution>(
    seed: u64,
    path: u64,
    block: u64,
    process: u64,
    scale: f64,
) -> [f64; 4] {
    D::four(words::<D>(seed, path, block, process), scale)
}

#[cfg(test)]
mod tests {
    use super::{Distribution, ROOT_3, ThreePoints};

    /// Checks that ⌊2⁶⁴/6⌋ words give each sign: those at the ends of the signed range.
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
