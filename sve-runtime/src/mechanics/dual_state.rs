//! States that vary in a direction, for smooth functions of users.

use core::cell::OnceCell;

use crate::error::StepError;
use crate::phase::Field;
use crate::phase::configuration::{Coordinates, FlatConfiguration};
use crate::phase::dual::{Dual, DualState};
use crate::phase::state::State;
use crate::system::System;

/// Calls a function with a state that varies in a direction of its canonical coordinates, as does the parameter number `varied`. Calls `read` with the number of each
/// parameter that the function asks for.
///
/// # Errors
/// [`StepError::UnknownParameter`].
pub(crate) fn with_dual_state<S: System, Q: Coordinates<N>, T, const N: usize>(
    system: &S,
    state: &State<Q>,
    direction: &Field<[f64; N]>,
    varied: Option<usize>,
    read: &dyn Fn(usize),
    function: impl FnOnce(&DualState<'_, N, Q::Dual>) -> T,
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
    // of a rotation Π = y − ½ ε × Π to first order
    let (p, mut dp) = (Q::components(&state.p), direction.p);
    Q::Flat::add_transport(&p.map(|p| 0.5 * p), &direction.q, &mut dp);
    let result = function(&DualState {
        t: state.t,
        q: state.q.dual(&direction.q),
        p: Dual::row(&p, &dp),
        parameter: &parameter,
    });
    match unknown.into_inner() {
        None => Ok(result),
        Some(parameter) => Err(StepError::UnknownParameter {
            parameter,
            known: S::PARAMETERS.iter().map(|&name| name.to_owned()).collect(),
        }),
    }
}
