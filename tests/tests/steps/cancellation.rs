//! Differences and powers that lose all digits if they are evaluated as they are written. Generated
//! energies, derivatives and steps keep their digits.

use sve_models::checks::failure;
use sve_models::stepper::one_node;
use sve_runtime::prelude::*;

/// A pendulum whose potential is zero at the lowest point.
#[derive(Debug)]
struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - self.g * (1.0 - q.cos())
    }
}

/// A relativistic particle without its energy at rest.
#[derive(Debug)]
struct Relativistic {
    m: f64,
    c: f64,
}

#[variational(midpoint)]
impl Relativistic {
    fn lagrangian(&self, _q: f64, v: f64) -> f64 {
        let rest = self.m * self.c.powi(2);
        rest - rest * (1.0 - v.powi(2) / self.c.powi(2)).sqrt()
    }
}

/// A bead on a cycloid, whose mass vanishes at the cusp, θ = 0.
#[derive(Debug)]
struct Cycloid;

#[variational(midpoint, endpoint, initial_point)]
impl Cycloid {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        (1.0 - q.cos()) * v * v
    }
}

/// The same system, written so that nothing cancels.
#[derive(Debug)]
struct Reference;

#[variational(midpoint, endpoint, initial_point)]
impl Reference {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        2.0 * (q / 2.0).sin().powi(2) * v * v
    }
}

/// A potential whose base and exponent are both coordinates.
#[derive(Debug)]
struct Power;

#[variational(initial_point)]
impl Power {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - q[0].powf(q[1])
    }
}

/// A few units of rounding. Evaluated as they are written, the values below would have at most two
/// correct digits.
const ROUNDINGS: f64 = 8.0 * f64::EPSILON;

fn assert_close(found: f64, expected: f64, bound: f64) {
    assert!(
        (found - expected).abs() <= bound * expected.abs(),
        "{found:e} for {expected:e}"
    );
}

#[test]
fn energies_of_small_motions() {
    let system = Pendulum { g: 9.8 };
    let energy = |q, p| system.hamiltonian(&State::new([q], [p])).unwrap();
    assert_close(energy(1e-9, 0.0), 4.9e-18, ROUNDINGS);
    assert_close(energy(-1e-9, 0.0), 4.9e-18, ROUNDINGS);
    assert_close(energy(1e-9, 2e-9), 4.9e-18 + 2e-18, ROUNDINGS);
    // and of large ones
    assert_close(energy(std::f64::consts::PI, 0.0), 19.6, ROUNDINGS);
    let system = Relativistic { m: 2.0, c: 3.0 };
    let energy = system.hamiltonian(&State::new([0.0], [1e-8])).unwrap();
    assert_close(energy, 0.25e-16, ROUNDINGS);
}

#[test]
fn steps_where_the_mass_cancels() {
    // θ²/2 θ'² has its digits in the velocity: 1 − cos 1e-6 has four, and the step would have as
    // many
    let start = State::new([1e-6], [3e-18]);
    for (rule, reference) in one_node(&Cycloid).iter().zip(one_node(&Reference)) {
        let found = rule.after(start, 0.05, &[], 5);
        let expected = reference.after(start, 0.05, &[], 5);
        // five solves to the rounding level
        assert_close(found.q[0], expected.q[0], 1e-13);
        assert_close(found.p[0], expected.p[0], 1e-13);
    }
}

#[test]
fn powers_of_zero_with_an_exponent_that_moves() {
    let integrator = Integrator::new(Power, InitialPoint);
    // 0^y and its derivatives vanish for y > 1
    let mut state = State::new([0.0, 2.5], [0.5, 0.25]);
    integrator.step(&mut state, 0.5, &[]).unwrap();
    assert_eq!((state.q, state.p), ([0.25, 2.625], [0.5, 0.25]));
    // the force is −(y x^(y−1), x^y ln x)
    let mut state = State::new([2.0, 3.0], [0.0, 0.0]);
    integrator.step(&mut state, 0.5, &[]).unwrap();
    assert_close(state.p[0], -6.0, ROUNDINGS);
    assert_close(state.p[1], -4.0 * std::f64::consts::LN_2, ROUNDINGS);
    // no derivative in the exponent, and an error instead of a step
    failure(&integrator, &State::new([0.0; 2], [0.0; 2]), 0.5, &[]);
}
