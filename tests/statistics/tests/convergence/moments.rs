//! The energy of the stochastic linear oscillator, as an expectation without sampling.
//!
//! A step is affine, `z₁ = A z₀ + b ΔW` (b holds σ). Its A and b are read off by steps from the unit
//! vectors and with ΔW = 1, and mean and covariance obey an exact recursion.

use sve_models::gaussian::{ENERGY, Linear, Scheme, linear};
use sve_models::models::Oscillator;
use sve_runtime::baseline::{BackwardEulerMaruyama, EulerMaruyama, Heun};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{Method, Variational};

const H: f64 = 0.1;
const OSCILLATOR: Oscillator = Oscillator { sigma: 1.0 };

/// `E[H]` after so many steps from (1, 0) with σ = 1: the recursion in 40-digit arithmetic for the
/// `f64` nearest to 0.1.
const STEPS: [usize; 3] = [100, 1000, 20_000];
const INITIAL_POINT: [f64; 3] = [
    5.498_433_996_767_539,
    50.651_649_400_242_32,
    1_003.025_792_097_544_5,
];
const ENDPOINT: [f64; 3] = [
    5.529_280_993_840_453,
    50.599_043_290_997_63,
    1_002.986_534_292_459_9,
];
const MIDPOINT: [f64; 3] = [
    5.487_531_172_069_826,
    50.375_311_720_698_26,
    998.006_234_414_165_1,
];
/// The energy of the forward method grows exponentially; its last value has six digits.
const FORWARD: [f64; 3] = [9.876_476_061_818_382, 115_270.356_007_975_24, 1.471_76e87];
/// The energy of the backward method settles where the exact one grows.
const BACKWARD: [f64; 3] = [3.336_299_544_518_964, 4.999_785_296_694_256, 5.0];

/// A step of linear systems must not depend on where it is read off: three units of rounding.
const SUPERPOSITION: f64 = 3.0 * f64::EPSILON;

/// The entries of A are rounded, half a unit each, which multiplies the moments by up to 1 + ε in
/// each of 20,000 steps.
const ROUNDING: [f64; 3] = [1e-12, 1e-12, 20_000.0 * f64::EPSILON];

/// Returns the step's matrix and its response to ΔW = 1.
fn affine(method: &impl Method<System = Oscillator>) -> Linear<2> {
    let (a, b) = linear(method, H).unwrap();
    let image = |q: f64, p: f64, dw: f64| {
        let mut state = State::new([q], [p]);
        method.step(&mut state, H, &[dw]).unwrap();
        [state.q[0], state.p[0]]
    };
    assert_eq!(image(0.0, 0.0, 0.0), [0.0, 0.0]);
    let z = image(0.3, -0.8, 0.6);
    for i in 0..2 {
        let sum = 0.3 * a[i][0] - 0.8 * a[i][1] + 0.6 * b[i];
        assert!((z[i] - sum).abs() <= SUPERPOSITION, "not affine: {z:?}");
    }
    (a, b)
}

/// Compares `E[H]` with a table.
fn check(method: &impl Method<System = Oscillator>, table: [f64; 3], bounds: [f64; 3]) {
    let scheme = Scheme::driven(affine(method), H);
    for ((steps, expected), bound) in STEPS.into_iter().zip(table).zip(bounds) {
        let (energy, _) = scheme.after([1.0, 0.0], steps).quadratic(&ENERGY);
        let error = (energy / expected - 1.0).abs();
        assert!(error < bound, "{steps} steps: {energy}, not {expected}");
    }
}

/// Compares `E[H]` with a table, and the determinant of A with 1.
fn check_rule<R>(rule: R, table: [f64; 3])
where
    Oscillator: Variational<R> + System<Dims = Dims<1, 1>>,
{
    let integrator = Integrator::new(OSCILLATOR, rule);
    let (a, _) = affine(&integrator);
    let det = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    assert!((det - 1.0).abs() <= 2.0 * f64::EPSILON, "det A = {det}");
    check(&integrator, table, ROUNDING);
}

#[test]
fn symplectic_rules_follow_the_energy() {
    check_rule(InitialPoint, INITIAL_POINT);
    check_rule(Endpoint, ENDPOINT);
    check_rule(Midpoint, MIDPOINT);
}

#[test]
fn baselines_do_not_follow_the_energy() {
    let six_digits = 0.5e-5 / 1.471_76;
    check(
        &EulerMaruyama::new(OSCILLATOR),
        FORWARD,
        [1e-12, 1e-12, six_digits],
    );
    check(
        &BackwardEulerMaruyama::new(OSCILLATOR),
        BACKWARD,
        [1e-12; 3],
    );
    // |λ|² = (1 − h²/2)² + h² = 1 + h⁴/4 without noise
    let gain = |steps: usize| 0.5 * (1.0 + H.powi(4) / 4.0).powi(steps as i32);
    check(
        &Heun::new(Oscillator { sigma: 0.0 }),
        STEPS.map(gain),
        [1e-10; 3],
    );
}
