//! Increments of many paths at once, a lane for each path.
//!
//! Input: a block of four steps, the paths of the lanes, and processes. Output: their increments.
//! Invariant: each increment has the bits that [`PathKey::increment`] gives for its path.

use core::marker::PhantomData;

use super::distribution::{BY_STEPS, Distribution, PathKey, SHARED, Workspace};
use crate::lanes::dispatch::{VectorKernel, dispatch_vectors};
use crate::lanes::{Aligned, LANES, Lane};

/// The increments of a tile over the four steps of a block.
pub(crate) type Rows = Aligned<[Lane; SHARED]>;

/// The paths, steps and processes whose increments are drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draw<'a> {
    pub(crate) seed: u64,
    /// The path in each lane of each tile.
    pub(crate) paths: &'a [[u64; LANES]],
    /// The first block of four steps.
    pub(crate) first_block: u64,
    /// The standard deviation, √h.
    pub(crate) scale: f64,
    pub(crate) processes: usize,
}

/// Fills `out` with the increments of all processes of all tiles over blocks of four steps.
///
/// Tile `t` and process `p` (from 0) over step 4 (`first_block` + `b`) + `k` are in
/// `out[(b * tiles + t) * processes + p][k]`; the length of `out` gives the number of blocks. The
/// overhead of a call equals the cost of about ten increments, so many rows in a call save time;
/// `out` should fit into the first cache.
#[inline(never)]
pub(super) fn fill<D: Distribution>(draw: &Draw<'_>, out: &mut [Rows]) {
    if draw.processes == 0 || draw.paths.is_empty() {
        return;
    }
    dispatch_vectors(Fill::<D> {
        draw: *draw,
        out,
        distribution: PhantomData,
    });
}

/// A fill with increments of a distribution.
struct Fill<'a, D> {
    draw: Draw<'a>,
    out: &'a mut [Rows],
    distribution: PhantomData<D>,
}

impl Draw<'_> {
    /// Returns the key of the path in a lane of a tile.
    #[inline(always)]
    fn key(&self, tile: usize, lane: usize) -> PathKey {
        PathKey {
            seed: self.seed,
            path: self.paths[tile][lane],
        }
    }

    /// Fills the rows of the first processes, one block for each row.
    #[inline(always)]
    fn fill_by_steps<D: Distribution, const AVX512: bool>(
        &self,
        [block, tile]: [usize; 2],
        work: &mut Workspace<LANES>,
        rows: &mut [Rows],
    ) {
        let block = self.first_block + block as u64;
        for (process, row) in (0..).zip(rows) {
            let words = |lane| self.key(tile, lane).words_by_steps::<D>(block, process);
            D::fill_lanes::<LANES, AVX512>(words, self.scale, work, &mut row.0);
        }
    }

    /// Fills the rows of the further processes, one block for each four rows and step.
    #[inline(always)]
    fn fill_by_processes<D: Distribution, const AVX512: bool>(
        &self,
        [block, tile]: [usize; 2],
        work: &mut Workspace<LANES>,
        rows: &mut [Rows],
    ) {
        let first_step = SHARED as u64 * (self.first_block + block as u64);
        let mut of_step = Aligned([[0.0; LANES]; SHARED]);
        let groups = rows.chunks_mut(SHARED);
        for (group, rows) in ((BY_STEPS / SHARED) as u64..).zip(groups) {
            for at in 0..SHARED {
                let step = first_step + at as u64;
                let words = |lane| self.key(tile, lane).words_by_processes::<D>(step, group);
                D::fill_lanes::<LANES, AVX512>(words, self.scale, work, &mut of_step.0);
                for (row, of_process) in rows.iter_mut().zip(of_step.0) {
                    row.0[at] = of_process;
                }
            }
        }
    }
}

impl<D: Distribution> VectorKernel for Fill<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<const AVX512: bool>(self) {
        let Self { draw, out, .. } = self;
        let mut work = Workspace::new();
        for (number, rows) in out.chunks_exact_mut(draw.processes).enumerate() {
            let tiles = draw.paths.len();
            let place = [number / tiles, number % tiles];
            let (by_steps, by_processes) = rows.split_at_mut(rows.len().min(BY_STEPS));
            draw.fill_by_steps::<D, AVX512>(place, &mut work, by_steps);
            draw.fill_by_processes::<D, AVX512>(place, &mut work, by_processes);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::lanes::Aligned;
    use core::marker::PhantomData;

    use super::{Draw, Fill, LANES, Lane, fill};
    use crate::lanes::dispatch::{VectorKernel, vector_versions};
    use crate::noise::counter_path::CounterPath;
    use crate::noise::distribution::Distribution;
    use crate::noise::three_point::ThreePoints;
    use crate::noise::wiener::Normal;

    /// Number of blocks in each case.
    const BLOCKS: usize = 3;

    /// First path, first block, processes, tiles.
    const CASES: [(u64, u64, usize, usize); 6] = [
        (0, 0, 1, 1),
        (u64::MAX - 20, 5, 2, 3),
        (3, 1 << 20, 17, 2),
        (9, 6, 23, 1),
        (123_456, u64::MAX / 4 - 2, 3, 2),
        (1 << 40, 1 << 30, 1, 40),
    ];

    /// Returns consecutive paths in the lanes of tiles.
    fn consecutive(first: u64, tiles: usize) -> Vec<[u64; LANES]> {
        let path = |tile, lane| first.wrapping_add((tile * LANES + lane) as u64);
        let tile = |tile| core::array::from_fn(|lane| path(tile, lane));
        (0..tiles).map(tile).collect()
    }

    fn increments_have_the_bits_of_single_paths<D: Distribution>() {
        let (seed, h) = (7, 0.037_f64);
        for (first, block, processes, tiles) in CASES {
            let draw = Draw {
                seed,
                paths: &consecutive(first, tiles),
                first_block: block,
                scale: h.sqrt(),
                processes,
            };
            let mut out = vec![Aligned([[f64::NAN; LANES]; 4]); BLOCKS * processes * tiles];
            fill::<D>(&draw, &mut out);
            for (row, steps) in out.iter().enumerate() {
                let (number, tile) = (row / processes / tiles, row / processes % tiles);
                for (step, lanes) in steps.0.iter().enumerate() {
                    for (lane, dw) in lanes.iter().enumerate() {
                        let path = first.wrapping_add((tile * LANES + lane) as u64);
                        let path = CounterPath::<D>::new(seed).path(path);
                        let step = 4 * (block + number as u64) + step as u64;
                        let expected = path.increment(step, row % processes, h);
                        let domain = D::DOMAIN;
                        assert_eq!(
                            dw.to_bits(),
                            expected.to_bits(),
                            "{domain} {row} {step} {lane}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn normal_increments_have_the_bits_of_single_paths() {
        increments_have_the_bits_of_single_paths::<Normal>();
    }

    #[test]
    fn increments_of_three_values_have_the_bits_of_single_paths() {
        increments_have_the_bits_of_single_paths::<ThreePoints>();
    }

    /// A fill that owns its memory.
    #[derive(Clone)]
    struct Filled<D> {
        case: (u64, u64, usize, usize),
        distribution: PhantomData<D>,
    }

    impl<D: Distribution> VectorKernel for Filled<D> {
        type Output = Vec<Aligned<[Lane; 4]>>;

        #[inline(always)]
        fn run<const AVX512: bool>(self) -> Self::Output {
            let (first_path, block, processes, tiles) = self.case;
            let mut out = vec![Aligned([[f64::NAN; LANES]; 4]); BLOCKS * processes * tiles];
            let draw = Draw {
                seed: 11,
                paths: &consecutive(first_path, tiles),
                first_block: block,
                scale: 0.3,
                processes,
            };
            let fill = Fill {
                draw,
                out: &mut out,
                distribution: self.distribution,
            };
            fill.run::<AVX512>();
            out
        }
    }

    fn assert_versions_agree<D: Distribution>() {
        for case in CASES {
            let distribution = PhantomData::<D>;
            let all = vector_versions(&Filled { case, distribution });
            let bits = |out: &Vec<Aligned<[Lane; 4]>>| {
                let numbers = out.iter().flat_map(|row| row.0.as_flattened());
                numbers.map(|z| z.to_bits()).collect::<Vec<_>>()
            };
            for version in &all {
                assert_eq!(bits(version), bits(&all[0]));
            }
        }
    }

    #[test]
    fn every_width_gives_the_same_bits() {
        assert_versions_agree::<Normal>();
        assert_versions_agree::<ThreePoints>();
    }

    #[test]
    fn an_empty_fill_does_nothing() {
        for (processes, tiles) in [(0, 1), (3, 1), (3, 0)] {
            let draw = Draw {
                seed: 1,
                paths: &consecutive(0, tiles),
                first_block: 0,
                scale: 1.0,
                processes,
            };
            fill::<Normal>(&draw, &mut []);
            fill::<ThreePoints>(&draw, &mut []);
        }
    }
}
