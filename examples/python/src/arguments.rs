//! The checks of arguments. A message begins with the name of the argument.

use std::fmt::Display;
use std::ops::RangeInclusive;

use numpy::{AllowTypeChange, PyArrayLikeDyn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sve_runtime::system::AnySystem;

/// Returns a `ValueError`.
pub(crate) fn wrong(message: String) -> PyErr {
    PyValueError::new_err(message)
}

/// Returns a whole number of a range.
pub(crate) fn whole<T>(name: &str, value: i128, range: RangeInclusive<T>) -> PyResult<T>
where
    T: TryFrom<i128> + PartialOrd + Display,
{
    match T::try_from(value) {
        Ok(value) if range.contains(&value) => Ok(value),
        _ => Err(wrong(format!(
            "{name} is {value}, and has to be a whole number from {} to {}",
            range.start(),
            range.end()
        ))),
    }
}

/// Checks that a step size is finite and not 0.
pub(crate) fn check_step_size(h: f64) -> PyResult<()> {
    if h.is_finite() && h != 0.0 {
        return Ok(());
    }
    Err(wrong(format!("h is {h}, and has to be finite and not 0")))
}

/// Returns the numbers of an argument: a number, a sequence or an array of them.
pub(crate) fn numbers(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let array = value
        .extract::<PyArrayLikeDyn<'_, f64, AllowTypeChange>>()
        .map_err(|error| {
            wrong(format!(
                "{name} has to be a number or an array of numbers: {error}"
            ))
        })?;
    Ok(array.as_array().iter().copied().collect())
}

/// Checks that an argument has a number for each `of` of the system.
pub(crate) fn check_length(name: &str, found: usize, wanted: usize, of: &str) -> PyResult<()> {
    if found == wanted {
        return Ok(());
    }
    let numbers = if found == 1 { "number" } else { "numbers" };
    Err(wrong(format!(
        "{name} has {found} {numbers} and needs {wanted}, one for each {of}"
    )))
}

/// Checks that all parameters of a system are finite.
pub(crate) fn check_parameters<S: AnySystem>(system: &S) -> PyResult<()> {
    let mut names = S::NAMES.parameters.iter();
    let mut result = Ok(());
    system.visit_parameters(&mut |value| {
        let name = names.next().unwrap_or(&"a parameter");
        if !value.is_finite() && result.is_ok() {
            result = Err(wrong(format!("{name} is {value}, and has to be finite")));
        }
    });
    result
}
