//! Lagrangians that are defined for some velocities or positions only: steps and the Legendre
//! transform stay within the domain of L.

use sve_models::assert_matches;
use sve_models::checks::{assert_relative, assert_says, failure};
use sve_models::orders::numbers;
use sve_models::stepper::{one_node, with_taylor2};
use sve_runtime::__private::StateLanes;
use sve_runtime::prelude::*;

use super::roots::end;
use super::wild::CoshKinetic;

struct Logarithmic;

#[variational(midpoint, endpoint, initial_point)]
impl Logarithmic {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        -(1.0 - v * v).ln() - 0.5 * q * q
    }
}

/// The equations of the step have a solution with v ≈ 10⁹, where L is not defined.
#[test]
fn solutions_outside_of_the_domain_are_none() {
    for v in [0.1, 0.7, 0.75, 0.9, 0.999, -0.7] {
        let p = 2.0 * v / (1.0 - v * v);
        for h in [1e-4, 1e-2] {
            // the motion to second order: q̇ = v, ṗ = −q
            let expected = [0.3 + h * v, p - h * 0.3 - 0.5 * h * h * v];
            for rule in one_node(&Logarithmic) {
                let found = numbers(&rule.after(State::new([0.3], [p]), h, &[], 1));
                assert_relative(&found, &expected, 2.0 * h * h, rule.name());
            }
        }
        assert!((Logarithmic.velocity(&State::new([0.3], [p])).unwrap()[0] - v).abs() < 1e-14);
    }
}

struct Falling {
    c: f64,
}

#[variational(midpoint, endpoint, initial_point, taylor2)]
impl Falling {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        -self.c.powi(2) * (1.0 - v * v / self.c.powi(2)).sqrt() + q
    }
}

/// A relativistic particle under unit force: v = p/√(1 + p²/c²) at each momentum, p₁ = p₀ + h by
/// every rule.
#[test]
fn relativistic_momenta_of_any_size() {
    for c in [1.0, 299_792_458.0] {
        for ratio in [1e-3, 0.5, 0.9999, 1.0, 1.001, 3.0, 50.0, 1e3, 1e6] {
            let (p, h) = (ratio * c, 1e-3);
            let velocity = |p: f64| p / (1.0 + (p / c).powi(2)).sqrt();
            let falling = Falling { c };
            // the momenta whose velocities the rules take; that of the Taylor series has none
            let nodes = [Some(p + h), Some(p + 0.5 * h), Some(p), None];
            for (rule, at) in with_taylor2(&falling).iter().zip(nodes) {
                let end = rule.after(State::new([0.0], [p]), h, &[], 1);
                let Some(at) = at else { continue };
                let ([q], [p1]) = (end.q, end.p);
                assert!((q - h * velocity(at)).abs() <= 1e-13 * q, "{ratio} {q}");
                assert!((p1 - p - h).abs() <= 1e-13 * p, "{p1}");
            }
        }
    }
}

struct Gyrating;

#[variational(midpoint)]
impl Gyrating {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let speed = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        -(1.0 - speed).sqrt() + 0.5 * (q[0] * v[1] - q[1] * v[0])
    }
}

/// In a magnetic field the kinetic momentum keeps its size, here of 5 mc, and turns.
#[test]
fn a_relativistic_particle_gyrates() {
    let integrator = Integrator::new(Gyrating, Midpoint);
    let kinetic = |s: &State<[f64; 3]>| [s.p[0] + 0.5 * s.q[1], s.p[1] - 0.5 * s.q[0], s.p[2]];
    let size = |s: &State<[f64; 3]>| kinetic(s).iter().map(|x| x * x).sum::<f64>().sqrt();
    let start = State::new([0.0; 3], [4.0, 0.0, 3.0]);
    let end = integrator.trajectory(start, 0.05, NoNoise).take(400).last();
    let end = end.unwrap().unwrap();
    assert!((size(&end) - 5.0).abs() < 1e-12, "{end:?}");
    assert!((end.p[0] - 4.0).abs() > 0.1);
}

struct Exponential;

#[variational(midpoint)]
impl Exponential {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v.exp() - 0.5 * q * q
    }
}

struct Entropic;

#[variational(midpoint)]
impl Entropic {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v * v.ln() - 0.5 * q * q
    }
}

/// Momenta that grow like an exponential of the velocity, and a velocity that cannot vanish.
#[test]
fn the_legendre_transform_is_followed() {
    for v in [-3.0_f64, 0.1, 5.0, 50.0, 300.0] {
        let at = |q: f64, p: f64| State::new([q], [p]);
        let cosh = CoshKinetic.velocity(&at(0.0, v.sinh())).unwrap();
        assert_relative(&cosh, &[v], 1e-14, "cosh");
        let exponential = Exponential.velocity(&at(0.0, v.exp())).unwrap();
        assert_relative(&exponential, &[v], 1e-14, "exp");
        let entropic = Entropic.velocity(&at(0.1, v.abs().ln() + 1.0)).unwrap();
        assert_relative(&entropic, &[v.abs()], 1e-13, "v ln v");
    }
    // no velocity has a negative momentum
    assert!(Exponential.velocity(&State::new([0.0], [-1.0])).is_err());
    let h = 1e-2;
    let (exponential, p) = (Integrator::new(Exponential, Midpoint), 5.0_f64.exp());
    let found = end(&exponential, [0.0, p], h, []).unwrap();
    assert_relative(&found, &[5.0 * h, p - 2.5 * h * h], 1e-6, "exp");
    end(&Integrator::new(Entropic, Midpoint), [0.1, 1.0], h, []).unwrap();
}

struct Charged;

#[variational(endpoint, midpoint)]
impl Charged {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.ln()
    }
}

/// An explicit step across the border of the domain is an error that names it, and in lanes it is
/// left to the single step.
#[test]
fn explicit_steps_stay_within_the_domain() {
    let endpoint = Integrator::new(Charged, Endpoint);
    let start = State::new([0.1], [-5.0]);
    let error = failure(&endpoint, &start, 0.1, &[]);
    assert_matches!(error, StepError::OutsideDomain { .. });
    assert_says(error, &["q₁ > 0", "h = 1e-1", "smaller h"]);
    let states = StateLanes::splat(&start);
    let mut next = states;
    let prepared = endpoint.prepare(0.1).unwrap();
    let left = endpoint.step_lanes(&prepared, &states, &mut next, 0.1, &[]);
    assert_eq!((left, next), (u32::MAX, states));
    // an implicit step is repelled by the border, and turns back
    let [q, p] = end(&Integrator::new(Charged, Midpoint), [0.1, -5.0], 1.0, []).unwrap();
    assert!(q > 0.0 && p > 0.0, "{q} {p}");
}
