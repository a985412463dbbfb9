//! Lengths far from 1 in the formulas, as in SI units. The macro evaluates expressions at random points near 1, where functions of such
//! lengths are constant to the last digit. The step must still equal the step of a system with a parameter in place of the length.

use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};

const WIDTH: f64 = 1e-6;

/// A particle in a trap and at a wall.
struct Written {
    m: f64,
    u: f64,
}

#[variational(initial_point, endpoint, midpoint, taylor2)]
impl Written {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let trap = (-(q[0] / WIDTH).powi(2)).exp();
        let wall = (q[1] / WIDTH).tanh() - (q[0] / WIDTH).exp().ln_1p();
        0.5 * self.m * (v[0] * v[0] + v[1] * v[1]) + self.u * (trap + wall)
    }
}

struct Given {
    m: f64,
    u: f64,
    width: f64,
}

#[variational(initial_point, endpoint, midpoint, taylor2)]
impl Given {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let trap = (-(q[0] / self.width).powi(2)).exp();
        let wall = (q[1] / self.width).tanh() - (q[0] / self.width).exp().ln_1p();
        0.5 * self.m * (v[0] * v[0] + v[1] * v[1]) + self.u * (trap + wall)
    }
}

fn check<R: Copy>(rule: R)
where
    Written: Variational<R> + System<Dims = Dims<2, 0>>,
    Given: Variational<R> + System<Dims = Dims<2, 0>>,
{
    let (m, u) = (1e-18, 1e-20);
    let written = Integrator::new(Written { m, u }, rule);
    let width = WIDTH;
    let given = Integrator::new(Given { m, u, width }, rule);
    let start = State::new([0.5e-6, -0.2e-6], [1e-19, 0.5e-19]);
    for h in [1e-7, 1e-6, 1e-5] {
        let (mut a, mut b) = (start, start);
        written.step(&mut a, h, &[]).unwrap();
        given.step(&mut b, h, &[]).unwrap();
        for i in 0..2 {
            let (dq, dp) = ((a.q[i] - b.q[i]).abs(), (a.p[i] - b.p[i]).abs());
            assert!(dq <= 1e-14 * WIDTH, "h = {h}: {a:?}, {b:?}");
            assert!(dp <= 1e-14 * 1e-19, "h = {h}: {a:?}, {b:?}");
        }
    }
}

#[test]
fn a_trap_and_a_wall_of_a_micrometre() {
    check(InitialPoint);
    check(Endpoint);
    check(Midpoint);
    check(Taylor2);
}
