//! A coupling or a friction that is small compared with the masses. The step is as accurate with the small number in the formulas as with a
//! parameter in its place. Elimination must not divide by the small number.

use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};

const SMALL: f64 = 1e-6;

/// Two masses with a weak coupling.
struct Written {
    m: [f64; 2],
}

#[variational(initial_point, endpoint, midpoint, taylor2)]
impl Written {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let kinetic = 0.5 * (self.m[0] * v[0] * v[0] + self.m[1] * v[1] * v[1]);
        kinetic + SMALL * v[0] * v[1] - 0.25 * q[0].powi(4) - q[1].cosh()
    }
}

struct Given {
    m: [f64; 2],
    small: f64,
}

#[variational(initial_point, endpoint, midpoint, taylor2)]
impl Given {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let kinetic = 0.5 * (self.m[0] * v[0] * v[0] + self.m[1] * v[1] * v[1]);
        kinetic + self.small * v[0] * v[1] - 0.25 * q[0].powi(4) - q[1].cosh()
    }
}

/// A weak magnetic field, and friction.
struct WrittenField {
    m: f64,
}

#[variational(taylor2)]
impl WrittenField {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let kinetic = 0.5 * self.m * (v[0] * v[0] + v[1] * v[1]);
        kinetic + SMALL * (q[0] * v[1] - q[1] * v[0]) - 0.25 * q[0].powi(4) - q[1].cosh()
    }

    #[force]
    fn friction(&self, _q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        [-SMALL * v[0], -SMALL * v[1]]
    }
}

struct GivenField {
    m: f64,
    small: f64,
}

#[variational(taylor2)]
impl GivenField {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let kinetic = 0.5 * self.m * (v[0] * v[0] + v[1] * v[1]);
        kinetic + self.small * (q[0] * v[1] - q[1] * v[0]) - 0.25 * q[0].powi(4) - q[1].cosh()
    }

    #[force]
    fn friction(&self, _q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        [-self.small * v[0], -self.small * v[1]]
    }
}

fn check<A, B, R: Copy>(written: &A, given: &B, rule: R)
where
    A: Variational<R> + System<Dims = Dims<2, 0>>,
    B: Variational<R> + System<Dims = Dims<2, 0>>,
{
    let start = State::new([0.7, 0.3], [0.5, -0.4]);
    for h in [0.1, 0.03, 1e-3] {
        let (mut a, mut b) = (start, start);
        let written = Integrator::new(written, rule);
        let given = Integrator::new(given, rule);
        if let Err(error) = written.step(&mut a, h, &[]) {
            panic!("h = {h}: {error}");
        }
        given.step(&mut b, h, &[]).unwrap();
        for i in 0..2 {
            let off = (a.q[i] - b.q[i]).abs().max((a.p[i] - b.p[i]).abs());
            assert!(off <= 8.0 * f64::EPSILON, "h = {h}: {a:?}, {b:?}");
        }
    }
}

#[test]
fn a_weak_coupling_of_masses() {
    let m = [1.3, 0.7];
    let (written, given) = (&Written { m }, &Given { m, small: SMALL });
    check(written, given, InitialPoint);
    check(written, given, Endpoint);
    check(written, given, Midpoint);
    check(written, given, Taylor2);
}

#[test]
fn a_weak_field_with_weak_friction() {
    let (m, small) = (1.3, SMALL);
    check(&WrittenField { m }, &GivenField { m, small }, Taylor2);
}
