//! What the words of a counter become: increments of a law.
//!
//! Input: seed, path, block of four steps, process and scale √h. Output: the increments of one process over these four steps.
//! Invariant: a pure function, the same bits for one path or for a lane of them.
//!
//! Layout: the key of [`threefry`] is (seed, path, domain, 0), the counter is (step / 4, process, 0, 0), and the four words of
//! that block belong to the steps 4k … 4k+3 of one process. Changing any of this changes every published result: it is
//! part of the public contract, and the tests hold its values.

use super::{box_muller, threefry};

/// Steps that share a block.
pub(crate) const STEPS: u64 = 4;

/// A distribution of increments of variance h.
pub(crate) trait Law: Copy {
    /// Separates these draws from whatever else a seed is used for.
    const DOMAIN: u64;

    /// Four words to four increments, where `scale` is √h.
    fn four(words: [u64; 4], scale: f64) -> [f64; 4];
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
}

/// The block of a step, and its place there.
#[inline(always)]
pub(crate) fn place(step: u64) -> (u64, usize) {
    (step / STEPS, (step % STEPS) as usize)
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
    let words = threefry::block([block, process, 0, 0], [seed, path, L::DOMAIN, 0]);
    L::four(words, scale)
}
