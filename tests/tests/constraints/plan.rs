//! What the plan says of constraints.

use sve_models::models::{Breathing, Curved, OnSphere, TurnedSphere};
use sve_runtime::BlockKind;
use sve_runtime::prelude::*;

use super::systems::{FiveRods, two_rods};

/// Kinds and sizes of the blocks that are not explicit.
fn blocks(plan: &sve_runtime::Plan) -> Vec<(BlockKind, usize)> {
    let implicit = plan.blocks.iter().filter(|b| b.kind != BlockKind::Explicit);
    implicit.map(|b| (b.kind, b.unknowns.len())).collect()
}

#[test]
fn newton_has_an_unknown_for_each_constraint_where_all_else_is_explicit() {
    let rods = two_rods();
    let expected = [(BlockKind::Newton, 2), (BlockKind::Linear, 2)];
    assert_eq!(
        blocks(Integrator::new(&rods, StormerVerlet).plan()),
        expected
    );
    assert_eq!(
        blocks(Integrator::new(&rods, InitialPoint).plan()),
        expected
    );
    // the forces of the rods' midpoint rule are constant
    assert_eq!(blocks(Integrator::new(&rods, Midpoint).plan()), expected);
    let sphere = OnSphere { g: 1.0, s: 0.1 };
    let expected = [(BlockKind::Newton, 1), (BlockKind::Linear, 1)];
    assert_eq!(
        blocks(Integrator::new(&sphere, StormerVerlet).plan()),
        expected
    );
    // a force at the middle of the step: the velocities that it depends on, and the multiplier
    let expected = [(BlockKind::Newton, 3), (BlockKind::Linear, 1)];
    assert_eq!(blocks(Integrator::new(&sphere, Midpoint).plan()), expected);
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
    let text = Integrator::new(OnSphere { g: 1.0, s: 0.1 }, Midpoint)
        .plan()
        .to_string();
    for part in [
        "φ sphere = q[0]²/2 + q[1]²/2 + q[2]²/2 − 1/2 = 0",
        "+ λ·φ(q₀) + μ·φ(q₁)",
        "q[0] ∘ dΛ",
        "Newton's method for",
        "from a linear equation\n      μ = ",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let text = Integrator::new(
        Breathing {
            g: 1.0,
            d: 0.1,
            s: 0.1,
        },
        Endpoint,
    )
    .plan()
    .to_string();
    assert!(text.contains("+ λ·φ(t₀, q₀) + μ·φ(t₁, q₁)"), "{text}");
    let text = Integrator::new(&two_rods(), Midpoint).plan().to_string();
    assert!(text.contains("+ ⟨λ, φ(q₀)⟩ + ⟨μ, φ(q₁)⟩"), "{text}");
    let text = Integrator::new(Curved { g: 1.0, s: 0.1 }, Midpoint)
        .plan()
        .to_string();
    assert!(text.contains("strong order 1"), "{text}");
}
