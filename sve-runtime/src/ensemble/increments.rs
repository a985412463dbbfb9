//! The Wiener increments of a block of paths, in lanes.
//!
//! Input: the first path and a stretch of steps. Output: one increment a lane, step and process.
//! Invariant: those of path `k` are the ones of `Wiener::new(seed).path(k)`, or of the same truncated, bit for bit.

use super::BLOCK_TILES;
use crate::lanes::{LANES, Lane};
use crate::noise::{Noise, NoiseError, Truncated, Wiener};

/// Steps whose increments are drawn at once: a multiple of the four that share a block of the generator.
pub(super) const STRETCH: u64 = 16;

/// Steps that share a block of the generator.
const QUAD: u64 = 4;

/// Which increments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Law {
    /// Of a Wiener process.
    Wiener,
    /// Those, clipped.
    Truncated {
        /// The exponent of [`Truncated`].
        exponent: f64,
    },
    /// None: zeros.
    None,
}

impl Law {
    /// The largest increment that is left as it is.
    pub(super) fn largest(self, h: f64) -> Result<f64, NoiseError> {
        match self {
            Self::Truncated { exponent } => Truncated::new(Wiener::new(0))
                .exponent(exponent)?
                .largest(h),
            Self::Wiener | Self::None => Ok(f64::INFINITY),
        }
    }
}

/// The increments of a stretch of steps for the tiles of a block.
pub(super) struct Increments<const M: usize> {
    /// Where there are any: one a path.
    wiener: Vec<Wiener>,
    h: f64,
    largest: f64,
    /// Which stretch is there.
    stretch: Option<u64>,
    /// Of each tile, step and process.
    values: Vec<[Lane; M]>,
}

impl<const M: usize> Increments<M> {
    /// Those of the paths from `first` on.
    pub(super) fn new(law: Law, seed: u64, first: u64, h: f64, largest: f64) -> Self {
        let paths = match law {
            Law::None => 0,
            _ if M == 0 => 0,
            Law::Wiener | Law::Truncated { .. } => (BLOCK_TILES * LANES) as u64,
        };
        Self {
            wiener: (0..paths)
                .map(|k| Wiener::new(seed).path(first.wrapping_add(k)))
                .collect(),
            h,
            largest,
            stretch: None,
            values: vec![[[0.0; LANES]; M]; BLOCK_TILES * STRETCH as usize],
        }
    }

    /// Draws those of a stretch.
    pub(super) fn load(&mut self, stretch: u64) {
        if self.stretch == Some(stretch) {
            return;
        }
        self.stretch = Some(stretch);
        for (path, wiener) in self.wiener.iter_mut().enumerate() {
            let (tile, lane) = (path / LANES, path % LANES);
            for at in 0..STRETCH {
                let mut dw = [0.0; M];
                let step = stretch * STRETCH + at;
                debug_assert!(STRETCH.is_multiple_of(QUAD));
                if wiener.increments(step, self.h, &mut dw).is_err() {
                    // the step size was checked before
                    continue;
                }
                let values = &mut self.values[tile * STRETCH as usize + at as usize];
                for process in 0..M {
                    values[process][lane] = dw[process].clamp(-self.largest, self.largest);
                }
            }
        }
    }

    /// Those of a tile for the stretch that was drawn last, one a step.
    pub(super) fn tile(&self, tile: usize) -> &[[Lane; M]] {
        &self.values[tile * STRETCH as usize..][..STRETCH as usize]
    }
}
