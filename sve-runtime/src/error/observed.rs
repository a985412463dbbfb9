//! The results of functions of a state that users give: observables, functions whose zeros are
//! events, weights.
//!
//! Input: a number, or a number or an error. Output: the latter.

use crate::error::StepError;

/// The result of an observable: a number, or a number or an error.
#[diagnostic::on_unimplemented(
    message = "an observable or another function of a state returns `f64` or `Result<f64, StepError>`, not `{Self}`",
    label = "the closure given here has another result",
    note = "end it with a number, or with what `system.hamiltonian(state)` returns; an event is at the zero of a number, `state.q[0] - 1.0` for q[0] = 1"
)]
pub trait Observed {
    /// Returns the value.
    ///
    /// # Errors
    /// The error of the observable.
    fn observed(self) -> Result<f64, StepError>;
}

impl Observed for f64 {
    #[inline(always)]
    fn observed(self) -> Result<f64, StepError> {
        Ok(self)
    }
}

impl Observed for Result<f64, StepError> {
    #[inline(always)]
    fn observed(self) -> Result<f64, StepError> {
        self
    }
}
