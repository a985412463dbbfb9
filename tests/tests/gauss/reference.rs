//! Steps computed elsewhere with 40-digit arithmetic from the discrete action, independently of this project.

use std::collections::HashMap;

use sve_models::reference::ReferenceRun;
use sve_runtime::prelude::*;
use sve_runtime::{Dims, Rule, System, Variational};

use crate::systems::{DoublePendulum, Kubo, Pendulum};

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
    let runs = ReferenceRun::read(file);
    let mut compared = 0;
    for run in runs.iter().filter(|run| !run.rule.ends_with("stage_noise")) {
        let system = system(&run.params);
        let worst = match run.rule.as_str() {
            "gauss_2" => run.error(&Integrator::new(system, Gauss::<2>)),
            "gauss_3" => run.error(&Integrator::new(system, Gauss::<3>)),
            "gauss_8" => run.error(&Integrator::new(system, Gauss::<8>)),
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
    S: System<Dims = Dims<N, M>>,
    StageNoise<Gauss<2>>: Rule<S::Itself>,
    StageNoise<Gauss<3>>: Rule<S::Itself>,
    StageNoise<Gauss<8>>: Rule<S::Itself>,
{
    let runs = ReferenceRun::read(file);
    let mut compared = 0;
    for run in runs.iter().filter(|run| run.rule.ends_with("stage_noise")) {
        let system = system(&run.params);
        let worst = match run.rule.as_str() {
            "gauss_2_stage_noise" => run.error(&Integrator::new(system, StageNoise(Gauss::<2>))),
            "gauss_3_stage_noise" => run.error(&Integrator::new(system, StageNoise(Gauss::<3>))),
            "gauss_8_stage_noise" => run.error(&Integrator::new(system, StageNoise(Gauss::<8>))),
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
