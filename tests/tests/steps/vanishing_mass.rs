//! A kinetic energy whose mass vanishes at rest, `L = v⁴/4 − q²/2`. The Legendre transform `p = v³` is inverted, and steps are made, if
//! `p ≠ 0`.

use sve_runtime::Mechanics;
use sve_runtime::prelude::*;

struct QuarticKinetic;

#[variational(initial_point, endpoint, midpoint)]
impl QuarticKinetic {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.25 * v.powi(4) - 0.5 * q * q
    }
}

const STARTS: [(f64, f64); 5] = [
    (0.3, 8.0),
    (-1.0, -0.2),
    (0.0, 1e-3),
    (2.0, 100.0),
    (0.5, -27.0),
];

fn near(x: f64, y: f64) -> bool {
    (x - y).abs() <= 4.0 * f64::EPSILON * (x.abs() + y.abs())
}

#[test]
fn the_velocity_is_the_cube_root() {
    for (q, p) in STARTS {
        let v = QuarticKinetic.velocity(&State::new([q], [p])).unwrap()[0];
        assert!(near(v, p.cbrt()), "{v} for p = {p}");
        let energy = QuarticKinetic.hamiltonian(&State::new([q], [p])).unwrap();
        assert!(near(energy, 0.75 * p.cbrt().powi(4) + 0.5 * q * q));
    }
}

#[test]
fn steps_solve_their_equations() {
    let h = 0.01;
    for (q, p) in STARTS {
        // p₀ = v³, q₁ = q₀ + h v, p₁ = p₀ − h q₁
        let mut state = State::new([q], [p]);
        Integrator::new(QuarticKinetic, Endpoint)
            .step(&mut state, h, &[])
            .unwrap();
        let end = q + h * p.cbrt();
        assert!(
            near(state.q[0], end) && near(state.p[0], p - h * end),
            "{state:?}"
        );
        // p₁ = p₀ − h q₀ = v³, q₁ = q₀ + h v
        let mut state = State::new([q], [p]);
        Integrator::new(QuarticKinetic, InitialPoint)
            .step(&mut state, h, &[])
            .unwrap();
        let kicked = p - h * q;
        assert!(
            near(state.p[0], kicked) && near(state.q[0], q + h * kicked.cbrt()),
            "{state:?}"
        );
        // (p₀ + p₁)/2 = v³, p₁ = p₀ − h q̄
        let mut state = State::new([q], [p]);
        Integrator::new(QuarticKinetic, Midpoint)
            .step(&mut state, h, &[])
            .unwrap();
        let (v, node) = ((state.q[0] - q) / h, 0.5 * (state.q[0] + q));
        assert!(
            (0.5 * (state.p[0] + p) - v.powi(3)).abs() < 1e-11 * (1.0 + p.abs()),
            "{state:?}"
        );
        assert!(near(state.p[0], p - h * node), "{state:?}");
    }
}
