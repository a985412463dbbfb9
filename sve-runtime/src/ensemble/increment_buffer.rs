//! The increments of a block of paths, in lanes, drawn for several steps at once.
//!
//! Input: the noise, the first path and a range of steps. Output: one increment for each lane, step and process.
//! Invariant: the increments of path `k` are those of the source's path `k`, bit for bit. In antithetic pairs, paths `2k` and `2k + 1` have those of path `k`, the second
//! one with the other sign. Coarsened increments are sums of the source's increments over the halves of a step.

use super::BLOCK_TILES;
use super::path_noise::PathNoise;
use crate::lanes::{Aligned, LANES, Lane};
use crate::noise::lanes::fill;

/// Number of steps whose increments are drawn at once, so that the overhead of a draw is small.
pub(super) const BATCH: u64 = 16;

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
    /// Increments by groups of four steps, tiles and processes.
    values: Vec<Aligned<[Lane; 4]>>,
    /// Work space: increments over halves of steps.
    halves: Vec<Aligned<[Lane; 4]>>,
}

impl<const M: usize> IncrementBuffer<M> {
    /// An empty buffer for the paths from `first_path` on.
    pub(super) fn new(noise: PathNoise, first_path: u64, h: f64) -> Self {
        Self {
            noise,
            first_path: noise.first_path.wrapping_add(noise.path_within(first_path)),
            scale: noise.scale(h),
            batch: None,
            values: vec![Aligned([[0.0; LANES]; 4]); QUADS * BLOCK_TILES * M],
            halves: Vec::new(),
        }
    }

    /// Draws the increments of a batch, for the first so many tiles.
    pub(super) fn load(&mut self, batch: u64, tiles: usize) {
        let Some(distribution) = self.noise.distribution else {
            return;
        };
        let PathNoise {
            seed,
            largest,
            is_antithetic,
            is_coarsened,
            ..
        } = self.noise;
        if M == 0 || self.batch == Some(batch) {
            return;
        }
        self.batch = Some(batch);
        let drawn = M * if is_antithetic {
            tiles.div_ceil(2)
        } else {
            tiles
        };
        let (first_path, scale) = (self.first_path, self.scale);
        let draw = |quad, values: &mut [_]| {
            fill(distribution, seed, first_path, quad, scale, M, values);
        };
        let quads = self.values.chunks_exact_mut(BLOCK_TILES * M);
        for (quad, values) in (batch * QUADS as u64..).zip(quads) {
            let values = &mut values[..tiles * M];
            if is_coarsened {
                self.halves.resize(drawn, Aligned([[0.0; LANES]; 4]));
                for half in 0..2 {
                    draw(2 * quad + half, &mut self.halves);
                    add_halves(&self.halves, half as usize, &mut values[..drawn]);
                }
            } else {
                draw(quad, &mut values[..drawn]);
            }
            if is_antithetic {
                mirror::<M>(values);
            }
            if largest < f64::INFINITY {
                for dw in values.iter_mut().flat_map(|row| row.0.as_flattened_mut()) {
                    *dw = dw.clamp(-largest, largest);
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

/// Writes the sums of the increments over four halves of steps to the first (`half` = 0) or the last two of four steps.
fn add_halves(halves: &[Aligned<[Lane; 4]>], half: usize, sums: &mut [Aligned<[Lane; 4]>]) {
    for (halves, sums) in halves.iter().zip(sums) {
        for step in 0..2 {
            let [first, second] = [&halves.0[2 * step], &halves.0[2 * step + 1]];
            sums.0[2 * half + step] = core::array::from_fn(|lane| first[lane] + second[lane]);
        }
    }
}

/// Spreads the increments of the first half of the tiles to the pairs of all tiles: lane `2k` has those of path `k`, lane `2k + 1` their negatives.
fn mirror<const M: usize>(values: &mut [Aligned<[Lane; 4]>]) {
    // from the last tile down, so that no increment is overwritten before it is read
    for row in (0..values.len()).rev() {
        let (tile, process) = (row / M, row % M);
        let source = values[tile / 2 * M + process];
        let first_lane = tile % 2 * (LANES / 2);
        values[row] = Aligned(core::array::from_fn(|step| {
            core::array::from_fn(|lane| {
                let dw = source.0[step][first_lane + lane / 2];
                if lane % 2 == 0 { dw } else { -dw }
            })
        }));
    }
}
