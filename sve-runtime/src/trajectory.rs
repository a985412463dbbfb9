//! States along a path, one a step.

use crate::error::StepError;
use crate::method::Method;
use crate::noise::{Noise, NoiseError};
use crate::system::{Dimensions, IncrementsOf, StateOf, System};

/// The states after each step, from [`Method::trajectory`].
///
/// Ends after an error, and where a recorded path ends; otherwise it has no end: `take` what is needed.
#[derive(Debug)]
pub struct Trajectory<'a, I: Method, W> {
    method: &'a I,
    noise: W,
    state: StateOf<I::System>,
    start: f64,
    h: f64,
    prepared: Option<I::Prepared>,
    step: u64,
    over: bool,
}

impl<'a, I: Method, W: Noise> Trajectory<'a, I, W> {
    pub(crate) fn new(method: &'a I, state: StateOf<I::System>, h: f64, noise: W) -> Self {
        Self {
            start: <<I::System as System>::Dims>::time(&state),
            method,
            noise,
            state,
            h,
            prepared: None,
            step: 0,
            over: false,
        }
    }

    /// The state reached so far.
    pub fn state(&self) -> &StateOf<I::System> {
        &self.state
    }

    fn advance(&mut self) -> Result<Option<StateOf<I::System>>, StepError> {
        let prepared = match self.prepared {
            Some(prepared) => prepared,
            None => *self.prepared.insert(self.method.prepare(self.h)?),
        };
        let mut dw: IncrementsOf<I::System> = <<I::System as System>::Dims>::NO_INCREMENTS;
        match self.noise.increments(self.step, self.h, dw.as_mut()) {
            Ok(()) => {}
            Err(NoiseError::Exhausted { .. }) => return Ok(None),
            Err(source) => {
                let t = <<I::System as System>::Dims>::time(&self.state);
                return Err(StepError::Noise { t, source });
            }
        }
        self.method
            .step_prepared(&prepared, &mut self.state, self.h, &dw)?;
        self.step += 1;
        // k h is rounded once, where adding h k times would drift
        let t = self.start + self.step as f64 * self.h;
        <<I::System as System>::Dims>::set_time(&mut self.state, t);
        Ok(Some(self.state.clone()))
    }
}

impl<I: Method, W: Noise> Iterator for Trajectory<'_, I, W> {
    type Item = Result<StateOf<I::System>, StepError>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        if self.over {
            return None;
        }
        let item = self.advance().transpose();
        self.over = !matches!(item, Some(Ok(_)));
        item
    }
}
