//! Increments of many paths at once.
//!
//! Input: a block of four steps, the paths and processes. Output: their increments, in lanes of consecutive paths.
//! Invariant: each has the bits that [`law::increments`](super::law::increments) gives for that path.

use core::marker::PhantomData;

use super::law::{Law, Normal, ThreePoints, words};
use crate::lanes::dispatch::{Kernel, dispatch};
use crate::lanes::{LANES, Lane};

/// Which distribution the increments have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Increments {
    /// Normal, those of [`Wiener`](super::Wiener).
    Normal,
    /// Those of [`ThreePoint`](super::ThreePoint).
    ThreePoint,
}

/// The increments of `processes` processes over the four steps 4 `block` … 4 `block` + 3, each of standard deviation `scale` = √h.
///
/// Path `first_path` + [`LANES`] `tile` + `lane` (modulo 2⁶⁴) and process `p` (from 0) are in
/// `out[tile * processes + p][step % 4][lane]`; there are as many tiles as `out` has room for. Many tiles a call save the cost of
/// the call, which is that of some ten increments; what is filled should stay in the first cache.
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
    };
    // x86-64 converts words in vectors since AVX-512
    #[cfg(target_arch = "x86_64")]
    let direct = std::arch::is_x86_feature_detected!("avx512dq");
    #[cfg(not(target_arch = "x86_64"))]
    let direct = true;
    match (increments, direct) {
        (Increments::Normal, true) => dispatch(OfLaw::<Normal, true>(fill, PhantomData)),
        (Increments::Normal, false) => dispatch(OfLaw::<Normal, false>(fill, PhantomData)),
        (Increments::ThreePoint, _) => dispatch(OfLaw::<ThreePoints, true>(fill, PhantomData)),
    }
}

struct Fill<'a> {
    seed: u64,
    first_path: u64,
    block: u64,
    scale: f64,
    processes: usize,
    out: &'a mut [[Lane; 4]],
}

struct OfLaw<'a, L, const DIRECT: bool>(Fill<'a>, PhantomData<L>);

impl<L: Law, const DIRECT: bool> Kernel for OfLaw<'_, L, DIRECT> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Fill {
            seed,
            first_path,
            block,
            scale,
            processes,
            out,
        } = self.0;
        let (mut first, mut process) = (first_path, 0);
        for row in out {
            let of_lane =
                |lane| words::<L>(seed, first.wrapping_add(lane as u64), block, process as u64);
            L::row::<DIRECT>(of_lane, scale, row);
            process += 1;
            if process == processes {
                process = 0;
                first = first.wrapping_add(LANES as u64);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use core::marker::PhantomData;

    use super::{Fill, Increments, LANES, Lane, OfLaw, fill};
    use crate::lanes::dispatch::{Kernel, versions};
    use crate::noise::law::{Law, Normal, ThreePoints};
    use crate::noise::{ThreePoint, Wiener};

    /// First path, block, processes, tiles.
    const CASES: [(u64, u64, usize, usize); 4] = [
        (0, 0, 1, 1),
        (u64::MAX - 20, 5, 2, 3),
        (123_456, u64::MAX / 4, 3, 2),
        (1 << 40, 1 << 30, 1, 40),
    ];

    #[test]
    fn the_bits_of_single_paths() {
        let (seed, h) = (7, 0.037_f64);
        for law in [Increments::Normal, Increments::ThreePoint] {
            let single = |path, step, process| match law {
                Increments::Normal => Wiener::new(seed).path(path).increment(step, process, h),
                Increments::ThreePoint => {
                    ThreePoint::new(seed).path(path).increment(step, process, h)
                }
            };
            for (first, block, processes, tiles) in CASES {
                let mut out = vec![[[f64::NAN; LANES]; 4]; processes * tiles];
                fill(law, seed, first, block, h.sqrt(), processes, &mut out);
                for (row, steps) in out.iter().enumerate() {
                    for (step, lanes) in steps.iter().enumerate() {
                        for (lane, dw) in lanes.iter().enumerate() {
                            let path = first.wrapping_add((row / processes * LANES + lane) as u64);
                            let expected = single(path, 4 * block + step as u64, row % processes);
                            assert_eq!(
                                dw.to_bits(),
                                expected.to_bits(),
                                "{law:?} {row} {step} {lane}"
                            );
                        }
                    }
                }
            }
        }
    }

    /// A fill with memory of its own.
    #[derive(Clone)]
    struct Filled<L, const DIRECT: bool> {
        case: (u64, u64, usize, usize),
        law: PhantomData<L>,
    }

    impl<L: Law, const DIRECT: bool> Kernel for Filled<L, DIRECT> {
        type Output = Vec<[Lane; 4]>;

        #[inline(always)]
        fn run(self) -> Self::Output {
            let (first_path, block, processes, tiles) = self.case;
            let mut out = vec![[[f64::NAN; LANES]; 4]; processes * tiles];
            let fill = Fill {
                seed: 11,
                first_path,
                block,
                scale: 0.3,
                processes,
                out: &mut out,
            };
            OfLaw::<L, DIRECT>(fill, PhantomData).run();
            out
        }
    }

    fn assert_versions_agree<L: Law>() {
        for case in CASES {
            let law = PhantomData::<L>;
            let mut all = versions(&Filled::<L, true> { case, law });
            all.extend(versions(&Filled::<L, false> { case, law }));
            let bits = |out: &Vec<[Lane; 4]>| {
                let numbers = out.as_flattened().as_flattened();
                numbers.iter().map(|z| z.to_bits()).collect::<Vec<_>>()
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
    fn what_does_not_fill_is_fine() {
        fill(Increments::Normal, 1, 0, 0, 1.0, 0, &mut []);
        fill(Increments::ThreePoint, 1, 0, 0, 1.0, 3, &mut []);
    }
}
