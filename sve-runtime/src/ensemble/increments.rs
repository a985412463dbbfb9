//! The Wiener increments of a block of paths, in lanes.
//!
//! Input: the first path and a stretch of steps. Output: one increment a lane, step and process.
//! Invariant: those of path `k` are the ones of `Wiener::new(seed).path(k)`, or of the same truncated, bit for bit.

use super::BLOCK_TILES;
use super::law::Law;
use crate::lanes::{Aligned, LANES, Lane};
use crate::noise::lanes::fill;

/// Steps whose increments are drawn at once, so that what surrounds a draw and a tile's steps is little beside them.
pub(super) const STRETCH: u64 = 16;

/// Steps that share a block of the generator.
const QUAD: u64 = 4;
const QUADS: usize = (STRETCH / QUAD) as usize;

/// The increments of a stretch of steps for the tiles of a block.
pub(super) struct Increments<const M: usize> {
    law: Law,
    seed: u64,
    first_path: u64,
    /// √h.
    scale: f64,
    /// Which stretch is there.
    stretch: Option<u64>,
    /// Of each four steps, tile and process.
    values: Vec<Aligned<[Lane; 4]>>,
}

impl<const M: usize> Increments<M> {
    /// Those of the paths from `first_path` on.
    pub(super) fn new(law: Law, seed: u64, first_path: u64, h: f64) -> Self {
        Self {
            law,
            seed,
            first_path,
            scale: h.sqrt(),
            stretch: None,
            values: vec![Aligned([[0.0; LANES]; 4]); QUADS * BLOCK_TILES * M],
        }
    }

    /// Draws those of a stretch, for the first so many tiles.
    pub(super) fn load(&mut self, stretch: u64, tiles: usize) {
        let Law::Drawn { source, largest } = self.law else {
            return;
        };
        if M == 0 || self.stretch == Some(stretch) {
            return;
        }
        self.stretch = Some(stretch);
        let quads = self.values.chunks_exact_mut(BLOCK_TILES * M);
        for (quad, values) in (stretch * QUADS as u64..).zip(quads) {
            let values = &mut values[..tiles * M];
            fill(
                source,
                self.seed,
                self.first_path,
                quad,
                self.scale,
                M,
                values,
            );
            if largest < f64::INFINITY {
                for dw in values.iter_mut().flat_map(|row| row.0.as_flattened_mut()) {
                    *dw = dw.clamp(-largest, largest);
                }
            }
        }
    }

    /// Those of a tile for a step of the stretch that was drawn last.
    #[inline(always)]
    pub(super) fn of(&self, tile: usize, step: u64) -> Aligned<[Lane; M]> {
        let quad = (step % STRETCH / QUAD) as usize;
        let values = &self.values[(quad * BLOCK_TILES + tile) * M..][..M];
        Aligned(core::array::from_fn(|process| {
            values[process].0[(step % QUAD) as usize]
        }))
    }
}
