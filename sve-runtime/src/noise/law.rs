//! What the words of a counter become: increments of a law.
//!
//! Input: seed, path, block of four steps, process and scale √h. Output: the increments of one process over these four steps.
//! Invariant: a pure function, the same bits for one path or for a lane of them.
//!
//! Layout: the key of [`threefry`] is (seed, path, domain, 0), the counter is (step / 4, process, 0, 0), and the four words of
//! that block belong to the steps 4k … 4k+3 of one process. Changing any of this changes every published result: it is
//! part of the public contract, and the tests hold its values.

use super::{box_muller, threefry};
#[cfg(feature = "ensemble")]
use crate::lanes::{LANES, Lane};

/// Steps that share a block.
pub(crate) const STEPS: u64 = 4;

/// A distribution of increments of variance h.
pub(crate) trait Law: Copy {
    /// Separates these draws from whatever else a seed is used for.
    const DOMAIN: u64;

    /// Four words to four increments, where `scale` is √h.
    fn four(words: [u64; 4], scale: f64) -> [f64; 4];

    /// The same for each lane. `DIRECT` says whether the vectors of the machine convert words to numbers.
    #[cfg(feature = "ensemble")]
    #[inline(always)]
    fn row<const DIRECT: bool>(words: impl Fn(usize) -> [u64; 4], scale: f64, out: &mut [Lane; 4]) {
        let [a, b, c, d] = out;
        for lane in 0..LANES {
            [a[lane], b[lane], c[lane], d[lane]] = Self::four(words(lane), scale);
        }
    }
}

/// Normal increments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Normal;

impl Law for Normal {
    const DOMAIN: u64 = u64::from_le_bytes(*b"wiener  ");

    #[inline(always)]
    fn four(words: [u64; 4], scale: f64) -> [f64; 4] {
        box_muller::four(words, scale)
    }

    #[cfg(feature = "ensemble")]
    #[inline(always)]
    fn row<const DIRECT: bool>(words: impl Fn(usize) -> [u64; 4], scale: f64, out: &mut [Lane; 4]) {
        box_muller::row::<DIRECT>(words, scale, out);
    }
}

/// Increments ±√(3h) with probability 1/6 each, else 0: the first five moments are those of the normal ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ThreePoints;

impl ThreePoints {
    /// Words from here up to 2⁶³ and as many below −here, of the 2⁶⁴ with sign: a third of all, to 2⁻⁶⁴.
    const BOUND: i64 = (2 * (1_u128 << 63) / 3) as i64 + 1;
}

impl Law for ThreePoints {
    const DOMAIN: u64 = u64::from_le_bytes(*b"3-points");

    #[inline(always)]
    fn four(words: [u64; 4], scale: f64) -> [f64; 4] {
        let step = (ROOT_3 * scale).to_bits();
        words.map(|word| {
            let signs = word.cast_signed() >> 63;
            // its size, or that less 1 below 0: as far from the end of either sign; comparisons are slow in old vectors
            let size = word.cast_signed() ^ signs;
            let small = (size - Self::BOUND) >> 63;
            f64::from_bits((step | (word & (1 << 63))) & !small.cast_unsigned())
        })
    }
}

/// √3, rounded.
const ROOT_3: f64 = 1.732_050_807_568_877_2;

/// The block of a step, and its place there.
#[inline(always)]
pub(crate) fn place(step: u64) -> (u64, usize) {
    (step / STEPS, (step % STEPS) as usize)
}

/// The random words of one process over the four steps of a block.
#[inline(always)]
pub(crate) fn words<L: Law>(seed: u64, path: u64, block: u64, process: u64) -> [u64; 4] {
    threefry::block([block, process, 0, 0], [seed, path, L::DOMAIN, 0])
}

/// The increments of one process over the four steps of a block.
#[inline(always)]
pub(crate) fn increments<L: Law>(
    seed: u64,
    path: u64,
    block: u64,
    process: u64,
    scale: f64,
) -> [f64; 4] {
    L::four(words::<L>(seed, path, block, process), scale)
}

#[cfg(test)]
mod tests {
    use super::{Law, ROOT_3, ThreePoints};

    /// ⌊2⁶⁴/6⌋ words give each sign: those at the ends of the range with sign.
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
