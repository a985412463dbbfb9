//! The sources of noise: what they promise, recorded and refined paths, and the distribution of the
//! increments.

mod distribution;
mod recorded;
mod refined;
mod sources;
mod statistics;

use sve_runtime::noise::{Noise, NoiseError};

/// Returns the increments of a step.
pub(crate) fn draw<const M: usize>(
    noise: &mut (impl Noise + ?Sized),
    step: u64,
    h: f64,
) -> Result<[f64; M], NoiseError> {
    let mut dw = [f64::NAN; M];
    noise.increments(step, h, &mut dw)?;
    Ok(dw)
}
