//! The plans of derived steps: kinds of blocks, numbers of unknowns, orders.

use sve_models::case::Case;
use sve_models::oracle::{
    Nodes, cases, charges, damped, kubo, oscillator, planar_double_pendulum, rails, stretched,
};
use sve_runtime::Plan;
use sve_runtime::plan::{BlockKind, StrongOrder};
use sve_runtime::prelude::*;

use crate::plan_table;

/// Systems with L = T(v) − V(q), T quadratic with a constant mass, and no H₁.
const SEPARABLE: &[&str] = &[
    "Pendulum",
    "HenonHeiles",
    "Quartic",
    "Oscillator",
    "Synchrotron",
    "Chain",
    "Central",
];

/// Systems with quadratic L and H₁, and γ at most quadratic.
const QUADRATIC: &[&str] = &["Oscillator", "Kubo"];

fn check_plan(case: &dyn Case) {
    let plan = case.plan();
    assert_eq!(plan.rule, case.rule());
    assert_eq!((plan.degrees_of_freedom, plan.noises), case.dimensions());
    let order = match case.nodes() {
        Nodes::One(0.5) | Nodes::Ends | Nodes::Predicted => 2,
        Nodes::One(_) => 1,
    };
    assert_eq!(plan.deterministic_order, order, "{plan}");
    let strong = match plan.strong_order {
        StrongOrder::Deterministic => {
            assert_eq!(plan.noises, 0);
            String::new()
        }
        StrongOrder::One => "strong 1".to_owned(),
        StrongOrder::Half { pair: (a, b) } => format!("strong 1/2: {a}, {b}"),
        other => panic!("{other:?}"),
    };
    let [strong_order, expected] = plan_table::plan(plan.system, plan.rule)
        .unwrap_or_else(|| panic!("not in the table:\n{plan}"));
    assert_eq!(strong, strong_order, "{plan}");
    let found = format!("{} {}", plan.kind(), plan.unknowns());
    assert_eq!(found, expected, "{plan}");
    let is_chain = matches!(plan.system, "Rails" | "Chain");
    for block in plan.blocks {
        let expected = (is_chain && block.unknowns.len() > 1).then_some((1, 1));
        assert_eq!(block.band, expected, "{plan}");
    }

    if SEPARABLE.contains(&plan.system)
        && matches!(case.nodes(), Nodes::One(0.0 | 1.0) | Nodes::Ends)
    {
        assert_eq!(plan.kind(), BlockKind::Explicit, "{plan}");
    }
    if QUADRATIC.contains(&plan.system) && case.nodes() == Nodes::One(0.5) {
        assert_eq!(plan.kind(), BlockKind::Linear, "{plan}");
    }
    for block in plan.blocks {
        let k = block.unknowns.len();
        assert!((k..=k * k).contains(&block.nonzeros), "{plan}");
        if block.kind == BlockKind::Explicit {
            assert_eq!(k, 1, "{plan}");
        }
    }
    // work in an iteration where there is one, and nowhere else
    let iterates = plan.iteration.arithmetic + plan.iteration.transcendental > 0;
    assert_eq!(iterates, plan.kind() == BlockKind::Newton, "{plan}");
    // the text names everything
    let text = plan.to_string();
    for block in plan.blocks {
        assert!(text.contains(&block.unknowns.join(", ")), "{text}");
    }
}

#[test]
fn every_plan_is_in_the_table() {
    let cases = cases();
    for case in &cases {
        check_plan(&**case);
    }
    assert_eq!(cases.len(), plan_table::count());
}

#[test]
fn kubo_by_midpoint() {
    let plan = Integrator::new(kubo(), Midpoint).plan();
    // the counts of operations are what they are: see the plan's own numbers
    let expected = format!(
        "Kubo by the rule midpoint
  1 degree of freedom, 1 Wiener process
  linear, 1 unknown, 1 non-zero in the Jacobian
    linear   v
  deterministic order 2, strong order 1 (all noises commute), weak order 1
  system
    L = v²/(2·a) − a·q²/2
    H₁ jitter = sigma·(q² + p²)/2
  equations of motion (Stratonovich)
    dq = v dt + sigma·p ∘ dW
    dp = −a·q dt − sigma·q ∘ dW
    p = v/a
  discrete action
    S = h·L(q̄, v) + p·(q₁ − q₀ − h·v) − H₁(q̄, p)·ΔW
    S = h·(v²/a − a·q̄²)/2 + p·(Δq − h·v) − sigma·ΔW·(q̄² + p²)/2
    q̄ = (q₀ + q₁)/2, Δq = q₁ − q₀
  equations of the step
    from a linear equation
      v = (p₀ − h·a·q₀/2 − sigma·ΔW·q₀/2)/(1/a + h·a·(h + sigma·ΔW/a)/4 + sigma·ΔW·(h + sigma·ΔW/a)/4)
    then
      q₁ = q₀ + h·v + sigma·ΔW·v/a
      p₁ = p₀ − h·a·q̄ − sigma·ΔW·q̄
    with
      q̄ = q₀ + h·v/2 + sigma·ΔW·v/(2·a)
    computed as a matrix times the state, whose entries are known before it
  operations a step size: {} arithmetic, 0 transcendental
  operations a step: {} arithmetic, 0 transcendental",
        plan.prepare.arithmetic, plan.step.arithmetic
    );
    assert_eq!(plan.to_string(), expected);
    let head = expected.lines().take(5).collect::<Vec<_>>().join("\n");
    assert_eq!(plan.structure().to_string(), head);
    // a rotation of two numbers by a rational function of ah + σΔW
    assert!(plan.step.arithmetic <= 40);
}

#[test]
fn banded_blocks_are_in_the_order_of_the_band() {
    // the k-th bead is number 3k mod 8; which end comes first is a matter of taste
    let way = [5, 2, 7, 4, 1, 6, 3, 0].map(|i| format!("v[{i}]"));
    let plan = Integrator::new(rails(), Midpoint).plan();
    let mut found = plan.blocks[0].unknowns.to_vec();
    if found[0] == "v[0]" {
        found.reverse();
    }
    assert_eq!(found, way);
    let text = plan.to_string();
    assert!(text.contains(" (banded, 1 + 1 + 1)"), "{text}");
}

/// Everything but the counts of operations.
fn formulas(plan: &Plan) -> String {
    let text = plan.to_string();
    let lines: Vec<&str> = text
        .lines()
        .skip_while(|line| !line.starts_with("  system"))
        .filter(|line| !line.starts_with("  operations"))
        .collect();
    lines.join("\n")
}

#[test]
fn linear_oscillator_by_endpoint() {
    let plan = Integrator::new(oscillator(), Endpoint).plan();
    let expected = "  system
    L = v²/2 − q²/2
    γ push = sigma·q
  equations of motion (Stratonovich)
    dq = v dt
    dp = −q dt + sigma ∘ dW
    p = v
  discrete action
    S = h·L(q₁, v) + p·(q₁ − q₀ − h·v) + γ(q₁)·ΔW
    S = h·(v² − q₁²)/2 + p·(Δq − h·v) + sigma·ΔW·q₁
    Δq = q₁ − q₀
  equations of the step
    q₁ = q₀ + h·p₀
    p₁ = p₀ + sigma·ΔW − h·q₁";
    assert_eq!(formulas(plan), expected);
}

#[test]
fn double_pendulum_by_midpoint() {
    let plan = Integrator::new(planar_double_pendulum(), Midpoint).plan();
    let expected = "  system
    L = l[0]²·v[0]²·(m[0] + m[1])/2 + m[1]·l[1]²·v[1]²/2 + m[1]·l[0]·l[1]·v[0]·v[1]·cos(q[0] − q[1]) + l[0]·g·cos(q[0])·(m[0] + m[1]) + m[1]·l[1]·g·cos(q[1])
  equations of motion
    dq[0] = v[0] dt
    dq[1] = v[1] dt
    dp[0] = −(m[1]·l[0]·l[1]·v[0]·v[1]·sin(q[0] − q[1]) + l[0]·g·sin(q[0])·(m[0] + m[1])) dt
    dp[1] = (m[1]·l[0]·l[1]·v[0]·v[1]·sin(q[0] − q[1]) − m[1]·l[1]·g·sin(q[1])) dt
    p[0] = l[0]²·v[0]·(m[0] + m[1]) + m[1]·l[0]·l[1]·v[1]·cos(q[0] − q[1])
    p[1] = m[1]·l[1]²·v[1] + m[1]·l[0]·l[1]·v[0]·cos(q[0] − q[1])
  discrete action
    S = h·L(q̄, v) + ⟨p, q₁ − q₀ − h·v⟩
    S = h·(l[0]²·v[0]²·(m[0] + m[1]) + m[1]·l[1]²·v[1]² + 2·m[1]·l[0]·l[1]·v[0]·v[1]·cos(q̄[0] − q̄[1]) + 2·l[0]·g·cos(q̄[0])·(m[0] + m[1]) + 2·m[1]·l[1]·g·cos(q̄[1]))/2 + p[0]·(Δq[0] − h·v[0]) + p[1]·(Δq[1] − h·v[1])
    q̄ = (q₀ + q₁)/2, Δq = q₁ − q₀
  equations of the step
    Newton's method for v[1], v[0]
      0 = l[0]²·v[0]·(m[0] + m[1]) − p₀[0] + m[1]·l[0]·l[1]·v[1]·c1 + h·(l[0]·g·sin(q̄[0])·(m[0] + m[1]) + m[1]·l[0]·l[1]·v[0]·v[1]·s1)/2
      0 = m[1]·l[1]²·v[1] − p₀[1] + m[1]·l[0]·l[1]·v[0]·c1 + h·(m[1]·l[1]·g·sin(q̄[1]) − m[1]·l[0]·l[1]·v[0]·v[1]·s1)/2
    then
      q₁[0] = q₀[0] + h·v[0]
      q₁[1] = q₀[1] + h·v[1]
      p₁[0] = 2·l[0]²·v[0]·(m[0] + m[1]) − p₀[0] + 2·m[1]·l[0]·l[1]·v[1]·c1
      p₁[1] = 2·m[1]·l[1]²·v[1] − p₀[1] + 2·m[1]·l[0]·l[1]·v[0]·c1
    with
      q̄[0] = q₀[0] + h·v[0]/2
      q̄[1] = q₀[1] + h·v[1]/2
      s1 = sin(q̄[0] − q̄[1])
      c1 = cos(q̄[0] − q̄[1])";
    assert_eq!(formulas(plan), expected);
}

#[test]
fn forces_and_symmetries() {
    let plan = Integrator::new(damped(), Midpoint).plan();
    let expected = "  system
    L = m·v²/2 − k·(q² − 1)²/4
    γ bath = sigma·q
    F = −m·nu·v
  equations of motion (Stratonovich)
    dq = v dt
    dp = −(k·q·(q² − 1) + m·nu·v) dt + sigma ∘ dW
    p = m·v
  discrete action
    S = h·L(q̄, v) + p·(q₁ − q₀ − h·v) + γ(q̄)·ΔW";
    assert!(formulas(plan).starts_with(expected), "{plan}");
    assert!(formulas(plan).contains("with the virtual work h·F(q̄, v)·δq̄ beside δS"));
    assert!(plan.conserved.is_empty());

    let plan = Integrator::new(charges(), Midpoint).plan();
    assert_eq!(plan.conserved, ["rotation_momentum", "shift_momentum"]);
    assert!(
        plan.to_string()
            .contains("\n  conserves rotation_momentum, shift_momentum\n")
    );
    assert!(
        plan.formulas
            .system
            .contains("conserved shift_momentum = p[2] + p[5]")
    );
    // not affine in q: not by the steps
    let plan = Integrator::new(stretched(), Midpoint).plan();
    assert!(plan.conserved.is_empty());
    assert!(
        plan.formulas
            .system
            .contains("conserved by the motion shift_momentum = ")
    );
}

/// The system of the guide's tour of the macro, by its rule alone: the order of terms may depend on
/// other rules.
mod guide {
    use sve_runtime::prelude::*;

    pub(super) struct Pendulum {
        pub(super) l: f64,
        pub(super) g: f64,
        pub(super) sigma: f64,
    }

    #[variational(midpoint)]
    impl Pendulum {
        fn lagrangian(&self, q: f64, v: f64) -> f64 {
            0.5 * self.l.powi(2) * v * v + self.g * self.l * q.cos()
        }

        #[gamma]
        fn shaking(&self, q: f64) -> f64 {
            self.sigma * q.cos()
        }
    }
}

/// The guide shows the text that the plan prints.
#[test]
fn the_plan_in_the_guide() {
    let text = include_str!("../../../sve-runtime/docs/guide/macro_tour.md");
    let pendulum = guide::Pendulum {
        l: 2.0,
        g: 9.8,
        sigma: 0.3,
    };
    let plan = Integrator::new(pendulum, Midpoint).plan().to_string();
    let shown = format!("```text\n{}\n```", plan.trim_end());
    assert!(text.contains(&shown), "{plan}");
}
