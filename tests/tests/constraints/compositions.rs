//! Compositions of constrained steps: their orders, and that symmetric rules step back.

use sve_models::models::TwoRods;
use sve_models::orders::{Order, Tolerance, distance2, numbers};
use sve_runtime::prelude::*;
use sve_runtime::{Rule, Variational};

use super::systems::two_rods;

fn end<R: Copy>(rule: R, steps: u32) -> Vec<f64>
where
    TwoRods: Variational<R>,
{
    let integrator = Integrator::new(two_rods(), rule);
    let start = integrator.consistent(State::new([0.9, -0.4, 0.6, -1.0], [0.2, 0.5, 0.4, 0.1]));
    let mut path = integrator.trajectory(start.unwrap(), 1.0 / f64::from(steps), NoNoise);
    numbers(&path.nth(steps as usize - 1).unwrap().unwrap())
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
    fn check<R, B>(there: R, back: B)
    where
        TwoRods: Variational<R> + Variational<B>,
    {
        let there = Integrator::new(two_rods(), there);
        let back = Integrator::new(two_rods(), back);
        let start = State::new([0.9, -0.4, 0.6, -1.0], [0.2, 0.5, 0.4, 0.1]);
        let start = there.consistent(start).unwrap();
        let mut state = start;
        there.step(&mut state, 0.05, &[0.3, -0.2]).unwrap();
        back.step(&mut state, -0.05, &[-0.3, 0.2]).unwrap();
        for (bound, at, expected) in [(1e-14, state.q, start.q), (1e-13, state.p, start.p)] {
            let error = distance2(&at, &expected).sqrt();
            assert!(error < bound, "{state:?} {start:?}");
        }
    }
    check(Midpoint, Midpoint);
    check(StormerVerlet, StormerVerlet);
    check(InitialPoint, Endpoint);
    check(Endpoint, InitialPoint);
    check(
        Composed::new(Midpoint, KahanLi8),
        Composed::new(Midpoint, KahanLi8),
    );
}

#[test]
fn a_composition_has_no_multipliers_and_says_its_substeps() {
    let plan = <Composed<Midpoint, KahanLi8> as Rule<TwoRods>>::PLAN;
    assert_eq!(plan.deterministic_order, 8);
}
