//! Baselines in ensembles: nanoseconds a step of one trajectory on one thread, beside single
//! trajectories.

use std::time::Instant;

use sve_runtime::baseline::{EulerMaruyama, Heun, RungeKutta4};
use sve_runtime::noise::Wiener;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::systems::{Coupled, DoublePendulum, HenonHeiles, Kubo, Polar, QuietPendulum};
use crate::{H, median};

const PATHS: u64 = 1024;
const STEPS: u64 = 200;
/// Number of alternating runs of each side.
const RUNS: usize = 11;

fn compare<I, S, const N: usize, const M: usize>(name: &str, method: &I, start: State<[f64; N]>)
where
    I: Method<System = S, Increments = [f64; M]> + Sync,
    S: System<Dims = Dims<N, M>>,
{
    let ns = 1e9 / (PATHS * STEPS) as f64;
    let ensemble = || {
        let begin = Instant::now();
        let ensemble = Ensemble::new(method).paths(PATHS).steps(H, STEPS);
        let ensemble = ensemble.seed(1).start(start).observe("q", |_, s| s.q[0]);
        ensemble.run().expect("a run");
        begin.elapsed().as_secs_f64() * ns
    };
    let single = || {
        let begin = Instant::now();
        let mut sum = 0.0;
        for path in 0..PATHS {
            let noise = Wiener::new(1).path(path);
            let steps = method.trajectory(start, H, noise).take(STEPS as usize);
            sum += steps.last().expect("steps").expect("a step").q[0];
        }
        std::hint::black_box(sum);
        begin.elapsed().as_secs_f64() * ns
    };
    let (lanes, single): (Vec<f64>, Vec<f64>) = (0..RUNS).map(|_| (ensemble(), single())).unzip();
    let (lanes, single) = (median(lanes), median(single));
    println!(
        "{name:32} {lanes:8.2} ns {single:8.2} ns   ratio {:.2}",
        lanes / single
    );
}

pub(crate) fn table() {
    println!("\n{:32} {:>11} {:>11}", "", "ensemble", "single");
    let (sigma, g) = (0.05, 1.0);
    let kubo = Kubo { a: 1.0, sigma: 0.3 };
    let start = State::new([1.0], [0.0]);
    compare("Kubo, Heun", &Heun::new(&kubo), start);
    compare("Kubo, Euler–Maruyama", &EulerMaruyama::new(&kubo), start);
    let start = State::new([0.0, 0.1], [0.3, 0.0]);
    let henon = HenonHeiles { sigma };
    compare("Hénon–Heiles, Heun", &Heun::new(&henon), start);
    let (m, c, k) = ([2.0, 1.5], 0.4, 1.2);
    compare(
        "coupled masses, Heun",
        &Heun::new(Coupled { m, c, k, sigma }),
        start,
    );
    let start = State::new([1.0, 0.1], [0.3, 1.2]);
    let (m, k) = (1.3, 0.8);
    compare("polar, Heun", &Heun::new(Polar { m, k, sigma }), start);
    let start = State::new([0.4, 0.1], [0.3, 0.2]);
    let double = DoublePendulum { g, sigma };
    compare("double pendulum, Heun", &Heun::new(&double), start);
    let quiet = RungeKutta4::new(QuietPendulum { g });
    compare("double pendulum, Runge–Kutta", &quiet, start);
}
