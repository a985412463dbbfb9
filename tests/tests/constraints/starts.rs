//! Consistent starts, and what a step makes of others.

use sve_models::assert_matches;
use sve_models::checks::{assert_close, assert_says, assert_states_close, failure};
use sve_models::models::{OnSphere, Saddle, Torus};
use sve_models::stepper::Stepper;
use sve_runtime::prelude::*;

use super::systems::two_rods;

#[test]
fn a_projected_state_satisfies_the_constraints() {
    let system = two_rods();
    let integrator = Integrator::new(&system, Midpoint);
    let state = State::new([0.9, -0.5, 0.3, -1.2], [1.0, 0.5, -0.4, 0.1]);
    let state = integrator.consistent(state).unwrap();
    let rates = |q: &[f64; 4], p: &[f64; 4]| {
        let v = [p[0] / 1.0, p[1] / 1.0, p[2] / 0.5, p[3] / 0.5];
        let [x, y] = [q[2] - q[0], q[3] - q[1]];
        [
            q[0] * v[0] + q[1] * v[1],
            x * (v[2] - v[0]) + y * (v[3] - v[1]),
        ]
    };
    let phi = system.rods(state.q);
    let psi = rates(&state.q, &state.p);
    assert!(phi.iter().all(|x| x.abs() < 4e-16), "{phi:?}");
    assert!(psi.iter().all(|x| x.abs() < 1e-15), "{psi:?}");
    // a state on the constraints stays where it is
    let again = integrator.consistent(state).unwrap();
    assert_states_close(&again, &state, 1e-15, "two rods");
}

/// The displacement is orthogonal to the constraints in the metric of the masses: along M⁻¹Dφᵀ.
#[test]
fn the_projection_is_orthogonal_in_the_metric_of_the_masses() {
    let system = Saddle { c: 0.3, s: 0.4 };
    let integrator = Integrator::new(&system, Midpoint);
    let on = integrator
        .consistent(State::new([0.5, -0.3, 0.1], [0.3, 0.9, 0.2]))
        .unwrap();
    let [x, y, _] = on.q;
    let slope = [-y * x.cos(), -x.sin(), 1.0];
    let mass = [
        [1.5 + y.sin(), 0.3 * (x + y).cos(), 0.0],
        [0.3 * (x + y).cos(), 1.0 + x * x, 0.0],
        [0.0, 0.0, 1.0],
    ];
    let step = 1e-5;
    let direction =
        Matrix3::from_fn(|i, j| mass[i][j]).try_inverse().unwrap() * Vector3::from(slope);
    let off: [f64; 3] = core::array::from_fn(|i| on.q[i] + step * direction[i]);
    let back = integrator.consistent(State::new(off, on.p)).unwrap();
    // first order in the displacement
    assert_close(&back.q, &on.q, 1e-9, "saddle");
}

#[test]
fn an_inconsistent_configuration_is_refused_with_its_value() {
    let integrator = Integrator::new(OnSphere { g: 1.0, s: 0.1 }, StormerVerlet);
    let start = State::new([0.6, 0.0, -0.8 + 1e-6], [0.0, 1.0, 0.0]);
    let error = failure(&integrator, &start, 0.01, &[0.0, 0.0]);
    let StepError::InconsistentStart {
        constraint,
        value,
        magnitude,
        ..
    } = &error
    else {
        panic!("{error}");
    };
    assert_eq!(&**constraint, "sphere");
    assert!((value + 8e-7).abs() < 1e-12 && (magnitude - 2.0).abs() < 1e-5);
    assert_says(error, &["integrator.consistent(state)"]);
    // rounding errors are not refused
    let start = State::new([0.6, 0.0, -0.8 + 1e-10], [0.0, 1.0, 0.0]);
    let end = integrator.after(start, 0.01, &[0.0, 0.0], 1);
    let phi = integrator.system().sphere(end.q);
    assert!(phi.abs() < 4e-16, "{phi:e}");
}

#[test]
fn a_momentum_across_the_constraints_has_no_effect() {
    let integrator = Integrator::new(OnSphere { g: 1.0, s: 0.5 }, Midpoint);
    let q = [0.6, 0.0, -0.8];
    let p = [0.288, 0.9, 0.216];
    let across = core::array::from_fn(|i| p[i] + 3.0 * q[i]);
    let [state, other] =
        [p, across].map(|p| integrator.after(State::new(q, p), 0.05, &[0.1, -0.2], 1));
    assert_close(&state.q, &other.q, 1e-15, "sphere");
    assert_close(&state.p, &other.p, 1e-14, "sphere");
}

#[test]
fn where_no_configuration_is_near_there_is_an_error() {
    // a tube of imaginary radius
    let torus = Torus {
        g: 1.0,
        a: 2.0,
        b: 0.7,
        s: 0.5,
    };
    let integrator = Integrator::new(torus, Midpoint);
    let origin = State::new(Vector3::new(0.0, 0.0, 0.0), Vector3::zeros());
    assert!(integrator.consistent(origin).is_err());
    let not_a_number = State::new(Vector3::new(f64::NAN, 0.0, 0.0), Vector3::zeros());
    let refused = integrator.consistent(not_a_number);
    assert_matches!(refused, Err(StepError::NonFiniteInput { .. }));
}

/// Without constraints a state is returned as it is.
#[test]
fn a_system_without_constraints_has_consistent_states() {
    let pendulum = Integrator::new(sve_models::models::Pendulum { g: 1.0 }, Midpoint);
    let state = State::new([0.3], [0.1]);
    assert_eq!(pendulum.consistent(state).unwrap(), state);
}
