//! Steps computed elsewhere with 40-digit arithmetic from the discrete action, independently of this project.

use serde::Deserialize;
use std::collections::HashMap;

use sve_runtime::prelude::*;
use sve_runtime::{Dims, Discretised, Increments, System, Variational};

use crate::systems::{DoublePendulum, Kubo, Pendulum};

#[derive(Deserialize)]
struct Run {
    rule: String,
    params: HashMap<String, f64>,
    h: f64,
    dw: Vec<Vec<f64>>,
    states: Vec<Vec<f64>>,
}

/// Largest error along the run, relative to the largest component.
fn error<S, R, const N: usize, const M: usize>(integrator: &Integrator<S, R>, run: &Run) -> f64
where
    S: Discretised<R> + System<Dims = Dims<N, M>>,
{
    let array = |z: &[f64]| -> [f64; N] { z.try_into().unwrap() };
    let (q, p) = run.states[0].split_at(N);
    let mut state = State::new(array(q), array(p));
    let mut worst: f64 = 0.0;
    for (dw, expected) in run.dw.iter().zip(&run.states[1..]) {
        let mut increments = S::Increments::NONE;
        increments.as_mut().copy_from_slice(dw);
        integrator.step(&mut state, run.h, &increments).unwrap();
        let size = expected.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        for (x, y) in state.q.iter().chain(&state.p).zip(expected) {
            worst = worst.max((x - y).abs() / size);
        }
    }
    assert!(run.dw.len() >= 10);
    worst
}

fn check<S, const N: usize, const M: usize>(
    file: &str,
    bound: f64,
    system: impl Fn(&HashMap<String, f64>) -> S,
) where
    S: System<Dims = Dims<N, M>>
        + Variational<Gauss<2>>
        + Variational<Gauss<3>>
        + Variational<Gauss<8>>,
{
    let path = format!("{}/data/{file}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let runs: Vec<Run> = serde_json::from_str(&text).expect("reference data");
    let mut compared = 0;
    for run in runs.iter().filter(|run| !run.rule.ends_with("stage_noise")) {
        let system = system(&run.params);
        let worst = match run.rule.as_str() {
            "gauss_2" => error(&Integrator::new(system, Gauss::<2>), run),
            "gauss_3" => error(&Integrator::new(system, Gauss::<3>), run),
            "gauss_8" => error(&Integrator::new(system, Gauss::<8>), run),
            other => panic!("unknown rule {other}"),
        };
        println!("{file} {}: {worst:e}", run.rule);
        assert!(worst < bound, "{file} {}: {worst:e} > {bound:e}", run.rule);
        compared += 1;
    }
    assert!(compared >= 2, "{compared} runs");
}

#[test]
fn pendulum() {
    check("gauss_pendulum", 1e-12, |p| Pendulum { g: p["g"] });
}

#[test]
fn kubo() {
    check("gauss_kubo", 1e-12, |p| Kubo {
        a: p["a"],
        sigma: p["sigma"],
    });
}

#[test]
fn double_pendulum() {
    check("gauss_double_pendulum", 1e-12, |p| DoublePendulum {
        m: [p["m1"], p["m2"]],
        l: [p["l1"], p["l2"]],
        g: p["g"],
        s: p["s"],
    });
}

/// The runs with an increment of each process for each stage.
fn check_stage_noise<S, const N: usize, const M: usize>(
    file: &str,
    system: impl Fn(&HashMap<String, f64>) -> S,
) where
    S: System<Dims = Dims<N, M>>
        + Discretised<StageNoise<Gauss<2>>>
        + Discretised<StageNoise<Gauss<3>>>
        + Discretised<StageNoise<Gauss<8>>>,
{
    let path = format!("{}/data/{file}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let runs: Vec<Run> = serde_json::from_str(&text).expect("reference data");
    let mut compared = 0;
    for run in runs.iter().filter(|run| run.rule.ends_with("stage_noise")) {
        let system = system(&run.params);
        let worst = match run.rule.as_str() {
            "gauss_2_stage_noise" => error(&Integrator::new(system, StageNoise(Gauss::<2>)), run),
            "gauss_3_stage_noise" => error(&Integrator::new(system, StageNoise(Gauss::<3>)), run),
            "gauss_8_stage_noise" => error(&Integrator::new(system, StageNoise(Gauss::<8>)), run),
            other => panic!("unknown rule {other}"),
        };
        assert!(worst < 1e-12, "{file} {}: {worst:e}", run.rule);
        compared += 1;
    }
    assert_eq!(compared, 3);
}

#[test]
fn kubo_with_stage_noise() {
    check_stage_noise("gauss_kubo", |p| Kubo {
        a: p["a"],
        sigma: p["sigma"],
    });
}

#[test]
fn double_pendulum_with_stage_noise() {
    check_stage_noise("gauss_double_pendulum", |p| DoublePendulum {
        m: [p["m1"], p["m2"]],
        l: [p["l1"], p["l2"]],
        g: p["g"],
        s: p["s"],
    });
}
