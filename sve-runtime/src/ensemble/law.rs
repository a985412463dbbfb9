//! Which increments the paths of an ensemble have.
//!
//! Input: what was asked for. Output: a law, or why there is none.

use super::EnsembleError;
use crate::noise::lanes::DistributionKind as Source;
use crate::noise::{Truncated, Wiener};

/// What was asked for.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wanted {
    pub(super) three_point: bool,
    /// The bound of [`Truncated`], in standard deviations.
    pub(super) truncated: Option<f64>,
    pub(super) no_noise: bool,
}

/// Which increments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Law {
    /// Those of a source, of which none is larger than `largest`.
    Drawn { source: Source, largest: f64 },
    /// None: zeros.
    None,
}

impl Wanted {
    /// The law of steps of this length.
    pub(super) fn law(self, h: f64) -> Result<Law, EnsembleError> {
        let Self {
            three_point,
            truncated,
            no_noise,
        } = self;
        if let (true, Some(deviations)) = (three_point, truncated) {
            return Err(EnsembleError::TruncatedThreePoint { deviations });
        }
        let mut largest = f64::INFINITY;
        if let Some(deviations) = truncated {
            largest = Truncated::new(Wiener::new(0))
                .deviations(deviations)
                .and_then(|noise| noise.largest(h))
                .map_err(EnsembleError::Truncation)?;
        }
        let source = if three_point {
            Source::ThreePoint
        } else {
            Source::Normal
        };
        Ok(if no_noise {
            Law::None
        } else {
            Law::Drawn { source, largest }
        })
    }
}
