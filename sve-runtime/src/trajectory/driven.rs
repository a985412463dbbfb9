//! Trajectories of systems with inputs.
//!
//! Invariant: an input is computed once a step, from the state at its start, and held over it.
//! Nothing that depends on it is carried to the next step.

use core::cell::RefCell;
use core::fmt;
use core::iter::Take;

use super::{Snapshot, Trajectory};
use crate::error::StepError;
use crate::integrator::Integrator;
use crate::integrator::driven::{Driven, Source};
use crate::integrator::inputs::Holding;
use crate::method::{OneStepMethod, Shared};
use crate::noise::Noise;
use crate::rule::Rule;
use crate::system::{AnySystem, StateOf, WithInputs};

/// Trajectories of systems with inputs.
pub trait DrivenPaths<S: WithInputs, R> {
    /// Returns a path that still needs the [`inputs`](NeedsInputs::inputs) of its steps.
    fn trajectory<W: Noise>(&self, state: StateOf<S>, h: f64, noise: W)
    -> NeedsInputs<'_, S, R, W>;

    /// Continues a trajectory from a snapshot, with its bits if the inputs are the same. The
    /// function of the inputs gets the numbers of steps from the start of the first trajectory.
    ///
    /// # Errors
    /// As [`Method::resume`](crate::Method::resume).
    fn resume<'a, W, F>(
        &'a self,
        snapshot: Snapshot<StateOf<S>>,
        noise: W,
        inputs: F,
    ) -> Result<DrivenTrajectory<'a, S, R, W, F>, StepError>
    where
        W: Noise,
        R: Copy + Rule<S::Held<'a>>,
        F: FnMut(u64, &StateOf<S>) -> S::Input,
        Holding<'a, S, R>: OneStepMethod<System = S::Held<'a>>;

    /// Does not compile, and names the call that does: [`Integrator::step_with`].
    ///
    /// # Errors
    /// None: it is never called.
    #[doc(hidden)]
    fn step<D: ?Sized>(&self, state: &mut StateOf<S>, _: f64, _: &D) -> Result<(), StepError>
    where
        S: StepsWithoutInputs,
    {
        S::step(state)
    }
}

/// Systems whose steps take no inputs: none that has them.
#[doc(hidden)]
#[diagnostic::on_unimplemented(
    message = "a step of `{Self}` takes the values of its inputs",
    label = "the inputs are missing",
    note = "`step_with(&mut state, h, &dw, &u)` makes a step with the inputs `u`; trajectories take them by `.inputs(|step, state| …)`, ensembles by `.inputs(\"name\", |path, step, state| …)`"
)]
pub trait StepsWithoutInputs: AnySystem {
    /// Makes a step.
    fn step(state: &mut StateOf<Self>) -> Result<(), StepError>;
}

impl<S: WithInputs, R: Copy> DrivenPaths<S, R> for Integrator<S, R> {
    fn trajectory<W: Noise>(
        &self,
        state: StateOf<S>,
        h: f64,
        noise: W,
    ) -> NeedsInputs<'_, S, R, W> {
        NeedsInputs {
            integrator: self,
            state,
            h,
            noise,
        }
    }

    fn resume<'a, W, F>(
        &'a self,
        snapshot: Snapshot<StateOf<S>>,
        noise: W,
        inputs: F,
    ) -> Result<DrivenTrajectory<'a, S, R, W, F>, StepError>
    where
        W: Noise,
        R: Copy + Rule<S::Held<'a>>,
        F: FnMut(u64, &StateOf<S>) -> S::Input,
        Holding<'a, S, R>: OneStepMethod<System = S::Held<'a>>,
    {
        Trajectory::resume(driven(self, inputs), snapshot, noise)
    }
}

/// A method whose inputs come from a function.
type ByFunction<'a, S, R, F> = Driven<'a, S, R, RefCell<Once<F, <S as WithInputs>::Numbers>>>;

/// Returns the method of an integrator whose inputs come from a function.
fn driven<'a, S, R, F>(
    integrator: &'a Integrator<S, R>,
    inputs: F,
) -> Shared<'a, ByFunction<'a, S, R, F>>
where
    S: WithInputs,
    R: Copy + Rule<S::Held<'a>>,
{
    let inputs = RefCell::new(Once {
        inputs,
        first: 0,
        kept: None,
    });
    Shared::Owned(Box::new(Driven::new(integrator, inputs)))
}

/// A path of a system with inputs, without their values.
#[must_use = "a system with inputs needs their values: `.inputs(|step, state| …)`"]
pub struct NeedsInputs<'a, S: WithInputs, R, W> {
    integrator: &'a Integrator<S, R>,
    state: StateOf<S>,
    h: f64,
    noise: W,
}

impl<S: WithInputs, R, W> fmt::Debug for NeedsInputs<'_, S, R, W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NeedsInputs")
            .field("h", &self.h)
            .finish_non_exhaustive()
    }
}

/// Does not compile, and names the call that does: [`inputs`](NeedsInputs::inputs).
impl<S: WithInputs + StepsWithoutInputs, R, W> Iterator for NeedsInputs<'_, S, R, W> {
    type Item = Result<StateOf<S>, StepError>;

    fn next(&mut self) -> Option<Self::Item> {
        Some(S::step(&mut self.state).map(|()| self.state.clone()))
    }
}

/// As the methods of its iterator, whose errors would not name the call that compiles.
impl<S: WithInputs, R, W> NeedsInputs<'_, S, R, W> {
    #[doc(hidden)]
    pub fn last(self) -> Option<Result<StateOf<S>, StepError>>
    where
        S: StepsWithoutInputs,
    {
        Iterator::last(self)
    }

    #[doc(hidden)]
    pub fn nth(&mut self, step: usize) -> Option<Result<StateOf<S>, StepError>>
    where
        S: StepsWithoutInputs,
    {
        Iterator::nth(self, step)
    }

    #[doc(hidden)]
    pub fn take(self, steps: usize) -> Take<Self>
    where
        S: StepsWithoutInputs,
    {
        Iterator::take(self, steps)
    }
}

impl<'a, S: WithInputs, R, W: Noise> NeedsInputs<'a, S, R, W> {
    /// Returns the states after each step, with the inputs that a function returns for the number
    /// of a step, from 0, and the state at its start. A table is `|step, _| table[step as usize]`;
    /// it needs an entry for each step that is made. Where the function panics, as beyond the end
    /// of a table, the path ends with [`StepError::Inputs`].
    ///
    /// A function of the state is a feedback, which does not see the increments of its step. Where
    /// such an input multiplies increments, the limit h → 0 is that of Itô in the input, and no
    /// order of convergence is claimed. Against a feedback without hold a step is late by h/2, an
    /// error of order 1: continuous friction belongs into `#[force]`.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A pendulum with a motor at its pivot.
    /// struct Pendulum { g: f64, sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Pendulum {
    ///     fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 {
    ///         0.5 * v * v + self.g * q.cos() + u * q
    ///     }
    ///     #[gamma]
    ///     fn shake(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// // the motor holds the pendulum upright, against gravity and noise
    /// let pendulum = Integrator::new(Pendulum { g: 9.8, sigma: 0.1 }, Midpoint);
    /// let path = pendulum
    ///     .trajectory(State::new([3.0], [0.0]), 0.01, Wiener::new(1))
    ///     .inputs(|_, state| -40.0 * (state.q[0] - std::f64::consts::PI) - 8.0 * state.p[0]);
    /// let end = path.take(1000).last().unwrap()?;
    /// assert!((end.q[0] - std::f64::consts::PI).abs() < 0.1);
    /// # Ok(())
    /// # }
    /// ```
    pub fn inputs<F>(self, inputs: F) -> DrivenTrajectory<'a, S, R, W, F>
    where
        R: Copy + Rule<S::Held<'a>>,
        F: FnMut(u64, &StateOf<S>) -> S::Input,
        Holding<'a, S, R>: OneStepMethod<System = S::Held<'a>>,
    {
        let method = driven(self.integrator, inputs);
        Trajectory::new(method, self.state, self.h, self.noise)
    }
}

/// A trajectory of a system with inputs. It has the options of all trajectories, and a
/// [`gradient`](Trajectory::gradient) by the inputs of each step.
///
/// A loss of the inputs themselves, such as their squares, is added by the caller. A loss that
/// reads the input as a parameter of the state, `u[0]`, sees that of the step before the state, and
/// at the present state that of the step behind it. An event within a step does not change its
/// inputs.
///
/// ```
/// use sve_runtime::prelude::*;
///
/// /// A particle that is pushed.
/// struct Particle;
///
/// #[variational(midpoint)]
/// impl Particle {
///     fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 { 0.5 * v * v + u * q }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let particle = Integrator::new(Particle, Midpoint);
/// let path = particle.trajectory(State::new([0.0], [0.0]), 0.1, NoNoise).inputs(|_, _| 1.0);
/// let place = path.gradient(10, |k, state| (k == 10).then(|| state.q[0]))?;
/// // ∂q_N/∂u_k = h² (N − k − ½)
/// for (k, by_input) in place.inputs().enumerate() {
///     assert!((by_input[0] - 0.01 * (9.5 - k as f64)).abs() < 1e-14);
/// }
/// # Ok(())
/// # }
/// ```
pub type DrivenTrajectory<'a, S, R, W, F> =
    Trajectory<'a, Driven<'a, S, R, RefCell<Once<F, <S as WithInputs>::Numbers>>>, W>;

/// A function of inputs that is called once a step. Where steps are made again, the inputs are
/// kept.
#[doc(hidden)]
pub struct Once<F, N> {
    inputs: F,
    /// The first step whose inputs are kept.
    first: u64,
    kept: Option<Vec<N>>,
}

impl<S, F> Source<S> for RefCell<Once<F, S::Numbers>>
where
    S: WithInputs,
    F: FnMut(u64, &StateOf<S>) -> S::Input,
{
    fn numbers(&self, _: u64, step: u64, state: &StateOf<S>) -> S::Numbers {
        let Once {
            inputs,
            first,
            kept,
        } = &mut *self.borrow_mut();
        let place = (step - *first) as usize;
        if let Some(numbers) = kept.as_ref().and_then(|kept| kept.get(place)) {
            return *numbers;
        }
        let numbers = S::numbers(&inputs(step, state));
        if let Some(kept) = kept {
            kept.push(numbers);
        }
        numbers
    }

    fn keep(&self, first: u64) {
        let once = &mut *self.borrow_mut();
        (once.first, once.kept) = (first, Some(Vec::new()));
    }
}
