//! The rate of escape from a double well, on any number of ranks.
//!
//! Langevin dynamics in V = (q² − 1)² with friction ν = 2 and a barrier of 4 kT. Paths start in the
//! left well. The difference of the populations of the wells, d(t) = P(q < 0) − P(q > 0), finally
//! decays as exp(−λt). Rank 0 prints λ with its standard error beside the smallest eigenvalue above
//! 0 of the Fokker–Planck operator, and exits with status 1 if they differ by more than the
//! tolerance.
//!
//! ```sh
//! mpirun -n 4 cargo run --release --example escape
//! mpirun -n 4 cargo run --release --example escape -- --paths 100000000 --checkpoint escape.sve
//! ```
//!
//! 10⁵ paths take about 3 core-seconds and give λ to 1 %. 10⁸ paths take a core-hour and give it to
//! 0.03 %, less than the error of the step size, which is up to 0.2 %. `escape.slurm` in the same
//! folder is a batch script.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Parser;
use mpi::Threading;
use mpi::traits::Communicator as _;
use sve_runtime::prelude::*;

/// Computes the rate of escape from a double well on all ranks.
#[derive(Debug, Parser)]
struct Options {
    /// Number of paths
    #[arg(long, default_value_t = 100_000, value_parser = clap::value_parser!(u64).range(1000..))]
    paths: u64,
    /// Seed of the noise and the starts
    #[arg(long, default_value_t = 42)]
    seed: u64,
    /// Threads of each rank; by default as many as the cores that the rank may use
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    threads: Option<u32>,
    /// File from which a run that was stopped continues
    #[arg(long)]
    checkpoint: Option<PathBuf>,
    /// Minutes after which the run ends with the paths that it has, before a batch system ends it
    #[arg(long)]
    minutes: Option<u64>,
}

struct Well {
    /// Height of the barrier.
    a: f64,
    /// Rate of friction.
    nu: f64,
    /// Temperature times Boltzmann's constant.
    kt: f64,
}

#[variational(midpoint)]
impl Well {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - self.a * (q * q - 1.0).powi(2)
    }

    #[force]
    fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v
    }

    #[gamma]
    fn bath(&self, q: f64) -> f64 {
        (2.0 * self.nu * self.kt).sqrt() * q
    }
}

const WELL: Well = Well {
    a: 1.0,
    nu: 2.0,
    kt: 0.25,
};

/// λ of this well, computed by the example `ensemble` of sve from a continued fraction (Risken,
/// *The Fokker–Planck Equation*, chapter 10).
const LAMBDA: f64 = 9.688_884_559_620e-3;

const H: f64 = 0.05;

/// Steps between two records: one unit of time.
const EVERY: u64 = 20;

/// Records after which a path has come to rest in its well.
const REST: usize = 20;

/// Records until d has fallen to about 1/e.
const RECORDS: u64 = 123;

/// Largest difference from the exact result, in standard errors.
const STANDARD_ERRORS: f64 = 4.0;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let initialised = mpi::initialize_with_threading(Threading::Funneled);
    let (universe, _) = initialised.ok_or("MPI is initialised already")?;
    let world = universe.world();
    let options = Options::parse();
    let integrator = Integrator::new(WELL, Midpoint);
    let start = Instant::now();
    let limit = options
        .minutes
        .map(|minutes| Duration::from_secs(60 * minutes));
    let mut ensemble = Ensemble::new(&integrator)
        .paths(options.paths)
        .seed(options.seed)
        .steps(H, RECORDS * EVERY)
        .every(EVERY)
        .start(Starts::each(|_, rng| {
            State::new([-1.0], [WELL.kt.sqrt() * rng.normal()])
        }))
        .observe("left", |_, state| if state.q[0] < 0.0 { 1.0 } else { -1.0 })
        .first_passage("arrival", |_, state| state.q[0] - 1.0)
        .stop_on_failure(true)
        .stop_when(|| limit.is_some_and(|limit| start.elapsed() >= limit))
        .progress(true);
    if let Some(threads) = options.threads {
        ensemble = ensemble.threads(threads as usize);
    }
    if let Some(file) = options.checkpoint {
        ensemble = ensemble
            .checkpoint(file, Duration::from_secs(300))
            .resume(true);
    }
    let summary = sve_mpi::run(&ensemble, &world)?;
    if world.rank() != 0 {
        return Ok(ExitCode::SUCCESS);
    }
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{} of {} paths on {} ranks in {seconds:.2} s",
        summary.paths(),
        options.paths,
        world.size()
    );
    let (lambda, error) = decay(&summary);
    // The relative error of a frequency ω of the step is (ωh)²/12; the frequency of the well is
    // ω² = 8.
    let allowed = STANDARD_ERRORS * error + LAMBDA * 8.0 * H * H / 12.0;
    let is_right = (lambda - LAMBDA).abs() <= allowed;
    println!(
        "λ = {lambda:.6} ± {error:.6}; exact {LAMBDA:.6}, from which it may be off by {allowed:.6}"
    );
    let arrivals = summary.passage("arrival").ok_or("no passages")?.rate(REST);
    println!(
        "{} first arrivals at the bottom of the other well, {:.6} ± {:.6} per unit of time; λ/2 in the limit of a high barrier",
        arrivals.events, arrivals.value, arrivals.standard_error
    );
    println!("{}", if is_right { "ok" } else { "OFF" });
    Ok(if is_right {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// Returns λ from d at two times, d₂/d₁ = exp(−λ(t₂ − t₁)), and its standard error. A path is ±1 at
/// both times, with covariance exp(−λ(t₂ − t₁)) − d₁d₂.
fn decay(summary: &Summary) -> (f64, f64) {
    let (times, left, last) = (summary.times(), summary["left"].mean(), RECORDS as usize);
    let (d1, d2, time) = (left[REST], left[last], times[last] - times[REST]);
    let ratio = d2 / d1;
    let covariance = ratio - d1 * d2;
    let variance =
        (1.0 - d1 * d1) / (d1 * d1) + (1.0 - d2 * d2) / (d2 * d2) - 2.0 * covariance / (d1 * d2);
    (
        -ratio.ln() / time,
        (variance / summary.paths() as f64).sqrt() / time,
    )
}
