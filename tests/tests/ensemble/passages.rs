//! First passages: exact times of free particles, exact laws, competing ends, paths out of bounds,
//! refused noises.

use sve_models::assert_matches;
use sve_models::checks::{assert_says, assert_within};
use sve_models::models::{Kicked, Pushed};
use sve_runtime::ensemble::Cause;
use sve_runtime::noise::{ThreePoint, Truncated};
use sve_runtime::prelude::*;

use crate::runs::free;

const H: f64 = 0.05;

const PENDULUM: Pushed = Pushed { g: 1.0, s: 0.4 };

/// Velocities from 1/4 to 2: a free particle from 0 passes 1 at 1/v.
fn velocity(path: u64) -> f64 {
    0.25 + 1.75 * ((path * 37) % 1000) as f64 / 1000.0
}

#[test]
fn free_particles_pass_at_their_exact_times() {
    let method = free();
    let paths = 1000;
    let (records, end) = (8, 2.0);
    let summary = Ensemble::new(&method)
        .paths(paths)
        .steps(H, 40)
        .every(5)
        .start(Starts::each(|path, _| State::new([0.0], [velocity(path)])))
        .observe("time", |_, state| state.t)
        .observe("q", |_, state| state.q[0])
        .stop_at("wall", |_, state| state.q[0] - 1.0)
        .keep_final_states(true)
        .run()
        .unwrap();
    let times: Vec<f64> = (0..paths).map(|path| 1.0 / velocity(path)).collect();
    for (path, state) in summary.final_states() {
        let expected = times[path as usize].min(end);
        assert!((state.t - expected).abs() < 1e-12, "{path}: {}", state.t);
        let q = velocity(path) * expected;
        assert!((state.q[0] - q).abs() < 1e-12, "{path}");
    }
    assert_eq!(summary.final_states().count(), 1000);
    let wall = summary.passage("wall").unwrap();
    assert_eq!((wall.name(), wall.paths()), ("wall", paths));
    let n = paths as f64;
    for record in 0..=records {
        let t = summary.times()[record];
        let passed = times.iter().filter(|&&time| time <= t).count() as u64;
        assert_eq!(wall.passed()[record], passed);
        assert_eq!(wall.at_risk()[record], paths - passed);
        assert_eq!(wall.censored()[record], 0);
        // without censoring Kaplan–Meier is the fraction, and Greenwood the error of a fraction
        let survival = 1.0 - passed as f64 / n;
        assert!((wall.survival()[record].unwrap() - survival).abs() < 1e-15);
        let error = (survival * (1.0 - survival) / n).sqrt();
        assert!((wall.survival_error()[record].unwrap() - error).abs() < 1e-15);
        // stopped paths stay in the statistics, with their last values
        assert_eq!(summary.counts()[record], paths);
        let mean: f64 = times.iter().map(|time| time.min(t)).sum::<f64>() / n;
        assert!((summary["time"].mean()[record] - mean).abs() < 1e-12);
    }
    assert!((summary["q"].max()[records] - 1.0).abs() < 1e-12);
    let from = summary.times()[2];
    let rate = wall.rate(2);
    let late = times.iter().filter(|&&time| time > from);
    let exposure: f64 = late.map(|time| time.min(end) - from).sum();
    let events = times.iter().filter(|&&t| t > from && t <= end).count() as u64;
    assert_eq!(rate.events, events);
    assert!((rate.exposure - exposure).abs() < 1e-10);
    assert!((rate.value - events as f64 / exposure).abs() < 1e-10);
    assert!((rate.standard_error - rate.value / (events as f64).sqrt()).abs() < 1e-12);
}

/// Compares the end of each path with that of a trajectory. Returns the largest difference of the
/// times, and how many paths stopped.
fn compare_with_trajectories(paths: u64, noise: Option<u64>) -> (f64, u64) {
    let method = Integrator::new(PENDULUM, StormerVerlet);
    let start = |path: u64| State::new([0.0], [0.3 + 0.01 * path as f64]);
    let half = |_: &Pushed, state: &State<[f64; 1]>| state.q[0].abs() - 0.5;
    let ensemble = Ensemble::new(&method)
        .paths(paths)
        .steps(H, 600)
        .start(Starts::each(move |path, _| start(path)))
        .stop_at("half", half)
        .keep_final_states(true);
    let ensemble = match noise {
        Some(seed) => ensemble.seed(seed),
        None => ensemble.noise(NoNoise),
    };
    let summary = ensemble.run().unwrap();
    let (mut largest, mut stopped) = (0.0_f64, 0);
    for (path, state) in summary.final_states() {
        // a trajectory that makes all steps has not stopped
        let expected = match noise {
            Some(seed) => {
                let path = || method.trajectory(start(path), H, Wiener::new(seed).path(path));
                let stopped = path().stop_at(half).nth(599).is_none();
                stopped.then(|| path().stop_at(half).last())
            }
            None => {
                let path = || method.trajectory(start(path), H, NoNoise);
                let stopped = path().stop_at(half).nth(599).is_none();
                stopped.then(|| path().stop_at(half).last())
            }
        };
        let Some(expected) = expected else {
            assert!((state.t - 600.0 * H).abs() < 1e-12);
            continue;
        };
        let expected = expected.unwrap().unwrap();
        largest = largest.max((state.t - expected.t).abs());
        assert!((state.q[0].abs() - 0.5).abs() < 1e-4, "{path}");
        stopped += 1;
    }
    assert_eq!(summary.passage("half").unwrap().passed()[1], stopped);
    (largest, stopped)
}

/// Without noise the times agree to the secant within 2⁻¹² of a step. With noise the re-solved step
/// is rough in its length, so that it has several zeros: both searches find one in the same step.
#[test]
fn ensembles_stop_where_trajectories_stop() {
    let (difference, stopped) = compare_with_trajectories(60, None);
    assert!(difference < 1e-10 && stopped > 20, "{difference} {stopped}");
    let (difference, stopped) = compare_with_trajectories(60, Some(5));
    assert!(difference < H && stopped > 40, "{difference} {stopped}");
}

/// The error function for x ≥ 0, to 2e-7 (Abramowitz and Stegun 7.1.26).
fn erf(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let sum = [
        1.061_405_429,
        -1.453_152_027,
        1.421_413_741,
        -0.284_496_736,
        0.254_829_592,
    ];
    let sum = sum.into_iter().fold(0.0, |sum, c| (sum + c) * t);
    1.0 - sum * (-x * x).exp()
}

/// P(τ > t) of a Brownian motion to a level a is erf(a/(σ√(2t))); seen after steps of length h, the
/// level is farther by 0.5826 σ√h.
#[test]
fn brownian_passages_have_their_law_with_the_documented_shift() {
    let (sigma, level, h) = (0.7, 0.9, 0.01_f64);
    let method = Integrator::new(Kicked { sigma }, Midpoint);
    let summary = Ensemble::new(&method)
        .paths(20_000)
        .seed(11)
        .steps(h, 400)
        .every(100)
        .start(State::new([0.0], [0.0]))
        .stop_at("level", |_, state| state.p[0] - level)
        .run()
        .unwrap();
    let passages = summary.passage("level").unwrap();
    let (survival, errors) = (passages.survival(), passages.survival_error());
    let seen = level + 0.5826 * sigma * h.sqrt();
    for record in 1..=4 {
        let scale = sigma * (2.0 * summary.times()[record]).sqrt();
        let (survival, error) = (survival[record].unwrap(), errors[record].unwrap());
        assert_within(survival, erf(seen / scale), error, 4.5, record);
        // the shift is resolved
        let z = (survival - erf(level / scale)) / error;
        assert!(z > 4.0, "record {record}: z = {z}");
    }
}

#[test]
fn competing_ends_and_failures_are_censored() {
    let method = free();
    let paths = 300;
    // velocities −1, 1, and a third that fails at a recorded time
    let speed = |path: u64| [-1.0, 1.0, 0.5][(path % 3) as usize];
    let ensemble = Ensemble::new(&method)
        .paths(paths)
        .steps(0.125, 16)
        .every(4)
        .start(Starts::each(move |path, _| {
            let q = (path / 3) as f64 / 100.0;
            State::new([q], [speed(path)])
        }))
        .observe("q", |_, state| state.q[0])
        .bound("q", -1.0..=1.48)
        .stop_at("left", |_, state| state.q[0] + 0.3)
        .stop_at("right", |_, state| state.q[0] - 1.2)
        .first_passage("middle", |_, state| state.q[0] - 1.0);
    let summary = ensemble.run().unwrap();
    let passage = |name| summary.passage(name).unwrap();
    let [left, right, middle] = ["left", "right", "middle"].map(passage);
    // every path to the left arrives until t = 2, and so does every one to the right
    assert_eq!(left.passed()[4], 100);
    let slow_on_time = (0..100).filter(|k| 0.5 * 2.0 + f64::from(*k) / 100.0 >= 1.2);
    assert_eq!(right.passed()[4], 100 + slow_on_time.count() as u64);
    assert_eq!(left.censored()[4], right.passed()[4]);
    assert_eq!(right.censored()[4], 100);
    assert_eq!(summary.failed(), 0);
    // those that are at 1 at the start have the side of their first step
    assert_eq!(left.at_risk()[4], right.at_risk()[4]);
    let passed: u64 = middle.passed()[4];
    // to the right all pass 1, and of the slow ones those from 0 on
    assert_eq!(passed, 100 + 100);
    // a bound that fails: paths that are beyond at a recorded time
    let summary = ensemble.bound("q", ..=0.9).run().unwrap();
    let right = summary.passage("right").unwrap();
    assert!(summary.failed() > 0);
    for record in 0..5 {
        let sum = right.passed()[record] + right.censored()[record] + right.at_risk()[record];
        assert_eq!(sum, paths);
    }
}

/// A path that is out of its bound where it stops fails at the time of the zero, and has not
/// passed. One that goes on has passed, and fails at the next recorded time.
#[test]
fn paths_out_of_bounds_where_they_stop_have_not_passed() {
    let method = free();
    let ensemble = |bound: f64| {
        Ensemble::new(&method)
            .paths(100)
            .steps(H, 40)
            .every(10)
            .start(Starts::each(|path, _| State::new([0.0], [velocity(path)])))
            .observe("v", |_, state| state.p[0])
            .observe("q", |_, state| state.q[0])
            .bound("q", ..=bound)
    };
    let arrives = |path: u64| velocity(path) > 0.5;
    let arrivals = (0..100).filter(|&path| arrives(path)).count() as u64;
    let summary = ensemble(0.99)
        .stop_at("wall", |_, state| state.q[0] - 1.0)
        .run()
        .unwrap();
    let wall = summary.passage("wall").unwrap();
    // fast paths are beyond 0.99 at a recorded time before they arrive, none has passed
    assert_eq!((wall.passed()[4], wall.censored()[4]), (0, arrivals));
    assert_eq!(summary.failed(), arrivals);
    assert_eq!(summary.counts()[4], 100 - arrivals);
    let mut exposure = 0.0;
    let mut within_steps = 0;
    for path in 0..100 {
        // seen at a recorded time between 0.99/v and 1/v, or where it stops
        let v = velocity(path);
        let recorded = (0..=4).map(|k| 0.5 * f64::from(k));
        let seen = recorded.into_iter().find(|t| v * t > 0.99);
        let end = seen.unwrap_or(f64::INFINITY).min(1.0 / v).min(2.0);
        exposure += end;
        let failure = summary.failures().iter().find(|f| f.path == path);
        assert_eq!(failure.is_some(), arrives(path), "{path}");
        if let Some(failure) = failure {
            assert!((failure.t - end).abs() < 1e-12, "{failure} {end}");
            assert!(matches!(failure.cause, Cause::OutOfBound { .. }));
            assert_says(failure, &[&format!("at t = {}", failure.t)]);
            within_steps += u32::from((failure.t / H - (failure.t / H).round()).abs() > 1e-9);
        }
    }
    assert!(within_steps > 50, "{within_steps}");
    let rate = wall.rate(0);
    assert!(
        (rate.exposure - exposure).abs() < 1e-10,
        "{rate:?} {exposure}"
    );
    // on the bound they pass
    let summary = ensemble(1.0 + 1e-9);
    let summary = summary.stop_at("wall", |_, state| state.q[0] - 1.0);
    let summary = summary.run().unwrap();
    assert_eq!(summary.passage("wall").unwrap().passed()[4], arrivals);
    assert_eq!(summary.failed(), 0);
    // paths that go on pass, unless they are seen beyond the bound before
    let summary = ensemble(1.0).first_passage("wall", |_, state| state.q[0] - 1.0);
    let summary = summary.run().unwrap();
    let wall = summary.passage("wall").unwrap();
    assert_eq!((wall.passed()[4], wall.censored()[4]), (arrivals, 0));
    assert_eq!(summary.failed(), arrivals);
}

#[test]
fn noises_that_are_not_known_within_steps_are_refused() {
    let method = Integrator::new(PENDULUM, Midpoint);
    let ensemble = || {
        Ensemble::new(&method)
            .paths(10)
            .steps(H, 10)
            .start(State::new([0.0], [0.0]))
            .stop_at("right", |_, state| state.q[0] - 1.0)
    };
    for ensemble in [
        ensemble().noise(ThreePoint::new(1)),
        ensemble().noise(Truncated::new(Wiener::new(1))),
    ] {
        let error = ensemble.run().unwrap_err();
        assert_matches!(
            error,
            EnsembleError::NoiseWithinSteps { setting: "stop_at" }
        );
        assert_says(error, &["`Wiener`"]);
    }
    assert!(ensemble().noise(NoNoise).run().is_ok());
    let twice = ensemble().first_passage("right", |_, state| state.q[0]);
    assert!(matches!(twice.run(), Err(EnsembleError::TwiceNamed { name }) if name == "right"));
}
