//! Increments of many paths at once, a lane for each path.
//!
//! Input: a block of four steps, the paths of the lanes, and processes. Output: their increments.
//! Invariant: each increment has the bits that [`distribution::increments`](super::distribution::increments) gives for its path.

use core::marker::PhantomData;

use super::distribution::{Distribution, Normal, ThreePoints, words};
use crate::lanes::dispatch::{Kernel, dispatch};
use crate::lanes::{Aligned, LANES, Lane};

/// The distribution of increments, as a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DistributionKind {
    /// The normal distribution of [`Wiener`](super::Wiener).
    Normal,
    /// The distribution of [`ThreePoint`](super::ThreePoint).
    ThreePoint,
}

/// Fills `out` with the increments of `processes` processes over the four steps 4 `block` … 4 `block` + 3, each of standard deviation `scale` = √h.
///
/// Path `paths[tile][lane]` and process `p` (from 0) are in
/// `out[tile * processes + p][step % 4][lane]`; the length of `out` gives the number of tiles. A call costs as much as some ten increments, so
/// many tiles in a call save time; `out` should fit into the first cache.
#[inline(never)]
pub(crate) fn fill(
    distribution: DistributionKind,
    seed: u64,
    paths: &[[u64; LANES]],
    block: u64,
    scale: f64,
    processes: usize,
    out: &mut [Aligned<[Lane; 4]>],
) {
    let fill = Fill {
        seed,
        paths,
        block,
        scale,
        processes,
        out,
    };
    // x86-64 converts words in vectors since AVX-512
    #[cfg(target_arch = "x86_64")]
    let direct = std::arch::is_x86_feature_detected!("avx512dq");
    #[cfg(not(target_arch = "x86_64"))]
    let direct = true;
    match (distribution, direct) {
        (DistributionKind::Normal, true) => dispatch(FillFrom::<Normal, true>(fill, PhantomData)),
        (DistributionKind::Normal, false) => dispatch(FillFrom::<Normal, false>(fill, PhantomData)),
        (DistributionKind::ThreePoint, _) => {
            dispatch(FillFrom::<ThreePoints, true>(fill, PhantomData));
        }
    }
}

struct Fill<'a> {
    seed: u64,
    paths: &'a [[u64; LANES]],
    block: u64,
    scale: f64,
    processes: usize,
    out: &'a mut [Aligned<[Lane; 4]>],
}

/// A fill with increments of a distribution.
struct FillFrom<'a, D, const DIRECT: bool>(Fill<'a>, PhantomData<D>);

impl<D: Distribution, const DIRECT: bool> Kernel for FillFrom<'_, D, DIRECT> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Fill {
            seed,
            paths,
            block,
            scale,
            processes,
            out,
        } = self.0;
        let rows = paths
            .iter()
            .flat_map(|paths| (0..processes).map(move |p| (paths, p)));
        for (row, (paths, process)) in out.iter_mut().zip(rows) {
            let of_lane = |lane: usize| words::<D>(seed, paths[lane], block, process as u64);
            D::fill_lanes::<DIRECT>(of_lane, scale, &mut row.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::lanes::Aligned;
    use core::marker::PhantomData;

    use super::{DistributionKind, Fill, FillFrom, LANES, Lane, fill};
    use crate::lanes::dispatch::{Kernel, versions};
    use crate::noise::distribution::{Distribution, Normal, ThreePoints};
    use crate::noise::{ThreePoint, Wiener};

    /// First path, block, processes, tiles.
    const CASES: [(u64, u64, usize, usize); 4] = [
        (0, 0, 1, 1),
        (u64::MAX - 20, 5, 2, 3),
        (123_456, u64::MAX / 4, 3, 2),
        (1 << 40, 1 << 30, 1, 40),
    ];

    /// Consecutive paths in the lanes of tiles.
    fn consecutive(first: u64, tiles: usize) -> Vec<[u64; LANES]> {
        let path = |tile, lane| first.wrapping_add((tile * LANES + lane) as u64);
        let tile = |tile| core::array::from_fn(|lane| path(tile, lane));
        (0..tiles).map(tile).collect()
    }

    #[test]
    fn increments_have_the_bits_of_single_paths() {
        let (seed, h) = (7, 0.037_f64);
        for distribution in [DistributionKind::Normal, DistributionKind::ThreePoint] {
            let single = |path, step, process| match distribution {
                DistributionKind::Normal => {
                    Wiener::new(seed).path(path).increment(step, process, h)
                }
                DistributionKind::ThreePoint => {
                    ThreePoint::new(seed).path(path).increment(step, process, h)
                }
            };
            for (first, block, processes, tiles) in CASES {
                let mut out = vec![Aligned([[f64::NAN; LANES]; 4]); processes * tiles];
                fill(
                    distribution,
                    seed,
                    &consecutive(first, tiles),
                    block,
                    h.sqrt(),
                    processes,
                    &mut out,
                );
                for (row, steps) in out.iter().enumerate() {
                    for (step, lanes) in steps.0.iter().enumerate() {
                        for (lane, dw) in lanes.iter().enumerate() {
                            let path = first.wrapping_add((row / processes * LANES + lane) as u64);
                            let expected = single(path, 4 * block + step as u64, row % processes);
                            assert_eq!(
                                dw.to_bits(),
                                expected.to_bits(),
                                "{distribution:?} {row} {step} {lane}"
                            );
                        }
                    }
                }
            }
        }
    }

    /// A fill of its own memory.
    #[derive(Clone)]
    struct Filled<D, const DIRECT: bool> {
        case: (u64, u64, usize, usize),
        distribution: PhantomData<D>,
    }

    impl<D: Distribution, const DIRECT: bool> Kernel for Filled<D, DIRECT> {
        type Output = Vec<Aligned<[Lane; 4]>>;

        #[inline(always)]
        fn run(self) -> Self::Output {
            let (first_path, block, processes, tiles) = self.case;
            let mut out = vec![Aligned([[f64::NAN; LANES]; 4]); processes * tiles];
            let fill = Fill {
                seed: 11,
                paths: &consecutive(first_path, tiles),
                block,
                scale: 0.3,
                processes,
                out: &mut out,
            };
            FillFrom::<D, DIRECT>(fill, PhantomData).run();
            out
        }
    }

    fn assert_versions_agree<D: Distribution>() {
        for case in CASES {
            let distribution = PhantomData::<D>;
            let mut all = versions(&Filled::<D, true> { case, distribution });
            all.extend(versions(&Filled::<D, false> { case, distribution }));
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
        fill(DistributionKind::Normal, 1, &[], 0, 1.0, 0, &mut []);
        fill(DistributionKind::ThreePoint, 1, &[], 0, 1.0, 3, &mut []);
    }
}
