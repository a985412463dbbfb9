//! Saved states are those of the trajectory, at times as one writes them; a state within a step is
//! a step of a part of the length on the same path.

use sve_runtime::noise::{DyadicInterval, NoiseError};
use sve_runtime::prelude::*;

/// A pendulum that is shaken, with a gravity that depends on time.
#[derive(Clone, Copy)]
struct Shaken {
    g: f64,
    sigma: f64,
}

#[variational(midpoint, stormer_verlet, gauss(2, stage_noise))]
impl Shaken {
    fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * (1.0 + 0.3 * t.sin()) * q.cos()
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

const SYSTEM: Shaken = Shaken { g: 2.0, sigma: 0.4 };

fn start() -> State<[f64; 1]> {
    State::at(0.3, [1.0], [0.5])
}

type States = Vec<State<[f64; 1]>>;

fn times(states: &[State<[f64; 1]>]) -> Vec<f64> {
    states.iter().map(|state| state.t).collect()
}

/// Checks that a state has the coordinates of another one, and a time.
fn check(state: &State<[f64; 1]>, same: &State<[f64; 1]>, t: f64) {
    assert_eq!((state.q, state.p, state.t), (same.q, same.p, t));
}

/// Each 0th state is none: an error with the time, for plain and refined trajectories, and no
/// panic.
#[test]
fn an_interval_of_no_steps_is_an_error() {
    let system = Integrator::new(SYSTEM, Midpoint);
    let path = || system.trajectory(start(), 0.1, Wiener::new(1));
    let error = Some(Err(StepError::SavedInterval { t: 0.3 }));
    let mut plain = path().every(0);
    assert_eq!(plain.next(), error);
    assert_eq!(plain.next(), None);
    assert_eq!(path().refine(3).every(0).until(0.9).next(), error);
    let failed = path().every(0).until(0.9).table().map(|_| ()).unwrap_err();
    assert!(failed.to_string().contains("every(0)"), "{failed}");
}

#[test]
fn every_nth_state_has_the_bits_of_the_trajectory() {
    let system = Integrator::new(SYSTEM, StormerVerlet);
    let path = || system.trajectory(start(), 0.1, Wiener::new(1));
    let whole: States = path().take(60).map(Result::unwrap).collect();
    let saved: States = path().every(7).take(6).map(Result::unwrap).collect();
    assert_eq!(saved[0], start());
    for (k, state) in saved.iter().enumerate().skip(1) {
        let written = format!("{}.{}", (3 + 7 * k) / 10, (3 + 7 * k) % 10);
        check(state, &whole[7 * k - 1], written.parse().unwrap());
    }
    // at least one time differs from that of the trajectory by rounding
    assert!((1..6).any(|k| saved[k].t != whole[7 * k - 1].t));
    let mut saved = path().every(7);
    saved.nth(3);
    assert_eq!((saved.step(), saved.state()), (21, &whole[20]));
}

#[test]
fn times_of_whole_steps_are_whole_steps() {
    let system = Integrator::new(SYSTEM, Midpoint);
    let path = || {
        system.trajectory(
            start(),
            0.1,
            Recorded::record(Wiener::new(1), 0.1, 1, 50).unwrap(),
        )
    };
    let whole: States = path().take(60).map(Result::unwrap).collect();
    let wanted = [0.3, 0.4, 0.9, 2.0, 2.0 + 1e-15];
    let saved: States = path().at(wanted).map(Result::unwrap).collect();
    assert_eq!(times(&saved), wanted);
    check(&saved[0], &start(), 0.3);
    for (state, k) in saved[1..].iter().zip([1, 6, 17, 17]) {
        check(state, &whole[k - 1], state.t);
    }
    // borrowed times too
    assert_eq!(path().at(wanted.iter()).count(), 5);
}

/// At the middle of a step the increment is that of the first half.
#[test]
fn a_state_within_a_step_is_on_the_path() {
    let system = Integrator::new(SYSTEM, StormerVerlet);
    let (h, noise) = (0.25, Wiener::new(4).path(2));
    let start = State { t: 0.5, ..start() };
    let whole: States = system
        .trajectory(start, h, noise)
        .take(20)
        .map(Result::unwrap)
        .collect();
    let wanted = [1.625, 1.6875, 1.75, 2.3];
    let saved: States = system
        .trajectory(start, h, noise)
        .at(wanted)
        .map(Result::unwrap)
        .collect();
    // 1.5 is after four steps
    let [left, _] = noise.halves(DyadicInterval::whole(4), 0, h, noise.increment(4, 0, h));
    let mut state = whole[3];
    system.step(&mut state, 0.5 * h, &[left]).unwrap();
    check(&saved[0], &state, 1.625);
    let first = DyadicInterval::whole(4).halves().unwrap()[1];
    let [part, _] = noise.halves(first, 0, 0.5 * h, noise.increment(4, 0, h) - left);
    let mut state = whole[3];
    system.step(&mut state, 0.75 * h, &[left + part]).unwrap();
    check(&saved[1], &state, 1.6875);
    check(&saved[2], &whole[4], 1.75);
    assert_eq!(saved[3].t, 2.3);
}

/// A step of a part of the length that is nearly the whole, or nearly nothing, is near the states
/// after whole steps.
#[test]
fn states_within_a_step_join_the_whole_ones() {
    let system = Integrator::new(SYSTEM, Midpoint);
    let path = || system.trajectory(start(), 0.1, Wiener::new(3));
    let whole: States = path().take(6).map(Result::unwrap).collect();
    let saved: States = path()
        .at([0.7 + 1e-9, 0.8 - 1e-9])
        .map(Result::unwrap)
        .collect();
    for (state, whole) in saved.iter().zip(&whole[3..]) {
        let distance = (state.q[0] - whole.q[0]).hypot(state.p[0] - whole.p[0]);
        assert!(distance > 0.0 && distance < 1e-3, "{distance}");
    }
}

#[test]
fn the_last_state_is_at_the_end() {
    let system = Integrator::new(SYSTEM, Midpoint);
    let path = || system.trajectory(start(), 0.1, Wiener::new(1));
    let whole: States = path().take(10).map(Result::unwrap).collect();
    let all: States = path().until(0.8).map(Result::unwrap).collect();
    assert_eq!(times(&all), [0.4, 0.5, 0.6, 0.7, 0.8]);
    check(&all[4], &whole[4], 0.8);
    let all: States = path().every(2).until(0.8).map(Result::unwrap).collect();
    assert_eq!(times(&all), [0.3, 0.5, 0.7, 0.8]);
    check(&all[3], &whole[4], 0.8);
    let all: States = path().every(2).until(0.75).map(Result::unwrap).collect();
    assert_eq!(times(&all), [0.3, 0.5, 0.7, 0.75]);
    let all: States = path().every(3).until(0.9).map(Result::unwrap).collect();
    assert_eq!(times(&all), [0.3, 0.6, 0.9]);
    let all: States = path()
        .at([0.4, 0.9])
        .until(0.6)
        .map(Result::unwrap)
        .collect();
    assert_eq!(times(&all), [0.4, 0.6]);
    assert_eq!(
        times(&path().until(0.3).map(Result::unwrap).collect::<States>()),
        [0.3]
    );
    // backwards in time
    let back = system
        .trajectory(start(), -0.1, Wiener::new(1))
        .every(2)
        .until(-0.05);
    assert_eq!(
        times(&back.map(Result::unwrap).collect::<States>()),
        [0.3, 0.1, -0.05]
    );
}

#[test]
fn a_stored_trajectory_is_saved_from_where_it_is() {
    let system = Integrator::new(SYSTEM, Midpoint);
    let mut path = system.trajectory(start(), 0.1, Wiener::new(1));
    let whole: States = path.by_ref().take(20).map(Result::unwrap).collect();
    let stored = {
        let mut path = system.trajectory(start(), 0.1, Wiener::new(1));
        path.nth(4);
        path.snapshot()
    };
    let resumed = || system.resume(stored.clone(), Wiener::new(1)).unwrap();
    let saved: States = resumed().every(5).until(1.9).map(Result::unwrap).collect();
    assert_eq!(times(&saved), [0.8, 1.3, 1.8, 1.9]);
    check(&saved[1], &whole[9], 1.3);
    let behind = resumed().at([0.4]).next().unwrap();
    assert!(matches!(
        behind,
        Err(StepError::TimeOrder {
            t: 0.4,
            after: 0.8,
            ..
        })
    ));
}

#[test]
fn refined_trajectories_are_saved() {
    let system = Integrator::new(SYSTEM, Midpoint);
    let path = || system.trajectory(start(), 0.1, Wiener::new(1)).refine(4);
    let plain = system.trajectory(start(), 0.1, Wiener::new(1));
    let plain: States = plain.at([0.5, 0.62]).map(Result::unwrap).collect();
    assert_eq!(
        path()
            .at([0.5, 0.62])
            .map(Result::unwrap)
            .collect::<States>(),
        plain
    );
    assert_eq!(path().every(2).until(0.62).count(), 3);
    assert_eq!(path().until(0.62).last().unwrap().unwrap(), plain[1]);
    assert_eq!(path().every(2).refinements().steps, 0);
}

#[test]
fn a_source_that_does_not_know_its_path_within_a_step_says_so() {
    let system = Integrator::new(SYSTEM, Midpoint);
    let recorded = Recorded::record(Wiener::new(1), 0.1, 1, 5).unwrap();
    let mut path = system
        .trajectory(start(), 0.1, &recorded)
        .at([0.5, 0.62, 0.7]);
    assert_eq!(path.next().unwrap().unwrap().t, 0.5);
    let error = path.next().unwrap().unwrap_err();
    assert!(
        matches!(
            error,
            StepError::WithinStep {
                t: 0.62,
                stages: 1,
                ..
            }
        ),
        "{error}"
    );
    assert!(error.to_string().contains("such as `Wiener`"), "{error}");
    assert!(path.next().is_none());
    // entered at a step, borrowed and boxed sources know theirs
    let mut source = Wiener::new(1);
    let first = system.trajectory(start(), 0.1, source).at([0.62]).last();
    for other in [
        system
            .trajectory(start(), 0.1, source.from_step(0))
            .at([0.62])
            .last(),
        system
            .trajectory(start(), 0.1, &mut source)
            .at([0.62])
            .last(),
        system
            .trajectory(start(), 0.1, Box::new(Wiener::new(1)))
            .at([0.62])
            .last(),
    ] {
        assert_eq!(other, first);
    }
}

#[test]
fn stage_noise_has_no_parts_of_steps() {
    let system = Integrator::new(SYSTEM, StageNoise(Gauss::<2>));
    let path = || system.trajectory(start(), 0.1, Wiener::new(1));
    assert_eq!(path().every(3).until(0.9).count(), 3);
    let error = path().until(0.62).last().unwrap().unwrap_err();
    assert!(
        matches!(error, StepError::WithinStep { stages: 2, .. }),
        "{error}"
    );
    assert!(error.to_string().contains("2 stages"), "{error}");
    let quiet = system.trajectory(start(), 0.1, NoNoise).until(0.62).last();
    assert_eq!(quiet.unwrap().unwrap().t, 0.62);
}

#[test]
fn times_that_cannot_be_reached_are_errors() {
    let system = Integrator::new(SYSTEM, Midpoint);
    let path = || system.trajectory(start(), 0.1, Wiener::new(1));
    for t in [0.2, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for error in [path().at([t]).last(), path().until(t).last()] {
            let error = error.unwrap().unwrap_err();
            assert!(matches!(error, StepError::TimeOrder { .. }), "{error}");
        }
    }
    let mut states = path().at([0.6, 0.5]);
    assert!(states.next().unwrap().is_ok());
    assert!(matches!(
        states.next(),
        Some(Err(StepError::TimeOrder { t: 0.5, .. }))
    ));
    assert!(states.next().is_none());
    // a recorded path that is too short
    let recorded = Recorded::record(Wiener::new(1), 0.1, 1, 5).unwrap();
    let short = || system.trajectory(start(), 0.1, &recorded);
    assert_eq!(short().every(2).count(), 3);
    for last in [short().until(1.0).last(), short().at([1.0]).last()] {
        let error = last.unwrap().unwrap_err();
        assert_eq!(error, StepError::PathEnded { t: 1.0, end: 0.8 });
    }
    // errors of the trajectory come through
    let zero = system.trajectory(start(), 0.0, NoNoise).until(1.0).last();
    assert_eq!(zero.unwrap().unwrap_err(), StepError::StepSize { h: 0.0 });
    let wrong = system.trajectory(start(), 0.05, &recorded).every(1).nth(1);
    let error = wrong.unwrap().unwrap_err();
    assert!(
        matches!(
            error,
            StepError::Noise {
                source: NoiseError::StepSize { .. },
                ..
            }
        ),
        "{error}"
    );
}

/// Backwards in time too a state within a step is a step of a part of the length, with the
/// increment of that part.
#[test]
fn states_within_a_step_backwards_are_parts_of_it() {
    let system = Integrator::new(SYSTEM, Midpoint);
    let (h, noise) = (-0.25, Wiener::new(4));
    let start = State { t: 0.5, ..start() };
    let path = system.trajectory(start, h, noise).at([0.25, 0.125]);
    let saved: States = path.map(Result::unwrap).collect();
    let mut state = start;
    system
        .step(&mut state, h, &[noise.increment(0, 0, h)])
        .unwrap();
    check(&saved[0], &state, 0.25);
    let [left, _] = noise.halves(DyadicInterval::whole(1), 0, h, noise.increment(1, 0, h));
    system.step(&mut state, 0.5 * h, &[left]).unwrap();
    check(&saved[1], &state, 0.125);
}

/// For a large ΔW a step has no solution.
struct Rotor;

#[variational(midpoint)]
impl Rotor {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }
    #[h1]
    fn jitter(&self, _q: f64, p: f64) -> f64 {
        0.1 * p.powi(4)
    }
}

/// Saved states after refined steps are those of the trajectory.
#[test]
fn states_after_refined_steps_are_saved() {
    let system = Integrator::new(Rotor, Midpoint);
    let mut refined = 0;
    for number in 0..20 {
        let noise = Wiener::new(1).path(number);
        let path = || {
            system
                .trajectory(State::new([0.0], [2.0]), 0.5, noise)
                .refine(16)
        };
        let whole: States = path().take(12).map(Result::unwrap).collect();
        let mut saved = path().every(3).until(6.0);
        let states: States = saved.by_ref().map(Result::unwrap).collect();
        assert_eq!(states[1..], [2, 5, 8, 11].map(|k| whole[k]));
        refined += saved.refinements().steps;
        let at: States = path().at([2.5, 6.0]).map(Result::unwrap).collect();
        assert_eq!(at, [whole[4], whole[11]]);
    }
    assert!(refined > 0);
}
