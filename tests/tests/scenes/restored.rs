//! Bare steps that fail in the last of many sites, where the way back is not safe: with friction,
//! or with velocities that are solved for. The state is then copied, and restored bit for bit.

use sve_runtime::prelude::*;

use crate::common::spread;

struct Damped {
    nu: f64,
}

#[variational(initial_point, endpoint, stormer_verlet)]
impl Damped {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let sites = q.iter().zip(v);
        sites.map(|(q, v)| 0.5 * v * v - 0.25 * q.powi(4)).sum()
    }

    #[force]
    fn friction(&self, _q: &[f64], v: &[f64]) -> Vec<f64> {
        v.iter().map(|v| -self.nu * v).collect()
    }
}

struct Fast {
    c: f64,
}

#[variational(initial_point, endpoint, stormer_verlet)]
impl Fast {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let c2 = self.c * self.c;
        let sites = q.iter().zip(v);
        let kinetic = |v: f64| -c2 * (1.0 - v * v / c2).sqrt();
        sites.map(|(q, v)| kinetic(*v) - 0.25 * q.powi(4)).sum()
    }
}

fn check(step: impl FnOnce(&mut State<Vec<f64>>) -> Result<(), StepError>) {
    let n = 3000;
    let mut start = State::new(spread(n, 1), spread(n, 2));
    start.q[n - 1] = 1e120;
    let mut state = start.clone();
    let error = step(&mut state).expect_err("an overflow");
    assert!(error.to_string().contains("2999"), "{error}");
    for (x, y) in [(&state.q, &start.q), (&state.p, &start.p)] {
        assert!(x.iter().zip(y).all(|(x, y)| x.to_bits() == y.to_bits()));
    }
}

macro_rules! check_rules {
    ($system:expr) => {
        check(|state| Integrator::new($system, InitialPoint).step(state, 0.3, &[]));
        check(|state| Integrator::new($system, Endpoint).step(state, 0.3, &[]));
        check(|state| Integrator::new($system, StormerVerlet).step(state, 0.3, &[]));
    };
}

#[test]
fn states_of_scenes_with_friction_are_restored() {
    check_rules!(Damped { nu: 0.7 });
}

#[test]
fn states_of_scenes_with_other_kinetic_energies_are_restored() {
    check_rules!(Fast { c: 2.0 });
}
