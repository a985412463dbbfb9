//! The increments of a block of paths, in lanes, drawn for several steps at once.
//!
//! Input: the noise, the paths and a range of steps. Output: one increment for each lane, step and
//! process; with stage noise one for each lane, step, process and stage. Invariant: path `k` has
//! the increments of the source's path `k`, bit for bit. In antithetic pairs, paths `2k` and
//! `2k + 1` have the increments of path `k`, the second one with the other sign. Coarsened
//! increments are sums of the source's increments over the halves of a step.

use core::marker::PhantomData;

use super::BLOCK_TILES;
use super::path_noise::PathNoise;
use crate::gauss::stage_noise;
use crate::lanes::{Aligned, LANES, Lane};
use crate::noise::AnyDistribution;
use crate::noise::lanes::{Draw, Rows};
use crate::noise::refined_lanes::RefinedLanes;
use crate::noise::stages::fill_stages;
use crate::system::Increments;

/// Number of steps whose increments are drawn at once, so that the overhead of a draw is small.
pub(super) const BATCH: u64 = 32;

/// Number of steps that share a block of the generator.
const QUAD: u64 = 4;
const QUADS: usize = (BATCH / QUAD) as usize;

/// The increments of a batch of steps for the tiles of a block.
pub(super) struct IncrementBuffer<D> {
    noise: PathNoise,
    h: f64,
    /// Number of the batch in the buffer.
    batch: Option<u64>,
    /// The paths of the source in the lanes of each tile.
    paths: Vec<[u64; LANES]>,
    /// The lanes of each tile whose increments have the opposite sign of the increments of the
    /// source.
    mirrored: Vec<[bool; LANES]>,
    /// Increments by groups of four steps, tiles, processes and stages.
    values: Vec<Rows>,
    increments: PhantomData<D>,
}

impl<D: Increments> IncrementBuffer<D> {
    /// An empty buffer.
    pub(super) fn new(noise: PathNoise, h: f64) -> Self {
        Self {
            noise,
            h,
            batch: None,
            paths: Vec::with_capacity(BLOCK_TILES),
            mirrored: Vec::with_capacity(BLOCK_TILES),
            values: vec![Aligned([[0.0; LANES]; 4]); QUADS * BLOCK_TILES * D::COUNT],
            increments: PhantomData,
        }
    }

    /// Draws the increments of a batch, for tiles with these paths in their lanes.
    pub(super) fn load<'t>(&mut self, batch: u64, tiles: impl Iterator<Item = &'t [u64; LANES]>) {
        let Some(distribution) = self.noise.distribution else {
            return;
        };
        if D::COUNT == 0 {
            return;
        }
        let first = self.noise.first_path;
        let mut is_loaded = self.batch.replace(batch) == Some(batch);
        for (tile, paths) in tiles.enumerate() {
            let mirrored = paths.map(|path| self.noise.is_mirrored(path));
            let paths = paths.map(|path| first.wrapping_add(self.noise.path_within(path)));
            is_loaded &= self.paths.get(tile) == Some(&paths);
            is_loaded &= self.mirrored.get(tile) == Some(&mirrored);
            if tile < self.paths.len() {
                (self.paths[tile], self.mirrored[tile]) = (paths, mirrored);
            } else {
                self.paths.push(paths);
                self.mirrored.push(mirrored);
            }
        }
        if is_loaded {
            return;
        }
        if self.noise.depth == 0 {
            self.draw(distribution, batch);
        } else {
            self.draw_refined(distribution, batch);
        }
        if self.noise.is_antithetic {
            self.mirror();
        }
    }

    /// Changes the signs of the increments in the mirrored lanes.
    fn mirror(&mut self) {
        let tiles = self.mirrored.len();
        let rows = QUADS * tiles * D::COUNT;
        for (row, values) in self.values[..rows].iter_mut().enumerate() {
            let mirrored = &self.mirrored[row / D::COUNT % tiles];
            for dw in &mut values.0 {
                for (dw, &is_mirrored) in dw.iter_mut().zip(mirrored) {
                    *dw = if is_mirrored { -*dw } else { *dw };
                }
            }
        }
    }

    /// Draws the increments over whole steps of the source.
    fn draw(&mut self, distribution: &dyn AnyDistribution, batch: u64) {
        let PathNoise { seed, stages, .. } = self.noise;
        let rows = self.paths.len() * D::COUNT;
        let values = &mut self.values[..QUADS * rows];
        let mut draw = Draw {
            seed,
            paths: &self.paths,
            first_block: batch * QUADS as u64,
            scale: self.h.abs().sqrt(),
            processes: D::COUNT / stages,
        };
        let fill = |draw: &Draw<'_>, out: &mut [Rows]| match stages {
            1 => distribution.fill(draw, out),
            _ => fill_stages(draw, stages, out),
        };
        if self.noise.is_coarsened {
            draw.first_block *= 2;
            draw.scale = (0.5 * self.h.abs()).sqrt();
            let mut halves = vec![Aligned([[0.0; LANES]; 4]); 2 * QUADS * rows];
            fill(&draw, &mut halves);
            add_halves(&halves, [rows, stages], values);
        } else {
            fill(&draw, values);
        }
        if self.noise.largest < f64::INFINITY {
            for (row, largest) in values.iter_mut().zip(self.noise.bounds().cycle()) {
                for dw in row.0.as_flattened_mut() {
                    *dw = dw.clamp(-largest, largest);
                }
            }
        }
    }

    /// Draws the increments over parts of steps of the source.
    fn draw_refined(&mut self, distribution: &dyn AnyDistribution, batch: u64) {
        let PathNoise { seed, depth, .. } = self.noise;
        let whole_h = self.h * (1_u64 << depth) as f64;
        let parts = BATCH.min(1 << depth);
        let mut whole = vec![Aligned([[0.0; LANES]; 4]); self.paths.len() * D::COUNT];
        let mut drawn = None;
        let mut halves = [[0.0; LANES]; BATCH as usize];
        for first in (batch * BATCH..)
            .step_by(parts as usize)
            .take((BATCH / parts) as usize)
        {
            let step = first >> depth;
            let quad = step / QUAD;
            if drawn.replace(quad) != Some(quad) {
                let draw = Draw {
                    seed,
                    paths: &self.paths,
                    first_block: quad,
                    scale: whole_h.abs().sqrt(),
                    processes: D::COUNT,
                };
                distribution.fill(&draw, &mut whole);
            }
            for (tile, paths) in self.paths.iter().enumerate() {
                let lanes = RefinedLanes {
                    seed,
                    paths,
                    whole_h,
                    depth,
                };
                for process in 0..D::COUNT {
                    let of_step = &whole[tile * D::COUNT + process].0[(step % QUAD) as usize];
                    let part = first - (step << depth);
                    let halves = &mut halves[..parts as usize];
                    lanes.fill(step, process, of_step, part, halves);
                    for (fine, dw) in (first..).zip(halves) {
                        let quad = (fine % BATCH / QUAD) as usize;
                        let row = (quad * self.paths.len() + tile) * D::COUNT + process;
                        self.values[row].0[(fine % QUAD) as usize] = *dw;
                    }
                }
            }
        }
    }

    /// Returns the increments of a tile for a step of the batch in the buffer.
    #[inline(always)]
    pub(super) fn of(&self, tile: usize, step: u64) -> Aligned<D::Lanes> {
        let mut increments = Aligned(D::NO_LANES);
        for (number, lanes) in increments.0.as_mut().iter_mut().enumerate() {
            *lanes = *self.row(tile, step, number);
        }
        increments
    }

    /// Returns the increments of a tile for a step of the batch in the buffer, if each lane has a
    /// single increment: it need not be copied.
    #[inline(always)]
    pub(super) fn only(&self, tile: usize, step: u64) -> Option<&D::Lanes> {
        if D::COUNT != 1 {
            return None;
        }
        D::of_only(self.row(tile, step, 0))
    }

    /// Returns increment `number` of the lanes of a tile.
    #[inline(always)]
    fn row(&self, tile: usize, step: u64, number: usize) -> &Lane {
        let quad = (step % BATCH / QUAD) as usize;
        let rows = &self.values[(quad * self.paths.len() + tile) * D::COUNT..][..D::COUNT];
        &rows[number].0[(step % QUAD) as usize]
    }
}

/// Fills `out` with the increments of steps from the increments over their halves. A group of four
/// steps has so many rows.
fn add_halves(halves: &[Rows], [rows, stages]: [usize; 2], out: &mut [Rows]) {
    // the part of each increment of a half in the increments at the stages of the step
    let weights = |half: usize, part: usize| {
        let (mut unit, mut longer) = (vec![0.0; stages], vec![0.0; stages]);
        unit[part] = 1.0;
        stage_noise::add_to_longer_step(&unit, [half, 2], &mut longer);
        longer
    };
    let of_half = |half| {
        (0..stages)
            .map(|part| weights(half, part))
            .collect::<Vec<_>>()
    };
    let weights = [of_half(0), of_half(1)];
    for (row, out) in out.iter_mut().enumerate() {
        let stage = row % stages;
        let first = row / rows * 2 * rows + row % rows - stage;
        out.0 = [[0.0; LANES]; 4];
        for half in 0..8 {
            let parts = &halves[first + half / 4 * rows..][..stages];
            for (part, weights) in parts.iter().zip(&weights[half % 2]) {
                let sums = out.0[half / 2].iter_mut().zip(&part.0[half % 4]);
                sums.for_each(|(sum, part)| *sum += weights[stage] * part);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{BATCH, BLOCK_TILES, IncrementBuffer, LANES};
    use crate::ensemble::path_noise::PathNoise;
    use crate::noise::{ManyPaths as _, Noise as _, Recorded, Wiener};

    /// Returns any paths in the lanes: consecutive and other numbers.
    fn tiles() -> [[u64; LANES]; BLOCK_TILES] {
        let path = |tile: usize, lane: usize| match tile {
            0 => lane as u64,
            _ => (lane as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 8,
        };
        core::array::from_fn(|tile| core::array::from_fn(|lane| path(tile, lane)))
    }

    fn refined_increments_are_those_of_single_paths<const M: usize>(depth: u32) {
        let (seed, first, h) = (7, 5, 0.037 / f64::from(1 << depth));
        let source = Wiener::new(seed).path(first);
        let noise = source.refine(depth).unwrap().many_paths();
        let noise = PathNoise::new(Some(noise), 0, h).unwrap();
        let mut buffer = IncrementBuffer::<[f64; M]>::new(noise, h);
        let tiles = tiles();
        for batch in [0, 1, 2, 77] {
            buffer.load(batch, tiles.iter());
            for (tile, lane) in [(0, 0), (0, 31), (1, 3), (1, 17)] {
                let path = Wiener::new(seed).path(first.wrapping_add(tiles[tile][lane]));
                let mut refined = path.refine(depth).unwrap();
                let mut sum = [0.0; M];
                for step in batch * BATCH..(batch + 1) * BATCH {
                    let mut expected = [0.0; M];
                    refined.increments(step, h, &mut expected).unwrap();
                    let got = buffer.of(tile, step).0.map(|process| process[lane]);
                    assert_eq!(got, expected, "{depth} {batch} {tile} {lane} {step}");
                    // the parts of a step sum up to its increment
                    let parts = 1 << depth;
                    for process in 0..M {
                        sum[process] += got[process];
                        if (step + 1) % parts == 0 && parts <= BATCH {
                            let whole = h * parts as f64;
                            let whole = path.increment(step / parts, process, whole);
                            assert!((sum[process] - whole).abs() < 1e-14);
                            sum[process] = 0.0;
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn refined_paths_have_the_bits_of_single_ones() {
        for depth in [1, 2, 3, 4, 5, 9, 20] {
            refined_increments_are_those_of_single_paths::<1>(depth);
        }
        refined_increments_are_those_of_single_paths::<3>(2);
        refined_increments_are_those_of_single_paths::<6>(5);
        refined_increments_are_those_of_single_paths::<19>(3);
    }

    /// `N` increments: five processes at the stages of a rule.
    fn stages_are_those_of_single_paths<const N: usize>(is_coarsened: bool) {
        let (seed, h, stages) = (7, 0.037, N / 5);
        let mut noise = PathNoise::new(Some(Wiener::new(seed).many_paths()), 0, h).unwrap();
        (noise.stages, noise.is_coarsened) = (stages, is_coarsened);
        let mut buffer = IncrementBuffer::<[f64; N]>::new(noise, h);
        let tiles = tiles();
        buffer.load(1, tiles.iter());
        for (tile, lane) in [(0, 0), (0, 31), (1, 3), (1, 17)] {
            let path = Wiener::new(seed).path(tiles[tile][lane]);
            let count = if is_coarsened { 2 } else { 1 };
            let of_step = h / count as f64;
            let steps = 2 * BATCH as usize * count;
            let path = Recorded::record_stages(path, of_step, 5, stages, steps).unwrap();
            let path = path.coarsen(count).unwrap();
            for step in BATCH..2 * BATCH {
                let got = buffer.of(tile, step).0.map(|increment| increment[lane]);
                assert_eq!(
                    got,
                    path.get(step as usize).unwrap(),
                    "{N} {tile} {lane} {step}"
                );
            }
        }
    }

    #[test]
    fn increments_at_stages_have_the_bits_of_single_paths() {
        for is_coarsened in [false, true] {
            stages_are_those_of_single_paths::<10>(is_coarsened);
            stages_are_those_of_single_paths::<15>(is_coarsened);
            stages_are_those_of_single_paths::<40>(is_coarsened);
        }
    }
}
