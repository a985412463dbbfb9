//! Steps and multipliers computed elsewhere with 40-digit arithmetic, independently of this
//! project.

use sve_models::models::{OnSphere, TurnedSphere, TwoRods};
use sve_models::reference::{ReferenceRun, check};
use sve_runtime::__private::ConstraintImpulses;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

fn error<S, const N: usize, const M: usize>(run: &ReferenceRun, system: &S) -> f64
where
    S: System<Dims = Dims<N, M>>
        + Variational<InitialPoint>
        + Variational<Midpoint>
        + Variational<Endpoint>
        + ConstraintImpulses<InitialPoint>
        + ConstraintImpulses<Midpoint>
        + ConstraintImpulses<Endpoint>,
{
    match run.rule.as_str() {
        "initial_point" => run.error_with_multipliers(system, InitialPoint),
        "midpoint" => run.error_with_multipliers(system, Midpoint),
        "endpoint" => run.error_with_multipliers(system, Endpoint),
        other => panic!("unknown rule {other}"),
    }
}

#[test]
fn spherical_pendulum() {
    let system = |run: &ReferenceRun| OnSphere {
        g: run.number("g"),
        s: run.number("s"),
    };
    check("spherical_pendulum", 3, 1e-12, |run| {
        error(run, &system(run))
    });
}

#[test]
fn rotating_sphere() {
    let system = |run: &ReferenceRun| TurnedSphere { s: run.number("s") };
    check("rotating_sphere", 3, 1e-12, |run| error(run, &system(run)));
}

#[test]
fn double_pendulum() {
    let system = |run: &ReferenceRun| TwoRods {
        m: ["m1", "m2"].map(|name| run.number(name)),
        l: ["l1", "l2"].map(|name| run.number(name)),
        g: run.number("g"),
        s: run.number("s"),
    };
    check("double_pendulum_cartesian", 3, 1e-12, |run| {
        error(run, &system(run))
    });
}
