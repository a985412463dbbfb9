//! The option `weak2`: steps against Lagrangians that contain the potential by hand, and against
//! the unrolled action; derivatives, symmetry, trajectories, plans.

mod systems;

use sve_models::orders::numbers;
use sve_models::potential::{
    Additive, Heavy, HeavyByHand, HeavyUnstructured, Pendulums, PendulumsByHand,
    PendulumsUnstructured, Well, WellByHand, WellUnstructured,
};
use sve_models::random::Random;
use sve_models::steps::{check_return, check_tangent};
use sve_runtime::__private::Unstructured;
use sve_runtime::plan::StrongOrder;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{Rule, Variational};

use systems::{Moved, Quadratic, Stretched};

const H: f64 = 0.1;

/// Rounding of steps whose equations are solved to rounding.
const ROUNDING: f64 = 1e-14;

/// Rounding of their derivatives.
const DERIVATIVES: f64 = 1e-13;

const S: [f64; 2] = [0.6, 0.4];

#[track_caller]
fn close(found: &[f64], expected: &[f64], bound: f64, what: &str) {
    assert_eq!(found.len(), expected.len());
    let size = expected.iter().fold(1.0f64, |m, x| m.max(x.abs()));
    for (x, y) in found.iter().zip(expected) {
        assert!(
            (x - y).abs() <= bound * size,
            "{what}: {found:?} for {expected:?}"
        );
    }
}

fn point<const N: usize>(random: &mut Random) -> State<[f64; N]> {
    State::at(
        random.uniform(0.2, 1.0),
        random.array(-0.8, 0.8),
        random.array(-0.8, 0.8),
    )
}

/// The state after a step, and its derivatives by the state and by some parameters.
fn derived<T, R, const N: usize, const M: usize, const K: usize>(
    integrator: &Integrator<T, R>,
    start: &State<[f64; N]>,
    dw: &[f64; K],
    parameters: &[&str],
) -> [Vec<f64>; 2]
where
    T: System<Dims = Dims<N, M>>,
    R: Rule<T::Itself, Increments = [f64; K]>,
{
    let mut state = *start;
    let derivatives = integrator.step_with_derivatives(&mut state, H, dw);
    let (tangent, sensitivity) = derivatives.unwrap();
    let mut all = tangent.to_dmatrix().as_slice().to_vec();
    for parameter in parameters {
        let field = sensitivity.get(parameter).unwrap();
        all.extend(field.q);
        all.extend(field.p);
    }
    [numbers(&state), all]
}

/// Compares steps by two rules, with their derivatives.
fn agree<T, U, P, R, const N: usize, const M: usize, const K: usize>(
    one: &Integrator<T, P>,
    other: &Integrator<U, R>,
    parameters: &[&str],
) where
    T: System<Dims = Dims<N, M>>,
    U: System<Dims = Dims<N, M>>,
    P: Rule<T::Itself, Increments = [f64; K]>,
    R: Rule<U::Itself, Increments = [f64; K]>,
{
    let name = format!("{} by {}", one.plan().system, one.plan().rule);
    let mut random = Random::new(4);
    for _ in 0..20 {
        let start: State<[f64; N]> = point(&mut random);
        let dw: [f64; K] = random.array(-0.2, 0.2);
        let found = derived::<_, _, N, M, K>(one, &start, &dw, parameters);
        let expected = derived::<_, _, N, M, K>(other, &start, &dw, parameters);
        close(&found[0], &expected[0], ROUNDING, &name);
        close(&found[1], &expected[1], DERIVATIVES, &name);
    }
}

/// ½κh for increments in proportion to the weights.
const PLAIN: f64 = H / 12.0;

/// ½κh with stage noise of so many stages.
fn of_stage_noise(stages: usize) -> f64 {
    H / (8 * (2 * stages - 1)) as f64
}

macro_rules! compare {
    ($system:ident $by_hand:ident $noises:literal: $($rule:expr, $part:expr;)*) => {$(
        let corrected = Integrator::new($system { s: S, m: 1.3 }, Weak2($rule));
        let by_hand = Integrator::new($by_hand { s: S, m: 1.3, part: $part }, $rule);
        agree::<_, _, _, _, _, $noises, _>(&corrected, &by_hand, &["s[0]", "s[1]", "m"]);
    )*};
    ($system:ident $by_hand:ident $noises:literal) => {
        compare! { $system $by_hand $noises:
            Gauss::<2>, PLAIN;
            Gauss::<3>, PLAIN;
            Gauss::<4>, PLAIN;
            StageNoise(Gauss::<2>), of_stage_noise(2);
            StageNoise(Gauss::<4>), of_stage_noise(4);
        }
    };
}

#[test]
fn steps_are_those_of_the_lagrangian_with_the_potential() {
    compare!(Well WellByHand 2);
    compare!(Heavy HeavyByHand 1);
    compare!(Pendulums PendulumsByHand 2);
}

/// K = (aw − bk)(aq² − bp²) for H = ½(wp² + kq²); the Hamiltonian with the potential has other w
/// and k.
#[test]
fn noise_in_momentum_adds_to_the_hamiltonian() {
    fn check<R>(rule: R)
    where
        R: Copy,
        Quadratic: Variational<R> + Variational<Weak2<R>> + System<Dims = Dims<1, 1>>,
    {
        let plain = Quadratic {
            w: 0.8,
            k: 1.3,
            a: 0.7,
            b: -0.4,
        };
        let Quadratic { w, k, a, b } = plain;
        let difference = a * w - b * k;
        let by_hand = Quadratic {
            w: w - 2.0 * PLAIN * difference * b,
            k: k + 2.0 * PLAIN * difference * a,
            a,
            b,
        };
        let corrected = Integrator::new(plain, Weak2(rule));
        let by_hand = Integrator::new(by_hand, rule);
        agree::<_, _, _, _, 1, 1, 1>(&corrected, &by_hand, &[]);
    }
    check(Gauss::<2>);
    check(Gauss::<3>);
    check(Gauss::<4>);
}

#[test]
fn steps_are_those_of_the_unrolled_action() {
    macro_rules! check {
        ($($system:ident $noises:literal: $($stages:literal)*;)*) => {$($(
            let system = $system { s: S, m: 1.3 };
            let derived = Integrator::new(system.clone(), Weak2(Gauss::<$stages>));
            let unrolled = Integrator::new(system, Unstructured(Weak2(Gauss::<$stages>)));
            agree::<_, _, _, _, _, $noises, _>(&derived, &unrolled, &["s[0]", "s[1]", "m"]);
        )*)*};
    }
    check! {
        WellUnstructured 2: 2 4;
        HeavyUnstructured 1: 2 4;
        PendulumsUnstructured 2: 2 4;
        Stretched 2: 2 4;
    }
}

/// Checks the tangent map against central differences, that it is symplectic, and that the step
/// back returns.
fn is_symplectic<T, R, const N: usize, const M: usize, const K: usize>(
    integrator: &Integrator<T, R>,
) where
    T: System<Dims = Dims<N, M>>,
    R: Rule<T::Itself, Increments = [f64; K]>,
{
    let mut random = Random::new(9);
    for _ in 0..20 {
        let start: State<[f64; N]> = point(&mut random);
        let dw: [f64; K] = random.array(-0.2, 0.2);
        check_tangent(integrator, &start, H, &dw, Some(1e-13));
        // stages change places in the step back
        let stages = K / M;
        let back = core::array::from_fn(|at| {
            let (process, stage) = (at / stages, at % stages);
            -dw[process * stages + stages - 1 - stage]
        });
        check_return(integrator, &start, H, [&dw, &back], ROUNDING);
    }
}

#[test]
fn steps_are_symplectic_and_return() {
    macro_rules! check {
        ($($system:ident $noises:literal: $($rule:expr),*;)*) => {$($(
            let system = $system { s: S, m: 1.3 };
            is_symplectic::<_, _, _, $noises, _>(&Integrator::new(system, Weak2($rule)));
        )*)*};
    }
    check! {
        Well 2: Gauss::<2>, Gauss::<4>, StageNoise(Gauss::<2>), StageNoise(Gauss::<4>);
        Pendulums 2: Gauss::<2>, Gauss::<4>, StageNoise(Gauss::<2>), StageNoise(Gauss::<4>);
        Moved 2: Gauss::<2>, Gauss::<3>, Gauss::<4>;
    }
}

/// A trajectory is the repeated step.
#[test]
fn trajectories_are_repeated_steps() {
    let integrator = Integrator::new(Moved { s: S, m: 1.3 }, Weak2(Gauss::<4>));
    let start = State::new([0.6, -0.2], [0.3, 0.1]);
    let mut noise = Wiener::new(8);
    let mut state = start;
    for (step, next) in (0..40).zip(integrator.trajectory(start, 0.05, Wiener::new(8))) {
        let mut dw = [0.0; 2];
        noise.increments(step, 0.05, &mut dw).unwrap();
        integrator.step(&mut state, 0.05, &dw).unwrap();
        let next = next.unwrap();
        // times of trajectories are rounded once
        close(&numbers(&state), &numbers(&next), 1e-15, "repeated steps");
    }
}

#[test]
fn plans_state_the_orders_and_the_term() {
    let well = || Well { s: S, m: 1.3 };
    let plain = Integrator::new(well(), Gauss::<2>).plan();
    let corrected = Integrator::new(well(), Weak2(Gauss::<2>)).plan();
    let on_paths = Integrator::new(well(), Weak2(StageNoise(Gauss::<2>))).plan();
    assert_eq!(corrected.rule, "gauss(2, weak2)");
    assert_eq!(on_paths.rule, "gauss(2, stage_noise, weak2)");
    assert_eq!([plain.weak_order, corrected.weak_order], [1, 2]);
    assert_eq!(plain.strong_order, corrected.strong_order);
    assert_eq!(on_paths.strong_order, StrongOrder::OneAndAHalf);
    assert_eq!(on_paths.weak_order, 2);
    assert_eq!(plain.unknowns(), corrected.unknowns());
    let texts = [plain, corrected, on_paths].map(|plan| &plan.formulas);
    assert!(!texts[0].action.contains('K'));
    assert!(texts[1].action.contains(" − |h|·K(Qᵢ)/12 + "));
    assert!(texts[1].action.contains("K = Σ (∂γ/∂q)²/(∂²L/∂v²)"));
    assert!(texts[1].step.contains(" − h·|h|·bᵢ·∂K/∂q(Qᵢ)/12\n"));
    assert!(texts[2].action.contains(" − |h|·K(Qᵢ)/24 + "));
    assert!(texts[2].action.contains(" + Σ γ(Qᵢ)·ωᵢ"));
    let moved = Integrator::new(Moved { s: S, m: 1.3 }, Weak2(Gauss::<3>)).plan();
    assert!(moved.formulas.action.contains(" − |h|·K(tᵢ, Qᵢ, Pᵢ)/12 + "));
    assert!(
        moved
            .formulas
            .step
            .contains(" + h·|h|·bᵢ·∂K/∂p(tᵢ, Qᵢ, Pᵢ)/12\n")
    );
    assert_eq!(moved.weak_order, 2);
}

#[test]
fn additive_noise_has_no_term() {
    fn check<R, const K: usize>(rule: R) -> StrongOrder
    where
        R: Copy + Rule<Additive, Increments = [f64; K]>,
        Weak2<R>: Rule<Additive, Increments = [f64; K]>,
    {
        let (plain, corrected) = (
            Integrator::new(Additive, rule),
            Integrator::new(Additive, Weak2(rule)),
        );
        assert!(!corrected.plan().formulas.action.contains('K'));
        assert_eq!(corrected.plan().weak_order, 2);
        assert_eq!(corrected.plan().strong_order, plain.plan().strong_order);
        let mut random = Random::new(2);
        for _ in 0..20 {
            let (start, dw) = (point(&mut random), random.array(-0.3, 0.3));
            let (mut a, mut b) = (start, start);
            plain.step(&mut a, H, &dw).unwrap();
            corrected.step(&mut b, H, &dw).unwrap();
            assert_eq!(a, b);
        }
        plain.plan().strong_order
    }
    assert_eq!(check(Gauss::<2>), StrongOrder::One);
    assert_eq!(check(Gauss::<4>), StrongOrder::One);
    assert_eq!(check(StageNoise(Gauss::<3>)), StrongOrder::Three);
}
