//! Trajectories that compensate the rounding errors of the state. A method with such steps gives its trajectories a function `compensated`.

use super::{RefinedTrajectory, Trajectory};
use crate::error::StepError;
use crate::method::OneStepMethod;
use crate::noise::Noise;
use crate::system::StateOf;

impl<I: OneStepMethod, W: Noise> Trajectory<'_, I, W> {
    /// Carries the low parts of the state from now on, starting with `low`. A resumed trajectory keeps its own.
    pub(crate) fn carry_low_parts(mut self, low: StateOf<I::System>) -> Self {
        self.low.get_or_insert(low);
        self
    }

    /// Makes a step that carries the low parts of the state.
    #[inline(never)]
    pub(super) fn compensated_step(&mut self, dw: &I::Increments) -> Result<(), StepError> {
        match (&mut self.prepared, &mut self.low) {
            (Some(prepared), Some(low)) => {
                self.method
                    .compensated_step(prepared, &mut self.state, low, self.h, dw)
            }
            _ => Ok(()),
        }
    }
}

impl<I: OneStepMethod, W: Noise> RefinedTrajectory<'_, I, W> {
    /// Carries the low parts of the state from now on, see [`Trajectory::carry_low_parts`].
    pub(crate) fn carry_low_parts(self, low: StateOf<I::System>) -> Self {
        self.map(|trajectory| trajectory.carry_low_parts(low))
    }
}
