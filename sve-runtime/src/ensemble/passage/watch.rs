//! The watch for passages: the signs of functions after each step, in the lanes of the tiles.
//!
//! Input: the tiles after a step. Output: the passages within the step, and the lanes that stop.
//! Invariant: a function counts once for each path.

use super::counts::{End, Passage};
use super::search::{Crossing, Zero};
use crate::ensemble::PathMethod;
use crate::error::StepError;
use crate::lanes::{LANES, Lane, Mask};
use crate::method::DimsOf;
use crate::method::Within;
use crate::system::{Dimensions, Increments as _, StateOf};

use super::super::Ensemble;
use super::super::crossings::crosses;
use super::super::failure::Cause;
use super::super::observe::not_finite;
use super::super::observer::LastStep;
use super::super::path_block::PathBlock;
use super::super::systems::Systems;
use super::super::tile::{Place, lanes};

/// The last values of each function in the tiles of a block, and the passages found.
pub(in super::super) struct PassageWatch {
    functions: Vec<Watched>,
    pub(in super::super) passages: Vec<Passage>,
}

/// The values of a function in the tiles of a block.
struct Watched {
    /// The values after the last step but one.
    before: Vec<Lane>,
    /// After the last step.
    now: Vec<Lane>,
    /// Lanes whose paths have passed.
    passed: Vec<Mask>,
}

/// A zero of a function, with its number.
type Found<S> = (usize, Zero<StateOf<S>>);

impl PassageWatch {
    /// Returns the watch over so many tiles before their start.
    pub(in super::super) fn new<I: PathMethod>(ensemble: &Ensemble<'_, I>, tiles: usize) -> Self {
        let functions = ensemble.observed.passages.iter().map(|_| Watched {
            before: vec![[0.0; LANES]; tiles],
            now: vec![[0.0; LANES]; tiles],
            passed: vec![0; tiles],
        });
        Self {
            functions: functions.collect(),
            passages: Vec::new(),
        }
    }

    pub(in super::super) fn is_empty(&self) -> bool {
        self.functions.is_empty()
    }

    /// Moves the data of a path to another lane.
    pub(in super::super) fn move_lane(&mut self, from: Place, to: Place) {
        for Watched {
            before,
            now,
            passed,
        } in &mut self.functions
        {
            before[to.tile][to.lane] = before[from.tile][from.lane];
            now[to.tile][to.lane] = now[from.tile][from.lane];
            let has_passed = passed[from.tile] >> from.lane & 1;
            passed[to.tile] = passed[to.tile] & !(1 << to.lane) | has_passed << to.lane;
        }
    }
}

impl<I: PathMethod> PathBlock<'_, I> {
    /// Records the passages of the paths of a tile within their last step. Returns the lanes that
    /// stop. Their states are then the states at the zeros, and `last` has the lengths of their
    /// last steps.
    pub(in super::super) fn find_passages(
        &mut self,
        tile: usize,
        last: &mut LastStep,
        systems: &Systems<'_, I::System>,
    ) -> Mask {
        let ensemble = self.settings.ensemble;
        let mut crossed = 0;
        for (number, passage) in ensemble.observed.passages.iter().enumerate() {
            let watched = &mut self.watch.functions[number];
            watched.before[tile] = watched.now[tile];
            let (now, of) = (&mut watched.now[tile], &self.tiles[tile]);
            passage.function.tile(systems, of.states(), now);
            if systems.hold_inputs() && last.number > 0 {
                // the inputs have changed after the last step but one
                let before = &mut watched.before[tile];
                passage.function.tile(systems, of.states_before(), before);
            }
            let failed = not_finite(now) & self.tiles[tile].active;
            if last.number > 0 {
                crossed |= crossings(&watched.before[tile], now) & !watched.passed[tile];
            }
            if failed != 0 {
                let function = &*passage.function;
                self.fail_not_finite((tile, failed), last, &passage.name, function, systems);
            }
        }
        let mut stopped = 0;
        for lane in lanes(crossed & self.tiles[tile].active) {
            match self.zeros(tile, lane) {
                Ok(zeros) => {
                    if let Some(fraction) = self.pass(Place { tile, lane }, zeros, last.number) {
                        last.lengths[lane] = fraction * self.settings.h;
                        stopped |= 1 << lane;
                    }
                }
                Err(error) => self.fail(tile, lane, last.number - 1, Cause::Step(error)),
            }
        }
        stopped
    }

    /// Returns the first zeros of the functions that change their sign in the last step of a path
    /// and have not done so before, with the numbers of the functions, in the order of time.
    #[cold]
    fn zeros(&mut self, tile: usize, lane: usize) -> Result<Vec<Found<I::System>>, StepError> {
        let settings = self.settings;
        let path = self.tiles[tile].paths[lane];
        let Some(noise) = settings.noise.within_steps(path) else {
            return Ok(Vec::new());
        };
        let step = self.step - 1;
        let before = DimsOf::<I>::get(self.tiles[tile].states_before(), lane);
        (settings.method).hold(&mut self.prepared, path, step, &before)?;
        let crossing = Crossing {
            method: Within {
                method: settings.method,
                step: Some(&self.prepared),
            },
            noise: &*noise,
            step,
            h: settings.h,
            before,
            whole: I::Increments::of_lane(&self.increments_of(tile, step).0, lane),
            depth: settings.ensemble.refine,
        };
        let mut zeros = Vec::new();
        for (number, watched) in self.watch.functions.iter().enumerate() {
            let values = [watched.before[tile][lane], watched.now[tile][lane]];
            if watched.passed[tile] >> lane & 1 == 0 && crosses(values[0], values[1]) {
                let function = &settings.ensemble.observed.passages[number].function;
                zeros.push((number, crossing.first_zero(number, &**function, values)?));
            }
        }
        zeros.sort_by(|(_, a), (_, b)| a.fraction.total_cmp(&b.fraction));
        Ok(zeros)
    }

    /// Records the passages of a path within its last step, until the first passage that stops it.
    /// Returns the part of the step that the path has then made.
    fn pass(
        &mut self,
        Place { tile, lane }: Place,
        zeros: Vec<Found<I::System>>,
        step: u64,
    ) -> Option<f64> {
        let path = self.tiles[tile].paths[lane];
        for (function, Zero { fraction, state }) in zeros {
            let stops = self.settings.ensemble.observed.passages[function].stops;
            let t = state.t;
            self.watch.passages.push(Passage {
                end: End { path, step, t },
                function,
                stops,
            });
            self.watch.functions[function].passed[tile] |= 1 << lane;
            if stops {
                DimsOf::<I>::set(self.tiles[tile].states_mut(), lane, &state);
                return Some(fraction);
            }
        }
        None
    }
}

/// Returns the lanes in which a function changes its sign.
fn crossings(before: &Lane, now: &Lane) -> Mask {
    let mut mask = 0;
    for lane in 0..LANES {
        mask |= Mask::from(crosses(before[lane], now[lane])) << lane;
    }
    mask
}
