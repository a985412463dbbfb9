//! The systems of the lanes of a tile.
//!
//! Input: a method, and the states of a tile before its last step. Output: the system that each
//! lane had in this step. Invariant: lanes have systems of their own only if steps hold inputs.

use super::observe::Function;
use super::observer::LastStep;
use super::path_block::PathBlock;
use crate::ensemble::PathMethod;
use crate::lanes::{LANES, Lane};
use crate::method::DimsOf;
use crate::system::{Dimensions, StateLanesOf, System};

/// The system of each lane of a tile.
pub(super) enum Systems<'t, S> {
    /// All lanes have the same system.
    Same(&'t S),
    /// Each lane has the system with the inputs of its last step.
    OfLanes(Vec<S>),
}

impl<S> Systems<'_, S> {
    /// Returns the system of a lane.
    pub(super) fn of(&self, lane: usize) -> &S {
        match self {
            Self::Same(system) => system,
            Self::OfLanes(systems) => &systems[lane],
        }
    }
}

impl<S: System> Systems<'_, S> {
    /// Evaluates a function in all lanes; NaN where the function fails.
    pub(super) fn evaluate<F>(&self, function: &F, states: &StateLanesOf<S>, values: &mut Lane)
    where
        F: Function<S> + ?Sized,
    {
        match self {
            Self::Same(system) => function.tile(system, states, values),
            Self::OfLanes(systems) => {
                for ((lane, value), system) in values.iter_mut().enumerate().zip(systems) {
                    let state = S::Dims::get(states, lane);
                    *value = function.value(system, &state).unwrap_or(f64::NAN);
                }
            }
        }
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
            method.system_of_step(tile.paths[lane], step, &DimsOf::<I>::get(before, lane))
        };
        let systems: Option<Vec<_>> = (0..LANES).map(system).collect();
        systems.map_or_else(|| Systems::Same(method.system()), Systems::OfLanes)
    }
}
