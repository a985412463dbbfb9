//! Events that change the state: bounces and kicks, with and without noise.

use std::cell::RefCell;

use sve_runtime::prelude::*;

use super::systems::{Ball, Drifting, HenonHeiles, Langevin, Oscillator};

fn ball() -> Integrator<Ball, StormerVerlet> {
    Integrator::new(Ball { g: 1.0 }, StormerVerlet)
}

/// A ball from height ½ with g = 1 bounces at t = 1, 3, 5, … A step of the rule is exact, and so
/// are the bounces, however many there are in a step.
#[test]
fn an_elastic_ball_bounces_for_ever() {
    for (h, tolerance) in [(0.1, 1e-11), (0.7, 1e-12), (5.2, 1e-12), (20.5, 1e-12)] {
        let times = RefCell::new(Vec::new());
        let ball = ball();
        let path = ball
            .trajectory(State::new([0.5], [0.0]), h, NoNoise)
            .change_at(
                |_, s| s.q[0],
                |_, s| {
                    s.p[0] = -s.p[0];
                    times.borrow_mut().push(s.t);
                },
            )
            .falling()
            .samples(if h > 1.0 { 25 } else { 1 });
        let mut steps = 0_u32;
        for (k, state) in (1_u32..).zip(path) {
            let state = state.unwrap();
            // steps stay where they were
            assert_eq!(state.t, f64::from(k) * h);
            let from_bounce = (state.t + 1.0).rem_euclid(2.0) - 1.0;
            let expected = 0.5 - 0.5 * from_bounce * from_bounce;
            assert!((state.q[0] - expected).abs() < tolerance, "{h} {state:?}");
            steps = k;
            if state.t > 100.0 {
                break;
            }
        }
        let times = times.into_inner();
        let end = f64::from(steps) * h;
        assert_eq!(times.len() as f64, (0.5 * (end + 1.0)).floor(), "{h}");
        for (k, t) in (0_u32..).zip(&times) {
            assert!((t - f64::from(2 * k + 1)).abs() < tolerance, "{h} {k} {t}");
        }
    }
}

/// With restitution e the bounces accumulate at t = 1 + 2e/(1 − e). That is an error that says so,
/// and the ball never is below the floor.
#[test]
fn bounces_that_accumulate_are_an_error() {
    for e in [0.9, 0.5, 0.1, 0.01] {
        let ball = ball();
        let mut path = ball
            .trajectory(State::new([0.5], [0.0]), 0.05, NoNoise)
            .change_at(|_, s| s.q[0], |_, s| s.p[0] *= -e)
            .falling();
        let mut lowest = f64::INFINITY;
        let error = path.by_ref().take(1000).find_map(|state| {
            lowest = lowest.min(state.as_ref().map_or(lowest, |s| s.q[0]));
            state.err()
        });
        let error = error.expect("bounces that accumulate");
        assert!(path.next().is_none());
        let StepError::EventsAccumulate { t, interval, .. } = error else {
            panic!("{error}");
        };
        let rest = 1.0 + 2.0 * e / (1.0 - e);
        assert!((t - rest).abs() < 2e-4 && interval < 2e-5, "{e} {t} {rest}");
        assert!(lowest > -1e-12, "{e} {lowest}");
        assert!(error.to_string().contains("stop_at"), "{error}");
    }
}

/// A kick at q = 0 lets the motion pass: one kick for each crossing.
#[test]
fn kicks_let_the_motion_pass() {
    let motion = Integrator::new(Oscillator, Gauss::<4>);
    let kicks = RefCell::new(0);
    let path = motion
        .trajectory(State::new([1.0], [0.0]), 0.25, NoNoise)
        .change_at(
            |_, s| s.q[0],
            |_, s| {
                s.p[0] += 0.1 * s.p[0].signum();
                *kicks.borrow_mut() += 1;
            },
        );
    let end = path.take(400).last().unwrap().unwrap();
    // zeros of cos t: t = 100 is after 32 of them, and the kicks keep the phase
    assert_eq!(kicks.into_inner(), 32);
    let amplitude = 1.0 + 3.2;
    let expected = [amplitude * end.t.cos(), -amplitude * end.t.sin()];
    assert!((end.q[0] - expected[0]).abs() < 1e-8, "{end:?}");
    assert!((end.p[0] - expected[1]).abs() < 1e-8, "{end:?}");
}

/// After a change the path goes on as a new trajectory from there: nothing is carried across it,
/// and later steps have the same bits.
#[test]
fn a_change_begins_a_new_trajectory() {
    let motion = Integrator::new(HenonHeiles, StormerVerlet);
    let start = State::new([-0.22, 0.1], [0.4, 0.0]);
    let turn = |s: &mut State<[f64; 2]>| s.p = [-s.p[0], s.p[1] + 0.01];
    let path = || {
        motion
            .trajectory(start, 0.1, NoNoise)
            .change_at(|_, s| s.q[0], move |_, s| turn(s))
    };
    let states: Vec<_> = path().take(12).map(Result::unwrap).collect();
    let mut at_change = motion
        .trajectory(start, 0.1, NoNoise)
        .crossings(|_, s| s.q[0]);
    let mut state = at_change.next().unwrap().unwrap();
    let made = at_change.step() as usize;
    turn(&mut state);
    let h = made as f64 * 0.1 - state.t;
    motion.step(&mut state, h, &[]).unwrap();
    for (a, b) in state
        .q
        .iter()
        .chain(&state.p)
        .zip(states[made - 1].q.iter().chain(&states[made - 1].p))
    {
        assert!((a - b).abs() < 1e-15);
    }
    let again = motion.trajectory(states[made - 1], 0.1, NoNoise);
    let before_the_next = states[made..].iter().take(3);
    for (a, b) in again.zip(before_the_next) {
        let a = a.unwrap();
        assert_eq!((a.q, a.p), (b.q, b.p));
    }
    // compensated sums begin anew as well
    let compensated = motion.trajectory(start, 0.1, NoNoise).compensated();
    let path = compensated.change_at(|_, s| s.q[0], move |_, s| turn(s));
    for (a, b) in path.take(12).zip(&states) {
        let a = a.unwrap();
        assert!((a.q[0] - b.q[0]).abs() < 1e-15 && (a.p[1] - b.p[1]).abs() < 1e-15);
    }
}

/// A section at the place of a change shows the state before it, once.
#[test]
fn a_section_at_a_change() {
    let ball = ball();
    for is_first in [true, false] {
        let path = ball.trajectory(State::new([0.5], [0.0]), 0.3, NoNoise);
        let bounce = |_: &Ball, s: &mut State<[f64; 1]>| s.p[0] = -s.p[0];
        let events = if is_first {
            path.change_at(|_, s| s.q[0], bounce)
                .falling()
                .crossings(|_, s| s.q[0])
        } else {
            path.crossings(|_, s| s.q[0])
                .change_at(|_, s| s.q[0], bounce)
                .falling()
        };
        for (k, state) in (0..20_u32).zip(events) {
            let state = state.unwrap();
            assert!((state.t - f64::from(2 * k + 1)).abs() < 1e-12, "{state:?}");
            assert!((state.p[0] + 1.0).abs() < 1e-12, "{state:?}");
        }
    }
}

/// A change at the very end of a step, and one that leads to the next bounce at once.
#[test]
fn changes_at_the_end_of_a_step() {
    let ball = ball();
    // falls from ½ in one unit of time: steps of ⅛ end at the floor exactly
    let mut bounces = 0;
    let path = ball
        .trajectory(State::new([0.5], [0.0]), 0.125, NoNoise)
        .change_at(
            |_, s| s.q[0],
            |_, s| {
                s.p[0] *= -0.03125;
                bounces += 1;
            },
        )
        .falling();
    // the second bounce is 1/16 later, within the next step, the third 1/512 after it
    let states: Vec<_> = path.take(9).collect();
    assert_eq!(
        states[7].as_ref().unwrap(),
        &State::at(1.0, [0.0], [0.03125])
    );
    assert!(matches!(states[8], Err(StepError::EventsAccumulate { .. })));
    assert!(bounces >= 3, "{bounces}");
}

/// The rest of a step after a change has the rest of the increment: a change that changes nothing
/// leaves the path as it was.
#[test]
fn the_rest_of_a_step_has_the_rest_of_the_noise() {
    let motion = Integrator::new(Drifting { sigma: 0.5 }, Midpoint);
    let start = State::new([0.0], [0.3]);
    let plain = motion.trajectory(start, 0.1, Wiener::new(5));
    let mut changes = 0;
    let events = motion
        .trajectory(start, 0.1, Wiener::new(5))
        .change_at(|_, s| s.q[0] - 0.2, |_, _| changes += 1);
    for (a, b) in plain.zip(events).take(400) {
        let (a, b) = (a.unwrap(), b.unwrap());
        assert!((a.q[0] - b.q[0]).abs() < 1e-12 && a.t == b.t);
    }
    assert!(changes > 3, "{changes}");
    // a step of a rule with a force and additive noise is nearly the composition of its parts
    let motion = Integrator::new(
        Langevin {
            nu: 0.3,
            sigma: 0.5,
        },
        Midpoint,
    );
    let plain = motion.trajectory(start, 1e-3, Wiener::new(5));
    let events = motion
        .trajectory(start, 1e-3, Wiener::new(5))
        .change_at(|_, s| s.q[0] - 0.02, |_, _| {});
    for (a, b) in plain.zip(events).take(1000) {
        let (a, b) = (a.unwrap(), b.unwrap());
        let away = [(a.q[0] - b.q[0]).abs(), (a.p[0] - b.p[0]).abs()];
        assert!(away[0] < 1e-5 && away[1] < 1e-4, "{away:?}");
    }
}

/// A stop ends the trajectory, also where another function would change the state.
#[test]
fn a_stop_ends_everything() {
    let ball = ball();
    for is_first in [true, false] {
        let path = ball.trajectory(State::new([0.5], [0.0]), 0.3, NoNoise);
        let bounce = |_: &Ball, s: &mut State<[f64; 1]>| s.p[0] = -s.p[0];
        let events = if is_first {
            path.stop_at(|_, s| s.q[0]).change_at(|_, s| s.q[0], bounce)
        } else {
            path.change_at(|_, s| s.q[0], bounce).stop_at(|_, s| s.q[0])
        };
        let end = events.last().unwrap().unwrap();
        assert!((end.t - 1.0).abs() < 1e-12 && (end.p[0] + 1.0).abs() < 1e-12);
    }
    let bounces = RefCell::new(0);
    let path = ball
        .trajectory(State::new([0.5], [0.0]), 0.3, NoNoise)
        .change_at(
            |_, s| s.q[0],
            |_, s| {
                s.p[0] = -s.p[0];
                *bounces.borrow_mut() += 1;
            },
        )
        .falling()
        .stop_at(|_, s| s.t - 4.25);
    let states: Vec<_> = path.map(Result::unwrap).collect();
    // 14 whole steps, and a part of one
    assert_eq!((states.len(), bounces.into_inner()), (15, 2));
    assert!((states[14].q[0] - (0.5 - 0.5 * 0.25 * 0.25)).abs() < 1e-12);
}
