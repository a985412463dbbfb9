//! Wiener paths from a counter-based generator.
//!
//! Input: seed, path, step, process and step size. Output: √h z with z a standard normal.
//! Invariant: z is a pure function of (seed, path, step, process), the same bits on every machine.

use super::blocks::Blocks;
use super::law::Normal;
use super::{Noise, NoiseError};

/// Wiener paths from a seed: any step of any path, in any order, always the same.
///
/// An increment is a pure function of the seed, the path, the step and the process: nothing is consumed. So a path can be
/// replayed, restarted in the middle and shared between threads or machines by its two numbers alone, and
/// two systems given equal `Wiener`s feel the same noise. Different seeds, paths, steps and processes are independent,
/// neighbouring ones too. The bits are the same on every platform: normals are made by arithmetic and square
/// roots alone, without a library's `ln`, `sin` and `cos`.
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
/// A trajectory begins at step 0 of its source. One that goes on from a state reached after `k` steps takes
/// [`from_step(k)`](super::Replayable::from_step), or the noise of these steps would come again.
///
/// The same path in smaller steps is [`refine`](Self::refine).
///
/// Generator: Threefry4x64-13 of Salmon, Moraes, Dror and Shaw (2011); normals by Box and Muller (1958).
#[derive(Clone, Debug)]
pub struct Wiener(pub(super) Blocks<Normal>);

impl Wiener {
    /// Path 0 of a seed. Every seed is as good as any other.
    pub fn new(seed: u64) -> Self {
        Self(Blocks::new(seed))
    }

    /// Path number `path` of the same seed.
    #[must_use]
    pub fn path(self, path: u64) -> Self {
        Self(self.0.path(path))
    }

    /// The increment of a process (from 0) over step number `step` (from 0) of length `h`.
    ///
    /// The same number as [`Noise::increments`] gives, at four times the cost in a sequence of steps.
    /// NaN where `h` is negative or NaN, as `h.sqrt()` is.
    #[inline]
    pub fn increment(&self, step: u64, process: usize, h: f64) -> f64 {
        self.0.increment(step, process, h)
    }
}

impl Noise for Wiener {
    #[inline]
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.0.increments(step, h, dw)
    }
}
