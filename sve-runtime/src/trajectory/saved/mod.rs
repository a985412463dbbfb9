//! The states of a trajectory that are saved: every n-th state, the states at given times, the
//! states up to a time.
//!
//! Input: a trajectory of any kind, and the points to save. Output: an iterator over the saved
//! states. Invariant: the trajectory makes its own steps, with its own bits. A state within a step
//! is computed separately, by a step of a part of the length, and does not affect the trajectory.

mod search;
mod write;

use core::borrow::Borrow;
use core::ops::Deref;
use std::collections::VecDeque;

use super::{StepKind, Trajectory};
use crate::method::OneStepMethod;
use crate::noise::Noise;
use crate::progress::Progress;
use crate::time::WrittenTimes;

/// Saved states of a trajectory, from [`Trajectory::every`], [`Trajectory::at`] and
/// [`Trajectory::until`].
///
/// An iterator over states, as the trajectory is. Times come out as one writes them: with h = 0.1
/// the third state is at 0.3, not at 0.30000000000000004. In detail, the time after `k` steps is
/// `t₀ + k h` with both as the decimal numbers that print them, if the sum has at most 15 digits,
/// and the rounded sum of the numbers themselves otherwise; a time that was asked for comes out
/// with its bits. A Lagrangian that depends on time sees t₀ + k h rounded once, as in a trajectory
/// that is not saved: `q` and `p` have the same bits.
///
/// **A time within a step** is reached by a step of a part of the length, from the last whole step,
/// on the same path of the noise. The trajectory does not notice it. The source has to know its
/// path within steps, as [`Wiener`](crate::noise::Wiener) and [`NoNoise`](crate::noise::NoNoise) do
/// ([`Halves`](crate::noise::Halves)); for other sources, and for a rule with [stage
/// noise](crate::StageNoise), the item is an error that says so. A time that is the end of a whole
/// step up to rounding counts as one.
///
/// [`to_csv`](Self::to_csv), `to_npy` and `to_parquet` write the states, with the names of the
/// coordinates; [`table`](Self::table) returns them. The states of a scene have no table:
/// `to_npy` and, for bodies, [`to_xyz`](Self::to_xyz) write them one by one, as they come.
///
/// It dereferences to the trajectory, which is after the last whole step.
#[derive(Debug)]
pub struct Saved<T> {
    path: T,
    times: WrittenTimes,
    wanted: Wanted,
    /// The time at which to end.
    end: Option<f64>,
    has_ended: bool,
    /// True if the progress is to be shown from the next state on.
    begins_progress: bool,
    progress: Option<Progress>,
}

/// The states that are saved.
#[derive(Clone, Debug)]
enum Wanted {
    /// From the step `next` on, one state for each `every` steps.
    Steps { next: u64, every: u64 },
    /// At these times.
    Times(VecDeque<f64>),
}

impl<I: OneStepMethod, W: Noise, K: StepKind<I, W>> Trajectory<'_, I, W, K> {
    /// Saves the present state of the trajectory, and every `n`-th state after it.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Pendulum { g: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Pendulum {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.g * q.cos() }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let pendulum = Integrator::new(Pendulum { g: 9.8 }, Midpoint);
    /// let start = State::new([1.0], [0.0]);
    /// let mut times = Vec::new();
    /// for state in pendulum.trajectory(start, 0.01, NoNoise).every(10).take(4) {
    ///     times.push(state?.t);
    /// }
    /// assert_eq!(times, [0.0, 0.1, 0.2, 0.3]);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// [`until`](Saved::until) ends it. If `n` is 0, the first item is the error
    /// [`StepError::SavedInterval`](crate::StepError::SavedInterval).
    #[must_use]
    pub fn every(self, n: u64) -> Saved<Self> {
        let next = self.step;
        Saved::new(self, Wanted::Steps { next, every: n })
    }

    /// Saves the states at these times, in the order in which the trajectory reaches them, and
    /// ends.
    ///
    /// A time between two steps is reached by a step of a part of the length, on the same path of
    /// the noise; see [`Saved`]. This part is not [refined](Self::refine). The time of the start is
    /// allowed.
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
    /// let path = || pendulum.trajectory(State::new([1.0], [0.0]), 0.1, Wiener::new(1));
    /// let states = path().at([0.0, 0.3, 0.75, 2.0]).collect::<Result<Vec<_>, _>>()?;
    /// assert_eq!(states[2].t, 0.75);
    /// // the trajectory is that without the state within a step
    /// assert_eq!(states[3].q, path().nth(19).unwrap()?.q);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn at<T: Borrow<f64>>(self, times: impl IntoIterator<Item = T>) -> Saved<Self> {
        let times = times.into_iter().map(|t| *t.borrow()).collect();
        Saved::new(self, Wanted::Times(times))
    }

    /// Ends the trajectory at a time, with the state at this time as its last state.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Pendulum { g: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Pendulum {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.g * q.cos() }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let pendulum = Integrator::new(Pendulum { g: 9.8 }, Midpoint);
    /// let path = || pendulum.trajectory(State::new([1.0], [0.0]), 0.1, NoNoise);
    /// let states = path().until(1.0).collect::<Result<Vec<_>, _>>()?;
    /// assert_eq!((states.len(), states[2].t, states[9].t), (10, 0.3, 1.0));
    /// // the last step is a part of one
    /// assert_eq!(path().until(0.55).last().unwrap()?.t, 0.55);
    /// // with the start, and fewer states
    /// let states = path().every(5).until(1.0).collect::<Result<Vec<_>, _>>()?;
    /// assert_eq!((states[0].t, states[1].t, states[2].t), (0.0, 0.5, 1.0));
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn until(self, t: f64) -> Saved<Self> {
        let next = self.step + 1;
        Saved::new(self, Wanted::Steps { next, every: 1 }).until(t)
    }
}

impl<'a, I: OneStepMethod, W: Noise, K: StepKind<I, W>> Saved<Trajectory<'a, I, W, K>> {
    fn new(path: Trajectory<'a, I, W, K>, wanted: Wanted) -> Self {
        Self {
            times: path.times(),
            path,
            wanted,
            end: None,
            has_ended: false,
            begins_progress: false,
            progress: None,
        }
    }

    /// Ends at a time. The state at this time is the last one, even if it would not be saved
    /// otherwise.
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
    /// let start = State::from_velocity(rotor.system(), [0.0], [1.0])?;
    /// let mut times = Vec::new();
    /// for state in rotor.trajectory(start, 0.1, NoNoise).every(4).until(1.0) {
    ///     times.push(state?.t);
    /// }
    /// assert_eq!(times, [0.0, 0.4, 0.8, 1.0]);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn until(mut self, t: f64) -> Self {
        self.end = Some(t);
        self
    }

    /// Shows how many of the states are saved, on standard error if it is a terminal, with the
    /// feature `progress` as a bar. Without an end, from [`at`](Trajectory::at) or
    /// [`until`](Self::until), nothing is shown.
    ///
    #[doc = include_str!("../../example.md")]
    /// let path = pendulum.trajectory(start, 0.1, NoNoise).every(2).until(1.0);
    /// assert_eq!(path.progress(true).count(), 6);
    #[doc = include_str!("../../example_end.md")]
    #[must_use]
    pub fn progress(mut self, shown: bool) -> Self {
        self.begins_progress = shown;
        self
    }
}

impl<T> Deref for Saved<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.path
    }
}
