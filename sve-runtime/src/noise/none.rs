//! The source without noise. Input: any step. Output: zeros.

use super::{DyadicInterval, Halves as _, Noise, NoiseError};

/// No noise at all, for deterministic systems or the deterministic limit of a noisy one.
///
/// ```
/// use sve_runtime::noise::{NoNoise, Noise};
///
/// let mut dw = [1.0, 2.0];
/// NoNoise.increments(0, 0.1, &mut dw)?;
/// assert_eq!(dw, [0.0, 0.0]);
/// # Ok::<(), sve_runtime::noise::NoiseError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoNoise;

impl Noise for NoNoise {
    #[inline]
    fn increments(&mut self, _step: u64, _h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        dw.fill(0.0);
        Ok(())
    }

    #[inline]
    fn stage_increments(
        &mut self,
        step: u64,
        h: f64,
        _stages: usize,
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        self.increments(step, h, dw)
    }

    fn halves_if_known(
        &self,
        interval: DyadicInterval,
        h: f64,
        whole: &[f64],
        left: &mut [f64],
        right: &mut [f64],
    ) -> bool {
        self.halves_of(interval, h, whole, left, right);
        true
    }
}
