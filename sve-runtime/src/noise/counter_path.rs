//! A counter-based path: increments that are a pure function of seed, path, step and process.
//!
//! Input: seed, path, step, process, step size and a distribution. Output: increments of variance h.
//! Invariant: the increments kept between calls save work and change no result.

use core::marker::PhantomData;

use super::NoiseError;
use super::distribution::{self, Distribution, block_of};
use super::error::check_step;

/// Number of processes whose increments are kept. Those of further processes are drawn in each step, which costs four times as much.
const KEPT: usize = 8;

/// A path with increments of a distribution.
#[derive(Clone, Copy, Debug)]
pub(super) struct CounterPath<D> {
    pub(super) seed: u64,
    pub(super) path: u64,
    distribution: PhantomData<D>,
    /// The block of four steps that `increments` belongs to, and their step size.
    block: Option<(u64, f64)>,
    /// Number of processes whose increments are in `increments`.
    processes: usize,
    /// The increments of four steps for each process. A row in place, so that a path is `Copy`.
    increments: [[f64; 4]; KEPT],
}

impl<D: Distribution> CounterPath<D> {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            seed,
            path: 0,
            distribution: PhantomData,
            block: None,
            processes: 0,
            increments: [[0.0; 4]; KEPT],
        }
    }

    pub(super) fn path(&self, path: u64) -> Self {
        Self {
            path,
            ..Self::new(self.seed)
        }
    }

    #[inline]
    pub(super) fn increment(&self, step: u64, process: usize, h: f64) -> f64 {
        let (block, at) = block_of(step);
        self.draw(block, process, h.abs().sqrt())[at]
    }

    #[inline]
    pub(super) fn increments(
        &mut self,
        step: u64,
        h: f64,
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        let (block, at) = block_of(step);
        let kept = dw.len().min(KEPT);
        if self.block != Some((block, h)) || self.processes < kept {
            self.fill(block, kept, h)?;
        }
        for (dw, four) in dw.iter_mut().zip(&self.increments) {
            *dw = four[at];
        }
        for process in KEPT..dw.len() {
            dw[process] = self.increment(step, process, h);
        }
        Ok(())
    }

    /// Returns the increments of one process over the four steps of a block.
    #[inline]
    fn draw(&self, block: u64, process: usize, scale: f64) -> [f64; 4] {
        distribution::increments::<D>(self.seed, self.path, block, process as u64, scale)
    }

    fn fill(&mut self, block: u64, processes: usize, h: f64) -> Result<(), NoiseError> {
        check_step(h)?;
        let scale = h.abs().sqrt();
        self.processes = self.processes.max(processes);
        for process in 0..self.processes {
            self.increments[process] = self.draw(block, process, scale);
        }
        self.block = Some((block, h));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{CounterPath, KEPT};
    use crate::noise::distribution::{Distribution, Normal, ThreePoints};
    use crate::noise::threefry;

    fn check_layout<D: Distribution>(domain: [u8; 8]) {
        let path = CounterPath::<D>::new(11).path(22);
        for (step, process) in [(0, 0), (3, 1), (4, 0), (4_000_001, 7), (u64::MAX, 2)] {
            let domain = u64::from_le_bytes(domain);
            let words = threefry::block([step / 4, process, 0, 0], [11, 22, domain, 0]);
            let expected = D::four(words, 0.5)[(step % 4) as usize];
            assert_eq!(path.increment(step, process as usize, 0.25), expected);
        }
    }

    #[test]
    fn words_are_laid_out_as_documented() {
        check_layout::<Normal>(*b"wiener  ");
        check_layout::<ThreePoints>(*b"3-points");
    }

    #[test]
    fn a_path_keeps_its_block() {
        let mut path = CounterPath::<Normal>::new(1);
        let mut dw = [0.0; 3];
        for step in [8, 9, 10, 11, 12, 0, u64::MAX] {
            path.increments(step, 0.1, &mut dw).unwrap();
            assert_eq!(path.block, Some((step / 4, 0.1)));
        }
        path.increments(u64::MAX, 0.1, &mut dw[..1]).unwrap();
        assert_eq!(path.processes, 3);
    }

    #[test]
    fn processes_beyond_those_kept_have_their_own_increments() {
        let mut path = CounterPath::<Normal>::new(1);
        let mut dw = [0.0; 2 * KEPT + 3];
        for (step, processes) in [(3, 2), (3, dw.len()), (4, dw.len()), (5, KEPT), (9, 1)] {
            path.increments(step, 0.1, &mut dw[..processes]).unwrap();
            for (process, &dw) in dw[..processes].iter().enumerate() {
                assert_eq!(dw, path.increment(step, process, 0.1));
            }
        }
    }
}
