//! Steps computed elsewhere with 40-digit arithmetic from the discrete action, independently of
//! this project.

use sve_models::reference::{ReferenceRun, check};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{Rule, Variational};

use crate::systems::{DoublePendulum, Kubo, Pendulum};

fn error<S, const N: usize, const M: usize>(run: &ReferenceRun, system: S) -> f64
where
    S: System<Dims = Dims<N, M>>
        + Variational<Gauss<2>>
        + Variational<Gauss<3>>
        + Variational<Gauss<8>>,
{
    match run.rule.as_str() {
        "gauss_2" => run.error(system, Gauss::<2>),
        "gauss_3" => run.error(system, Gauss::<3>),
        "gauss_8" => run.error(system, Gauss::<8>),
        other => panic!("unknown rule {other}"),
    }
}

/// Some runs have an increment of each process for each stage.
fn error_with_noise<S, const N: usize, const M: usize>(run: &ReferenceRun, system: S) -> f64
where
    S: System<Dims = Dims<N, M>>
        + Variational<Gauss<2>>
        + Variational<Gauss<3>>
        + Variational<Gauss<8>>,
    StageNoise<Gauss<2>>: Rule<S::Itself>,
    StageNoise<Gauss<3>>: Rule<S::Itself>,
    StageNoise<Gauss<8>>: Rule<S::Itself>,
{
    match run.rule.as_str() {
        "gauss_2_stage_noise" => run.error(system, StageNoise(Gauss::<2>)),
        "gauss_3_stage_noise" => run.error(system, StageNoise(Gauss::<3>)),
        "gauss_8_stage_noise" => run.error(system, StageNoise(Gauss::<8>)),
        _ => error(run, system),
    }
}

#[test]
fn pendulum() {
    let system = |run: &ReferenceRun| Pendulum { g: run.number("g") };
    check("gauss_pendulum", 3, 1e-12, |run| error(run, system(run)));
}

#[test]
fn kubo() {
    let system = |run: &ReferenceRun| Kubo {
        a: run.number("a"),
        sigma: run.number("sigma"),
    };
    check("gauss_kubo", 6, 1e-12, |run| {
        error_with_noise(run, system(run))
    });
}

#[test]
fn double_pendulum() {
    let system = |run: &ReferenceRun| DoublePendulum {
        m: ["m1", "m2"].map(|name| run.number(name)),
        l: ["l1", "l2"].map(|name| run.number(name)),
        g: run.number("g"),
        s: run.number("s"),
    };
    check("gauss_double_pendulum", 6, 1e-12, |run| {
        error_with_noise(run, system(run))
    });
}
