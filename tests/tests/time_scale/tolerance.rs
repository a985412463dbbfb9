//! Paths with a tolerance: steps of τ whose size is adapted.

use std::f64::consts::TAU;

use sve_runtime::prelude::*;

use super::{Comet, DoublePendulum, distance, on_orbit, perihelion};

const COMET: Comet = Comet { mu: 1.0 };

/// Errors after ten periods, in few steps. For the eccentricity 0.99 the speed at the perihelion
/// multiplies errors of the time by 14.
#[test]
fn errors_are_about_the_tolerance() {
    let comet = Integrator::new(COMET, Gauss::<8>);
    for (eccentricity, factor, most_steps) in [(0.6, 1.0, 160), (0.9, 1.0, 210), (0.99, 100.0, 270)]
    {
        let start = perihelion(eccentricity);
        let mut errors = Vec::new();
        for exponent in 4..=12 {
            let tolerance = 10.0_f64.powi(-exponent);
            let path = comet.trajectory(start, 0.1, NoNoise).tolerance(tolerance);
            let mut path = path.until(10.0 * TAU);
            let end = path.by_ref().last().expect("a state").expect("a step");
            let error = distance(&end, &State::at(0.0, start.q, start.p));
            let bound = factor * tolerance + 1e-9;
            assert!(error < bound, "{eccentricity} {tolerance:e}: {error:e}");
            assert!(
                path.step() < 2 * most_steps,
                "{eccentricity} {tolerance:e}: {}",
                path.step()
            );
            errors.push(error);
        }
        // the tolerance is used: the first error is not a rounding error
        assert!(errors[0] > 1e-8, "{eccentricity}: {errors:?}");
    }
}

#[test]
fn times_are_reached_to_the_last_bit() {
    let comet = Integrator::new(COMET, Gauss::<8>);
    for (t0, h) in [(0.0, 0.1), (1e3, 0.1), (0.0, -0.1)] {
        let start = perihelion(0.9);
        let start = TimedState::on_path(State::at(t0, start.q, start.p), start.energy());
        let path = || comet.trajectory(start, h, NoNoise).tolerance(1e-11);
        let times = [0.0, 1e-6, 0.01, 0.01 + 1e-13, 1.0 / 3.0, 2.0, 19.0];
        let times = times.map(|t| t0 + t * h.signum());
        let states = path()
            .at(times)
            .collect::<Result<Vec<_>, _>>()
            .expect("steps");
        assert_eq!(states.len(), times.len());
        for (state, t) in states.iter().zip(times) {
            assert_eq!(state.t, t);
            let end = path().until(t).last();
            assert_eq!(end.map_or(*start, Result::unwrap), *state);
            let exact = on_orbit(0.9, t - t0);
            let error = (state.q[0] - exact[0]).hypot(state.q[1] - exact[1]);
            // t − t₀ has rounding errors
            assert!(error < 1e-9 + 5e-13 * t0, "{t}: {error:e}");
        }
        assert_eq!(states[0], *start);
    }
}

#[test]
fn what_is_read_leaves_the_path_as_it_is() {
    let comet = Integrator::new(COMET, Gauss::<8>);
    let path = || {
        comet
            .trajectory(perihelion(0.9), 0.1, NoNoise)
            .tolerance(1e-9)
    };
    let plain: Vec<_> = path().take(30).map(Result::unwrap).collect();
    let t = 0.5 * (plain[20].t + plain[21].t);
    let mut saved = path().until(t);
    let states: Vec<_> = saved.by_ref().map(Result::unwrap).collect();
    assert_eq!(
        (states.len(), saved.step(), *saved.state()),
        (22, 21, plain[20])
    );
    assert_eq!(states[..21], plain[..21]);
    // passages of the axis, at the ends of parts of steps
    let crossings: Vec<_> = path()
        .crossings(|_, state| state.q[1])
        .take(3)
        .map(Result::unwrap)
        .collect();
    for (k, state) in crossings.iter().enumerate() {
        let half_periods = (k + 1) as f64;
        assert!(
            (state.t - half_periods * 0.5 * TAU).abs() < 1e-7,
            "{}",
            state.t
        );
    }
    // forwards and back to the start
    let mut error = comet
        .trajectory(perihelion(0.9), 0.1, NoNoise)
        .tolerance(1e-12);
    let end = *error
        .by_ref()
        .nth(9)
        .expect("no end")
        .as_ref()
        .expect("a step");
    let back = TimedState::on_path(end, perihelion(0.9).energy());
    let back = comet.trajectory(back, -0.1, NoNoise).tolerance(1e-12);
    let back = back.until(0.0).last().expect("a state").expect("a step");
    assert!(distance(&back, &perihelion(0.9)) < 1e-11, "{back:?}");
}

#[test]
fn the_state_within_a_step_has_the_order_of_its_stages() {
    let double = Integrator::new(DoublePendulum, Gauss::<4>);
    let fine = Integrator::new(DoublePendulum, Gauss::<8>);
    let start = TimedState::new(&DoublePendulum, [1.0, 1.5], [0.5, -0.5]).expect("a time scale");
    let error = |h: f64, fraction: f64| {
        // the first step has the given size
        let mut path = double.trajectory(start, h, NoNoise).tolerance(1e-6);
        assert_eq!(path.state_at(0.0), None);
        let end = path.next().expect("no end").expect("a step");
        assert_eq!((path.snapshot().h(), path.rejections()), (h, 0));
        assert_eq!(path.state_at(0.0), Some(*start));
        let last = path.state_at(end.t).expect("within the step");
        assert!(distance(&last, &end) < 1e-15);
        assert_eq!(
            [path.state_at(-1e-9), path.state_at(1.001 * end.t)],
            [None; 2]
        );
        let t = fraction * end.t;
        let state = path.state_at(t).expect("within the step");
        assert_eq!(state.t, t);
        let exact = fine.trajectory(start, 0.1 * h, NoNoise).until(t);
        distance(&state, &exact.last().expect("a state").expect("a step"))
    };
    for fraction in [0.2, 0.55, 0.9] {
        let (long, short) = (error(0.16, fraction), error(0.08, fraction));
        let order = (long / short).log2();
        let what = format!("{fraction}: {long:e} {short:e} {order}");
        assert!((4.5..6.2).contains(&order), "{what}");
    }
}

#[test]
fn a_stored_path_is_continued_with_the_same_bits() {
    let comet = Integrator::new(COMET, Gauss::<8>);
    let (start, tolerance) = (perihelion(0.9), 1e-9);
    let path = || comet.trajectory(start, 0.01, NoNoise).tolerance(tolerance);
    let whole: Vec<_> = path().take(60).map(Result::unwrap).collect();
    let mut first = path();
    let mut rejected_before = 0;
    for stop in 0..50 {
        let text = serde_json::to_string(&first.snapshot()).expect("text");
        let snapshot = serde_json::from_str(&text).expect("a snapshot");
        let rest = comet
            .resume(snapshot, start.energy(), NoNoise)
            .expect("the same system");
        let mut rest = rest.tolerance(tolerance);
        assert_eq!(rest.rejections(), first.rejections());
        for state in whole[stop..].iter().take(4) {
            assert_eq!(
                &rest.next().expect("no end").expect("a step"),
                state,
                "after {stop}"
            );
        }
        let rejections = first.rejections();
        first.next().expect("no end").expect("a step");
        rejected_before += usize::from(first.rejections() > rejections);
    }
    // also right after steps that were tried more than once
    assert!(rejected_before >= 2, "{rejected_before}");
}

#[test]
fn no_start_runs_to_steps_of_size_zero() {
    let comet = Integrator::new(COMET, Gauss::<8>);
    for t0 in [0.0, 7e5] {
        for h in [1e-3, 1e-300, 1e10] {
            let start = perihelion(0.9);
            let start = TimedState::on_path(State::at(t0, start.q, start.p), start.energy());
            let mut path = comet
                .trajectory(start, h, NoNoise)
                .tolerance(1e-9)
                .until(t0 + TAU);
            let end = path.by_ref().last().expect("a state").expect("a step");
            // the steps grow by a factor of two at most, from 1e-200 at the time 0
            let most = if h < 1e-200 && t0 == 0.0 { 800 } else { 150 };
            assert!(path.step() < most, "{h:e}: {}", path.step());
            assert!(distance(&end, &start) < 1e-7, "{h:e}: {end:?}");
        }
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
fn a_place_without_a_time_scale_is_the_reason() {
    let root = Integrator::new(Root, Gauss::<4>);
    let nowhere = TimedState::on_path(State::at(1.5, [-0.25], [1.0]), 0.5);
    let mut path = root.trajectory(nowhere, 0.1, NoNoise).tolerance(1e-6);
    let error = path.next().expect("an error").unwrap_err();
    assert!(
        matches!(error, StepError::TimeScale { t: 1.5, .. }),
        "{error}"
    );
    assert_eq!(*path.state(), *nowhere);
    // s = 0 too, which no step size makes up for
    let still = TimedState::on_path(State::at(1.5, [0.0], [1.0]), 0.5);
    let mut path = root.trajectory(still, 0.1, NoNoise).tolerance(1e-6);
    let error = path.next().expect("an error").unwrap_err();
    assert!(
        matches!(error, StepError::TimeScale { t: 1.5, .. }),
        "{error}"
    );
    // the edge is reached after a finite time, in steps that become smaller and smaller
    let start = TimedState::new(&Root, [0.25], [-1.0]).expect("a time scale");
    let mut path = root.trajectory(start, 0.1, NoNoise).tolerance(1e-6);
    let error = path.find_map(Result::err).expect("an error");
    assert!(matches!(error, StepError::StepTooSmall { .. }), "{error}");
    assert!(path.state().t < 0.25, "{}", path.state().t);
}
