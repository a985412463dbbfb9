//! Gradients of means beside plain ensembles: `cargo bench -p sve-runtime --features
//! ensemble --bench gradients`. `-- kubo` selects the systems whose names contain `kubo`.
//!
//! Prints nanoseconds a trajectory-step of a plain ensemble, and the times of the same ensemble
//! with gradients by one, two and four quantities as multiples of it: with tangent vectors in
//! lanes, and with tangent vectors of one state after the other. Then the times of gradients along
//! single paths, as multiples of the steps. All are medians of runs that alternate between the
//! sides.

mod alone;
mod along;

use std::hint::black_box;
use std::time::Instant;

use sve_runtime::ensemble::By;
use sve_runtime::prelude::*;

use alone::Alone;

/// Number of paths of a run.
const PATHS: u64 = 1024;
/// Number of steps of a path.
const STEPS: u64 = 500;
/// Step size.
const H: f64 = 0.05;
/// Number of alternating runs.
const ROUNDS: usize = 15;

#[derive(Debug)]
struct Linear {
    k: f64,
    sigma: f64,
}

#[variational(endpoint)]
impl Linear {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * self.k * q * q
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

#[derive(Debug)]
struct Kubo {
    a: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v / self.a - 0.5 * self.a * q * q
    }
    #[h1]
    fn stir(&self, q: f64, p: f64) -> f64 {
        0.5 * self.sigma * (q * q + p * p)
    }
}

#[derive(Debug)]
struct Pendulum {
    g: f64,
    sigma: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q.sin()
    }
}

/// A double pendulum of two equal rods, whose mass matrix depends on the angles.
#[derive(Debug)]
struct Double {
    g: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Double {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        v[0] * v[0]
            + 0.5 * v[1] * v[1]
            + v[0] * v[1] * (q[0] - q[1]).cos()
            + self.g * (2.0 * q[0].cos() + q[1].cos())
    }
    #[gamma]
    fn push(&self, q: [f64; 2]) -> f64 {
        self.sigma * q[1]
    }
}

/// Runs an ensemble with gradients by some quantities, or without gradients.
macro_rules! run {
    ($method:expr, $start:expr, $by:expr) => {{
        let ensemble = Ensemble::new($method)
            .paths(PATHS)
            .threads(1)
            .seed(1)
            .steps(H, STEPS)
            .start($start);
        let ensemble = if $by.is_empty() {
            ensemble.observe("q", |_, s| s.q[0])
        } else {
            ensemble.gradient("q", $by.iter().cloned(), |s| s.q[0])
        };
        let summary = ensemble.run().expect("a summary");
        assert_eq!(summary.failed(), 0);
        black_box(summary["q"].mean()[1]);
    }};
}

/// Returns the seconds of a run.
fn seconds(run: impl FnOnce()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64()
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

macro_rules! task {
    ($filter:expr, $name:literal, $method:expr, $start:expr, $names:expr) => {
        if $filter.is_none_or(|word| $name.contains(word)) {
            let (lanes, alone) = ($method, Alone($method));
            let all = [$names[0].into(), $names[1].into(), By::q(0), By::p(0)];
            let sides = [0, 1, 2, 4];
            let mut times = vec![Vec::new(); 2 * sides.len()];
            for _ in 0..ROUNDS {
                for (side, &count) in sides.iter().enumerate() {
                    let by: &[By] = &all[..count];
                    times[2 * side].push(seconds(|| run!(&lanes, $start, by)));
                    times[2 * side + 1].push(seconds(|| run!(&alone, $start, by)));
                }
            }
            let medians: Vec<f64> = times.into_iter().map(median).collect();
            let plain = medians[0];
            print!(
                "{:28} {:7.2} ns",
                $name,
                1e9 * plain / (PATHS * STEPS) as f64
            );
            for side in 1..sides.len() {
                let [lanes, alone] = [medians[2 * side] / plain, medians[2 * side + 1] / plain];
                print!(" | {}: {lanes:5.2} lanes {alone:6.2} alone", sides[side]);
            }
            println!();
        }
    };
}

fn main() {
    let filter: Option<String> = std::env::args().skip(1).find(|word| !word.starts_with('-'));
    let filter = filter.as_deref();
    let linear = || Integrator::new(Linear { k: 1.0, sigma: 0.5 }, Endpoint);
    let start = State::new([1.0], [0.0]);
    task!(filter, "linear, endpoint", linear(), start, ["k", "sigma"]);
    let kubo = || Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint);
    task!(filter, "kubo, midpoint", kubo(), start, ["a", "sigma"]);
    let pendulum = || Pendulum { g: 1.0, sigma: 0.2 };
    let midpoint = || Integrator::new(pendulum(), Midpoint);
    task!(
        filter,
        "pendulum, midpoint",
        midpoint(),
        start,
        ["g", "sigma"]
    );
    let verlet = || Integrator::new(pendulum(), StormerVerlet);
    task!(
        filter,
        "pendulum, stormer_verlet",
        verlet(),
        start,
        ["g", "sigma"]
    );
    let double = || Integrator::new(Double { g: 1.0, sigma: 0.2 }, Midpoint);
    let start = State::new([1.0, 0.5], [0.0, 0.0]);
    task!(
        filter,
        "double pendulum, midpoint",
        double(),
        start,
        ["g", "sigma"]
    );
    along::run(filter);
}
