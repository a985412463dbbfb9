//! Steps that fail: time scales that are not positive and finite, and bad input.

use sve_runtime::prelude::*;

use super::{Comet, perihelion};

/// A free particle, with a time scale that is negative on one side.
struct Edge;

#[variational(initial_point)]
impl Edge {
    fn lagrangian(&self, _q: f64, v: f64) -> f64 {
        0.5 * v * v
    }

    #[time_scale]
    fn scale(&self, q: f64) -> f64 {
        q
    }
}

/// A free particle, with a time scale that is no number on one side.
struct Root;

#[variational(gauss(4))]
impl Root {
    fn lagrangian(&self, _q: f64, v: f64) -> f64 {
        0.5 * v * v
    }

    #[time_scale]
    fn scale(&self, q: f64) -> f64 {
        q.sqrt()
    }
}

#[test]
fn a_state_without_a_time_scale_is_not_made() {
    let error = TimedState::new(&Edge, [-0.5], [1.0]).unwrap_err();
    let StepError::TimeScale { t, h, scale, q } = &error else {
        panic!("{error}");
    };
    assert_eq!((*t, *h, *scale, &q[..]), (0.0, 0.0, -0.5, &[-0.5][..]));
    for (q, p) in [
        (0.0, 1.0),
        (f64::INFINITY, 1.0),
        (f64::NAN, 1.0),
        (0.5, f64::NAN),
    ] {
        let error = TimedState::new(&Edge, [q], [p]).unwrap_err();
        let is_of_input = matches!(error, StepError::NonFiniteInput { .. });
        assert_eq!(is_of_input, !(q.is_finite() && p.is_finite()), "{error}");
    }
    let error = TimedState::new(&Root, [-0.5], [1.0]).unwrap_err();
    assert!(
        matches!(&error, StepError::TimeScale { scale, .. } if scale.is_nan()),
        "{error}"
    );
    let text = error.to_string();
    assert!(
        text.contains("q = [-0.5]") && text.contains("positive and finite"),
        "{text}"
    );
}

#[test]
fn a_step_from_or_to_a_place_without_a_time_scale_fails_and_leaves_the_state() {
    let edge = Integrator::new(Edge, InitialPoint);
    let start = TimedState::on_path(State::at(0.375, [-0.125], [-1.0]), 0.5);
    let mut state = start;
    let error = edge.step(&mut state, 1.5, &[]).unwrap_err();
    let StepError::TimeScale { t, h, scale, q } = error else {
        panic!("{error}");
    };
    assert_eq!((t, h, scale, &q[..]), (0.375, 1.5, -0.125, &[-0.125][..]));
    assert_eq!(state, start);
    // steps across the edge of the time scale
    let start = TimedState::new(&Edge, [0.25], [-1.0]).expect("a time scale");
    let mut state = start;
    let error = edge.step(&mut state, 1.5, &[]).unwrap_err();
    let StepError::TimeScale { t, h, scale, q } = error else {
        panic!("{error}");
    };
    // dq/dτ = −q at the start
    assert_eq!((t, h, scale, &q[..]), (0.0, 1.5, -0.125, &[-0.125][..]));
    assert_eq!(state, start);
    // also where h, a step of τ, is below the rounding error of t
    let late = TimedState::on_path(State { t: 1e20, ..*start }, start.energy());
    let mut state = late;
    let error = edge.step(&mut state, 1.5, &[]).unwrap_err();
    assert!(
        matches!(error, StepError::TimeScale { t: 1e20, .. }),
        "{error}"
    );
    assert_eq!(state, late);
    let root = Integrator::new(Root, Gauss::<4>);
    let start = TimedState::new(&Root, [0.25], [-1.0]).expect("a time scale");
    let mut state = start;
    let error = root.step(&mut state, 20.0, &[]).unwrap_err();
    assert!(
        matches!(&error, StepError::TimeScale { t: 0.0, scale, .. } if scale.is_nan()),
        "{error}"
    );
    assert_eq!(state, start);
}

#[test]
fn bad_input_is_the_right_error() {
    let comet = Integrator::new(Comet { mu: 1.0 }, Gauss::<8>);
    let start = perihelion(0.9);
    for h in [0.0, f64::NAN, f64::INFINITY] {
        let error = comet.step(&mut { start }, h, &[]).unwrap_err();
        assert!(matches!(error, StepError::StepSize { .. }), "{error}");
    }
    let changed = |change: fn(&mut State<[f64; 2]>)| {
        let mut state = *start;
        change(&mut state);
        TimedState::on_path(state, start.energy())
    };
    let mut bad = changed(|state| state.q[1] = f64::NAN);
    let error = comet.step(&mut bad, 0.1, &[]).unwrap_err();
    assert!(
        matches!(&error, StepError::NonFiniteInput { what, .. } if what == "q[1]"),
        "{error}"
    );
    let mut bad = changed(|state| state.t = f64::INFINITY);
    let error = comet.step(&mut bad, 0.1, &[]).unwrap_err();
    assert!(
        matches!(&error, StepError::NonFiniteInput { what, .. } if what == "t"),
        "{error}"
    );
    // a step that takes less time than the rounding error of t
    let mut late = changed(|state| state.t = 1e12);
    let error = comet.step(&mut late, 1e-9, &[]).unwrap_err();
    assert!(matches!(error, StepError::Time { t: 1e12, .. }), "{error}");
    let nowhere = TimedState::on_path(*start, f64::NAN);
    assert!(comet.step(&mut { nowhere }, 0.1, &[]).is_err());
    // steps that are too long
    let mut state = start;
    let error = comet.step(&mut state, 100.0, &[]).unwrap_err();
    assert!(error.to_string().contains("h = 1e2"), "{error}");
    assert_eq!(state, start);
}
