//! Increments of many refined paths at once, a lane for each path.
//!
//! Input: the increments over whole steps in lanes, and a range of parts of these steps. Output:
//! the increments over the parts. Invariant: each increment has the bits that
//! [`Refined`](super::Refined) gives for its path.

use super::box_muller::{self, Workspace};
use super::bridge::{self, DyadicInterval, two_to};
use crate::lanes::dispatch::{VectorKernel, dispatch_vectors};
use crate::lanes::{LANES, Lane};

/// The refined paths in the lanes of a tile.
pub(crate) struct RefinedLanes<'a> {
    pub(crate) seed: u64,
    pub(crate) paths: &'a [u64; LANES],
    /// Length of a whole step.
    pub(crate) whole_h: f64,
    /// Number of halvings of a step.
    pub(crate) depth: u32,
}

impl RefinedLanes<'_> {
    /// Fills `out` with the increments of a process over the parts `first` …
    /// `first + out.len() − 1` of a whole step; `whole` has the increments over the step. The
    /// number of parts is a power of two, and `first` is a multiple of it.
    pub(crate) fn fill(
        &self,
        step: u64,
        process: usize,
        whole: &Lane,
        first: u64,
        out: &mut [Lane],
    ) {
        let levels = out.len().trailing_zeros();
        let root = self.depth - levels;
        let mut interval = DyadicInterval::whole(step);
        let mut part = *whole;
        for level in 0..root {
            let halves = self.halves(interval, process, &part);
            let half = (first >> (self.depth - level - 1) & 1) as usize;
            part = halves[half];
            interval = child(interval, half);
        }
        // The parts of each level stand in front of the parts of the next level, which overwrite
        // them from the last on.
        out[0] = part;
        for level in 0..levels {
            let count = 1 << level;
            for k in (0..count).rev() {
                let of_part = descendant(interval, level, k as u64);
                let [left, right] = self.halves(of_part, process, &out[k]);
                out[2 * k] = left;
                out[2 * k + 1] = right;
            }
        }
    }

    /// Returns the increments over both halves of an interval.
    fn halves(&self, interval: DyadicInterval, process: usize, whole: &Lane) -> [Lane; 2] {
        let mut halves = [[0.0; LANES]; 2];
        dispatch_vectors(Split {
            paths: self,
            interval,
            process,
            whole,
            halves: &mut halves,
        });
        halves
    }
}

/// Returns a half of an interval.
fn child(interval: DyadicInterval, half: usize) -> DyadicInterval {
    interval.halves().map_or(interval, |halves| halves[half])
}

/// Returns part `k` of the 2^`levels` parts of an interval.
fn descendant(interval: DyadicInterval, levels: u32, k: u64) -> DyadicInterval {
    (0..levels).rev().fold(interval, |interval, level| {
        child(interval, (k >> level & 1) as usize)
    })
}

/// The division of an interval in all lanes.
struct Split<'a> {
    paths: &'a RefinedLanes<'a>,
    interval: DyadicInterval,
    process: usize,
    whole: &'a Lane,
    halves: &'a mut [Lane; 2],
}

impl VectorKernel for Split<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const AVX512: bool>(self) {
        let RefinedLanes {
            seed,
            paths,
            whole_h,
            depth: _,
        } = *self.paths;
        let scale = 0.5 * (whole_h / two_to(self.interval.level())).abs().sqrt();
        let group = self.process as u64 / 4;
        let words = |lane: usize| bridge::words(seed, paths[lane], self.interval, group);
        let mut normals = [[0.0; LANES]; 4];
        let mut work = Workspace::new();
        box_muller::fill_lanes::<LANES, AVX512>(words, scale, &mut work, &mut normals);
        let [left, right] = self.halves;
        for lane in 0..LANES {
            let deviation = normals[self.process % 4][lane];
            [left[lane], right[lane]] = bridge::split(self.whole[lane], deviation);
        }
    }
}
