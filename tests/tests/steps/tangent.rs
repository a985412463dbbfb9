//! The tangent map and the sensitivities of every step against differences of the step itself, and the exact identities
//! that a tangent map obeys.

use sve_models::case::Case;
use sve_models::differences::derivatives;
use sve_models::models::{Damped, DoublePendulum, Driven, Kubo, Mixed, Pendulum, Polar};
use sve_models::oracle::{self, Model, Rule, cases, name};
use sve_models::random::Random;
use sve_models::steps::stepped;
use sve_runtime::prelude::*;
use sve_runtime::{System, Tangent, Variational};

/// Differences are good to 1e-12 (see `differences`) times derivatives of the seventh order, below 100 here.
const DIFFERENCES: f64 = 1e-9;

/// Rounding: some 50 operations an entry, and entries up to 10 that are multiplied and cancel.
const SYMPLECTIC: f64 = 1e-12;

fn tangents_are_derivatives(case: &dyn Case, random: &mut Random) {
    let (h, model) = (0.1, case.model());
    let (n, m) = case.dimensions();
    for _ in 0..5 {
        let start = model.point(random);
        let dw = random.vector(m, -0.3, 0.3);
        let derived = case.differentiated(&mut start.clone(), h, &dw).unwrap();
        for column in 0..2 * n {
            let differences = derivatives(|d| {
                let mut from = start.clone();
                match column {
                    i if i < n => from.q[i] += d,
                    i => from.p[i - n] += d,
                }
                let to = case.stepped(&from, h, &dw);
                to.entries().copied().collect()
            });
            for row in 0..2 * n {
                let (got, expected) = (derived.tangent[row][column], differences[row]);
                assert!(
                    (got - expected).abs() <= DIFFERENCES * (1.0 + expected.abs()),
                    "{}: [{row}][{column}] at {start:?}, {dw:?}: {got:e}, by differences {expected:e}",
                    case.name()
                );
            }
        }
        if !model.is_forced() {
            let defect = derived.defect;
            assert!(
                defect < SYMPLECTIC,
                "{}: defect at {start:?}, {dw:?}: {defect:e}",
                case.name()
            );
        }
    }
}

#[test]
fn tangents_are_derivatives_of_steps_and_symplectic() {
    let mut random = Random::new(17);
    for case in cases() {
        tangents_are_derivatives(&*case, &mut random);
    }
}

/// The tangent of many steps is the product of theirs, and symplectic to the rounding of the products.
#[test]
fn tangents_of_successive_steps() {
    let integrator = Integrator::new(oracle::double_pendulum(), Midpoint);
    let start = State::new([0.4, -0.3], [0.1, 0.2]);
    let increments = |k: u32| [0.1 * f64::from(k).sin(), 0.1 * f64::from(k).cos()];
    let run = |from: State<[f64; 2]>| {
        let mut state = from;
        for k in 0..50 {
            integrator.step(&mut state, 0.02, &increments(k)).unwrap();
        }
        [state.q, state.p].concat()
    };
    let (mut state, mut total) = (start, Tangent::identity());
    for k in 0..50 {
        let dw = increments(k);
        let (tangent, _) = integrator
            .step_with_derivatives(&mut state, 0.02, &dw)
            .unwrap();
        total = &tangent * &total;
    }
    assert_eq!([state.q, state.p].concat(), run(start));
    assert!(total.symplectic_defect() < 1e-11);
    let differences = derivatives(|d| {
        run(State {
            q: [0.4 + d, -0.3],
            ..start
        })
    });
    for (row, expected) in differences.iter().enumerate() {
        assert!((total[row][0] - expected).abs() < 1e-8 * (1.0 + expected.abs()));
    }
}

/// Checks the derivative in one parameter over two steps; `make` sets it.
fn parameter<S, R, const N: usize, const M: usize>(
    make: impl Fn(f64) -> S,
    rule: R,
    parameter: &str,
    value: f64,
) where
    S: Model<N, M> + Variational<R>,
    R: Rule + Copy,
{
    let mut random = Random::new(23);
    let start = S::point(&mut random);
    let dw: [[f64; M]; 2] = [random.array(-0.3, 0.3), random.array(-0.3, 0.3)];
    let integrator = Integrator::new(make(value), rule);
    let mut state = start;
    let (_, mut total) = integrator
        .step_with_derivatives(&mut state, 0.1, &dw[0])
        .unwrap();
    let (tangent, own) = integrator
        .step_with_derivatives(&mut state, 0.1, &dw[1])
        .unwrap();
    total.advance(&tangent, &own);
    let got = total.get(parameter).unwrap();
    let differences = derivatives(|d| {
        let integrator = Integrator::new(make(value + d), rule);
        let mut state = start;
        integrator.step(&mut state, 0.1, &dw[0]).unwrap();
        stepped(&integrator, &state, 0.1, &dw[1])
    });
    for (got, expected) in got.q.iter().chain(&got.p).zip(&differences) {
        assert!(
            (got - expected).abs() <= DIFFERENCES * (1.0 + expected.abs()),
            "{}, {parameter}: {got:e}, by differences {expected:e}",
            name(&integrator)
        );
    }
}

macro_rules! parameters {
    ($($model:ident = $make:expr, [$($rule:ident),*]: $($name:literal ($($field:tt)*) = $value:expr),*;)*) => {$(
        parameters!(@ $model, $make, [$($rule),*] [$($name ($($field)*) = $value),*]);
    )*};
    (@ $model:ident, $make:expr, [$($rule:ident),*] $parameters:tt) => {$(
        parameters!(@@ $model, $make, $rule, $parameters);
    )*};
    (@@ $model:ident, $make:expr, $rule:ident, [$($name:literal ($($field:tt)*) = $value:expr),*]) => {$(
        parameter(
            |x| {
                let mut model: $model = $make;
                model.$($field)* = x;
                model
            },
            $rule,
            $name,
            $value,
        );
    )*};
}

#[test]
fn sensitivities_are_derivatives_in_the_parameters() {
    parameters! {
        Pendulum = oracle::pendulum(), [InitialPoint, Endpoint, Midpoint, Taylor2]: "g" (g) = 9.8;
        Kubo = oracle::kubo(), [InitialPoint, Endpoint, Midpoint]: "a" (a) = 1.3, "sigma" (sigma) = 0.6;
        DoublePendulum = oracle::double_pendulum(), [InitialPoint, Endpoint, Midpoint]:
            "m[0]" (m[0]) = 1.0, "m[1]" (m[1]) = 0.7, "l[0]" (l[0]) = 0.8, "l[1]" (l[1]) = 1.1, "g" (g) = 2.0, "s" (s) = 0.4;
        Mixed = oracle::mixed(), [InitialPoint, Endpoint, Midpoint]: "c" (c) = 0.3, "s[2]" (s[2]) = 0.5, "s[0]" (s[0]) = 0.4;
        Polar = oracle::polar(), [InitialPoint, Endpoint, Midpoint]: "m" (m) = 1.2, "sigma[1]" (sigma[1]) = 0.2;
        Driven = oracle::driven(), [InitialPoint, Endpoint, Midpoint]: "b" (b) = 0.5, "sigma[0]" (sigma[0]) = 0.6;
        Damped = oracle::damped(), [InitialPoint, Endpoint, Midpoint]: "nu" (nu) = 0.7, "m" (m) = 1.3;
    }
}

#[test]
fn names_of_the_parameters() {
    assert_eq!(Kubo::PARAMETERS, ["a", "sigma"]);
    let integrator = Integrator::new(oracle::kubo(), Midpoint);
    let state = State::new([1.0], [0.0]);
    let sensitivity = integrator.sensitivity(&state, 0.1, &[0.0]).unwrap();
    let names: Vec<&str> = sensitivity.iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["a", "sigma"]);
    assert!(sensitivity.get("b").is_none());
}

/// A step that fails returns no derivatives and leaves the state unchanged.
#[test]
fn derivatives_of_a_step_that_fails() {
    let integrator = Integrator::new(oracle::pendulum(), Midpoint);
    let mut state = State::new([1.0], [f64::NAN]);
    let error = integrator.step_with_derivatives(&mut state, 0.1, &[]);
    assert!(matches!(error, Err(StepError::NonFiniteInput { .. })));
    assert_eq!((state.t, state.q), (0.0, [1.0]));
    let state = State::new([1.0], [0.0]);
    assert!(matches!(
        integrator.tangent(&state, 0.0, &[]),
        Err(StepError::StepSize { .. })
    ));
}
