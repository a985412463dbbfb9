//! Steps computed elsewhere with 40-digit arithmetic from the discrete action, independently of
//! this project.

use sve_models::models::{DoublePendulum, Kubo, Oscillator, Pendulum};
use sve_models::reference::{ReferenceRun, check};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::verlet::DoubleWell;

fn error<S, const N: usize, const M: usize>(run: &ReferenceRun, system: S) -> f64
where
    S: System<Dims = Dims<N, M>>
        + Variational<InitialPoint>
        + Variational<Midpoint>
        + Variational<Endpoint>
        + Variational<StormerVerlet>,
{
    match run.rule.as_str() {
        "initial_point" => run.error(system, InitialPoint),
        "midpoint" => run.error(system, Midpoint),
        "endpoint" => run.error(system, Endpoint),
        "stormer_verlet" => run.error(system, StormerVerlet),
        other => panic!("unknown rule {other}"),
    }
}

#[test]
fn pendulum() {
    let system = |run: &ReferenceRun| Pendulum { g: run.number("g") };
    check("pendulum", 3, 1e-12, |run| error(run, system(run)));
}

#[test]
fn oscillator() {
    let system = |run: &ReferenceRun| Oscillator {
        sigma: run.number("sigma"),
    };
    check("oscillator", 3, 1e-12, |run| error(run, system(run)));
}

#[test]
fn kubo() {
    let system = |run: &ReferenceRun| Kubo {
        a: run.number("a"),
        sigma: run.number("sigma"),
    };
    check("kubo", 3, 1e-12, |run| error(run, system(run)));
    check("verlet_kubo", 1, 1e-12, |run| error(run, system(run)));
}

#[test]
fn double_well() {
    let system = |run: &ReferenceRun| DoubleWell { s: run.number("s") };
    check("verlet_double_well", 1, 1e-12, |run| {
        run.error(system(run), StormerVerlet)
    });
}

/// Chaotic: rounding errors grow along the run.
#[test]
fn double_pendulum() {
    let system = |run: &ReferenceRun| DoublePendulum {
        m: ["m1", "m2"].map(|name| run.number(name)),
        l: ["l1", "l2"].map(|name| run.number(name)),
        g: run.number("g"),
        s: run.number("s"),
    };
    for (file, runs) in [("double_pendulum", 3), ("verlet_double_pendulum", 1)] {
        check(file, runs, 1e-10, |run| error(run, system(run)));
    }
}
