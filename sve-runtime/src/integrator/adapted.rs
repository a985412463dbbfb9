//! Attempts at steps whose size is adapted: an integrator with a Gauss rule, and what a step leaves
//! for the next one.
//!
//! Input: a state with its low parts, and a step size. Output: the decay of the step, from which
//! its size is judged, and the state after it. Invariant: a state changes when an attempt is
//! accepted, and not before.

use core::fmt;

use super::Integrator;
use super::accept::replace;
use super::time_scale::InScaledTime;
use crate::gauss::{AdaptedSteps, Attempt, StageSeries, integral};
use crate::mechanics::time_scale::TimeScale;
use crate::method::OneStepMethod;
use crate::phase::configuration::{Coordinates, FlatConfiguration as _, two_sum};
use crate::phase::state::State;
use crate::rule::Gauss;
use crate::system::start::StartOfStep as _;
use crate::system::{AnySystem, Dims, StateOf, System};

/// A method whose step size can be adapted: an [`Integrator`] with a Gauss rule of four stages or
/// more.
#[diagnostic::on_unimplemented(
    message = "`.tolerance(tol)` does not take the steps of `{Self}`",
    label = "its steps have no adapted sizes",
    note = "it takes the integrator of a rule from `Gauss::<4>` to `Gauss::<8>`, in the attribute `gauss(4)` to `gauss(8)`: other rules, options such as `Weak2` and compositions get their structure from steps of one size; its ∂L/∂v has to be affine in v, so that an iteration solves the steps",
    note = "inputs that are held over a step belong to steps of one size too; an integrator of `system.holding(&u)` has constant ones"
)]
pub trait AdaptsSteps: OneStepMethod {
    /// Number of stages.
    #[doc(hidden)]
    const STAGES: usize;
    /// Returns attempts at its steps.
    #[doc(hidden)]
    fn attempts(&self) -> BoxedAttempts<Self::System>;
    /// Returns the low parts of a state that is exact.
    #[doc(hidden)]
    fn no_low_parts() -> StateOf<Self::System>;
}

/// Attempts at the steps of any method.
#[doc(hidden)]
pub type BoxedAttempts<S> = Box<dyn Attempts<S> + Send + Sync>;

/// The time that passes in a unit of the step size at a state; `None` if the step size is a time.
#[doc(hidden)]
pub type Rate<'a, S> = Option<&'a dyn Fn(&StateOf<S>) -> f64>;

/// Attempts at steps of any size.
#[doc(hidden)]
pub trait Attempts<S: AnySystem>: fmt::Debug {
    /// Tries a step. Returns the logarithm to base 2 of the ratio of successive terms of its
    /// series; `None` if the step was not solved.
    fn attempt(
        &mut self,
        system: (&S, Rate<'_, S>),
        state: &StateOf<S>,
        h: f64,
        level: f64,
    ) -> Option<f64>;

    /// Returns the time that the step takes that was tried last; NaN if it was not solved.
    fn elapsed(&self) -> f64;

    /// Moves the state with its low parts by the step that was tried last. Returns whether the
    /// result is finite and at another time; otherwise nothing changes.
    fn accept(&mut self, state: &mut StateOf<S>, low: &mut StateOf<S>) -> bool;

    /// Returns the state at a fraction of the last step that was accepted.
    fn within(&self, fraction: f64) -> Option<StateOf<S>>;

    /// Forgets the last step, after a change of the state.
    fn forget(&mut self);

    /// Adds the numbers of the last step to a list.
    fn store(&self, numbers: &mut Vec<f64>);

    /// Reads the numbers that [`store`](Self::store) added. Returns whether their count is right.
    fn restore(&mut self, numbers: &[f64]) -> bool;

    /// Returns a copy.
    fn copy(&self) -> BoxedAttempts<S>;
}

#[diagnostic::do_not_recommend]
impl<S, Q, const K: usize, const N: usize, const M: usize> AdaptsSteps for Integrator<S, Gauss<K>>
where
    Self: OneStepMethod<System = S>,
    S: System<Dims = Dims<N, M, Q>, Itself: AdaptedSteps<K, N>>,
    Q: Coordinates<N, Flat = [f64; N]>,
{
    const STAGES: usize = K;

    fn attempts(&self) -> BoxedAttempts<S> {
        Box::new(GaussAttempts::<CoefficientsOf<S, K, N>, K, N> {
            coefficients: self.system().itself().coefficients(),
            tried: None,
            last: None,
            start: None,
        })
    }

    fn no_low_parts() -> StateOf<S> {
        State::new(Q::origin(), Q::no_momentum())
    }
}

#[diagnostic::do_not_recommend]
impl<H: TimeScale, R> AdaptsSteps for InScaledTime<H, R>
where
    Self: OneStepMethod<System = H>,
    Integrator<H, R>: AdaptsSteps<System = H>,
{
    const STAGES: usize = Integrator::<H, R>::STAGES;

    fn attempts(&self) -> BoxedAttempts<H> {
        self.in_tau().attempts()
    }

    fn no_low_parts() -> StateOf<H> {
        Integrator::<H, R>::no_low_parts()
    }
}

/// The values that the steps of a system compute from its parameters alone.
type CoefficientsOf<S, const K: usize, const N: usize> =
    <<S as System>::Itself as AdaptedSteps<K, N>>::Coefficients;

/// The Legendre series of the time within a step.
type Times<const K: usize> = [f64; K];

/// Attempts at the steps of a Gauss rule. `C` is what they compute from parameters alone.
#[derive(Clone)]
struct GaussAttempts<C, const K: usize, const N: usize> {
    coefficients: C,
    tried: Option<(Attempt<K, N>, Times<K>)>,
    /// The series of the last step that was accepted.
    last: Option<StageSeries<K, N>>,
    /// The start of this step, the time at its end, and the times between.
    start: Option<(State<[f64; N]>, f64, Times<K>)>,
}

impl<C, const K: usize, const N: usize> fmt::Debug for GaussAttempts<C, K, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("GaussAttempts")
            .field("last", &self.last)
            .finish_non_exhaustive()
    }
}

impl<S, Q, const K: usize, const N: usize, const M: usize> Attempts<S>
    for GaussAttempts<CoefficientsOf<S, K, N>, K, N>
where
    S: System<Dims = Dims<N, M, Q>, Itself: AdaptedSteps<K, N>>,
    Q: Coordinates<N, Flat = [f64; N]>,
{
    fn attempt(
        &mut self,
        (system, rate): (&S, Rate<'_, S>),
        state: &State<Q>,
        h: f64,
        level: f64,
    ) -> Option<f64> {
        let (itself, start) = (system.itself(), state.to_coordinates());
        self.tried = None;
        if S::Itself::TESTS_PARAMETERS && !itself.parameters_give_regular_mass()
            || S::Itself::TESTS_STATE && !itself.state_gives_regular_mass(start.t, &start.q)
        {
            return None;
        }
        let tried = itself.attempt(&self.coefficients, &start, h, level, self.last.as_ref())?;
        let times = match rate {
            None => Some(core::array::from_fn(|k| if k == 0 { h } else { 0.0 })),
            Some(rate) => tried.times(&start.q, |q| {
                rate(&State::from_coordinates(&State { q: *q, ..start }))
            }),
        };
        self.tried = times.map(|times| (tried, times));
        self.tried.map(|(tried, _)| tried.decay)
    }

    fn elapsed(&self) -> f64 {
        self.tried.map_or(f64::NAN, |(_, times)| times[0])
    }

    fn accept(&mut self, state: &mut State<Q>, low: &mut State<Q>) -> bool {
        let Some((tried, times)) = self.tried.take() else {
            return false;
        };
        let [dq, dp] = tried.increments;
        let start = state.to_coordinates();
        let (mut end, mut new_low) = (start, low.to_coordinates());
        let (q, p) = <[f64; N]>::moved_with_low_parts(&start, &mut new_low, &dq, &dp);
        let added = times[0] + low.t;
        if !replace(&mut end, added, &q, &p) {
            return false;
        }
        (end.t, new_low.t) = two_sum(start.t, added);
        self.last = Some(tried.series);
        self.start = Some((start, end.t, times));
        *state = State::from_coordinates(&end);
        *low = State::from_coordinates(&new_low);
        true
    }

    fn within(&self, fraction: f64) -> Option<State<Q>> {
        let ((mut state, end, times), series) = (self.start?, self.last?);
        if fraction == 0.0 {
            return Some(State::from_coordinates(&state));
        }
        let [moves, kicks] = series.until(fraction);
        for n in 0..N {
            state.q[n] += moves[n];
            state.p[n] += kicks[n];
        }
        state.t = if fraction == 1.0 {
            end
        } else {
            state.t + integral(&times, fraction)
        };
        Some(State::from_coordinates(&state))
    }

    fn forget(&mut self) {
        (self.last, self.start) = (None, None);
    }

    fn store(&self, numbers: &mut Vec<f64>) {
        if let Some(StageSeries { h, rows }) = &self.last {
            numbers.push(*h);
            numbers.extend(rows.as_flattened().as_flattened());
        }
    }

    fn restore(&mut self, numbers: &[f64]) -> bool {
        (self.last, self.start) = (None, None);
        let Some((&h, entries)) = numbers.split_first() else {
            return true;
        };
        let mut rows = [[[0.0; K]; N]; 2];
        let to = rows.as_flattened_mut().as_flattened_mut();
        if to.len() != entries.len() {
            return false;
        }
        to.copy_from_slice(entries);
        self.last = Some(StageSeries { h, rows });
        true
    }

    fn copy(&self) -> BoxedAttempts<S> {
        Box::new(self.clone())
    }
}
