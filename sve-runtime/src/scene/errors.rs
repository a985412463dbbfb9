//! Errors of steps of scenes: the checks that find them, and the names of numbers in them.

use super::sweep::Place;
use super::{IndexError, Phase, Row, Scene};
use crate::error::StepError;

/// Checks the length of an array.
pub(crate) fn check_length(
    what: &str,
    found: usize,
    expected: usize,
    t: f64,
) -> Result<(), StepError> {
    if found == expected {
        return Ok(());
    }
    let what = what.into();
    Err(StepError::Length {
        t,
        what,
        found,
        expected,
    })
}

/// Checks that each force has an entry for each site.
pub(super) fn check_forces<S: Scene>(scene: &S, n: usize, t: f64) -> Result<(), StepError> {
    let mut checked = Ok(());
    let visited = scene.forces(n, &mut |name, found| {
        // the number of rounds of a loop is not negative
        let found = usize::try_from(found).unwrap_or_default();
        if checked.is_ok() {
            checked = check_length(&format!("the result of `{name}`"), found, n, t);
        }
    });
    visited.map_err(|error| index_error(error, t))?;
    checked
}

/// Returns the name of a component: `p[5]`, or `p[5][2]` in a row of several.
pub(super) fn name(array: &str, at: usize, length: usize) -> String {
    match length {
        1 => format!("{array}[{at}]"),
        _ => format!("{array}[{}][{}]", at / length, at % length),
    }
}

pub(super) fn index_error(error: IndexError, t: f64) -> StepError {
    let IndexError {
        text,
        index,
        length,
        instance,
    } = error;
    StepError::Index {
        t,
        text: format!("{text}{instance}").into(),
        index,
        length,
    }
}

/// Returns the error of a step with a number that is not finite, from the restored state.
#[cold]
pub(super) fn not_finite<R: Row>(
    state: &Phase<'_, R>,
    place: Place,
    [t, h]: [f64; 2],
    dw: &[f64],
) -> StepError {
    let [q, p] = [&*state.q, &*state.p].map(R::numbers);
    input_error::<R>([q, p], dw, t).unwrap_or_else(|| StepError::NonFiniteCoordinate {
        t,
        h,
        what: name(place.array, place.component, R::LENGTH),
    })
}

/// Returns the error of a step whose start or increments are not finite.
#[cold]
pub(super) fn input_error<R: Row>([q, p]: [&[f64]; 2], dw: &[f64], t: f64) -> Option<StepError> {
    let input = (find("q", q, R::LENGTH))
        .or_else(|| find("p", p, R::LENGTH))
        .or_else(|| find("dw", dw, 1));
    input.map(|(what, value)| StepError::NonFiniteInput { what, value, t })
}

/// Returns the first number that is not finite, with its name.
fn find(array: &str, numbers: &[f64], length: usize) -> Option<(String, f64)> {
    let at = numbers.iter().position(|x| !x.is_finite())?;
    Some((name(array, at, length), numbers[at]))
}
