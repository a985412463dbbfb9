//! Observers: the numbers that an ensemble makes of its functions along each path.
//!
//! Input: the states of a tile after each step, or at recorded times only. Output: at a recorded
//! time a number for each lane. Invariant: the number of a path depends on its states only, not on
//! its lane, block or thread. A kind of observable is one file, which implements [`Observable`] and
//! [`Observer`], or [`Accumulate`](super::memory::Accumulate) if it remembers numbers.

use super::Ensemble;
use super::failure::Cause;
use super::observe::Function;
use super::path_block::PathBlock;
use super::systems::Systems;
use super::tangents::Tangents;
use super::tile::{Place, lanes};
use crate::ensemble::PathMethod;
use crate::error::StepError;
use crate::lanes::{LANES, Lane, Mask};
use crate::method::DimsOf;
use crate::system::{Dimensions, StateLanesOf, System};

/// The name of the weight in messages.
const WEIGHT: &str = "weight";

/// The uses of the values of a function along a path. Their numbers are part of the fingerprints of
/// shards and checkpoints, so they must not change.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Plain = 0,
    Weighted = 1,
    Average = 2,
    Integral = 3,
    Maximum = 4,
    Crossings = 5,
    Fold = 6,
    Gradient = 7,
}

/// A function, and the treatment of its values along a path.
pub(super) trait Observable<S: System>: Sync {
    /// Returns the kind of the observable.
    fn kind(&self) -> Kind;

    /// The function.
    fn function(&self) -> &dyn Function<S>;

    /// Returns whether the observer has a memory that values of the function do not show, so that a
    /// fingerprint has to sample it.
    fn has_hidden_memory(&self) -> bool {
        false
    }

    /// Returns an observer of so many tiles before their start. Averages begin after `settled`
    /// steps.
    fn observer(&self, tiles: usize, settled: u64) -> Box<dyn Observer<S> + '_>;
}

/// An observer of the paths of some tiles.
pub(super) trait Observer<S: System>: Send {
    /// Returns whether the observer needs the states after all steps, not those at recorded times
    /// alone.
    fn sees_steps(&self) -> bool {
        true
    }

    /// Takes in the states after a step, or at the start. Returns the lanes in which the observed
    /// function is not finite.
    fn update(&mut self, seen: &Seen<'_, S>) -> Mask {
        let _ = seen;
        0
    }

    /// Writes the recorded numbers after a step.
    fn values(&self, seen: &Seen<'_, S>, values: &mut Lane);

    /// Moves the data of a path to another lane.
    fn move_lane(&mut self, from: Place, to: Place) {
        let _ = (from, to);
    }
}

/// A tile after a step, as an observer sees it.
pub(super) struct Seen<'t, S: System> {
    pub(super) systems: &'t Systems<'t, S>,
    pub(super) tile: usize,
    pub(super) states: &'t StateLanesOf<S>,
    /// The states before the last step.
    pub(super) before: &'t StateLanesOf<S>,
    pub(super) active: Mask,
    pub(super) step: &'t LastStep,
    /// The exponent ∫V dt of the weight in each lane, if there is a weight.
    pub(super) exponents: Option<Lane>,
    /// The tangent vectors, if there are gradients.
    pub(super) tangents: Option<&'t Tangents<S::Dims>>,
}

impl<'t, S: System> Seen<'t, S> {
    /// A tile with these states before and after a step and these active lanes, without weight and
    /// tangent vectors.
    pub(super) fn new(
        systems: &'t Systems<'t, S>,
        tile: usize,
        [before, states]: [&'t StateLanesOf<S>; 2],
        active: Mask,
        step: &'t LastStep,
    ) -> Self {
        Self {
            systems,
            tile,
            states,
            before,
            active,
            step,
            exponents: None,
            tangents: None,
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

    /// Returns the time in a lane since step number `step`, which has been made.
    pub(super) fn time_since(&self, step: u64, lane: usize) -> f64 {
        let (length, steps) = (self.lengths[lane], self.number - step);
        if length == self.h {
            steps as f64 * self.h
        } else {
            (steps - 1) as f64 * self.h + length
        }
    }
}

/// A function whose value at the recorded time is recorded, times the weight of the path if there
/// is one.
pub(super) struct Plain<F> {
    pub(super) function: F,
    pub(super) is_weighted: bool,
}

impl<S: System, F: Function<S>> Observable<S> for Plain<F> {
    fn kind(&self) -> Kind {
        if self.is_weighted {
            Kind::Weighted
        } else {
            Kind::Plain
        }
    }

    fn function(&self) -> &dyn Function<S> {
        &self.function
    }

    fn observer(&self, _: usize, _: u64) -> Box<dyn Observer<S> + '_> {
        Box::new(self)
    }
}

impl<S: System, F: Function<S>> Observer<S> for &Plain<F> {
    fn sees_steps(&self) -> bool {
        false
    }

    fn values(&self, seen: &Seen<'_, S>, values: &mut Lane) {
        self.function.tile(seen.systems, seen.states, values);
        if let Some(exponents) = seen.exponents.filter(|_| self.is_weighted) {
            for (value, exponent) in values.iter_mut().zip(exponents) {
                *value *= (-exponent).exp();
            }
        }
    }
}

impl<I: PathMethod, K> Ensemble<'_, I, K> {
    /// Returns the observed functions: the exponent of the weight if there is a weight, then the
    /// observables.
    fn observed(&self) -> impl Iterator<Item = (&str, &dyn Observable<I::System>)> {
        let observed = &self.observed;
        let weight = observed.weight.iter().map(|weight| (WEIGHT, &**weight));
        let all = observed.names.iter().zip(&observed.observables);
        weight.chain(all.map(|(name, observable)| (name.as_str(), &**observable)))
    }

    /// Returns the observers of so many tiles, in this order.
    pub(super) fn observers(
        &self,
        settled: u64,
        tiles: usize,
    ) -> Vec<Box<dyn Observer<I::System> + '_>> {
        let all = self.observed();
        all.map(|(_, of)| of.observer(tiles, settled)).collect()
    }
}

impl<I: PathMethod> PathBlock<'_, I> {
    /// Shows the last step of a tile, or the start, to all observers.
    pub(super) fn show(&mut self, tile: usize, step: &LastStep, systems: &Systems<'_, I::System>) {
        let ensemble = self.settings.ensemble;
        for number in 0..self.observers.len() {
            let of = &self.tiles[tile];
            if of.active == 0 {
                return;
            }
            let states = [of.states_before(), of.states()];
            let seen = Seen::new(systems, tile, states, of.active, step);
            let failed = self.observers[number].update(&seen) & seen.active;
            if failed != 0
                && let Some((name, of)) = ensemble.observed().nth(number)
            {
                self.fail_not_finite((tile, failed), step, name, of.function(), systems);
            }
        }
    }

    /// Lets the paths of some lanes fail, since a function is not finite in these lanes.
    #[cold]
    pub(super) fn fail_not_finite(
        &mut self,
        (tile, failed): (usize, Mask),
        step: &LastStep,
        name: &str,
        function: &dyn Function<I::System>,
        systems: &Systems<'_, I::System>,
    ) {
        for lane in lanes(failed) {
            let state = DimsOf::<I>::get(self.tiles[tile].states(), lane);
            let value = function.value(systems.of(lane), &state);
            let cause = not_finite_cause(name, value);
            self.fail_at(state.t, tile, lane, step.number, cause);
        }
    }

    /// Evaluates the observables of a tile after a step.
    pub(super) fn evaluate(
        &self,
        tile: usize,
        step: &LastStep,
        systems: &Systems<'_, I::System>,
        values: &mut [Lane],
    ) {
        let of = &self.tiles[tile];
        let states = [of.states_before(), of.states()];
        let mut seen = Seen::new(systems, tile, states, of.active, step);
        seen.tangents = Some(&self.tangents);
        let mut observers = self.observers.iter();
        if self.settings.ensemble.observed.weight.is_some() {
            let mut exponents = [0.0; LANES];
            (observers.next()).inspect(|weight| weight.values(&seen, &mut exponents));
            seen.exponents = Some(exponents);
        }
        for (observer, values) in observers.zip(values) {
            observer.values(&seen, values);
        }
    }
}

/// Returns why a path fails on which a function is not finite.
pub(super) fn not_finite_cause(name: &str, value: Result<f64, StepError>) -> Cause {
    let name = name.to_owned();
    match value {
        Ok(value) => Cause::NotFinite { name, value },
        Err(error) => Cause::Observable { name, error },
    }
}
