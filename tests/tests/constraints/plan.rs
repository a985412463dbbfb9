//! The sentences of plans on constraints.

use sve_models::checks::assert_says;
use sve_models::models::{Breathing, Curved, OnSphere, TurnedSphere};
use sve_runtime::plan::BlockKind;
use sve_runtime::prelude::*;

use super::systems::{FiveRods, two_rods};

/// Kinds and sizes of the blocks that are not explicit.
fn blocks(plan: &sve_runtime::Plan) -> Vec<(BlockKind, usize)> {
    let implicit = plan.blocks.iter().filter(|b| b.kind != BlockKind::Explicit);
    implicit.map(|b| (b.kind, b.unknowns.len())).collect()
}

#[test]
fn newton_has_an_unknown_for_each_constraint_where_all_else_is_explicit() {
    let (rods, sphere) = (two_rods(), OnSphere { g: 1.0, s: 0.1 });
    let implicit = |unknowns, linear| [(BlockKind::Newton, unknowns), (BlockKind::Linear, linear)];
    for (plan, expected) in [
        (Integrator::new(&rods, StormerVerlet).plan(), implicit(2, 2)),
        (Integrator::new(&rods, InitialPoint).plan(), implicit(2, 2)),
        // the forces of the rods' midpoint rule are constant
        (Integrator::new(&rods, Midpoint).plan(), implicit(2, 2)),
        (
            Integrator::new(&sphere, StormerVerlet).plan(),
            implicit(1, 1),
        ),
        // a force at the middle of the step: the velocities that it depends on, and the multiplier
        (Integrator::new(&sphere, Midpoint).plan(), implicit(3, 1)),
    ] {
        assert_eq!(blocks(plan), expected, "{} by {}", plan.system, plan.rule);
    }
    let turned = Integrator::new(TurnedSphere { s: 0.1 }, Midpoint);
    assert!(blocks(turned.plan())[0].1 <= 7);
}

#[test]
fn a_chain_is_banded() {
    let chain = Integrator::new(FiveRods { g: 1.0, s: 0.1 }, StormerVerlet);
    let newton = &chain.plan().blocks[0];
    assert_eq!((newton.kind, newton.unknowns.len()), (BlockKind::Newton, 5));
    assert_eq!(newton.nonzeros, 13);
}

#[test]
fn the_plan_writes_the_constraints() {
    let sphere = Integrator::new(OnSphere { g: 1.0, s: 0.1 }, Midpoint);
    let parts = [
        "φ sphere = q[0]²/2 + q[1]²/2 + q[2]²/2 − 1/2 = 0",
        "+ λ·φ(q₀) + μ·φ(q₁)",
        "q[0] ∘ dΛ",
        "Newton's method for",
        "from a linear equation\n      μ = ",
    ];
    assert_says(sphere.plan(), &parts);
    let (g, s) = (1.0, 0.1);
    let breathing = Integrator::new(Breathing { g, d: 0.1, s }, Endpoint);
    assert_says(breathing.plan(), &["+ λ·φ(t₀, q₀) + μ·φ(t₁, q₁)"]);
    let rods = Integrator::new(two_rods(), Midpoint);
    assert_says(rods.plan(), &["+ ⟨λ, φ(q₀)⟩ + ⟨μ, φ(q₁)⟩"]);
    let curved = Integrator::new(Curved { g, s }, Midpoint);
    assert_says(curved.plan(), &["strong order 1"]);
}
