//! Steps computed elsewhere with 40-digit arithmetic, independently of this project.

use sve_models::degenerate::{InternalLotkaVolterra, Kubo, LotkaVolterra, Spin};
use sve_models::reference::{ReferenceRun, check};
use sve_runtime::Rule;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

/// The error along a run from the rest state of its first configuration.
fn error<S, R>(run: &ReferenceRun, system: S, rule: R) -> f64
where
    S: System<Dims = Dims<2, 1>>,
    R: Rule<S::Itself>,
{
    let [x, y, ..] = *run.first() else {
        panic!("no configuration");
    };
    let start = State::from_configuration(&system, [x, y]).unwrap();
    run.error_from(system, rule, start)
}

#[test]
fn steps_of_lotka_volterra() {
    check("lotka_volterra", 4, 1e-12, |run| match run.rule.as_str() {
        "midpoint" => error(run, LotkaVolterra, Midpoint),
        "midpoint_dvi" => error(run, InternalLotkaVolterra, Midpoint),
        "initial_point" => error(run, InternalLotkaVolterra, InitialPoint),
        "endpoint" => error(run, InternalLotkaVolterra, Endpoint),
        other => panic!("unknown rule {other}"),
    });
}

#[test]
fn steps_of_a_spin() {
    check("spin", 1, 1e-12, |run| error(run, Spin, Midpoint));
}

#[test]
fn steps_of_a_rotation() {
    check("kubo_degenerate", 3, 1e-12, |run| match run.rule.as_str() {
        "initial_point" => error(run, Kubo, InitialPoint),
        "midpoint" => error(run, Kubo, Midpoint),
        "endpoint" => error(run, Kubo, Endpoint),
        other => panic!("unknown rule {other}"),
    });
}
