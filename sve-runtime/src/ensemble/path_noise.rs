//! The increments of the paths of an ensemble: which distribution, which seed, which bound.
//!
//! Input: the noise that was set, and the step size. Output: the data from which blocks of paths draw their increments.

use super::EnsembleError;
use crate::noise::lanes::DistributionKind;
use crate::noise::{Halves, ManyPaths as _, NoNoise, NoiseError, PathData, Wiener};

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
    /// Number of halvings of a step of the source, see [`Refined`](crate::noise::Refined).
    pub(super) depth: u32,
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
            depth,
        } = noise.unwrap_or_else(|| Wiener::new(default_seed).many_paths());
        // a whole step of the source has a finite length
        let whole = h * (1_u64 << depth) as f64;
        if !whole.is_finite() {
            let error = NoiseError::InvalidStep { h: whole };
            return Err(EnsembleError::Noise(error));
        }
        let largest = match truncation {
            Some(truncated) => truncated.largest(h).map_err(EnsembleError::Noise)?,
            None => f64::INFINITY,
        };
        Ok(Self {
            seed: seed.unwrap_or(default_seed),
            first_path,
            distribution,
            largest,
            depth,
            is_antithetic: false,
            is_coarsened: false,
        })
    }

    /// Returns the kind of the increments, for people; empty without noise.
    pub(super) fn describe(&self) -> String {
        let kind = match self.distribution {
            None => return String::new(),
            Some(DistributionKind::Normal) => "normal increments",
            Some(DistributionKind::ThreePoint) => "increments of three values",
        };
        let is_truncated = self.largest.is_finite();
        let truncated = if is_truncated { ", truncated" } else { "" };
        let pairs = if self.is_antithetic {
            ", antithetic pairs"
        } else {
            ""
        };
        let from = match self.first_path {
            0 => String::new(),
            path => format!(", from path {path} on"),
        };
        format!("{kind}{truncated}{pairs}{from}")
    }

    /// Returns the number of the source's path, counted from its first one, that belongs to a path of the ensemble.
    pub(super) fn path_within(&self, path: u64) -> u64 {
        if self.is_antithetic { path / 2 } else { path }
    }

    /// Returns whether a path has the increments of its path of the source with the other sign.
    pub(super) fn is_mirrored(&self, path: u64) -> bool {
        self.is_antithetic && path % 2 == 1
    }

    /// Returns the source of a path of the ensemble, if it is known within steps.
    pub(super) fn within_steps(&self, path: u64) -> Option<Box<dyn Halves>> {
        match self.distribution {
            None => Some(Box::new(NoNoise)),
            Some(_) if self.is_antithetic || self.is_coarsened => None,
            Some(DistributionKind::Normal) if self.largest == f64::INFINITY => {
                let path = self.first_path.wrapping_add(path);
                let path = Wiener::new(self.seed).path(path);
                if self.depth == 0 {
                    return Some(Box::new(path));
                }
                let refined = path.refine(self.depth).ok()?;
                Some(Box::new(refined))
            }
            Some(_) => None,
        }
    }
}
