//! What the distribution over ranks costs: the same paths on two ranks with one thread each, and on one rank with two threads.
//!
//! The two ways alternate in one run, and the median of the ratios is printed. `mpirun -n 2 cargo run --release --example overhead`; an argument sets the
//! number of repetitions, 15 by default.

#![allow(unused_crate_dependencies)] // of the library

use std::error::Error;
use std::thread;
use std::time::{Duration, Instant};

use mpi::Threading;
use mpi::traits::{Communicator as _, CommunicatorCollectives as _};
use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let initialised = mpi::initialize_with_threading(Threading::Funneled);
    let (universe, _) = initialised.ok_or("MPI is initialised already")?;
    let world = universe.world();
    let repetitions = match std::env::args().nth(1) {
        Some(text) => text.parse()?,
        None => 15,
    };
    let ranks = world.size().unsigned_abs() as usize;
    let integrator = Integrator::new(Pendulum { g: 9.8, sigma: 0.3 }, Midpoint);
    let ensemble = |paths: u64, threads: usize| {
        Ensemble::new(&integrator)
            .paths(paths)
            .threads(threads)
            .steps(0.01, 1000)
            .record_every(100)
            .start(State::new([1.0], [0.0]))
            .observe("q", |_, s| s.q[0])
            .observe("energy", |system, s| system.hamiltonian(s))
    };
    // about a second
    let mut paths = 64 * 256;
    let mut ratios = Vec::new();
    for repetition in 0..=repetitions {
        barrier(&world);
        let start = Instant::now();
        let alone = (world.rank() == 0)
            .then(|| ensemble(paths, ranks).run())
            .transpose()?;
        let threads = start.elapsed().as_secs_f64();
        barrier(&world);
        let start = Instant::now();
        let summary = sve_mpi::run(&ensemble(paths, 1), &world)?;
        let distributed = start.elapsed().as_secs_f64();
        if let Some(alone) = alone {
            assert_eq!(alone, summary);
        }
        let mut first = threads;
        mpi::traits::Root::broadcast_into(&world.process_at_rank(0), &mut first);
        if repetition == 0 {
            // the first repetition finds the number of paths that takes a second
            let blocks = (paths as f64 / 64.0 / first).max(8.0);
            #[allow(clippy::cast_sign_loss)] // a count
            let blocks = blocks as u64;
            paths = 64 * blocks;
            continue;
        }
        ratios.push(distributed / threads);
        if world.rank() == 0 {
            println!(
                "{threads:.4} s by threads, {distributed:.4} s by ranks, ratio {:.4}",
                distributed / threads
            );
        }
    }
    ratios.sort_by(f64::total_cmp);
    if world.rank() == 0 {
        println!(
            "median ratio {:.4} of {} repetitions, {paths} paths",
            ratios[ratios.len() / 2],
            ratios.len()
        );
    }
    Ok(())
}

/// Waits for all ranks with pauses, so that a rank that waits leaves its core to the others.
fn barrier(world: &impl mpi::traits::Communicator) {
    let mut request = world.immediate_barrier();
    while let Err(waiting) = request.test() {
        request = waiting;
        thread::sleep(Duration::from_micros(200));
    }
}
