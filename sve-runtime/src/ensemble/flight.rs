//! The paths of a block on their way, a tile of lanes at a time.
//!
//! Input: the ensemble's settings and a block's number. Output: its states at any step, and its failures.
//! Invariant: a path's states depend on its number alone: lanes do not touch one another, and one that the lane step leaves
//! is stepped by the scalar step whatever its neighbours do. The time after step `k` is `t₀ + k h`, rounded once.

use super::failure::{Cause, Failure};
use super::increments::{Increments, STRETCH};
use super::run::Run;
use super::start::{Start, StartRng};
use super::{BLOCK_PATHS, BLOCK_TILES, EnsembleError, path_at};
use crate::configuration::Coordinates;
use crate::error::StepError;
use crate::lanes::dispatch::{Kernel, dispatch};
use crate::lanes::{ALL, LANES, Lane, Mask, StateLanes};
use crate::method::Method;
use crate::state::State;
use crate::system::{Dimensions, Dims, System};
use crate::trajectory::time_after;

/// The paths of a block.
pub(super) struct Flight<'a, I: Method, const N: usize, const M: usize> {
    pub(super) run: Run<'a, I>,
    prepared: I::Prepared,
    increments: Increments<M>,
    pub(super) first_path: u64,
    /// Steps made.
    pub(super) step: u64,
    pub(super) tiles: Vec<Tile<N>>,
    pub(super) failures: Vec<Failure>,
    /// Room for the observables of a tile.
    pub(super) values: Vec<Lane>,
}

/// States in lanes, and the lanes whose paths exist and have not failed. The others copy a path that lives.
pub(super) struct Tile<const N: usize> {
    /// The states, and room for those after a step, which changes places with them.
    buffers: [StateLanes<N>; 2],
    /// Which are the states.
    at: bool,
    pub(super) alive: Mask,
    /// Living lanes whose state is still the one before the last step.
    left: Mask,
}

impl<const N: usize> Tile<N> {
    /// The states reached so far.
    pub(super) fn states(&self) -> &StateLanes<N> {
        &self.buffers[usize::from(self.at)]
    }

    fn states_mut(&mut self) -> &mut StateLanes<N> {
        &mut self.buffers[usize::from(self.at)]
    }

    /// Lets the two change places: the states before a step, and those after it.
    #[inline(always)]
    fn turn(&mut self) -> (&StateLanes<N>, &mut StateLanes<N>) {
        self.at = !self.at;
        let [first, second] = &mut self.buffers;
        if self.at {
            (first, second)
        } else {
            (second, first)
        }
    }
}

impl<'a, I, S, Q, const N: usize, const M: usize> Flight<'a, I, N, M>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// The paths of a block at their start; of one path alone, where one is given.
    pub(super) fn new(
        run: Run<'a, I>,
        block: u64,
        only: Option<u64>,
    ) -> Result<Self, EnsembleError> {
        let first_path = block * BLOCK_PATHS;
        let mut flight = Self {
            run,
            prepared: run
                .ensemble
                .method
                .prepare(run.h)
                .map_err(EnsembleError::Prepare)?,
            increments: run.increments(first_path),
            first_path,
            step: 0,
            tiles: Vec::with_capacity(BLOCK_TILES),
            failures: Vec::new(),
            values: vec![[0.0; LANES]; run.ensemble.names.len()],
        };
        let paths = first_path..path_at(block + 1, run.paths);
        // the last block may end at the largest number
        let tiles = (paths.end - first_path).div_ceil(LANES as u64);
        for first in (0..tiles).map(|tile| first_path + tile * LANES as u64) {
            let wanted = |path| paths.contains(&path) && only.is_none_or(|only| only == path);
            flight.start_tile(first, wanted);
        }
        Ok(flight)
    }

    fn start_tile(&mut self, first: u64, wanted: impl Fn(u64) -> bool) {
        let starts: [State<[f64; N]>; LANES] = core::array::from_fn(|lane| {
            let path = first.wrapping_add(lane as u64);
            match &self.run.ensemble.start {
                Some(Start::Drawn(draw)) if wanted(path) => {
                    draw(path, &mut StartRng::new(self.run.ensemble.seed, path)).to_coordinates()
                }
                Some(Start::Same(state)) => state.to_coordinates(),
                _ => State::new([0.0; N], [0.0; N]),
            }
        });
        let mut states = StateLanes::splat(&starts[0]);
        let mut alive = 0;
        for lane in 0..LANES {
            states.set(lane, &starts[lane]);
            alive |= Mask::from(wanted(first.wrapping_add(lane as u64))) << lane;
        }
        let tile = self.tiles.len();
        self.tiles.push(Tile {
            buffers: [states, states],
            at: false,
            alive,
            left: 0,
        });
        for lane in lanes(alive) {
            if let Some(cause) = self.unfit(&starts[lane]) {
                self.fail(tile, lane, 0, cause);
            }
        }
        for lane in lanes(ALL & !self.tiles[tile].alive) {
            self.replace(tile, lane);
        }
    }

    /// Why a path cannot start there.
    fn unfit(&self, state: &State<[f64; N]>) -> Option<Cause> {
        let named = |what: String, value: f64| {
            let t = state.t;
            (!value.is_finite()).then_some(Cause::Step(StepError::NonFiniteInput {
                what,
                value,
                t,
            }))
        };
        if state.t != self.run.start_time {
            let (t, expected) = (state.t, self.run.start_time);
            return Some(Cause::StartTime { t, expected });
        }
        (0..N)
            .find_map(|i| named(format!("q[{i}]"), state.q[i]))
            .or_else(|| (0..N).find_map(|i| named(format!("p[{i}]"), state.p[i])))
    }

    /// Steps every living path until it has made so many steps.
    pub(super) fn advance(&mut self, until: u64) {
        while self.step < until && self.tiles.iter().any(|tile| tile.alive != 0) {
            let stretch = self.step / STRETCH;
            let end = until.min((stretch + 1) * STRETCH);
            self.increments.load(stretch, self.tiles.len());
            while self.step < end {
                self.step = dispatch(Stretch {
                    method: self.run.ensemble.method,
                    prepared: &self.prepared,
                    h: self.run.h,
                    start_time: self.run.start_time,
                    increments: &self.increments,
                    tiles: &mut self.tiles,
                    step: self.step,
                    end,
                });
                for tile in 0..self.tiles.len() {
                    self.step_singly(tile);
                }
            }
        }
        self.step = until;
    }

    /// Makes the last step in those lanes that the lane step left.
    fn step_singly(&mut self, tile: usize) {
        let left = core::mem::take(&mut self.tiles[tile].left);
        let step = self.step - 1;
        for lane in lanes(left & self.tiles[tile].alive) {
            let increments = self.increments.of(tile, step);
            let mut state = S::Dims::get(self.tiles[tile].states(), lane);
            state.t = self.run.time(step);
            let dw = increments.0.map(|process| process[lane]);
            let method = self.run.ensemble.method;
            match method.step_prepared(&self.prepared, &mut state, self.run.h, &dw) {
                Ok(()) => {
                    state.t = self.run.time(step + 1);
                    S::Dims::set(self.tiles[tile].states_mut(), lane, &state);
                }
                Err(error) => self.fail(tile, lane, step, Cause::Step(error)),
            }
        }
    }

    /// Takes a path out after so many steps.
    #[cold]
    pub(super) fn fail(&mut self, tile: usize, lane: usize, step: u64, cause: Cause) {
        self.tiles[tile].alive &= !(1 << lane);
        self.failures.push(Failure {
            path: self.first_path + (tile * LANES + lane) as u64,
            step,
            t: self.run.time(step),
            cause,
        });
        if self.run.ensemble.stop_on_failure {
            // paths after this one can no more be the first that fails
            self.tiles[tile].alive &= (1 << lane) - 1;
            for later in &mut self.tiles[tile + 1..] {
                later.alive = 0;
            }
        }
        self.replace(tile, lane);
    }

    /// Lets a lane without a path go the way of one that has: no step may have to look for a solution that is not there.
    fn replace(&mut self, tile: usize, lane: usize) {
        let tile = &mut self.tiles[tile];
        if tile.alive != 0 {
            let other = tile.states().get(tile.alive.trailing_zeros() as usize);
            tile.states_mut().set(lane, &other);
        }
    }
}

/// The lanes of a set.
pub(super) fn lanes(set: Mask) -> impl Iterator<Item = usize> {
    (0..LANES).filter(move |lane| set >> lane & 1 == 1)
}

/// Steps of all tiles, until one leaves a living lane; the number of steps then made.
///
/// The tiles take turns, since the operations of one step wait for one another.
struct Stretch<'f, I: Method, const N: usize, const M: usize> {
    method: &'f I,
    prepared: &'f I::Prepared,
    h: f64,
    start_time: f64,
    increments: &'f Increments<M>,
    tiles: &'f mut [Tile<N>],
    step: u64,
    end: u64,
}

impl<I, S, Q, const N: usize, const M: usize> Kernel for Stretch<'_, I, N, M>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let mut step = self.step;
        let mut left = 0;
        while step < self.end && left == 0 {
            let t = time_after(self.start_time, step + 1, self.h);
            for (number, tile) in self.tiles.iter_mut().enumerate() {
                if tile.alive == 0 {
                    continue;
                }
                let dw = self.increments.of(number, step);
                let (before, next) = tile.turn();
                let left_here = self
                    .method
                    .step_lanes(self.prepared, before, next, self.h, &dw.0);
                next.t = [t; LANES];
                tile.left = left_here & tile.alive;
                left |= tile.left;
            }
            step += 1;
        }
        step
    }
}
