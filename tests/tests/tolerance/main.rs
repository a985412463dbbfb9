//! Paths with a tolerance: their errors, their times, what is read from them, what they refuse.

mod continued;
mod failures;
mod systems;

use core::f64::consts::TAU;

use sve_runtime::prelude::*;
use systems::{Ball, Channel, DoublePendulum, Kepler, Pendulum, distance, perihelion};

/// Checks the errors at the end of a path for tolerances from 10⁻⁴ to 10⁻¹². They are below
/// `$factor` times the tolerance, or below rounding errors.
macro_rules! check_errors {
    ($system:expr, $start:expr, $t:expr, $end:expr, $factor:expr, $($stages:literal)*) => {$({
        let integrator = Integrator::new($system, Gauss::<$stages>);
        let mut errors = Vec::new();
        for exponent in 4..=12 {
            let tolerance = 10.0_f64.powi(-exponent);
            let path = integrator.trajectory($start, 0.1, NoNoise).tolerance(tolerance);
            let end = path.until($t).last().unwrap().unwrap();
            let error = distance(&end, $end);
            let bound = $factor * tolerance + 2e-12;
            assert!(error < bound, "{} stages, {tolerance:e}: {error:e}", $stages);
            errors.push(error);
        }
        // the tolerance is used: the first error is not a rounding error
        assert!(errors[0] > 1e-12, "{} stages: {errors:?}", $stages);
    })*};
}

/// Returns half of the period of a pendulum from rest at 2, which leads to −2: π over the
/// arithmetic-geometric mean of 1 and cos 1.
fn half_period() -> f64 {
    let (mut a, mut b) = (1.0, 1.0_f64.cos());
    for _ in 0..6 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    core::f64::consts::PI / a
}

#[test]
fn errors_after_a_period_are_about_the_tolerance() {
    let start = perihelion(0.6);
    check_errors!(Kepler, start, TAU, &start, 1.0, 4 5 6 7 8);
    let start = perihelion(0.9);
    check_errors!(Kepler, start, TAU, &start, 20.0, 4 5 6 7 8);
    let (start, half) = (State::new([2.0], [0.0]), half_period());
    let end = State::at(half, [-2.0], [0.0]);
    check_errors!(Pendulum { g: 1.0 }, start, half, &end, 1.0, 4 6 8);
}

/// The masses of a double pendulum depend on its angles, so its velocities are series too.
#[test]
fn errors_with_masses_of_the_place_are_about_the_tolerance() {
    let start = State::new([1.0, 1.5], [0.0, 0.0]);
    let fixed = Integrator::new(DoublePendulum, Gauss::<8>);
    let mut reference = fixed.trajectory(start, 1.0 / 256.0, NoNoise).compensated();
    let end = *reference.advance(512).unwrap();
    check_errors!(DoublePendulum, start, 2.0, &end, 10.0, 4 6 8);
}

/// A step is as long as the tolerance allows: at equal accuracy eccentric orbits need less than a
/// tenth of the equal steps.
#[test]
fn steps_are_long_far_from_the_perihelion() {
    let kepler = Integrator::new(Kepler, Gauss::<8>);
    let path = kepler
        .trajectory(perihelion(0.9), 0.01, NoNoise)
        .tolerance(1e-10);
    let states = path.until(TAU).collect::<Result<Vec<_>, _>>().unwrap();
    assert!(states.len() < 45, "{}", states.len());
    let steps = states.windows(2).map(|pair| pair[1].t - pair[0].t);
    let (least, most) = steps.fold((f64::MAX, 0.0), |(least, most), h| {
        (h.min(least), h.max(most))
    });
    assert!(most > 50.0 * least, "{least} {most}");
}

/// At an unstable equilibrium the forces are rounding errors, and their series decays in no step.
#[test]
fn an_unstable_equilibrium_is_left_by_steps_of_the_motion() {
    use core::f64::consts::PI;
    let upright = State::new([PI], [0.0]);
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Gauss::<8>);
    let path = pendulum.trajectory(upright, 0.1, NoNoise).tolerance(1e-10);
    let states = path.until(50.0).collect::<Result<Vec<_>, _>>().unwrap();
    assert!(states.len() < 200, "{}", states.len());
    let energy = pendulum
        .system()
        .hamiltonian(states.last().unwrap())
        .unwrap();
    assert!((energy - 1.0).abs() < 1e-9, "{energy}");
    let upright = State::new([PI, PI], [0.0, 0.0]);
    let double = Integrator::new(DoublePendulum, Gauss::<8>);
    let path = double.trajectory(upright, 0.1, NoNoise).tolerance(1e-10);
    let states = path.until(5.0).collect::<Result<Vec<_>, _>>().unwrap();
    assert!(states.len() < 200, "{}", states.len());
}

#[test]
fn times_are_reached_to_the_last_bit() {
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Gauss::<8>);
    for (t0, h) in [(0.0, 0.1), (1e3, 0.1), (0.0, -0.1), (-7.3, -0.2)] {
        let start = State::at(t0, [1.0], [0.5]);
        let path = || pendulum.trajectory(start, h, NoNoise).tolerance(1e-9);
        let times = [0.0, 1e-9, 0.1, 0.1 + 1e-15, 1.0 / 3.0, 2.0, 9.7];
        let times = times.map(|t| t0 + t * h.signum());
        let states = path().at(times).collect::<Result<Vec<_>, _>>().unwrap();
        assert_eq!(states.len(), times.len());
        for (state, t) in states.iter().zip(times) {
            assert_eq!(state.t, t);
            // the same state as the end of a path
            let end = path().until(t).last();
            assert_eq!(end.map_or(start, Result::unwrap), *state);
        }
        assert_eq!(states[0], start);
    }
}

#[test]
fn what_is_saved_does_not_change_the_path() {
    let kepler = Integrator::new(Kepler, Gauss::<6>);
    let path = || {
        kepler
            .trajectory(perihelion(0.9), 0.01, NoNoise)
            .tolerance(1e-8)
    };
    let plain: Vec<_> = path().take(60).map(Result::unwrap).collect();
    let end = 0.5 * (plain[40].t + plain[41].t);
    let until: Vec<_> = path().until(end).map(Result::unwrap).collect();
    assert_eq!(until[..41], plain[..41]);
    assert_eq!((until.len(), until[41].t), (42, end));
    let every: Vec<_> = path().every(10).until(end).map(Result::unwrap).collect();
    assert_eq!([every[1], every[4]], [plain[9], plain[39]]);
    assert_eq!((every.len(), every[5]), (6, until[41]));
    let mut saved = path().at((0..300).map(|k| 0.01 * f64::from(k)));
    for state in &mut saved {
        state.unwrap();
    }
    let steps = usize::try_from(saved.step()).unwrap();
    assert_eq!(saved.state(), &plain[steps - 1]);
    // a time that is the end of a step is reached by this step
    let whole = path().until(plain[7].t).last().unwrap().unwrap();
    assert!(whole.t == plain[7].t && distance(&whole, &plain[7]) < 1e-14);
    let table = path().until(end).table().unwrap();
    assert_eq!(table.get("t").unwrap().len(), 42);
}

/// The polynomials of S stages have errors of order S + 1 within a step, and end where it ends.
#[test]
fn states_within_a_step_have_the_order_of_its_polynomials() {
    let integrator = Integrator::new(Pendulum { g: 1.0 }, Gauss::<4>);
    let start = State::at(1.0, [2.0], [0.3]);
    let error = |h: f64, fraction: f64| {
        let mut path = integrator.trajectory(start, h, NoNoise).tolerance(1e-9);
        assert_eq!(path.state_at(1.0), None);
        let end = path.next().unwrap().unwrap();
        assert_eq!(end.t, 1.0 + h);
        let (first, last) = (path.state_at(1.0).unwrap(), path.state_at(end.t).unwrap());
        assert_eq!(first, start);
        assert!(distance(&last, &end) < 1e-15);
        assert_eq!(
            [path.state_at(0.999), path.state_at(end.t + 1e-9)],
            [None; 2]
        );
        let t = 1.0 + fraction * h;
        let fine = Integrator::new(Pendulum { g: 1.0 }, Gauss::<8>);
        let exact = fine.trajectory(start, 0.01 * h, NoNoise).compensated();
        let exact = exact.until(t).last().unwrap().unwrap();
        distance(&path.state_at(t).unwrap(), &exact)
    };
    for fraction in [0.2, 0.55, 0.9] {
        let (long, short) = (error(0.125, fraction), error(0.0625, fraction));
        let order = (long / short).log2();
        assert!(
            (4.5..6.2).contains(&order),
            "{fraction}: {long:e} {short:e} {order}"
        );
    }
}

#[test]
fn sections_and_stops_are_found_to_the_tolerance() {
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Gauss::<8>);
    let (start, half) = (State::new([2.0], [0.0]), half_period());
    let path = || pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-10);
    for (k, state) in (0..6).zip(path().crossings(|_, state| state.q[0])) {
        let state = state.unwrap();
        let error = state.t - half * (0.5 + f64::from(k));
        assert!(
            error.abs() < 1e-9 && state.q[0].abs() < 1e-13,
            "{k}: {error:e}"
        );
    }
    let end = path()
        .stop_at(|_, state| state.p[0])
        .last()
        .unwrap()
        .unwrap();
    assert!((end.t - half).abs() < 1e-10);
}

/// A ball keeps its energy over bounces, and each is at the time of a free fall.
#[test]
fn a_step_ends_at_a_change_of_the_state() {
    let ball = Integrator::new(Ball, Gauss::<4>);
    let mut bounces = Vec::new();
    let path = ball
        .trajectory(State::new([0.5], [0.0]), 0.1, NoNoise)
        .tolerance(1e-12);
    let path = path
        .change_at(
            |_, ball| ball.q[0],
            |_, ball| {
                ball.p[0] = -ball.p[0];
                bounces.push(ball.t);
            },
        )
        .falling()
        .stop_at(|_, ball| ball.t - 60.0);
    let end = path.last().unwrap().unwrap();
    // each bounce cuts a step, and the next step is no longer
    assert_eq!(bounces.len(), 30);
    for (k, t) in (0..).zip(bounces) {
        assert!((t - f64::from(2 * k + 1)).abs() < 1e-11, "{k}: {t}");
    }
    assert!((end.q[0] - 0.5).abs() < 1e-11 && end.p[0].abs() < 1e-11);
}

/// The power that holds it there is one of zero.
#[test]
fn a_body_stays_in_the_middle_of_a_channel() {
    let channel = Integrator::new(Channel, Gauss::<4>);
    let start = State::new([1.0, 0.0], [0.0, 0.0]);
    let path = channel.trajectory(start, 0.1, NoNoise).tolerance(1e-10);
    let end = path.until(3.0).last().unwrap().unwrap();
    assert!((end.q[0] - 3.0_f64.cos()).abs() < 1e-9, "{end:?}");
    assert_eq!((end.q[1], end.p[1]), (0.0, 0.0));
}

/// The path back ends at the start.
#[test]
fn time_can_run_backwards() {
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Gauss::<8>);
    let start = State::new([2.0], [0.0]);
    let there = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-12);
    let there = there.until(10.0).last().unwrap().unwrap();
    let back = pendulum.trajectory(there, -0.1, NoNoise).tolerance(1e-12);
    let back = back.until(0.0).last().unwrap().unwrap();
    assert!(back.t == 0.0 && distance(&back, &start) < 1e-12);
}

/// The time of a path is the sum of the sizes of its steps, rounded once.
#[test]
fn times_are_sums_that_are_rounded_once() {
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Gauss::<8>);
    let start = State::at(1e3, [2.0], [0.0]);
    let mut path = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-10);
    let (mut sum, mut low) = (start.t, 0.0);
    for step in 0..2000 {
        let state = path.next().unwrap().unwrap();
        let h = path.snapshot().h();
        let next = sum + h;
        low += (sum - next) + h;
        sum = next;
        let error = (state.t - sum) - low;
        assert!(error.abs() <= 2.0 * f64::EPSILON * sum, "{step}: {error:e}");
    }
}
