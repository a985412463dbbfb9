//! States of degenerate systems: starts, energies, velocities, and what is an error.

use sve_models::degenerate::{Joint, Kubo, LotkaVolterra, MassWithPair, Spin, VortexPair};
use sve_runtime::prelude::*;

/// Checks that a result is an error of a kind, and returns its message.
macro_rules! error {
    ($result:expr, $pattern:pat) => {{
        let error = $result.unwrap_err();
        assert!(matches!(error, $pattern), "{error:?}");
        error.to_string()
    }};
}

#[test]
fn a_configuration_is_a_state() {
    let state = State::from_configuration(&LotkaVolterra, [2.0, 0.5]).unwrap();
    assert_eq!(state.p, [0.5 + 0.5f64.ln() / 2.0, 2.0]);
    assert_eq!((state.t, state.q), (0.0, [2.0, 0.5]));
    // a massive coordinate is at rest: p = ∂L/∂v(q, 0)
    let state = State::from_configuration(&MassWithPair { mass: 2.0 }, [0.5, 0.3, 0.4]).unwrap();
    assert_eq!(state.p[0], 0.3 * 0.3);
    assert!((state.p[1] + 1.05 * 0.4 / 1.25).abs() < 1e-16);
    // an algebraic coordinate is solved for: k (x − y) = y + y³
    let state = State::from_configuration(&Joint { k: 3.0 }, [2.0, 0.0]).unwrap();
    let [x, y] = state.q;
    assert_eq!((x, state.p), (2.0, [0.0; 2]));
    assert!((3.0 * (x - y) - y - y.powi(3)).abs() < 1e-15, "{y}");
    // L is not defined there
    error!(
        State::from_configuration(&LotkaVolterra, [-1.0, 0.5]),
        StepError::NonFiniteResult { .. }
    );
}

#[test]
fn energies_and_velocities_follow_from_the_two_form() {
    let state = State::from_configuration(&LotkaVolterra, [2.0, 0.5]).unwrap();
    let energy = 2.5 - 2.0f64.ln() - 2.0 * 0.5f64.ln();
    assert!((LotkaVolterra.hamiltonian(&state).unwrap() - energy).abs() < 1e-15);
    // x' = x (y − 2), y' = y (1 − x) up to the sign of time
    let [vx, vy] = LotkaVolterra.velocity(&state).unwrap();
    assert!((vx - 2.0 * (0.5 - 2.0)).abs() < 1e-14, "{vx}");
    assert!((vy - 0.5 * (1.0 - 2.0)).abs() < 1e-14, "{vy}");
    // the drift is tangent to p = α(q)
    let drift = LotkaVolterra.drift(&state).unwrap();
    assert_eq!(drift.q, [vx, vy]);
    let along = vy + vy / (0.5 * 2.0) - vx * 0.5f64.ln() / 4.0;
    assert!((drift.p[0] - along).abs() < 1e-14 && (drift.p[1] - vx).abs() < 1e-14);
    error!(
        LotkaVolterra.acceleration(&state),
        StepError::Degenerate { .. }
    );
    error!(
        LotkaVolterra.temperature(&state),
        StepError::Degenerate { .. }
    );
}

/// Velocities of systems with massive, massless and algebraic coordinates, against a short step.
#[test]
fn velocities_are_those_of_short_steps() {
    let h = 1e-4;
    let system = MassWithPair { mass: 1.5 };
    let mut state = State::from_configuration(&system, [0.5, 0.3, -0.4]).unwrap();
    state.p[0] += 0.8;
    let energy = system.hamiltonian(&state).unwrap();
    let middle = Integrator::new(system, Midpoint);
    let mut ends = [state, state];
    for (end, h) in ends.iter_mut().zip([h, -h]) {
        middle.step(end, h, &[0.0; 2]).unwrap();
        assert!((system.hamiltonian(end).unwrap() - energy).abs() < 1e-12);
    }
    let velocity = system.velocity(&state).unwrap();
    let drift = system.drift(&state).unwrap();
    for i in 0..3 {
        let difference = (ends[0].q[i] - ends[1].q[i]) / (2.0 * h);
        assert!((difference - velocity[i]).abs() < 1e-7, "{i}");
        let difference = (ends[0].p[i] - ends[1].p[i]) / (2.0 * h);
        assert!((difference - drift.p[i]).abs() < 1e-7, "{i}");
    }
    let joint = Joint { k: 3.0 };
    let mut state = State::from_configuration(&joint, [2.0, 0.0]).unwrap();
    state.p[0] = 0.7;
    let mut ends = [state, state];
    for (end, h) in ends.iter_mut().zip([h, -h]) {
        Integrator::new(joint, Midpoint)
            .step(end, h, &[0.0; 2])
            .unwrap();
    }
    let velocity = joint.velocity(&state).unwrap();
    assert_eq!(velocity[0], 0.7);
    for i in 0..2 {
        let difference = (ends[0].q[i] - ends[1].q[i]) / (2.0 * h);
        assert!((difference - velocity[i]).abs() < 1e-7, "{i}");
    }
}

#[test]
fn momenta_that_are_not_those_of_the_configuration_are_errors() {
    let system = LotkaVolterra;
    let integrator = Integrator::new(system, Midpoint);
    let good = State::from_configuration(&system, [2.0, 0.5]).unwrap();
    for (off, is_error) in [(1e-10, false), (1e-7, true), (1.0, true)] {
        for i in 0..2 {
            let mut state = good;
            state.p[i] += off;
            let before = state;
            let result = integrator.step(&mut state, 0.1, &[0.0]);
            assert_eq!(result.is_err(), is_error, "{off} {i} {result:?}");
            if is_error {
                let message = error!(result, StepError::Inconsistent { .. });
                assert!(
                    message.contains(&format!("p[{i}] is {}", before.p[i])),
                    "{message}"
                );
                assert!(message.contains("State::from_configuration"), "{message}");
                assert_eq!(state, before);
                error!(system.hamiltonian(&state), StepError::Inconsistent { .. });
                error!(system.velocity(&state), StepError::Inconsistent { .. });
                error!(system.drift(&state), StepError::Inconsistent { .. });
            }
        }
    }
    // an algebraic coordinate that does not solve its equation
    let joint = Integrator::new(Joint { k: 3.0 }, Endpoint);
    let mut state = State::new([2.0, 1.0], [0.0, 0.0]);
    let message = error!(
        joint.step(&mut state, 0.1, &[0.0; 2]),
        StepError::Inconsistent { .. }
    );
    assert!(message.contains("∂L/∂q[1]"), "{message}");
}

#[test]
fn a_singular_two_form_is_an_error_with_its_numbers() {
    // two vortices of which one has no strength
    let pair = VortexPair {
        strength: [1.0, 0.0],
        sigma: 0.0,
    };
    let mut state = State::from_configuration(&pair, [[1.0, 0.0], [0.0, 0.0]]).unwrap();
    let before = state;
    let integrator = Integrator::new(pair, Midpoint);
    let error = integrator.step(&mut state, 0.1, &[0.0]).unwrap_err();
    let StepError::SingularForm {
        t,
        h,
        q,
        determinant,
    } = &error
    else {
        panic!("{error:?}");
    };
    assert_eq!(
        (*t, *h, q.as_slice(), *determinant),
        (0.0, 0.1, &[1.0, 0.0, 0.0, 0.0][..], 0.0)
    );
    assert_eq!(state, before);
    assert!(error.to_string().contains("Dαᵀ − Dα"), "{error}");
    error!(pair.velocity(&state), StepError::SingularForm { .. });
}

#[test]
fn steps_out_of_the_domain_are_errors() {
    let integrator = Integrator::new(LotkaVolterra, Midpoint);
    let mut state = State::from_configuration(&LotkaVolterra, [2.0, 0.01]).unwrap();
    let before = state;
    let result = integrator.step(&mut state, 30.0, &[0.0]);
    println!("{result:?}");
    assert!(result.is_err());
    assert_eq!(state, before);
    // inputs that are not finite are named
    let mut state = State::new([f64::NAN, 1.0], [0.0; 2]);
    error!(
        Integrator::new(Kubo, Midpoint).step(&mut state, 0.1, &[0.0]),
        StepError::NonFiniteInput { .. }
    );
    let mut state = State::from_configuration(&Spin, [0.1, 0.2]).unwrap();
    error!(
        Integrator::new(Spin, Midpoint).step(&mut state, 0.1, &[f64::INFINITY]),
        StepError::NonFiniteInput { .. }
    );
}
