//! The motion without noise that `Mechanics::drift` tells, with the forces of constraints.

use sve_models::assert_matches;
use sve_models::checks::assert_relative;
use sve_models::models::OnSphere;
use sve_models::orders::numbers;
use sve_models::stepper::Stepper;
use sve_runtime::__private::{ConstraintImpulses, VectorCoordinates};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use super::systems::{Check, all, thermal};

/// Compares the drift with a difference of steps without noise.
struct Compared;

impl Check for Compared {
    fn run<S, R, Q, const N: usize, const M: usize>(
        &mut self,
        name: &str,
        integrator: &Integrator<S, R>,
        start: State<Q>,
    ) where
        S: Variational<R> + ConstraintImpulses<R> + System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        // one-sided rules too: a step back with the same rule is that of the other one
        let h = 2e-5;
        let moved = |h| numbers(&integrator.after(start, h, &[0.0; M], 1));
        let (forth, back) = (moved(h), moved(-h));
        let drift = integrator.system().drift(&start).unwrap();
        let drift = [Q::components(&drift.q), Q::components(&drift.p)].concat();
        let pairs = forth.iter().zip(&back);
        let differences: Vec<f64> = pairs.map(|(a, b)| (a - b) / (2.0 * h)).collect();
        assert_relative(&differences, &drift, 1e-7, name);
    }
}

/// Forces, friction, constraints that move, masses that depend on q.
#[test]
fn the_drift_is_the_rate_of_small_steps() {
    all(&mut Compared);
}

#[test]
fn the_force_of_a_rod_is_the_centripetal_one() {
    let (g, speed) = (9.8, 2.0);
    let sphere = OnSphere { g, s: 0.3 };
    let hanging = State::new([0.0, 0.0, -1.0], [speed, 0.0, 0.0]);
    let drift = sphere.drift(&hanging).unwrap();
    assert_eq!(drift.q, [speed, 0.0, 0.0]);
    assert_eq!(drift.p, [0.0, 0.0, speed * speed]);
    // a momentum across the constraint has no effect, as in a step
    let pulled = State::new([0.0, 0.0, -1.0], [speed, 0.0, 3.0]);
    assert_eq!(sphere.drift(&pulled).unwrap(), drift);
}

#[test]
fn states_beside_the_constraints_have_no_drift() {
    let thermal = thermal(0.5, 1.0);
    let beside = State::new(Vector3::new(0.0, 0.0, 1.01), Vector3::zeros());
    let error = thermal.drift(&beside).unwrap_err();
    assert_matches!(error, StepError::InconsistentStart { constraint, .. } if &**constraint == "sphere");
    let nan = State::new(Vector3::new(0.0, 0.0, f64::NAN), Vector3::zeros());
    assert!(thermal.drift(&nan).is_err());
}
