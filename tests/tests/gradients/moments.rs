//! Gradients of means against exact moments of the discrete maps and their derivatives.

use sve_models::differences::derivative;
use sve_models::gaussian::{Linear, Scheme};
use sve_models::models::Kubo;
use sve_runtime::prelude::*;

pub(crate) const H: f64 = 0.1;
const PATHS: u64 = 20_000;

/// An oscillator that is pushed at random.
pub(crate) struct Pushed {
    pub(crate) k: f64,
    pub(crate) sigma: f64,
}

#[variational(endpoint, midpoint)]
impl Pushed {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * self.k * q * q
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

/// q₁ = q₀ + hp₀, p₁ = p₀ − hkq₁ + σ ΔW.
pub(crate) fn endpoint(k: f64, sigma: f64) -> Linear<2> {
    ([[1.0, H], [-H * k, 1.0 - H * H * k]], [0.0, sigma])
}

/// (q₁ − q₀)/h = (p₀ + p₁)/2, p₁ − p₀ = −hk(q₀ + q₁)/2 + σ ΔW.
fn midpoint(k: f64, sigma: f64) -> Linear<2> {
    let x = 0.25 * H * H * k;
    let scale = 1.0 / (1.0 + x);
    let a = [[1.0 - x, H], [-H * k, 1.0 - x]];
    (
        a.map(|row| row.map(|a| scale * a)),
        [0.5 * H * sigma * scale, sigma * scale],
    )
}

/// E q and E q² after some steps from (1, ½).
pub(crate) fn moments(step: Linear<2>, steps: usize) -> [f64; 2] {
    let law = Scheme::driven(step, H).after([1.0, 0.5], steps);
    let mean = law.mean[0];
    [mean, law.covariance[0][0] + mean * mean]
}

macro_rules! oscillator {
    ($rule:expr, $step:ident, $seed:literal) => {{
        let (k, sigma) = (1.2, 0.6);
        let integrator = Integrator::new(Pushed { k, sigma }, $rule);
        let summary = Ensemble::new(&integrator)
            .paths(PATHS)
            .seed($seed)
            .steps(H, 40)
            .every(10)
            .start(State::new([1.0], [0.5]))
            .gradient("q", ["k", "sigma"], |s| s.q[0])
            .gradient("q²", ["k", "sigma"], |s| s.q[0].powi(2))
            .run()
            .unwrap();
        for record in 1..=4 {
            let at = |k, sigma| moments($step(k, sigma), 10 * record);
            for (number, name) in ["q", "q²"].into_iter().enumerate() {
                let by_k = derivative(|d| at(k + d, sigma)[number]);
                let by_sigma = derivative(|d| at(k, sigma + d)[number]);
                for (by, expected) in [("k", by_k), ("sigma", by_sigma)] {
                    let found = summary.derivative(name, by).unwrap();
                    let error = found.standard_error()[record];
                    // differences and rounding beside the error of the sample
                    let bound = 4.5 * error + 1e-9;
                    let off = found.mean()[record] - expected;
                    assert!(off.abs() < bound, "∂{name}/∂{by}: {off} ± {error}");
                    assert!(error < 0.05 * (1.0 + expected.abs()), "{error} {expected}");
                }
            }
        }
        // q is affine in the noise, so its derivative by k is not random where there is none
        let error = summary.derivative("q", "sigma").unwrap().standard_error();
        assert!(error[4] > 1e-3);
    }};
}

#[test]
fn linear_oscillator_by_the_endpoint_rule() {
    oscillator!(Endpoint, endpoint, 1);
}

#[test]
fn linear_oscillator_by_the_midpoint_rule() {
    oscillator!(Midpoint, midpoint, 2);
}

/// The mean of q + ip after some steps: that of a step's factor (1 − iθ/2)/(1 + iθ/2), θ = ah + σ
/// ΔW, to this power, times the start.
fn kubo_mean(a: f64, sigma: f64, steps: i32) -> f64 {
    let (mut sum, mut weights) = ([0.0; 2], 0.0);
    for i in -900..=900 {
        let z = 0.01 * f64::from(i);
        let weight = (-0.5 * z * z).exp();
        let half = 0.5 * (a * H + sigma * H.sqrt() * z);
        let angle = -2.0 * half.atan();
        weights += weight;
        sum[0] += weight * angle.cos();
        sum[1] += weight * angle.sin();
    }
    let [re, im] = sum.map(|s| s / weights);
    let (size, angle) = (re.hypot(im).powi(steps), f64::from(steps) * im.atan2(re));
    // the start is 1 + i/2
    size * (angle.cos() - 0.5 * angle.sin())
}

#[test]
fn kubo_oscillator() {
    let (a, sigma) = (1.0, 0.5);
    let integrator = Integrator::new(Kubo { a, sigma }, Midpoint);
    let summary = Ensemble::new(&integrator)
        .paths(PATHS)
        .seed(3)
        .steps(H, 30)
        .start(State::new([1.0], [0.5]))
        .gradient("q", ["a", "sigma"], |s| s.q[0])
        .run()
        .unwrap();
    let by_a = derivative(|d| kubo_mean(a + d, sigma, 30));
    let by_sigma = derivative(|d| kubo_mean(a, sigma + d, 30));
    let value = kubo_mean(a, sigma, 30);
    let q = &summary["q"];
    assert!((q.mean()[1] - value).abs() < 4.5 * q.standard_error()[1]);
    for (by, expected) in [("a", by_a), ("sigma", by_sigma)] {
        let found = summary.derivative("q", by).unwrap();
        let (off, error) = (found.mean()[1] - expected, found.standard_error()[1]);
        assert!(off.abs() < 4.5 * error, "∂q/∂{by}: {off} ± {error}");
        assert!(error < 0.02, "{error}");
    }
}
