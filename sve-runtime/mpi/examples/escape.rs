//! The rate of escape from a double well, on any number of ranks.
//!
//! Langevin dynamics in V = (q² − 1)² with friction ν = 2 and a barrier of 4 kT. Paths start in the left well and are stopped at the bottom of the
//! right one; the probability that a path is still on its way ends up as exp(−kt). Rank 0 prints λ = 2k with its standard error beside the smallest
//! eigenvalue above 0 of the Fokker–Planck operator, and exits with status 1 if they differ by more than they may.
//!
//! ```sh
//! mpirun -n 4 cargo run --release --example escape
//! mpirun -n 4 cargo run --release --example escape -- --paths 100000000 --checkpoint escape.sve
//! ```
//!
//! 10⁵ paths give λ to 0.5 %. 10⁸ paths take a core-hour or two and give it to 0.02 %, less than the error of the step
//! size, which is up to 0.2 %, and than the share of paths that return from the right well before they are at its bottom, up to 1 %.
//! `escape.slurm` in the same folder is a batch script.

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

/// λ of this well, computed by the example `ensemble` of sve from a continued fraction (Risken, *The Fokker–Planck Equation*, chapter 10).
const LAMBDA: f64 = 9.688_884_559_620e-3;

const H: f64 = 0.05;

/// Steps between two records: one unit of time.
const EVERY: u64 = 20;

/// Records after which a path has come to rest in its well.
const REST: usize = 20;

/// Records until half of the paths have escaped.
const RECORDS: u64 = 163;

/// Time within which a path that crossed the barrier is at the bottom of the right well.
const BOTTOM: f64 = 2.0;

/// Standard errors by which a correct result may be off.
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
        .record_every(EVERY)
        .start_with(|_, rng| State::new([-1.0], [WELL.kt.sqrt() * rng.normal()]))
        .stop_at("escape", |_, state| state.q[0] - 1.0)
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
    let rate = summary.passage("escape").ok_or("no passages")?.rate(REST);
    let (lambda, error) = (2.0 * rate.value, 2.0 * rate.standard_error);
    // frequencies of the step are off by (ωh)²/12, with that of the well, ω² = 8; λ/2 of the paths return within a unit of time
    let bias = 8.0 * H * H / 12.0 + BOTTOM * 0.5 * LAMBDA;
    let allowed = STANDARD_ERRORS * error + LAMBDA * bias;
    let is_right = (lambda - LAMBDA).abs() <= allowed;
    println!(
        "λ = {lambda:.6} ± {error:.6}; exact {LAMBDA:.6}, from which it may be off by {allowed:.6}"
    );
    println!("{}", if is_right { "ok" } else { "OFF" });
    Ok(if is_right {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}
