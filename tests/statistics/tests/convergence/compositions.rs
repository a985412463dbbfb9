//! Compositions and splittings with noise of strength σ: their error on paths is O(hʳ + σh). So the strong order is 1, and the order r shows where noise is weak.

use sve_models::oracle::synchrotron;
use sve_runtime::prelude::*;
use sve_runtime::{Dims, StrongOrder, System, Variational};

use super::strong_order::{Path, distance2, measure, record, run, with_fine_reference};

/// Standard errors of the fitted slope within which the order has to be.
const SIGMAS: f64 = 4.0;

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

/// Measures the strong order of a method, and compares it with that of the plan.
fn has_order_one<S, R, const N: usize, const M: usize>(
    system: S,
    rule: R,
    start: State<[f64; N]>,
    path: impl Fn(u64) -> Path<N>,
) where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let method = Integrator::new(system, rule);
    let plan = method.plan();
    assert_eq!(plan.strong_order, StrongOrder::One);
    let composition = plan.substeps.expect("a composition").composition;
    let name = format!("{} by {}, {composition}", plan.system, plan.rule);
    let (order, error) = measure(path, |path| run(&method, start, path));
    println!("| {name} | 1 | {order:.3} ± {error:.3} |");
    assert!(
        (order - 1.0).abs() < SIGMAS * error,
        "{name}: {order} ± {error}"
    );
}

#[test]
fn noise_in_position() {
    let system = synchrotron();
    let start = State::new([0.5], [0.8]);
    let path = with_fine_reference(&system, start);
    has_order_one(
        &system,
        Composed::new(StormerVerlet, KahanLi8),
        start,
        &path,
    );
    has_order_one(&system, Composed::new(Midpoint, KahanLi8), start, &path);
    has_order_one(&system, Split::new(BlanesMoan4), start, &path);
    has_order_one(&system, Split::new(BlanesMoanRkn6), start, &path);
}

#[test]
fn noise_in_position_and_momentum() {
    let system = Turned { sigma: 0.5 };
    let start = State::new([1.0], [0.3]);
    let path = with_fine_reference(&system, start);
    has_order_one(
        &system,
        Composed::new(StormerVerlet, KahanLi8),
        start,
        &path,
    );
    has_order_one(&system, Composed::new(Midpoint, KahanLi8), start, &path);
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
    let paths = 40;
    let square = |path| {
        let increments = record(path, 1, 10);
        let exact = run(&fine, start, &increments);
        let coarse = increments.coarsen(128).unwrap();
        distance2(&run(&method, start, &coarse), &exact)
    };
    ((0..paths).map(square).sum::<f64>() / paths as f64).sqrt()
}

/// Checks that the error without noise is far below the given one, and that the error with noise is in proportion to its strength while it is above that without.
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
