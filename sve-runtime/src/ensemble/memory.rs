//! Memories of observers: what is remembered of each path beside its state.
//!
//! Input: the states of a tile after each step. Output: at a recorded time a number for each lane. Invariant: the memory of a path depends on its
//! states only, not on its lane, block or thread.

use super::Ensemble;
use super::failure::Cause;
use super::observe::{Observable, not_finite};
use super::path_block::PathBlock;
use super::tile::{Place, lanes};
use crate::lanes::{LANES, Lane, Mask};
use crate::phase::configuration::Coordinates;
use crate::system::{Dimensions, Dims, StateLanesOf, System};
use crate::trajectory::Method;

/// The name of the weight in messages.
const WEIGHT: &str = "weight";

/// What becomes of an observable at a recorded time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Its value.
    Value,
    /// Its value times the weight of the path.
    Weighted,
    /// Its average over time.
    Average,
    /// Its integral over time.
    Integral,
    /// Its greatest value so far.
    Maximum,
    /// The number of its changes of sign.
    Crossings,
    /// The value of a memory of any type.
    Fold,
    /// A derivative: the numbers of the function and of the quantity.
    Slope(usize, usize),
}

impl Kind {
    /// Returns whether the observable needs the states after all steps.
    fn has_memory(self) -> bool {
        !matches!(self, Self::Value | Self::Weighted | Self::Slope(..))
    }

    /// Returns the number by which a fingerprint knows the kind.
    pub(super) fn number(self) -> u64 {
        match self {
            Self::Value => 0,
            Self::Weighted => 1,
            Self::Average => 2,
            Self::Integral => 3,
            Self::Maximum => 4,
            Self::Crossings => 5,
            Self::Fold => 6,
            Self::Slope(..) => 7,
        }
    }
}

/// The last step of the paths in a tile.
pub(super) struct LastStep {
    /// Number of steps with this one; 0 at the start.
    pub(super) number: u64,
    h: f64,
    /// Its length in each lane: h, or the part of h after which a path was stopped.
    pub(super) lengths: Lane,
}

impl LastStep {
    /// A step of length `h` in all lanes.
    pub(super) fn whole(number: u64, h: f64) -> Self {
        let lengths = [h; LANES];
        Self { number, h, lengths }
    }

    /// Returns the time in a lane since so many steps, which are fewer than have been made.
    fn time_since(&self, step: u64, lane: usize) -> f64 {
        let (length, steps) = (self.lengths[lane], self.number - step);
        if length == self.h {
            steps as f64 * self.h
        } else {
            (steps - 1) as f64 * self.h + length
        }
    }
}

/// The memory of an observer, for the tiles of a block.
pub(super) trait PathMemory<S: System>: Send {
    /// Takes in the states after a step, or at the start. Returns the lanes in which the observed function is not finite.
    fn update(
        &mut self,
        tile: usize,
        system: &S,
        states: &StateLanesOf<S>,
        step: &LastStep,
    ) -> Mask;
    /// Returns what is observed after a step.
    fn values(&self, tile: usize, step: &LastStep) -> Lane;
    /// Moves the memory of a path to another lane.
    fn move_lane(&mut self, from: Place, to: Place);
}

/// An observer and its memory.
pub(super) struct Remembered<'a, S: System> {
    name: &'a str,
    function: &'a dyn Observable<S>,
    pub(super) memory: Box<dyn PathMemory<S> + 'a>,
}

/// The memory of an observer of one number, in the lanes of a tile.
#[derive(Clone, Copy)]
struct Numbers {
    value: Lane,
    /// The function after the last step.
    last: Lane,
}

/// The memory of an observer of one number.
struct NumberMemory<'a, S: System> {
    function: &'a dyn Observable<S>,
    kind: Kind,
    /// The step at which an integral begins.
    from: u64,
    tiles: Vec<Numbers>,
}

impl<S: System> PathMemory<S> for NumberMemory<'_, S> {
    fn update(
        &mut self,
        tile: usize,
        system: &S,
        states: &StateLanesOf<S>,
        step: &LastStep,
    ) -> Mask {
        let Numbers { value, last } = &mut self.tiles[tile];
        let mut now = [0.0; LANES];
        self.function.tile(system, states, &mut now);
        match self.kind {
            Kind::Maximum if step.number == 0 => *value = now,
            Kind::Maximum => {
                for lane in 0..LANES {
                    value[lane] = value[lane].max(now[lane]);
                }
            }
            Kind::Crossings if step.number == 0 => {}
            Kind::Crossings => {
                for lane in 0..LANES {
                    value[lane] += f64::from(u8::from(crosses(last[lane], now[lane])));
                }
            }
            _ if step.number <= self.from => {}
            _ => {
                for lane in 0..LANES {
                    value[lane] += 0.5 * step.lengths[lane] * (last[lane] + now[lane]);
                }
            }
        }
        *last = now;
        not_finite(&now)
    }

    fn values(&self, tile: usize, step: &LastStep) -> Lane {
        let Numbers { value, last } = &self.tiles[tile];
        match self.kind {
            Kind::Average if step.number <= self.from => *last,
            Kind::Average => {
                core::array::from_fn(|lane| value[lane] / step.time_since(self.from, lane))
            }
            _ => *value,
        }
    }

    fn move_lane(&mut self, from: Place, to: Place) {
        let Numbers { value, last } = self.tiles[from.tile];
        self.tiles[to.tile].value[to.lane] = value[from.lane];
        self.tiles[to.tile].last[to.lane] = last[from.lane];
    }
}

/// Returns whether a function changes its sign from one value to the next. Arriving at 0 is a change, leaving from there is none.
#[inline(always)]
pub(super) fn crosses(last: f64, now: f64) -> bool {
    let (rises, falls) = (last < 0.0 && now >= 0.0, last > 0.0 && now <= 0.0);
    rises || falls
}

impl<I: Method> Ensemble<'_, I> {
    /// Returns the observers with empty memories for so many tiles: the exponent of the weight if there is one, then the observables.
    ///
    /// Averages begin after `settled` steps.
    pub(super) fn memories(&self, settled: u64, tiles: usize) -> Vec<Remembered<'_, I::System>> {
        let empty = Numbers {
            value: [0.0; LANES],
            last: [0.0; LANES],
        };
        let of = |name, function, kind, from| Remembered {
            name,
            function,
            memory: Box::new(NumberMemory {
                function,
                kind,
                from,
                tiles: vec![empty; tiles],
            }),
        };
        let weight = self.weight.iter();
        let weight = weight.map(|function| of(WEIGHT, &**function, Kind::Integral, 0));
        let all = self.names.iter().zip(&self.observables).zip(&self.kinds);
        let with_memory = all.filter(|(_, kind)| kind.has_memory());
        let observers = with_memory.map(|((name, function), &kind)| {
            let from = if kind == Kind::Average { settled } else { 0 };
            let function = &**function;
            match function.memory(tiles) {
                Some(memory) => Remembered {
                    name,
                    function,
                    memory,
                },
                None => of(name, function, kind, from),
            }
        });
        weight.chain(observers).collect()
    }

    /// Returns the number of the memory of an observable that has one.
    fn memory_of(&self, observable: usize) -> usize {
        let before = &self.kinds[..observable];
        let others = before.iter().filter(|kind| kind.has_memory());
        usize::from(self.weight.is_some()) + others.count()
    }
}

impl<I, S, Q, const N: usize, const M: usize> PathBlock<'_, I, N, M>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Lets all observers of a tile take in its last step, or the start.
    pub(super) fn remember(&mut self, tile: usize, step: &LastStep) {
        let system = self.settings.method.system();
        for number in 0..self.memories.len() {
            let active = self.tiles[tile].active;
            if active == 0 {
                return;
            }
            let Remembered {
                name,
                function,
                memory,
            } = &mut self.memories[number];
            let (name, function) = (*name, *function);
            let failed = active & memory.update(tile, system, self.tiles[tile].states(), step);
            for lane in lanes(failed) {
                let state = S::Dims::get(self.tiles[tile].states(), lane);
                let cause = not_finite_cause(name, function.value(system, &state));
                self.fail_at(state.t, tile, lane, step.number, cause);
            }
        }
    }

    /// Evaluates an observable in the lanes of a tile after a step: its value, or what its observer has remembered.
    pub(super) fn evaluate(
        &self,
        observable: usize,
        tile: usize,
        step: &LastStep,
        values: &mut Lane,
    ) {
        let ensemble = self.settings.ensemble;
        let kind = ensemble.kinds[observable];
        if kind.has_memory() {
            let memory = &self.memories[ensemble.memory_of(observable)].memory;
            *values = memory.values(tile, step);
            return;
        }
        if let Kind::Slope(function, direction) = kind {
            return self.slopes((function, direction), tile, values);
        }
        let (system, states) = (self.settings.method.system(), self.tiles[tile].states());
        ensemble.observables[observable].tile(system, states, values);
        if kind == Kind::Weighted && ensemble.weight.is_some() {
            let exponents = self.memories[0].memory.values(tile, step);
            for (value, exponent) in values.iter_mut().zip(exponents) {
                *value *= (-exponent).exp();
            }
        }
    }
}

/// Returns why a path fails on which a function is not finite.
pub(super) fn not_finite_cause(name: &str, value: Result<f64, crate::error::StepError>) -> Cause {
    let name = name.to_owned();
    match value {
        Ok(value) => Cause::NotFinite { name, value },
        Err(error) => Cause::Observable { name, error },
    }
}
