//! The energy of the stochastic linear oscillator, as an expectation without sampling.
//!
//! The generated step is affine, `z₁ = A z₀ + b ΔW` (b holds σ). Its A and b are read off by steps
//! from the unit vectors and with ΔW = 1, and the second moments then obey `M₁ = A M₀ Aᵀ + h b bᵀ`
//! exactly.

use sve_models::models::Oscillator;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

const H: f64 = 0.1;

/// `E[H]` after so many steps from (1, 0) with σ = 1: the recursion in 40-digit arithmetic for the
/// `f64` nearest to 0.1.
const STEPS: [u32; 3] = [100, 1000, 20_000];
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

/// A step of linear systems must not depend on where it is read off: three units of rounding.
const SUPERPOSITION: f64 = 3.0 * f64::EPSILON;

/// The step's matrix and its response to ΔW = 1.
fn affine<R>(integrator: &Integrator<Oscillator, R>) -> ([[f64; 2]; 2], [f64; 2])
where
    Oscillator: Variational<R> + System<Dims = Dims<1, 1>>,
{
    let image = |q: f64, p: f64, dw: f64| {
        let mut state = State::new([q], [p]);
        integrator.step(&mut state, H, &[dw]).unwrap();
        [state.q[0], state.p[0]]
    };
    let (x, y, b) = (
        image(1.0, 0.0, 0.0),
        image(0.0, 1.0, 0.0),
        image(0.0, 0.0, 1.0),
    );
    assert_eq!(image(0.0, 0.0, 0.0), [0.0, 0.0]);
    let z = image(0.3, -0.8, 0.6);
    for i in 0..2 {
        let sum = 0.3 * x[i] - 0.8 * y[i] + 0.6 * b[i];
        assert!((z[i] - sum).abs() <= SUPERPOSITION, "not affine: {z:?}");
    }
    ([[x[0], y[0]], [x[1], y[1]]], b)
}

/// Compares `E[H]` with the table to 1e-12, and to nε after 20,000 steps: the entries of A are
/// rounded, half a unit each, which multiplies the moments by up to 1 + ε in each step.
fn check<R>(rule: R, table: [f64; 3])
where
    Oscillator: Variational<R> + System<Dims = Dims<1, 1>>,
{
    let integrator = Integrator::new(Oscillator { sigma: 1.0 }, rule);
    let (a, b) = affine(&integrator);

    let det = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    assert!((det - 1.0).abs() <= 2.0 * f64::EPSILON, "det A = {det}");

    let mut m = [[1.0, 0.0], [0.0, 0.0]];
    let mut step = 0;
    for (steps, expected) in STEPS.into_iter().zip(table) {
        while step < steps {
            m = recursion(&a, &b, &m);
            step += 1;
        }
        let energy = 0.5 * (m[0][0] + m[1][1]);
        let error = (energy / expected - 1.0).abs();
        println!("{} {steps}: {energy} {error:e}", integrator.plan().rule);
        let bound = (f64::from(steps) * f64::EPSILON).max(1e-12);
        assert!(error < bound, "{steps} steps: {energy}, not {expected}");
    }
}

/// `A M Aᵀ + h b bᵀ`.
fn recursion(a: &[[f64; 2]; 2], b: &[f64; 2], m: &[[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let mut next = [[0.0; 2]; 2];
    for i in 0..2 {
        for j in 0..2 {
            next[i][j] = H * b[i] * b[j];
            for k in 0..2 {
                for l in 0..2 {
                    next[i][j] += a[i][k] * m[k][l] * a[j][l];
                }
            }
        }
    }
    next
}

#[test]
fn initial_point() {
    check(InitialPoint, INITIAL_POINT);
}

#[test]
fn endpoint() {
    check(Endpoint, ENDPOINT);
}

#[test]
fn midpoint() {
    check(Midpoint, MIDPOINT);
}
