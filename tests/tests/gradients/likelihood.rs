//! Derivatives of probabilities by likelihood ratios, as the guide writes them with an observer
//! that remembers, against exact values.

use sve_models::differences::derivative;
use sve_runtime::prelude::*;

use crate::moments::{H, Pushed, endpoint, moments};

const STEPS: u64 = 20;
const LEVEL: f64 = 0.3;

/// Returns P(x > a) of a normal variable.
fn tail([mean, second]: [f64; 2], a: f64) -> f64 {
    let deviation = (second - mean * mean).sqrt();
    // Simpson's rule from the level to ten standard deviations beyond the mean
    let (low, high, pieces) = ((a - mean) / deviation, 10.0, 4000);
    let width = (high - low) / f64::from(pieces);
    let density = |i: i32| (-0.5 * (low + width * f64::from(i)).powi(2)).exp();
    let weight = |i: i32| match i {
        0 => 1.0,
        i if i == pieces => 1.0,
        i if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let sum: f64 = (0..=pieces).map(|i| weight(i) * density(i)).sum();
    sum * width / 3.0 / core::f64::consts::TAU.sqrt()
}

/// The memory of a path: its last state, and the derivative of the logarithm of its
/// density.
struct Path {
    last: State<[f64; 1]>,
    by_k: f64,
    by_sigma: f64,
}

#[test]
fn probabilities_by_likelihood_ratios() {
    let (k, sigma) = (1.2, 0.6);
    let integrator = Integrator::new(Pushed { k, sigma }, Endpoint);
    let begin = |_: &Pushed, start: &State<[f64; 1]>| Path {
        last: *start,
        by_k: 0.0,
        by_sigma: 0.0,
    };
    // p₁ = p₀ − hkq₁ + σ ΔW is normal with variance σ²h
    let update = |path: &mut Path, system: &Pushed, state: &State<[f64; 1]>| {
        let dw = (state.p[0] - path.last.p[0] + H * system.k * state.q[0]) / system.sigma;
        path.by_k -= dw * state.q[0] / system.sigma;
        path.by_sigma += (dw * dw / H - 1.0) / system.sigma;
        path.last = *state;
    };
    let is_above = |path: &Path| f64::from(u8::from(path.last.q[0] > LEVEL));
    let summary = Ensemble::new(&integrator)
        .paths(50_000)
        .seed(6)
        .steps(H, STEPS)
        .start(State::new([1.0], [0.5]))
        .observe("above", |_, s| f64::from(u8::from(s.q[0] > LEVEL)))
        .fold("by k", begin, update, |path| is_above(path) * path.by_k)
        .fold("by sigma", begin, update, |path| {
            is_above(path) * path.by_sigma
        })
        .run()
        .unwrap();
    let exact = |k, sigma| tail(moments(endpoint(k, sigma), STEPS as usize), LEVEL);
    let check = |name: &str, expected: f64| {
        let found = &summary[name];
        let (off, error) = (found.mean()[1] - expected, found.standard_error()[1]);
        assert!(
            off.abs() < 4.5 * error,
            "{name}: {off} ± {error} from {expected}"
        );
        assert!(error < 0.1 * expected.abs(), "{name}: {error} {expected}");
    };
    check("above", exact(k, sigma));
    check("by k", derivative(|d| exact(k + d, sigma)));
    check("by sigma", derivative(|d| exact(k, sigma + d)));
}
