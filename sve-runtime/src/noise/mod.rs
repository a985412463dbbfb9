//! Wiener increments for a trajectory.

/// A source of Wiener increments: one path of as many processes as a system asks for.
pub trait Noise {
    /// Fills `dw` with the increments of every process over step number `step` (from 0) of length `h`,
    /// each of variance `h`.
    ///
    /// # Errors
    /// When this source cannot serve that step.
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError>;
}

/// Why a noise source could not give the increments of a step.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NoiseError {
    /// A recorded path is over. A [`Trajectory`](crate::Trajectory) ends there without an error.
    #[error("the recorded path has {recorded} steps and step {step} was asked for")]
    Exhausted {
        /// Step asked for, from 0.
        step: u64,
        /// Steps recorded.
        recorded: u64,
    },
    /// A recorded path was made for another step size.
    #[error(
        "the path was recorded with h = {recorded:e}, and h = {h:e} was asked for; use the recorded step, or `coarsen` the path"
    )]
    StepSize {
        /// Step size asked for.
        h: f64,
        /// Step size of the recording.
        recorded: f64,
    },
    /// A recorded path has another number of processes.
    #[error("the path was recorded with {recorded} Wiener processes, and the system has {asked}")]
    Processes {
        /// Processes that the system has.
        asked: usize,
        /// Processes recorded.
        recorded: usize,
    },
    /// Truncated increments need `h < 1`.
    #[error(
        "truncated increments are defined for h < 1, and h = {h}; measure time in a larger unit, or take a smaller step"
    )]
    TruncationStep {
        /// Step size asked for.
        h: f64,
    },
}

/// No noise at all, for deterministic systems or the deterministic limit of a noisy one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoNoise;

impl Noise for NoNoise {
    fn increments(&mut self, _step: u64, _h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        dw.fill(0.0);
        Ok(())
    }
}
