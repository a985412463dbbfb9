//! A trajectory has the bits of repeated steps. Its times are rounded once, and it ends at an error
//! or at the end of its noise.

mod continued;
mod saved;

use sve_models::case::Case;
use sve_models::oracle::{cases, kubo, mixed, oscillator, pendulum};
use sve_models::random::Random;
use sve_runtime::Variational;
use sve_runtime::baseline::{EulerMaruyama, RungeKutta4};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

fn trajectory_is_the_repeated_step(case: &dyn Case, random: &mut Random) {
    let start = case.model().point(random);
    let (h, noises) = (0.01, case.dimensions().1);
    let noise = Wiener::new(3).path(4);
    let prepared = case.prepared(h).unwrap();
    let (mut prepared_state, mut plain_state) = (start.clone(), start.clone());
    let path = case.trajectory(&start, h, Box::new(noise));
    for (k, state) in (0..50_u32).zip(path) {
        let state = state.unwrap();
        let increment = |i| noise.increment(u64::from(k), i, h);
        let dw: Vec<f64> = (0..noises).map(increment).collect();
        prepared(&mut prepared_state, &dw).unwrap();
        case.step(&mut plain_state, h, &dw).unwrap();
        let time = f64::from(k + 1).mul_add(h, start.t);
        prepared_state.t = time;
        plain_state.t = time;
        assert_eq!(state, prepared_state, "{} step {k}", case.name());
        assert_eq!(state, plain_state, "{} step {k}", case.name());
    }
}

#[test]
fn every_trajectory_is_the_repeated_step() {
    let mut random = Random::new(12);
    for case in cases() {
        trajectory_is_the_repeated_step(&*case, &mut random);
    }
}

/// A step alone adds h to the time; a trajectory rounds t₀ + kh once, however long it is.
#[test]
fn time_does_not_drift() {
    let oscillator = Integrator::new(oscillator(), Endpoint);
    let start = State::at(1.0, [1.0], [0.0]);
    let mut state = start;
    oscillator.step(&mut state, 0.1, &[0.0]).unwrap();
    assert_eq!(state.t, 1.1);
    let mut path = oscillator.trajectory(start, 0.1, NoNoise);
    let mut added = start.t;
    for k in 1..=100_000_u32 {
        let state = path.next().unwrap().unwrap();
        added += 0.1;
        assert_eq!(state.t, f64::from(k).mul_add(0.1, 1.0));
        assert_eq!(&state, path.state());
    }
    assert_ne!(added, 10_001.0, "adding h would have drifted");
    assert_eq!(path.state().t, 10_001.0);
}

/// t₀ + k h to the nearest number: bounds with 53 bits each, and their sum as an integer.
#[test]
fn times_are_rounded_once() {
    let oscillator = Integrator::new(oscillator(), Endpoint);
    let mut random = Random::new(5);
    let unit = 2.0_f64.powi(-40);
    for round in 0..200 {
        let start = (random.uniform(-1.0, 1.0) * 2.0_f64.powi(46)).round();
        let h = (random.uniform(0.1, 1.0) * 2.0_f64.powi(30 + round % 15)).round();
        let state = State::at(start * unit, [0.0], [0.0]);
        let path = oscillator.trajectory(state, h * unit, NoNoise);
        for (k, state) in (1..300).zip(path) {
            // below 2⁵³ times 300: the conversion rounds to nearest, ties to even
            let exact = start as i128 + i128::from(k) * h as i128;
            assert_eq!(state.unwrap().t, exact as f64 * unit, "{start} + {k} · {h}");
        }
    }
}

/// A time that is infinite, or that a step does not change, is an error with the numbers, and the
/// state is kept.
#[test]
fn times_that_do_not_advance_are_errors() {
    let oscillator = Integrator::new(oscillator(), Endpoint);
    let pendulum = Integrator::new(pendulum(), Midpoint);
    for (start, h) in [
        (1e16, 0.5),
        (-1e16, 1.0),
        (1.0, 1e-17),
        (0.1, 1e-320),
        (1e300, 1e280),
        (1.7e308, 1e308),
    ] {
        let before = State::at(start, [0.0], [0.0]);
        let expected = StepError::Time {
            t: start,
            h,
            end: start + h,
        };
        let mut state = before;
        let error = oscillator.step(&mut state, h, &[0.0]);
        assert_eq!((error, state), (Err(expected.clone()), before));
        let error = RungeKutta4::new(sve_models::oracle::pendulum()).step(&mut state, h, &[]);
        assert_eq!((error, state), (Err(expected.clone()), before));
        if h < 1e200 {
            let error = pendulum.step(&mut state, h, &[]);
            assert_eq!((error, state), (Err(expected.clone()), before));
        }
        let mut path = oscillator.trajectory(before, h, NoNoise).refine(5);
        assert_eq!(path.next(), Some(Err(expected.clone())));
        assert_eq!(path.state(), &before);
        assert_eq!(path.next(), None);
        let text = expected.to_string();
        assert!(text.contains(&format!("{h:e}")), "{text}");
    }
    // finite for a while: the last time is the last number
    let h = 0.6 * f64::MAX;
    let mut path = oscillator.trajectory(State::at(-h, [0.0], [0.0]), h, NoNoise);
    assert_eq!(path.next().unwrap().unwrap().t, 0.0);
    assert_eq!(path.next().unwrap().unwrap().t, h);
    let (t, end) = (h, f64::INFINITY);
    assert_eq!(path.next(), Some(Err(StepError::Time { t, h, end })));
    // a step that changes the time by a single unit is one
    let mut state = State::at(1.0, [0.0], [0.0]);
    oscillator.step(&mut state, f64::EPSILON, &[0.0]).unwrap();
    assert_eq!(state.t, 1.0 + f64::EPSILON);
}

fn ends_with<S, R, W, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<[f64; N]>,
    h: f64,
    noise: W,
) -> (usize, Option<StepError>)
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
    W: Noise,
{
    let mut path = integrator.trajectory(start, h, noise);
    let (mut states, mut error) = (0, None);
    for item in path.by_ref().take(1000) {
        assert!(error.is_none(), "a state after an error");
        match item {
            Ok(_) => states += 1,
            Err(e) => error = Some(e),
        }
    }
    if states < 1000 {
        // it stays over
        assert!(path.next().is_none());
        assert!(path.next().is_none());
    }
    (states, error)
}

#[test]
fn ends_with_its_recording() {
    let kubo = Integrator::new(kubo(), Midpoint);
    let start = State::new([1.0], [0.0]);
    let recorded = Recorded::record(Wiener::new(1), 0.1, 1, 37).unwrap();
    assert_eq!(ends_with(&kubo, start, 0.1, &recorded), (37, None));
    let coarse = recorded.coarsen(37).unwrap();
    assert_eq!(ends_with(&kubo, start, coarse.h(), coarse), (1, None));

    // for another step size, or another number of processes, it is an error that names both
    let (states, error) = ends_with(&kubo, start, 0.2, &recorded);
    let message = error.as_ref().map(ToString::to_string).unwrap_or_default();
    assert!(
        matches!(error, Some(StepError::Noise { t: 0.0, .. })),
        "{message}"
    );
    assert!(
        states == 0 && message.contains("1e-1") && message.contains("2e-1"),
        "{message}"
    );
    let mixed = Integrator::new(mixed(), Midpoint);
    let (states, error) = ends_with(&mixed, State::new([0.1; 2], [0.1; 2]), 0.1, &recorded);
    assert_eq!(states, 0);
    assert!(matches!(error, Some(StepError::Noise { .. })), "{error:?}");
}

#[test]
fn ends_after_an_error() {
    let oscillator = Integrator::new(oscillator(), Endpoint);
    let start = State::new([1.0], [0.0]);
    // p is 0.7 of the largest number after the second step
    let bad = Recorded::new(0.1, [[0.1], [f64::MAX], [f64::MAX], [0.1]]).unwrap();
    let (states, error) = ends_with(&oscillator, start, 0.1, bad);
    assert_eq!(states, 2);
    let Some(StepError::NonFiniteResult { t, h, .. }) = error else {
        panic!("{error:?}");
    };
    assert_eq!((t, h), (0.2, 0.1));

    for h in [0.0, -0.0, f64::NAN] {
        let (states, error) = ends_with(&oscillator, start, h, NoNoise);
        assert_eq!(states, 0);
        assert!(
            matches!(error, Some(StepError::StepSize { .. })),
            "{error:?}"
        );
    }
    let nowhere = State::new([f64::NAN], [0.0]);
    let (states, error) = ends_with(&oscillator, nowhere, 0.1, NoNoise);
    assert_eq!(states, 0);
    assert!(
        matches!(error, Some(StepError::NonFiniteInput { .. })),
        "{error:?}"
    );
    // and otherwise it does not end
    assert_eq!(
        ends_with(&oscillator, start, 0.1, Wiener::new(5)),
        (1000, None)
    );
}

/// Without noise, a system with noises is its deterministic limit.
#[test]
fn no_noise() {
    let integrator = Integrator::new(kubo(), Midpoint);
    let start = State::new([1.0], [0.5]);
    let mut state = start;
    for (k, item) in (1..100_u32).zip(integrator.trajectory(start, 0.1, NoNoise)) {
        integrator.step(&mut state, 0.1, &[0.0]).unwrap();
        state.t = f64::from(k) * 0.1;
        assert_eq!(item.unwrap(), state);
    }
}

/// Two trajectories from the same source can be advanced alternately, and a reference to a source
/// is a source.
#[test]
fn paths_are_independent_of_their_readers() {
    let integrator = Integrator::new(oscillator(), Endpoint);
    let start = State::new([1.0], [0.5]);
    let recorded = Recorded::record(Wiener::new(9), 0.1, 1, 20).unwrap();
    let mut wiener = Wiener::new(9);
    let by_reference = integrator.trajectory(start, 0.1, &mut wiener);
    let replayed = integrator.trajectory(start, 0.1, &recorded);
    let again = integrator.trajectory(start, 0.1, &recorded);
    for ((a, b), c) in by_reference.zip(replayed).zip(again) {
        let (a, b, c) = (a.unwrap(), b.unwrap(), c.unwrap());
        assert_eq!(a, b);
        assert_eq!(b, c);
    }
}

/// Baselines run by the same trajectories.
#[test]
fn of_baselines() {
    let start = State::new([1.0], [0.5]);
    let recorded = Recorded::record(Wiener::new(2), 0.05, 1, 20).unwrap();
    let euler = EulerMaruyama::new(oscillator());
    let mut state = start;
    let mut path = euler.trajectory(start, 0.05, &recorded);
    for k in 0..20 {
        let dw = recorded.get(k).unwrap();
        euler
            .step(&mut state, 0.05, dw.try_into().unwrap())
            .unwrap();
        state.t = (k + 1) as f64 * 0.05;
        assert_eq!(path.next().unwrap().unwrap(), state);
    }
    assert!(path.next().is_none());
    let runge = RungeKutta4::new(pendulum());
    let end = runge.trajectory(start, 0.05, NoNoise).nth(9);
    assert_eq!(end.unwrap().unwrap().t, 0.5);
}

/// A borrowed system is the same system.
#[test]
fn a_system_can_be_borrowed() {
    let pendulum = sve_models::models::Pendulum { g: 9.8 };
    let start = State::new([1.0], [0.3]);
    let (mut owned, mut borrowed, mut other) = (start, start, start);
    let by_reference = Integrator::new(&pendulum, Midpoint);
    Integrator::new(pendulum.clone(), Midpoint)
        .step(&mut owned, 0.1, &[])
        .unwrap();
    by_reference.step(&mut borrowed, 0.1, &[]).unwrap();
    sve_runtime::baseline::RungeKutta4::new(&pendulum)
        .step(&mut other, 0.1, &[])
        .unwrap();
    assert_eq!(owned, borrowed);
    assert!((other.q[0] - owned.q[0]).abs() < 1e-2);
    assert_eq!(by_reference.plan().system, "Pendulum");
}
