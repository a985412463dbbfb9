//! The sentences of plans on degenerate Lagrangians.

use sve_runtime::plan::DegenerateStep;
use sve_runtime::prelude::*;
use sve_runtime::{Plan, Variational};

use sve_models::degenerate::{
    CubicLotkaVolterra, Drift, InternalLotkaVolterra, Joint, Kubo, LotkaVolterra,
    MassWithAffinePair, MassWithPair, Spin, VortexPair, Vortices,
};

fn plan<S: Variational<R>, R>(_: S, _: R) -> &'static Plan {
    <R as sve_runtime::Rule<S::Itself>>::PLAN
}

#[test]
fn plans_say_what_is_preserved() {
    let (four, two) = ([1.0; 4], [1.0; 2]);
    let pair = VortexPair {
        strength: two,
        sigma: 0.1,
    };
    let vortices = Vortices { strength: four };
    let (joint, mass) = (Joint { k: 1.0 }, MassWithPair { mass: 1.0 });
    let cases = [
        (plan(LotkaVolterra, Midpoint), DegenerateStep::Internal),
        (
            plan(InternalLotkaVolterra, Endpoint),
            DegenerateStep::Internal,
        ),
        (plan(Kubo, Midpoint), DegenerateStep::Affine),
        (plan(Kubo, InitialPoint), DegenerateStep::Internal),
        (plan(vortices, Midpoint), DegenerateStep::Affine),
        (plan(vortices, Endpoint), DegenerateStep::Internal),
        (plan(pair, Midpoint), DegenerateStep::Affine),
        (plan(MassWithAffinePair, Midpoint), DegenerateStep::Affine),
        (plan(joint, Endpoint), DegenerateStep::Eliminated),
        (plan(joint, Midpoint), DegenerateStep::Eliminated),
        (
            plan(CubicLotkaVolterra, Midpoint),
            DegenerateStep::Projected,
        ),
        (plan(Spin, Midpoint), DegenerateStep::Projected),
        (plan(Drift, Midpoint), DegenerateStep::Projected),
        (plan(mass, Midpoint), DegenerateStep::Projected),
    ];
    for (plan, expected) in cases {
        println!("{plan}\n");
        assert_eq!(plan.degenerate, Some(expected), "{}", plan.system);
        assert!(plan.to_string().contains(&expected.to_string()));
    }
}
