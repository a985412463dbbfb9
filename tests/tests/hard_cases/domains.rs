//! Lagrangians that are defined for some velocities or positions only: steps and the Legendre
//! transform stay within the domain of L.

use sve_runtime::StateLanes;
use sve_runtime::prelude::*;

use super::roots::{assert_near, end};
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
    let midpoint = Integrator::new(Logarithmic, Midpoint);
    let endpoint = Integrator::new(Logarithmic, Endpoint);
    let initial_point = Integrator::new(Logarithmic, InitialPoint);
    for v in [0.1, 0.7, 0.75, 0.9, 0.999, -0.7] {
        let p = 2.0 * v / (1.0 - v * v);
        for h in [1e-4, 1e-2] {
            // the motion to second order: q̇ = v, ṗ = −q
            let expected = [0.3 + h * v, p - h * 0.3 - 0.5 * h * h * v];
            for found in [
                end(&midpoint, [0.3, p], h, []).unwrap(),
                end(&endpoint, [0.3, p], h, []).unwrap(),
                end(&initial_point, [0.3, p], h, []).unwrap(),
            ] {
                assert_near(found, expected, 2.0 * h * h);
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
            let check = |found: Result<[f64; 2], StepError>, at: f64| {
                let [q, p1] = found.unwrap();
                assert!((q - h * velocity(at)).abs() <= 1e-13 * q, "{ratio} {q}");
                assert!((p1 - p - h).abs() <= 1e-13 * p, "{p1}");
            };
            check(
                end(&Integrator::new(Falling { c }, Midpoint), [0.0, p], h, []),
                p + 0.5 * h,
            );
            check(
                end(&Integrator::new(Falling { c }, Endpoint), [0.0, p], h, []),
                p,
            );
            check(
                end(
                    &Integrator::new(Falling { c }, InitialPoint),
                    [0.0, p],
                    h,
                    [],
                ),
                p + h,
            );
            end(&Integrator::new(Falling { c }, Taylor2), [0.0, p], h, []).unwrap();
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
        assert_near(
            [CoshKinetic
                .velocity(&State::new([0.0], [v.sinh()]))
                .unwrap()[0]; 2],
            [v; 2],
            1e-14,
        );
        assert_near(
            [Exponential.velocity(&State::new([0.0], [v.exp()])).unwrap()[0]; 2],
            [v; 2],
            1e-14,
        );
        assert_near(
            [Entropic
                .velocity(&State::new([0.1], [v.abs().ln() + 1.0]))
                .unwrap()[0]; 2],
            [v.abs(); 2],
            1e-13,
        );
    }
    // no velocity has a negative momentum
    assert!(Exponential.velocity(&State::new([0.0], [-1.0])).is_err());
    let h = 1e-2;
    let [q, p] = end(
        &Integrator::new(Exponential, Midpoint),
        [0.0, 5.0_f64.exp()],
        h,
        [],
    )
    .unwrap();
    assert_near([q, p], [5.0 * h, 5.0_f64.exp() - 2.5 * h * h], 1e-6);
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
    let mut state = start;
    let error = endpoint.step(&mut state, 0.1, &[]).unwrap_err();
    assert_eq!(state, start);
    assert!(matches!(error, StepError::OutsideDomain { .. }), "{error}");
    let message = error.to_string();
    for part in ["q₁ > 0", "h = 1e-1", "smaller h"] {
        assert!(message.contains(part), "{message}");
    }
    let states = StateLanes::splat(&start);
    let mut next = states;
    let prepared = endpoint.prepare(0.1).unwrap();
    let left = endpoint.step_lanes(&prepared, &states, &mut next, 0.1, &[]);
    assert_eq!((left, next), (u32::MAX, states));
    // an implicit step is repelled by the border, and turns back
    let [q, p] = end(&Integrator::new(Charged, Midpoint), [0.1, -5.0], 1.0, []).unwrap();
    assert!(q > 0.0 && p > 0.0, "{q} {p}");
}
