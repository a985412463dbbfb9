//! Ensembles on 1, 2, 3 and 4 ranks against one machine.
//!
//! Without a rank this program starts itself by `mpirun`, once for each case and number of ranks. A
//! case is a function that every rank runs. The names of cases can be given as arguments.

#![allow(clippy::redundant_closure_for_method_calls)] // closures are written as users write them

mod bits;
mod errors;
mod launch;
mod models;
mod restart;

use mpi::Threading;
use mpi::topology::SimpleCommunicator;
use mpi::traits::Communicator as _;

/// The communicator of a case, the rank and the last rank.
pub(crate) struct World {
    pub(crate) communicator: SimpleCommunicator,
    pub(crate) rank: i32,
    pub(crate) last: i32,
}

impl World {
    /// Returns the number of ranks below the last.
    pub(crate) fn others(&self) -> u64 {
        self.last.unsigned_abs().into()
    }
}

/// The expected end of a case.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Outcome {
    Passes,
    /// The run is killed.
    Dies,
}

pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) run: fn(&World),
    pub(crate) ranks: &'static [u32],
    pub(crate) outcome: Outcome,
    pub(crate) threading: Threading,
}

const ALL: &[u32] = &[1, 2, 3, 4];
const SEVERAL: &[u32] = &[2, 3, 4];

const fn case(name: &'static str, ranks: &'static [u32], run: fn(&World)) -> Case {
    Case {
        name,
        run,
        ranks,
        outcome: Outcome::Passes,
        threading: Threading::Funneled,
    }
}

const CASES: &[Case] = &[
    case("same_bits", ALL, bits::same_bits),
    case("messages_in_pieces", ALL, bits::messages_in_pieces),
    case("unequal_times", SEVERAL, bits::unequal_times),
    case("divided_communicators", ALL, bits::divided_communicators),
    case("shards", ALL, bits::shards),
    case("progress", ALL, bits::progress),
    case("failing_paths", ALL, errors::failing_paths),
    case("stop_on_failure", ALL, errors::stop_on_failure),
    case("panics", ALL, errors::panics),
    case("wrong_settings", ALL, errors::wrong_settings),
    case("differing_settings", SEVERAL, errors::differing_settings),
    case("bad_files", ALL, errors::bad_files),
    case("vanishing_folders", ALL, errors::vanishing_folders),
    Case {
        threading: Threading::Single,
        ..case("thread_level", ALL, errors::thread_level)
    },
    case("stopped", ALL, restart::stopped),
    case("restarted_alone", ALL, restart::restarted_alone),
    Case {
        outcome: Outcome::Dies,
        ..case("killed", SEVERAL, restart::killed)
    },
    case("continued", ALL, restart::continued),
];

fn main() {
    match std::env::var("SVE_MPI_CASE") {
        Ok(name) => rank(&name),
        Err(_) => launch::all(),
    }
}

/// Runs a case on a rank.
fn rank(name: &str) {
    let case = CASES.iter().find(|case| case.name == name);
    let case = case.expect("a case of this name");
    let initialised = mpi::initialize_with_threading(case.threading);
    let (universe, _) = initialised.expect("MPI is initialised once");
    let world = universe.world();
    let given = World {
        rank: world.rank(),
        last: world.size() - 1,
        communicator: universe.world(),
    };
    let ran = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| (case.run)(&given)));
    if ran.is_err() {
        eprintln!("{name} failed on rank {}", given.rank);
        world.abort(1);
    }
}
