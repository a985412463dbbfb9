//! Compositions of constrained steps: their orders, and that symmetric rules step back.

use sve_models::checks::assert_close;
use sve_models::models::TwoRods;
use sve_models::orders::{Order, Tolerance, distance2, numbers};
use sve_models::stepper::{Stepper, with_verlet};
use sve_runtime::prelude::*;
use sve_runtime::{Rule, Variational};

use super::systems::{two_rods, two_rods_at};

fn end<R: Copy>(rule: R, steps: u32) -> Vec<f64>
where
    TwoRods: Variational<R>,
{
    let integrator = Integrator::new(two_rods(), rule);
    let h = 1.0 / f64::from(steps);
    numbers(&integrator.after(two_rods_at(0.5), h, &[0.0; 2], steps))
}

/// Checks the order of the error at time 1 between a number of steps and twice as many.
fn check<R: Copy>(name: &str, rule: R, steps: u32, expected: f64, exact: &[f64])
where
    TwoRods: Variational<R>,
{
    let errors = [steps, 2 * steps].map(|steps| distance2(&end(rule, steps), exact).sqrt());
    let tolerance = Tolerance {
        bias: 0.12 * expected.sqrt(),
        error: 0.0,
    };
    Order::of(&errors).check(["TwoRods", name, "none"], expected, tolerance);
}

#[test]
fn orders() {
    let exact = end(Composed::new(Midpoint, KahanLi8), 400);
    check("initial point", InitialPoint, 3200, 1.0, &exact);
    check("endpoint", Endpoint, 3200, 1.0, &exact);
    check("midpoint", Midpoint, 200, 2.0, &exact);
    check("Störmer–Verlet", StormerVerlet, 200, 2.0, &exact);
    let rule = Composed::new(Midpoint, KahanLi8);
    check("Kahan–Li of midpoint", rule, 32, 8.0, &exact);
    let rule = Composed::new(StormerVerlet, KahanLi8);
    check("Kahan–Li of Störmer–Verlet", rule, 32, 8.0, &exact);
    check("Blanes–Moan", Split::new(BlanesMoan4), 64, 4.0, &exact);
}

/// A symmetric rule with −h and −ΔW returns to its start; initial point and endpoint are adjoint to
/// one another.
#[test]
fn steps_lead_back() {
    let system = two_rods();
    let composed = Composed::new(Midpoint, KahanLi8);
    let [there, back] = [with_verlet(&system), with_verlet(&system)].map(|mut rules| {
        rules.push(Box::new(Integrator::new(&system, composed)));
        rules
    });
    let start = two_rods_at(0.5);
    // initial point and endpoint are the first and the third
    for (there, back) in there.iter().zip([2, 1, 0, 3, 4].map(|at| &back[at])) {
        let state = there.after(start, 0.05, &[0.3, -0.2], 1);
        let state = back.after(state, -0.05, &[-0.3, 0.2], 1);
        assert_close(&state.q, &start.q, 1e-14, there.name());
        assert_close(&state.p, &start.p, 1e-13, there.name());
    }
}

#[test]
fn a_composition_has_no_multipliers_and_says_its_substeps() {
    let plan = <Composed<Midpoint, KahanLi8> as Rule<TwoRods>>::PLAN;
    assert_eq!(plan.deterministic_order, 8);
}
