//! Tangent vectors of the paths of a block, carried along their steps.
//!
//! Input: the tiles of a block and the quantities by which means are differentiated. Output: a
//! tangent vector for each path and quantity at any step. Invariant: the states have the bits of a
//! block without tangent vectors, and the vectors of a path depend on its number only. A lane whose
//! vectors the step in lanes does not carry gets them from the step of a single state, at the
//! states that the step in lanes has reached.

use core::ops::Range;

use super::by::{By, Varied};
use super::failure::Cause;
use super::gradient::Gradients;
use super::increment_buffer::IncrementBuffer;
use super::observer::LastStep;
use super::path_block::PathBlock;
use super::tile::{Tile, lanes};
use crate::ensemble::PathMethod;
use crate::lanes::dispatch::{Kernel, dispatch};
use crate::lanes::{LANES, Mask};
use crate::method::{Differentiable, DimsOf};
use crate::phase::Field;
use crate::phase::tangents::{FieldLanes, LaneDirections};
use crate::system::linearisation::Directions;
use crate::system::{Dimensions, Increments as _, StateLanesOf, System, TangentLanesOf};
use crate::time::time_after;

/// The tangent vectors of the paths of a block.
pub(super) struct Tangents<D: Dimensions> {
    tiles: Vec<TangentTile<D::TangentLanes>>,
    /// The parameters and coordinates that vary, one for each direction.
    varied: Vec<Varied>,
    /// Work space: the parameter that varies in a step, and the vectors of a path, by quantity.
    parameters: Vec<Option<usize>>,
    fields: Vec<Field<D::Vector>>,
}

/// The tangent vectors of the paths of a tile, by quantity.
pub(super) struct TangentTile<L> {
    /// The current vectors, and the work space for the vectors after a step.
    buffers: [Vec<L>; 2],
    /// Which buffer has the current vectors.
    current: bool,
    /// The lanes whose vectors the last step in lanes did not carry.
    unfinished: Mask,
}

impl<L> TangentTile<L> {
    fn fields(&self) -> &[L] {
        &self.buffers[usize::from(self.current)]
    }

    /// Swaps the buffers. Returns the vectors before a step, and the work space for the vectors
    /// after it, which become the current ones.
    #[inline(always)]
    fn swap_buffers(&mut self) -> (&[L], &mut [L]) {
        self.current = !self.current;
        let [first, second] = &mut self.buffers;
        if self.current {
            (first, second)
        } else {
            (second, first)
        }
    }
}

impl<D: Dimensions> Tangents<D> {
    /// The tangent vectors at the start, for so many tiles. A step of the ensemble is `parts` steps
    /// of the run.
    pub(super) fn new<I: PathMethod>(
        gradients: &Gradients<'_, I>,
        parts: u64,
        tiles: usize,
    ) -> Self {
        let fields: Vec<_> = gradients.by.iter().map(By::start::<D>).collect();
        let starts: Vec<_> = fields.iter().map(FieldLanes::splat).collect();
        let tile = || TangentTile {
            buffers: [starts.clone(), starts.clone()],
            current: false,
            unfinished: 0,
        };
        let varied = (gradients.by.iter()).map(|by| by.varied::<I::System>(parts));
        Self {
            tiles: (0..tiles).map(|_| tile()).collect(),
            varied: varied.collect(),
            parameters: vec![None; fields.len()],
            fields,
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.varied.is_empty()
    }

    /// Returns the vector of a path along a direction.
    pub(super) fn of(&self, tile: usize, direction: usize, lane: usize) -> Field<D::Vector> {
        self.tiles[tile].fields()[direction].get(lane)
    }

    /// Returns the parameter that varies along a direction in the last step.
    pub(super) fn varied_in(&self, direction: usize, step: &LastStep) -> Option<usize> {
        self.varied[direction].in_step(step.number.saturating_sub(1))
    }
}

/// Steps all tiles with their tangent vectors until a step does not solve an active lane or does
/// not carry its vectors. Returns the number of steps then made.
pub(super) struct CarryTiles<'f, I: PathMethod> {
    method: &'f I,
    prepared: &'f mut I::Prepared,
    h: f64,
    start_time: f64,
    increments: &'f IncrementBuffer<I::Increments>,
    tiles: &'f mut [Tile<StateLanesOf<I::System>>],
    tangents: &'f mut [TangentTile<TangentLanesOf<I::System>>],
    varied: &'f [Varied],
    parameters: &'f mut [Option<usize>],
    step: u64,
    end: u64,
}

/// Runs the kernel, for the methods that have it.
pub(super) fn carry_tiles<I: PathMethod + Differentiable>(tiles: CarryTiles<'_, I>) -> u64 {
    dispatch(tiles)
}

impl<I: PathMethod + Differentiable> Kernel for CarryTiles<'_, I> {
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let mut step = self.step;
        let mut left = 0;
        while step < self.end && left == 0 {
            let t = time_after(self.start_time, step + 1, self.h);
            for (parameter, varied) in self.parameters.iter_mut().zip(self.varied) {
                *parameter = varied.in_step(step);
            }
            let tiles = self.tiles.iter_mut().zip(self.tangents.iter_mut());
            for (number, (tile, tangents)) in tiles.enumerate() {
                if tile.active == 0 {
                    continue;
                }
                let (method, paths) = (self.method, (&tile.paths, tile.active));
                let failed = method.hold_lanes(self.prepared, paths, step, tile.states());
                let (before, next) = tile.swap_buffers();
                let (start, end) = tangents.swap_buffers();
                let directions = LaneDirections {
                    start,
                    next: end,
                    parameters: self.parameters,
                };
                let dw = self.increments.of(number, step);
                let [unsolved, unfinished] = method.push_forward_lanes(
                    self.prepared,
                    before,
                    next,
                    self.h,
                    &dw.0,
                    directions,
                );
                *<I::System as System>::Dims::times(next) = [t; LANES];
                tile.unsolved = (failed | unsolved) & tile.active;
                tangents.unfinished = (failed | unfinished) & tile.active;
                left |= tangents.unfinished;
            }
            step += 1;
        }
        step
    }
}

impl<I: PathMethod> PathBlock<'_, I> {
    /// Steps some tiles with their tangent vectors, as far as the step in lanes goes. Returns the
    /// number of steps then made.
    pub(super) fn carry(&mut self, buffer: usize, tiles: Range<usize>, end: u64) -> u64 {
        let settings = self.settings;
        let Some(steps) = settings.ensemble.observed.gradients.steps else {
            return self.step;
        };
        (steps.in_lanes)(CarryTiles {
            method: settings.method,
            prepared: &mut self.prepared,
            h: settings.h,
            start_time: settings.start_time,
            increments: &self.increments[buffer],
            tiles: &mut self.tiles[tiles.clone()],
            tangents: &mut self.tangents.tiles[tiles],
            varied: &self.tangents.varied,
            parameters: &mut self.tangents.parameters,
            step: self.step,
            end,
        })
    }

    /// Carries the tangent vectors along the last step in the active lanes where the step in lanes
    /// did not.
    pub(super) fn carry_unfinished_lanes(&mut self, tile: usize) {
        let unfinished = core::mem::take(&mut self.tangents.tiles[tile].unfinished);
        let settings = self.settings;
        let (Some(steps), Some(step)) = (
            settings.ensemble.observed.gradients.steps,
            self.step.checked_sub(1),
        ) else {
            return;
        };
        for lane in lanes(unfinished & self.tiles[tile].active) {
            let increments = self.increments_of(tile, step);
            let mut state = DimsOf::<I>::get(self.tiles[tile].states_before(), lane);
            state.t = settings.time(step);
            let Tangents {
                tiles,
                parameters,
                fields,
                varied: _,
            } = &mut self.tangents;
            let TangentTile {
                buffers, current, ..
            } = &mut tiles[tile];
            let [before, after] = [!*current, *current].map(usize::from);
            for (field, lanes) in fields.iter_mut().zip(&buffers[before]) {
                *field = lanes.get(lane);
            }
            let directions = Directions { fields, parameters };
            let dw = I::Increments::of_lane(&increments.0, lane);
            let (method, h) = (settings.method, settings.h);
            let path = self.tiles[tile].paths[lane];
            let made = (method.hold(&mut self.prepared, path, step, &state)).and_then(|()| {
                (steps.alone)(method, &self.prepared, &mut state, h, &dw, directions)
            });
            for (field, lanes) in fields.iter().zip(&mut buffers[after]) {
                lanes.set(lane, field);
            }
            if let Err(error) = made {
                self.fail(tile, lane, step, Cause::Step(error));
            }
        }
    }
}
