//! A counter-based path: increments that are a pure function of seed, path, step and process.
//!
//! Input: seed, path, step, process, step size and a distribution. Output: increments of variance
//! h. Invariant: the increments kept between calls save work and change no result.

use core::marker::PhantomData;

use super::distribution::{BY_STEPS, Distribution, PathKey, SHARED, Workspace};
use super::{Noise, NoiseError};
use crate::error::check_step;
use crate::lanes::Aligned;
use crate::lanes::dispatch::{VectorKernel, dispatch_vectors};

/// Number of blocks drawn at once, in lanes: a register of AVX-512.
const LANES: usize = 8;

/// Number of rows that a path keeps.
const ROWS: usize = 4;

/// Four increments of each block.
type Rows = Aligned<[[f64; LANES]; SHARED]>;

/// The content of the lanes: blocks of steps of one process in each row, or processes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Layout {
    /// For few processes: row `a` has 32 steps of process `a`.
    Steps,
    /// For more processes: row `r` has four steps of the processes from `8 r` on.
    Processes,
}

impl Layout {
    fn of(processes: usize) -> Self {
        if processes <= ROWS {
            Self::Steps
        } else {
            Self::Processes
        }
    }

    /// Returns the number of blocks of four steps that are kept.
    fn blocks(self) -> u64 {
        match self {
            Self::Steps => LANES as u64,
            Self::Processes => 1,
        }
    }
}

/// A path with increments of a distribution. It holds them in place, so that a path is `Copy`.
#[derive(Clone, Copy, Debug)]
pub(super) struct CounterPath<D> {
    pub(super) seed: u64,
    pub(super) path: u64,
    distribution: PhantomData<D>,
    /// The first block of steps in `increments`, their step size, and the content of the lanes.
    kept: Option<(u64, f64, Layout)>,
    /// Number of processes that are kept.
    processes: usize,
    /// The increments of processes whose blocks are shared by steps. The increments of step `k` are
    /// in place `k` modulo 4 of a row.
    increments: [Rows; ROWS],
}

impl<D: Distribution> CounterPath<D> {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            seed,
            path: 0,
            distribution: PhantomData,
            kept: None,
            processes: 0,
            increments: [Aligned([[0.0; LANES]; SHARED]); ROWS],
        }
    }

    pub(super) fn path(&self, path: u64) -> Self {
        Self {
            path,
            ..Self::new(self.seed)
        }
    }

    fn key(&self) -> PathKey {
        PathKey {
            seed: self.seed,
            path: self.path,
        }
    }

    pub(super) fn increment(&self, step: u64, process: usize, h: f64) -> f64 {
        self.key().increment::<D>(step, process, h.abs().sqrt())
    }

    #[inline(never)]
    fn fill(&mut self, first_block: u64, processes: usize, h: f64) -> Result<(), NoiseError> {
        check_step(h)?;
        let layout = Layout::of(processes);
        let rows = match layout {
            Layout::Steps => processes,
            Layout::Processes => processes.div_ceil(LANES),
        };
        dispatch_vectors(BySteps {
            key: self.key(),
            first_block,
            layout,
            scale: h.abs().sqrt(),
            distribution: self.distribution,
            out: &mut self.increments[..rows],
        });
        self.kept = Some((first_block, h, layout));
        self.processes = processes;
        Ok(())
    }

    /// Draws the increments of all further processes over a step.
    #[inline(never)]
    fn draw_by_processes(&self, step: u64, h: f64, out: &mut [f64]) {
        dispatch_vectors(ByProcesses {
            key: self.key(),
            step,
            scale: h.abs().sqrt(),
            distribution: self.distribution,
            out,
        });
    }
}

impl<D: Distribution> Noise for CounterPath<D> {
    #[inline]
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        let processes = dw.len().min(BY_STEPS);
        let layout = Layout::of(processes);
        let (block, at) = (step / SHARED as u64, (step % SHARED as u64) as usize);
        let lane = (block % layout.blocks()) as usize;
        let first = block - lane as u64;
        if self.kept != Some((first, h, layout)) || self.processes < processes {
            self.fill(first, processes, h)?;
        }
        let (by_steps, by_processes) = dw.split_at_mut(processes);
        match layout {
            Layout::Steps => {
                for (dw, rows) in by_steps.iter_mut().zip(&self.increments) {
                    *dw = rows.0[at][lane];
                }
            }
            Layout::Processes => {
                for (dw, rows) in by_steps.chunks_mut(LANES).zip(&self.increments) {
                    dw.copy_from_slice(&rows.0[at][..dw.len()]);
                }
            }
        }
        if !by_processes.is_empty() {
            self.draw_by_processes(step, h, by_processes);
        }
        Ok(())
    }
}

/// The increments of the first processes over some steps.
struct BySteps<'a, D> {
    key: PathKey,
    first_block: u64,
    layout: Layout,
    scale: f64,
    distribution: PhantomData<D>,
    out: &'a mut [Rows],
}

impl<D: Distribution> VectorKernel for BySteps<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<const AVX512: bool>(self) {
        let mut work = Workspace::new();
        for (row, rows) in (0..).zip(self.out) {
            let words = |lane| {
                let lane = lane as u64;
                let (block, process) = match self.layout {
                    Layout::Steps => (self.first_block + lane, row),
                    Layout::Processes => (self.first_block, row * LANES as u64 + lane),
                };
                self.key.words_by_steps::<D>(block, process)
            };
            D::fill_lanes::<LANES, AVX512>(words, self.scale, &mut work, &mut rows.0);
        }
    }
}

/// The increments of the processes from [`BY_STEPS`] on over a step.
struct ByProcesses<'a, D> {
    key: PathKey,
    step: u64,
    scale: f64,
    distribution: PhantomData<D>,
    out: &'a mut [f64],
}

impl<D: Distribution> VectorKernel for ByProcesses<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<const AVX512: bool>(self) {
        let mut first_group = (BY_STEPS / SHARED) as u64;
        let mut work = Workspace::new();
        let mut rows = Aligned([[0.0; LANES]; SHARED]);
        for out in self.out.chunks_mut(LANES * SHARED) {
            let words = |lane| {
                let group = first_group + lane as u64;
                self.key.words_by_processes::<D>(self.step, group)
            };
            D::fill_lanes::<LANES, AVX512>(words, self.scale, &mut work, &mut rows.0);
            for (at, out) in out.iter_mut().enumerate() {
                *out = rows.0[at % SHARED][at / SHARED];
            }
            first_group += LANES as u64;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{BY_STEPS, CounterPath, Layout};
    use crate::noise::Noise as _;
    use crate::noise::distribution::Distribution;
    use crate::noise::three_point::ThreePoints;
    use crate::noise::threefry;
    use crate::noise::wiener::Normal;

    fn check_layout<D: Distribution>(domain: [u8; 8]) {
        let path = CounterPath::<D>::new(11).path(22);
        let domain = u64::from_le_bytes(domain);
        let key = [11, 22, domain, 0];
        let check = |step, process, counter, at: u64| {
            let expected = D::four(threefry::block(counter, key), 0.5)[at as usize];
            assert_eq!(path.increment(step, process as usize, 0.25), expected);
        };
        for (step, process) in [(0, 0), (3, 1), (4, 0), (4_000_001, 15), (u64::MAX, 2)] {
            check(step, process, [step / 4, process, 0, 0], step % 4);
        }
        for (step, process) in [(0, 16), (3, 17), (4, 23), (4_000_001, 1000), (u64::MAX, 18)] {
            check(step, process, [step, process / 4, 1, 0], process % 4);
        }
    }

    #[test]
    fn words_are_laid_out_as_documented() {
        check_layout::<Normal>(*b"wiener  ");
        check_layout::<ThreePoints>(*b"3-points");
    }

    /// Checks numbers of processes below, at and above the borders of both kinds of blocks.
    #[test]
    fn a_draw_of_all_processes_has_the_bits_of_each() {
        fn check<D: Distribution>() {
            for processes in [1, 3, 15, 16, 17, 19, 20, 48, 49, 100] {
                let mut path = CounterPath::<D>::new(3).path(5);
                let mut dw = vec![f64::NAN; processes];
                for step in [0, 1, 2, 3, 4, 31, 32, 33, 1000, u64::MAX - 1, u64::MAX] {
                    path.increments(step, 0.3, &mut dw).unwrap();
                    for (process, dw) in dw.iter().enumerate() {
                        let one = path.increment(step, process, 0.3);
                        assert_eq!(dw.to_bits(), one.to_bits(), "{processes} {step} {process}");
                    }
                }
            }
        }
        check::<Normal>();
        check::<ThreePoints>();
    }

    #[test]
    fn a_path_keeps_its_steps() {
        let mut path = CounterPath::<Normal>::new(1);
        let mut dw = [0.0; 3];
        for step in [8, 9, 10, 31, 32, 0, u64::MAX] {
            path.increments(step, 0.1, &mut dw).unwrap();
            let first = step / 32 * 8;
            assert_eq!(path.kept, Some((first, 0.1, Layout::Steps)));
        }
        path.increments(u64::MAX, 0.1, &mut dw[..1]).unwrap();
        assert_eq!(path.processes, 3);
        path.increments(5, 0.1, &mut [0.0; 1000]).unwrap();
        assert_eq!(path.kept, Some((1, 0.1, Layout::Processes)));
        assert_eq!(path.processes, BY_STEPS);
    }

    /// Checks numbers of processes that change from step to step.
    #[test]
    fn other_numbers_of_processes_have_the_same_bits() {
        let mut path = CounterPath::<Normal>::new(7);
        let mut dw = [0.0; 20];
        for (step, processes) in (0..).zip([1, 4, 5, 3, 16, 20, 9, 2, 8, 4, 17]) {
            path.increments(step, 0.1, &mut dw[..processes]).unwrap();
            for (process, dw) in dw[..processes].iter().enumerate() {
                assert_eq!(*dw, path.increment(step, process, 0.1));
            }
        }
    }
}
