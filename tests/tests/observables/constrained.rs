//! Sections, bounces and temperatures on a manifold; sections of a degenerate Lagrangian.

use sve_runtime::prelude::*;
use sve_runtime::{Blocking, Rule};

use super::systems::Sphere;

type Point = State<Vector3<f64>>;

fn sphere() -> Sphere {
    Sphere {
        g: 1.0,
        nu: 0.0,
        sigma: 0.0,
    }
}

fn start() -> Point {
    let q = Vector3::new(0.6, 0.0, 0.8);
    State::new(q, Vector3::new(0.4, 1.1, -0.3))
}

fn is_on_the_sphere(state: &Point) -> bool {
    (state.q.norm() - 1.0).abs() < 1e-13 && state.q.dot(&state.p).abs() < 1e-13
}

/// The crossings of the equator by a rule, with error of order 2 at a fixed number of steps, and on
/// the sphere.
fn section<R>(motion: &Integrator<Sphere, R>, h: f64) -> Vec<Point>
where
    R: Rule<Sphere, Increments = [f64; 3]>,
{
    let path = motion.trajectory(motion.consistent(start()).unwrap(), h, NoNoise);
    let section: Vec<Point> = path
        .crossings(|_, s| s.q.z)
        .take(6)
        .map(Result::unwrap)
        .collect();
    for state in &section {
        assert!(
            state.q.z.abs() < 1e-14 && is_on_the_sphere(state),
            "{state:?}"
        );
    }
    section
}

fn order<R>(rule: R)
where
    R: Rule<Sphere, Increments = [f64; 3]>,
{
    let motion = Integrator::new(sphere(), rule);
    let exact = section(&motion, 0.1 / 64.0);
    let error = |h: f64| {
        let found = section(&motion, h);
        let pairs = found.iter().zip(&exact);
        pairs
            .map(|(a, b)| (a.q - b.q).norm() + (a.t - b.t).abs())
            .fold(0.0, f64::max)
    };
    let order = (error(0.1) / error(0.025)).log2() / 2.0;
    assert!((order - 2.0).abs() < 0.1, "{order}");
}

#[test]
fn sections_on_a_sphere() {
    order(Midpoint);
    order(StormerVerlet);
}

/// A particle that bounces off the equator keeps its energy as well as without bounces, and stays
/// on the sphere.
#[test]
fn bounces_on_a_sphere() {
    let motion = Integrator::new(sphere(), Midpoint);
    let begin = motion.consistent(start()).unwrap();
    let energy = motion.system().hamiltonian(&begin).unwrap();
    let mut bounces = 0;
    let path = motion
        .trajectory(begin, 0.02, NoNoise)
        .change_at(
            |_, s| s.q.z,
            |_, s| {
                s.p.z = -s.p.z;
                bounces += 1;
            },
        )
        .falling();
    for state in path.take(2000) {
        let state = state.unwrap();
        assert!(state.q.z > -1e-12 && is_on_the_sphere(&state));
        let error = motion.system().hamiltonian(&state).unwrap() - energy;
        assert!(error.abs() < 1e-3, "{error}");
    }
    assert!(bounces > 5, "{bounces}");
    // a change that leaves the sphere is an error of the next step
    let path = motion
        .trajectory(begin, 0.02, NoNoise)
        .change_at(|_, s| s.q.z, |_, s| s.q *= 1.1);
    let error = path.take(2000).find_map(Result::err).unwrap();
    assert!(
        matches!(error, StepError::InconsistentStart { .. }),
        "{error}"
    );
}

/// A sphere has two degrees of freedom: the mean temperature is that of the bath up to the error of
/// the rule.
#[test]
fn the_temperature_on_a_sphere() {
    let system = Sphere {
        g: 1.0,
        nu: 1.0,
        sigma: 1.0,
    };
    let motion = Integrator::new(system, Midpoint);
    let begin = motion.consistent(start()).unwrap();
    let mut temperature = Blocking::new();
    let path = motion.trajectory(begin, 0.05, Wiener::new(6));
    for state in path.skip(200).take(100_000) {
        temperature.push(system.temperature(&state.unwrap()).unwrap());
    }
    let error = temperature.standard_error().unwrap();
    let mean = temperature.mean();
    println!("{mean} {error}");
    assert!((mean - 0.5).abs() < 4.0 * error + 2e-3, "{mean} {error}");
}

/// Two conjugate coordinates: L is linear in the velocities.
struct Planar;

#[variational(midpoint)]
impl Planar {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (q[0] * v[1] - q[1] * v[0]) - 0.5 * (q[0] * q[0] + q[1] * q[1])
    }
}

/// The motion is a turn with unit rate. The section of its circle is a point, at times that are a
/// turn apart up to the phase error h²/12 of the rule.
#[test]
fn a_section_of_a_degenerate_lagrangian() {
    let motion = Integrator::new(Planar, Midpoint);
    let begin = State::from_configuration(&Planar, [1.0, 0.5]).unwrap();
    let h = 0.1;
    let section = motion
        .trajectory(begin, h, NoNoise)
        .crossings(|_, s| s.q[1])
        .rising();
    let states: Vec<_> = section.take(5).map(Result::unwrap).collect();
    let turn = std::f64::consts::TAU;
    for pair in states.windows(2) {
        assert!((pair[1].t - pair[0].t - turn * (1.0 + h * h / 12.0)).abs() < 1e-3);
        assert!((pair[1].q[0].abs() - 1.25_f64.sqrt()).abs() < 1e-12);
    }
    let error = Planar.temperature(&begin).unwrap_err();
    assert!(matches!(error, StepError::Degenerate { .. }), "{error}");
}
