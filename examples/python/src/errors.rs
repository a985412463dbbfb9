//! Errors of the library as exceptions, with its messages.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::{EnsembleError, StepError};

/// Returns the exception for the error of a step: `ValueError` for an argument that no step takes.
pub(crate) fn of_step(error: &sve_runtime::StepError) -> PyErr {
    use sve_runtime::StepError as Error;
    match error {
        Error::NonFiniteInput { .. } | Error::StepSize { .. } => {
            PyValueError::new_err(error.to_string())
        }
        _ => StepError::new_err(error.to_string()),
    }
}

/// Returns the exception for the error of an ensemble.
pub(crate) fn of_ensemble(error: &sve_runtime::ensemble::EnsembleError) -> PyErr {
    EnsembleError::new_err(error.to_string())
}
