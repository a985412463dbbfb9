//! Compositions and splittings with noise of strength σ: their error on paths is O(hʳ + σh). So the
//! strong order is 1, and the order r shows where noise is weak.

use std::sync::LazyLock;

use sve_models::oracle::synchrotron;
use sve_models::orders::{Paths, Row, Tolerance, distance2, end};
use sve_runtime::Variational;
use sve_runtime::prelude::*;

use super::strong_order::{EXACT, FINE};

static PATHS: LazyLock<Paths> = LazyLock::new(|| Paths {
    tolerance: Tolerance {
        bias: 0.0,
        error: 0.03,
    },
    ..*FINE
});

/// A pendulum with noise in position, which does not commute with H.
#[derive(Clone, Debug)]
struct Shaken {
    sigma: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Shaken {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }

    #[gamma]
    fn shake(&self, q: f64) -> f64 {
        self.sigma * (2.0 * q).sin()
    }
}

/// A pendulum with noise in position and momentum, which does not commute with H.
#[derive(Clone, Debug)]
struct Turned {
    sigma: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Turned {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }

    #[h1]
    fn turn(&self, q: f64, p: f64) -> f64 {
        0.5 * self.sigma * (q * q + p * p)
    }
}

#[test]
fn noise_in_position() {
    let system = synchrotron();
    let start = State::new([0.5], [0.8]);
    let fine = Integrator::new(&system, Midpoint);
    let path = PATHS.against(2, |path| end(&fine, start, path));
    let rows = [
        Row::new(&system, Composed::new(StormerVerlet, KahanLi8), start),
        Row::new(&system, Composed::new(Midpoint, KahanLi8), start),
        Row::new(&system, Split::new(BlanesMoan4), start),
        Row::new(&system, Split::new(BlanesMoanRkn6), start),
    ];
    PATHS.check("γ = (σ₁ sin q, σ₂ cos q)", &rows, path);
}

#[test]
fn noise_in_position_and_momentum() {
    let system = Turned { sigma: 0.5 };
    let start = State::new([1.0], [0.3]);
    let fine = Integrator::new(&system, Midpoint);
    let path = PATHS.against(1, |path| end(&fine, start, path));
    let rows = [
        Row::new(&system, Composed::new(StormerVerlet, KahanLi8), start),
        Row::new(&system, Composed::new(Midpoint, KahanLi8), start),
    ];
    PATHS.check("H₁ = σI", &rows, path);
}

/// Root mean square over paths of the error at time 1 with 8 steps.
fn error<R: Copy>(rule: R, sigma: f64) -> f64
where
    Shaken: Variational<R>,
{
    let system = Shaken { sigma };
    let start = State::new([0.5], [0.8]);
    let fine = Integrator::new(&system, Composed::new(StormerVerlet, KahanLi8));
    let method = Integrator::new(&system, rule);
    let paths = 10;
    let square = |path| {
        let increments = EXACT.record(path, 1);
        let exact = end(&fine, start, &increments);
        let coarse = increments.coarsen(128).unwrap();
        distance2(&end(&method, start, &coarse), &exact)
    };
    ((0..paths).map(square).sum::<f64>() / paths as f64).sqrt()
}

/// Checks that the error without noise is far below the given one, and that the error with noise is
/// in proportion to its strength while it is above that without.
fn has_error_of_noise<R: Copy>(rule: R, noises: &[f64], of_low_order: f64)
where
    Shaken: Variational<R>,
{
    let quiet = error(rule, 0.0);
    let relative = noises.iter().map(|&sigma| error(rule, sigma) / sigma);
    let relative: Vec<f64> = relative.collect();
    println!("{quiet:e} without noise, {relative:?} times the noise");
    assert!(quiet < 1e-2 * of_low_order, "{quiet:e}, {of_low_order:e}");
    for (sigma, error) in noises.iter().zip(&relative) {
        assert!(quiet < 0.1 * error * sigma);
        assert!((error / relative[0] - 1.0).abs() < 0.1, "{relative:?}");
    }
}

#[test]
fn the_error_of_weak_noise_is_in_proportion_to_its_strength() {
    let plain = error(StormerVerlet, 0.0);
    let composed = Composed::new(StormerVerlet, KahanLi8);
    has_error_of_noise(composed, &[1e-2, 1e-4, 1e-6], plain);
    has_error_of_noise(Split::new(BlanesMoanRkn6), &[1e-2, 1e-4, 1e-6], plain);
    has_error_of_noise(Split::new(BlanesMoan4), &[1e-2, 1e-3], plain);
}
