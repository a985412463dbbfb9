//! The increments of the paths of an ensemble: which distribution, which seed, which bound.
//!
//! Input: the noise that was set, and the step size. Output: the data from which blocks of paths draw their increments.

use super::EnsembleError;
use crate::noise::lanes::DistributionKind;
use crate::noise::{ManyPaths as _, PathData, Wiener};

/// The noise of an ensemble, for steps of one length.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathNoise {
    pub(super) seed: u64,
    /// The path of the source that belongs to path 0 of the ensemble.
    pub(super) first_path: u64,
    /// The distribution of the increments; `None` without noise.
    pub(super) distribution: Option<DistributionKind>,
    /// Largest |ΔW|; infinite without truncation.
    pub(super) largest: f64,
    /// Whether paths 2k and 2k + 1 have the increments of path k of the source, the second one with the other sign.
    pub(super) is_antithetic: bool,
    /// Whether an increment is the sum of the source's two increments over the halves of the step.
    pub(super) is_coarsened: bool,
}

impl PathNoise {
    /// Checks a noise for steps of length `h`. The default noise is a [`Wiener`] with the default seed.
    pub(super) fn new(
        noise: Option<PathData>,
        default_seed: u64,
        h: f64,
    ) -> Result<Self, EnsembleError> {
        let PathData {
            seed,
            first_path,
            distribution,
            truncation,
        } = noise.unwrap_or_else(|| Wiener::new(default_seed).many_paths());
        let largest = match truncation {
            Some(truncated) => truncated.largest(h).map_err(EnsembleError::Noise)?,
            None => f64::INFINITY,
        };
        Ok(Self {
            seed: seed.unwrap_or(default_seed),
            first_path,
            distribution,
            largest,
            is_antithetic: false,
            is_coarsened: false,
        })
    }

    /// Returns the number of the source's path, counted from its first one, that belongs to a path of the ensemble.
    pub(super) fn path_within(&self, path: u64) -> u64 {
        if self.is_antithetic { path / 2 } else { path }
    }

    /// Returns the scale of the increments that are drawn for steps of length `h`.
    pub(super) fn scale(&self, h: f64) -> f64 {
        let h = if self.is_coarsened { 0.5 * h } else { h };
        h.abs().sqrt()
    }
}
