//! Tiles: as many paths as there are lanes.
//!
//! Invariant: an unused lane holds a copy of an active lane's state, so that its step is solvable.

use super::increment_buffer::IncrementBuffer;
use crate::ensemble::PathMethod;
use crate::lanes::dispatch::Kernel;
use crate::lanes::{LANES, Mask};
use crate::method::DimsOf;
use crate::system::{Dimensions, StateLanesOf};
use crate::time::time_after;

/// A lane of a tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) tile: usize,
    pub(super) lane: usize,
}

/// The states of some paths in lanes. A lane is active if its path exists, has not failed and has
/// not stopped; the other lanes copy an active lane.
pub(super) struct Tile<L> {
    /// The current states, and the work space for the states after a step.
    pub(super) buffers: [L; 2],
    /// Which buffer has the current states.
    pub(super) current: bool,
    /// The active lanes.
    pub(super) active: Mask,
    /// Active lanes that the last step in lanes did not solve.
    pub(super) unsolved: Mask,
    /// The path of each lane.
    pub(super) paths: [u64; LANES],
    /// The tile still has the paths with which it began.
    pub(super) is_at_home: bool,
}

impl<L> Tile<L> {
    /// The states reached so far.
    pub(super) fn states(&self) -> &L {
        &self.buffers[usize::from(self.current)]
    }

    /// The states before the last step.
    pub(super) fn states_before(&self) -> &L {
        &self.buffers[usize::from(!self.current)]
    }

    pub(super) fn states_mut(&mut self) -> &mut L {
        &mut self.buffers[usize::from(self.current)]
    }

    /// Swaps the buffers. Returns the states before a step, and the work space for the states after
    /// it, which become the current ones.
    #[inline(always)]
    pub(super) fn swap_buffers(&mut self) -> (&L, &mut L) {
        self.current = !self.current;
        let (before, next) = self.buffers_mut();
        (before, next)
    }

    /// Returns the states before the last step, and those reached so far.
    #[inline(always)]
    pub(super) fn buffers_mut(&mut self) -> (&mut L, &mut L) {
        let [first, second] = &mut self.buffers;
        if self.current {
            (first, second)
        } else {
            (second, first)
        }
    }
}

/// Returns the lanes of a set.
pub(super) fn lanes(set: Mask) -> impl Iterator<Item = usize> {
    (0..LANES).filter(move |lane| set >> lane & 1 == 1)
}

/// Steps all tiles until a step does not solve an active lane. Returns the number of steps then
/// made.
///
/// The tiles alternate: the operations of one step depend on one another, and the operations of two
/// tiles do not.
pub(super) struct AdvanceTiles<'f, I: PathMethod> {
    pub(super) method: &'f I,
    pub(super) prepared: &'f mut I::Prepared,
    pub(super) h: f64,
    pub(super) start_time: f64,
    pub(super) increments: &'f IncrementBuffer<I::Increments>,
    pub(super) tiles: &'f mut [Tile<StateLanesOf<I::System>>],
    pub(super) step: u64,
    pub(super) end: u64,
}

impl<I: PathMethod> Kernel for AdvanceTiles<'_, I> {
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let mut step = self.step;
        let mut unsolved = 0;
        while step < self.end && unsolved == 0 {
            let t = time_after(self.start_time, step + 1, self.h);
            for (number, tile) in self.tiles.iter_mut().enumerate() {
                if tile.active == 0 {
                    continue;
                }
                let (method, paths) = (self.method, (&tile.paths, tile.active));
                let failed = method.hold_lanes(self.prepared, paths, step, tile.states());
                let (before, next) = tile.swap_buffers();
                // a closure would not be compiled for the vectors of the machine
                let several;
                let dw = match self.increments.only(number, step) {
                    Some(only) => only,
                    None => {
                        several = self.increments.of(number, step);
                        &several.0
                    }
                };
                let unsolved_here =
                    failed | method.step_lanes(self.prepared, before, next, self.h, dw);
                *DimsOf::<I>::times(next) = [t; LANES];
                tile.unsolved = unsolved_here & tile.active;
                unsolved |= tile.unsolved;
            }
            step += 1;
        }
        step
    }
}
