//! The source without noise. Input: any step. Output: zeros.

#[cfg(feature = "ensemble")]
use super::many_paths::{ManyPaths, PathData};
use super::{Noise, NoiseError, Replayable, WithinSteps};

/// The source without noise, for deterministic systems or the deterministic limit of a noisy
/// system.
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

    fn within_steps(&self) -> Option<WithinSteps<'_>> {
        Some(WithinSteps::of(self))
    }

    fn is_replayable(&self) -> bool {
        true
    }
}

impl Replayable for NoNoise {}

#[cfg(feature = "ensemble")]
impl ManyPaths for NoNoise {
    fn many_paths(self) -> PathData {
        PathData::NONE
    }
}
