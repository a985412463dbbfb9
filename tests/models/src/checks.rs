//! Comparisons that many tests make; each panics with the row that it concerns.

use std::fmt::{Debug, Display};

use sve_runtime::__private::{Coordinates, FixedSize};
use sve_runtime::Rule;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::oracle::name;
use crate::orders::numbers;

/// Asserts that a value matches a pattern, and prints the value if it does not.
#[macro_export]
macro_rules! assert_matches {
    ($value:expr, $pattern:pat $(if $condition:expr)? $(,)?) => {
        match &$value {
            $pattern $(if $condition)? => {}
            other => panic!("{other:?} for {}", stringify!($pattern)),
        }
    };
}

/// Asserts that numbers differ from those expected by at most `bound`.
///
/// # Panics
/// If one does not.
#[track_caller]
pub fn assert_close(found: &[f64], expected: &[f64], bound: f64, row: impl Display) {
    assert_bounded(found, expected, |_| bound, row);
}

/// Asserts that numbers differ from those expected by at most `bound`, relative to 1 and the
/// number.
///
/// # Panics
/// If one does not.
#[track_caller]
pub fn assert_relative(found: &[f64], expected: &[f64], bound: f64, row: impl Display) {
    assert_bounded(found, expected, |y| bound * (1.0 + y.abs()), row);
}

#[track_caller]
fn assert_bounded(found: &[f64], expected: &[f64], bound: impl Fn(f64) -> f64, row: impl Display) {
    assert_eq!(found.len(), expected.len(), "{row}");
    for (i, (x, y)) in found.iter().zip(expected).enumerate() {
        assert!(
            (x - y).abs() <= bound(*y),
            "{row}, number {i}: {x:e} for {y:e} in {found:?} for {expected:?}"
        );
    }
}

/// Asserts that coordinates and momenta differ from those expected by at most `bound`.
///
/// # Panics
/// If one does not.
#[track_caller]
pub fn assert_states_close<Q: FixedSize>(
    found: &State<Q>,
    expected: &State<Q>,
    bound: f64,
    row: impl Display,
) {
    assert_close(&numbers(found), &numbers(expected), bound, row);
}

/// Asserts that a text contains all of these parts.
///
/// # Panics
/// If it lacks one.
#[track_caller]
pub fn assert_says(text: impl Display, parts: &[&str]) {
    let text = text.to_string();
    for part in parts {
        assert!(text.contains(part), "no {part:?} in\n{text}");
    }
}

/// Asserts that a measured mean is the exact one within so many of its standard errors.
///
/// # Panics
/// If it is not.
#[track_caller]
pub fn assert_within(found: f64, exact: f64, error: f64, sigmas: f64, row: impl Display) {
    let z = (found - exact) / error;
    assert!(
        z.abs() < sigmas,
        "{row}: {found} ± {error} for {exact}, z = {z}"
    );
}

/// All bits of a state: its time, coordinates and momenta.
pub fn bits<Q: FixedSize>(state: &State<Q>) -> Vec<u64> {
    let mut all = vec![state.t.to_bits()];
    all.extend(numbers(state).iter().map(|x| x.to_bits()));
    all
}

/// Returns the error of a step that must fail and leave all bits of the state unchanged.
///
/// # Panics
/// If the step succeeds, or changes the state.
#[track_caller]
pub fn failure<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: &State<Q>,
    h: f64,
    dw: &R::Increments,
) -> StepError
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
    Q: Coordinates<N> + Debug,
{
    let (mut state, name) = (*start, name(integrator));
    let result = integrator.step(&mut state, h, dw);
    assert_eq!(bits(&state), bits(start), "{name}: the state was touched");
    match result {
        Ok(()) => panic!("{name}: no error from {start:?} with h = {h}"),
        Err(error) => error,
    }
}
