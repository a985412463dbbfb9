//! Times that are near those of steps: of ends of steps, of the state itself, of parts of a step
//! that take less than the rounding error of the time.

use std::f64::consts::TAU;

use sve_runtime::prelude::*;

use super::{Comet, distance, on_orbit, perihelion};

const COMET: Comet = Comet { mu: 1.0 };

fn comet() -> Integrator<Comet, Gauss<8>> {
    Integrator::new(COMET, Gauss::<8>)
}

/// The time at the end of a step is rounded, so it may be a little behind the end. The states are
/// those of the steps, and exact.
#[test]
fn times_of_steps_have_the_states_of_steps() {
    let comet = comet();
    for h in [0.1, 0.37, -0.05, 1e-3] {
        for t0 in [0.0, 1e3] {
            let start = perihelion(0.9);
            let start = TimedState::on_path(State::at(t0, start.q, start.p), start.energy());
            let path = || comet.trajectory(start, h, NoNoise).tolerance(1e-9);
            let plain: Vec<_> = path().take(40).map(Result::unwrap).collect();
            let again = path().at(plain.iter().map(|state| state.t));
            for (state, again) in plain.iter().zip(again) {
                let again = again.expect("a state");
                assert_eq!(again.t, state.t);
                let (a, exact) = (distance(&again, state), on_orbit(0.9, state.t - t0));
                let error = (again.q[0] - exact[0]).hypot(again.q[1] - exact[1]);
                // forces of 100 at the perihelion, and times with rounding errors
                let rounding = 1e-12 + 200.0 * f64::EPSILON * t0;
                assert!(a < rounding, "{h} {t0} {}: {a:e}", state.t);
                assert!(error < 1e-7 + rounding, "{}: {error:e}", state.t);
            }
            for state in &plain[..12] {
                let last = path().until(state.t).last().expect("a state");
                let error = distance(&last.expect("a step"), state);
                assert!(error < 1e-12 + 200.0 * f64::EPSILON * t0, "{error:e}");
            }
        }
    }
}

#[test]
fn the_present_time_has_the_present_state() {
    let comet = comet();
    // low parts of the time of both signs
    for steps in 1..40 {
        let mut path = comet
            .trajectory(perihelion(0.9), 0.01, NoNoise)
            .tolerance(1e-10);
        let state = path.by_ref().nth(steps).expect("a state").expect("a step");
        let states: Result<Vec<_>, _> = path.at([state.t, state.t + 1.0]).collect();
        let states = states.expect("states");
        assert_eq!(states[0], state);
        assert_eq!(states[1].t, state.t + 1.0);
    }
}

/// A path from an event, by its own function: the search looks at parts of steps that are shorter
/// than the rounding error of the time.
#[test]
fn events_are_found_from_an_event_on() {
    let comet = comet();
    for eccentricity in [0.3, 0.6, 0.9] {
        for h in [1.0, 0.7, 0.31] {
            let mut start = perihelion(eccentricity);
            for _ in 0..6 {
                let path = comet.trajectory(start, h, NoNoise);
                let two = path.crossings(|_, state| state.q[1]).rising().take(2);
                let stop = two.last().expect("a perihelion").expect("steps");
                // a zero with a rounding error may be found twice
                let error = stop.t - TAU * (stop.t / TAU).round();
                assert!(error.abs() < 1e-9, "{eccentricity} {h}: {error:e}");
                start = TimedState::on_path(stop, start.energy());
            }
            assert!(start.t > 6.5 * TAU, "{}", start.t);
        }
    }
}

/// A function that is zero at the start, at a time whose rounding errors are longer than the parts
/// of a step that are looked at.
#[test]
fn sides_are_found_at_late_times() {
    let comet = comet();
    let start = perihelion(0.9);
    let start = TimedState::on_path(State::at(1e6, start.q, start.p), start.energy());
    let half = |state: Option<Result<State<_>, _>>| {
        let t = state.expect("an aphelion").expect("steps").t;
        assert!((t - 1e6 - 0.5 * TAU).abs() < 1e-7, "{t}");
    };
    let path = || comet.trajectory(start, 1e-3, NoNoise);
    half(path().crossings(|_, state| state.q[1]).next());
    half(
        path()
            .tolerance(1e-9)
            .crossings(|_, state| state.q[1])
            .next(),
    );
}

/// A time that no part of a step resolves has the state of the start.
#[test]
fn tiny_times_are_reached() {
    let comet = comet();
    let start = perihelion(0.9);
    for t in [1e-20, 1e-200, f64::MIN_POSITIVE] {
        let path = || comet.trajectory(start, 0.8, NoNoise);
        let states = [
            path().at([t, 1.0]).next(),
            path().tolerance(1e-9).at([t, 1.0]).next(),
            path().until(t).last(),
        ];
        for state in states {
            let state = state.expect("a state").expect("a part of a step");
            assert!(state.t == t && distance(&state, &start) < 1e-15);
        }
    }
}

/// The time of a jump is that of t, not of τ.
#[test]
fn a_jump_is_named_with_its_time() {
    let comet = comet();
    let path = comet.trajectory(perihelion(0.6), 0.8, NoNoise);
    let angle = |state: &State<[f64; 2]>| state.q[1].atan2(state.q[0]);
    let error = path.crossings(move |_, state| angle(state)).next();
    let Some(Err(StepError::EventJump { t, .. })) = error else {
        panic!("{error:?}")
    };
    assert!((t - 0.5 * TAU).abs() < 1e-9, "{t}");
}
