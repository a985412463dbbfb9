//! Steps computed elsewhere with 40-digit arithmetic from the discrete action, independently of this project.

use serde::Deserialize;
use std::collections::HashMap;
use sve_models::models::{DoublePendulum, Kubo, Oscillator, Pendulum};
use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};

#[derive(Deserialize)]
struct ReferencePath {
    rule: String,
    params: HashMap<String, f64>,
    h: f64,
    dw: Vec<Vec<f64>>,
    states: Vec<Vec<f64>>,
}

fn runs(file: &str) -> Vec<ReferencePath> {
    let path = format!("{}/data/{file}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    serde_json::from_str(&text).expect("reference data")
}

/// Largest error along the run, relative to the largest component.
fn error<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    run: &ReferencePath,
) -> f64
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let unpack = |z: &[f64]| -> ([f64; N], [f64; N]) {
        (z[..N].try_into().unwrap(), z[N..].try_into().unwrap())
    };
    let (q, p) = unpack(&run.states[0]);
    let mut state = State::new(q, p);
    let mut worst: f64 = 0.0;
    for (dw, expected) in run.dw.iter().zip(&run.states[1..]) {
        integrator
            .step(&mut state, run.h, dw.as_slice().try_into().unwrap())
            .unwrap();
        let size = expected.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let (q, p) = unpack(expected);
        for i in 0..N {
            worst = worst.max((state.q[i] - q[i]).abs() / size);
            worst = worst.max((state.p[i] - p[i]).abs() / size);
        }
    }
    assert_eq!(run.dw.len() + 1, run.states.len());
    worst
}

fn check<S, const N: usize, const M: usize>(
    file: &str,
    bound: f64,
    system: impl Fn(&HashMap<String, f64>) -> S,
) where
    S: System<Dims = Dims<N, M>>
        + Variational<InitialPoint>
        + Variational<Midpoint>
        + Variational<Endpoint>,
{
    let runs = runs(file);
    assert_eq!(runs.len(), 3, "three rules");
    for run in &runs {
        let system = system(&run.params);
        let worst = match run.rule.as_str() {
            "initial_point" => error(&Integrator::new(system, InitialPoint), run),
            "midpoint" => error(&Integrator::new(system, Midpoint), run),
            "endpoint" => error(&Integrator::new(system, Endpoint), run),
            other => panic!("unknown rule {other}"),
        };
        println!("{file} {}: {worst:e}", run.rule);
        assert!(worst < bound, "{file} {}: {worst:e} > {bound:e}", run.rule);
    }
}

#[test]
fn pendulum() {
    check("pendulum", 1e-12, |p| Pendulum { g: p["g"] });
}

#[test]
fn oscillator() {
    check("oscillator", 1e-12, |p| Oscillator { sigma: p["sigma"] });
}

#[test]
fn kubo() {
    check("kubo", 1e-12, |p| Kubo {
        a: p["a"],
        sigma: p["sigma"],
    });
}

#[test]
fn double_pendulum() {
    // chaotic: rounding errors grow along the run
    check("double_pendulum", 1e-10, |p| DoublePendulum {
        m: [p["m1"], p["m2"]],
        l: [p["l1"], p["l2"]],
        g: p["g"],
        s: p["s"],
    });
}
