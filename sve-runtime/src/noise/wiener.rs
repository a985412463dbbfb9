//! Wiener paths from a counter-based generator.
//!
//! Input: seed, path, step, process and step size. Output: √h z with z a standard normal.
//! Invariant: z is a pure function of (seed, path, step, process); what is kept between calls only saves work.
//!
//! Layout: the key of [`threefry`] is (seed, path, domain, 0), the counter is (step / 4, process, 0, 0), and the four
//! words of that block are the four normals of the steps 4k … 4k+3 of one process. Changing any of this changes every
//! published result: it is part of the public contract, and the tests hold its values.

use super::error::check_step;
use super::law::{self, Normal, place};
use super::{Noise, NoiseError};

/// Wiener paths from a seed: any step of any path, in any order, always the same.
///
/// An increment is a pure function of the seed, the path, the step and the process: nothing is consumed. So a path can be
/// replayed, restarted in the middle and shared between threads or machines by its two numbers alone, and
/// two systems given equal `Wiener`s feel the same noise. Different seeds, paths, steps and processes are independent,
/// neighbouring ones too. The random bits are the same everywhere; the last digit of an increment may depend on the
/// platform's `ln`, `sin` and `cos`.
///
/// An increment has variance `h` and never exceeds 9.4926 √h in size.
///
/// As [`Noise`] it keeps a block of four steps for each process, so it costs least in sequence; there it refuses an `h` that is not positive and finite
/// ([`NoiseError::InvalidStep`]), and has no other error.
///
/// ```
/// use sve_runtime::noise::{Noise, Wiener};
///
/// let paths = Wiener::new(42);
/// let mut path = paths.clone().path(3);
/// let mut dw = [0.0; 2];
/// for step in [0, 1, 1_000_000, 5] {
///     path.increments(step, 0.01, &mut dw)?;
///     assert_eq!(dw[0], path.increment(step, 0, 0.01));
///     assert_ne!(dw[0], paths.increment(step, 0, 0.01)); // that is path 0
/// }
/// # Ok::<(), sve_runtime::noise::NoiseError>(())
/// ```
///
/// Generator: Threefry4x64-13 of Salmon, Moraes, Dror and Shaw (2011); normals by Box and Muller (1958).
#[derive(Clone, Debug)]
pub struct Wiener {
    seed: u64,
    path: u64,
    /// Which four steps `increments` belongs to, and their step size.
    block: Option<(u64, f64)>,
    /// One entry a process.
    increments: Vec<[f64; 4]>,
}

impl Wiener {
    /// Path 0 of a seed. Every seed is as good as any other.
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            path: 0,
            block: None,
            increments: Vec::new(),
        }
    }

    /// Path number `path` of the same seed.
    #[must_use]
    pub fn path(self, path: u64) -> Self {
        Self {
            path,
            block: None,
            ..self
        }
    }

    /// The increment of a process (from 0) over step number `step` (from 0) of length `h`.
    ///
    /// The same number as [`Noise::increments`] gives, at four times the cost in a sequence of steps.
    /// NaN where `h` is negative or NaN, as `h.sqrt()` is.
    #[inline]
    pub fn increment(&self, step: u64, process: usize, h: f64) -> f64 {
        let (block, at) = place(step);
        self.draw(block, process, h.sqrt())[at]
    }

    /// The increments of one process over the four steps of a block.
    #[inline]
    fn draw(&self, block: u64, process: usize, scale: f64) -> [f64; 4] {
        law::increments::<Normal>(self.seed, self.path, block, process as u64, scale)
    }

    fn fill(&mut self, block: u64, processes: usize, h: f64) -> Result<(), NoiseError> {
        check_step(h)?;
        let scale = h.sqrt();
        if self.increments.len() < processes {
            self.increments.resize(processes, [0.0; 4]);
        }
        for process in 0..self.increments.len() {
            self.increments[process] = self.draw(block, process, scale);
        }
        self.block = Some((block, h));
        Ok(())
    }
}

impl Noise for Wiener {
    #[inline]
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        let (block, at) = place(step);
        if self.block != Some((block, h)) || self.increments.len() < dw.len() {
            self.fill(block, dw.len(), h)?;
        }
        for (dw, four) in dw.iter_mut().zip(&self.increments) {
            *dw = four[at];
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Noise, Wiener};
    use crate::noise::law::{Law, Normal};
    use crate::noise::{box_muller, threefry};

    #[test]
    fn layout() {
        let path = Wiener::new(11).path(22);
        for (step, process) in [(0, 0), (3, 1), (4, 0), (4_000_001, 7), (u64::MAX, 2)] {
            let words = threefry::block([step / 4, process, 0, 0], [11, 22, Normal::DOMAIN, 0]);
            let four = box_muller::four(words, 1.0);
            let expected = 0.25_f64.sqrt() * four[(step % 4) as usize];
            assert_eq!(path.increment(step, process as usize, 0.25), expected);
        }
        assert_eq!(Normal::DOMAIN.to_le_bytes(), *b"wiener  ");
    }

    #[test]
    fn keeps_its_block_and_its_memory() {
        let mut path = Wiener::new(1);
        let mut dw = [0.0; 3];
        path.increments(8, 0.1, &mut dw).unwrap();
        let memory = path.increments.as_ptr();
        for step in [9, 10, 11, 12, 0, u64::MAX] {
            path.increments(step, 0.1, &mut dw).unwrap();
            assert_eq!(path.block, Some((step / 4, 0.1)));
            assert_eq!(path.increments.as_ptr(), memory);
        }
        path.increments(u64::MAX, 0.1, &mut dw[..1]).unwrap();
        assert_eq!(path.increments.len(), 3);
    }
}
