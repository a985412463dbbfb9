//! How stages are solved: by fixed-point iteration where it contracts, by Newton's method
//! elsewhere.

use sve_models::checks::assert_says;
use sve_models::orders::{distance2, numbers};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::systems::{Pendulum, Relativistic, Ring, double_pendulum, pendulum};

/// Makes a step, and returns whether the fixed-point iteration solved it: then no iteration of
/// Newton's method is needed.
fn is_fixed_point<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    state: State<[f64; N]>,
    h: f64,
) -> bool
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    integrator.step(&mut { state }, h, &[0.0; M]).unwrap();
    let prepared = integrator.prepare(h).unwrap();
    // none where Newton's method was followed by continuation
    integrator.newton_iterations(&prepared, &state, h, &[0.0; M]) == Some(0)
}

#[test]
fn newton_takes_over_where_the_fixed_point_contracts_badly() {
    let start = State::new([2.0], [0.3]);
    let of_pendulum = |h| is_fixed_point(&Integrator::new(pendulum(), Gauss::<4>), start, h);
    assert!([0.1, 0.5, 2.0].into_iter().all(of_pendulum));
    assert!(![3.0, 4.0].into_iter().any(of_pendulum));
    // a stiff pendulum
    let stiff = |h| is_fixed_point(&Integrator::new(Pendulum { g: 1e4 }, Gauss::<8>), start, h);
    assert!(stiff(0.005));
    assert!(!stiff(0.1));
    let start = State::new([1.0, 0.5], [0.1, -0.2]);
    let of_two = |h| is_fixed_point(&Integrator::new(double_pendulum(), Gauss::<8>), start, h);
    assert!(of_two(0.1));
    assert!(!of_two(2.0));
}

#[test]
fn few_stages_and_other_kinetic_energies_are_for_newton() {
    let start = State::new([1.0], [0.3]);
    let relativistic = Relativistic {
        m: 1.1,
        c: 1.5,
        k: 0.7,
    };
    let found = [
        is_fixed_point(&Integrator::new(pendulum(), Gauss::<2>), start, 0.1),
        is_fixed_point(&Integrator::new(pendulum(), Gauss::<3>), start, 0.1),
        is_fixed_point(&Integrator::new(relativistic, Gauss::<4>), start, 0.1),
    ];
    assert_eq!(found, [false; 3]);
}

/// Newton's matrix of the largest step, 205 kB, has room on the stack of a thread, which is 2 MiB
/// by default, and a quarter of the stack is left for the program.
#[test]
fn the_largest_step_is_solved_by_both() {
    let largest = std::thread::Builder::new().stack_size(3 << 19);
    let thread = largest.spawn(|| {
        let ring = Integrator::new(Ring, Gauss::<8>);
        assert_eq!(ring.plan().unknowns(), 160);
        let start = State::new(core::array::from_fn(|i| 0.05 * i as f64), [0.1; 20]);
        assert!(is_fixed_point(&ring, start, 0.1));
        assert!(!is_fixed_point(&ring, start, 2.5));
    });
    thread.unwrap().join().unwrap();
}

#[test]
fn the_plan_says_stages_and_orders() {
    let integrator = Integrator::new(double_pendulum(), Gauss::<4>);
    let plan = integrator.plan();
    assert_eq!((plan.rule, plan.deterministic_order), ("gauss(4)", 8));
    assert_eq!(plan.unknowns(), 8);
    let parts = [
        "S = Σᵢ { h·bᵢ·(L(Qᵢ, Vᵢ) + ⟨Pᵢ, Uᵢ − Vᵢ⟩) + bᵢ·Σ γ(Qᵢ)·ΔW } + ⟨λ, q₁ − q₀ − h·Σⱼ bⱼ·Uⱼ⟩",
        "fixed-point iteration, Newton's method where it does not contract, for Vᵢ at 4 stages",
        "c = 0.069432, 0.330009, 0.669991, 0.930568",
        "b = 0.173927, 0.326073, 0.326073, 0.173927",
        "deterministic order 8, strong order 1",
    ];
    assert_says(plan, &parts);
}

/// A composition of a rule of order 4 has order 8, and lowers no order.
#[test]
fn compositions_of_gauss_rules_have_the_higher_order() {
    let pendulum = Pendulum { g: 1.0 };
    let composed = Integrator::new(&pendulum, Composed::new(Gauss::<2>, KahanLi8));
    assert_eq!(composed.plan().deterministic_order, 8);
    let highest = Integrator::new(&pendulum, Composed::new(Gauss::<8>, KahanLi8));
    assert_eq!(highest.plan().deterministic_order, 16);
    let exact = Integrator::new(&pendulum, Gauss::<8>);
    let end = |steps: usize| {
        let mut path = composed.trajectory(State::new([1.0], [0.3]), 2.0 / steps as f64, NoNoise);
        path.nth(steps - 1).unwrap().unwrap()
    };
    let mut expected = exact.trajectory(State::new([1.0], [0.3]), 0.1, NoNoise);
    let expected = expected.nth(19).unwrap().unwrap();
    let error = |steps| distance2(&numbers(&end(steps)), &numbers(&expected)).sqrt();
    // the leading terms nearly cancel at the longest step, so the slope is too large rather than
    // too small
    let order = (error(2) / error(4)).log2();
    assert!(order > 7.0, "{order}: {:e} {:e}", error(2), error(4));
    assert!(error(4) < 1e-9, "{:e}", error(4));
}
