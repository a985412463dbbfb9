//! Memories of numbers: observables that remember a number of each path, made from the values of a
//! function after all steps.
//!
//! Input: the values of a function at both ends of each step. Output: a number for each lane.

use super::observe::{Closure, Function, not_finite};
use super::observer::{Kind, LastStep, Observable, Observer, Seen};
use super::tile::Place;
use crate::lanes::{LANES, Lane, Mask};
use crate::system::System;

/// The method by which a number is made from the values of a function along a path.
pub(super) trait Accumulate: Copy + Send + Sync {
    /// The kind of the observable.
    const KIND: Kind;

    /// Sets the step at which averages begin.
    #[must_use]
    fn settled(self, from: u64) -> Self {
        let _ = from;
        self
    }

    /// Returns the number at the start of a path.
    fn begin(self, now: f64) -> f64 {
        let _ = now;
        0.0
    }

    /// Returns the number after the last step of a path, with the values of the function before and
    /// after it.
    fn after(self, number: f64, ends: [f64; 2], step: &LastStep, lane: usize) -> f64;

    /// Returns the recorded number of a path after its last step, from this number and value of the
    /// function.
    fn read(self, number: f64, now: f64, step: &LastStep, lane: usize) -> f64 {
        let _ = (now, step, lane);
        number
    }
}

/// A function with a memory of numbers.
pub(super) struct Accumulated<F, A> {
    function: F,
    memory: A,
}

impl<F, O, A> Accumulated<Closure<F, O>, A> {
    pub(super) fn new(function: F, memory: A) -> Self {
        let function = Closure::new(function);
        Self { function, memory }
    }
}

impl<S: System, F: Function<S>, A: Accumulate> Observable<S> for Accumulated<F, A> {
    fn kind(&self) -> Kind {
        A::KIND
    }

    fn function(&self) -> &dyn Function<S> {
        &self.function
    }

    fn observer(&self, tiles: usize, settled: u64) -> Box<dyn Observer<S> + '_> {
        let empty = Numbers {
            value: [0.0; LANES],
            last: [0.0; LANES],
        };
        Box::new(NumberMemory {
            function: &self.function,
            memory: self.memory.settled(settled),
            tiles: vec![empty; tiles],
        })
    }
}

/// The numbers of a tile.
#[derive(Clone, Copy)]
struct Numbers {
    value: Lane,
    /// The function after the last step.
    last: Lane,
}

/// The numbers of some tiles.
struct NumberMemory<'o, F, A> {
    function: &'o F,
    memory: A,
    tiles: Vec<Numbers>,
}

impl<S: System, F: Function<S>, A: Accumulate> Observer<S> for NumberMemory<'_, F, A> {
    fn update(&mut self, seen: &Seen<'_, S>) -> Mask {
        let Numbers { value, last } = &mut self.tiles[seen.tile];
        let mut now = [0.0; LANES];
        self.function.tile(seen.systems, seen.states, &mut now);
        if seen.systems.hold_inputs() && seen.step.number > 0 {
            // the inputs have changed after the last step but one
            self.function.tile(seen.systems, seen.before, last);
        }
        if seen.step.number == 0 {
            *value = now.map(|now| self.memory.begin(now));
        } else {
            for lane in 0..LANES {
                let ends = [last[lane], now[lane]];
                value[lane] = self.memory.after(value[lane], ends, seen.step, lane);
            }
        }
        *last = now;
        not_finite(&now)
    }

    fn values(&self, seen: &Seen<'_, S>, values: &mut Lane) {
        let Numbers { value, last } = &self.tiles[seen.tile];
        for lane in 0..LANES {
            values[lane] = self.memory.read(value[lane], last[lane], seen.step, lane);
        }
    }

    fn move_lane(&mut self, from: Place, to: Place) {
        let Numbers { value, last } = self.tiles[from.tile];
        self.tiles[to.tile].value[to.lane] = value[from.lane];
        self.tiles[to.tile].last[to.lane] = last[from.lane];
    }
}
