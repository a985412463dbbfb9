//! The systems of the lanes of a tile.
//!
//! Input: a method, and the states of a tile before its last step. Output: the system that each
//! lane had in this step. Invariant: lanes have systems of their own only if steps hold inputs.

use super::observer::LastStep;
use super::path_block::PathBlock;
use crate::ensemble::PathMethod;
use crate::lanes::LANES;
use crate::method::DimsOf;
use crate::system::Dimensions;

/// The system of each lane of a tile.
pub(super) enum Systems<'t, S> {
    /// All lanes have the same system.
    Same(&'t S),
    /// Each lane has the system with the inputs of its last step.
    OfLanes(Vec<S>),
}

impl<S> Systems<'_, S> {
    /// Returns the system of a lane.
    #[inline(always)]
    pub(super) fn of(&self, lane: usize) -> &S {
        match self {
            Self::Same(system) => system,
            Self::OfLanes(systems) => &systems[lane],
        }
    }

    /// Visits each lane with its system. One system for all lanes is known before the loop, which
    /// is then compiled for vectors.
    #[inline(always)]
    pub(super) fn each(&self, mut visit: impl FnMut(usize, &S)) {
        match self {
            Self::Same(system) => {
                for lane in 0..LANES {
                    visit(lane, system);
                }
            }
            Self::OfLanes(systems) => {
                for (lane, system) in systems.iter().enumerate() {
                    visit(lane, system);
                }
            }
        }
    }

    /// Returns whether the systems hold inputs, which change where a step ends.
    pub(super) fn hold_inputs(&self) -> bool {
        matches!(self, Self::OfLanes(_))
    }
}

impl<'a, I: PathMethod> PathBlock<'a, I> {
    /// Returns the system of each lane of a tile in its last step; at the start, in the first step.
    pub(super) fn systems(&self, tile: usize, last: &LastStep) -> Systems<'a, I::System> {
        let method: &'a I = self.settings.method;
        let tile = &self.tiles[tile];
        let (step, before) = match last.number {
            0 => (0, tile.states()),
            number => (number - 1, tile.states_before()),
        };
        let system = |lane: usize| {
            // an unused lane copies the states of an active one
            let is_active = tile.active >> lane & 1 == 1;
            let lane = if is_active {
                lane
            } else {
                tile.active.trailing_zeros() as usize % LANES
            };
            let state = DimsOf::<I>::get(before, lane);
            // the step was made with these inputs, so they are finite
            let system = method.system_of_step(tile.paths[lane], step, &state);
            system.ok().flatten()
        };
        let systems: Option<Vec<_>> = (0..LANES).map(system).collect();
        systems.map_or_else(|| Systems::Same(method.system()), Systems::OfLanes)
    }
}
