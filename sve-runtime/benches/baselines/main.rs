//! Baselines against loops written by hand: `cargo bench -p sve-runtime --bench baselines`.
//!
//! Both sides make the same steps with the same increments. The table has the medians of runs that alternate between the two sides. A work–precision figure is fair to the
//! baselines if the ratios are near 1.

use std::hint::black_box;
use std::time::Instant;

use sve_runtime::baseline::{EulerMaruyama, Heun};
use sve_runtime::noise::Wiener;
use sve_runtime::prelude::*;
use sve_runtime::{Dims, System};

const STEPS: usize = 2000;
const H: f64 = 0.01;
/// Alternating runs of each side.
const RUNS: usize = 61;

struct Kubo {
    a: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v * v / (2.0 * self.a) - 0.5 * self.a * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        0.5 * self.sigma * (q * q + p * p)
    }
}

struct HenonHeiles {
    sigma: f64,
}

#[variational(midpoint)]
impl HenonHeiles {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (x * x + y * y) - x * x * y + y * y * y / 3.0
    }

    #[gamma]
    fn push(&self, q: [f64; 2]) -> f64 {
        self.sigma * q[0] * q[1]
    }
}

/// The field of a system by hand, for an increment of time and one of the noise.
trait Field<const D: usize>: Copy {
    /// h f(z) + g(z) ΔW, in the sense of Stratonovich.
    fn euler(self, z: [f64; D], h: f64, dw: f64) -> [f64; D];
    /// The Itô correction, times h.
    fn correction(self, z: [f64; D], h: f64) -> [f64; D];
}

#[derive(Clone, Copy)]
struct KuboByHand {
    a: f64,
    sigma: f64,
}

impl Field<2> for KuboByHand {
    #[inline(always)]
    fn euler(self, [q, p]: [f64; 2], h: f64, dw: f64) -> [f64; 2] {
        let x = self.a * h + self.sigma * dw;
        [x * p, -x * q]
    }

    #[inline(always)]
    fn correction(self, [q, p]: [f64; 2], h: f64) -> [f64; 2] {
        let c = -0.5 * self.sigma * self.sigma * h;
        [c * q, c * p]
    }
}

#[derive(Clone, Copy)]
struct HenonHeilesByHand {
    sigma: f64,
}

impl Field<4> for HenonHeilesByHand {
    #[inline(always)]
    fn euler(self, [x, y, u, w]: [f64; 4], h: f64, dw: f64) -> [f64; 4] {
        let s = self.sigma * dw;
        [
            h * u,
            h * w,
            h * (-x - 2.0 * x * y) + s * y,
            h * (y * y - y - x * x) + s * x,
        ]
    }

    #[inline(always)]
    fn correction(self, _: [f64; 4], _: f64) -> [f64; 4] {
        [0.0; 4]
    }
}

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
fn compare<I, S, const N: usize, const D: usize>(
    name: &str,
    method: &I,
    start: State<[f64; N]>,
    by_hand: impl Fn(&mut [f64; D], f64),
) where
    I: Method<System = S, Increments = [f64; 1]>,
    S: System<Dims = Dims<N, 1>>,
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
                let made = method.step_prepared(&prepared, &mut state, H, &[*dw]);
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

fn main() {
    println!("{:32} {:>11} {:>11}", "", "baseline", "by hand");
    let (a, sigma) = (black_box(1.0), black_box(0.3));
    let (field, start) = (KuboByHand { a, sigma }, State::new([1.0], [0.0]));
    let kubo = Kubo { a, sigma };
    compare("Kubo, Heun", &Heun::new(&kubo), start, |z, dw| {
        heun(field, z, H, dw)
    });
    compare(
        "Kubo, Euler–Maruyama",
        &EulerMaruyama::new(&kubo),
        start,
        |z, dw| {
            euler_maruyama(field, z, H, dw);
        },
    );
    let sigma = black_box(0.05);
    let (field, start) = (
        HenonHeilesByHand { sigma },
        State::new([0.0, 0.1], [0.3, 0.0]),
    );
    let system = HenonHeiles { sigma };
    compare(
        "Hénon–Heiles, Heun",
        &Heun::new(&system),
        start,
        |z, dw| heun(field, z, H, dw),
    );
    compare(
        "Hénon–Heiles, Euler–Maruyama",
        &EulerMaruyama::new(&system),
        start,
        |z, dw| {
            euler_maruyama(field, z, H, dw);
        },
    );
}
