//! Bad input at run time. Each case returns the right error with the right numbers, the message
//! contains the numbers, and the state keeps its bits.

use sve_models::assert_matches;
use sve_models::case::Case;
use sve_models::checks::{assert_says, bits, failure};
use sve_models::functions::Point;
use sve_models::models::Quartic;
use sve_models::oracle::{
    actions, cases, kubo, magnetic, mixed, oscillator, pendulum, quartic, spherical_pendulum,
};
use sve_models::random::Random;
use sve_models::stepper::{Stepper, with_taylor2};
use sve_runtime::prelude::*;

const BAD: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

/// Returns the error of a case's step that must fail and leave the state unchanged.
fn failure_of(case: &dyn Case, start: &Point, h: f64, dw: &[f64]) -> StepError {
    let mut state = start.clone();
    let result = case.step(&mut state, h, dw);
    let name = case.name();
    assert_eq!(state.bits(), start.bits(), "{name}: the state was touched");
    match result {
        Ok(()) => panic!("{name}: no error from {start:?} with h = {h}, dw = {dw:?}"),
        Err(error) => error,
    }
}

fn names_what_is_not_finite(case: &dyn Case, state: &Point, dw: &[f64], expected: &str, bad: f64) {
    let error = failure_of(case, state, 0.1, dw);
    let StepError::NonFiniteInput { what, value, t } = &error else {
        panic!("{}: {error:?}", case.name());
    };
    assert_eq!(what, expected, "{}", case.name());
    assert_eq!(value.to_bits(), bad.to_bits());
    assert_eq!(t.to_bits(), state.t.to_bits());
    assert_says(
        &error,
        &[&format!("{expected} is {bad}"), &format!("t = {t}")],
    );
}

fn names_what_is_bad(case: &dyn Case, random: &mut Random) {
    let good = case.model().point(random);
    let (n, m) = case.dimensions();
    let dw = vec![0.2; m];
    for bad in BAD {
        for i in 0..n {
            let mut state = good.clone();
            state.q[i] = bad;
            names_what_is_not_finite(case, &state, &dw, &format!("q[{i}]"), bad);
            let mut state = good.clone();
            state.p[i] = bad;
            names_what_is_not_finite(case, &state, &dw, &format!("p[{i}]"), bad);
        }
        for i in 0..m {
            let mut dw = dw.clone();
            dw[i] = bad;
            names_what_is_not_finite(case, &good, &dw, &format!("dw[{i}]"), bad);
        }
        let mut state = good.clone();
        state.t = bad;
        names_what_is_not_finite(case, &state, &dw, "t", bad);
    }
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0] {
        let error = failure_of(case, &good, bad, &dw);
        let StepError::StepSize { h } = error else {
            panic!("{}: {error:?}", case.name());
        };
        assert_eq!(h.to_bits(), bad.to_bits());
        assert_says(&error, &[&format!("h = {bad}")]);
    }
}

#[test]
fn bad_input_of_every_model_and_rule_is_named() {
    let mut random = Random::new(10);
    for case in cases() {
        names_what_is_bad(&*case, &mut random);
    }
}

/// `step_prepared` with a step size for which `prepare` was not called.
#[test]
fn step_size_that_was_not_prepared() {
    let pendulum = Integrator::new(pendulum(), Endpoint);
    let prepared = OneStepMethod::prepare(&pendulum, 0.1).unwrap();
    let start = State::new([1.0], [0.0]);
    let mut state = start;
    for h in [f64::NAN, f64::INFINITY] {
        let error = pendulum.step_prepared(&prepared, &mut state, h, &[]);
        assert_matches!(error, Err(StepError::StepSize { .. }));
        assert_eq!(bits(&state), bits(&start));
    }
}

/// A step that succeeds changes the bits of the state, so the comparison of bits can fail.
#[test]
fn without_a_failure() {
    let mut state = State::new([1.0], [0.0]);
    let before = bits(&state);
    let pendulum = Integrator::new(pendulum(), Midpoint);
    pendulum.step(&mut state, 0.1, &[]).unwrap();
    assert!(bits(&state).iter().zip(&before).all(|(a, b)| a != b));
}

#[test]
fn newton_limit() {
    // with one iteration each the solution could still be followed from short steps
    let options = Newton {
        max_iterations: 0,
        ..Newton::default()
    };
    let pendulum = Integrator::new(pendulum(), Midpoint).with_newton(options);
    let start = State::at(2.5, [1.0], [3.0]);
    let error = failure(&pendulum, &start, 0.5, &[]);
    let StepError::NotConverged {
        t,
        h,
        iterations,
        residual,
        tolerance,
    } = error
    else {
        panic!("{error:?}");
    };
    assert_eq!((t, h, iterations), (2.5, 0.5, 0));
    assert_eq!(tolerance, options.tolerance);
    assert!(tolerance < residual && residual < 1.0, "{residual}");
    let numbers = [residual, tolerance].map(|x| format!("{x:e}"));
    assert_says(&error, &["after 0 iterations", "t = 2.5", "h = 5e-1"]);
    assert_says(&error, &["max_iterations", &numbers[0], &numbers[1]]);
    // the default limit is enough
    let pendulum = pendulum.with_newton(Newton::default());
    pendulum.step(&mut start.clone(), 0.5, &[]).unwrap();
}

/// An implicit equation with a huge increment may have no solution. The step then returns one of
/// several errors.
#[test]
fn no_solution() {
    let integrator = Integrator::new(mixed(), Endpoint);
    let start = State::new([0.3, -0.2], [0.5, 0.4]);
    let mut failures = 0;
    let mut random = Random::new(11);
    for _ in 0..200 {
        let dw = random.array(-30.0, 30.0);
        let mut state = start;
        match integrator.step(&mut state, 0.1, &dw) {
            Ok(()) => assert!(state.q.iter().chain(&state.p).all(|x| x.is_finite())),
            Err(
                StepError::NotConverged { t, h, .. }
                | StepError::BranchLost { t, h, .. }
                | StepError::Singular { t, h, .. }
                | StepError::NonFiniteResult { t, h, .. },
            ) => {
                assert_eq!((t, h), (0.0, 0.1));
                assert_eq!(bits(&state), bits(&start));
                failures += 1;
            }
            Err(other) => panic!("{other:?}"),
        }
    }
    assert!(failures > 0, "increments of 30 always had a solution");
}

#[test]
fn pole_of_the_spherical_pendulum() {
    // no motion along the meridian: the step stays at the pole
    for p in [[0.0, 0.5], [0.0, -1e-300]] {
        let start = State::at(1.5, [0.0, 0.3], p);
        for rule in with_taylor2(&spherical_pendulum()) {
            let error = rule.failure(&start, 0.25, &[]);
            let StepError::SingularMass { t, h, q, .. } = &error else {
                panic!("{} from {start:?}: {error:?}", rule.name());
            };
            assert_eq!((*t, *h, q.as_slice()), (1.5, 0.25, &[0.0, 0.3][..]));
            assert_says(
                &error,
                &["t = 1.5", "h = 2.5e-1", "[0.0, 0.3]", "mass matrix"],
            );
        }
    }
    let velocity = spherical_pendulum().velocity(&State::new([0.0, 0.3], [0.0, 0.5]));
    assert_matches!(velocity, Err(StepError::SingularMass { h: 0.0, .. }));
}

/// A mass that vanishes as a parameter.
#[test]
fn no_mass() {
    let massless = Quartic {
        m: 0.0,
        ..quartic()
    };
    let rules = with_taylor2(&massless).into_iter();
    for rule in rules.filter(|rule| rule.rule() != "midpoint") {
        let error = rule.failure(&State::new([1.0], [0.5]), 0.1, &[]);
        assert_matches!(error, StepError::SingularMass { .. });
    }
}

fn overflows<const N: usize, const M: usize>(
    rule: &dyn Stepper<[f64; N], [f64; M]>,
    start: State<[f64; N]>,
    dw: [f64; M],
) {
    let error = rule.failure(&start, 0.5, &dw);
    let StepError::NonFiniteResult { t, h, q, p } = &error else {
        panic!("{} from {start:?}: {error:?}", rule.name());
    };
    assert_eq!((*t, *h), (start.t, 0.5));
    assert_eq!((q.as_slice(), p.as_slice()), (&start.q[..], &start.p[..]));
    let numbers = [
        format!("t = {t}"),
        format!("q = {q:?}"),
        format!("p = {p:?}"),
    ];
    assert_says(&error, &["h = 5e-1", &numbers[0], &numbers[1], &numbers[2]]);
}

#[test]
fn overflow() {
    for rule in with_taylor2(&quartic()) {
        overflows(&*rule, State::at(0.25, [1e200], [-1.0]), []);
    }
    let largest = State::new([f64::MAX], [f64::MAX]);
    overflows(&Integrator::new(oscillator(), Endpoint), largest, [0.0]);
    let largest = State::new([-f64::MAX], [f64::MAX]);
    let explicit = Integrator::new(oscillator(), InitialPoint);
    overflows(&explicit, largest, [f64::MAX]);
    let far = State::new([1e200, 1.0], [0.0, 1.0]);
    overflows(&Integrator::new(magnetic(), InitialPoint), far, []);
    overflows(&Integrator::new(magnetic(), Midpoint), far, []);
    let far = State::new([1e160], [0.0]);
    overflows(&Integrator::new(actions(), Endpoint), far, [0.1; 2]);
    overflows(&Integrator::new(actions(), Midpoint), far, [0.1; 2]);
    // time itself
    let late = State::at(f64::MAX, [1.0], [0.0]);
    let error = failure(&Integrator::new(pendulum(), Endpoint), &late, f64::MAX, &[]);
    assert_matches!(error, StepError::Time { .. });
}

/// Increments far beyond any that is drawn. With `x = ah + σΔW` the limit of Kubo's step for large
/// x is the half turn, which it misses by 4/x; the coefficients of the linear solve cancel, which
/// costs ε|x| more. Where x² overflows the result means nothing, but it is finite or an error,
/// never NaN.
#[test]
fn huge_increments() {
    let integrator = Integrator::new(kubo(), Midpoint);
    let start = State::new([1.0], [0.5]);
    for size in [1e3, 1e6, 1e10, 1e150, 1e200, 1e308] {
        for dw in [size, -size] {
            let mut state = start;
            match integrator.step(&mut state, 0.1, &[dw]) {
                Ok(()) => {
                    let error = (state.q[0] + 1.0).hypot(state.p[0] + 0.5);
                    let x = 0.13 + 0.6 * dw;
                    let bound = 5.0 / x.abs() + 4.0 * f64::EPSILON * x.abs();
                    assert!(error < bound || size > 1e150, "dw = {dw:e}: {state:?}");
                    assert!(error.is_finite(), "dw = {dw:e}: {state:?}");
                }
                Err(StepError::NonFiniteResult { .. }) => assert_eq!(bits(&state), bits(&start)),
                Err(error) => panic!("{error:?}"),
            }
        }
    }
}

/// Polar coordinates with a radial force: the angle has no mass at the origin.
mod polar {
    use sve_runtime::prelude::*;

    pub(super) struct Polar;

    #[variational(initial_point, endpoint, midpoint, taylor2)]
    impl Polar {
        fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
            0.5 * (v[0] * v[0] + (q[0] * v[1]).powi(2)) - q[0]
        }
    }
}

/// At rest in the origin the equations hold for every angular velocity. The step returns an error
/// and not one of the solutions.
#[test]
fn equations_that_many_velocities_satisfy_are_singular() {
    let rules = with_taylor2(&polar::Polar).into_iter();
    for rule in rules.filter(|rule| ["initial_point", "taylor2"].contains(&rule.rule())) {
        let error = rule.failure(&State::new([0.0, 0.0], [0.0, 0.0]), 0.1, &[]);
        assert_matches!(error, StepError::SingularMass { .. });
    }
}
