//! Increments of three values, for weak solutions.
//!
//! Input: seed, path, step, process and step size. Output: ±√(3h) or 0.
//! Invariant: a pure function of (seed, path, step, process), the same bits on every machine.
//!
//! Source: Kloeden, Platen, *Numerical Solution of Stochastic Differential Equations*, Springer (1992), section 14.2.

use super::counter_path::CounterPath;
use super::distribution::ThreePoints;
use super::{Noise, NoiseError};

/// Increments ±√(3h) with probability 1/6 each and 0 with 2/3, counter-based as [`Wiener`](super::Wiener).
///
/// The moments up to the fifth are those of a normal increment, so expectations converge with the same weak order, up
/// to 2. The increments are cheap and bounded by 1.74 √h, which keeps implicit steps solvable. They are not increments of a Brownian path: solutions do not converge
/// path by path, and paths with two step sizes are unrelated. Draws are independent of those of a `Wiener` of the same seed.
///
/// Its only error is [`NoiseError::InvalidStep`], for an `h` that is zero or not finite.
///
/// ```
/// use sve_runtime::noise::{Noise, ThreePoint};
///
/// let mut path = ThreePoint::new(42).path(3);
/// let mut dw = [0.0; 2];
/// path.increments(7, 0.01, &mut dw)?;
/// for (process, dw) in dw.into_iter().enumerate() {
///     assert!(dw == 0.0 || dw.abs() == 3.0_f64.sqrt() * 0.1);
///     assert_eq!(dw, path.increment(7, process, 0.01));
/// }
/// # Ok::<(), sve_runtime::noise::NoiseError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ThreePoint(pub(super) CounterPath<ThreePoints>);

impl ThreePoint {
    /// Path 0 of a seed.
    pub fn new(seed: u64) -> Self {
        Self(CounterPath::new(seed))
    }

    /// Path number `path` of the same seed.
    #[must_use]
    pub fn path(&self, path: u64) -> Self {
        Self(self.0.path(path))
    }

    /// Returns the increment of a process (from 0) over step number `step` (from 0) of length `h`. Its variance is |h|. If `h` is NaN, returns NaN or 0.
    #[inline]
    pub fn increment(&self, step: u64, process: usize, h: f64) -> f64 {
        self.0.increment(step, process, h)
    }
}

impl Noise for ThreePoint {
    #[inline]
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.0.increments(step, h, dw)
    }
}
