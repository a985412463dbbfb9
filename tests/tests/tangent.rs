//! The tangent map and the sensitivities of every step against differences of the step itself, and the exact identities
//! that a tangent map obeys.

use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Tangent, Variational};
use sve_tests::differences::derivatives;
use sve_tests::models::{Damped, DoublePendulum, Driven, Kubo, Mixed, Pendulum, Polar};
use sve_tests::oracle::{self, Model, Rule, Visitor, every_step, name};
use sve_tests::random::Random;

/// Differences are good to 1e-12 (see `differences`) times derivatives of the seventh order, below 100 here.
const DIFFERENCES: f64 = 1e-9;

/// Rounding: some 50 operations an entry, and entries up to 10 that are multiplied and cancel.
const SYMPLECTIC: f64 = 1e-12;

/// `(q₁, p₁)`.
fn image<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    mut state: State<[f64; N]>,
    h: f64,
    dw: &[f64; M],
) -> [[f64; N]; 2]
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    integrator.step(&mut state, h, dw).unwrap();
    [state.q, state.p]
}

/// The derivative of both rows of a result, by differences.
fn slope<const N: usize>(f: impl Fn(f64) -> [[f64; N]; 2]) -> [[f64; N]; 2] {
    [0, 1].map(|part| derivatives(|d| f(d)[part]))
}

struct Tangents(Random);

impl Visitor for Tangents {
    fn visit<S, R, const N: usize, const M: usize>(&mut self, integrator: &Integrator<S, R>)
    where
        S: Model<N, M> + Variational<R>,
        R: Rule,
    {
        for _ in 0..5 {
            let start = S::point(&mut self.0);
            let dw = self.0.array(-0.3, 0.3);
            let h = 0.1;
            let tangent = integrator.tangent(&start, h, &dw).unwrap();
            let what = |entry: &str| format!("{}: {entry} at {start:?}, {dw:?}", name(integrator));
            for column in 0..2 * N {
                let moved = |d: f64| {
                    let mut from = start;
                    match column {
                        i if i < N => from.q[i] += d,
                        i => from.p[i - N] += d,
                    }
                    image(integrator, from, h, &dw)
                };
                let [dq, dp] = slope(moved);
                for row in 0..2 * N {
                    let expected = if row < N { dq[row] } else { dp[row - N] };
                    let got = tangent[row][column];
                    assert!(
                        (got - expected).abs() <= DIFFERENCES * (1.0 + expected.abs()),
                        "{}: {got:e}, by differences {expected:e}",
                        what(&format!("[{row}][{column}]"))
                    );
                }
            }
            if !S::FORCED {
                let defect = tangent.symplectic_defect();
                assert!(defect < SYMPLECTIC, "{}: {defect:e}", what("defect"));
            }
        }
    }
}

#[test]
fn tangents_are_derivatives_of_steps_and_symplectic() {
    every_step(&mut Tangents(Random::new(17)));
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
        [state.q, state.p]
    };
    let (mut state, mut total) = (start, Tangent::identity());
    for k in 0..50 {
        let dw = increments(k);
        let (tangent, _) = integrator
            .step_with_derivatives(&mut state, 0.02, &dw)
            .unwrap();
        total = &tangent * &total;
    }
    assert_eq!([state.q, state.p], run(start));
    assert!(total.symplectic_defect() < 1e-11);
    let [dq, dp] = slope(|d| {
        run(State {
            q: [0.4 + d, -0.3],
            ..start
        })
    });
    for i in 0..2 {
        assert!((total[i][0] - dq[i]).abs() < 1e-8 * (1.0 + dq[i].abs()));
        assert!((total[2 + i][0] - dp[i]).abs() < 1e-8 * (1.0 + dp[i].abs()));
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
    let [dq, dp] = slope(|d| {
        let integrator = Integrator::new(make(value + d), rule);
        let mut state = start;
        integrator.step(&mut state, 0.1, &dw[0]).unwrap();
        image(&integrator, state, 0.1, &dw[1])
    });
    for i in 0..N {
        for (got, expected) in [(got.q[i], dq[i]), (got.p[i], dp[i])] {
            assert!(
                (got - expected).abs() <= DIFFERENCES * (1.0 + expected.abs()),
                "{}, {parameter}: {got:e}, by differences {expected:e}",
                name(&integrator)
            );
        }
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

/// A step that fails has no derivatives, and leaves the state.
#[test]
fn derivatives_of_a_step_that_fails() {
    let integrator = Integrator::new(oracle::pendulum(), Midpoint);
    let mut state = State::new([1.0], [f64::NAN]);
    let error = integrator.step_with_derivatives(&mut state, 0.1, &[]);
    assert!(matches!(error, Err(StepError::NonFiniteInput { .. })));
    assert_eq!((state.t, state.q), (0.0, [1.0]));
    let state = State::new([1.0], [0.0]);
    assert!(matches!(
        integrator.tangent(&state, -0.1, &[]),
        Err(StepError::StepSize { .. })
    ));
}
