//! The increments of the paths of an ensemble: which distribution, which seed, which bound.
//!
//! Input: the noise that was set, and the step size. Output: the data from which blocks of paths
//! draw their increments.

use super::EnsembleError;
use crate::gauss::stage_noise;
use crate::noise::{
    AnyDistribution, Halves, ManyPaths as _, NoNoise, NoiseError, PathData, Wiener, draw,
};

/// The noise of an ensemble, for steps of one length.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathNoise {
    pub(super) seed: u64,
    /// The path of the source that belongs to path 0 of the ensemble.
    pub(super) first_path: u64,
    /// The distribution of the increments; `None` without noise.
    pub(super) distribution: Option<&'static dyn AnyDistribution>,
    /// Largest |ΔW|; infinite without truncation.
    pub(super) largest: f64,
    /// Number of increments of a process in a step.
    pub(super) stages: usize,
    /// Paths 2k and 2k + 1 have the increments of path k of the source, the second one with the
    /// other sign.
    pub(super) is_antithetic: bool,
    /// An increment is the sum of the source's two increments over the halves of the step.
    pub(super) is_coarsened: bool,
    /// Number of halvings of a step of the source, see [`Refined`](crate::noise::Refined).
    pub(super) depth: u32,
}

impl PathNoise {
    /// Checks a noise for steps of length `h`. The default noise is a [`Wiener`] with the default
    /// seed.
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
            stages: 1,
            depth,
            is_antithetic: false,
            is_coarsened: false,
        })
    }

    /// Checks that there are increments at the stages of the rule.
    pub(super) fn check_stages(&self) -> Result<(), EnsembleError> {
        let stages = self.stages;
        let noise = match self.distribution.filter(|_| stages > 1) {
            Some(distribution) if !distribution.has_stages() => distribution.name(),
            Some(_) if self.depth > 0 => "increments of a refined path",
            _ => return Ok(()),
        };
        Err(EnsembleError::NoStages { noise, stages })
    }

    /// Returns the kind of the increments, for people; empty without noise.
    pub(super) fn describe(&self) -> String {
        let Some(distribution) = self.distribution else {
            return String::new();
        };
        let kind = distribution.name();
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

    /// Returns the largest increments of a process: the same multiple of the standard deviation at
    /// each stage.
    pub(super) fn bounds(&self) -> impl Iterator<Item = f64> + Clone + use<> {
        let weights = stage_noise::weights(self.stages).unwrap_or(&[]);
        let largest = self.largest;
        weights.iter().map(move |weight| largest * weight.sqrt())
    }

    /// Returns the number of the source's path, counted from its first one, that belongs to a path
    /// of the ensemble.
    pub(super) fn path_within(&self, path: u64) -> u64 {
        if self.is_antithetic { path / 2 } else { path }
    }

    /// Returns whether a path has the increments of its path of the source with the other sign.
    pub(super) fn is_mirrored(&self, path: u64) -> bool {
        self.is_antithetic && path % 2 == 1
    }

    /// Returns the source of a path of the ensemble, if it is known within steps.
    pub(super) fn within_steps(&self, path: u64) -> Option<Box<dyn Halves>> {
        if self.stages > 1 {
            return None;
        }
        let Some(distribution) = self.distribution else {
            return Some(Box::new(NoNoise));
        };
        let are_of_source =
            !self.is_antithetic && !self.is_coarsened && self.largest == f64::INFINITY;
        let path = self.first_path.wrapping_add(path);
        let known = are_of_source.then(|| distribution.within_steps(self.seed, path, self.depth));
        known.flatten()
    }

    /// Returns the increments of a path of the ensemble over steps of length `h`, step by step.
    pub(super) fn increments_of(
        self,
        path: u64,
        h: f64,
    ) -> impl FnMut(u64, &mut [f64]) -> Result<(), NoiseError> {
        let number = self.first_path.wrapping_add(self.path_within(path));
        let mut source = (self.distribution).map(|of| of.path(self.seed, number, self.depth));
        move |step, dw| {
            let Some(source) = &mut source else {
                return Ok(());
            };
            let stages = self.stages;
            if self.is_coarsened {
                let mut half = vec![0.0; dw.len()];
                dw.fill(0.0);
                for number in 0..2 {
                    draw(source, 2 * step + number, 0.5 * h, stages, &mut half)?;
                    for (dw, parts) in dw.chunks_mut(stages).zip(half.chunks(stages)) {
                        stage_noise::add_to_longer_step(parts, [number as usize, 2], dw);
                    }
                }
            } else {
                draw(source, step, h, stages, dw)?;
            }
            for (dw, largest) in dw.iter_mut().zip(self.bounds().cycle()) {
                *dw = dw.clamp(-largest, largest);
                if self.is_mirrored(path) {
                    *dw = -*dw;
                }
            }
            Ok(())
        }
    }
}
