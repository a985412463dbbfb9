//! Trajectories in t: saved states, events, snapshots; what a path in τ has.

use std::f64::consts::TAU;

use sve_runtime::prelude::*;

use super::{Comet, distance, on_orbit, perihelion};

const COMET: Comet = Comet { mu: 1.0 };

#[test]
fn a_trajectory_is_the_repeated_step() {
    for h in [0.5, -0.5] {
        let comet = Integrator::new(COMET, Midpoint);
        let mut state = perihelion(0.9);
        let mut path = comet.trajectory(state, h, NoNoise);
        for _ in 0..100 {
            comet.step(&mut state, h, &[]).expect("a step");
            let next = path.next().expect("no end").expect("a step");
            assert_eq!((next.q, next.p), (state.q, state.p));
            // a trajectory carries the low part of the time
            assert!((next.t - state.t).abs() < 1e-13 * next.t.abs());
        }
        assert_eq!(path.energy(), state.energy());
        assert_eq!(path.step(), 100);
    }
}

#[test]
fn saved_states_leave_the_trajectory_as_it_is() {
    let comet = Integrator::new(COMET, Gauss::<8>);
    let path = || comet.trajectory(perihelion(0.9), 0.8, NoNoise);
    let plain: Vec<_> = path().take(40).map(Result::unwrap).collect();
    let t = 0.5 * (plain[9].t + plain[10].t);
    let mut saved = path().until(t);
    let states: Vec<_> = saved.by_ref().map(Result::unwrap).collect();
    assert_eq!(states.len(), 11);
    assert_eq!(states[..10], plain[..10]);
    assert_eq!(states[10].t, t);
    // the trajectory is after the last whole step
    assert_eq!((saved.step(), *saved.state()), (10, plain[9]));
    // several times within a step, the time of the start, and the times of steps
    let times = [
        0.0,
        plain[4].t,
        t,
        t,
        0.9 * t + 0.1 * plain[10].t,
        plain[10].t,
    ];
    let mut saved = path().at(times);
    let states: Vec<_> = saved.by_ref().map(Result::unwrap).collect();
    assert_eq!(
        states.iter().map(|state| state.t).collect::<Vec<_>>(),
        times
    );
    assert_eq!((states[1], states[5]), (plain[4], plain[10]));
    assert_eq!(states[2], states[3]);
    // every n-th state, with the end
    let states: Vec<_> = path().every(4).until(t).map(Result::unwrap).collect();
    let [first, second, third, last] = states[..] else {
        panic!("{states:?}");
    };
    assert_eq!(
        (first, second, third),
        (*perihelion(0.9), plain[3], plain[7])
    );
    assert_eq!(last.t, t);
    // an end that is the time of a step
    let states: Vec<_> = path().until(plain[5].t).map(Result::unwrap).collect();
    assert_eq!(states, plain[..6]);
    // back in time
    let back = comet.trajectory(perihelion(0.9), -0.8, NoNoise);
    let end = back.until(-TAU).last().expect("a state").expect("a step");
    assert!(distance(&end, &perihelion(0.9)) < 1e-9 && end.t == -TAU);
}

#[test]
fn times_in_the_wrong_order_are_errors() {
    let comet = Integrator::new(COMET, Gauss::<8>);
    let path = || comet.trajectory(perihelion(0.9), 0.8, NoNoise);
    for t in [-1.0, f64::NAN] {
        let error = path().until(t).next().expect("an item").unwrap_err();
        assert!(matches!(error, StepError::TimeOrder { .. }), "{error}");
    }
    let mut saved = path().at([2.0, 1.0]);
    assert!(saved.next().expect("an item").is_ok());
    assert!(matches!(
        saved.next(),
        Some(Err(StepError::TimeOrder { .. }))
    ));
    assert!(saved.next().is_none());
    assert!(matches!(
        path().every(0).next(),
        Some(Err(StepError::SavedInterval { .. }))
    ));
}

#[test]
fn events_act_on_t() {
    let comet = Integrator::new(COMET, Gauss::<8>);
    let path = || comet.trajectory(perihelion(0.9), 0.8, NoNoise);
    // the perihelion
    let mut passages = path().crossings(|_, state| state.q[1]).rising();
    for period in 1..20 {
        let state = passages.next().expect("no end").expect("a step");
        let error = state.t - f64::from(period) * TAU;
        assert!(error.abs() < 1e-11, "{error:e}");
        assert!((state.q[0] - 0.1).abs() < 1e-12);
    }
    // a time, as an event and as an end
    let by_event = path().stop_at(|_, state| state.t - 10.0).last();
    let by_event = by_event.expect("a state").expect("a step");
    let by_end = path().until(10.0).last().expect("a state").expect("a step");
    assert!((by_event.t - 10.0).abs() < 1e-14);
    assert!(distance(&by_event, &by_end) < 1e-13);
    // functions see the system in τ
    let rates =
        path().crossings(|system, state| sve_runtime::TimeScale::time_scale(system, state) - 1.0);
    let state = rates.take(1).last().expect("a state").expect("a step");
    assert!((state.q[0].hypot(state.q[1]) - 1.0).abs() < 1e-13);
}

#[test]
fn a_snapshot_continues_with_the_same_bits() {
    let comet = Integrator::new(COMET, Gauss::<8>);
    let mut path = comet.trajectory(perihelion(0.9), 0.8, NoNoise);
    path.advance(25).expect("steps");
    let text = serde_json::to_string(&path.snapshot()).expect("a text");
    let snapshot: Snapshot<State<[f64; 2]>> = serde_json::from_str(&text).expect("a snapshot");
    let mut rest = comet
        .resume(snapshot.clone(), path.energy(), NoNoise)
        .expect("the same method");
    for _ in 0..50 {
        let (a, b) = (rest.next(), path.next());
        assert_eq!(
            a.expect("no end").expect("a step"),
            b.expect("no end").expect("a step")
        );
    }
    assert_eq!(rest.snapshot(), path.snapshot());
    let other = comet
        .resume(snapshot, 0.9 * path.energy(), NoNoise)
        .map(|_| ());
    let error = other.unwrap_err();
    assert!(matches!(error, StepError::OtherSteps { .. }), "{error}");
    let text = serde_json::to_string(&perihelion(0.9)).expect("a text");
    let read: TimedState<[f64; 2]> = serde_json::from_str(&text).expect("a state");
    assert_eq!(read, perihelion(0.9));
}

#[test]
fn a_path_continues_from_its_states_on_its_energy() {
    let comet = Integrator::new(&COMET, Gauss::<8>);
    let path = comet.trajectory(perihelion(0.9), 0.8, NoNoise);
    let energy = path.energy();
    let middle = path.until(3.0).last().expect("a state").expect("a step");
    let start = TimedState::on_path(middle, energy);
    let end = comet.trajectory(start, 0.8, NoNoise).until(TAU);
    let end = end.last().expect("a state").expect("a step");
    assert!(distance(&end, &perihelion(0.9)) < 1e-10, "{end:?}");
    assert_eq!(TimedState::of(&COMET, middle).expect("an energy").t, 3.0);
}

/// A step of τ may be smaller than the rounding error of t.
#[test]
fn units_of_tau_do_not_matter() {
    struct Slow;
    #[variational(midpoint)]
    impl Slow {
        fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
            0.5 * (v[0] * v[0] + v[1] * v[1]) + 1.0 / q[0].hypot(q[1])
        }
        #[time_scale]
        fn scale(&self, q: [f64; 2]) -> f64 {
            1_180_591_620_717_411_303_424.0 * q[0].hypot(q[1]).powf(1.5)
        }
    }
    let [comet, slow] = [0.25, 0.25 / 1_180_591_620_717_411_303_424.0];
    let plain = Integrator::new(COMET, Midpoint);
    let scaled = Integrator::new(Slow, Midpoint);
    let plain = plain.trajectory(perihelion(0.6), comet, NoNoise).nth(40);
    let start = perihelion(0.6);
    let start = TimedState::new(&Slow, start.q, start.p).expect("a time scale");
    let scaled = scaled.trajectory(start, slow, NoNoise).nth(40);
    let [plain, scaled] = [plain, scaled].map(|state| state.expect("no end").expect("a step"));
    assert!(distance(&plain, &scaled) < 1e-13, "{plain:?} {scaled:?}");
    assert!((plain.t - scaled.t).abs() < 1e-13);
}

#[test]
fn exponents_and_sensitivities_are_those_of_the_map_in_tau() {
    let comet = Integrator::new(COMET, Gauss::<8>);
    let start = perihelion(0.6);
    let in_tau = comet.at_energy(start.energy());
    // an orbit of Kepler has no exponents, and pairs of opposite ones at all times
    let mut exponents = in_tau.lyapunov(*start, 0.5, NoNoise, 4);
    exponents.advance(400).expect("steps");
    let found = exponents.exponents();
    assert!((found[0] + found[3]).abs() < 1e-12, "{found:?}");
    // the derivative of a step by the energy, against differences
    let sensitivity = in_tau.sensitivity(&start, 0.5, &[]).expect("a step");
    let by_energy = sensitivity.get("E").expect("a parameter").q[0];
    let moved = |d: f64| {
        let mut state = TimedState::on_path(*start, start.energy() + d);
        comet.step(&mut state, 0.5, &[]).expect("a step");
        state.q[0]
    };
    let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
    assert!(
        (by_energy - difference).abs() < 1e-8,
        "{by_energy} {difference}"
    );
}

/// The gradient of a loss by the start holds the energy, which is a parameter beside it.
#[test]
fn gradients_hold_the_energy_of_the_path() {
    let comet = Integrator::new(COMET, Gauss::<8>);
    let start = perihelion(0.6);
    let in_tau = comet.at_energy(start.energy());
    let path = in_tau.trajectory(*start, 0.5, NoNoise);
    let gradient = path.gradient(9, |k, end| (k == 9).then(|| end.q[0]));
    let gradient = gradient.expect("steps");
    let by_start = [gradient.start().q, gradient.start().p].concat();
    // the first row of the product of the tangent maps of the steps
    let mut state = *start;
    let mut product = sve_runtime::Tangent::identity();
    for _ in 0..9 {
        let step = in_tau.step_with_derivatives(&mut state, 0.5, &[]);
        product = &step.expect("a step").0 * &product;
    }
    for (found, expected) in by_start.iter().zip(&product[0]) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
    // differences of paths in t, by the start, the energy and the strength
    let end = |by: [f64; 6]| {
        let [x, y, a, b, energy, mu] = by;
        let comet = Integrator::new(Comet { mu: 1.0 + mu }, Gauss::<8>);
        let moved = State::new(
            [start.q[0] + x, start.q[1] + y],
            [start.p[0] + a, start.p[1] + b],
        );
        let moved = TimedState::on_path(moved, start.energy() + energy);
        let end = comet.trajectory(moved, 0.5, NoNoise).nth(8);
        end.expect("no end").expect("a step").q[0]
    };
    let by_parameters = ["E", "mu"].map(|name| gradient.get(name).expect("a parameter"));
    for (k, found) in by_start.into_iter().chain(by_parameters).enumerate() {
        let moved = |d: f64| end(std::array::from_fn(|i| if i == k { d } else { 0.0 }));
        let d = 1e-4;
        let [near, far] = [d, 2.0 * d].map(|d| moved(d) - moved(-d));
        let difference = (8.0 * near - far) / (12.0 * d);
        assert!(
            (found - difference).abs() < 1e-9,
            "{k}: {found} {difference}"
        );
    }
}

/// The steps of a composition go back in τ and in t too.
#[test]
fn compositions_reach_times_and_continue_with_the_same_bits() {
    let comet = Integrator::new(COMET, Composed::new(Midpoint, KahanLi8));
    let path = || comet.trajectory(perihelion(0.6), 0.2, NoNoise);
    let plain: Vec<_> = path().take(60).map(Result::unwrap).collect();
    let t = 0.7 * plain[29].t + 0.3 * plain[30].t;
    let times = [plain[4].t, t, t + 1e-9, plain[40].t];
    let states: Vec<_> = path().at(times).map(Result::unwrap).collect();
    let until: Vec<_> = path().until(t).map(Result::unwrap).collect();
    assert_eq!((states[0], states[3]), (plain[4], plain[40]));
    assert_eq!((&until[..30], until[30]), (&plain[..30], states[1]));
    for (state, t) in states.iter().zip(times) {
        let exact = on_orbit(0.6, t);
        let error = (state.q[0] - exact[0]).hypot(state.q[1] - exact[1]);
        assert!(state.t == t && error < 1e-9, "{t}: {error:e}");
    }
    let mut first = path();
    first.advance(25).expect("steps");
    let text = serde_json::to_string(&first.snapshot()).expect("a text");
    let snapshot = serde_json::from_str(&text).expect("a snapshot");
    let rest = comet.resume(snapshot, first.energy(), NoNoise);
    let rest = rest.expect("the same method").take(35).map(Result::unwrap);
    assert_eq!(rest.collect::<Vec<_>>(), plain[25..]);
}

/// A kick at each passage of an axis: the path ends there, and another one begins with its energy.
#[test]
fn a_path_goes_on_from_an_event_with_another_energy() {
    let comet = Integrator::new(COMET, Gauss::<8>);
    let mut state = perihelion(0.9);
    for passage in 1..=20 {
        let path = comet.trajectory(state, 0.7, NoNoise).stop_at(|_, s| s.q[1]);
        let mut end = path.last().unwrap().unwrap();
        // the two ends of the axis in turn
        assert_eq!(end.q[0] < 0.0, passage % 2 == 1, "{passage} {end:?}");
        end.p[1] *= 1.0 + 1e-3;
        state = TimedState::of(comet.system(), end).unwrap();
    }
}
