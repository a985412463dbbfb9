//! The option `weak2` of all rules: steps against Lagrangians that contain the potential by hand,
//! for steps of one size, and against the unrolled action; derivatives, symmetry, lanes,
//! trajectories, plans.

mod systems;

use sve_models::checks::{assert_close, assert_says};
use sve_models::orders::numbers;
use sve_models::potential::{
    Additive, Chain, ChainByHand, Heavy, HeavyByHand, HeavyUnstructured, Pendulums,
    PendulumsByHand, PendulumsUnstructured, Well, WellByHand, WellUnstructured,
};
use sve_models::random::Random;
use sve_models::steps::{check_return, check_tangent, stepped};
use sve_runtime::__private::Unstructured;
use sve_runtime::plan::{BlockKind, StrongOrder};
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
    let size = expected.iter().fold(1.0f64, |m, x| m.max(x.abs()));
    assert_close(found, expected, bound * size, what);
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

/// Checks that a step with the option is another one than without it.
fn differ<T, R, const N: usize, const M: usize>(system: T, rule: R)
where
    T: Variational<R> + Variational<Weak2<R>> + System<Dims = Dims<N, M>> + Clone,
    R: Copy,
{
    let (start, dw) = (State::new([0.6; N], [0.3; N]), [0.1; M]);
    let plain = stepped(&Integrator::new(system.clone(), rule), &start, H, &dw);
    let corrected = Integrator::new(system, Weak2(rule));
    let ends = stepped(&corrected, &start, H, &dw);
    let is_other = |i: usize| (ends[i] - plain[i]).abs() > 1e-5;
    assert!((N..2 * N).any(is_other), "{}", corrected.plan().rule);
}

/// ½κh for the midpoint rule and the rule of Störmer and Verlet.
const OF_ONE_STAGE: f64 = H / 8.0;

/// ½κh for increments in proportion to the weights.
const PLAIN: f64 = H / 12.0;

/// ½κh with stage noise of so many stages.
fn of_stage_noise(stages: usize) -> f64 {
    H / (8 * (2 * stages - 1)) as f64
}

macro_rules! compare {
    (@one_stage $($system:ident $by_hand:ident $noises:literal;)*) => {$(
        differ($system { s: S, m: 1.3 }, Midpoint);
        differ($system { s: S, m: 1.3 }, StormerVerlet);
        compare! { $system $by_hand $noises: Midpoint, OF_ONE_STAGE; StormerVerlet, OF_ONE_STAGE; }
    )*};
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
    compare! { @one_stage
        Well WellByHand 2;
        Heavy HeavyByHand 1;
        Pendulums PendulumsByHand 2;
        Chain ChainByHand 1;
    }
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

/// Checks the tangent map against central differences, that the step back returns, and with a bound
/// of the defect that the tangent map is symplectic.
fn check_identities<T, R, const N: usize, const M: usize, const K: usize>(
    integrator: &Integrator<T, R>,
    defect: Option<f64>,
) where
    T: System<Dims = Dims<N, M>>,
    R: Rule<T::Itself, Increments = [f64; K]>,
{
    let mut random = Random::new(9);
    for _ in 0..20 {
        let start: State<[f64; N]> = point(&mut random);
        let dw: [f64; K] = random.array(-0.2, 0.2);
        check_tangent(integrator, &start, H, &dw, defect);
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
        ($($system:ident $noises:literal $defect:expr; $($rule:expr),*;)*) => {$($(
            let integrator = Integrator::new($system { s: S, m: 1.3 }, Weak2($rule));
            check_identities::<_, _, _, $noises, _>(&integrator, $defect);
        )*)*};
    }
    let bound = Some(1e-13);
    check! {
        Well 2 bound; Midpoint, StormerVerlet;
        Pendulums 2 bound; Midpoint, StormerVerlet;
        Chain 1 bound; Midpoint, StormerVerlet;
        Well 2 bound; Gauss::<2>, Gauss::<4>, StageNoise(Gauss::<2>), StageNoise(Gauss::<4>);
        Pendulums 2 bound; Gauss::<2>, Gauss::<4>, StageNoise(Gauss::<2>), StageNoise(Gauss::<4>);
        Moved 2 bound; Gauss::<2>, Gauss::<3>, Gauss::<4>;
    }
    // friction
    check! { Heavy 1 None; Midpoint, StormerVerlet; }
}

/// Compares paths of an ensemble with single trajectories, and single trajectories with repeated
/// steps up to a bound.
fn follow<T, R, const N: usize, const M: usize>(system: T, rule: R, bound: f64)
where
    T: Variational<R> + System<Dims = Dims<N, M>> + Sync,
    R: Sync,
{
    let integrator = Integrator::new(system, rule);
    let start = State::new([0.6; N], [0.3; N]);
    let steps = 40;
    let summary = Ensemble::new(&integrator)
        .paths(30)
        .seed(8)
        .steps(0.05, steps)
        .start(start)
        .keep_final_states(true)
        .run()
        .expect("an ensemble");
    assert_eq!(summary.failed(), 0);
    for (path, end) in summary.final_states() {
        let mut noise = Wiener::new(8).path(path);
        let mut state = start;
        let mut last = Vec::new();
        for (step, next) in (0..steps).zip(integrator.trajectory(start, 0.05, noise)) {
            let mut dw = [0.0; M];
            noise.increments(step, 0.05, &mut dw).unwrap();
            integrator.step(&mut state, 0.05, &dw).unwrap();
            last = numbers(&next.unwrap());
            close(&numbers(&state), &last, bound, "repeated steps");
        }
        close(&[end.q, end.p].concat(), &last, 1e-12, "in a lane");
    }
}

#[test]
fn ensembles_and_trajectories() {
    follow(Well { s: S, m: 1.3 }, Weak2(StormerVerlet), 1e-14);
    follow(Well { s: S, m: 1.3 }, Weak2(Midpoint), 1e-14);
    follow(Pendulums { s: S, m: 1.3 }, Weak2(Midpoint), 1e-14);
    follow(Pendulums { s: S, m: 1.3 }, Weak2(StormerVerlet), 1e-14);
    follow(Moved { s: S, m: 1.3 }, Weak2(Gauss::<4>), 1e-15);
}

#[test]
fn the_structure_is_that_of_the_plain_rule() {
    let well = Well { s: S, m: 1.3 };
    let verlet = Integrator::new(well.clone(), Weak2(StormerVerlet)).plan();
    assert_eq!(verlet.kind(), BlockKind::Explicit);
    assert_eq!(verlet.rule, "stormer_verlet(weak2)");
    let action = &verlet.formulas.action;
    assert_says(action, &[" − h·|h|·(K(q₀) + K(q₁))/16"]);
    let plain = Integrator::new(well, StormerVerlet).plan();
    assert_eq!([plain.weak_order, verlet.weak_order], [1, 2]);
    assert_eq!(plain.strong_order, verlet.strong_order);
    let orders = ", strong order 1 (all noises commute), weak order 2\n";
    assert_says(verlet, &[orders]);
    let midpoint = Integrator::new(Pendulums { s: S, m: 1.3 }, Weak2(Midpoint)).plan();
    assert_says(midpoint.formulas.action, &[" − h·|h|·K(t̄, q̄)/8"]);
    assert_eq!(midpoint.unknowns(), 2);
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
        assert_eq!(plain.plan().weak_order, 2);
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
    check(Midpoint);
    check(StormerVerlet);
    assert_eq!(check(Gauss::<2>), StrongOrder::One);
    assert_eq!(check(Gauss::<4>), StrongOrder::One);
    assert_eq!(check(StageNoise(Gauss::<3>)), StrongOrder::Three);
}
