//! Increments with bounded size, for implicit steps.
//!
//! Input: the increments of another source. Output: these increments, clipped to ±A√h.
//! Invariant: |ΔW| ≤ A√h, for every h.
//!
//! Source of the bound that grows like √|ln h|: Milstein, Repin, Tretyakov, *Numerical methods for
//! stochastic systems preserving symplectic structure*, SIAM J. Numer. Anal. 40 (2002) 1583–1604.

#[cfg(feature = "ensemble")]
use super::many_paths::{ManyPaths, PathData};
#[cfg(feature = "ensemble")]
use super::wiener::Wiener;
use super::{Noise, NoiseError, Replayable};
use crate::error::check_step;
use crate::gauss::stage_noise;

/// Default bound, in standard deviations.
const DEVIATIONS: f64 = 6.0;

/// Another source with its increments clipped: ΔW = √h ξ with |ξ| ≤ A, a number of standard
/// deviations.
///
/// An implicit step with noise in the momentum may have no solution for a large ΔW. The clipped
/// increment is at most `A√h`, so a small enough step always has a solution. How small the step has
/// to be depends on the system: clipping does not make every step solvable.
///
/// A has no unit, so the clipped path is the same in any unit of time. The clipped parts of the
/// increments have a mean square of c²h. Over a time t they change a path by about c√t times the
/// strength of the noise:
///
/// | A | one ξ in … is clipped | c |
/// | --- | --- | --- |
/// | 3 | 370 | 2.0e-2 |
/// | 4 | 15,800 | 2.5e-3 |
/// | 5 | 1.7 million | 2.0e-4 |
/// | 6, the default | 5.1e8 | 9.8e-6 |
/// | 7 | 3.9e11 | 3.1e-7 |
///
/// So a strong order is observed for errors above c√t. A bound that keeps an order for all h grows
/// slowly as h decreases: see [`exponent`](Self::exponent).
///
/// ```
/// use sve_runtime::noise::{Noise, NoiseError, Truncated, Wiener};
///
/// let mut noise = Truncated::new(Wiener::new(42)).deviations(4.0)?;
/// let mut dw = [0.0];
/// noise.increments(0, 0.25, &mut dw)?;
/// assert!(dw[0].abs() <= 2.0); // 4 √h
/// assert_eq!(noise.largest(9.0)?, 12.0);
/// # Ok::<(), sve_runtime::noise::NoiseError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truncated<W> {
    noise: W,
    bound: Bound,
}

/// The bound A.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Bound {
    /// A given number.
    Deviations(f64),
    /// The number √(2k ln(τ/h)).
    Exponent { k: f64, tau: f64 },
}

impl<W> Truncated<W> {
    /// Clips the increments of `noise` at 6 standard deviations.
    ///
    #[doc = include_str!("../example.md")]
    /// let noise = Truncated::new(Wiener::new(42));
    /// assert_eq!(noise.largest(0.25)?, 3.0); // 6 √h
    #[doc = include_str!("../example_end.md")]
    pub fn new(noise: W) -> Self {
        Self {
            noise,
            bound: Bound::Deviations(DEVIATIONS),
        }
    }

    /// Clips at another number of standard deviations A: |ΔW| ≤ A√h.
    ///
    #[doc = include_str!("../example.md")]
    /// let noise = Truncated::new(Wiener::new(42)).deviations(4.0)?;
    /// let path = pendulum.trajectory(start, 0.01, noise);
    #[doc = include_str!("../example_end.md")]
    ///
    /// # Errors
    /// [`NoiseError::TruncationDeviations`] unless `deviations` is positive and finite.
    pub fn deviations(self, deviations: f64) -> Result<Self, NoiseError> {
        if deviations > 0.0 && deviations < f64::INFINITY {
            let bound = Bound::Deviations(deviations);
            Ok(Self { bound, ..self })
        } else {
            Err(NoiseError::TruncationDeviations { deviations })
        }
    }

    /// Clips as Milstein, Repin and Tretyakov propose: A = √(2k ln(τ/h)), with a time τ of the
    /// system, such as its shortest period, and an exponent `k` of at least 1.
    ///
    /// The mean square of the clipped part of ξ is at most `(h/τ)^k`, so `k = 2` keeps the strong
    /// order 1 of the rules for all `h`. Their paper has τ = 1, which depends on the unit of time.
    /// The bound needs `h < τ` ([`NoiseError::TruncationStep`]), and it decreases as `h` grows: it
    /// clips one ξ in 400 at `h = τ/10` (A = 3.03), and one in 10 at `h = τ/2` (A = 1.67).
    ///
    /// ```
    /// use sve_runtime::noise::{Noise, NoiseError, Truncated, Wiener};
    ///
    /// let period = 6.28;
    /// let mut noise = Truncated::new(Wiener::new(42)).exponent(2.0, period)?;
    /// assert!((noise.largest(0.0628)? / 0.0628_f64.sqrt() - 4.29).abs() < 0.01);
    /// let error = noise.increments(0, 7.0, &mut [0.0]);
    /// assert_eq!(error, Err(NoiseError::TruncationStep { h: 7.0, tau: 6.28 }));
    /// # Ok::<(), NoiseError>(())
    /// ```
    ///
    /// # Errors
    /// [`NoiseError::TruncationExponent`] unless `k` is finite and at least 1, and τ is positive
    /// and finite.
    pub fn exponent(self, k: f64, tau: f64) -> Result<Self, NoiseError> {
        if (1.0..f64::INFINITY).contains(&k) && tau > 0.0 && tau < f64::INFINITY {
            let bound = Bound::Exponent { k, tau };
            Ok(Self { bound, ..self })
        } else {
            Err(NoiseError::TruncationExponent { k, tau })
        }
    }

    /// Returns the largest |ΔW| over a step of length `h`, A√h.
    ///
    /// # Errors
    /// [`NoiseError::InvalidStep`] if `h` is zero or not finite; [`NoiseError::TruncationStep`] for
    /// an |h| that is not below the τ of [`exponent`](Self::exponent).
    #[inline]
    pub fn largest(&self, h: f64) -> Result<f64, NoiseError> {
        check_step(h)?;
        let h = h.abs();
        match self.bound {
            Bound::Deviations(deviations) => Ok(deviations * h.abs().sqrt()),
            Bound::Exponent { k, tau } if h < tau => Ok((-2.0 * k * h * (h / tau).ln()).sqrt()),
            Bound::Exponent { tau, .. } => Err(NoiseError::TruncationStep { h, tau }),
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

    /// Clips the increment at a stage at the same multiple of its own standard deviation.
    fn stage_increments(
        &mut self,
        step: u64,
        h: f64,
        stages: usize,
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        let largest = self.largest(h)?;
        let weights = stage_noise::weights(stages).ok_or(NoiseError::NoStages { stages })?;
        self.noise.stage_increments(step, h, stages, dw)?;
        for (dw, weight) in dw.iter_mut().zip(weights.iter().cycle()) {
            let largest = largest * weight.sqrt();
            *dw = dw.clamp(-largest, largest);
        }
        Ok(())
    }

    fn is_replayable(&self) -> bool {
        self.noise.is_replayable()
    }
}

impl<W: Replayable> Replayable for Truncated<W> {}

#[cfg(feature = "ensemble")]
impl ManyPaths for Truncated<Wiener> {
    fn many_paths(self) -> PathData {
        let Self { noise, bound } = self;
        PathData {
            truncation: Some(Truncated { noise: (), bound }),
            ..noise.many_paths()
        }
    }
}
