//! A kinetic energy whose mass vanishes at rest, `L = v⁴/4 − q²/2`. The Legendre transform `p = v³`
//! is inverted, and steps are made, if `p ≠ 0`.

use sve_models::stepper::Stepper;
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
    let is_near = |end: State<[f64; 1]>, q, p| {
        assert!(near(end.q[0], q) && near(end.p[0], p), "{end:?}");
    };
    for (q, p) in STARTS {
        let start = State::new([q], [p]);
        // p₀ = v³, q₁ = q₀ + h v, p₁ = p₀ − h q₁
        let end = q + h * p.cbrt();
        let found = Integrator::new(QuarticKinetic, Endpoint).after(start, h, &[], 1);
        is_near(found, end, p - h * end);
        // p₁ = p₀ − h q₀ = v³, q₁ = q₀ + h v
        let kicked = p - h * q;
        let found = Integrator::new(QuarticKinetic, InitialPoint).after(start, h, &[], 1);
        is_near(found, q + h * kicked.cbrt(), kicked);
        // (p₀ + p₁)/2 = v³, p₁ = p₀ − h q̄
        let found = Integrator::new(QuarticKinetic, Midpoint).after(start, h, &[], 1);
        let (v, node) = ((found.q[0] - q) / h, 0.5 * (found.q[0] + q));
        let defect = 0.5 * (found.p[0] + p) - v.powi(3);
        assert!(defect.abs() < 1e-11 * (1.0 + p.abs()), "{found:?}");
        assert!(near(found.p[0], p - h * node), "{found:?}");
    }
}
