//! The mean energy of the linear oscillator against its exact recursion.
//!
//! A step is affine, `z₁ = A z₀ + b ΔW`, so the state is Gaussian with mean `Aⁿ z₀` and covariance
//! `C₁ = A C₀ Aᵀ + h b bᵀ`. For a Gaussian with mean m and covariance C, H = |z|²/2 has mean (|m|²
//! + tr C)/2 and variance tr C²/2 + mᵀ C m.

use sve_models::checks::assert_within;
use sve_models::models::Oscillator;
use sve_models::stepper::Stepper;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::runs::oscillator;

const H: f64 = 0.1;
const PATHS: u64 = 20_000;

/// Mean and covariance.
pub(crate) type Gaussian = ([f64; 2], [[f64; 2]; 2]);

/// A step as an affine map of moments.
pub(crate) struct Affine {
    pub(crate) a: [[f64; 2]; 2],
    b: [f64; 2],
    h: f64,
}

impl Affine {
    /// The steps of length `h`.
    pub(crate) fn of<R>(integrator: &Integrator<Oscillator, R>, h: f64) -> Self
    where
        Oscillator: Variational<R> + System<Dims = Dims<1, 1>>,
    {
        let image = |q, p, dw| {
            let end = integrator.after(State::new([q], [p]), h, &[dw], 1);
            [end.q[0], end.p[0]]
        };
        let (x, y) = (image(1.0, 0.0, 0.0), image(0.0, 1.0, 0.0));
        let (a, b) = ([[x[0], y[0]], [x[1], y[1]]], image(0.0, 0.0, 1.0));
        Self { a, b, h }
    }

    /// The moments after a step.
    pub(crate) fn step(&self, (m, c): Gaussian) -> Gaussian {
        let Self { a, b, h } = self;
        let mut next = ([0.0; 2], [[0.0; 2]; 2]);
        for i in 0..2 {
            for j in 0..2 {
                next.0[i] += a[i][j] * m[j];
                next.1[i][j] = h * b[i] * b[j];
                for k in 0..2 {
                    for l in 0..2 {
                        next.1[i][j] += a[i][k] * c[k][l] * a[j][l];
                    }
                }
            }
        }
        next
    }

    /// The moments at the start and after each of so many steps from a place, at rest.
    pub(crate) fn from(&self, q: f64, steps: u64) -> Vec<Gaussian> {
        let mut all = vec![([q, 0.0], [[0.0; 2]; 2])];
        for _ in 0..steps {
            all.push(self.step(all[all.len() - 1]));
        }
        all
    }
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
    let integrator = oscillator(rule);
    let summary = Ensemble::new(&integrator)
        .paths(PATHS)
        .seed(seed)
        .steps(H, 500)
        .every(50)
        .start(State::new([1.0], [0.0]))
        .observe("energy", Mechanics::hamiltonian)
        .run()
        .unwrap();
    let exact = Affine::of(&integrator, H).from(1.0, 500);
    let statistics = &summary["energy"];
    assert_eq!(summary.times().len(), 11);
    assert_eq!(statistics.mean()[0], 0.5);
    assert_eq!(statistics.variance()[0], 0.0);
    for record in 1..=10 {
        let (mean, variance) = energy(exact[50 * record]);
        let row = format!("{}, record {record}", integrator.name());
        let error = (variance / PATHS as f64).sqrt();
        assert_within(statistics.mean()[record], mean, error, 4.0, &row);
        // the kurtosis of χ² with two degrees of freedom is 9
        let ratio = statistics.variance()[record] / variance;
        assert_within(ratio, 1.0, (8.0 / PATHS as f64).sqrt(), 4.0, &row);
    }
}

#[test]
fn mean_energies_are_exact() {
    check(Endpoint, 1);
    check(Midpoint, 2);
}
