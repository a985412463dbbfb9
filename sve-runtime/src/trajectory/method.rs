//! Methods with trajectories.

use crate::error::StepError;
use crate::integrator::Integrator;
use crate::integrator::steps::Steps;
use crate::method::OneStepMethod;
use crate::noise::Noise;
use crate::rule::Rule;
use crate::system::{AnySystem, IncrementsOf, StateOf, System};
use crate::trajectory::{Snapshot, Trajectory};

/// A [`OneStepMethod`] that takes one increment for each Wiener process. Its steps can be divided,
/// at events or where they fail, and code for any method asks for it.
///
/// All methods take such increments, except rules with stage noise, which ensembles and studies run
/// too.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no method with one increment for each Wiener process",
    note = "steps that are divided, at an event or where they fail, have one increment for each process: use the rule without stage noise",
    note = "they are for systems of fixed sizes; a system whose `q` is a slice has single steps and trajectories, so far"
)]
pub trait Method:
    OneStepMethod<System: System, Increments = IncrementsOf<<Self as OneStepMethod>::System>>
{
    /// Makes one step of length `h` with the given Wiener increments, one for each process in
    /// source order.
    ///
    /// # Errors
    /// A [`StepError`] if an input is not finite, `h` is zero, or the step fails; `state` is then
    /// unchanged.
    #[inline]
    fn step(
        &self,
        state: &mut StateOf<Self::System>,
        h: f64,
        dw: &IncrementsOf<Self::System>,
    ) -> Result<(), StepError> {
        let prepared = self.prepare(h)?;
        self.step_prepared(&prepared, state, h, dw)
    }

    /// Returns the states after each step of length `h` from `state`, without end, or to the end of
    /// a recorded path.
    ///
    /// State number `k` (from 1) has time `t₀ + k h`, rounded once. The first step has the
    /// increments of step 0 of the noise, for every time of `state`. To continue after `k` steps of
    /// a path, give [`noise.from_step(k)`](crate::noise::Replayable::from_step), or
    /// [`resume`](Self::resume) a snapshot.
    fn trajectory<W: Noise>(
        &self,
        state: StateOf<Self::System>,
        h: f64,
        noise: W,
    ) -> Trajectory<'_, Self, W>
    where
        Self: Sized,
    {
        Trajectory::new(self, state, h, noise)
    }

    /// Continues the trajectory of a [`Snapshot`], with the bits of a trajectory that was not
    /// interrupted.
    ///
    /// System, method and noise have to be the same as for the first trajectory. A trajectory
    /// borrows its method, so the method does not change between its steps, and some rules carry
    /// results that the next step would compute again, such as the force at the end of a step. A
    /// snapshot with such numbers is refused if a parameter, a formula or an option has another
    /// value than at the snapshot. A snapshot without them, of [`Midpoint`](crate::Midpoint) for
    /// example, continues with the present parameters. To change parameters along a path, begin a
    /// [`trajectory`](Self::trajectory) at the state of the snapshot. The noise starts from its
    /// beginning, since the snapshot contains the number of the step; a source whose increments
    /// [follow one another](crate::noise::FromRng) has to be in the same state as at the snapshot.
    /// A refined trajectory needs [`refine`](Trajectory::refine) again; a
    /// [compensated](Trajectory::compensated) one continues to be compensated.
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
    /// let pendulum = Integrator::new(Pendulum { g: 9.8, sigma: 0.1 }, Midpoint);
    /// let start = State::new([1.0], [0.0]);
    /// let mut path = pendulum.trajectory(start, 0.01, Wiener::new(7)).compensated();
    /// path.nth(999).unwrap()?;
    /// let snapshot = path.snapshot(); // with the feature `serde`, into a file and back
    ///
    /// let mut continued = pendulum.resume(snapshot, Wiener::new(7))?;
    /// assert_eq!(continued.step(), 1000);
    /// for _ in 0..1000 {
    ///     assert_eq!(continued.next().unwrap()?, path.next().unwrap()?);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`StepError::OtherSteps`] for a snapshot with numbers that were carried by steps of another
    /// method or of other parameters; [`StepError::Uncompensated`] for a snapshot of a compensated
    /// trajectory, if this method makes no such steps.
    fn resume<W: Noise>(
        &self,
        snapshot: Snapshot<StateOf<Self::System>>,
        noise: W,
    ) -> Result<Trajectory<'_, Self, W>, StepError>
    where
        Self: Sized,
    {
        Trajectory::resume(self, snapshot, noise)
    }
}

// The message of the trait says more than the message of the increments.
#[diagnostic::do_not_recommend]
impl<I> Method for I where
    I: OneStepMethod<System: System, Increments = IncrementsOf<<I as OneStepMethod>::System>>
{
}

/// The functions of [`Method`], for programs that do not import the trait.
impl<S, R> Integrator<S, R>
where
    S: AnySystem,
    S::Kind: Steps<S::Target, R>,
    R: Rule<S::Target>,
{
    /// Returns the states after each step of length `h` from `state`; see
    /// [`Method::trajectory`](crate::Method::trajectory).
    ///
    #[doc = include_str!("../example.md")]
    /// for state in pendulum.trajectory(start, 0.01, Wiener::new(42)).take(100) {
    ///     let state = state?;
    ///     println!("{} {}", state.t, state.q[0]);
    /// }
    #[doc = include_str!("../example_end.md")]
    pub fn trajectory<W: Noise>(
        &self,
        state: StateOf<S>,
        h: f64,
        noise: W,
    ) -> Trajectory<'_, Self, W> {
        Trajectory::new(self, state, h, noise)
    }

    /// Continues a trajectory from a snapshot; see [`Method::resume`](crate::Method::resume).
    ///
    /// # Errors
    /// As [`Method::resume`](crate::Method::resume).
    pub fn resume<W: Noise>(
        &self,
        snapshot: Snapshot<StateOf<S>>,
        noise: W,
    ) -> Result<Trajectory<'_, Self, W>, StepError> {
        Trajectory::resume(self, snapshot, noise)
    }
}
