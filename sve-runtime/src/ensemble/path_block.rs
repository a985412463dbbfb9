//! Blocks of paths, stepped a tile of lanes at a time.
//!
//! Input: the settings of the ensemble and the numbers of blocks. Output: the states of their paths
//! at any step, and their failures. Invariant: the states of a path depend on its number only.
//! Lanes are independent, and a lane that the lane step does not solve takes the scalar step
//! whatever its neighbours do. The time after step `k` is `t₀ + k h`, rounded once.

use core::ops::Range;

use super::failure::{Cause, Failure};
use super::increment_buffer::{BATCH, IncrementBuffer};
use super::observer::{LastStep, Observer};
use super::passage::watch::PassageWatch;
use super::settings::Settings;
use super::systems::Systems;
use super::tangents::Tangents;
use super::tile::{AdvanceTiles, Place, Tile, lanes};
use super::{BLOCK_TILES, EnsembleError, path_at};
use crate::ensemble::PathMethod;
use crate::error::StepError;
use crate::lanes::dispatch::dispatch;
use crate::lanes::{ALL, Aligned, LANES, Lane, Mask};
use crate::method::DimsOf;
use crate::phase::configuration::{Configuration as _, FixedSize};
use crate::phase::state::State;
use crate::system::{
    ConfigurationOf, Dimensions, IncrementLanesOf, Increments as _, StateLanesOf, StateOf,
};

/// Paths of some consecutive blocks. If no path can stop, there is one block.
pub(super) struct PathBlock<'a, I: PathMethod> {
    pub(super) settings: Settings<'a, I>,
    pub(super) prepared: I::Prepared,
    /// The increments of each [`BLOCK_TILES`] tiles.
    pub(super) increments: Vec<IncrementBuffer<I::Increments>>,
    pub(super) first_path: u64,
    /// Steps made.
    pub(super) step: u64,
    pub(super) tiles: Vec<Tile<StateLanesOf<I::System>>>,
    /// The observer of the weight if there is one, and the observers of the observables.
    pub(super) observers: Vec<Box<dyn Observer<I::System> + 'a>>,
    pub(super) watch: PassageWatch,
    /// The tangent vectors of the paths, if there are gradients.
    pub(super) tangents: Tangents<DimsOf<I>>,
    pub(super) ends: Ends<StateOf<I::System>>,
    pub(super) records: Records,
}

/// The failures and stops of single paths.
pub(super) struct Ends<T> {
    pub(super) failures: Vec<Failure>,
    /// The path of each step that was made in smaller steps.
    pub(super) refined: Vec<u64>,
    /// Paths that have stopped, with their last states.
    pub(super) stopped: Vec<(u64, T)>,
}

/// The observables of the paths, in the lanes with which they began.
pub(super) struct Records {
    /// The observables of each [`LANES`] paths, at the last record or where a path stopped.
    pub(super) values: Vec<Vec<Lane>>,
    /// The paths that count, in groups of [`LANES`]: the paths that have not failed.
    pub(super) counted: Vec<Mask>,
    /// The observables of each tile at all recorded times so far, if covariances of two times are
    /// taken.
    pub(super) history: Vec<Vec<Vec<Lane>>>,
    /// Work space: the observables of a tile.
    pub(super) work: Vec<Lane>,
}

impl<'a, I: PathMethod> PathBlock<'a, I> {
    /// Starts the paths of some blocks, or only one of these paths.
    pub(super) fn new(
        settings: Settings<'a, I>,
        blocks: Range<u64>,
        only: Option<u64>,
    ) -> Result<Self, EnsembleError> {
        let ensemble = settings.ensemble;
        let paths = path_at(blocks.start, settings.paths)..path_at(blocks.end, settings.paths);
        let first_path = paths.start;
        // The last block may end at the largest number.
        let tiles = (paths.end - first_path).div_ceil(LANES as u64) as usize;
        let names = ensemble.observed.names.len();
        let mut block = Self {
            settings,
            prepared: (settings.method)
                .prepare(settings.h)
                .map_err(EnsembleError::Prepare)?,
            increments: Vec::new(),
            first_path,
            step: 0,
            tiles: Vec::with_capacity(tiles),
            observers: ensemble.observers(settings.settled(), tiles),
            watch: PassageWatch::new(ensemble, tiles),
            tangents: Tangents::new(&ensemble.observed.gradients, settings.parts, tiles),
            ends: Ends {
                failures: Vec::new(),
                refined: Vec::new(),
                stopped: Vec::new(),
            },
            records: Records {
                values: vec![vec![[0.0; LANES]; names]; tiles],
                counted: vec![0; tiles],
                history: Vec::new(),
                work: vec![[0.0; LANES]; names],
            },
        };
        for _ in 0..tiles.div_ceil(BLOCK_TILES) {
            block.increments.push(settings.increments());
        }
        for tile in 0..tiles {
            let is_wanted = |path| paths.contains(&path) && only.is_none_or(|only| only == path);
            block.start_tile(first_path + (tile * LANES) as u64, is_wanted);
        }
        for tile in 0..tiles {
            block.observe_step(tile);
        }
        Ok(block)
    }

    fn start_tile(&mut self, first: u64, is_wanted: impl Fn(u64) -> bool) {
        let paths: [u64; LANES] = core::array::from_fn(|lane| first.wrapping_add(lane as u64));
        let starts: [StateOf<I::System>; LANES] = paths.map(|path| {
            if is_wanted(path) {
                self.settings.start_of(path)
            } else {
                State::new(
                    FixedSize::origin(),
                    ConfigurationOf::<I::System>::no_momentum(),
                )
            }
        });
        let mut states = DimsOf::<I>::splat(&starts[0]);
        let mut active = 0;
        for lane in 0..LANES {
            DimsOf::<I>::set(&mut states, lane, &starts[lane]);
            active |= Mask::from(is_wanted(paths[lane])) << lane;
        }
        let tile = self.tiles.len();
        self.records.counted[tile] = active;
        self.tiles.push(Tile {
            buffers: [states, states],
            current: false,
            active,
            unsolved: 0,
            paths,
            is_at_home: true,
        });
        for lane in lanes(active) {
            if let Some(cause) = self.start_error(paths[lane], &starts[lane]) {
                self.fail(tile, lane, 0, cause);
            }
        }
        for lane in lanes(ALL & !self.tiles[tile].active) {
            self.fill_unused_lane(tile, lane);
        }
    }

    /// Returns why a path cannot start at a state; `None` if it can.
    fn start_error(&self, path: u64, state: &StateOf<I::System>) -> Option<Cause> {
        // Names are made for errors only: making a name for each number of each path takes as long
        // as about ten steps.
        let not_finite = |of: &str, i: usize, value: f64| {
            let t = state.t;
            (!value.is_finite()).then(|| {
                Cause::Step(StepError::NonFiniteInput {
                    what: format!("{of}[{i}]"),
                    value,
                    t,
                })
            })
        };
        if state.t != self.settings.start_time {
            let (t, expected) = (state.t, self.settings.start_time);
            return Some(Cause::StartTime { t, expected });
        }
        let mut momenta = DimsOf::<I>::ZERO;
        state.p.store(momenta.as_mut());
        let sum = state.q.sum_of_stored_values() + momenta.as_ref().iter().sum::<f64>();
        if sum.is_finite() {
            let system = self.settings.method.system_of_step(path, 0, state);
            return system.err().map(Cause::Step);
        }
        let [mut q, mut p] = state.stored().map(|values| values.into_iter().enumerate());
        q.find_map(|(i, q)| not_finite("q", i, q))
            .or_else(|| p.find_map(|(i, p)| not_finite("p", i, p)))
    }

    /// Steps every active path until it has made so many steps, and observes it.
    pub(super) fn advance(&mut self, until: u64) {
        while self.step < until {
            let begin = self.step;
            let end = until.min((begin / BATCH + 1) * BATCH);
            for buffer in 0..self.increments.len() {
                self.step = begin;
                self.advance_some(buffer, end);
            }
            self.step = end;
            if self.settings.ensemble.has_stops() {
                self.pack();
            }
        }
    }

    /// Steps the active paths of the tiles that share a buffer of increments, within a batch of
    /// steps.
    fn advance_some(&mut self, buffer: usize, end: u64) {
        let first = buffer * BLOCK_TILES;
        let tiles = first..self.tiles.len().min(first + BLOCK_TILES);
        let is_active = |tile: &Tile<_>| tile.active != 0;
        if !self.tiles[tiles.clone()].iter().any(is_active) {
            return;
        }
        let paths = self.tiles[tiles.clone()].iter().map(|tile| &tile.paths);
        self.increments[buffer].load(self.step / BATCH, paths);
        let carries = !self.tangents.is_empty();
        let sees_steps =
            !self.watch.is_empty() || self.observers.iter().any(|observer| observer.sees_steps());
        while self.step < end && self.tiles[tiles.clone()].iter().any(is_active) {
            let until = if sees_steps { self.step + 1 } else { end };
            self.step = if carries {
                self.carry(buffer, tiles.clone(), until)
            } else {
                dispatch(AdvanceTiles {
                    method: self.settings.method,
                    prepared: &mut self.prepared,
                    h: self.settings.h,
                    start_time: self.settings.start_time,
                    increments: &self.increments[buffer],
                    tiles: &mut self.tiles[tiles.clone()],
                    step: self.step,
                    end: until,
                })
            };
            for tile in tiles.clone() {
                self.step_unsolved_lanes(tile);
                if carries {
                    self.carry_unfinished_lanes(tile);
                }
                if sees_steps {
                    self.observe_step(tile);
                }
            }
        }
    }

    /// Returns the increments of a tile for a step of the batch that was loaded last.
    pub(super) fn increments_of(
        &self,
        tile: usize,
        step: u64,
    ) -> Aligned<IncrementLanesOf<I::Increments>> {
        self.increments[tile / BLOCK_TILES].of(tile % BLOCK_TILES, step)
    }

    /// Shows the last step of a tile, or its start, to the observers that see all steps, and stops
    /// paths.
    fn observe_step(&mut self, tile: usize) {
        if self.tiles[tile].active == 0 {
            return;
        }
        let mut last = LastStep::whole(self.step, self.settings.h);
        let systems = self.systems(tile, &last);
        let stopped = self.find_passages(tile, &mut last, &systems);
        self.show(tile, &last, &systems);
        if stopped != 0 {
            self.stop(tile, stopped, &last, &systems);
        }
    }

    /// Ends the paths of some lanes at their states.
    #[cold]
    fn stop(
        &mut self,
        tile: usize,
        stopped: Mask,
        last: &LastStep,
        systems: &Systems<'_, I::System>,
    ) {
        self.observe(tile, stopped, last, systems);
        for lane in lanes(stopped & self.tiles[tile].active) {
            let state = DimsOf::<I>::get(self.tiles[tile].states(), lane);
            let path = self.tiles[tile].paths[lane];
            self.ends.stopped.push((path, state));
            self.tiles[tile].active &= !(1 << lane);
        }
        for lane in lanes(ALL & !self.tiles[tile].active) {
            self.fill_unused_lane(tile, lane);
        }
    }

    /// Repeats the last step with the scalar step, in the lanes that the lane step did not solve.
    fn step_unsolved_lanes(&mut self, tile: usize) {
        let unsolved = core::mem::take(&mut self.tiles[tile].unsolved);
        let step = self.step - 1;
        for lane in lanes(unsolved & self.tiles[tile].active) {
            let increments = self.increments_of(tile, step);
            let mut state = DimsOf::<I>::get(self.tiles[tile].states_before(), lane);
            state.t = self.settings.time(step);
            let dw = I::Increments::of_lane(&increments.0, lane);
            let (method, h, path) = (
                self.settings.method,
                self.settings.h,
                self.tiles[tile].paths[lane],
            );
            let made = match method.hold(&mut self.prepared, path, step, &state) {
                Ok(()) => (method.step_prepared(&self.prepared, &mut state, h, &dw))
                    .or_else(|error| self.step_in_parts(error, tile, lane, &mut state, &dw)),
                Err(error) => Err(error),
            };
            match made {
                Ok(()) => {
                    state.t = self.settings.time(step + 1);
                    DimsOf::<I>::set(self.tiles[tile].states_mut(), lane, &state);
                }
                Err(error) => self.fail(tile, lane, step, Cause::Step(error)),
            }
        }
    }

    /// Records the failure of a path after so many whole steps, and deactivates its lane.
    pub(super) fn fail(&mut self, tile: usize, lane: usize, step: u64, cause: Cause) {
        self.fail_at(self.settings.time(step), tile, lane, step, cause);
    }

    /// Records the failure of a path at a time after so many steps, and deactivates its lane. The
    /// last step may be a part of a step.
    #[cold]
    pub(super) fn fail_at(&mut self, t: f64, tile: usize, lane: usize, step: u64, cause: Cause) {
        self.tiles[tile].active &= !(1 << lane);
        let path = self.tiles[tile].paths[lane];
        let home = self.home_of(path);
        self.records.counted[home.tile] &= !(1 << home.lane);
        self.ends.failures.push(Failure {
            path,
            step,
            t,
            cause,
        });
        if self.settings.ensemble.stop_on_failure {
            // Later paths cannot be the first path that fails.
            for tile in &mut self.tiles {
                let later = lanes(ALL).filter(|&lane| tile.paths[lane] > path);
                let later = later.fold(0, |lanes, lane| lanes | 1 << lane);
                tile.active &= !later;
            }
        }
        self.fill_unused_lane(tile, lane);
    }

    /// Returns the lane with which a path began.
    pub(super) fn home_of(&self, path: u64) -> Place {
        let number = (path - self.first_path) as usize;
        Place {
            tile: number / LANES,
            lane: number % LANES,
        }
    }

    /// Fills an unused lane with a copy of an active lane, so that the step in it is solvable and
    /// takes the fast path.
    fn fill_unused_lane(&mut self, tile: usize, lane: usize) {
        let tile = &mut self.tiles[tile];
        if tile.active != 0 {
            let other = DimsOf::<I>::get(tile.states(), tile.active.trailing_zeros() as usize);
            DimsOf::<I>::set(tile.states_mut(), lane, &other);
        }
    }
}
