//! Packing: paths that go on are moved together where others have stopped, so that stopped paths
//! cost no steps.
//!
//! Input: tiles with free lanes. Output: as few tiles with active lanes as hold them. Invariant: a
//! path has the same bits in any lane, so packing changes no result.

use super::path_block::PathBlock;
use super::tile::{Place, lanes};
use crate::ensemble::PathMethod;
use crate::lanes::{ALL, LANES};
use crate::method::DimsOf;
use crate::system::Dimensions;

impl<I: PathMethod> PathBlock<'_, I> {
    /// Empties tiles whose paths fit into the free lanes of others, the tile with the fewest paths
    /// first.
    pub(super) fn pack(&mut self) {
        loop {
            let used = || (0..self.tiles.len()).filter(|&tile| self.tiles[tile].active != 0);
            let paths = |tile: usize| self.tiles[tile].active.count_ones() as usize;
            let all: usize = used().map(paths).sum();
            if all.div_ceil(LANES) == used().count() {
                return;
            }
            let Some(source) = used().min_by_key(|&tile| paths(tile)) else {
                return;
            };
            let targets: Vec<usize> = used().filter(|&tile| tile != source).collect();
            let free = targets.into_iter().flat_map(|tile| {
                lanes(ALL & !self.tiles[tile].active).map(move |lane| Place { tile, lane })
            });
            let from = lanes(self.tiles[source].active).map(|lane| Place { tile: source, lane });
            let moves: Vec<(Place, Place)> = from.zip(free).collect();
            for (from, to) in moves {
                self.move_lane(from, to);
            }
        }
    }

    /// Moves a path to a free lane.
    fn move_lane(&mut self, from: Place, to: Place) {
        let source = &self.tiles[from.tile];
        let [before, state] = [source.states_before(), source.states()]
            .map(|states| DimsOf::<I>::get(states, from.lane));
        let path = self.tiles[from.tile].paths[from.lane];
        self.tiles[from.tile].active &= !(1 << from.lane);
        let target = &mut self.tiles[to.tile];
        let (to_before, to_now) = target.buffers_mut();
        DimsOf::<I>::set(to_before, to.lane, &before);
        DimsOf::<I>::set(to_now, to.lane, &state);
        target.paths[to.lane] = path;
        target.active |= 1 << to.lane;
        target.is_at_home = false;
        for observer in &mut self.observers {
            observer.move_lane(from, to);
        }
        self.watch.move_lane(from, to);
    }
}
