//! The stochastic linear oscillator of figures 2 and 3: its schemes, their exact moments, and its
//! exact solution.
//!
//! A and b of a scheme `z₁ = A z₀ + b ΔW` are taken from its own steps, so the expectation belongs
//! to the code that ran.

use std::array::from_fn;

use sve_examples::figure::{Pen, Shape};
use sve_examples::gaussian::{Gaussian, Linear, Matrix, Scheme, linear};
use sve_examples::hues;
use sve_runtime::baseline::{BackwardEulerMaruyama, EulerMaruyama};
use sve_runtime::prelude::*;

use crate::run::{Run, run};
use crate::settings::H;
use crate::systems::Oscillator;

pub(crate) const OSCILLATOR: Oscillator = Oscillator { sigma: 1.0 };
/// Start of every run, `(q, p)`.
pub(crate) const START: [f64; 2] = [1.0, 0.0];

/// A scheme that figures 2 and 3 show.
pub(crate) struct Entry {
    pub(crate) name: &'static str,
    pub(crate) pen: Pen,
    pub(crate) scheme: Box<dyn Stepper>,
}

/// A method for the oscillator.
pub(crate) trait Stepper {
    /// Returns the run from [`START`] on a path.
    fn run(&self, path: &Wiener, steps: usize) -> Result<Run, StepError>;
    /// Returns A and b of one step.
    fn linear(&self) -> Result<Linear<2>, StepError>;
}

impl<I: Method<System = Oscillator>> Stepper for I {
    fn run(&self, path: &Wiener, steps: usize) -> Result<Run, StepError> {
        run(self, start(), H, *path, steps)
    }

    fn linear(&self) -> Result<Linear<2>, StepError> {
        linear(self, H)
    }
}

/// Returns the energy. It is infinite above the range of f64, which forward Euler–Maruyama reaches
/// in a very long run.
pub(crate) fn energy(state: &State<[f64; 1]>) -> Result<f64, StepError> {
    match OSCILLATOR.hamiltonian(state) {
        Err(StepError::NonFiniteResult { .. }) => Ok(f64::INFINITY),
        result => result,
    }
}

pub(crate) fn start() -> State<[f64; 1]> {
    State::new([START[0]], [START[1]])
}

/// Returns every scheme; the variational schemes come last.
pub(crate) fn entries() -> [Entry; 5] {
    let entry = |name, pen, scheme| Entry { name, pen, scheme };
    [
        entry(
            "forward Euler–Maruyama",
            Pen::dashed(hues::EULER_MARUYAMA, 1.6, (8.0, 3.0)),
            Box::new(EulerMaruyama::new(OSCILLATOR)) as Box<dyn Stepper>,
        ),
        entry(
            "backward Euler–Maruyama",
            Pen::line(hues::EULER_MARUYAMA, 1.4).symbols(Shape::Triangle, 8),
            Box::new(BackwardEulerMaruyama::new(OSCILLATOR)),
        ),
        entry(
            "midpoint rule",
            Pen::line(hues::MIDPOINT, 1.2).symbols(Shape::Cross, 13),
            Box::new(Integrator::new(OSCILLATOR, Midpoint)),
        ),
        entry(
            "initial-point rule",
            Pen::line(hues::INITIAL_POINT, 1.2).symbols(Shape::Square, 11),
            Box::new(Integrator::new(OSCILLATOR, InitialPoint)),
        ),
        entry(
            "endpoint rule",
            Pen::line(hues::ENDPOINT, 1.4).symbols(Shape::Circle, 9),
            Box::new(Integrator::new(OSCILLATOR, Endpoint)),
        ),
    ]
}

/// The exact step `z₁ = R z₀ + σ (∫ sin(h − s) dW, ∫ cos(h − s) dW)`, drawn jointly with ΔW.
pub(crate) struct Exact {
    r: Matrix<2>,
    /// Covariance of the two integrals.
    integrals: Matrix<2>,
    /// Covariance of the integrals with ΔW.
    with_dw: [f64; 2],
    /// The integrals are `slope ΔW + root (ξ₁, ξ₂)` with ξ independent of ΔW.
    slope: [f64; 2],
    root: [f64; 3],
}

impl Exact {
    pub(crate) fn new() -> Self {
        let (sin, cos) = H.sin_cos();
        let s = OSCILLATOR.sigma;
        let sin2 = (2.0 * H).sin();
        let cross = s * s * sin * sin / 2.0;
        let integrals = [
            [s * s * (H / 2.0 - sin2 / 4.0), cross],
            [cross, s * s * (H / 2.0 + sin2 / 4.0)],
        ];
        let with_dw = [s * 2.0 * (H / 2.0).sin().powi(2), s * sin];
        let slope = with_dw.map(|c| c / H);
        // The Cholesky factor of the part that ΔW does not determine. The cancellation leaves ten
        // digits at h = 0.1.
        let left: Matrix<2> = from_fn(|i| from_fn(|j| integrals[i][j] - slope[i] * with_dw[j]));
        let first = left[0][0].sqrt();
        let below = left[1][0] / first;
        let root = [first, below, (left[1][1] - below * below).max(0.0).sqrt()];
        Self {
            r: [[cos, sin], [-sin, cos]],
            integrals,
            with_dw,
            slope,
            root,
        }
    }

    /// Returns the exact solution on a path. Process 0 drives the schemes too; processes 1 and 2
    /// give the part that ΔW does not determine.
    pub(crate) fn run(&self, path: &Wiener, steps: usize) -> Run {
        let mut states = vec![start()];
        let mut z = START;
        for step in 0..steps {
            // The last two have variance 1.
            let draw = |process, variance| path.increment(step as u64, process, variance);
            let (dw, xi, eta) = (draw(0, H), draw(1, 1.0), draw(2, 1.0));
            let [first, below, second] = self.root;
            let added = [
                self.slope[0] * dw + first * xi,
                self.slope[1] * dw + below * xi + second * eta,
            ];
            z = from_fn(|i| self.r[i][0] * z[0] + self.r[i][1] * z[1] + added[i]);
            states.push(State::at((step + 1) as f64 * H, [z[0]], [z[1]]));
        }
        Run {
            states,
            overflow: None,
        }
    }

    /// Returns the exact solution as a map of distributions.
    pub(crate) fn moments(&self) -> Scheme<2> {
        Scheme {
            a: self.r,
            noise: self.integrals,
        }
    }

    /// Returns a scheme (components 0, 1) and the exact solution (2, 3) on the same path, as a map
    /// of distributions.
    pub(crate) fn beside(&self, (a, b): Linear<2>) -> Scheme<4> {
        let mut joint = Scheme {
            a: [[0.0; 4]; 4],
            noise: [[0.0; 4]; 4],
        };
        for i in 0..2 {
            for j in 0..2 {
                joint.a[i][j] = a[i][j];
                joint.a[2 + i][2 + j] = self.r[i][j];
                joint.noise[i][j] = H * b[i] * b[j];
                joint.noise[2 + i][2 + j] = self.integrals[i][j];
                joint.noise[i][2 + j] = b[i] * self.with_dw[j];
                joint.noise[2 + j][i] = b[i] * self.with_dw[j];
            }
        }
        joint
    }
}

/// Returns the distribution of `scheme − exact` from the joint distribution.
pub(crate) fn difference(joint: &Gaussian<4>) -> Gaussian<2> {
    let c = &joint.covariance;
    Gaussian {
        mean: from_fn(|i| joint.mean[i] - joint.mean[2 + i]),
        covariance: from_fn(|i| from_fn(|j| c[i][j] - c[i][2 + j] - c[2 + i][j] + c[2 + i][2 + j])),
    }
}
