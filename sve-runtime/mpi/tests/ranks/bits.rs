//! Runs on several ranks have the bits of the run on one machine.

use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use mpi::collective::SystemOperation;
use mpi::topology::Color;
use mpi::traits::{Communicator as _, CommunicatorCollectives as _};
use sve_runtime::prelude::*;

use super::World;
use super::models::{bits, kubo, pendulum, with_all};

/// Numbers of paths: fewer blocks than ranks, as many, a part of a block at the end, and many.
const PATHS: [u64; 6] = [1, 64, 65, 256, 7 * 64 + 5, 20_011];

pub(crate) fn same_bits(given: &World) {
    let method = kubo();
    for paths in PATHS {
        let alone = with_all(&method, paths).threads(1).run().unwrap();
        for threads in [1, 2] {
            // Ranks with odd numbers have another number of threads.
            let threads = threads + usize::from(given.rank % 2 == 1);
            let ensemble = with_all(&method, paths).threads(threads);
            let summary = sve_mpi::run(&ensemble, &given.communicator).unwrap();
            assert!(summary.is_complete());
            assert_eq!(bits(&summary), bits(&alone), "{paths} paths");
        }
    }
    let pendulum = pendulum();
    let ensemble = Ensemble::new(&pendulum)
        .paths(3000)
        .seed(8)
        .steps(0.02, 200)
        .start(State::new([1.0], [0.0]))
        .observe("q", |_, s| s.q[0]);
    let summary = sve_mpi::run(&ensemble, &given.communicator).unwrap();
    assert_eq!(bits(&summary), bits(&ensemble.run().unwrap()));
}

/// Checks messages in pieces of a few bytes, which messages of more than 2³⁰ bytes need too.
pub(crate) fn messages_in_pieces(given: &World) {
    let method = kubo();
    let ensemble = with_all(&method, 3000).threads(1);
    let alone = bits(&ensemble.run().unwrap());
    for piece in [8, 61, 1000] {
        let summary = sve_mpi::run_in_pieces(&ensemble, &given.communicator, piece).unwrap();
        assert_eq!(bits(&summary), alone);
    }
}

/// Checks paths that take long in the last rank's region. Other ranks take some of its blocks.
pub(crate) fn unequal_times(given: &World) {
    const BLOCKS: u64 = 256;
    let slow = 64 * BLOCKS * given.others() / (given.others() + 1);
    let (method, own) = (kubo(), AtomicU64::new(0));
    let ensemble = |delay: Duration| {
        let own = &own;
        Ensemble::new(&method)
            .paths(64 * BLOCKS)
            .threads(1)
            .steps(0.1, 5)
            .start(Starts::each(move |path, rng| {
                if path % 64 == 0 && path >= slow && !delay.is_zero() {
                    // The delay is a pause and no work, so that the load of the machine does not
                    // matter.
                    thread::sleep(delay);
                    own.fetch_add(1, Ordering::Relaxed);
                }
                State::new([rng.normal()], [1.0])
            }))
            .observe("q", |_, s| s.q[0])
    };
    let alone = ensemble(Duration::ZERO).run().unwrap();
    let slow_ensemble = ensemble(Duration::from_millis(10));
    let summary = sve_mpi::run(&slow_ensemble, &given.communicator).unwrap();
    assert_eq!(bits(&summary), bits(&alone));
    let own = own.load(Ordering::Relaxed);
    let mut most = 0_u64;
    given
        .communicator
        .all_reduce_into(&own, &mut most, SystemOperation::max());
    let all = BLOCKS / (given.others() + 1);
    // An equal share is all / ranks; each rank also draws up to 17 starts for the fingerprint.
    assert!(most < all * 3 / 4 + 17, "{most} of {all}");
}

/// Checks two runs at the same time, each on some of the ranks, while a message of the program is
/// under way.
pub(crate) fn divided_communicators(given: &World) {
    let color = given.rank % 2;
    let half = given
        .communicator
        .split_by_color(Color::with_value(color))
        .unwrap();
    let method = kubo();
    let ensemble = with_all(&method, 2000).seed(color.unsigned_abs().into());
    let summary = sve_mpi::run(&ensemble, &half).unwrap();
    assert_eq!(bits(&summary), bits(&ensemble.run().unwrap()));
}

pub(crate) fn shards(given: &World) {
    let method = kubo();
    let shard =
        |k| sve_mpi::run(&with_all(&method, 1500).shard(k, 3), &given.communicator).unwrap();
    let mut whole = shard(2);
    assert!(!whole.is_complete());
    whole.merge(shard(0)).unwrap();
    whole.merge(shard(1)).unwrap();
    assert_eq!(bits(&whole), bits(&with_all(&method, 1500).run().unwrap()));
}

/// Prints the progress, which the launcher reads.
pub(crate) fn progress(given: &World) {
    let method = kubo();
    let ensemble = with_all(&method, 640).progress(true);
    sve_mpi::run(&ensemble, &given.communicator).unwrap();
}
