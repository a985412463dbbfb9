//! The mean energy of the linear oscillator against its exact recursion.
//!
//! A step is affine, `z₁ = A z₀ + b ΔW`, so the state is Gaussian with mean `Aⁿ z₀` and covariance `C₁ = A C₀ Aᵀ + h b bᵀ`. For a
//! Gaussian with mean m and covariance C, H = |z|²/2 has mean (|m|² + tr C)/2 and variance tr C²/2 + mᵀ C m.

use sve_models::models::Oscillator;
use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};

const H: f64 = 0.1;
const SIGMA: f64 = 1.0;
const PATHS: u64 = 20_000;

/// Mean and covariance.
pub(crate) type Gaussian = ([f64; 2], [[f64; 2]; 2]);

pub(crate) fn affine<R>(integrator: &Integrator<Oscillator, R>) -> ([[f64; 2]; 2], [f64; 2])
where
    Oscillator: Variational<R> + System<Dims = Dims<1, 1>>,
{
    let image = |q, p, dw| {
        let mut state = State::new([q], [p]);
        integrator.step(&mut state, H, &[dw]).unwrap();
        [state.q[0], state.p[0]]
    };
    let (x, y) = (image(1.0, 0.0, 0.0), image(0.0, 1.0, 0.0));
    ([[x[0], y[0]], [x[1], y[1]]], image(0.0, 0.0, 1.0))
}

pub(crate) fn after_a_step(a: &[[f64; 2]; 2], b: &[f64; 2], (m, c): Gaussian) -> Gaussian {
    let mut next = ([0.0; 2], [[0.0; 2]; 2]);
    for i in 0..2 {
        for j in 0..2 {
            next.0[i] += a[i][j] * m[j];
            next.1[i][j] = H * b[i] * b[j];
            for k in 0..2 {
                for l in 0..2 {
                    next.1[i][j] += a[i][k] * c[k][l] * a[j][l];
                }
            }
        }
    }
    next
}

fn energy((m, c): Gaussian) -> (f64, f64) {
    let mean = 0.5 * (m[0] * m[0] + m[1] * m[1] + c[0][0] + c[1][1]);
    let square = c[0][0] * c[0][0] + 2.0 * c[0][1] * c[1][0] + c[1][1] * c[1][1];
    let spread = (0..2).flat_map(|i| (0..2).map(move |j| m[i] * c[i][j] * m[j]));
    (mean, 0.5 * square + spread.sum::<f64>())
}

fn check<R: Sync>(rule: R, seed: u64)
where
    Oscillator: Variational<R> + System<Dims = Dims<1, 1>>,
{
    let integrator = Integrator::new(Oscillator { sigma: SIGMA }, rule);
    let summary = Ensemble::new(&integrator)
        .paths(PATHS)
        .seed(seed)
        .steps(H, 500)
        .record_every(50)
        .start(State::new([1.0], [0.0]))
        .observe("energy", Mechanics::hamiltonian)
        .run()
        .unwrap();
    let (a, b) = affine(&integrator);
    let mut exact: Gaussian = ([1.0, 0.0], [[0.0; 2]; 2]);
    let statistics = &summary["energy"];
    assert_eq!(summary.times().len(), 11);
    assert_eq!(statistics.mean()[0], 0.5);
    assert_eq!(statistics.variance()[0], 0.0);
    for record in 1..=10 {
        for _ in 0..50 {
            exact = after_a_step(&a, &b, exact);
        }
        let (mean, variance) = energy(exact);
        let error = (variance / PATHS as f64).sqrt();
        let z = (statistics.mean()[record] - mean) / error;
        assert!(z.abs() < 4.0, "record {record}: z = {z}");
        // four standard errors of a variance with the kurtosis of χ² with two degrees of freedom, 9
        let ratio = statistics.variance()[record] / variance;
        let bound = 4.0 * (8.0 / PATHS as f64).sqrt();
        assert!((ratio - 1.0).abs() < bound, "record {record}: {ratio}");
    }
}

#[test]
fn mean_energy_of_the_endpoint_rule() {
    check(Endpoint, 1);
}

#[test]
fn mean_energy_of_the_midpoint_rule() {
    check(Midpoint, 2);
}
