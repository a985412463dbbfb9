//! Distributions of increments: random words to increments.
//!
//! Input: seed, path, step, process and scale √h. Output: increments.
//! Invariant: a pure function with the same bits for one path and for lanes of paths.
//!
//! Layout: the key of [`threefry`] is (seed, path, domain, 0). The four words of a block belong to
//!
//! - the steps 4k … 4k+3 of one process, for the first [`BY_STEPS`] processes: the counter is
//!   (step / 4, process, 0, 0). A path of few processes, drawn step after step, wastes no word;
//! - four processes of one step, for the other processes: the counter is (step, process / 4, 1, 0).
//!   A path of many processes keeps nothing between steps.
//!
//! A change of the layout changes every published result: the layout is part of the public
//! contract, and tests fix its values. [`VERSION`] counts the changes.

use core::marker::PhantomData;

pub(super) use super::box_muller::Workspace;
use super::threefry;
use crate::lanes::dispatch::{Kernel, dispatch};

/// Version of the increments. It changes with their bits, so that results of different versions are
/// not merged.
#[cfg(feature = "ensemble")]
pub(crate) const VERSION: u64 = 2;

/// Number of steps, or of processes, that share a block.
pub(crate) const SHARED: usize = 4;

/// Number of processes whose blocks are shared by steps.
pub(crate) const BY_STEPS: usize = 16;

/// A distribution of increments with variance h.
pub(crate) trait Distribution: Copy {
    /// Part of the generator's key that separates these draws from other uses of the seed.
    const DOMAIN: u64;

    /// Converts four words to four increments, within a [`Kernel`]; `scale` is √h.
    fn four(words: [u64; 4], scale: f64) -> [f64; 4];

    /// Converts the words of each lane. `AVX512` is true if the machine has AVX-512.
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

/// Seed and path, from which the random words of a path follow.
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
