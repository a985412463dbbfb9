//! Noises that are forces: `f(q)` has the weak order 2 with the option `weak2`, `f(v)` has 1.

use sve_runtime::prelude::*;

use super::moments::exact;
use super::stages::of_two_stages;
use super::{for_each_rule, linear, matrix};

/// Two coordinates that the masses couple, M = (1, ½; ½, 2), with a noise force Nq, a noise
/// γ = ½σq₀² that commutes with it, and friction.
#[derive(Clone)]
struct Whirled {
    n: [[f64; 2]; 2],
    sigma: f64,
    friction: f64,
}

#[variational(
    initial_point,
    endpoint,
    midpoint,
    midpoint(weak2),
    stormer_verlet,
    stormer_verlet(weak2),
    gauss(2),
    gauss(2, weak2),
    gauss(4, weak2)
)]
impl Whirled {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * v[0] * v[0] + v[1] * v[1] + 0.5 * v[0] * v[1] - 0.5 * q[0] * q[0] - q[1] * q[1]
    }

    #[gamma]
    fn stiffness(&self, q: [f64; 2]) -> f64 {
        0.5 * self.sigma * q[0] * q[0]
    }

    #[force]
    fn drag(&self, _q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        [
            -self.friction * (v[0] + 0.5 * v[1]),
            -self.friction * (0.5 * v[0] + 2.0 * v[1]),
        ]
    }

    #[force(noise)]
    fn stir(&self, q: [f64; 2], _v: [f64; 2]) -> [f64; 2] {
        let [a, b] = self.n;
        [a[0] * q[0] + a[1] * q[1], b[0] * q[0] + b[1] * q[1]]
    }
}

/// An oscillator whose friction is noisy.
#[derive(Clone)]
struct Rubbed {
    sigma: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet, gauss(2))]
impl Rubbed {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[force(noise)]
    fn rub(&self, _q: f64, v: f64) -> f64 {
        self.sigma * v
    }
}

#[test]
fn forces_without_potential() {
    let start = State::new([1.0, -0.5], [0.2, 0.3]);
    for (n, sigma, friction, noise) in [
        ([[0.0, -0.7], [0.7, 0.0]], 0.0, 0.0, "f = σ(−y, x)"),
        ([[0.3, -0.7], [0.5, 0.2]], 0.0, 0.4, "f = Nq, friction"),
        ([[0.0, -0.7], [0.4, 0.0]], 0.5, 0.0, "f = Nq, γ = ½σx²"),
    ] {
        let system = Whirled { n, sigma, friction };
        // M⁻¹ of the masses
        let (a, b, c) = (2.0 / 1.75, -0.5 / 1.75, 1.0 / 1.75);
        let zero = [0.0; 5];
        let drift = matrix([
            [0.0, 0.0, a, b, 0.0],
            [0.0, 0.0, b, c, 0.0],
            [-1.0, 0.0, -friction, 0.0, 0.0],
            [0.0, -2.0, 0.0, -friction, 0.0],
            zero,
        ]);
        let row = |n: [f64; 2]| [n[0], n[1], 0.0, 0.0, 0.0];
        let noises = vec![
            matrix([zero, zero, [sigma, 0.0, 0.0, 0.0, 0.0], zero, zero]),
            matrix([zero, zero, row(n[0]), row(n[1]), zero]),
        ];
        let exact = exact(start, &drift, |_| noises.clone());
        let plain = Integrator::new(system.clone(), Midpoint);
        let plain = linear(&plain, noise, start, &exact);
        let corrected = Integrator::new(system.clone(), Weak2(Midpoint));
        let corrected = linear(&corrected, noise, start, &exact);
        // steps of 2⁻⁵
        assert!(plain[1] > 4.0 * corrected[1], "{plain:?} {corrected:?}");
        for_each_rule!(linear, system.clone(), every, (noise, start, &exact));
        let fourth = Integrator::new(system, Weak2(Gauss::<4>));
        linear(&fourth, noise, start, &exact);
    }
}

/// Two coordinates under `f = σ(−y, x)`.
struct Curl {
    sigma: f64,
}

#[variational(gauss(2, stage_noise), gauss(2, stage_noise, weak2))]
impl Curl {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (q[0] * q[0] + q[1] * q[1])
    }

    #[force(noise)]
    fn stir(&self, q: [f64; 2], _v: [f64; 2]) -> [f64; 2] {
        [-self.sigma * q[1], self.sigma * q[0]]
    }
}

#[test]
fn stage_noise() {
    let (start, sigma) = (State::new([1.0, -0.5], [0.2, 0.3]), 0.7);
    let zero = [0.0; 5];
    let drift = matrix([
        [0.0, 0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 1.0, 0.0],
        [-1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, -1.0, 0.0, 0.0, 0.0],
        zero,
    ]);
    let rows = [[0.0, -sigma, 0.0, 0.0, 0.0], [sigma, 0.0, 0.0, 0.0, 0.0]];
    let noise = matrix([zero, zero, rows[0], rows[1], zero]);
    let exact = exact(start, &drift, |_| vec![noise.clone()]);
    let plain = Integrator::new(Curl { sigma }, StageNoise(Gauss::<2>));
    of_two_stages(&plain, ("f = σ(−y, x)", 1), start, &exact);
    // above the order 2 that the plan states
    let corrected = Integrator::new(Curl { sigma }, Weak2(StageNoise(Gauss::<2>)));
    of_two_stages(&corrected, ("f = σ(−y, x)", 3), start, &exact);
}

/// The exact moments of `dq = p dt`, `dp = −q dt + σp ∘ dW`. The quadrature over increments has no
/// nodes beyond the poles of the steps.
#[test]
fn friction_noise() {
    // from other starts the leading errors of some rules nearly cancel
    let (start, sigma) = (State::new([0.3], [1.0]), 0.6);
    let drift = matrix([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0; 3]]);
    let noise = matrix([[0.0; 3], [0.0, sigma, 0.0], [0.0; 3]]);
    let exact = exact(start, &drift, |_| vec![noise.clone()]);
    for_each_rule!(
        linear,
        Rubbed { sigma },
        (InitialPoint, Endpoint, Midpoint, StormerVerlet, Gauss::<2>),
        ("f = σp", start, &exact)
    );
}
