//! Increments of many paths at once.
//!
//! Input: a block of four steps, the paths and processes. Output: their increments, in lanes of consecutive paths.
//! Invariant: each has the bits that [`law::increments`](super::law::increments) gives for that path.

use super::law::{Law, Normal, increments};
use crate::lanes::dispatch::{Kernel, dispatch};
use crate::lanes::{LANES, Lane};

/// Which distribution the increments have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Increments {
    /// Normal, those of [`Wiener`](super::Wiener).
    Normal,
}

/// The increments of `processes` processes over the four steps 4 `block` … 4 `block` + 3, each of standard deviation `scale` = √h.
///
/// Path `first_path` + [`LANES`] `tile` + `lane` (modulo 2⁶⁴) and process `p` (from 0) are in
/// `out[tile * processes + p][step % 4][lane]`; there are as many tiles as `out` has room for.
#[inline(never)]
pub(crate) fn fill(
    increments: Increments,
    seed: u64,
    first_path: u64,
    block: u64,
    scale: f64,
    processes: usize,
    out: &mut [[Lane; 4]],
) {
    let fill = Fill {
        seed,
        first_path,
        block,
        scale,
        processes,
        out,
        law: Normal,
    };
    match increments {
        Increments::Normal => dispatch(fill),
    }
}

struct Fill<'a, L> {
    seed: u64,
    first_path: u64,
    block: u64,
    scale: f64,
    processes: usize,
    out: &'a mut [[Lane; 4]],
    #[allow(dead_code)]
    law: L,
}

impl<L: Law> Kernel for Fill<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        if self.processes == 0 {
            return;
        }
        for (tile, rows) in self.out.chunks_exact_mut(self.processes).enumerate() {
            let first = self.first_path.wrapping_add((tile * LANES) as u64);
            for (process, [a, b, c, d]) in rows.iter_mut().enumerate() {
                for lane in 0..LANES {
                    let path = first.wrapping_add(lane as u64);
                    [a[lane], b[lane], c[lane], d[lane]] =
                        increments::<L>(self.seed, path, self.block, process as u64, self.scale);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Increments, LANES, fill};
    use crate::noise::Wiener;

    #[test]
    fn the_bits_of_single_paths() {
        let (seed, h) = (7, 0.037_f64);
        for (first, block, processes, tiles) in [
            (0, 0, 1, 1),
            (u64::MAX - 20, 5, 2, 3),
            (123_456, u64::MAX / 4, 3, 2),
        ] {
            let mut out = vec![[[f64::NAN; LANES]; 4]; processes * tiles];
            fill(
                Increments::Normal,
                seed,
                first,
                block,
                h.sqrt(),
                processes,
                &mut out,
            );
            for (row, steps) in out.iter().enumerate() {
                for (step, lanes) in steps.iter().enumerate() {
                    for (lane, dw) in lanes.iter().enumerate() {
                        let path = first.wrapping_add((row / processes * LANES + lane) as u64);
                        let single = Wiener::new(seed).path(path);
                        let step = 4 * block + step as u64;
                        assert_eq!(*dw, single.increment(step, row % processes, h));
                    }
                }
            }
        }
    }
}
