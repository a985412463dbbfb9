//! The option `weak2`: its step is that of the Lagrangian L − |h| K/8, which is written by hand
//! here for steps of one size; with everything that steps have: tangent maps, sensitivities,
//! symmetry, lanes, what a trajectory carries.

use sve_models::checks::{assert_close, assert_says};
use sve_models::orders::numbers;
use sve_models::potential::{
    Additive, Chain, ChainByHand, Heavy, HeavyByHand, Pendulums, PendulumsByHand, Well, WellByHand,
};
use sve_models::random::Random;
use sve_runtime::Variational;
use sve_runtime::plan::BlockKind;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

const H: f64 = 0.1;

/// Rounding of steps whose equations are solved to rounding, with condition numbers below 10 and
/// some 100 operations.
const ROUNDING: f64 = 1e-13;

/// Rounding of derivatives of these.
const DERIVATIVES: f64 = 1e-11;

#[track_caller]
fn close(found: &[f64], expected: &[f64], bound: f64, what: &str) {
    let size = expected.iter().fold(1.0f64, |m, x| m.max(x.abs()));
    assert_close(found, expected, bound * size, what);
}

fn point<const N: usize>(random: &mut Random) -> State<[f64; N]> {
    State::at(
        random.uniform(0.2, 1.0),
        random.array(-1.0, 1.0),
        random.array(-1.0, 1.0),
    )
}

/// Compares steps and their derivatives.
fn agree<S, T, R, const N: usize, const M: usize>(system: &S, by_hand: &T, rule: R)
where
    S: Variational<Weak2<R>> + Variational<R> + System<Dims = Dims<N, M>> + Clone,
    T: Variational<R> + System<Dims = Dims<N, M>> + Clone,
    R: Copy,
{
    let corrected = Integrator::new(system.clone(), Weak2(rule));
    let by_hand = Integrator::new(by_hand.clone(), rule);
    let plain = Integrator::new(system.clone(), rule);
    let name = corrected.plan().rule;
    let mut random = Random::new(4);
    let mut differs = false;
    for _ in 0..20 {
        let start: State<[f64; N]> = point(&mut random);
        let dw: [f64; M] = random.array(-0.3, 0.3);
        let (mut found, mut expected, mut other) = (start, start, start);
        let (tangent, sensitivity) = corrected.step_with_derivatives(&mut found, H, &dw).unwrap();
        let (tangent_by_hand, sensitivity_by_hand) = by_hand
            .step_with_derivatives(&mut expected, H, &dw)
            .unwrap();
        plain.step(&mut other, H, &dw).unwrap();
        close(&numbers(&found), &numbers(&expected), ROUNDING, name);
        differs |= (0..N).any(|i| (found.p[i] - other.p[i]).abs() > 1e-5);
        let (a, b) = (tangent.to_dmatrix(), tangent_by_hand.to_dmatrix());
        close(a.as_slice(), b.as_slice(), DERIVATIVES, name);
        for parameter in ["s[0]", "s[1]", "m"] {
            let of = |field: &sve_runtime::__private::Field<[f64; N]>| [field.q, field.p].concat();
            let [a, b] = [&sensitivity, &sensitivity_by_hand].map(|s| s.get(parameter).unwrap());
            close(&of(a), &of(b), DERIVATIVES, parameter);
        }
        // back along the same increments
        let back = dw.map(|dw| -dw);
        corrected.step(&mut found, -H, &back).unwrap();
        close(&numbers(&found), &numbers(&start), 10.0 * ROUNDING, name);
    }
    assert!(differs, "{name}: no term");
}

const S: [f64; 2] = [0.6, 0.4];

macro_rules! compare {
    ($system:ident $by_hand:ident) => {
        let (system, by_hand) = (
            $system { s: S, m: 1.3 },
            $by_hand {
                s: S,
                m: 1.3,
                part: H / 8.0,
            },
        );
        agree(&system, &by_hand, Midpoint);
        agree(&system, &by_hand, StormerVerlet);
    };
}

#[test]
fn steps_are_those_of_the_lagrangian_with_the_potential() {
    compare!(Well WellByHand);
    compare!(Heavy HeavyByHand);
    compare!(Pendulums PendulumsByHand);
    compare!(Chain ChainByHand);
}

#[test]
fn tangent_maps_are_symplectic() {
    let pendulums = Pendulums { s: S, m: 1.3 };
    let mut random = Random::new(9);
    for _ in 0..20 {
        let (start, dw) = (point(&mut random), random.array(-0.3, 0.3));
        let midpoint = Integrator::new(pendulums.clone(), Weak2(Midpoint));
        let verlet = Integrator::new(pendulums.clone(), Weak2(StormerVerlet));
        for tangent in [
            midpoint.tangent(&start, H, &dw),
            verlet.tangent(&start, H, &dw),
        ] {
            let defect = tangent.unwrap().symplectic_defect();
            assert!(defect < 1e-12, "{defect:e}");
        }
    }
}

#[test]
fn the_structure_is_that_of_the_plain_rule() {
    let well = Well { s: S, m: 1.3 };
    let verlet = Integrator::new(well.clone(), Weak2(StormerVerlet)).plan();
    assert_eq!(verlet.kind(), BlockKind::Explicit);
    assert_eq!(verlet.rule, "stormer_verlet(weak2)");
    let action = &verlet.formulas.action;
    assert_says(action, &[" − h·|h|·(K(q₀) + K(q₁))/16"]);
    let plain = Integrator::new(well.clone(), StormerVerlet).plan();
    assert_eq!([plain.weak_order, verlet.weak_order], [1, 2]);
    assert_eq!(plain.strong_order, verlet.strong_order);
    let orders = ", strong order 1 (all noises commute), weak order 2\n";
    assert_says(verlet, &[orders]);
    let midpoint = Integrator::new(Pendulums { s: S, m: 1.3 }, Weak2(Midpoint)).plan();
    assert_says(midpoint.formulas.action, &[" − h·|h|·K(t̄, q̄)/8"]);
    assert_eq!(midpoint.unknowns(), 2);
}

#[test]
fn additive_noise_has_no_term() {
    let (plain, corrected) = (
        Integrator::new(Additive, Midpoint),
        Integrator::new(Additive, Weak2(Midpoint)),
    );
    let verlets = (
        Integrator::new(Additive, StormerVerlet),
        Integrator::new(Additive, Weak2(StormerVerlet)),
    );
    assert_eq!(plain.plan().weak_order, 2);
    assert_eq!(corrected.plan().weak_order, 2);
    assert!(!corrected.plan().formulas.action.contains('K'));
    let mut random = Random::new(2);
    for _ in 0..20 {
        let (start, dw) = (point(&mut random), random.array(-0.3, 0.3));
        let (mut a, mut b, mut c, mut d) = (start, start, start, start);
        plain.step(&mut a, H, &dw).unwrap();
        corrected.step(&mut b, H, &dw).unwrap();
        verlets.0.step(&mut c, H, &dw).unwrap();
        verlets.1.step(&mut d, H, &dw).unwrap();
        assert_eq!((a, c), (b, d));
    }
}

/// Paths in lanes, single trajectories and repeated steps.
fn follow<S, R, const N: usize, const M: usize>(system: S, rule: R)
where
    S: Variational<R> + System<Dims = Dims<N, M>> + Sync,
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
        let noise = Wiener::new(8).path(path);
        let states = integrator.trajectory(start, 0.05, noise);
        let last = states.take(steps as usize).last().unwrap().unwrap();
        let expected = numbers(&last);
        close(&[end.q, end.p].concat(), &expected, 1e-12, "in a lane");
        let mut state = start;
        let mut source = Wiener::new(8).path(path);
        for step in 0..steps {
            let mut dw = [0.0; M];
            source.increments(step, 0.05, &mut dw).unwrap();
            integrator.step(&mut state, 0.05, &dw).unwrap();
        }
        close(&numbers(&state), &expected, 1e-14, "repeated steps");
    }
}

#[test]
fn ensembles_and_trajectories() {
    follow(Well { s: S, m: 1.3 }, Weak2(StormerVerlet));
    follow(Well { s: S, m: 1.3 }, Weak2(Midpoint));
    follow(Pendulums { s: S, m: 1.3 }, Weak2(Midpoint));
    follow(Pendulums { s: S, m: 1.3 }, Weak2(StormerVerlet));
}
