//! The increments of a block of paths, in lanes, drawn for several steps at once.
//!
//! Input: the noise, the paths and a range of steps. Output: one increment for each lane, step and process.
//! Invariant: the increments of path `k` are those of the source's path `k`, bit for bit.

use super::BLOCK_TILES;
use super::path_noise::PathNoise;
use crate::lanes::{Aligned, LANES, Lane};
use crate::noise::lanes::{DistributionKind, fill};
use crate::noise::refined_lanes::RefinedLanes;

/// Number of steps whose increments are drawn at once, so that the overhead of a draw is small.
pub(super) const BATCH: u64 = 16;

/// Number of steps that share a block of the generator.
const QUAD: u64 = 4;
const QUADS: usize = (BATCH / QUAD) as usize;

/// The increments of a batch of steps for the tiles of a block.
pub(super) struct IncrementBuffer<const M: usize> {
    noise: PathNoise,
    h: f64,
    /// Number of the batch in the buffer.
    batch: Option<u64>,
    /// The paths of the source in the lanes of each tile.
    paths: Vec<[u64; LANES]>,
    /// Increments by groups of four steps, tiles and processes.
    values: Vec<Aligned<[Lane; 4]>>,
}

impl<const M: usize> IncrementBuffer<M> {
    /// An empty buffer.
    pub(super) fn new(noise: PathNoise, h: f64) -> Self {
        Self {
            noise,
            h,
            batch: None,
            paths: Vec::with_capacity(BLOCK_TILES),
            values: vec![Aligned([[0.0; LANES]; 4]); QUADS * BLOCK_TILES * M],
        }
    }

    /// Draws the increments of a batch, for tiles with these paths in their lanes.
    pub(super) fn load<'t>(&mut self, batch: u64, tiles: impl Iterator<Item = &'t [u64; LANES]>) {
        let Some(distribution) = self.noise.distribution else {
            return;
        };
        if M == 0 {
            return;
        }
        let first = self.noise.first_path;
        let mut is_loaded = self.batch.replace(batch) == Some(batch);
        let mut count = 0;
        for paths in tiles.map(|paths| paths.map(|path| first.wrapping_add(path))) {
            is_loaded &= self.paths.get(count) == Some(&paths);
            match self.paths.get_mut(count) {
                Some(known) => *known = paths,
                None => self.paths.push(paths),
            }
            count += 1;
        }
        if is_loaded {
            return;
        }
        if self.noise.depth == 0 {
            self.draw(distribution, batch);
        } else {
            self.draw_refined(distribution, batch);
        }
    }

    /// Draws the increments over whole steps of the source.
    fn draw(&mut self, distribution: DistributionKind, batch: u64) {
        let PathNoise { seed, largest, .. } = self.noise;
        let scale = self.h.abs().sqrt();
        let quads = self.values.chunks_exact_mut(BLOCK_TILES * M);
        for (quad, values) in (batch * QUADS as u64..).zip(quads) {
            let values = &mut values[..self.paths.len() * M];
            fill(distribution, seed, &self.paths, quad, scale, M, values);
            if largest < f64::INFINITY {
                for dw in values.iter_mut().flat_map(|row| row.0.as_flattened_mut()) {
                    *dw = dw.clamp(-largest, largest);
                }
            }
        }
    }

    /// Draws the increments over parts of steps of the source.
    fn draw_refined(&mut self, distribution: DistributionKind, batch: u64) {
        let PathNoise { seed, depth, .. } = self.noise;
        let whole_h = self.h * (1_u64 << depth) as f64;
        let parts = BATCH.min(1 << depth);
        let mut whole = vec![Aligned([[0.0; LANES]; 4]); self.paths.len() * M];
        let mut drawn = None;
        let mut halves = [[0.0; LANES]; BATCH as usize];
        for first in (batch * BATCH..).step_by(parts as usize).take((BATCH / parts) as usize) {
            let step = first >> depth;
            let quad = step / QUAD;
            if drawn.replace(quad) != Some(quad) {
                let scale = whole_h.abs().sqrt();
                fill(distribution, seed, &self.paths, quad, scale, M, &mut whole);
            }
            for (tile, paths) in self.paths.iter().enumerate() {
                let lanes = RefinedLanes {
                    seed,
                    paths,
                    whole_h,
                    depth,
                };
                for process in 0..M {
                    let of_step = &whole[tile * M + process].0[(step % QUAD) as usize];
                    let part = first - (step << depth);
                    let halves = &mut halves[..parts as usize];
                    lanes.fill(step, process, of_step, part, halves);
                    for (fine, dw) in (first..).zip(halves) {
                        let quad = (fine % BATCH / QUAD) as usize;
                        let row = &mut self.values[(quad * BLOCK_TILES + tile) * M + process];
                        row.0[(fine % QUAD) as usize] = *dw;
                    }
                }
            }
        }
    }

    /// Returns the increments of a tile for a step of the batch in the buffer.
    #[inline(always)]
    pub(super) fn of(&self, tile: usize, step: u64) -> Aligned<[Lane; M]> {
        let quad = (step % BATCH / QUAD) as usize;
        let values = &self.values[(quad * BLOCK_TILES + tile) * M..][..M];
        Aligned(core::array::from_fn(|process| {
            values[process].0[(step % QUAD) as usize]
        }))
    }
}
