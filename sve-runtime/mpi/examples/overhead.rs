//! The cost of distribution over ranks: the time of a run on all ranks relative to shards of equal
//! size that each rank runs alone, without messages.
//!
//! The two ways alternate in one run, and the median of the ratios of their times is printed. Each
//! rank has one thread. `mpirun -n 2 cargo run --release --example overhead`; an argument sets the
//! number of repetitions, 15 by default.

#![allow(clippy::redundant_closure_for_method_calls)] // closures are written as users write them

use std::error::Error;
use std::thread;
use std::time::{Duration, Instant};

use mpi::Threading;
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives as _};
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
    let ranks = u64::from(world.size().unsigned_abs());
    let integrator = Integrator::new(Pendulum { g: 9.8, sigma: 0.3 }, Midpoint);
    let ensemble = |paths: u64| {
        Ensemble::new(&integrator)
            .paths(paths)
            .threads(1)
            .steps(0.01, 1000)
            .every(100)
            .start(State::new([1.0], [0.0]))
            .observe("q", |_, s| s.q[0])
            .observe("energy", |system, s| system.hamiltonian(s))
    };
    let mut paths = 64 * 128 * ranks;
    let mut ratios = Vec::new();
    for repetition in 0..=repetitions {
        let rank = u64::from(world.rank().unsigned_abs());
        let own = SimpleCommunicator::self_comm();
        let shard = || ensemble(paths).shard(rank, ranks);
        let alone = time(&world, || sve_mpi::run(&shard(), &own).map(drop))?;
        let distributed = time(&world, || sve_mpi::run(&ensemble(paths), &world).map(drop))?;
        if repetition == 0 {
            // The first repetition finds the number of paths that take a second.
            #[allow(clippy::cast_sign_loss)] // a count
            let blocks = (paths as f64 / 64.0 / alone).max(8.0) as u64;
            paths = 64 * blocks.next_multiple_of(ranks);
            continue;
        }
        ratios.push(distributed / alone);
        if world.rank() == 0 {
            let ratio = distributed / alone;
            println!("{alone:.4} s by shards, {distributed:.4} s on all ranks, ratio {ratio:.4}");
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

/// Returns the time until all ranks have called `run`.
fn time<E>(world: &impl Communicator, run: impl FnOnce() -> Result<(), E>) -> Result<f64, E> {
    barrier(world);
    let start = Instant::now();
    run()?;
    let own = start.elapsed().as_secs_f64();
    barrier(world);
    let mut longest = own;
    world.all_reduce_into(&own, &mut longest, SystemOperation::max());
    Ok(longest)
}

/// Waits for all ranks with pauses, so that a rank that waits leaves its core to the others.
fn barrier(world: &impl Communicator) {
    let mut request = world.immediate_barrier();
    while let Err(waiting) = request.test() {
        request = waiting;
        thread::sleep(Duration::from_micros(200));
    }
}
