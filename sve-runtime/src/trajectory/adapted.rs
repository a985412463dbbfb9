//! Steps of a trajectory whose size is adapted to a tolerance.
//!
//! Input: a trajectory with the control of its step size. Output: the trajectory after one step, or
//! the state at a time. Invariant: an error leaves the state unchanged; a step that ends at a given
//! time has this time with its bits.

use core::borrow::Borrow as _;
use core::ops::RangeInclusive;

use super::events::zero_between;
use super::{StepKind, Trajectory};
use crate::error::StepError;
use crate::gauss::step_size::StepSize;
use crate::integrator::accept::check_step_size;
use crate::integrator::adapted::{BoxedAttempts, Rate};
use crate::method::OneStepMethod;
use crate::noise::Noise;
use crate::system::{AnySystem, StateOf};
use crate::time::unit;

/// Smallest step, in units of the rounding error of the time.
const LEAST_STEP: f64 = 4.0;

/// Smallest first step to try, in the same units. The given size is a first guess, and one that
/// does not change the time is no step.
const LEAST_FIRST_STEP: f64 = 64.0;

/// Smallest first step to try at any time: its products with forces have all their digits.
const NORMAL_STEP: f64 = 1e-200;

/// Largest number of steps, unless another one is given.
const MOST_STEPS: u64 = 100_000_000;

/// The tolerances for which steps are adapted. Below them rounding errors of the state are larger,
/// and above them the series of a step says nothing about its error.
const TOLERANCES: RangeInclusive<f64> = 1e-15..=1e-2;

/// A step that ends within this fraction of its size before a time ends at this time.
const SAME_TIME: f64 = 1e-12;

/// The sizes of the steps of a trajectory.
#[derive(Debug)]
pub(super) enum Sizes<S: AnySystem> {
    /// One size for all steps.
    Fixed,
    /// Numbers of a snapshot, which continue with a tolerance.
    Stored(Vec<f64>),
    Adapted(Box<Adapted<S>>),
}

/// The control of a path with a tolerance.
#[derive(Debug)]
pub(super) struct Adapted<S: AnySystem> {
    tolerance: f64,
    size: StepSize,
    attempts: BoxedAttempts<S>,
    /// Number of attempts that were not accepted.
    pub(super) rejected: u64,
    /// Largest number of steps.
    pub(super) most_steps: u64,
    /// False if the numbers of a snapshot are those of another method.
    has_valid_numbers: bool,
}

impl<S: AnySystem> Adapted<S> {
    /// Returns the control of a path from a time, with the size of the first step to try.
    pub(super) fn new(
        tolerance: f64,
        size: StepSize,
        attempts: BoxedAttempts<S>,
        stored: &[f64],
    ) -> Self {
        let mut adapted = Self {
            tolerance,
            size,
            attempts,
            rejected: 0,
            most_steps: MOST_STEPS,
            has_valid_numbers: true,
        };
        if let Some((&[next, before, fitted, rejected], of_step)) = stored.split_first_chunk() {
            adapted.size.recall([next, before, fitted]);
            #[allow(clippy::cast_sign_loss, clippy::cast_possible_truncation)] // a count
            let rejected = rejected as u64;
            adapted.rejected = rejected;
            adapted.has_valid_numbers = adapted.attempts.restore(of_step);
        } else {
            adapted.has_valid_numbers = stored.is_empty();
        }
        adapted
    }

    /// Checks what the path was given, and that another step may follow `step` steps.
    fn check(&self, t: f64, h: f64, steps: u64) -> Result<(), StepError> {
        check_step_size(self.size.h())?;
        if steps >= self.most_steps {
            return Err(StepError::TooManySteps { t, h, steps });
        }
        let tolerance = self.tolerance;
        if !TOLERANCES.contains(&tolerance) {
            return Err(StepError::Tolerance { t, tolerance });
        }
        if !self.has_valid_numbers {
            let (numbers, differs) = (self.numbers().len(), "versions of this library".into());
            return Err(StepError::OtherSteps {
                t,
                numbers,
                differs,
            });
        }
        Ok(())
    }

    /// Limits the size of all steps.
    pub(super) fn limit(&mut self, most: f64) {
        self.size.limit(most);
    }

    fn numbers(&self) -> Vec<f64> {
        let mut numbers = self.size.numbers().to_vec();
        numbers.push(self.rejected as f64);
        self.attempts.store(&mut numbers);
        numbers
    }

    fn copy(&self) -> Self {
        Self {
            attempts: self.attempts.copy(),
            ..*self
        }
    }

    /// Returns the state at a time within the last step, by the polynomials of its stages.
    pub(super) fn state_at(&self, t: f64) -> Option<StateOf<S>> {
        let late = |fraction: f64| Some(self.attempts.within(fraction)?.t - t);
        let ends = [late(0.0)?, late(1.0)?];
        // false for NaN
        let is_within = ends[0] * ends[1] <= 0.0;
        if !is_within {
            return None;
        }
        let bracket = [(0.0, ends[0]), (1.0, ends[1])];
        let zero = zero_between(|fraction| late(fraction).ok_or(()), bracket);
        let mut state = self.attempts.within(zero.ok()?.at)?;
        state.t = t;
        Some(state)
    }

    /// Tries the part of the step that was tried last, a step of size `h`, that takes a time
    /// `rest`. Returns the size of the part that was tried last, which is solved if all parts were.
    fn attempt_until(
        &mut self,
        system: (&S, Rate<'_, S>),
        state: &StateOf<S>,
        mut h: f64,
        rest: f64,
    ) -> f64 {
        let (attempts, level) = (&mut self.attempts, self.size.level());
        let (whole, bracket) = (h, [(0.0, -rest), (1.0, attempts.elapsed() - rest)]);
        let mut late = |fraction: f64| {
            h = fraction * whole;
            let solved = attempts.attempt(system, state, h, level);
            solved.map(|_| attempts.elapsed() - rest).ok_or(())
        };
        // the part that was tried last need not be the one next to the zero
        zero_between(&mut late, bracket)
            .and_then(|zero| late(zero.at))
            .ok();
        h
    }
}

impl<S: AnySystem> Sizes<S> {
    /// Returns the numbers for a snapshot.
    pub(super) fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Fixed => Vec::new(),
            Self::Stored(numbers) => numbers.clone(),
            Self::Adapted(adapted) => adapted.numbers(),
        }
    }

    /// Forgets the steps before, after a change of the state in a step of size `h`. The next step
    /// is at most as long: the change has cut this one.
    pub(super) fn forget(&mut self, h: f64) {
        if let Self::Adapted(adapted) = self {
            adapted.size.forget(h);
            adapted.attempts.forget();
        }
    }
}

/// Returns the control of the step size for the first step, from a time whose rounding error is
/// that of a step of size `unit`.
pub(super) fn first_size(tolerance: f64, stages: usize, h: f64, unit: f64) -> StepSize {
    let least = (LEAST_FIRST_STEP * unit).max(NORMAL_STEP);
    let is_given = h.is_finite() && h != 0.0;
    let h = if is_given {
        h.abs().max(least).copysign(h)
    } else {
        h
    };
    StepSize::new(tolerance, stages, h)
}

/// Returns the size of a step that takes the rounding error of the time. Where a time scale is not
/// defined, the step says so.
pub(super) fn unit_of_step<I: OneStepMethod>(method: &I, state: &StateOf<I::System>) -> f64 {
    let rate = method.rate(state);
    let is_rate = rate > 0.0 && rate.is_finite();
    unit(state.t) / if is_rate { rate } else { 1.0 }
}

/// Where a step has to end.
#[derive(Clone, Copy)]
pub(super) enum Limit {
    None,
    /// Before a time: a step that reaches it is not made.
    Before(f64),
    /// At a time, if the step reaches it.
    At(f64),
}

impl Limit {
    /// Returns the time that is left.
    fn rest(self, t: f64, low: f64) -> f64 {
        match self {
            Self::None => f64::INFINITY,
            Self::Before(end) | Self::At(end) => (end - t) - low,
        }
    }
}

/// Returns whether a step that takes some time reaches the time after `rest`.
fn reaches(elapsed: f64, rest: f64) -> bool {
    rest.is_finite() && rest.abs() <= elapsed.abs() * (1.0 + SAME_TIME)
}

impl<I: OneStepMethod, W: Noise, K: StepKind<I, W>> Trajectory<'_, I, W, K> {
    /// Returns whether the sizes of the steps are adapted.
    pub(super) fn is_adapted(&self) -> bool {
        matches!(self.sizes, Sizes::Adapted(_))
    }

    /// Makes a step of the size that the tolerance allows. Returns whether it reaches the time of
    /// the limit.
    #[cold]
    #[inline(never)]
    pub(super) fn adapted_step(&mut self, limit: Limit) -> Result<bool, StepError> {
        let (Sizes::Adapted(adapted), Some(low)) = (&mut self.sizes, &mut self.low) else {
            return Ok(false);
        };
        let (method, state) = (&*self.method, &mut self.state);
        let rate = |state: &StateOf<I::System>| method.rate(state);
        let rate: Rate<'_, I::System> = if I::HAS_OWN_TIME { Some(&rate) } else { None };
        let system = (method.system(), rate);
        let t = state.t;
        adapted.check(t, self.h, self.step)?;
        let (rest, stays_before) = (limit.rest(t, low.t), matches!(limit, Limit::Before(_)));
        let least = LEAST_STEP * unit_of_step(method, state);
        let before = (adapted.size, adapted.rejected);
        let (mut tried, mut attempts) = (adapted.size.h(), 0);
        // each size is at most 2^-½ of the one before, so there is an end
        loop {
            let mut h = adapted.size.h();
            let mut lands = !I::HAS_OWN_TIME && reaches(h, rest);
            if lands {
                if stays_before {
                    return Ok(true);
                }
                h = rest;
            }
            // false for NaN
            let is_long_enough = h.abs() > least;
            if !lands && !is_long_enough {
                break;
            }
            attempts += 1;
            tried = h;
            let last = adapted.size;
            let decay = adapted.attempts.attempt(system, state, h, last.level());
            if adapted.size.judge(h, decay) {
                // how far a step of another time goes is known when it is solved
                if I::HAS_OWN_TIME && reaches(adapted.attempts.elapsed(), rest) {
                    if stays_before {
                        (adapted.size, adapted.rejected) = before;
                        return Ok(true);
                    }
                    lands = true;
                    h = adapted.attempt_until(system, state, h, rest);
                }
                // a time within a rounding error of the step has the state of its start
                let stays = lands && h == 0.0;
                if stays || adapted.attempts.accept(state, low) {
                    if let Limit::At(end) = limit
                        && lands
                    {
                        (state.t, low.t) = (end, 0.0);
                    }
                    self.h = h;
                    self.step += 1;
                    return Ok(lands);
                }
                adapted.size = last;
                adapted.size.judge(h, None);
            }
            adapted.rejected += 1;
        }
        adapted.size = before.0;
        Err(self.no_size(tried, least, attempts))
    }

    /// Returns the reason why no size was found for the next step: that of a short step of fixed
    /// size, if its start or a number is the reason.
    #[cold]
    fn no_size(&mut self, h: f64, least: f64, attempts: u32) -> StepError {
        let mut state = self.state.clone();
        let t = state.t;
        let short = LEAST_FIRST_STEP / LEAST_STEP * least;
        let short = short.max(NORMAL_STEP).copysign(h);
        let step = self.draw().and_then(|dw| {
            let prepared = self.method.prepare(short)?;
            (self.method).step_prepared(&prepared, &mut state, short, dw.borrow())
        });
        let [q, _] = self.state.stored();
        match step {
            Err(
                error @ (StepError::NonFiniteInput { .. }
                | StepError::NonFiniteResult { .. }
                | StepError::OutsideDomain { .. }
                | StepError::SingularMass { .. }
                | StepError::TimeScale { .. }
                | StepError::Noise { .. }),
            ) => error,
            _ => StepError::StepTooSmall {
                t,
                h,
                least,
                attempts,
                q,
            },
        }
    }

    /// Makes steps that end before a time, until there are `most` steps. Returns whether the last
    /// one ends at this time.
    pub(super) fn adapted_steps_before(&mut self, end: f64, most: u64) -> Result<bool, StepError> {
        loop {
            let (Sizes::Adapted(adapted), Some(low)) = (&self.sizes, &self.low) else {
                return Ok(false);
            };
            // the low part of the time does not matter to one who asks for the present state
            if self.state.t == end {
                return Ok(true);
            }
            let rest = Limit::At(end).rest(self.state.t, low.t);
            let h = adapted.size.h();
            if rest * h < 0.0 || !rest.is_finite() {
                let (t, after) = (end, self.state.t);
                return Err(StepError::TimeOrder { t, after, h });
            }
            if self.step >= most {
                return Ok(false);
            }
            let step = self.adapted_step(Limit::Before(end));
            self.has_ended |= step.is_err();
            if step? {
                return Ok(false);
            }
        }
    }

    /// Returns the state at a time before the end of the next step. The path stays where it is.
    pub(super) fn adapted_state_at(&mut self, t: f64) -> Result<StateOf<I::System>, StepError> {
        let Sizes::Adapted(adapted) = &mut self.sizes else {
            return Ok(self.state.clone());
        };
        let copy = Sizes::Adapted(Box::new(adapted.copy()));
        // these steps are no steps of the path
        adapted.most_steps = u64::MAX;
        let kept = (self.state.clone(), self.low.clone(), self.h, self.step);
        let mut reached = Ok(false);
        while let Ok(false) = reached {
            reached = self.adapted_step(Limit::At(t));
        }
        let state = core::mem::replace(&mut self.state, kept.0);
        (self.low, self.h, self.step) = (kept.1, kept.2, kept.3);
        self.sizes = copy;
        reached.map(|_| state)
    }
}
