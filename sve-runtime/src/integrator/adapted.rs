//! Attempts at steps whose size is adapted: an integrator with a Gauss rule, and what a step leaves
//! for the next one.
//!
//! Input: a state with its low parts, and a step size. Output: the decay of the step, from which
//! its size is judged, and the state after it. Invariant: a state changes when an attempt is
//! accepted, and not before.

use core::fmt;

use super::Integrator;
use super::accept::replace;
use crate::gauss::{AdaptedSteps, Attempt, StageSeries};
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

/// Attempts at steps of any size.
#[doc(hidden)]
pub trait Attempts<S: AnySystem>: fmt::Debug {
    /// Tries a step. Returns the logarithm to base 2 of the ratio of successive terms of its
    /// series; `None` if the step was not solved.
    fn attempt(&mut self, system: &S, state: &StateOf<S>, h: f64, level: f64) -> Option<f64>;

    /// Moves the state with its low parts by the step that was tried last. Returns whether the
    /// result is finite and at another time; otherwise nothing changes.
    fn accept(&mut self, state: &mut StateOf<S>, low: &mut StateOf<S>) -> bool;

    /// Returns the state at a time within the last step that was accepted.
    fn state_at(&self, t: f64) -> Option<StateOf<S>>;

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

/// What the steps of a system compute from its parameters alone.
type CoefficientsOf<S, const K: usize, const N: usize> =
    <<S as System>::Itself as AdaptedSteps<K, N>>::Coefficients;

/// Attempts at the steps of a Gauss rule. `C` is what they compute from parameters alone.
#[derive(Clone)]
struct GaussAttempts<C, const K: usize, const N: usize> {
    coefficients: C,
    tried: Option<Attempt<K, N>>,
    /// The series of the last step that was accepted.
    last: Option<StageSeries<K, N>>,
    /// The start of this step, and the time at its end.
    start: Option<(State<[f64; N]>, f64)>,
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
    fn attempt(&mut self, system: &S, state: &State<Q>, h: f64, level: f64) -> Option<f64> {
        let (system, state) = (system.itself(), state.to_coordinates());
        self.tried = None;
        if S::Itself::TESTS_PARAMETERS && !system.parameters_give_regular_mass()
            || S::Itself::TESTS_STATE && !system.state_gives_regular_mass(state.t, &state.q)
        {
            return None;
        }
        self.tried = system.attempt(&self.coefficients, &state, h, level, self.last.as_ref());
        self.tried.map(|tried| tried.decay)
    }

    fn accept(&mut self, state: &mut State<Q>, low: &mut State<Q>) -> bool {
        let Some(tried) = self.tried.take() else {
            return false;
        };
        let ([dq, dp], h) = (tried.increments, tried.series.h);
        let start = state.to_coordinates();
        let (mut end, mut new_low) = (start, low.to_coordinates());
        let (q, p) = <[f64; N]>::moved_with_low_parts(&start, &mut new_low, &dq, &dp);
        if !replace(&mut end, h, &q, &p) {
            return false;
        }
        (end.t, new_low.t) = two_sum(start.t, h + low.t);
        self.last = Some(tried.series);
        self.start = Some((start, end.t));
        *state = State::from_coordinates(&end);
        *low = State::from_coordinates(&new_low);
        true
    }

    fn state_at(&self, t: f64) -> Option<State<Q>> {
        let ((mut state, end), series) = (self.start?, self.last?);
        let fraction = (t - state.t) / (end - state.t);
        if !(0.0..=1.0).contains(&fraction) {
            return None;
        }
        let [moves, kicks] = series.until(fraction);
        for n in 0..N {
            state.q[n] += moves[n];
            state.p[n] += kicks[n];
        }
        state.t = t;
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
