//! A block of paths, stepped a tile of lanes at a time.
//!
//! Input: the settings of the ensemble and the number of a block. Output: the states of its paths at any step, and their failures.
//! Invariant: the states of a path depend on its number only. Lanes are independent, and a lane that the lane step does not solve
//! takes the scalar step whatever its neighbours do. The time after step `k` is `t₀ + k h`, rounded once.

use super::failure::{Cause, Failure};
use super::increment_buffer::{BATCH, IncrementBuffer};
use super::integral::Integral;
use super::settings::Settings;
use super::{BLOCK_PATHS, BLOCK_TILES, EnsembleError, path_at};
use crate::configuration::{Configuration, Coordinates};
use crate::error::StepError;
use crate::lanes::dispatch::{Kernel, dispatch};
use crate::lanes::{ALL, LANES, Lane, Mask};
use crate::method::Method;
use crate::state::State;
use crate::system::{Dimensions, Dims, StateLanesOf, System};
use crate::time::time_after;

/// A block of paths.
pub(super) struct PathBlock<'a, I: Method, const N: usize, const M: usize> {
    pub(super) settings: Settings<'a, I>,
    prepared: I::Prepared,
    increments: IncrementBuffer<M>,
    pub(super) first_path: u64,
    /// Steps made.
    pub(super) step: u64,
    pub(super) tiles: Vec<Tile<StateLanesOf<I::System>>>,
    pub(super) failures: Vec<Failure>,
    /// The integrals along the paths, by integrand and tile.
    pub(super) integrals: Vec<Integral>,
    /// The observables of each tile, and the lanes in which they are valid, at the last recorded time.
    pub(super) observed: Vec<Observed>,
    /// The observables at all recorded times so far, if covariances of two times are taken.
    pub(super) history: Vec<Vec<Observed>>,
}

/// The observables of a tile.
#[derive(Clone)]
pub(super) struct Observed {
    /// The values of each observable.
    pub(super) values: Vec<Lane>,
    /// The lanes of the paths that have not failed.
    pub(super) lanes: Mask,
}

/// The states of some paths in lanes. A lane is active if its path exists and has not failed; the other lanes copy an active one.
pub(super) struct Tile<L> {
    /// The current states, and the work space for the states after a step.
    buffers: [L; 2],
    /// Which buffer has the current states.
    current: bool,
    /// The active lanes.
    pub(super) active: Mask,
    /// Active lanes that the last step in lanes did not solve.
    unsolved: Mask,
}

impl<L> Tile<L> {
    /// The states reached so far.
    pub(super) fn states(&self) -> &L {
        &self.buffers[usize::from(self.current)]
    }

    fn states_mut(&mut self) -> &mut L {
        &mut self.buffers[usize::from(self.current)]
    }

    /// Swaps the buffers. Returns the states before a step, and the work space for the states after it, which become the current ones.
    #[inline(always)]
    fn swap_buffers(&mut self) -> (&L, &mut L) {
        self.current = !self.current;
        let [first, second] = &mut self.buffers;
        if self.current {
            (first, second)
        } else {
            (second, first)
        }
    }
}

impl<'a, I, S, Q, const N: usize, const M: usize> PathBlock<'a, I, N, M>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Starts the paths of a block, or only one of them.
    pub(super) fn new(
        settings: Settings<'a, I>,
        block: u64,
        only: Option<u64>,
    ) -> Result<Self, EnsembleError> {
        let first_path = block * BLOCK_PATHS;
        let mut block_of_paths = Self {
            settings,
            prepared: settings
                .method
                .prepare(settings.h)
                .map_err(EnsembleError::Prepare)?,
            increments: settings.increments(first_path),
            first_path,
            step: 0,
            tiles: Vec::with_capacity(BLOCK_TILES),
            failures: Vec::new(),
            integrals: Vec::new(),
            observed: Vec::new(),
            history: Vec::new(),
        };
        let paths = first_path..path_at(block + 1, settings.paths);
        // The last block may end at the largest number.
        let tiles = (paths.end - first_path).div_ceil(LANES as u64);
        for first in (0..tiles).map(|tile| first_path + tile * LANES as u64) {
            let is_wanted = |path| paths.contains(&path) && only.is_none_or(|only| only == path);
            block_of_paths.start_tile(first, is_wanted);
        }
        let nothing = Observed {
            values: vec![[0.0; LANES]; settings.ensemble.names.len()],
            lanes: 0,
        };
        block_of_paths.observed = vec![nothing; block_of_paths.tiles.len()];
        let integrals = settings.ensemble.integrands().count() * block_of_paths.tiles.len();
        block_of_paths.integrals = vec![Integral::ZERO; integrals];
        block_of_paths.integrate();
        Ok(block_of_paths)
    }

    fn start_tile(&mut self, first: u64, is_wanted: impl Fn(u64) -> bool) {
        let starts: [State<Q>; LANES] = core::array::from_fn(|lane| {
            let path = first.wrapping_add(lane as u64);
            if is_wanted(path) {
                self.settings.start_of(path)
            } else {
                State::new(Q::origin(), Q::no_momentum())
            }
        });
        let mut states = S::Dims::splat(&starts[0]);
        let mut active = 0;
        for lane in 0..LANES {
            S::Dims::set(&mut states, lane, &starts[lane]);
            active |= Mask::from(is_wanted(first.wrapping_add(lane as u64))) << lane;
        }
        let tile = self.tiles.len();
        self.tiles.push(Tile {
            buffers: [states, states],
            current: false,
            active,
            unsolved: 0,
        });
        for lane in lanes(active) {
            if let Some(cause) = self.start_error(&starts[lane]) {
                self.fail(tile, lane, 0, cause);
            }
        }
        for lane in lanes(ALL & !self.tiles[tile].active) {
            self.fill_unused_lane(tile, lane);
        }
    }

    /// Returns why a path cannot start at a state; `None` if it can.
    fn start_error(&self, state: &State<Q>) -> Option<Cause> {
        let not_finite = |what: String, value: f64| {
            let t = state.t;
            (!value.is_finite()).then_some(Cause::Step(StepError::NonFiniteInput {
                what,
                value,
                t,
            }))
        };
        if state.t != self.settings.start_time {
            let (t, expected) = (state.t, self.settings.start_time);
            return Some(Cause::StartTime { t, expected });
        }
        let (mut q, mut p) = (vec![0.0; Q::STORED_VALUES], [0.0; N]);
        state.q.store(&mut q);
        state.p.store(&mut p);
        let mut q = q.into_iter().enumerate();
        let mut p = p.into_iter().enumerate();
        q.find_map(|(i, q)| not_finite(format!("q[{i}]"), q))
            .or_else(|| p.find_map(|(i, p)| not_finite(format!("p[{i}]"), p)))
    }

    /// Steps every active path until it has made so many steps, and integrates along it.
    pub(super) fn advance(&mut self, until: u64) {
        if self.integrals.is_empty() {
            return self.advance_states(until);
        }
        while self.step < until {
            self.advance_states(self.step + 1);
            self.integrate();
        }
    }

    /// Steps every active path until it has made so many steps.
    fn advance_states(&mut self, until: u64) {
        while self.step < until && self.tiles.iter().any(|tile| tile.active != 0) {
            let batch = self.step / BATCH;
            let end = until.min((batch + 1) * BATCH);
            self.increments.load(batch, self.tiles.len());
            while self.step < end {
                self.step = dispatch(AdvanceTiles {
                    method: self.settings.method,
                    prepared: &self.prepared,
                    h: self.settings.h,
                    start_time: self.settings.start_time,
                    increments: &self.increments,
                    tiles: &mut self.tiles,
                    step: self.step,
                    end,
                });
                for tile in 0..self.tiles.len() {
                    self.step_unsolved_lanes(tile);
                }
            }
        }
        self.step = until;
    }

    /// Repeats the last step with the scalar step, in the lanes that the lane step did not solve.
    fn step_unsolved_lanes(&mut self, tile: usize) {
        let unsolved = core::mem::take(&mut self.tiles[tile].unsolved);
        let step = self.step - 1;
        for lane in lanes(unsolved & self.tiles[tile].active) {
            let increments = self.increments.of(tile, step);
            let mut state = S::Dims::get(self.tiles[tile].states(), lane);
            state.t = self.settings.time(step);
            let dw = increments.0.map(|process| process[lane]);
            let method = self.settings.method;
            match method.step_prepared(&self.prepared, &mut state, self.settings.h, &dw) {
                Ok(()) => {
                    state.t = self.settings.time(step + 1);
                    S::Dims::set(self.tiles[tile].states_mut(), lane, &state);
                }
                Err(error) => self.fail(tile, lane, step, Cause::Step(error)),
            }
        }
    }

    /// Records the failure of a path after so many steps, and deactivates its lane.
    #[cold]
    pub(super) fn fail(&mut self, tile: usize, lane: usize, step: u64, cause: Cause) {
        self.tiles[tile].active &= !(1 << lane);
        self.failures.push(Failure {
            path: self.first_path + (tile * LANES + lane) as u64,
            step,
            t: self.settings.time(step),
            cause,
        });
        if self.settings.ensemble.stop_on_failure {
            // Later paths cannot be the first one that fails.
            self.tiles[tile].active &= (1 << lane) - 1;
            for later in &mut self.tiles[tile + 1..] {
                later.active = 0;
            }
        }
        self.fill_unused_lane(tile, lane);
    }

    /// Fills an unused lane with a copy of an active one, so that the step in it is solvable and takes the fast path.
    fn fill_unused_lane(&mut self, tile: usize, lane: usize) {
        let tile = &mut self.tiles[tile];
        if tile.active != 0 {
            let other = S::Dims::get(tile.states(), tile.active.trailing_zeros() as usize);
            S::Dims::set(tile.states_mut(), lane, &other);
        }
    }
}

/// Returns the lanes of a set.
pub(super) fn lanes(set: Mask) -> impl Iterator<Item = usize> {
    (0..LANES).filter(move |lane| set >> lane & 1 == 1)
}

/// Steps all tiles until a step does not solve an active lane. Returns the number of steps then made.
///
/// The tiles alternate: the operations of one step depend on one another, and those of two tiles do not.
struct AdvanceTiles<'f, I: Method, const N: usize, const M: usize> {
    method: &'f I,
    prepared: &'f I::Prepared,
    h: f64,
    start_time: f64,
    increments: &'f IncrementBuffer<M>,
    tiles: &'f mut [Tile<StateLanesOf<I::System>>],
    step: u64,
    end: u64,
}

impl<I, S, Q, const N: usize, const M: usize> Kernel for AdvanceTiles<'_, I, N, M>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
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
                let dw = self.increments.of(number, step);
                let (before, next) = tile.swap_buffers();
                let unsolved_here =
                    self.method
                        .step_lanes(self.prepared, before, next, self.h, &dw.0);
                *S::Dims::times(next) = [t; LANES];
                tile.unsolved = unsolved_here & tile.active;
                unsolved |= tile.unsolved;
            }
            step += 1;
        }
        step
    }
}
