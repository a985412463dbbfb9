//! The increments of a block of paths, in lanes, drawn for several steps at once.
//!
//! Input: the noise, the first path and a range of steps. Output: one increment for each lane, step and process.
//! Invariant: the increments of path `k` are those of the source's path `k`, bit for bit. In antithetic pairs, paths `2k` and `2k + 1` have those of path `k`, the second
//! one with the other sign. Coarsened increments are sums of the source's increments over the halves of a step.

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
    /// Standard deviation of the increments that are drawn.
    scale: f64,
    /// Number of the batch in the buffer.
    batch: Option<u64>,
    /// Number of tiles in the buffer.
    tiles: usize,
    /// Increments by groups of four steps, tiles and processes.
    values: Vec<Aligned<[Lane; 4]>>,
    /// Work space: increments from which those of the paths are computed.
    drawn: Vec<Aligned<[Lane; 4]>>,
}

impl<const M: usize> IncrementBuffer<M> {
    /// An empty buffer for the paths from `first_path` on.
    pub(super) fn new(noise: PathNoise, first_path: u64, h: f64) -> Self {
        Self {
            noise,
            first_path: noise.first_path.wrapping_add(noise.path_within(first_path)),
            scale: noise.scale(h),
            batch: None,
            tiles: 0,
            values: vec![Aligned([[0.0; LANES]; 4]); QUADS * BLOCK_TILES * M],
            drawn: Vec::new(),
        }
    }

    /// Draws the increments of a batch, for the first so many tiles.
    pub(super) fn load(&mut self, batch: u64, tiles: usize) {
        let Some(distribution) = self.noise.distribution else {
            return;
        };
        if M == 0 || self.batch == Some(batch) {
            return;
        }
        (self.batch, self.tiles) = (Some(batch), tiles);
        let PathNoise { seed, largest, .. } = self.noise;
        let blocks = QUADS * if self.noise.is_coarsened { 2 } else { 1 };
        let draw = Draw {
            distribution,
            seed,
            first_path: self.first_path,
            first_block: batch * blocks as u64,
            scale: self.scale,
            processes: M,
            tiles: if self.noise.is_antithetic {
                tiles.div_ceil(2)
            } else {
                tiles
            },
        };
        let values = &mut self.values[..QUADS * tiles * M];
        if self.noise.is_antithetic || self.noise.is_coarsened {
            let rows = blocks * draw.tiles * M;
            self.drawn.resize(rows, Aligned([[0.0; LANES]; 4]));
            fill(&draw, &mut self.drawn);
            derive::<M>(self.noise, &self.drawn, [draw.tiles, tiles], values);
        } else {
            fill(&draw, values);
        }
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

/// Computes sums and mirror images of increments, from those of `drawn_tiles` tiles for `tiles` tiles.
fn derive<const M: usize>(
    noise: PathNoise,
    drawn: &[Aligned<[Lane; 4]>],
    [drawn_tiles, tiles]: [usize; 2],
    values: &mut [Aligned<[Lane; 4]>],
) {
    for (row, value) in values.iter_mut().enumerate() {
        let (quad, tile, process) = (row / (tiles * M), row / M % tiles, row % M);
        let of_block =
            |block: usize, tile: usize| &drawn[(block * drawn_tiles + tile) * M + process];
        let source = |tile| {
            if noise.is_coarsened {
                sums([of_block(2 * quad, tile), of_block(2 * quad + 1, tile)])
            } else {
                *of_block(quad, tile)
            }
        };
        *value = if noise.is_antithetic {
            pairs(&source(tile / 2), tile % 2)
        } else {
            source(tile)
        };
    }
}

/// Returns the sums of the increments over eight halves of steps: those of four steps.
fn sums(halves: [&Aligned<[Lane; 4]>; 2]) -> Aligned<[Lane; 4]> {
    Aligned(core::array::from_fn(|step| {
        let halves = &halves[step / 2].0;
        let [first, second] = [&halves[2 * step % 4], &halves[2 * step % 4 + 1]];
        core::array::from_fn(|lane| first[lane] + second[lane])
    }))
}

/// Returns the increments of the pairs of the first (`half` = 0) or second half of the lanes: lane `2k` has those of the k-th path, lane `2k + 1` their negatives.
fn pairs(source: &Aligned<[Lane; 4]>, half: usize) -> Aligned<[Lane; 4]> {
    Aligned(core::array::from_fn(|step| {
        core::array::from_fn(|lane| {
            let dw = source.0[step][half * (LANES / 2) + lane / 2];
            if lane % 2 == 0 { dw } else { -dw }
        })
    }))
}
