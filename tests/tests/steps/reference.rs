//! Steps computed elsewhere with 40-digit arithmetic from the discrete action, independently of this project.

use std::collections::HashMap;

use sve_models::models::{DoublePendulum, Kubo, Oscillator, Pendulum};
use sve_models::reference::ReferenceRun;
use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};

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
    let runs = ReferenceRun::read(file);
    assert_eq!(runs.len(), 3, "three rules");
    for run in &runs {
        let system = system(&run.params);
        let worst = match run.rule.as_str() {
            "initial_point" => run.error(&Integrator::new(system, InitialPoint)),
            "midpoint" => run.error(&Integrator::new(system, Midpoint)),
            "endpoint" => run.error(&Integrator::new(system, Endpoint)),
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
