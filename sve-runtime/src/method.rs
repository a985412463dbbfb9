//! One-step methods: what a trajectory can be made of.

use core::any::type_name;
use core::hash::Hasher;

use crate::Integrator;
use crate::configuration::Coordinates;
use crate::error::StepError;
use crate::lanes::{ALL, Lane, Mask, StateLanes};
use crate::newton::{Newton, Solver};
use crate::noise::Noise;
use crate::plan::StrongOrder;
use crate::snapshot::Snapshot;
use crate::state::State;
use crate::step::{check_step_size, compensated_step, solve_step};
use crate::system::{
    Dims, IncrementLanesOf, IncrementsOf, StateLanesOf, StateOf, System, Variational,
};
use crate::trajectory::{CompensatedStep, Trajectory};

/// A one-step method for a system: an [`Integrator`] or a [`baseline`](crate::baseline).
pub trait Method {
    /// The system it integrates.
    type System: System;
    /// What depends on parameters and step size alone.
    type Prepared: Clone;

    /// The system it integrates.
    fn system(&self) -> &Self::System;

    /// Checks the step size and computes what depends on it alone.
    ///
    /// # Errors
    /// [`StepError::StepSize`] unless `h` is positive and finite.
    fn prepare(&self, h: f64) -> Result<Self::Prepared, StepError>;

    /// One step from what [`prepare`](Self::prepare) returned for the same `h`.
    ///
    /// # Errors
    /// A [`StepError`] when the step fails; `state` is then unchanged.
    fn step_prepared(
        &self,
        prepared: &Self::Prepared,
        state: &mut StateOf<Self::System>,
        h: f64,
        dw: &IncrementsOf<Self::System>,
    ) -> Result<(), StepError>;

    /// One step of each lane from `states` to `next` where the fast path solves it; the lanes whose states are the same in
    /// `next`, which [`step_prepared`](Self::step_prepared) has to step, or to say why not. Without an own form, all of them.
    ///
    /// Times in `next` are left alone: they are the same function of the number of steps for all, and the caller's.
    #[inline(always)]
    fn step_lanes(
        &self,
        prepared: &Self::Prepared,
        states: &StateLanesOf<Self::System>,
        next: &mut StateLanesOf<Self::System>,
        h: f64,
        dw: &IncrementLanesOf<Self::System>,
    ) -> Mask {
        let _ = (prepared, h, dw);
        next.clone_from(states);
        ALL
    }

    /// Feeds to a hasher what besides system, step size and increments determines the steps: the method's name and options. Shards and
    /// checkpoints of ensembles know by it whether they are of one method.
    ///
    /// Without an own form, the name of the type: a method with options has to add them.
    fn identify(&self, to: &mut dyn Hasher) {
        // arguments of the type are the system, which has an identity of its own
        let name = type_name::<Self>();
        to.write(name.split('<').next().unwrap_or(name).as_bytes());
    }

    /// Newton iterations that a step from here takes, the most of its blocks: 0 where its equations are explicit or linear.
    /// `None` where the method does not tell, or the step fails.
    ///
    /// For measurements: it costs several steps, and a step itself counts nothing.
    fn newton_iterations(
        &self,
        prepared: &Self::Prepared,
        state: &StateOf<Self::System>,
        h: f64,
        dw: &IncrementsOf<Self::System>,
    ) -> Option<u32> {
        let _ = (prepared, state, h, dw);
        None
    }

    /// The order of convergence at a fixed time, where the method tells: with noise the strong one, without the deterministic one.
    fn order(&self) -> Option<f64> {
        None
    }

    /// One step of length `h` with the given Wiener increments, one a process in source order.
    ///
    /// # Errors
    /// A [`StepError`] when an input is not finite, `h ≤ 0`, or the step fails; `state` is then unchanged.
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

    /// The states after each step of length `h` from `state`, without end (or to the end of a recorded path).
    ///
    /// The state number `k` (from 1) has time `t₀ + k h`, rounded once. The first step has the increments of step 0 of the noise,
    /// whatever the time of `state`: to go on after `k` steps of a path, give [`noise.from_step(k)`](crate::noise::Replayable::from_step), or
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

    /// Continues the trajectory that a [`Snapshot`] was taken of, with the bits of one that was not interrupted.
    ///
    /// System, method and noise have to be those of the first trajectory; the noise from its beginning, since the snapshot knows the number of
    /// the step. A source whose increments [follow one another](crate::noise::FromRng) has to be in the state that it had then.
    /// A trajectory that was [refined](Trajectory::refine) has to be told so again; one that was
    /// [compensated](Trajectory::compensated) continues so.
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
    /// let mut path = pendulum.trajectory(State::new([1.0], [0.0]), 0.01, Wiener::new(7)).compensated();
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
    /// [`StepError::Uncompensated`] for a snapshot of a compensated trajectory, where this method makes no such steps.
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

    /// The step that carries the low parts of the state, where there is one.
    #[doc(hidden)]
    fn compensated_step(&self) -> Option<CompensatedStep<Self>>
    where
        Self: Sized,
    {
        None
    }
}

impl<S, R, Q, const N: usize, const M: usize> Method for Integrator<S, R>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    type System = S;
    type Prepared = S::Prepared;

    fn system(&self) -> &S {
        Integrator::system(self)
    }

    #[inline]
    fn prepare(&self, h: f64) -> Result<S::Prepared, StepError> {
        check_step_size(h)?;
        Ok(Integrator::system(self).prepare(h))
    }

    #[inline]
    fn step_prepared(
        &self,
        prepared: &S::Prepared,
        state: &mut State<Q>,
        h: f64,
        dw: &[f64; M],
    ) -> Result<(), StepError> {
        Q::in_coordinates(state, |state| {
            solve_step(self, prepared, state, h, dw).map(|_| ())
        })
    }

    #[inline(always)]
    fn step_lanes(
        &self,
        prepared: &S::Prepared,
        states: &StateLanes<N>,
        next: &mut StateLanes<N>,
        h: f64,
        dw: &[Lane; M],
    ) -> Mask {
        Integrator::system(self).increment_lanes(prepared, states, next, h, dw, self.newton())
    }

    fn compensated_step(&self) -> Option<CompensatedStep<Self>> {
        (!S::RETURNS.is_state()).then_some(compensated_step as CompensatedStep<Self>)
    }

    fn identify(&self, to: &mut dyn Hasher) {
        to.write(type_name::<R>().as_bytes());
        // the printed form of a number is the shortest that gives it back
        to.write(format!("{:?}", self.newton()).as_bytes());
    }

    /// The lowest limit with which the step gives the same bits: a guess that fails for want of iterations is replaced, and leads
    /// to the root along another way.
    fn order(&self) -> Option<f64> {
        let plan = self.plan();
        Some(match plan.strong_order {
            StrongOrder::Deterministic => f64::from(plan.deterministic_order),
            StrongOrder::One => 1.0,
            StrongOrder::Half { .. } => 0.5,
        })
    }

    fn newton_iterations(
        &self,
        prepared: &S::Prepared,
        state: &State<Q>,
        h: f64,
        dw: &[f64; M],
    ) -> Option<u32> {
        let state = &state.to_coordinates();
        let increment = |max_iterations| {
            let newton = Newton {
                max_iterations,
                ..*self.newton()
            };
            let (q, p, _) = Integrator::system(self)
                .increment(prepared, state, h, dw, &Solver::new(&newton))
                .ok()?;
            Some((q, p))
        };
        let most = self.newton().max_iterations;
        let step = increment(most)?;
        (0..=most).find(|&limit| increment(limit) == Some(step))
    }
}
