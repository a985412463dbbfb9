//! The tangent map and the sensitivities of every step against differences of the step itself, and
//! the exact identities that a tangent map obeys: a step of a variational integrator is symplectic,
//! `MᵀΩM = Ω`, with noise too.

use sve_models::assert_matches;
use sve_models::case::Case;
use sve_models::checks::assert_relative;
use sve_models::differences::derivatives;
use sve_models::functions::Point;
use sve_models::models::{Damped, DoublePendulum, Driven, Kubo, Mixed, Pendulum, Polar};
use sve_models::oracle::{self, Model, Rule, cases, name};
use sve_models::random::Random;
use sve_models::steps::stepped;
use sve_runtime::prelude::*;
use sve_runtime::system::System;
use sve_runtime::{Tangent, Variational};

/// Differences are good to 1e-12 (see `differences`) times derivatives of the seventh order and the
/// condition of the Jacobian, below 100 here. A step that is not symplectic is wrong by the order
/// of h², 1e-2.
const DIFFERENCES: f64 = 1e-9;

/// Rounding: some 50 operations an entry, and entries up to 10 that are multiplied and cancel.
const SYMPLECTIC: f64 = 1e-12;

/// The columns of the Jacobian of a step, by differences.
fn jacobian(start: &Point, step: impl Fn(&Point) -> Point) -> Vec<Vec<f64>> {
    let n = start.q.len();
    let column = |column: usize| {
        derivatives(|d| {
            let mut from = start.clone();
            match column {
                i if i < n => from.q[i] += d,
                i => from.p[i - n] += d,
            }
            step(&from).entries().copied().collect()
        })
    };
    (0..2 * n).map(column).collect()
}

/// Largest entry of `MᵀΩM − Ω` for the columns of M; not a number if one is not.
fn defect(m: &[Vec<f64>]) -> f64 {
    let n = m.len() / 2;
    let pairs = (0..2 * n).flat_map(|a| (0..2 * n).map(move |b| (a, b)));
    let entries = pairs.map(|(a, b)| {
        let bracket: f64 = (0..n)
            .map(|i| m[a][i] * m[b][n + i] - m[a][n + i] * m[b][i])
            .sum();
        let omega = f64::from(u8::from(b == a + n)) - f64::from(u8::from(a == b + n));
        (bracket - omega).abs()
    });
    entries.fold(0.0, |worst, x| if x <= worst { worst } else { x })
}

fn tangents_are_derivatives(case: &dyn Case, random: &mut Random) {
    let (h, model) = (0.1, case.model());
    for _ in 0..50 {
        let start = model.point(random);
        let dw = random.vector(case.dimensions().1, -0.3, 0.3);
        let row = format!("{} at {start:?}, {dw:?}", case.name());
        let derived = case.differentiated(&mut start.clone(), h, &dw).unwrap();
        let differences = jacobian(&start, |from| case.stepped(from, h, &dw));
        for (column, expected) in differences.iter().enumerate() {
            let found: Vec<f64> = derived.tangent.iter().map(|row| row[column]).collect();
            assert_relative(&found, expected, DIFFERENCES, &row);
        }
        // a force contracts or feeds the symplectic form: see `forces`
        if !model.is_forced() {
            let [derived, by_differences] = [derived.defect, defect(&differences)];
            assert!(derived < SYMPLECTIC, "{row}: defect {derived:e}");
            assert!(
                by_differences < DIFFERENCES,
                "{row}: defect {by_differences:e}"
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

/// The scheme that the paper prints as symplectic Euler–Maruyama is backward Euler. Its determinant
/// is 1/(1+h²).
#[test]
fn the_printed_scheme_is_not_symplectic() {
    let h = 0.1;
    let printed = |from: &Point| {
        let (q, p) = (from.q[0], from.p[0]);
        let kick = 0.3 * oracle::oscillator().sigma;
        // q₁ = q₀ + h p₁, p₁ = p₀ − h q₁ + σΔW, solved for p₁
        let p = (p - h * q + kick) / (1.0 + h * h);
        Point::new(&[q + h * p], &[p])
    };
    let defect = defect(&jacobian(&Point::new(&[0.7], &[-0.4]), printed));
    let expected = 1.0 - 1.0 / (1.0 + h * h);
    assert!((defect - expected).abs() < DIFFERENCES, "{defect:e}");
    assert!(defect > 1e6 * DIFFERENCES);
}

/// The tangent of many steps is the product of theirs, and symplectic to the rounding of the
/// products.
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
    let differences = derivatives(|d| run(State::new([0.4 + d, -0.3], start.p)));
    let column: Vec<f64> = (0..4).map(|row| total[row][0]).collect();
    assert_relative(&column, &differences, 1e-8, "50 steps");
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
    let row = format!("{}, {parameter}", name(&integrator));
    assert_relative(&[got.q, got.p].concat(), &differences, DIFFERENCES, row);
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
    assert_matches!(error, Err(StepError::NonFiniteInput { .. }));
    assert_eq!((state.t, state.q), (0.0, [1.0]));
    let state = State::new([1.0], [0.0]);
    let tangent = integrator.tangent(&state, 0.0, &[]);
    assert_matches!(tangent.map(|_| ()), Err(StepError::StepSize { .. }));
}
