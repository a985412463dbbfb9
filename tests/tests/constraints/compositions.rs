//! Compositions of constrained steps: their orders, and that symmetric rules step back.

use sve_models::models::TwoRods;
use sve_runtime::prelude::*;
use sve_runtime::{Rule, Variational};

use super::systems::two_rods;

fn end<R>(rule: R, steps: u32) -> [f64; 8]
where
    TwoRods: Variational<R>,
{
    let integrator = Integrator::new(two_rods(), rule);
    let h = 1.0 / f64::from(steps);
    let start = integrator.consistent(State::new([0.9, -0.4, 0.6, -1.0], [0.2, 0.5, 0.4, 0.1]));
    let mut state = start.unwrap();
    for _ in 0..steps {
        integrator.step(&mut state, h, &[0.0, 0.0]).unwrap();
    }
    [state.q, state.p].concat().try_into().unwrap()
}

/// The order of the error at time 1 between two numbers of steps.
fn order<R: Copy>(rule: R, steps: u32, exact: &[f64; 8]) -> f64
where
    TwoRods: Variational<R>,
{
    let error = |steps| {
        let found = end(rule, steps);
        let squares = found.iter().zip(exact).map(|(a, b)| (a - b).powi(2));
        squares.sum::<f64>().sqrt()
    };
    (error(steps) / error(2 * steps)).log2()
}

fn check(name: &str, order: f64, expected: f64) {
    println!("{name}: {order:.3}");
    assert!(
        (order - expected).abs() < 0.12 * expected.sqrt(),
        "{name}: {order}, expected {expected}"
    );
}

#[test]
fn orders() {
    let exact = end(Composed::new(Midpoint, KahanLi8), 400);
    let exact = &exact;
    check("initial point", order(InitialPoint, 3200, exact), 1.0);
    check("endpoint", order(Endpoint, 3200, exact), 1.0);
    check("midpoint", order(Midpoint, 200, exact), 2.0);
    check("Störmer–Verlet", order(StormerVerlet, 200, exact), 2.0);
    check(
        "Kahan–Li of midpoint",
        order(Composed::new(Midpoint, KahanLi8), 32, exact),
        8.0,
    );
    check(
        "Kahan–Li of Störmer–Verlet",
        order(Composed::new(StormerVerlet, KahanLi8), 32, exact),
        8.0,
    );
    check(
        "Blanes–Moan",
        order(Split::new(BlanesMoan4), 64, exact),
        4.0,
    );
}

/// A symmetric rule with −h and −ΔW returns to its start; initial point and endpoint are adjoint to one another.
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
        for i in 0..4 {
            assert!(
                (state.q[i] - start.q[i]).abs() < 1e-14,
                "{state:?} {start:?}"
            );
            assert!(
                (state.p[i] - start.p[i]).abs() < 1e-13,
                "{state:?} {start:?}"
            );
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
