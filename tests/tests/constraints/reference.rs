//! Steps and multipliers computed elsewhere with 40-digit arithmetic, independently of this project.

use std::collections::HashMap;

use serde::Deserialize;
use sve_models::models::{OnSphere, TurnedSphere, TwoRods};
use sve_runtime::prelude::*;
use sve_runtime::{ConstraintImpulses, Dims, System, Variational};

#[derive(Deserialize)]
struct Path {
    rule: String,
    params: HashMap<String, f64>,
    h: f64,
    dw: Vec<Vec<f64>>,
    states: Vec<Vec<f64>>,
    lambda: Vec<Vec<f64>>,
    mu: Vec<Vec<f64>>,
}

/// Largest errors of the states and of the multipliers along a path, relative to the largest number of the state.
fn errors<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    path: &Path,
) -> [f64; 2]
where
    S: Variational<R> + ConstraintImpulses<R> + System<Dims = Dims<N, M>>,
{
    let start = &path.states[0];
    let part = |z: &[f64]| -> [f64; N] { z.try_into().unwrap() };
    let mut state = State::new(part(&start[..N]), part(&start[N..]));
    let [mut of_states, mut of_multipliers] = [0.0f64; 2];
    for (k, (dw, expected)) in path.dw.iter().zip(&path.states[1..]).enumerate() {
        let dw: [f64; M] = dw.as_slice().try_into().unwrap();
        let forces = integrator.constraint_forces(&state, path.h, &dw).unwrap();
        integrator.step(&mut state, path.h, &dw).unwrap();
        let size = expected.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        for (found, wanted) in state.q.iter().chain(&state.p).zip(expected) {
            of_states = of_states.max((found - wanted).abs() / size);
        }
        let multipliers = path.lambda[k].iter().zip(&path.mu[k]);
        for (force, (lambda, mu)) in forces.constraints.iter().zip(multipliers) {
            let error = (force.at_start - lambda)
                .abs()
                .max((force.at_end - mu).abs());
            of_multipliers = of_multipliers.max(error / size);
        }
    }
    [of_states, of_multipliers]
}

fn check<S, const N: usize, const M: usize>(file: &str, system: impl Fn(&HashMap<String, f64>) -> S)
where
    S: System<Dims = Dims<N, M>>
        + Variational<InitialPoint>
        + Variational<Midpoint>
        + Variational<Endpoint>
        + ConstraintImpulses<InitialPoint>
        + ConstraintImpulses<Midpoint>
        + ConstraintImpulses<Endpoint>,
{
    let at = format!("{}/data/{file}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&at).unwrap_or_else(|e| panic!("{at}: {e}"));
    let paths: Vec<Path> = serde_json::from_str(&text).expect("reference data");
    assert_eq!(paths.len(), 3, "three rules");
    for path in &paths {
        let system = system(&path.params);
        let errors = match path.rule.as_str() {
            "initial_point" => errors(&Integrator::new(system, InitialPoint), path),
            "midpoint" => errors(&Integrator::new(system, Midpoint), path),
            "endpoint" => errors(&Integrator::new(system, Endpoint), path),
            other => panic!("unknown rule {other}"),
        };
        println!("{file} {}: {errors:?}", path.rule);
        assert!(
            errors.iter().all(|&e| e < 1e-12),
            "{file} {}: {errors:?}",
            path.rule
        );
    }
}

#[test]
fn spherical_pendulum() {
    check("spherical_pendulum", |p| OnSphere {
        g: p["g"],
        s: p["s"],
    });
}

#[test]
fn rotating_sphere() {
    check("rotating_sphere", |p| TurnedSphere { s: p["s"] });
}

#[test]
fn double_pendulum() {
    check("double_pendulum_cartesian", |p| TwoRods {
        m: [p["m1"], p["m2"]],
        l: [p["l1"], p["l2"]],
        g: p["g"],
        s: p["s"],
    });
}
