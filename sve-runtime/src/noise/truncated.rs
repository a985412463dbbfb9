//! Increments with bounded size, for implicit steps.
//!
//! Input: the increments of another source and `h < 1`. Output: the same, clipped to ±√h A.
//! Invariant: |ΔW| ≤ √(2 k h |ln h|).
//!
//! Source: Milstein, Repin, Tretyakov, *Numerical methods for stochastic systems preserving symplectic structure*,
//! SIAM J. Numer. Anal. 40 (2002) 1583–1604.

use super::error::check_step;
use super::{Noise, NoiseError};

/// Another source with its increments clipped: ΔW = √h ξ with ξ held between ±A, A = √(2k|ln h|).
///
/// An implicit step with noise in the momentum may have no solution for a large ΔW. The clipped increment goes to 0 with
/// `h` as surely as `h` does, so a small step always has one, and the mean square of what is cut off is at most `h^(k+1)`:
/// the default `k = 2` keeps the strong order 1 of the rules.
///
/// Needs `h < 1` in the unit of time ([`NoiseError::TruncationStep`]). The bound narrows as `h` grows: it clips one ξ in
/// 400 at `h = 0.1` (A = 3.03), and one in 10 at `h = 0.5` (A = 1.67).
///
/// ```
/// use sve_runtime::noise::{Noise, NoiseError, Truncated, Wiener};
///
/// let mut noise = Truncated::new(Wiener::new(42));
/// let mut dw = [0.0];
/// noise.increments(0, 0.1, &mut dw)?;
/// assert!(dw[0].abs() <= noise.largest(0.1)?); // 0.96
/// assert_eq!(noise.increments(0, 1.0, &mut dw), Err(NoiseError::TruncationStep { h: 1.0 }));
/// # Ok::<(), NoiseError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truncated<W> {
    noise: W,
    k: f64,
}

impl<W> Truncated<W> {
    /// Clips the increments of `noise` with `k = 2`.
    pub fn new(noise: W) -> Self {
        Self { noise, k: 2.0 }
    }

    /// Another exponent `k`, at least 1: a larger one clips less.
    ///
    /// # Errors
    /// [`NoiseError::TruncationExponent`] unless `k` is finite and at least 1.
    pub fn exponent(self, k: f64) -> Result<Self, NoiseError> {
        if (1.0..f64::INFINITY).contains(&k) {
            Ok(Self { k, ..self })
        } else {
            Err(NoiseError::TruncationExponent { k })
        }
    }

    /// The largest |ΔW| over a step of length `h`, √h A.
    ///
    /// # Errors
    /// [`NoiseError::InvalidStep`] unless `h` is positive and finite; [`NoiseError::TruncationStep`] unless `h < 1`.
    #[inline]
    pub fn largest(&self, h: f64) -> Result<f64, NoiseError> {
        check_step(h)?;
        if h < 1.0 {
            Ok((-2.0 * self.k * h * h.ln()).sqrt())
        } else {
            Err(NoiseError::TruncationStep { h })
        }
    }
}

impl<W: Noise> Noise for Truncated<W> {
    #[inline]
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        let largest = self.largest(h)?;
        self.noise.increments(step, h, dw)?;
        for dw in dw {
            *dw = dw.clamp(-largest, largest);
        }
        Ok(())
    }
}
