//! The increments of a block of paths, in lanes, drawn for several steps at once.
//!
//! Input: the noise, the first path and a range of steps. Output: one increment for each lane, step and process.
//! Invariant: the increments of path `k` are those of the source's path `k`, bit for bit.

use super::BLOCK_TILES;
use super::path_noise::PathNoise;
use crate::lanes::{Aligned, LANES, Lane};
use crate::noise::lanes::{Draw, fill};

/// Number of steps whose increments are drawn at once, so that the overhead of a draw is small.
pub(super) const BATCH: u64 = 32;

/// Number of steps that share a block of the generator.
const QUAD: u64 = 4;
const QUADS: usize = (BATCH / QUAD) as usize;

/// The increments of a batch of steps for the tiles of a block.
pub(super) struct IncrementBuffer<const M: usize> {
    noise: PathNoise,
    first_path: u64,
    /// √h.
    scale: f64,
    /// Number of the batch in the buffer.
    batch: Option<u64>,
    /// Number of tiles in the buffer.
    tiles: usize,
    /// Increments by groups of four steps, tiles and processes.
    values: Vec<Aligned<[Lane; 4]>>,
}

impl<const M: usize> IncrementBuffer<M> {
    /// An empty buffer for the paths from `first_path` on.
    pub(super) fn new(noise: PathNoise, first_path: u64, h: f64) -> Self {
        Self {
            noise,
            first_path: noise.first_path.wrapping_add(first_path),
            scale: h.abs().sqrt(),
            batch: None,
            tiles: 0,
            values: vec![Aligned([[0.0; LANES]; 4]); QUADS * BLOCK_TILES * M],
        }
    }

    /// Draws the increments of a batch, for the first so many tiles.
    pub(super) fn load(&mut self, batch: u64, tiles: usize) {
        let Some(distribution) = self.noise.distribution else {
            return;
        };
        let PathNoise { seed, largest, .. } = self.noise;
        if M == 0 || self.batch == Some(batch) {
            return;
        }
        (self.batch, self.tiles) = (Some(batch), tiles);
        let draw = Draw {
            distribution,
            seed,
            first_path: self.first_path,
            first_block: batch * QUADS as u64,
            scale: self.scale,
            processes: M,
            tiles,
        };
        let values = &mut self.values[..QUADS * tiles * M];
        fill(&draw, values);
        if largest < f64::INFINITY {
            for dw in values.iter_mut().flat_map(|row| row.0.as_flattened_mut()) {
                *dw = dw.clamp(-largest, largest);
            }
        }
    }

    /// Returns the increments of a tile for a step of the batch in the buffer.
    #[inline(always)]
    pub(super) fn of(&self, tile: usize, step: u64) -> Aligned<[Lane; M]> {
        let quad = (step % BATCH / QUAD) as usize;
        let values = &self.values[(quad * self.tiles + tile) * M..][..M];
        Aligned(core::array::from_fn(|process| {
            values[process].0[(step % QUAD) as usize]
        }))
    }
}
