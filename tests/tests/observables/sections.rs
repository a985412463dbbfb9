//! Crossings: their accuracy for each rule, directions, several functions, angles, what is seen,
//! errors.

use std::f64::consts::{PI, TAU};

use sve_runtime::Events;
use sve_runtime::baseline::{Heun, RungeKutta4};
use sve_runtime::prelude::*;

use super::systems::{HenonHeiles, Oscillator, Wheel};

type Point = State<[f64; 2]>;

fn distance(a: &Point, b: &Point) -> f64 {
    let pairs = a.q.iter().chain(&a.p).zip(b.q.iter().chain(&b.p));
    pairs
        .map(|(x, y)| (x - y).abs())
        .fold((a.t - b.t).abs(), f64::max)
}

/// The error of the first crossing of x = 0, which lies at 0.6 of a step of the exact motion.
fn error<I: Method<System = HenonHeiles>>(method: &I, h: f64) -> f64 {
    let exact = Integrator::new(HenonHeiles, Gauss::<8>);
    let crossing = State::at(0.0, [0.0, 0.25], [0.4, 0.1]);
    let mut start = crossing;
    for _ in 0..16 {
        exact.step(&mut start, -0.6 * h / 16.0, &[]).unwrap();
    }
    let mut crossings = method
        .trajectory(start, h, NoNoise)
        .crossings(|_, state| state.q[0]);
    let found = crossings.next().unwrap().unwrap();
    assert_eq!(crossings.step(), 1);
    assert!(found.q[0].abs() < 1e-16, "{found:?}");
    distance(&found, &crossing)
}

fn order<I: Method<System = HenonHeiles>>(name: &str, method: &I, expected: f64, h: f64) {
    let errors = [h, 0.5 * h, 0.25 * h].map(|h| error(method, h));
    let order = (errors[0] / errors[2]).log2() / 2.0;
    println!("| {name} | {expected} | {order:.2} | {:.1e} |", errors[2]);
    // the next term of the error still counts at the larger steps of the higher orders
    let bias = 0.04 * expected;
    assert!(
        (order - expected).abs() < bias,
        "{name}: {order} {errors:?}"
    );
}

/// The step is solved anew: the state at a crossing has the local error of the rule.
#[test]
fn a_crossing_is_as_accurate_as_a_step() {
    let system = HenonHeiles;
    order("midpoint", &Integrator::new(system, Midpoint), 3.0, 0.1);
    order("Verlet", &Integrator::new(system, StormerVerlet), 3.0, 0.1);
    order("Gauss 2", &Integrator::new(system, Gauss::<2>), 5.0, 0.4);
    order("Gauss 4", &Integrator::new(system, Gauss::<4>), 9.0, 1.6);
    order("Heun", &Heun::new(system), 3.0, 0.1);
    order("Runge–Kutta 4", &RungeKutta4::new(system), 5.0, 0.2);
    let composed = Composed::new(StormerVerlet, KahanLi8);
    order("Kahan–Li 8", &Integrator::new(system, composed), 9.0, 0.8);
    let gauss = error(&Integrator::new(system, Gauss::<4>), 0.1);
    assert!(gauss < 1e-14, "{gauss}");
}

/// The state at a crossing is that of one step of the length that leads there.
#[test]
fn a_crossing_is_a_part_of_a_step() {
    let motion = Integrator::new(HenonHeiles, StormerVerlet);
    let start = State::at(3.0, [-0.01, 0.1], [0.4, 0.0]);
    let mut crossings = motion
        .trajectory(start, 0.1, NoNoise)
        .crossings(|_, state| state.q[0]);
    let found = crossings.next().unwrap().unwrap();
    let mut state = start;
    motion.step(&mut state, found.t - start.t, &[]).unwrap();
    assert!(distance(&found, &state) < 1e-15);
    assert_eq!(crossings.event(), Some(0));
}

fn oscillation(h: f64) -> (Integrator<Oscillator, Gauss<4>>, State<[f64; 1]>, f64) {
    (
        Integrator::new(Oscillator, Gauss::<4>),
        State::new([1.0], [0.0]),
        h,
    )
}

/// The zeros of cos t, and the direction of each.
#[test]
fn directions() {
    let (motion, start, h) = oscillation(0.25);
    for (choose, first, spacing) in [
        (None, 0.5 * PI, PI),
        (Some(true), 1.5 * PI, TAU),
        (Some(false), 0.5 * PI, TAU),
    ] {
        let all = motion
            .trajectory(start, h, NoNoise)
            .crossings(|_, s| s.q[0]);
        let chosen = match choose {
            None => all,
            Some(true) => all.rising(),
            Some(false) => all.falling(),
        };
        for (k, state) in (0..20_u32).zip(chosen) {
            let state = state.unwrap();
            let expected = first + f64::from(k) * spacing;
            assert!((state.t - expected).abs() < 1e-10, "{choose:?} {k}");
            assert!(choose.is_none_or(|rises| (state.p[0] > 0.0) == rises));
        }
    }
    // along a trajectory into the past the cosine first rises at −3π/2
    let mut past = motion
        .trajectory(start, -h, NoNoise)
        .crossings(|_, s| s.q[0])
        .rising();
    assert!((past.next().unwrap().unwrap().t + 1.5 * PI).abs() < 1e-10);
}

#[test]
fn several_functions_in_the_order_of_time() {
    let (motion, start, h) = oscillation(0.5);
    let mut events = motion
        .trajectory(start, h, NoNoise)
        .crossings(|_, s| s.q[0])
        .crossings(|_, s| s.p[0] - 0.5)
        .rising()
        .crossings(|_, s| s.q[0] - 0.1);
    let mut found = Vec::new();
    for _ in 0..10 {
        let t = events.next().unwrap().unwrap().t;
        found.push((t, events.event().unwrap()));
    }
    // q = cos t, p = −sin t
    let (near, rise) = (0.1_f64.acos(), PI + 0.5_f64.asin());
    let mut expected = Vec::new();
    for turn in [0.0, TAU] {
        expected.extend([
            (turn + near, 2),
            (turn + 0.5 * PI, 0),
            (turn + rise, 1),
            (turn + 1.5 * PI, 0),
            (turn + TAU - near, 2),
        ]);
    }
    for ((t, event), (at, number)) in found.into_iter().zip(expected) {
        assert!((t - at).abs() < 1e-8 && event == number, "{t} {at} {event}");
    }
}

/// The states between events are those of the plain trajectory, with all bits.
#[test]
fn steps_keep_their_bits() {
    let motion = Integrator::new(HenonHeiles, StormerVerlet);
    let start = State::new([0.0, 0.1], [0.4, 0.0]);
    let plain = motion.trajectory(start, 0.1, NoNoise);
    let events = motion
        .trajectory(start, 0.1, NoNoise)
        .stop_at(|_, s| s.t - 20.04);
    let (mut count, mut end) = (0, start);
    for (a, b) in plain.zip(events) {
        end = b.unwrap();
        if count < 200 {
            assert_eq!(a.unwrap(), end);
        }
        count += 1;
    }
    assert_eq!(count, 201);
    assert!((end.t - 20.04).abs() < 1e-14);
}

#[test]
fn angles_that_wrap_are_no_crossings() {
    let wheel = Integrator::new(Wheel, Midpoint);
    let start = State::new([1.0], [-1.0]);
    let path = || wheel.trajectory(start, 0.3, NoNoise);
    let counted = path().crossings(|_, s| s.q[0]).angle();
    let reduced = path()
        .crossings(|_, s| s.q[0].sin().atan2(s.q[0].cos()))
        .angle();
    for (k, (a, b)) in (0..30_u32).zip(counted.zip(reduced)) {
        let expected = 1.0 + TAU * f64::from(k);
        assert!((a.unwrap().t - expected).abs() < 1e-11);
        assert!((b.unwrap().t - expected).abs() < 1e-11);
    }
    // the angle of a rising motion rises
    let none = path().crossings(|_, s| s.q[0]).angle().rising();
    assert_eq!(none.stop_at(|_, s| s.t - 50.0).count(), 0);
    // without the word the jump is an error that shows it
    let jump = path().crossings(|_, s| s.q[0].sin().atan2(s.q[0].cos()));
    let error = jump.last().unwrap().unwrap_err();
    let StepError::EventJump {
        t,
        number,
        before,
        after,
    } = error
    else {
        panic!("{error}");
    };
    assert!((t - 1.0 - PI).abs() < 1e-12 && number == 0);
    assert!((before + PI).abs() < 1e-9 && (after - PI).abs() < 1e-9);
    assert!(error.to_string().contains(".angle()"), "{error}");
}

/// Two zeros within a step are seen with samples between them only.
#[test]
fn what_is_seen() {
    let (motion, start, _) = oscillation(1.0);
    // positive at 0, 1, 2, 3, …, with two zeros between 3 and 4
    let dips = |_: &Oscillator, s: &State<[f64; 1]>| 0.995 + s.q[0];
    let path = |samples| {
        let path = motion.trajectory(start, 1.0, NoNoise);
        path.crossings(dips)
            .samples(samples)
            .stop_at(|_, s| s.t - 5.0)
    };
    assert_eq!(path(1).count(), 0);
    let seen: Vec<f64> = path(8).map(|state| state.unwrap().t).collect();
    let width = 0.995_f64.acos();
    assert_eq!(seen.len(), 2);
    assert!((seen[0] - PI + width).abs() < 1e-6, "{seen:?}");
    assert!((seen[1] - PI - width).abs() < 1e-6, "{seen:?}");
}

/// A value of exactly 0 after a step is a crossing there, once; a start at 0 is none.
#[test]
fn zeros_at_steps() {
    let wheel = Integrator::new(Wheel, Midpoint);
    let start = State::new([0.0], [1.0]);
    let path = || wheel.trajectory(start, 0.125, NoNoise);
    let stopped: Vec<_> = path().stop_at(|_, s| s.t - 1.0).collect();
    assert_eq!(stopped.len(), 8);
    assert_eq!(stopped[7].as_ref().unwrap(), &State::at(1.0, [1.0], [1.0]));
    let found: Vec<_> = path()
        .crossings(|_, s| s.q[0] * (s.q[0] - 1.0))
        .stop_at(|_, s| s.q[0] - 2.03)
        .collect();
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].as_ref().unwrap().q, [1.0]);
    // a touch is reported where a step ends at it, and the next crossing is not lost
    let touched: Vec<f64> = path()
        .crossings(|_, s| (s.q[0] - 1.0).powi(2) * (s.q[0] - 1.1))
        .stop_at(|_, s| s.q[0] - 2.0)
        .map(|state| state.unwrap().q[0])
        .collect();
    assert_eq!(touched.len(), 2);
    assert!(
        touched[0] == 1.0 && (touched[1] - 1.1).abs() < 1e-15,
        "{touched:?}"
    );
}

/// A path that begins at a zero of the function, up to rounding, does not find this zero again, at
/// early and at late times.
#[test]
fn a_path_begins_at_the_event_of_another_one() {
    let mut signs = [false; 2];
    for (time, level) in [0.0, 1e6]
        .into_iter()
        .flat_map(|t| (0..50).map(move |k| (t, k)))
    {
        let value = move |s: &Point| s.q[0] - 0.002 * f64::from(level) - 0.01;
        for h in [0.1, 1e-3] {
            let motion = Integrator::new(HenonHeiles, StormerVerlet);
            let start = State::at(time, [0.0, 0.1], [0.4, 0.0]);
            let first = motion
                .trajectory(start, h, NoNoise)
                .stop_at(move |_, s| value(s));
            let event = first.last().unwrap().unwrap();
            signs[usize::from(value(&event) > 0.0)] |= value(&event) != 0.0;
            let mut again = motion
                .trajectory(event, h, NoNoise)
                .crossings(move |_, s| value(s));
            let next = again.next().unwrap().unwrap();
            assert!(
                next.t > event.t + 1.0 && next.p[0] < 0.0,
                "{event:?} {next:?}"
            );
        }
    }
    assert_eq!(signs, [true; 2]);
}

#[test]
fn errors_of_the_function() {
    let (motion, start, h) = oscillation(0.25);
    let ends = |mut events: Events<'_, Integrator<Oscillator, Gauss<4>>, NoNoise>| {
        let error = events.by_ref().find_map(Result::err).unwrap();
        assert!(events.next().is_none());
        error
    };
    let path = || motion.trajectory(start, h, NoNoise);
    let error = ends(path().crossings(|_, s| (1.0 - s.t).sqrt() + 1.0));
    let text = error.to_string();
    let StepError::EventFunction { t, number, value } = error else {
        panic!("{error}");
    };
    assert!((t, number) == (1.25, 0) && value.is_nan());
    assert!(text.contains("NaN") && text.contains("t = 1.25"), "{text}");
    let mine = || StepError::StepSize { h: 7.0 };
    let fails = |_: &Oscillator, s: &State<[f64; 1]>| if s.t > 1.0 { Err(mine()) } else { Ok(1.0) };
    assert_eq!(ends(path().crossings(fails)), mine());
    // at the start as well
    let error = ends(path().stop_at(|_, s| s.p[0].ln()));
    assert!(matches!(error, StepError::EventFunction { t: 0.0, .. }));
    // what was found in the step before the error comes first
    let mut events = path()
        .crossings(|_, s| s.t - 1.05)
        .change_at(|_, s| s.t - 1.1, |_, s| s.p[0] = f64::NAN);
    assert!((events.next().unwrap().unwrap().t - 1.05).abs() < 1e-15);
    let error = events.next().unwrap().unwrap_err();
    assert!(matches!(error, StepError::NonFiniteInput { .. }), "{error}");
    assert!(events.next().is_none());
}

/// An event costs few steps where the function is smooth.
#[test]
fn the_cost_of_a_crossing() {
    let count = std::cell::Cell::new(0);
    let motion = Integrator::new(HenonHeiles, StormerVerlet);
    let start = State::new([0.0, 0.1], [0.4, 0.0]);
    let mut events = motion.trajectory(start, 0.1, NoNoise).crossings(|_, s| {
        count.set(count.get() + 1);
        s.q[0]
    });
    for state in events.by_ref().take(100) {
        state.unwrap();
    }
    let searched = count.get() - events.step() - 2;
    println!("{} evaluations a crossing", searched as f64 / 100.0);
    assert!(searched < 800, "{searched}");
}
