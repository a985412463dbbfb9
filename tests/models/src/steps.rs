//! Identities of a step of any rule: its derivatives by differences, symplecticity, and the step
//! back.

use sve_runtime::Rule;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::differences::derivatives;
use crate::oracle::name;
use crate::orders::numbers;

/// Largest error of a derivative by differences, relative to the larger of 1 and the derivative:
/// see `differences`, with derivatives of the seventh order below 100.
const DIFFERENCES: f64 = 1e-9;

/// Returns coordinates and momenta after a step.
///
/// # Panics
/// If the step fails.
pub fn stepped<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: &State<[f64; N]>,
    h: f64,
    dw: &R::Increments,
) -> Vec<f64>
where
    S: System<Dims = Dims<N, M>>,
    R: Rule<S::Itself>,
{
    let mut state = *start;
    let step = integrator.step(&mut state, h, dw);
    step.unwrap_or_else(|error| panic!("{} from {start:?}: {error}", name(integrator)));
    numbers(&state)
}

/// Returns the state with `by` added to an entry of (q, p).
fn moved<const N: usize>(mut state: State<[f64; N]>, entry: usize, by: f64) -> State<[f64; N]> {
    let mut entries = state.q.iter_mut().chain(&mut state.p);
    *entries.nth(entry).expect("an entry") += by;
    state
}

/// Compares derivatives with the derivatives of a function by differences.
fn compare(what: &str, derived: &[f64], function: impl Fn(f64) -> Vec<f64>) {
    let differences = derivatives(function);
    assert_eq!(derived.len(), differences.len(), "{what}");
    for (row, (derived, expected)) in derived.iter().zip(differences).enumerate() {
        assert!(
            (derived - expected).abs() <= DIFFERENCES * expected.abs().max(1.0),
            "{what}, row {row}: {derived:e}, by differences {expected:e}"
        );
    }
}

/// Checks that the tangent map of a step is its derivative and, with a bound of the defect,
/// symplectic.
///
/// # Panics
/// If it is not.
pub fn check_tangent<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: &State<[f64; N]>,
    h: f64,
    dw: &R::Increments,
    defect: Option<f64>,
) where
    S: System<Dims = Dims<N, M>>,
    R: Rule<S::Itself>,
{
    let name = name(integrator);
    let tangent = integrator.tangent(start, h, dw).expect("a step");
    for column in 0..2 * N {
        let derived: Vec<f64> = (0..2 * N).map(|row| tangent[row][column]).collect();
        let function = |by| stepped(integrator, &moved(*start, column, by), h, dw);
        compare(&format!("{name}, column {column}"), &derived, function);
    }
    if let Some(bound) = defect {
        let defect = tangent.symplectic_defect();
        assert!(defect < bound, "{name} from {start:?}: {defect:e}");
    }
}

/// Checks that sensitivities are derivatives of a step by parameters: `system` returns a system
/// with a parameter changed by a number.
///
/// # Panics
/// If a sensitivity is wrong.
pub fn check_sensitivity<S, R, const N: usize, const M: usize>(
    system: impl Fn(&str, f64) -> S,
    rule: R,
    parameters: &[&str],
    start: &State<[f64; N]>,
    (h, dw): (f64, &R::Increments),
) where
    S: System<Dims = Dims<N, M>>,
    R: Rule<S::Itself> + Copy,
{
    let integrator = Integrator::new(system(parameters[0], 0.0), rule);
    let sensitivity = integrator.sensitivity(start, h, dw).expect("a step");
    for parameter in parameters {
        let field = sensitivity.get(parameter).expect("a parameter");
        let derived = [field.q, field.p].concat();
        let name = format!("{} by {parameter}", name(&integrator));
        compare(&name, &derived, |by| {
            stepped(&Integrator::new(system(parameter, by), rule), start, h, dw)
        });
    }
}

/// Checks that a step, followed by a step with −h and the increments `back`, leads back to the
/// start.
///
/// # Panics
/// If the end differs from the start.
pub fn check_return<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: &State<[f64; N]>,
    h: f64,
    [dw, back]: [&R::Increments; 2],
    tolerance: f64,
) where
    S: System<Dims = Dims<N, M>>,
    R: Rule<S::Itself>,
{
    let mut state = *start;
    integrator.step(&mut state, h, dw).expect("a step");
    let ends = stepped(integrator, &state, -h, back);
    for (x, y) in ends.iter().zip(numbers(start)) {
        assert!(
            (x - y).abs() <= tolerance * (1.0 + y.abs()),
            "{}: {ends:?} for {start:?}",
            name(integrator)
        );
    }
}
