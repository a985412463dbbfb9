//! Steps and trajectories of systems with a time scale.
//!
//! Invariant: a trajectory holds the energy of its start. Its steps have equal lengths in τ, and
//! its states have the time t.

use super::{Snapshot, Trajectory};
use crate::error::StepError;
use crate::integrator::Integrator;
use crate::integrator::time_scale::InScaledTime;
use crate::mechanics::time_scale::{TimeScale, TimedState, WithTimeScale};
use crate::method::{OneStepMethod, Shared};
use crate::noise::Noise;
use crate::rule::Rule;
use crate::system::{ConfigurationOf, StateOf};

/// Steps and trajectories of systems with a time scale, `#[time_scale]`.
pub trait ScaledPaths<S: WithTimeScale, R> {
    /// Makes one step of length `h` in τ. The state gets the time that it takes, h Σ bᵢ s(Qᵢ) over
    /// the nodes of the rule.
    ///
    /// # Errors
    /// A [`StepError`] if the step fails, [`StepError::TimeScale`] if s is not positive and finite
    /// at a node; `state` is then unchanged.
    fn step<'a>(
        &'a self,
        state: &mut TimedState<ConfigurationOf<S>>,
        h: f64,
        dw: &<R as Rule<S::Held<'a>>>::Increments,
    ) -> Result<(), StepError>
    where
        R: Rule<S::Held<'a>>,
        InScaledTime<<S as WithTimeScale>::Held<'a>, R>:
            OneStepMethod<System = S::Held<'a>, Increments = <R as Rule<S::Held<'a>>>::Increments>;

    /// Returns the states after each step of length `h` in τ. [`until`](Trajectory::until),
    /// [`at`](Trajectory::at) and events act on the time t.
    fn trajectory<'a, W: Noise>(
        &'a self,
        state: TimedState<ConfigurationOf<S>>,
        h: f64,
        noise: W,
    ) -> ScaledTrajectory<'a, S, R, W>
    where
        R: Rule<S::Held<'a>>,
        InScaledTime<<S as WithTimeScale>::Held<'a>, R>: OneStepMethod<System = S::Held<'a>>;

    /// Continues a trajectory of an energy from a snapshot, with its bits.
    ///
    /// # Errors
    /// As [`Method::resume`](crate::Method::resume).
    fn resume<'a, W: Noise>(
        &'a self,
        snapshot: Snapshot<StateOf<S>>,
        energy: f64,
        noise: W,
    ) -> Result<ScaledTrajectory<'a, S, R, W>, StepError>
    where
        R: Rule<S::Held<'a>>,
        InScaledTime<<S as WithTimeScale>::Held<'a>, R>: OneStepMethod<System = S::Held<'a>>;
}

/// A trajectory of a system with a time scale. Its states have the time t; the energy of its path
/// is [`energy`](Trajectory::energy).
///
/// A time within a step is reached by a part of the step, whose length in τ is found by iteration.
/// [`TimedState::on_path`] continues from one of its states, and
/// [`tolerance`](Trajectory::tolerance) adapts the steps of τ. Steps that fail are not refined, and
/// events do not change the state, since its energy would be another one.
pub type ScaledTrajectory<'a, S, R, W> =
    Trajectory<'a, InScaledTime<<S as WithTimeScale>::Held<'a>, R>, W>;

impl<S: WithTimeScale, R: Copy> ScaledPaths<S, R> for Integrator<S, R> {
    fn step<'a>(
        &'a self,
        state: &mut TimedState<ConfigurationOf<S>>,
        h: f64,
        dw: &<R as Rule<S::Held<'a>>>::Increments,
    ) -> Result<(), StepError>
    where
        R: Rule<S::Held<'a>>,
        InScaledTime<<S as WithTimeScale>::Held<'a>, R>:
            OneStepMethod<System = S::Held<'a>, Increments = <R as Rule<S::Held<'a>>>::Increments>,
    {
        let method = self.in_scaled_time(state.energy());
        method.next_step(&mut method.prepare(h)?, &mut state.state, h, dw)
    }

    fn trajectory<'a, W: Noise>(
        &'a self,
        state: TimedState<ConfigurationOf<S>>,
        h: f64,
        noise: W,
    ) -> ScaledTrajectory<'a, S, R, W>
    where
        R: Rule<S::Held<'a>>,
        InScaledTime<<S as WithTimeScale>::Held<'a>, R>: OneStepMethod<System = S::Held<'a>>,
    {
        let method = self.in_scaled_time(state.energy());
        let method = Shared::Owned(Box::new(method));
        Trajectory::new(method, state.into_state(), h, noise)
    }

    fn resume<'a, W: Noise>(
        &'a self,
        snapshot: Snapshot<StateOf<S>>,
        energy: f64,
        noise: W,
    ) -> Result<ScaledTrajectory<'a, S, R, W>, StepError>
    where
        R: Rule<S::Held<'a>>,
        InScaledTime<<S as WithTimeScale>::Held<'a>, R>: OneStepMethod<System = S::Held<'a>>,
    {
        let method = Shared::Owned(Box::new(self.in_scaled_time(energy)));
        Trajectory::resume(method, snapshot, noise)
    }
}

impl<H: TimeScale, R, W, K> Trajectory<'_, InScaledTime<H, R>, W, K>
where
    InScaledTime<H, R>: OneStepMethod,
{
    /// Returns the energy of the path, that of its start.
    pub fn energy(&self) -> f64 {
        self.method.energy()
    }
}
