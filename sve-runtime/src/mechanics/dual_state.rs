//! States that vary in a direction, for smooth functions that users define.

use core::cell::OnceCell;

use crate::error::StepError;
use crate::phase::Field;
use crate::phase::dual::Dual;
use crate::system::{Dimensions, DualStateOf, StateOf, System, VectorOf};

/// Calls a function with a state that varies in a direction of its canonical coordinates, as does
/// the parameter number `varied`. Calls `read` with the number of each parameter that the function
/// asks for.
///
/// # Errors
/// [`StepError::UnknownParameter`] if the function asks for a parameter that the system does not
/// have.
pub(crate) fn with_dual_state<S: System, T>(
    system: &S,
    state: &StateOf<S>,
    direction: &Field<VectorOf<S>>,
    varied: Option<usize>,
    read: &dyn Fn(usize),
    function: impl FnOnce(&DualStateOf<'_, S>) -> T,
) -> Result<T, StepError> {
    let unknown = OnceCell::new();
    let parameter = |name: &str| {
        let Some(number) = S::PARAMETERS.iter().position(|&known| known == name) else {
            unknown.get_or_init(|| name.to_owned());
            return Dual::from(f64::NAN);
        };
        read(number);
        let (mut value, mut at) = (f64::NAN, 0);
        system.parameters(&mut |parameter| {
            if at == number {
                value = parameter;
            }
            at += 1;
        });
        Dual::parameter(value, varied == Some(number))
    };
    let result = function(&S::Dims::dual_state(state, direction, &parameter));
    match unknown.into_inner() {
        None => Ok(result),
        Some(parameter) => Err(StepError::UnknownParameter {
            parameter,
            known: S::PARAMETERS.iter().map(|&name| name.to_owned()).collect(),
        }),
    }
}
