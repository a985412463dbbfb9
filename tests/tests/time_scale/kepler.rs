//! Orbits of high eccentricity against their exact solution, and their energy along many periods.

use std::f64::consts::TAU;

use sve_runtime::prelude::*;

use super::{Comet, on_orbit, perihelion};

/// A position is as exact as its time, so errors of the time are seen at the perihelion.
#[test]
fn orbits_of_high_eccentricity_are_those_of_keplers_equation() {
    let comet = Integrator::new(Comet { mu: 1.0 }, Gauss::<8>);
    for (eccentricity, steps_a_period) in [(0.9, 11.0), (0.99, 15.0)] {
        let path = comet.trajectory(perihelion(eccentricity), 0.8, NoNoise);
        let times = (0..=60).map(|k| f64::from(k) * (TAU / 6.0));
        let mut saved = path.at(times.clone());
        for t in times {
            let state = saved.next().expect("a time").expect("a step");
            assert_eq!(state.t, t);
            let exact = on_orbit(eccentricity, t);
            let error = (state.q[0] - exact[0]).hypot(state.q[1] - exact[1]);
            assert!(error < 2e-11, "{eccentricity} {t}: {error:e}");
        }
        assert!(saved.next().is_none());
        let steps = saved.step() as f64 / 10.0;
        assert!(steps < steps_a_period, "{steps}");
    }
}

#[test]
fn the_energy_has_no_drift() {
    let comet = Integrator::new(Comet { mu: 1.0 }, Gauss::<8>);
    let start = perihelion(0.9);
    let mut path = comet.trajectory(start, 0.9, NoNoise);
    let mut means = Vec::new();
    for _ in 0..10 {
        let (mut sum, mut most) = (0.0, 0.0_f64);
        for _ in 0..1000 {
            let state = path.advance(1).expect("a step");
            let excess = comet.system().hamiltonian(state).expect("an energy") - start.energy();
            sum += excess;
            most = most.max(excess.abs());
        }
        assert!(most < 5e-12, "{most:e}");
        means.push(sum / 1000.0);
    }
    // a thousand periods
    assert!(path.state().t > 1000.0 * TAU);
    let [first, last] = [means[0], means[9]];
    assert!((last - first).abs() < 5e-13, "{means:?}");
}

#[test]
fn a_thousand_periods_end_at_the_perihelion() {
    let comet = Integrator::new(Comet { mu: 1.0 }, Gauss::<8>);
    let start = perihelion(0.9);
    let end = comet.trajectory(start, 0.9, NoNoise).until(1000.0 * TAU);
    let end = end.last().expect("a state").expect("a step");
    let error = (end.q[0] - start.q[0]).hypot(end.q[1]);
    assert!(error < 2e-9, "{error:e}");
}

/// The place at a time converges with the order of the rule: the times of its steps do too.
#[test]
fn places_at_a_time_converge_with_the_orders_of_the_rules() {
    fn errors<'a, R>(comet: &'a Integrator<Comet, R>, h: f64) -> [f64; 2]
    where
        R: Copy + sve_runtime::Rule<<Comet as WithTimeScale>::Held<'a>, Increments = [f64; 0]>,
    {
        let exact = on_orbit(0.6, 2.0);
        [h, 0.5 * h].map(|h| {
            let path = comet.trajectory(perihelion(0.6), h, NoNoise).until(2.0);
            let end = path.last().expect("a state").expect("a step");
            (end.q[0] - exact[0]).hypot(end.q[1] - exact[1])
        })
    }
    let comet = Comet { mu: 1.0 };
    for (order, [coarse, fine]) in [
        (1, errors(&Integrator::new(comet, InitialPoint), 0.002)),
        (1, errors(&Integrator::new(comet, Endpoint), 0.002)),
        (2, errors(&Integrator::new(comet, Midpoint), 0.02)),
        (2, errors(&Integrator::new(comet, StormerVerlet), 0.02)),
        (4, errors(&Integrator::new(comet, Gauss::<2>), 0.1)),
        (6, errors(&Integrator::new(comet, Gauss::<3>), 0.2)),
        (
            8,
            errors(
                &Integrator::new(comet, Composed::new(Midpoint, KahanLi8)),
                0.4,
            ),
        ),
    ] {
        let found = (coarse / fine).log2();
        assert!((found - f64::from(order)).abs() < 0.3, "{order} {found}");
    }
}
