//! Steps computed elsewhere with 40-digit arithmetic, independently of this project.

use serde::Deserialize;
use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};

use sve_models::degenerate::{InternalLotkaVolterra, Kubo, LotkaVolterra, Spin};

#[derive(Deserialize)]
struct ReferencePath {
    rule: String,
    h: f64,
    dw: Vec<[f64; 1]>,
    states: Vec<[f64; 4]>,
}

fn path(file: &str, rule: &str) -> ReferencePath {
    let path = format!("{}/data/{file}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let all: Vec<ReferencePath> = serde_json::from_str(&text).expect("reference data");
    let mut all = all.into_iter();
    all.find(|run| run.rule == rule)
        .unwrap_or_else(|| panic!("{file}: {rule}"))
}

/// Largest error of the states along a run, relative to the largest of their components: of the configuration, and of p.
fn errors<S, R>(system: S, rule: R, run: &ReferencePath) -> [f64; 2]
where
    S: Variational<R> + System<Dims = Dims<2, 1>>,
{
    let integrator = Integrator::new(system, rule);
    let [x, y, ..] = run.states[0];
    let mut state = State::from_configuration(integrator.system(), [x, y]).unwrap();
    let mut worst = [0.0f64; 2];
    for (dw, expected) in run.dw.iter().zip(&run.states[1..]) {
        integrator.step(&mut state, run.h, dw).unwrap();
        let size = expected.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        for i in 0..2 {
            worst[0] = worst[0].max((state.q[i] - expected[i]).abs() / size);
            worst[1] = worst[1].max((state.p[i] - expected[2 + i]).abs() / size);
        }
    }
    assert!(run.dw.len() > 3 && run.dw.len() + 1 == run.states.len());
    worst
}

fn check<S, R>(file: &str, name: &str, system: S, rule: R)
where
    S: Variational<R> + System<Dims = Dims<2, 1>>,
{
    let [q, p] = errors(system, rule, &path(file, name));
    println!("{file} {name}: {q:.1e} {p:.1e}");
    assert!(q < 1e-12 && p < 1e-12, "{file} {name}: {q:e} {p:e}");
}

#[test]
fn steps_of_lotka_volterra() {
    check("lotka_volterra", "midpoint", LotkaVolterra, Midpoint);
    let rule = "midpoint_dvi";
    check("lotka_volterra", rule, InternalLotkaVolterra, Midpoint);
    let rule = "initial_point";
    check("lotka_volterra", rule, InternalLotkaVolterra, InitialPoint);
    let rule = "endpoint";
    check("lotka_volterra", rule, InternalLotkaVolterra, Endpoint);
}

#[test]
fn steps_of_a_spin() {
    check("spin", "midpoint", Spin, Midpoint);
}

#[test]
fn steps_of_a_rotation() {
    check("kubo_degenerate", "initial_point", Kubo, InitialPoint);
    check("kubo_degenerate", "midpoint", Kubo, Midpoint);
    check("kubo_degenerate", "endpoint", Kubo, Endpoint);
}
