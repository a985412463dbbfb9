//! Wiener increments for a trajectory.
//!
//! Input: a step number, a step size `h`, and the number of processes. Output: one increment for
//! each process, normal with mean 0 and variance `h` (its unit is that of √t), independent between
//! steps and processes.
//!
//! | source | increments | replayable | with stage noise |
//! | --- | --- | --- | --- |
//! | [`Wiener`] | from a seed, counter-based | any step, in any order | yes; the same path for every number of stages |
//! | [`Refined`] | a `Wiener` path in smaller steps | any step, in any order | yes; the same whole steps for every number of stages |
//! | [`ThreePoint`] | of three values, for weak solutions; counter-based | any step, in any order | no: the stages would have another law |
//! | [`Recorded`] | given, or taken from another source; can be coarsened | any step, in any order | a path of [`Recorded::record_stages`], for as many stages or fewer |
//! | [`Truncated`] | of another source, clipped for implicit steps | as the other source | as the other source |
//! | [`FromRng`] | from a random generator of the `rand` crates | no: draws follow one another | yes |
//! | [`NoNoise`] | zero | trivially | yes |
//!
//! [`Wiener`], [`Refined`] and [`NoNoise`] know their path within a step ([`Halves`]): steps that
//! fail can be [refined](crate::Trajectory::refine), and steps can be cut at
//! [events](crate::Events).
//!
//! All sources serve all rules that take one increment for each process. Rules with [stage
//! noise](crate::StageNoise) ask for an increment for each process and stage. Where the table says
//! no, the first step returns an error that names the source; an ensemble returns an error before
//! its first step, also for [`Refined`]. With stage noise steps are not divided, where they
//! [fail](crate::Trajectory::refine) or at [events](crate::Events): both are compile errors.
//!
//! [`Replayable::from_step`] enters a replayable path at a step.
//!
//! ```
//! use sve_runtime::noise::{Noise, Wiener};
//!
//! let mut path = Wiener::new(42).path(7);
//! let mut dw = [0.0; 2];
//! path.increments(1000, 0.01, &mut dw)?;
//! assert_eq!(dw[1], Wiener::new(42).path(7).increment(1000, 1, 0.01)); // the same, bit for bit
//! # Ok::<(), sve_runtime::noise::NoiseError>(())
//! ```

pub(crate) mod box_muller;
mod bridge;
mod counter_path;
mod distribution;
mod from_rng;
mod from_step;
mod halves;
#[cfg(feature = "ensemble")]
pub(crate) mod lanes;
#[cfg(feature = "ensemble")]
mod many_paths;
mod none;
mod recorded;
#[cfg(feature = "ensemble")]
pub(crate) mod refined_lanes;
pub(crate) mod stages;
mod three_point;
pub(crate) mod threefry;
mod truncated;
mod wiener;

pub use crate::error::NoiseError;
pub use bridge::{DyadicInterval, Refined};
#[cfg(feature = "ensemble")]
pub(crate) use distribution::VERSION;
pub use from_rng::FromRng;
#[doc(hidden)]
pub use from_step::FromStep;
pub use from_step::Replayable;
pub(crate) use halves::increments_until;
pub use halves::{Halves, WithinSteps};
#[cfg(feature = "ensemble")]
pub use many_paths::ManyPaths;
#[cfg(feature = "ensemble")]
pub(crate) use many_paths::{AnyDistribution, DistributionKind, PathData};
pub use none::NoNoise;
pub use recorded::Recorded;
pub use three_point::ThreePoint;
pub use truncated::Truncated;
pub use wiener::Wiener;

/// A source of Wiener increments: one path with as many processes as a system asks for.
///
/// A mutable reference to a source is a source, and so is a box that contains a source.
///
/// ```
/// use sve_runtime::noise::{Noise, NoiseError};
///
/// /// One jump at the start, then nothing.
/// struct Kick(f64);
///
/// impl Noise for Kick {
///     fn increments(&mut self, step: u64, _h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
///         dw.fill(if step == 0 { self.0 } else { 0.0 });
///         Ok(())
///     }
/// }
///
/// let mut dw = [0.0];
/// Kick(0.5).increments(0, 0.01, &mut dw)?;
/// assert_eq!(dw, [0.5]);
/// # Ok::<(), NoiseError>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a source of Wiener increments",
    label = "expected a source, such as `Wiener::new(42)`",
    note = "sources are `Wiener::new(seed)`, `ThreePoint::new(seed)`, `Recorded`, `Truncated`, `FromRng`, and `NoNoise` for systems without noise terms"
)]
pub trait Noise {
    /// Fills `dw` with the increments of every process over step number `step` (from 0) of length
    /// `h`, each with variance `h`.
    ///
    /// # Errors
    /// A [`NoiseError`] if the source cannot serve the step.
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError>;

    /// Fills `dw` with the increments of every process at every stage of a Gauss rule, process by
    /// process, with nodes ascending. They are independent, with variance `b_i h` at the node with
    /// weight `b_i`.
    ///
    /// The increments of a process add up to the increment that [`increments`](Self::increments)
    /// returns; those of a [refined](Wiener::refine) path do over each step of the path. The
    /// default implementation returns an error.
    ///
    /// # Errors
    /// A [`NoiseError`] if the source cannot serve the step; [`NoiseError::NoStages`] if it draws
    /// no increments for stages.
    fn stage_increments(
        &mut self,
        step: u64,
        h: f64,
        stages: usize,
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        let _ = (step, h, dw);
        Err(NoiseError::NoStages { stages })
    }

    /// Returns the path within steps, if the source knows it: `Some(WithinSteps::of(self))` for a
    /// source with [`Halves`]. The default implementation returns `None`.
    fn within_steps(&self) -> Option<WithinSteps<'_>> {
        None
    }

    /// Returns whether the increments of a step can be drawn again, as those of a [`Replayable`]
    /// source can. The default implementation returns false.
    #[doc(hidden)]
    fn is_replayable(&self) -> bool {
        false
    }
}

/// Fills `dw` with the increments of a step of a rule with this number of stages.
///
/// # Errors
/// A [`NoiseError`] if the source cannot serve the step.
#[inline(always)]
pub(crate) fn draw<W: Noise + ?Sized>(
    noise: &mut W,
    step: u64,
    h: f64,
    stages: usize,
    dw: &mut [f64],
) -> Result<(), NoiseError> {
    match stages {
        1 => noise.increments(step, h, dw),
        _ => noise.stage_increments(step, h, stages, dw),
    }
}

/// Implements [`Noise`] for a pointer to a source.
macro_rules! forward {
    ($pointer:ty) => {
        impl<W: Noise + ?Sized> Noise for $pointer {
            #[inline]
            fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
                (**self).increments(step, h, dw)
            }

            #[inline]
            fn stage_increments(
                &mut self,
                step: u64,
                h: f64,
                stages: usize,
                dw: &mut [f64],
            ) -> Result<(), NoiseError> {
                (**self).stage_increments(step, h, stages, dw)
            }

            fn within_steps(&self) -> Option<WithinSteps<'_>> {
                (**self).within_steps()
            }

            fn is_replayable(&self) -> bool {
                (**self).is_replayable()
            }
        }
    };
}
forward!(&mut W);
forward!(Box<W>);
