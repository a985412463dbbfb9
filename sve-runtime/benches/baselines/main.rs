//! Baselines against loops written by hand: `cargo bench -p sve-runtime --bench baselines`.
//!
//! Both sides make the same steps with the same increments. The table has the medians of runs that
//! alternate between the two sides. A work–precision figure is fair to the baselines if the ratios
//! are near 1. With the feature `ensemble` a second table compares ensembles with single
//! trajectories.

#[cfg(feature = "ensemble")]
mod ensembles;
mod systems;

use std::hint::black_box;
use std::time::Instant;

use sve_runtime::baseline::{EulerMaruyama, Heun, RungeKutta4};
use sve_runtime::noise::Wiener;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use systems::{
    Coupled, CoupledByHand, DoublePendulum, DoublePendulumByHand, Field, HenonHeiles,
    HenonHeilesByHand, Kubo, KuboByHand, Polar, PolarByHand, QuietPendulum,
};

const STEPS: usize = 2000;
const H: f64 = 0.01;
/// Number of alternating runs of each side.
const RUNS: usize = 61;

#[inline(always)]
fn heun<const D: usize>(field: impl Field<D>, z: &mut [f64; D], h: f64, dw: f64) {
    let first = field.euler(*z, h, dw);
    let second = field.euler(core::array::from_fn(|i| z[i] + first[i]), h, dw);
    for i in 0..D {
        z[i] += 0.5 * (first[i] + second[i]);
    }
}

#[inline(always)]
fn euler_maruyama<const D: usize>(field: impl Field<D>, z: &mut [f64; D], h: f64, dw: f64) {
    let (step, correction) = (field.euler(*z, h, dw), field.correction(*z, h));
    for i in 0..D {
        z[i] += step[i] + correction[i];
    }
}

#[inline(always)]
fn runge_kutta4<const D: usize>(field: impl Field<D>, z: &mut [f64; D], h: f64) {
    let at = |scale: f64, k: [f64; D]| core::array::from_fn(|i| z[i] + scale * k[i]);
    let k1 = field.euler(*z, h, 0.0);
    let k2 = field.euler(at(0.5, k1), h, 0.0);
    let k3 = field.euler(at(0.5, k2), h, 0.0);
    let k4 = field.euler(at(1.0, k3), h, 0.0);
    for i in 0..D {
        z[i] += (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) * (1.0 / 6.0);
    }
}

/// Returns nanoseconds a step.
fn timed(mut run: impl FnMut()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64() * 1e9 / STEPS as f64
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Prints the ratio of a baseline to the loop by hand, and whether both end at the same state.
#[inline(never)]
fn compare<I, S, const N: usize, const D: usize, const M: usize>(
    name: &str,
    method: &I,
    start: State<[f64; N]>,
    by_hand: impl Fn(&mut [f64; D], f64),
) where
    I: Method<System = S, Increments = [f64; M]>,
    S: System<Dims = Dims<N, M>>,
{
    let path = Wiener::new(1);
    let dw: Vec<f64> = (0..STEPS as u64)
        .map(|step| path.increment(step, 0, H))
        .collect();
    let prepared = method.prepare(H).expect("a step size");
    let flat = |state: &State<[f64; N]>| -> [f64; D] {
        let mut all = state.q.iter().chain(&state.p);
        core::array::from_fn(|_| *all.next().expect("q and p"))
    };
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    let mut ends = ([0.0; D], [0.0; D]);
    for _ in 0..RUNS {
        ours.push(timed(|| {
            let mut state = black_box(start);
            for dw in &dw {
                let made = method.step_prepared(&prepared, &mut state, H, &[*dw; M]);
                made.expect("a step");
            }
            ends.0 = flat(&black_box(state));
        }));
        theirs.push(timed(|| {
            let mut z = black_box(flat(&start));
            for dw in &dw {
                by_hand(&mut z, *dw);
            }
            ends.1 = black_box(z);
        }));
    }
    let distance = (0..D)
        .map(|i| (ends.0[i] - ends.1[i]).abs())
        .fold(0.0, f64::max);
    assert!(distance < 1e-9, "{name}: the ends differ by {distance:e}");
    let (ours, theirs) = (median(ours), median(theirs));
    println!(
        "{name:32} {ours:8.2} ns {theirs:8.2} ns   ratio {:.2}",
        ours / theirs
    );
}

/// Compares Heun's method and the method of Euler and Maruyama on a system.
fn compare_both<S, const N: usize, const D: usize>(
    name: &str,
    system: &S,
    field: impl Field<D>,
    start: State<[f64; N]>,
) where
    S: System<Dims = Dims<N, 1>>,
{
    let both = |name_of_method: &str| format!("{name}, {name_of_method}");
    compare(&both("Heun"), &Heun::new(system), start, |z, dw| {
        heun(field, z, H, dw);
    });
    let method = EulerMaruyama::new(system);
    compare(&both("Euler–Maruyama"), &method, start, |z, dw| {
        euler_maruyama(field, z, H, dw);
    });
}

fn main() {
    println!("{:32} {:>11} {:>11}", "", "baseline", "by hand");
    let (a, sigma) = (black_box(1.0), black_box(0.3));
    let start = State::new([1.0], [0.0]);
    compare_both("Kubo", &Kubo { a, sigma }, KuboByHand { a, sigma }, start);
    let sigma = black_box(0.05);
    let (system, field) = (HenonHeiles { sigma }, HenonHeilesByHand { sigma });
    let start = State::new([0.0, 0.1], [0.3, 0.0]);
    compare_both("Hénon–Heiles", &system, field, start);
    let (m, c, k) = (black_box([2.0, 1.5]), black_box(0.4), black_box(1.2));
    let system = Coupled { m, c, k, sigma };
    compare_both(
        "coupled masses",
        &system,
        CoupledByHand::new(&system),
        start,
    );
    let (m, k) = (black_box(1.3), black_box(0.8));
    let system = Polar { m, k, sigma };
    let inverse = black_box(1.0 / m);
    let start = State::new([1.0, 0.1], [0.3, 1.2]);
    compare_both("polar", &system, PolarByHand { inverse, k, sigma }, start);
    let g = black_box(1.0);
    let field = DoublePendulumByHand { g, sigma };
    let system = DoublePendulum { g, sigma };
    let start = State::new([0.4, 0.1], [0.3, 0.2]);
    compare_both("double pendulum", &system, field, start);
    let method = RungeKutta4::new(QuietPendulum { g });
    compare("double pendulum, Runge–Kutta", &method, start, |z, _| {
        runge_kutta4(field, z, H);
    });
    #[cfg(feature = "ensemble")]
    ensembles::table();
}
