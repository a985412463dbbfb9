//! Strong orders of noises that are forces.
//!
//! The corrections of rules with one node at an end show: without them the order is 0.

use sve_models::models::Rubbed;
use sve_models::orders::{Row, end};
use sve_runtime::plan::StrongOrder;
use sve_runtime::prelude::*;

use super::strong_order::{FINE, check_against_fine_steps};

/// An oscillator whose friction is noisy, `f = σp`.
#[derive(Clone, Copy, Debug)]
struct Friction {
    sigma: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet, gauss(2))]
impl Friction {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[force(noise)]
    fn rub(&self, _q: f64, v: f64) -> f64 {
        self.sigma * v
    }
}

/// Two oscillators in a flow that turns: no γ has this force.
#[derive(Clone, Copy, Debug)]
struct Curl {
    sigma: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Curl {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (q[0] * q[0] + q[1] * q[1])
    }

    #[force(noise)]
    fn stir(&self, q: [f64; 2], _v: [f64; 2]) -> [f64; 2] {
        [-self.sigma * q[1], self.sigma * q[0]]
    }
}

/// Noisy friction that is the same in all directions, beside turns of the plane: both commute, and
/// their correction has the terms of a pair of a Hamiltonian and a force.
#[derive(Clone, Copy, Debug)]
struct Turned {
    s: [f64; 2],
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Turned {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * q[0] * q[0] - q[1] * q[1]
    }

    #[h1]
    fn turn(&self, q: [f64; 2], p: [f64; 2]) -> f64 {
        self.s[0] * (q[0] * p[1] - q[1] * p[0])
    }

    #[force(noise)]
    fn rub(&self, _q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        v.map(|v| self.s[1] * v)
    }
}

/// A mass of the position, a force, and noises that do not commute: in positions and momenta, and a
/// force of position and velocity.
#[derive(Clone, Copy, Debug)]
struct Mixed {
    s: [f64; 2],
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Mixed {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * (1.0 + 0.3 * q * q) * v * v - 0.5 * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        self.s[0] * (0.2 * (1.0 + q * q) * p * p + q.sin())
    }

    #[force]
    fn drag(&self, _q: f64, v: f64) -> f64 {
        -0.3 * v
    }

    #[force(noise)]
    fn rub(&self, q: f64, v: f64) -> f64 {
        self.s[1] * (0.5 * v + 0.2 * q * v + 0.3 * q)
    }
}

/// Friction noise beside a push, which do not commute.
#[derive(Clone, Copy, Debug)]
struct Clashing;

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Clashing {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[force(noise)]
    fn rub(&self, _q: f64, v: f64) -> f64 {
        0.5 * v
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        0.6 * q
    }
}

/// The end of a path of [`Friction`] by an explicit formula for a step.
fn by_formula(step: impl Fn([f64; 2], f64, f64) -> [f64; 2], path: &Recorded) -> Vec<f64> {
    let mut state = [0.8, 0.5];
    for at in 0..path.len() {
        state = step(state, path.h(), path.get(at).unwrap()[0]);
    }
    state.to_vec()
}

/// The midpoint rule with the force of the noise at the start, and the endpoint rule without a
/// correction.
fn wrong(system: Friction) -> [Row<'static>; 2] {
    let row = |rule: &str, end| Row {
        system: "Friction".to_owned(),
        rule: rule.to_owned(),
        order: 0.0,
        end,
    };
    let sigma = system.sigma;
    let midpoint = move |[q, p]: [f64; 2], h: f64, dw: f64| {
        let kicked = p + sigma * p * dw;
        // q₁ = q + h (p + p₁)/2, p₁ = kicked − h (q + q₁)/2
        let c = 0.25 * h * h;
        let next = (kicked - h * q - c * p) / (1.0 + c);
        [q + 0.5 * h * (p + next), next]
    };
    let endpoint = move |[q, p]: [f64; 2], h: f64, dw: f64| {
        let q = q + h * p;
        [q, p - h * q + sigma * p * dw]
    };
    [
        row(
            "midpoint, f at the start",
            Box::new(move |path| by_formula(midpoint, path)),
        ),
        row(
            "endpoint, uncorrected",
            Box::new(move |path| by_formula(endpoint, path)),
        ),
    ]
}

#[test]
fn friction_noise() {
    let system = Friction { sigma: 0.6 };
    let start = State::new([0.8], [0.5]);
    let mut rows = Row::rules(&system, start);
    rows.push(Row::new(&system, Gauss::<2>, start));
    rows.extend(wrong(system));
    let midpoint = Integrator::new(&system, Midpoint);
    let path = FINE.against(1, |fine| end(&midpoint, start, fine));
    FINE.check("f = σp", &rows, path);
}

#[test]
fn a_force_without_potential() {
    let (system, start) = (Curl { sigma: 0.7 }, State::new([0.8, -0.3], [0.5, 0.2]));
    check_against_fine_steps(&system, "f = σ(−y, x)", StrongOrder::One, start);
}

#[test]
fn two_friction_noises() {
    let (m, start) = (1.3, State::new([0.8], [0.5]));
    let system = Rubbed { m, s: [0.5, 0.3] };
    check_against_fine_steps(&system, "f = σ₁p, σ₂p", StrongOrder::One, start);
}

#[test]
fn friction_noise_and_turns() {
    let system = Turned { s: [0.5, 0.4] };
    let start = State::new([0.8, -0.3], [0.5, 0.2]);
    let noise = "H₁ = σ₁(q₀p₁ − q₁p₀), f = σ₂p";
    check_against_fine_steps(&system, noise, StrongOrder::One, start);
}

#[test]
fn noises_that_do_not_commute() {
    let half = |a, b| StrongOrder::Half { pair: (a, b) };
    let start = State::new([0.8], [0.5]);
    let system = Mixed { s: [0.4, 0.6] };
    let noise = "H₁ of p², f of p and q";
    check_against_fine_steps(&system, noise, half("jitter", "rub"), start);
    let noise = "f = p/2, γ = 0.6q";
    check_against_fine_steps(&Clashing, noise, half("push", "rub"), start);
}
