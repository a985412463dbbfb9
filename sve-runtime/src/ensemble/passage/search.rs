//! The first zero of a function within a step.
//!
//! Input: the state before a step, its increments, and the path of the noise within the step; the
//! function has different signs at both ends. Output: the state at the zero. Invariant: the result
//! is a function of these inputs.
//!
//! The step is halved on the same path of the noise, towards the earlier half in which the sign
//! changes. Within the last part the function is taken as linear and so is the path, so for a
//! smooth motion the zero is off by 2⁻²⁴ of the square of the step, times the second derivative
//! over the first. A part of the step that has no solution is made in smaller steps, if the
//! ensemble refines steps.

use crate::ensemble::PathMethod;
use crate::error::StepError;
use crate::method::Within;
use crate::noise::{DyadicInterval, Halves};
use crate::system::{Increments, StateOf};
use crate::time::is_next_time;
use crate::trajectory::Halving;

use super::super::crossings::crosses;
use super::super::observe::Function;

/// Number of halvings of a step. Each costs a scalar step and four random words a process.
const HALVINGS: u32 = 12;

/// Number of halvings after which a function that is no smaller than at the ends of the step jumps.
/// It is far smaller by then if it is continuous, also along a rough path.
const DEEPEST: u32 = 32;

/// A step within which a function has different signs.
pub(super) struct Crossing<'a, I: PathMethod> {
    pub(super) method: Within<'a, I>,
    pub(super) noise: &'a dyn Halves,
    /// The number of the step.
    pub(super) step: u64,
    pub(super) h: f64,
    /// The state before the step.
    pub(super) before: StateOf<I::System>,
    /// The increments over the step.
    pub(super) whole: I::Increments,
    /// Largest number of halvings of a part that has no solution.
    pub(super) depth: u32,
}

/// A zero within a step.
pub(super) struct Zero<T> {
    /// The part of the step before it.
    pub(super) fraction: f64,
    pub(super) state: T,
}

/// A dyadic part of a step, with its increments.
type Part<D> = (DyadicInterval, D);

/// A part of a step in which a function changes its sign.
#[derive(Clone)]
struct Bracket<D> {
    /// The parts before it, of falling length.
    before: Vec<Part<D>>,
    part: Part<D>,
    /// The start and the length of the bracket, as fractions of the step.
    low: f64,
    width: f64,
    /// The function at both ends.
    values: [f64; 2],
}

impl<D> Bracket<D> {
    /// Returns the larger size of the function at both ends.
    fn size(&self) -> f64 {
        self.values[0].abs().max(self.values[1].abs())
    }
}

impl<I: PathMethod> Crossing<'_, I> {
    /// Finds the first zero of function `number`, with these values before and after the step.
    pub(super) fn first_zero(
        &self,
        number: usize,
        function: &dyn Function<I::System>,
        values: [f64; 2],
    ) -> Result<Zero<StateOf<I::System>>, StepError> {
        let mut bracket = Bracket {
            before: Vec::new(),
            part: (DyadicInterval::whole(self.step), self.whole),
            low: 0.0,
            width: 1.0,
            values,
        };
        let size = bracket.size();
        for _ in 0..HALVINGS {
            self.halve(&mut bracket, number, function)?;
        }
        // a continuous function is smaller by now
        if bracket.size() > 0.5 * size {
            self.refuse_jump(bracket.clone(), number, function, size)?;
        }
        let [low, high] = bracket.values;
        let within = low / (low - high);
        let state = self.state_at(&bracket.before, bracket.part, within)?;
        let fraction = within.mul_add(bracket.width, bracket.low);
        Ok(Zero { fraction, state })
    }

    /// Replaces a bracket by its first half in which the sign changes. Returns `false` if the
    /// interval is too short to be halved.
    fn halve(
        &self,
        bracket: &mut Bracket<I::Increments>,
        number: usize,
        function: &dyn Function<I::System>,
    ) -> Result<bool, StepError> {
        let (interval, whole) = bracket.part;
        let Some([first, second]) = interval.halves() else {
            return Ok(false);
        };
        let (mut left, mut right) = (whole, whole);
        let length = bracket.width * self.h;
        let (to_left, to_right) = (left.as_mut(), right.as_mut());
        (self.noise).halves_of(interval, length, whole.as_ref(), to_left, to_right);
        bracket.width *= 0.5;
        let state = self.state_at(&bracket.before, (first, left), 1.0)?;
        let value = function.value(self.method.system(), &state)?;
        if !value.is_finite() {
            let t = state.t;
            return Err(StepError::EventFunction { t, number, value });
        }
        if crosses(bracket.values[0], value) {
            bracket.values[1] = value;
            bracket.part = (first, left);
        } else {
            bracket.values[0] = value;
            bracket.low += bracket.width;
            bracket.before.push((first, left));
            bracket.part = (second, right);
        }
        Ok(true)
    }

    /// Returns an error if the function jumps in the bracket: if it does not become smaller than
    /// half of its size at the ends of the step.
    fn refuse_jump(
        &self,
        mut bracket: Bracket<I::Increments>,
        number: usize,
        function: &dyn Function<I::System>,
        size: f64,
    ) -> Result<(), StepError> {
        while bracket.part.0.level() < DEEPEST && self.halve(&mut bracket, number, function)? {}
        if bracket.size() <= 0.5 * size {
            return Ok(());
        }
        let [before, after] = bracket.values;
        Err(StepError::EventJump {
            t: bracket.low.mul_add(self.h, self.before.t),
            number,
            before,
            after,
        })
    }

    /// Makes the step up to a fraction of a part that follows others.
    fn state_at(
        &self,
        before: &[Part<I::Increments>],
        last: Part<I::Increments>,
        within: f64,
    ) -> Result<StateOf<I::System>, StepError> {
        let mut dw = I::Increments::NONE;
        let mut fraction = 0.0;
        for (interval, part) in before {
            add(&mut dw, 1.0, part);
            fraction += interval.fraction();
        }
        add(&mut dw, within, &last.1);
        let fraction = within.mul_add(last.0.fraction(), fraction);
        let mut state = self.before;
        let t = fraction.mul_add(self.h, state.t);
        if let Err(error) = self.advance(&mut state, fraction * self.h, &dw) {
            state = self.state_in_parts(error, before, last, within)?;
        }
        state.t = t;
        Ok(state)
    }

    /// Computes the state that [`state_at`](Self::state_at) failed to compute, part by part, in
    /// smaller steps if needed.
    fn state_in_parts(
        &self,
        error: StepError,
        before: &[Part<I::Increments>],
        last: Part<I::Increments>,
        within: f64,
    ) -> Result<StateOf<I::System>, StepError> {
        if self.depth == 0 {
            return Err(error);
        }
        let halving = Halving {
            method: self.method,
            noise: self.noise,
            depth: self.depth,
        };
        let mut state = self.before;
        let whole = (within == 1.0).then_some(&last);
        for (interval, dw) in before.iter().chain(whole) {
            let h = interval.fraction() * self.h;
            if let Err(error) = self.advance(&mut state, h, dw) {
                halving.step(error, *interval, h, dw, &mut state)?;
            }
        }
        if within != 1.0 {
            let mut dw = I::Increments::NONE;
            add(&mut dw, within, &last.1);
            self.advance(&mut state, within * last.0.fraction() * self.h, &dw)?;
        }
        Ok(state)
    }

    /// Makes a step of length `h`.
    fn advance(
        &self,
        state: &mut StateOf<I::System>,
        h: f64,
        dw: &I::Increments,
    ) -> Result<(), StepError> {
        // A part that is too short to change the time changes nothing else.
        if h != 0.0 && is_next_time(state.t, state.t + h) {
            self.method.make(state, h, dw)?;
        }
        Ok(())
    }
}

/// Adds a multiple of increments to others.
fn add<D: Increments>(sum: &mut D, factor: f64, part: &D) {
    for (sum, part) in sum.as_mut().iter_mut().zip(part.as_ref()) {
        *sum += factor * part;
    }
}
