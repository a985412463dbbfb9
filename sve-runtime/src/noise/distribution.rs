//! Distributions of increments: random words to increments.
//!
//! Input: seed, path, step, process and scale √h. Output: increments.
//! Invariant: a pure function with the same bits for one path and for lanes of paths.
//!
//! Layout: the key of [`threefry`] is (seed, path, domain, 0). The four words of a block belong to
//!
//! - the steps 4k … 4k+3 of one process, for the first [`BY_STEPS`] processes: the counter is (step / 4, process, 0, 0). A path of few processes, drawn
//!   step after step, wastes no word;
//! - four processes of one step, for the others: the counter is (step, process / 4, 1, 0). A path of many processes keeps nothing between steps.
//!
//! A change of the layout changes every published result: the layout is part of the public contract, and tests fix its values. [`VERSION`] counts the changes.

use core::marker::PhantomData;

pub(super) use super::box_muller::Workspace;
use super::{box_muller, threefry};
use crate::lanes::dispatch::{Kernel, dispatch};

/// Version of the increments: it changes with their bits, so that results of different versions are not merged.
#[cfg(feature = "ensemble")]
pub(crate) const VERSION: u64 = 2;

/// Steps, or processes, that share a block.
pub(crate) const SHARED: usize = 4;

/// Number of processes whose blocks are shared by steps.
pub(crate) const BY_STEPS: usize = 16;

/// A distribution of increments with variance h.
pub(crate) trait Distribution: Copy {
    /// Part of the generator's key that separates these draws from other uses of the seed.
    const DOMAIN: u64;

    /// Converts four words to four increments, within a [`Kernel`]; `scale` is √h.
    fn four(words: [u64; 4], scale: f64) -> [f64; 4];

    /// Converts the words of each lane. `AVX512` says whether the machine has the vectors of that name.
    #[inline(always)]
    fn fill_lanes<const L: usize, const AVX512: bool>(
        words: impl Fn(usize) -> [u64; 4],
        scale: f64,
        work: &mut Workspace<L>,
        out: &mut [[f64; L]; 4],
    ) {
        let _ = work;
        let [a, b, c, d] = out;
        for lane in 0..L {
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
        box_muller::inlined_four(words, scale)
    }

    #[inline(always)]
    fn fill_lanes<const L: usize, const AVX512: bool>(
        words: impl Fn(usize) -> [u64; 4],
        scale: f64,
        work: &mut Workspace<L>,
        out: &mut [[f64; L]; 4],
    ) {
        box_muller::fill_lanes::<L, AVX512>(words, scale, work, out);
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

/// The random words of a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathKey {
    pub(crate) seed: u64,
    pub(crate) path: u64,
}

impl PathKey {
    /// Returns the words of one of the first processes for the four steps of a block.
    #[inline(always)]
    pub(crate) fn words_by_steps<D: Distribution>(self, block: u64, process: u64) -> [u64; 4] {
        self.words::<D>([block, process, 0, 0])
    }

    /// Returns the words of a group of four processes for a step.
    #[inline(always)]
    pub(crate) fn words_by_processes<D: Distribution>(self, step: u64, group: u64) -> [u64; 4] {
        self.words::<D>([step, group, 1, 0])
    }

    #[inline(always)]
    fn words<D: Distribution>(self, counter: [u64; 4]) -> [u64; 4] {
        threefry::block(counter, [self.seed, self.path, D::DOMAIN, 0])
    }

    /// Returns the increment of a process over a step.
    pub(crate) fn increment<D: Distribution>(self, step: u64, process: usize, scale: f64) -> f64 {
        let shared = SHARED as u64;
        let (words, at) = if process < BY_STEPS {
            let words = self.words_by_steps::<D>(step / shared, process as u64);
            (words, step % shared)
        } else {
            let process = process as u64;
            let words = self.words_by_processes::<D>(step, process / shared);
            (words, process % shared)
        };
        let kernel = Four {
            words,
            scale,
            distribution: PhantomData::<D>,
        };
        dispatch(kernel)[at as usize]
    }
}

/// Four increments of a distribution.
struct Four<D> {
    words: [u64; 4],
    scale: f64,
    distribution: PhantomData<D>,
}

impl<D: Distribution> Kernel for Four<D> {
    type Output = [f64; 4];

    #[inline(always)]
    fn run(self) -> [f64; 4] {
        D::four(self.words, self.scale)
    }
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
