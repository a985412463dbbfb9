//! Arguments that a path with a tolerance refuses, and the place where it ends.

use sve_runtime::prelude::*;

use super::systems::{Edge, Fall, Kepler, Pendulum, Wall, perihelion};

/// The size of the first step is a guess: a bad one costs attempts or steps, and nothing more.
#[test]
fn no_first_size_runs_to_steps_of_size_zero() {
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Gauss::<8>);
    let kepler = Integrator::new(Kepler, Gauss::<8>);
    for t in [0.0, 1e6] {
        for h in [1e-3, 1e-300, 5e-324, 1e10, 1e300] {
            let start = State::at(t, [1.0], [0.0]);
            let mut path = pendulum
                .trajectory(start, h, NoNoise)
                .tolerance(1e-10)
                .until(t + 30.0);
            let last = path.by_ref().last().unwrap().unwrap();
            assert_eq!(last.t, t + 30.0);
            assert!(path.step() < 1200, "{h:e}: {} steps", path.step());
            let start = State {
                t,
                ..perihelion(0.9)
            };
            let path = kepler.trajectory(start, h, NoNoise).tolerance(1e-10);
            assert_eq!(path.until(t + 30.0).last().unwrap().unwrap().t, t + 30.0);
        }
    }
}

#[test]
fn tolerances_and_sizes_that_are_none_are_errors() {
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Gauss::<8>);
    let start = State::at(0.5, [1.0], [0.0]);
    for tolerance in [f64::NAN, 0.0, -1e-8, 9e-16, 1.1e-2, f64::INFINITY] {
        let mut path = pendulum
            .trajectory(start, 0.1, NoNoise)
            .tolerance(tolerance);
        let error = path.next().unwrap().unwrap_err();
        assert!(
            matches!(&error, StepError::Tolerance { t: 0.5, tolerance: given } if given.to_bits() == tolerance.to_bits()),
            "{error}"
        );
        assert_eq!((path.next(), path.state()), (None, &start));
        let path = pendulum
            .trajectory(start, 0.1, NoNoise)
            .tolerance(tolerance);
        let error = path.until(1.0).last().unwrap().unwrap_err();
        assert!(matches!(error, StepError::Tolerance { .. }), "{error}");
    }
    for tolerance in [1e-15, 1e-2] {
        let mut path = pendulum
            .trajectory(start, 0.1, NoNoise)
            .tolerance(tolerance);
        path.next().unwrap().unwrap();
    }
    for h in [0.0, -0.0, f64::NAN, f64::INFINITY] {
        let path = || pendulum.trajectory(start, h, NoNoise).tolerance(1e-8);
        let error = path().next().unwrap().unwrap_err();
        assert!(matches!(error, StepError::StepSize { .. }), "{error}");
        let error = path().until(1.0).last().unwrap().unwrap_err();
        assert!(matches!(error, StepError::StepSize { .. }), "{error}");
    }
}

#[test]
fn times_behind_are_errors() {
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Gauss::<8>);
    let start = State::new([1.0], [0.0]);
    for t in [-1.0, f64::NAN, f64::INFINITY] {
        let path = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-8);
        let error = path.until(t).last().unwrap().unwrap_err();
        assert!(matches!(error, StepError::TimeOrder { .. }), "{error}");
    }
}

/// A fall into a centre has no solution beyond its collision, at t = π/√8 from rest at 1.
#[test]
fn a_collision_ends_a_path() {
    let fall = Integrator::new(Fall, Gauss::<8>);
    let mut path = fall
        .trajectory(State::new([1.0], [0.0]), 0.1, NoNoise)
        .tolerance(1e-10);
    let error = path.by_ref().find_map(Result::err).unwrap();
    let StepError::StepTooSmall { t, h, least, .. } = error else {
        panic!("{error}");
    };
    let collision = core::f64::consts::PI / 8.0_f64.sqrt();
    assert!(
        (t - collision).abs() < 1e-8 && h > 0.0 && least < 1e-15,
        "{t} {h:e}"
    );
    assert_eq!((path.state().t, path.next()), (t, None));
    assert!(path.step() < 500, "{}", path.step());
}

/// The force is not a number beyond the edge: steps become shorter up to it.
#[test]
fn the_edge_of_the_domain_ends_a_path() {
    let edge = Integrator::new(Edge, Gauss::<8>);
    let mut path = edge
        .trajectory(State::new([0.0], [2.0]), 0.1, NoNoise)
        .tolerance(1e-8);
    let error = path.by_ref().find_map(Result::err).unwrap();
    assert!(
        matches!(
            error,
            StepError::StepTooSmall { .. } | StepError::OutsideDomain { .. }
        ),
        "{error}"
    );
    assert!(
        path.state().q[0] > 0.999 && path.step() < 1000,
        "{}",
        path.step()
    );
}

/// A start without a step has the error that a step of fixed size has.
#[test]
fn a_start_that_is_not_finite_is_named() {
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Gauss::<8>);
    for start in [
        State::new([f64::NAN], [0.0]),
        State::new([1.0], [f64::INFINITY]),
    ] {
        let mut path = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-8);
        let error = path.next().unwrap().unwrap_err();
        assert!(matches!(error, StepError::NonFiniteInput { .. }), "{error}");
    }
    let nan = Integrator::new(Pendulum { g: f64::NAN }, Gauss::<8>);
    let mut path = nan
        .trajectory(State::new([1.0], [0.0]), 0.1, NoNoise)
        .tolerance(1e-8);
    let error = path.next().unwrap().unwrap_err();
    assert!(
        matches!(error, StepError::NonFiniteResult { .. }),
        "{error}"
    );
}

#[test]
fn the_number_of_steps_is_limited() {
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Gauss::<8>);
    let path = pendulum
        .trajectory(State::new([1.0], [0.0]), 0.1, NoNoise)
        .tolerance(1e-8);
    let mut path = path.max_steps(7);
    assert_eq!(path.by_ref().flatten().count(), 7);
    let path = pendulum
        .trajectory(State::new([1.0], [0.0]), 0.1, NoNoise)
        .tolerance(1e-8);
    let error = path.max_steps(7).until(1e9).last().unwrap().unwrap_err();
    assert!(
        matches!(error, StepError::TooManySteps { steps: 7, .. }),
        "{error}"
    );
    assert!(error.to_string().contains("max_steps"), "{error}");
}

/// Also where no end of the path makes a huge first size smaller.
#[test]
fn a_huge_first_size_is_made_smaller() {
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Gauss::<8>);
    for h in [1e25, -1e100, 1e300, f64::MAX] {
        let start = State::new([1.0], [0.0]);
        let path = pendulum.trajectory(start, h, NoNoise).tolerance(1e-10);
        let states: Result<Vec<_>, _> = path.take(400).collect();
        let last = states.unwrap_or_else(|error| panic!("{h:e}: {error}"))[399];
        assert!(last.t * h.signum() > 1.0, "{h:e}: {}", last.t);
    }
}

/// The steps up to a time that was asked for are no steps of the path, and the last size is that of
/// the last step.
#[test]
fn the_limit_of_steps_is_that_of_the_path() {
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Gauss::<8>);
    let path = || {
        let start = State::new([1.0], [0.0]);
        pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-10)
    };
    let times: Vec<f64> = path().take(5).map(|state| state.unwrap().t).collect();
    let mut limited = path().max_steps(5);
    let error = limited.by_ref().nth(5).unwrap().unwrap_err();
    let StepError::TooManySteps { t, h, steps: 5 } = error else {
        panic!("{error}")
    };
    assert!(t == times[4] && (h - (times[4] - times[3])).abs() < 1e-14);
    let within = 0.5 * (times[3] + times[4]);
    let states: Result<Vec<_>, _> = path().max_steps(5).at([within, times[4]]).collect();
    assert_eq!(states.map(|states| states.len()), Ok(2));
}

/// A step that is longer than a wall may pass it between its stages. Far from it, its potential is
/// subnormal, or 0.
#[test]
fn no_step_is_longer_than_its_limit() {
    let wall = Integrator::new(Wall, Gauss::<8>);
    for sign in [1.0, -1.0] {
        for k in 0..20 {
            let distance = 20.0 + 1.25 * f64::from(k);
            let start = State::new([-sign * distance], [1.0]);
            let path = wall.trajectory(start, 0.1 * sign, NoNoise).tolerance(1e-9);
            let mut path = path.max_step(2.0);
            let mut longest = 0.0_f64;
            while path.state().t * sign < 2.0 * distance {
                let before = path.state().t;
                let state = path.next().unwrap().unwrap();
                longest = longest.max((state.t - before).abs());
            }
            assert!((1.9..=2.0 + 1e-12).contains(&longest), "{longest}");
            let p = path.state().p[0];
            assert!((p + 1.0).abs() < 1e-7, "{k}: {p}");
        }
    }
    for size in [0.0, -1.0, f64::NAN] {
        let start = State::new([-5.0], [1.0]);
        let path = wall.trajectory(start, 0.1, NoNoise).tolerance(1e-9);
        let error = path.max_step(size).next().unwrap().unwrap_err();
        assert!(matches!(error, StepError::StepSize { .. }), "{error}");
    }
}
