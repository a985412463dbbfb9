//! Paths with a tolerance: accurate paths whose steps have the size that the tolerance allows.
//!
//! Input: a trajectory of a Gauss rule without noise, and a tolerance. Output: an iterator over the
//! states after its steps, with the adapters of a trajectory. Invariant: what is read from the
//! path, a saved state or an event, does not change its steps.

use super::adapted::{Adapted, Sizes, first_size, unit_of_step};
use super::{AdaptedSteps, FixedSteps, RefinedTrajectory, Trajectory};
use crate::integrator::adapted::AdaptsSteps;
use crate::method::OneStepMethod;
use crate::noise::{Halves, NoNoise, Noise};
use crate::system::StateOf;

/// A source without noise, which steps of adapted size need.
#[diagnostic::on_unimplemented(
    message = "`.tolerance(tol)` takes paths without noise, and `{Self}` is a noise",
    label = "steps of adapted size have no noise",
    note = "a step that is chosen by its own increments and tried again has increments of another distribution: give `NoNoise`, or leave out `.tolerance(tol)` and take equal steps"
)]
pub trait WithoutNoise: Halves {}

impl WithoutNoise for NoNoise {}

/// A path with a tolerance, from [`Trajectory::tolerance`].
///
/// A saved state and a state at an event are the ends of shorter steps, with the accuracy of the
/// path. Changes of the state by [`change_at`](Trajectory::change_at) end a step.
pub type AccurateTrajectory<'a, I, W = NoNoise> = Trajectory<'a, I, W, AdaptedSteps>;

impl<'a, I: OneStepMethod, W: Noise> Trajectory<'a, I, W> {
    /// Adapts the size of each step so that the path has an error of about `tolerance` after a
    /// characteristic time of its motion, a period say. The step size of the trajectory is only the
    /// size of the first step that is tried.
    ///
    /// For accurate paths over short times: close encounters, eccentric orbits, transients, and
    /// references for other methods. **The path has no structure.** Steps are neither symplectic
    /// nor reversible, momenta of symmetries are conserved to about the tolerance, and the energy
    /// drifts: over many periods the equal steps of a trajectory without a tolerance are better.
    /// Errors add up from period to period, and a chaotic motion multiplies them. The tolerance is
    /// in units of the state, relative to the largest forces and velocities of a step; coordinates
    /// that are very small beside others have no digits of their own.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A comet around the sun.
    /// struct Comet;
    ///
    /// #[variational(gauss(8))]
    /// impl Comet {
    ///     fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
    ///         0.5 * (v[0] * v[0] + v[1] * v[1]) + 1.0 / (q[0] * q[0] + q[1] * q[1]).sqrt()
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let comet = Integrator::new(Comet, Gauss::<8>);
    /// // an eccentricity of 0.9, from the perihelion, over one period
    /// let start = State::new([0.1, 0.0], [0.0, 19.0_f64.sqrt()]);
    /// let path = comet.trajectory(start, 0.01, NoNoise).tolerance(1e-10);
    /// let end = path.until(std::f64::consts::TAU).last().expect("a state")?;
    /// assert_eq!(end.t, std::f64::consts::TAU);
    /// assert!((end.q[0] - 0.1).abs() < 1e-9 && end.q[1].abs() < 1e-9);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// **The size of a step** follows from the decay of the Legendre series of its forces, or for
    /// masses that depend on the place of its forces and velocities: terms that fall by a factor r
    /// from degree to degree give S stages an error of order r²ˢ. The iteration of the stages ends
    /// where its changes are negligible beside this error. Sizes follow the trend of the steps
    /// before, and a step whose series decays too slowly, or whose iteration does not contract, is
    /// tried again with a smaller size.
    ///
    /// **Times.** Steps end at times of their own. [`until`](Self::until) and
    /// [`at`](Self::at) end a step at a given time, to the last bit, and
    /// [events](Self::crossings) are found as in any trajectory; the steps of the
    /// path are the same with and without them. The sign of the step size is that of time.
    ///
    /// **With a [time scale](crate::WithTimeScale)** the sizes are those of steps of τ, in which
    /// the motion is even. `until`, `at`, events and [`state_at`](Trajectory::state_at) act
    /// on the time t. Such a path has no structure either.
    ///
    /// **A [snapshot](Trajectory::snapshot)** has the numbers from which the next size follows:
    /// `integrator.resume(snapshot, NoNoise)?.tolerance(1e-10)` continues with the bits of the
    /// uninterrupted path.
    ///
    /// **Errors** of the steps: [`StepError::Tolerance`] for a tolerance that is not between 10⁻¹⁵
    /// and 10⁻², [`StepError::StepSize`] for a first size that is zero or not finite,
    /// [`StepError::StepTooSmall`] where no size is small enough, as in a collision, and
    /// [`StepError::TooManySteps`].
    ///
    /// A compile-time error for other rules than `Gauss::<4>` to `Gauss::<8>`, for compositions,
    /// for noise and for inputs, and with [`refine`](Self::refine) or
    /// [`compensated`](Self::compensated) behind it. Rounding errors are compensated in any case.
    ///
    /// Sources: the decay of a series tells the distance of the nearest singularity (J. P. Boyd,
    /// *Chebyshev and Fourier Spectral Methods*, 2001, chapter 2). The trend of the sizes and the
    /// first values of the stages from the step before as in the program `IRKGaussLegendre.jl` of
    /// Antoñana, Makazaga and Murua.
    ///
    /// [`StepError::Tolerance`]: crate::StepError::Tolerance
    /// [`StepError::StepSize`]: crate::StepError::StepSize
    /// [`StepError::StepTooSmall`]: crate::StepError::StepTooSmall
    /// [`StepError::TooManySteps`]: crate::StepError::TooManySteps
    #[must_use]
    pub fn tolerance(mut self, tolerance: f64) -> AccurateTrajectory<'a, I, W>
    where
        I: AdaptsSteps,
        W: WithoutNoise,
    {
        let stored = match &self.sizes {
            Sizes::Stored(numbers) => numbers.as_slice(),
            Sizes::Fixed | Sizes::Adapted(_) => &[],
        };
        let unit = unit_of_step(&*self.method, &self.state);
        let size = first_size(tolerance, I::STAGES, self.h, unit);
        let adapted = Adapted::new(tolerance, size, self.method.attempts(), stored);
        self.sizes = Sizes::Adapted(Box::new(adapted));
        self.prepared = None;
        self.low.get_or_insert_with(I::no_low_parts);
        self.of_kind(AdaptedSteps)
    }
}

impl<I: OneStepMethod, W> RefinedTrajectory<'_, I, W> {
    /// Does not compile: a step that fails is tried again with a smaller size in any case.
    #[doc(hidden)]
    #[must_use]
    pub fn tolerance(self, _: f64) -> Self
    where
        Self: FixedSteps,
    {
        self
    }
}

impl<I: OneStepMethod, W: Noise> AccurateTrajectory<'_, I, W> {
    /// Returns the state at a time within the last step, by the polynomials through its stages;
    /// `None` if the time is not within it, or before the first step.
    ///
    /// It costs no step, and has the accuracy of a picture: with S stages its error falls as the
    /// power S + 1 of the size of the step, that of the end of the step as the power 2S + 1. For a
    /// state with the accuracy of the path ask for its time with [`at`](Self::at).
    ///
    #[doc = include_str!("../example_gauss.md")]
    /// let mut path = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-8);
    /// let end = path.next().expect("no end")?;
    /// let middle = path.state_at(0.5 * end.t).expect("within the step");
    /// assert!(middle.q[0] < start.q[0] && middle.q[0] > end.q[0]);
    #[doc = include_str!("../example_end.md")]
    pub fn state_at(&self, t: f64) -> Option<StateOf<I::System>> {
        match &self.sizes {
            Sizes::Adapted(adapted) => adapted.state_at(t),
            Sizes::Fixed | Sizes::Stored(_) => None,
        }
    }

    /// Limits the number of steps, including the steps before a snapshot; without this option it is
    /// 10⁸. A path that would make more ends with
    /// [`StepError::TooManySteps`](crate::StepError::TooManySteps).
    ///
    #[doc = include_str!("../example_gauss.md")]
    /// let path = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-8).max_steps(10);
    /// let last = path.until(1e6).last().expect("an error");
    /// assert!(matches!(last, Err(StepError::TooManySteps { steps: 10, .. })));
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn max_steps(mut self, steps: u64) -> Self {
        if let Sizes::Adapted(adapted) = &mut self.sizes {
            adapted.most_steps = steps;
        }
        self
    }

    /// Limits the size of each step, of τ with a time scale. Without this option sizes grow as long
    /// as no stage sees a force, and a step may pass an obstacle of short range between its stages:
    /// give a size that does not. A snapshot does not store it.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A wall that is three units wide and higher than the energy of the particle.
    /// struct Wall;
    ///
    /// #[variational(gauss(8))]
    /// impl Wall {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 {
    ///         0.5 * v * v - 10.0 * (-q * q).exp()
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let wall = Integrator::new(Wall, Gauss::<8>);
    /// let start = State::new([-20.0], [1.0]);
    /// let path = wall.trajectory(start, 0.1, NoNoise).tolerance(1e-9).max_step(2.0);
    /// let end = path.until(40.0).last().expect("an end")?;
    /// assert!((end.p[0] + 1.0).abs() < 1e-7); // thrown back
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// The first step fails with [`StepError::StepSize`](crate::StepError::StepSize) if the size is
    /// not positive.
    #[must_use]
    pub fn max_step(mut self, size: f64) -> Self {
        if let Sizes::Adapted(adapted) = &mut self.sizes {
            adapted.limit(size);
        }
        self
    }

    /// Returns the number of attempts at steps that were not accepted, including the attempts
    /// before a snapshot.
    pub fn rejections(&self) -> u64 {
        match &self.sizes {
            Sizes::Adapted(adapted) => adapted.rejected,
            Sizes::Fixed | Sizes::Stored(_) => 0,
        }
    }
}
