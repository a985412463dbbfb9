//! Units, states and steps of extreme size.

use sve_models::assert_matches;
use sve_models::checks::{assert_close, assert_says, failure};
use sve_models::models::{Kepler, Pendulum, Quartic};
use sve_models::stepper::Stepper;
use sve_runtime::prelude::*;

/// A planet in units of length and time that are powers of two: the same bits, scaled.
#[test]
fn units_of_two_to_the_sixty() {
    let (length, time) = (2.0_f64.powi(60), 2.0_f64.powi(-60));
    for (length, time) in [(length, 1.0), (1.0, time), (time, length), (length, length)] {
        let speed = length / time;
        let reference = Integrator::new(Kepler { k: 1.0, sigma: 0.1 }, Midpoint);
        let k = length * speed * speed;
        // γ/r times an increment is an action; the increment may be measured in any power of two,
        // here that of the time
        let other = Integrator::new(Kepler { k, sigma: 0.1 * k }, Midpoint);
        let mut a = State::new([1.0, 0.2], [0.1, 0.9]);
        let mut b = State::new(a.q.map(|x| x * length), a.p.map(|x| x * speed));
        for step in 0..200 {
            let dw = Wiener::new(4).increment(step, 0, 0.01);
            reference.step(&mut a, 0.01, &[dw]).unwrap();
            other.step(&mut b, 0.01 * time, &[dw * time]).unwrap();
            assert_eq!(b.q, a.q.map(|x| x * length));
            assert_eq!(b.p, a.p.map(|x| x * speed));
        }
    }
}

/// From the smallest numbers to the largest: a finite state or an error, and what is at rest stays
/// there.
#[test]
fn subnormal_and_huge_states() {
    let midpoint = Integrator::new(Quartic { m: 1.0, k: 1.0 }, Midpoint);
    let pendulum = Integrator::new(Pendulum { g: 9.8 }, Midpoint);
    let (mut made, mut errors) = (0, 0);
    for q in [
        0.0,
        5e-324,
        1e-310,
        1e-200,
        1.0,
        1e50,
        1e100,
        1e150,
        1e300,
        f64::MAX,
    ] {
        for p in [0.0, -5e-324, 1e-310, -1e-160, 1.0, 1e77, 1e154, f64::MAX] {
            for h in [1e-12, 0.1, 1e3] {
                for start in [State::new([q], [p]), State::new([-q], [p])] {
                    let mut state = start;
                    let results = [
                        midpoint.step(&mut state, h, &[]).map(|()| state),
                        pendulum.step(&mut start.clone(), h, &[]).map(|()| start),
                    ];
                    for result in results {
                        match result {
                            Ok(end) => {
                                assert!(end.q[0].is_finite() && end.p[0].is_finite());
                                made += 1;
                            }
                            Err(_) => errors += 1,
                        }
                    }
                }
            }
        }
    }
    let rest = State::new([0.0], [0.0]);
    let mut state = rest;
    midpoint.step(&mut state, 1e3, &[]).unwrap();
    assert_eq!((state.q, state.p), (rest.q, rest.p));
    assert!(made > 200 && errors > 20, "{made} {errors}");
}

/// A subnormal oscillation keeps its digits as far as there are any: p₁ − p₀ = −h q̄ of the free
/// pendulum near rest.
#[test]
fn small_oscillations_of_a_pendulum() {
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
    for size in [1e-8, 1e-100, 1e-300] {
        let state = pendulum.after(State::new([size], [0.0]), 0.1, &[], 1);
        // the Cayley map of the linear oscillator with x = h
        let x = 0.1;
        let scale = 1.0 + x * x / 4.0;
        let expected = [(1.0 - x * x / 4.0) / scale, -x / scale];
        let found = [state.q[0] / size, state.p[0] / size];
        assert_close(&found, &expected, 1e-15, size);
    }
}

/// From steps below the digits of the state to ones of many periods: a step, or an error that gives
/// h.
#[test]
fn steps_of_all_sizes() {
    let pendulum = Integrator::new(Pendulum { g: 9.8 }, Midpoint);
    for h in [
        1e-300, 1e-30, 1e-12, 1e-6, 1e-3, 0.1, 0.5, 1.0, 10.0, 1e3, 1e300,
    ] {
        let start = State::new([1.0], [0.5]);
        let mut state = start;
        match pendulum.step(&mut state, h, &[]) {
            Ok(()) => {
                if h <= 1e-6 {
                    // the increments are right to their own digits, as far as the state can hold
                    // them
                    let (dq, dp) = (state.q[0] - 1.0, state.p[0] - 0.5);
                    let force = -9.8 * 1.0_f64.sin();
                    let expected = [h * 0.5, h * force];
                    assert_close(&[dq, dp], &expected, 2e-16 + 10.0 * h * h, h);
                }
            }
            Err(error) => {
                assert!(h >= 0.5, "{error}");
                assert_says(error, &[&format!("h = {h:e}")]);
                assert_eq!(state, start);
            }
        }
    }
}

/// A time so late that t + h = t: an error that says how far away the next number is.
#[test]
fn a_time_that_a_step_does_not_change() {
    let pendulum = Integrator::new(Pendulum { g: 9.8 }, Midpoint);
    let (late, h) = (2.0_f64.powi(53), 0.125);
    let start = State::at(late, [1.0], [0.0]);
    let error = failure(&pendulum, &start, h, &[]);
    assert_matches!(error, StepError::Time { .. });
    assert_says(error, &["2e0"]);
    let mut path = pendulum.trajectory(start, 4.0 * h, NoNoise);
    assert!(matches!(path.next(), Some(Err(StepError::Time { .. }))));
}
