//! Trajectories that divide a failing step into smaller steps on the same path.

use super::{FixedSteps, Method, RefinedSteps, StepKind, Trajectory};
use crate::error::StepError;
use crate::method::{OneStepMethod, Within};
use crate::noise::{DyadicInterval, Halves, Noise};
use crate::system::{Increments, StateOf};

/// The numbers of refined steps of a trajectory, see [`Trajectory::refine`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Refinements {
    /// Number of refined steps.
    pub steps: u64,
    /// Number of halvings of the smallest part of any step.
    pub deepest: u32,
}

/// A trajectory that refines steps that fail, from [`Trajectory::refine`].
pub type RefinedTrajectory<'a, I, W> = Trajectory<'a, I, W, RefinedSteps>;

impl<'a, I: OneStepMethod, W: Noise, K: StepKind<I, W>> Trajectory<'a, I, W, K> {
    /// Refines steps that fail: divides such a step into two halves on the same path, and divides
    /// each half that fails in the same way, up to `depth` times.
    ///
    /// The increments of the halves come from a Brownian bridge, a pure function of seed, path,
    /// step and interval, so a repeated trajectory has the same bits. It yields the states after
    /// steps of length `h`, at the same times as without refinement.
    /// [`refinements`](Self::refinements) counts the refined steps. If the smallest parts fail too,
    /// the error belongs to the first of them.
    ///
    /// The path determines which steps are refined, so the states no longer have exactly the
    /// distribution of the rule. Refinement is for rare failures. If the count grows with the
    /// number of steps, take a smaller `h`.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A pendulum with noise of fourth degree in the momentum: for a large ΔW the step has no
    /// /// solution.
    /// struct Rotor;
    ///
    /// #[variational(midpoint)]
    /// impl Rotor {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + q.cos() }
    ///     #[h1]
    ///     fn jitter(&self, _q: f64, p: f64) -> f64 { 0.1 * p.powi(4) }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let rotor = Integrator::new(Rotor, Midpoint);
    /// let start = State::new([0.0], [2.0]);
    /// let plain = rotor.trajectory(start, 0.5, Wiener::new(1)).take(1000).last().unwrap();
    /// assert!(matches!(plain, Err(StepError::BranchLost { .. })));
    ///
    /// let mut path = rotor.trajectory(start, 0.5, Wiener::new(1)).refine(16);
    /// for _ in 0..1000 {
    ///     path.next().unwrap()?;
    /// }
    /// println!("{:?}", path.refinements());
    /// assert!(path.refinements().steps > 0);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn refine(self, depth: u32) -> RefinedTrajectory<'a, I, W>
    where
        I: Method,
        W: Halves,
        K: FixedSteps,
    {
        const {
            assert!(
                !I::HAS_OWN_TIME,
                "steps of a system with a time scale are not refined, since parts of a step keep no structure: take a smaller h, or another time scale"
            );
        }
        self.of_kind(RefinedSteps { depth })
    }
}

impl<I: Method, W: Halves> StepKind<I, W> for RefinedSteps {
    /// Makes a step that failed with `error` in smaller steps.
    #[cold]
    #[inline(never)]
    fn retry(
        self,
        trajectory: &mut RefinedTrajectory<'_, I, W>,
        error: StepError,
        dw: &I::Increments,
    ) -> Result<(), StepError> {
        let mut state = trajectory.state;
        let halving = Halving {
            method: trajectory.within(),
            noise: &trajectory.noise,
            depth: self.depth,
        };
        let whole = DyadicInterval::whole(trajectory.step);
        let deepest = halving.step(error, whole, trajectory.h, dw, &mut state)?;
        trajectory.state = state;
        let made = &mut trajectory.refinements;
        made.steps += 1;
        made.deepest = made.deepest.max(deepest);
        Ok(())
    }
}

/// Makes a step that failed in two halves, and divides each half that fails in the same way.
pub(crate) struct Halving<'a, I: OneStepMethod, W: ?Sized> {
    pub(crate) method: Within<'a, I>,
    pub(crate) noise: &'a W,
    /// Largest number of halvings of a step.
    pub(crate) depth: u32,
}

impl<I: OneStepMethod<Increments: Increments>, W: Halves + ?Sized> Halving<'_, I, W> {
    /// Makes the step over an interval, which failed with `error`, in two halves. Returns the
    /// number of halvings of the smallest part. After an error the state lies between two parts.
    pub(crate) fn step(
        &self,
        error: StepError,
        interval: DyadicInterval,
        h: f64,
        dw: &I::Increments,
        state: &mut StateOf<I::System>,
    ) -> Result<u32, StepError> {
        let Some(halves) = interval.halves().filter(|_| interval.level() < self.depth) else {
            return Err(error);
        };
        let (mut left, mut right) = (*dw, *dw);
        let (whole, to_left, to_right) = (dw.as_ref(), left.as_mut(), right.as_mut());
        self.noise.halves_of(interval, h, whole, to_left, to_right);
        let h = 0.5 * h;
        // If h underflows, the first error says more.
        let prepared = self.method.prepare(h).map_err(|_| error)?;
        let mut deepest = interval.level() + 1;
        for (half, dw) in halves.into_iter().zip([left, right]) {
            if let Err(error) = self.method.method.step_prepared(&prepared, state, h, &dw) {
                let below = self.step(error, half, h, &dw, state)?;
                deepest = deepest.max(below);
            }
        }
        Ok(deepest)
    }
}
