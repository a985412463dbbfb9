//! Steps back in time. The rule with node c and step −h, −ΔW is the inverse of the rule with node
//! 1 − c and step h, ΔW, since their actions differ only in sign and in the order of the ends. So
//! midpoint is symmetric, and initial point and endpoint are adjoint (Hairer, Lubich, Wanner,
//! *Geometric Numerical Integration*, section II.3).

use sve_models::case::Case;
use sve_models::oracle::{Nodes, cases};
use sve_models::random::Random;
use sve_runtime::prelude::*;

const H: f64 = 0.05;

/// Allowed difference in units of rounding: the rounding errors of both steps, amplified by the
/// Jacobians of the models.
const UNITS: f64 = 40.0;

/// Returns the name of the rule that inverts a step.
fn adjoint(rule: &str) -> &str {
    match rule {
        "initial_point" => "endpoint",
        "endpoint" => "initial_point",
        other => other,
    }
}

fn returns(there: &dyn Case, back: &dyn Case, random: &mut Random) {
    for _ in 0..50 {
        let start = there.model().point(random);
        let dw = random.vector(there.dimensions().1, -0.1, 0.1);
        let mut state = there.stepped(&start, H, &dw);
        let backwards: Vec<f64> = dw.iter().map(|w| -w).collect();
        let name = there.name();
        back.step(&mut state, -H, &backwards)
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        for (x, expected) in state.entries().zip(start.entries()) {
            let error = (x - expected).abs() / (f64::EPSILON * start.size());
            assert!(
                error <= UNITS,
                "{name}: {state:?} for {start:?}, {error} units"
            );
        }
        assert!((state.t - start.t).abs() <= f64::EPSILON);
    }
}

#[test]
fn a_step_back_by_the_adjoint_rule_returns_to_the_start() {
    let (cases, mut random) = (cases(), Random::new(61));
    let mut count = 0;
    // taylor2 has another adjoint
    for there in cases.iter().filter(|case| case.nodes() != Nodes::Predicted) {
        let (system, rule) = (there.plan().system, adjoint(there.rule()));
        let back = cases
            .iter()
            .find(|case| case.plan().system == system && case.rule() == rule)
            .expect("the adjoint rule");
        returns(&**there, &**back, &mut random);
        count += 1;
    }
    assert_eq!(count, 108);
}

#[test]
fn increments_over_a_step_back_have_the_size_of_those_over_a_step() {
    let [mut there, mut back] = [[0.0; 2]; 2];
    let mut wiener = Wiener::new(5);
    wiener.increments(3, H, &mut there).unwrap();
    wiener.increments(3, -H, &mut back).unwrap();
    assert_eq!(there, back);
    let recorded = Recorded::new(H, [[0.1], [0.2]]).unwrap();
    let mut dw = [0.0];
    (&recorded).increments(1, -H, &mut dw).unwrap();
    assert_eq!(dw, [0.2]);
}
