//! The search for events within a step.
//!
//! Input: a step that was made, and the values of the functions at its start. Output: the states at
//! their zeros, in order; after a change of the state, the rest of the step made anew. Invariant:
//! every function has its value and its side at the last point up to which the search has come.

use super::Events;
use super::function::{Action, Side};
use super::rest::{PROBE, Rest};
use super::root::zero_between;
use crate::error::StepError;
use crate::method::OneStepMethod;
use crate::noise::Halves;
use crate::phase::configuration::FixedSize;
use crate::phase::state::State;
use crate::system::{ConfigurationOf, Increments, IncrementsOf, StateOf, System as _};
use crate::trajectory::Method;

/// Least time between two changes that a function causes, in steps. Changes that follow one another
/// faster accumulate.
const LEAST_INTERVAL: f64 = 1.0 / (1_u64 << 12) as f64;

/// Difference of two fractions of a step below which two functions are zero at the same state.
const SAME: f64 = 1.0 / (1_u64 << 40) as f64;

/// Largest value at a zero, as a fraction of the change of the function within the step. The value
/// of a continuous function is far smaller.
const JUMP: f64 = 1.0 / 1024.0;

/// A zero of a function within a step.
struct Hit<T> {
    fraction: f64,
    /// The number of the function.
    number: usize,
    state: T,
}

/// The hits of a system.
type Hits<I> = Vec<Hit<StateOf<<I as OneStepMethod>::System>>>;

impl<I: Method, W: Halves> Events<'_, I, W> {
    /// Makes a step and collects its states. Returns whether a step was made.
    pub(super) fn advance(&mut self) -> Result<bool, StepError> {
        let before = *self.trajectory.state();
        let is_first = !self.has_begun;
        if is_first {
            self.has_begun = true;
            // a function may read what the step is given
            self.trajectory.hold()?;
            self.evaluate(&before)?;
            self.arrive();
        }
        let step = self.trajectory.step();
        let Some(after) = self.trajectory.next().transpose()? else {
            return Ok(false);
        };
        if I::System::INPUTS > 0 && !is_first {
            // the inputs have changed after the step before
            self.evaluate(&before)?;
            self.arrive();
        }
        let h = self.trajectory.h;
        let mut whole = IncrementsOf::<I::System>::NONE;
        // The increments are a function of the step, so they can be drawn again.
        let drawn = self.trajectory.noise.increments(step, h, whole.as_mut());
        drawn.map_err(|source| StepError::Noise {
            t: before.t,
            source,
        })?;
        let mut rest = Rest {
            step,
            is_first,
            h,
            times: [before.t, after.t],
            from: 0.0,
            state: before,
            whole,
            before: IncrementsOf::<I::System>::NONE,
        };
        while let Some(changed) = self.search(&rest)? {
            rest = changed;
        }
        if self.yields_steps && !self.has_ended {
            self.found.push_back((self.trajectory.state, None));
        }
        Ok(true)
    }

    /// Searches the rest of a step for events. After a change of the state, returns the part of the
    /// step that is left.
    fn search(&mut self, rest: &Rest<I::System>) -> Result<Option<Rest<I::System>>, StepError> {
        self.find_sides(rest)?;
        for sample in 1..=self.samples {
            let (fraction, state) = if sample == self.samples {
                (1.0, self.trajectory.state)
            } else {
                let part = f64::from(sample) / f64::from(self.samples);
                let fraction = part.mul_add(1.0 - rest.from, rest.from);
                (fraction, self.state_at(rest, fraction)?)
            };
            self.evaluate(&state)?;
            let hits = self.hits(rest, fraction, &state)?;
            for (at, hit) in hits.iter().enumerate() {
                match self.functions[hit.number].action {
                    Action::Yield => self.found.push_back((hit.state, Some(hit.number))),
                    Action::Stop => {
                        self.stop(hit);
                        return Ok(None);
                    }
                    Action::Change(_) => return self.change(rest, &hits, at),
                }
            }
            for function in &mut self.functions {
                function.at = fraction;
                // If the remaining part of the step is too short to find the side, the next step
                // finds it.
                if function.side != Side::None || !rest.is_short() {
                    function.arrive(function.next);
                }
            }
        }
        Ok(None)
    }

    /// Evaluates the functions that are zero at the beginning a little later, to find the side on
    /// which the motion continues.
    fn find_sides(&mut self, rest: &Rest<I::System>) -> Result<(), StepError> {
        for number in 0..self.functions.len() {
            self.functions[number].at = rest.from;
            if self.functions[number].side == Side::None && !rest.is_short() {
                let later = rest.from + PROBE;
                let state = self.state_at(rest, later)?;
                let value = self.value(number, &state)?;
                let function = &mut self.functions[number];
                function.arrive(value);
                function.at = later;
            }
        }
        Ok(())
    }

    /// Returns the zeros between the last point and the next one at a fraction of the step, in
    /// order.
    fn hits(
        &self,
        rest: &Rest<I::System>,
        fraction: f64,
        state: &StateOf<I::System>,
    ) -> Result<Hits<I>, StepError> {
        let mut hits = Vec::new();
        for (number, function) in self.functions.iter().enumerate() {
            if !function.crosses_before(function.next) {
                continue;
            }
            let at = if function.next == 0.0 {
                fraction
            } else {
                self.zero(rest, number, fraction)?
            };
            if rest.is_start(at) {
                continue;
            }
            let state = if at == fraction {
                *state
            } else {
                self.state_at(rest, at)?
            };
            hits.push(Hit {
                fraction: at,
                number,
                state,
            });
        }
        hits.sort_by(|a, b| a.fraction.total_cmp(&b.fraction));
        Ok(hits)
    }

    /// Returns the fraction of the step at which a function is zero. The function has different
    /// signs at the last point and at the next one.
    fn zero(&self, rest: &Rest<I::System>, number: usize, next: f64) -> Result<f64, StepError> {
        let function = &self.functions[number];
        let bracket = [(function.at, function.value), (next, function.next)];
        let value = |fraction| self.value(number, &self.state_at(rest, fraction)?);
        let zero = zero_between(value, bracket)?;
        let [a, b] = zero.values;
        if a.abs().min(b.abs()) > JUMP * (function.next - function.value).abs() {
            let t = self.state_at(rest, zero.at)?.t;
            let [before, after] = if (a > 0.0) == (function.value > 0.0) {
                [a, b]
            } else {
                [b, a]
            };
            return Err(StepError::EventJump {
                t,
                number,
                before,
                after,
            });
        }
        Ok(zero.at)
    }

    fn stop(&mut self, hit: &Hit<StateOf<I::System>>) {
        if self.yields_steps {
            self.found.push_back((hit.state, Some(hit.number)));
        }
        self.has_ended = true;
    }

    /// Changes the state at a hit, and makes the rest of the step. Returns this rest; `None` if the
    /// hit is at its end, or a stop is at the same state.
    fn change(
        &mut self,
        rest: &Rest<I::System>,
        hits: &Hits<I>,
        at: usize,
    ) -> Result<Option<Rest<I::System>>, StepError> {
        let Hit {
            fraction,
            number,
            mut state,
        } = hits[at];
        let t = state.t;
        let same = |hit: &&Hit<_>| (hit.fraction - fraction).abs() <= SAME;
        for hit in hits[at + 1..].iter().filter(same) {
            match self.functions[hit.number].action {
                Action::Yield => self.found.push_back((hit.state, Some(hit.number))),
                Action::Stop => {
                    self.stop(hit);
                    return Ok(None);
                }
                Action::Change(_) => {}
            }
        }
        let interval = t - self.functions[number].changed_at;
        if interval.abs() < LEAST_INTERVAL * rest.h.abs() {
            return Err(StepError::EventsAccumulate {
                t,
                number,
                interval: interval.abs(),
            });
        }
        let system = self.trajectory.within().system();
        if let Action::Change(change) = &mut self.functions[number].action {
            change(system, &mut state);
        }
        state.t = t;
        self.functions[number].changed_at = t;
        self.evaluate(&state)?;
        self.arrive();
        for hit in hits.iter().filter(same) {
            self.functions[hit.number].side = Side::None;
        }
        self.go_on(rest, fraction, state)
    }

    /// Makes the rest of the step from a changed state. Returns this rest, if there is one.
    fn go_on(
        &mut self,
        rest: &Rest<I::System>,
        fraction: f64,
        state: StateOf<I::System>,
    ) -> Result<Option<Rest<I::System>>, StepError> {
        let rest = rest.after(fraction, state, &self.trajectory.noise);
        // A step of adapted size ends at the change: nothing tells the error of its rest.
        let goes_on = fraction < 1.0 && !self.trajectory.is_adapted();
        self.trajectory.state = if goes_on {
            self.state_at(&rest, 1.0)?
        } else {
            state
        };
        self.trajectory.forget();
        if let Some(low) = &mut self.trajectory.low {
            *low = State::new(
                ConfigurationOf::<I::System>::origin(),
                ConfigurationOf::<I::System>::no_momentum(),
            );
        }
        Ok(goes_on.then_some(rest))
    }

    fn state_at(
        &self,
        rest: &Rest<I::System>,
        fraction: f64,
    ) -> Result<StateOf<I::System>, StepError> {
        rest.state_at(self.trajectory.within(), &self.trajectory.noise, fraction)
    }

    fn value(&self, number: usize, state: &StateOf<I::System>) -> Result<f64, StepError> {
        self.functions[number].evaluate(number, self.trajectory.within().system(), state)
    }

    /// Evaluates all functions at a state.
    fn evaluate(&mut self, state: &StateOf<I::System>) -> Result<(), StepError> {
        let system = self.trajectory.within().system();
        for (number, function) in self.functions.iter_mut().enumerate() {
            function.next = function.evaluate(number, system, state)?;
        }
        Ok(())
    }

    /// Stores the values that were evaluated last as the values at the last point.
    fn arrive(&mut self) {
        for function in &mut self.functions {
            function.arrive(function.next);
        }
    }
}
