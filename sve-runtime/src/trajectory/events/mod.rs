//! Sections and events: the states along a trajectory at which a function of the state is zero.
//!
//! Input: a trajectory and functions of the system and a state. Output: the states at which a
//! function changes its sign, or the states of a trajectory that ends or is changed there.
//! Invariant: a state within a step is the step solved anew with a part of its length, on the same
//! path of the noise; the states after whole steps keep their bits until a change.
//!
//! Source: the idea of M. Hénon, *On the numerical computation of Poincaré maps*, Physica D 5
//! (1982) 412–414, with the step itself in place of a second method: the state has the accuracy of
//! the rule, and the part of the step is symplectic as the whole.

mod function;
mod rest;
mod root;
mod search;
mod states;

pub use states::WithoutEvents;

pub(super) use root::zero_between;

use std::collections::VecDeque;

use self::function::{Action, Direction, EventFunction, Function};
use super::{EqualSteps, StepKind, Trajectory, WholeSteps};
use crate::error::StepError;
use crate::error::observed::Observed;
use crate::method::OneStepMethod;
use crate::noise::{Halves, Noise};
use crate::system::StateOf;
use crate::trajectory::Method;

/// The events along a trajectory, from [`Trajectory::crossings`], [`Trajectory::stop_at`] and
/// [`Trajectory::change_at`].
///
/// An iterator over states. After [`crossings`](Self::crossings) it yields the states at the zeros
/// of these functions, otherwise the states after each step and the state at a stop. Several
/// functions are added one after another; [`rising`](Self::rising), [`falling`](Self::falling) and
/// [`angle`](Self::angle) apply to the function that was added last, and [`event`](Self::event)
/// returns the number of the function to which the last state belongs.
///
/// ```
/// use sve_runtime::prelude::*;
///
/// /// A ball above a floor.
/// struct Ball { g: f64 }
///
/// #[variational(stormer_verlet)]
/// impl Ball {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - self.g * q }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let ball = Integrator::new(Ball { g: 9.8 }, StormerVerlet);
/// let mut bounces = 0;
/// let path = ball
///     .trajectory(State::new([1.0], [0.0]), 0.01, NoNoise)
///     .change_at(|_, ball| ball.q[0], |_, ball| { ball.p[0] *= -0.9; bounces += 1; })
///     .falling()
///     .stop_at(|_, ball| ball.t - 2.5);
/// let states = path.collect::<Result<Vec<_>, _>>()?;
/// let end = states.last().unwrap();
/// assert!((end.t - 2.5).abs() < 1e-15 && states.iter().all(|ball| ball.q[0] > -1e-12));
/// assert_eq!(bounces, 3);
/// # Ok(())
/// # }
/// ```
///
/// **Detected zeros.** A function is evaluated after each step, or at more points of each step with
/// [`samples`](Self::samples). A zero between two of these points is found if the function has
/// different signs at them. Two zeros between them are not detected, and of three zeros one is
/// found: take smaller steps or more samples if a function returns so fast. A function that is 0 at
/// the start, exactly or up to rounding, has no crossing at the start, so that a path may begin at
/// the event of another one: a zero within 2⁻²⁴ of the first step does not count. A value of
/// exactly 0 after a step is a crossing at that step.
///
/// **Accuracy.** The step is solved anew with a part θh of its length until the function is zero to
/// rounding. So the state is as accurate as a step of the rule: its error at an event in the first
/// step is of order 3 for `midpoint` and `stormer_verlet`, of order 2s + 1 for `gauss(s)`. An event
/// costs about five steps.
///
/// **With noise** the increment of the part comes from the Brownian bridge: the path within a step
/// is a function of seed, path and step, the same for every function, down to 2⁻³² of the step. A
/// function whose value moves with the noise itself, such as a momentum that the noise pushes, has
/// infinitely many zeros near each of its zeros. One of them is found. The source has to know its
/// path within steps, as [`Wiener`](crate::noise::Wiener) and [`NoNoise`](crate::noise::NoNoise)
/// do; a rule with [stage noise](crate::StageNoise) is a compile error. A
/// [refined](Trajectory::refine) trajectory has no events, since a step that fails has no part.
///
/// **After a change** the trajectory makes the rest of the step from the changed state, with the
/// rest of the increment, and then whole steps at the times that it would have had. The numbers
/// that the method carries from step to step are dropped, and so are the low parts of
/// [compensated](Trajectory::compensated) sums. The motion continues on the side given by the sign
/// of the function a little later, after 2⁻²⁴ of the step. Changes by one function within 2⁻¹² of a
/// step are an error: a ball that comes to rest on a floor has to be stopped before.
///
/// It dereferences to the [`Trajectory`], which is after the last whole step. A
/// [snapshot](Trajectory::snapshot) does not contain the functions: give them again.
pub struct Events<'a, I: OneStepMethod, W> {
    trajectory: Trajectory<'a, I, W>,
    functions: Vec<EventFunction<'a, I::System>>,
    /// True if the states after whole steps are yielded too, and not the states at crossings alone.
    yields_steps: bool,
    /// Number of parts of a step at whose ends the functions are evaluated.
    samples: u32,
    /// States found in the last step, with the number of the function.
    found: VecDeque<(StateOf<I::System>, Option<usize>)>,
    event: Option<usize>,
    /// The error of the last step. It is kept until the states found in this step have been
    /// yielded.
    failure: Option<StepError>,
    has_begun: bool,
    has_ended: bool,
}

impl<'a, I: OneStepMethod, W: Noise, K: StepKind<I, W>> Trajectory<'a, I, W, K> {
    /// Returns the states at which a function of the system and a state changes its sign, in place
    /// of the states after each step: a Poincaré section, for example.
    ///
    /// The function returns `f64` or `Result<f64, StepError>`. A value that is not finite is an
    /// error.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct HenonHeiles;
    ///
    /// #[variational(midpoint)]
    /// impl HenonHeiles {
    ///     fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
    ///         let [x, y] = q;
    ///         let potential = 0.5 * (x * x + y * y) + x * x * y - y * y * y / 3.0;
    ///         0.5 * (v[0] * v[0] + v[1] * v[1]) - potential
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let motion = Integrator::new(HenonHeiles, Midpoint);
    /// let path = motion.trajectory(State::new([0.0, 0.1], [0.4, 0.0]), 0.1, NoNoise);
    /// let section = path.crossings(|_, state| state.q[0]).rising();
    /// for state in section.take(10) {
    ///     let state = state?;
    ///     assert!(state.q[0].abs() < 1e-15 && state.p[0] > 0.0);
    ///     println!("{} {}", state.q[1], state.p[1]);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// [`Events`] describes which zeros are detected, and how accurate the states are.
    #[must_use]
    pub fn crossings<F, O>(self, function: F) -> Events<'a, I, W>
    where
        I: Method,
        W: Halves,
        K: WholeSteps,
        F: Fn(&I::System, &StateOf<I::System>) -> O + 'a,
        O: Observed,
    {
        Events::new(self.of_kind(EqualSteps)).crossings(function)
    }

    /// Ends the trajectory at the first zero of a function, with the state at this zero as its last
    /// state; see [`Events`].
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Pendulum { g: f64, sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Pendulum {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.g * q.cos() }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// // the time at which a noisy pendulum first is at half a radian
    /// let pendulum = Integrator::new(Pendulum { g: 1.0, sigma: 0.3 }, Midpoint);
    /// let path = pendulum.trajectory(State::new([0.0], [0.0]), 0.05, Wiener::new(1));
    /// let passage = path.stop_at(|_, state| state.q[0].abs() - 0.5).last().unwrap()?;
    /// assert!((passage.q[0].abs() - 0.5).abs() < 1e-12);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn stop_at<F, O>(self, function: F) -> Events<'a, I, W>
    where
        I: Method,
        W: Halves,
        K: WholeSteps,
        F: Fn(&I::System, &StateOf<I::System>) -> O + 'a,
        O: Observed,
    {
        Events::new(self.of_kind(EqualSteps)).stop_at(function)
    }

    /// Changes the state at each zero of a function: a ball that bounces, a kick at a place. The
    /// trajectory continues from the changed state; see [`Events`].
    ///
    /// The time of the state does not change. The change may lead back to the side from which the
    /// motion came, as a bounce does, or let the motion pass, as a kick does.
    ///
    #[doc = include_str!("../../example.md")]
    /// // a kick wherever the pendulum hangs down
    /// let path = pendulum.trajectory(start, 0.01, NoNoise);
    /// let kicked = path.change_at(|_, s| s.q[0], |_, s| s.p[0] *= 1.01);
    /// assert_eq!(kicked.take(100).count(), 100);
    #[doc = include_str!("../../example_end.md")]
    #[must_use]
    pub fn change_at<F, O, C>(self, function: F, change: C) -> Events<'a, I, W>
    where
        I: Method,
        W: Halves,
        K: WholeSteps,
        F: Fn(&I::System, &StateOf<I::System>) -> O + 'a,
        O: Observed,
        C: FnMut(&I::System, &mut StateOf<I::System>) + 'a,
    {
        Events::new(self.of_kind(EqualSteps)).change_at(function, change)
    }
}

impl<'a, I: Method, W: Halves> Events<'a, I, W> {
    fn new(trajectory: Trajectory<'a, I, W>) -> Self {
        Self {
            trajectory,
            functions: Vec::new(),
            yields_steps: true,
            samples: 1,
            found: VecDeque::new(),
            event: None,
            failure: None,
            has_begun: false,
            has_ended: false,
        }
    }

    fn with<F, O>(mut self, function: F, action: Action<'a, I::System>) -> Self
    where
        F: Fn(&I::System, &StateOf<I::System>) -> O + 'a,
        O: Observed,
    {
        let function: Function<'a, I::System> =
            Box::new(move |system, state| function(system, state).observed());
        self.functions.push(EventFunction::new(function, action));
        self
    }

    /// Yields the states at the zeros of one more function, and no longer the states after whole
    /// steps; see [`Trajectory::crossings`].
    ///
    #[doc = include_str!("../../example.md")]
    /// let path = pendulum.trajectory(start, 0.01, NoNoise);
    /// let mut events = path.crossings(|_, s| s.q[0]).crossings(|_, s| s.p[0]);
    /// events.next().expect("no end")?;
    /// assert_eq!(events.event(), Some(0)); // the angle is zero before the momentum is
    #[doc = include_str!("../../example_end.md")]
    #[must_use]
    pub fn crossings<F, O>(mut self, function: F) -> Self
    where
        F: Fn(&I::System, &StateOf<I::System>) -> O + 'a,
        O: Observed,
    {
        self.yields_steps = false;
        self.with(function, Action::Yield)
    }

    /// Ends at the first zero of one more function; see [`Trajectory::stop_at`]. If there are
    /// [`crossings`](Self::crossings), the state at the end is not yielded.
    ///
    #[doc = include_str!("../../example.md")]
    /// let path = pendulum.trajectory(start, 0.01, NoNoise);
    /// let path = path.crossings(|_, s| s.q[0]).stop_at(|_, s| s.t - 5.0);
    /// assert!(path.count() > 3);
    #[doc = include_str!("../../example_end.md")]
    #[must_use]
    pub fn stop_at<F, O>(self, function: F) -> Self
    where
        F: Fn(&I::System, &StateOf<I::System>) -> O + 'a,
        O: Observed,
    {
        self.with(function, Action::Stop)
    }

    /// Changes the state at each zero of one more function; see [`Trajectory::change_at`].
    ///
    #[doc = include_str!("../../example.md")]
    /// let mut kicks = 0;
    /// let path = pendulum.trajectory(start, 0.01, NoNoise).stop_at(|_, s| s.t - 5.0);
    /// path.change_at(|_, s| s.q[0], |_, _| kicks += 1).last();
    /// assert!(kicks > 3);
    #[doc = include_str!("../../example_end.md")]
    #[must_use]
    pub fn change_at<F, O, C>(self, function: F, change: C) -> Self
    where
        F: Fn(&I::System, &StateOf<I::System>) -> O + 'a,
        O: Observed,
        C: FnMut(&I::System, &mut StateOf<I::System>) + 'a,
    {
        const {
            assert!(
                !I::HAS_OWN_TIME,
                "a path of a system with a time scale stays on its energy, which a changed state does not have: let the path end at the event (`stop_at`), and begin another one from `TimedState::of`"
            );
        }
        self.with(function, Action::Change(Box::new(change)))
    }

    /// Counts only zeros at which the last function goes from negative to positive along the
    /// trajectory.
    ///
    #[doc = include_str!("../../example.md")]
    /// let mut path = pendulum.trajectory(start, 0.01, NoNoise).crossings(|_, s| s.q[0]).rising();
    /// assert!(path.next().expect("no end")?.p[0] > 0.0);
    #[doc = include_str!("../../example_end.md")]
    #[must_use]
    pub fn rising(mut self) -> Self {
        self.newest().direction = Direction::Rising;
        self
    }

    /// Counts only zeros at which the last function goes from positive to negative along the
    /// trajectory.
    ///
    #[doc = include_str!("../../example.md")]
    /// let mut path = pendulum.trajectory(start, 0.01, NoNoise).crossings(|_, s| s.q[0]).falling();
    /// assert!(path.next().expect("no end")?.p[0] < 0.0);
    #[doc = include_str!("../../example_end.md")]
    #[must_use]
    pub fn falling(mut self) -> Self {
        self.newest().direction = Direction::Falling;
        self
    }

    /// Treats the last function as an angle in radians: it is zero at every multiple of 2π, and a
    /// jump from near π to near −π is no zero.
    ///
    /// The angle may be reduced to a turn or count turns. It has to change by less than π between
    /// two points at which it is evaluated. Without this option, a function that jumps is an error.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Rotor;
    ///
    /// #[variational(midpoint)]
    /// impl Rotor {
    ///     fn lagrangian(&self, _q: f64, v: f64) -> f64 { 0.5 * v * v }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let rotor = Integrator::new(Rotor, Midpoint);
    /// let path = rotor.trajectory(State::new([1.0], [1.0]), 0.1, NoNoise);
    /// let turns = path.crossings(|_, state| state.q[0]).angle();
    /// for (k, state) in (1..=5).zip(turns) {
    ///     assert!((state?.q[0] - f64::from(k) * std::f64::consts::TAU).abs() < 1e-13);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn angle(mut self) -> Self {
        self.newest().is_angle = true;
        self
    }

    /// Evaluates the functions at the ends of so many equal parts of each step, to detect zeros
    /// that lie close together. Each further part costs a step.
    ///
    #[doc = include_str!("../../example.md")]
    /// // the pendulum is below 0.99 for a large part of each step: only samples detect the zeros
    /// let path = pendulum.trajectory(start, 2.0, NoNoise);
    /// let path = path.crossings(|_, s| s.q[0] - 0.99).samples(50);
    /// assert!(path.take(4).all(|state| state.is_ok()));
    #[doc = include_str!("../../example_end.md")]
    #[must_use]
    pub fn samples(mut self, samples: u32) -> Self {
        self.samples = samples.max(1);
        self
    }

    fn newest(&mut self) -> &mut EventFunction<'a, I::System> {
        self.functions
            .last_mut()
            .expect("events begin with a function")
    }

    /// Returns the number of the function, in the order in which they were given, whose zero is the
    /// last state; `None` if it is the state after a whole step.
    pub fn event(&self) -> Option<usize> {
        self.event
    }
}
