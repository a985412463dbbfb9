//! Tiles: as many paths as there are lanes.
//!
//! Invariant: an unused lane holds a copy of an active lane's state, so that its step is solvable.

use crate::lanes::{LANES, Mask};

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
