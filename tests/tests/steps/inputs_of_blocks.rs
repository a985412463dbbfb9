//! Functions of a block with inputs besides its steps: momenta of symmetries, bodies, time.

use sve_runtime::nalgebra::{Rotation3, UnitQuaternion, Vector3};
use sve_runtime::prelude::*;

/// A symmetry whose generator reads a field, beside inputs.
struct Rails {
    slope: f64,
    mass: f64,
}

#[variational(midpoint)]
impl Rails {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2], u: f64) -> f64 {
        let m = self.mass;
        0.5 * m * (v[0] * v[0] + v[1] * v[1]) + u * (self.slope * q[0] - q[1]).powi(2)
    }
    #[symmetry]
    fn along(&self, _q: [f64; 2]) -> [f64; 2] {
        [1.0, self.slope]
    }
}

#[test]
fn momenta_of_systems_with_inputs_are_kept() {
    let rails = Integrator::new(
        Rails {
            slope: 0.7,
            mass: 1.5,
        },
        Midpoint,
    );
    let state = State::new([0.2, -0.4], [0.3, 0.1]);
    let before = rails.system().along_momentum(&state);
    let path = rails.trajectory(state, 0.1, NoNoise);
    let end = path.inputs(|k, _| (k as f64).sin()).nth(49);
    let end = end.unwrap().unwrap();
    assert!((rails.system().along_momentum(&end) - before).abs() < 1e-13);
    assert!((end.p[0] - state.p[0]).abs() > 0.1);
    // through the system that holds the inputs, too
    let held = rails.holding(&1.0);
    assert_eq!(held.system().along_momentum(&state), before);
}

/// A body whose torque depends on time and on an input.
struct Timed;

#[variational(midpoint)]
impl Timed {
    fn lagrangian(&self, t: f64, _r: Rotation3<f64>, w: Vector3<f64>, u: Vector3<f64>) -> f64 {
        0.5 * (1.0 + 0.1 * t) * w.dot(&w) + 0.0 * u.x
    }
    #[force]
    fn torque(
        &self,
        t: f64,
        _r: Rotation3<f64>,
        _w: Vector3<f64>,
        u: Vector3<f64>,
    ) -> Vector3<f64> {
        u * t
    }
}

#[test]
fn inputs_of_bodies_that_depend_on_time() {
    let mut state = State::at(1.0, UnitQuaternion::identity(), Vector3::zeros());
    Integrator::new(Timed, Midpoint)
        .step_with(&mut state, 0.1, &[], &Vector3::new(0.0, 0.0, 2.0))
        .unwrap();
    // h u t at the node, about a principal axis
    assert!((state.p.z - 0.1 * 2.0 * 1.05).abs() < 1e-14);
}
