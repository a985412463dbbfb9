//! Runs that end early and are continued on other numbers of ranks.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use mpi::collective::SystemOperation;
use mpi::traits::CommunicatorCollectives as _;
use sve_mpi::Error;
use sve_runtime::prelude::*;

use super::World;
use super::models::{Method, bits, kubo, scratch, with_all};

const PATHS: u64 = 200 * 64 + 9;

/// Checks that the last rank can end a run. Another number of ranks continues it: one machine, and
/// all ranks again.
pub(crate) fn stopped(given: &World) {
    let (method, asked) = (kubo(), AtomicU64::new(0));
    let file = scratch(&format!("stopped-{}.sve", given.last));
    if given.rank == 0 {
        let _ = std::fs::remove_file(&file);
    }
    let is_last = given.rank == given.last;
    // The other ranks are slow, so that they cannot end the run before the last rank is asked.
    let start = |sleep: u64| {
        move |path: u64, rng: &mut StartRng| {
            if path % 64 == 33 {
                thread::sleep(Duration::from_millis(sleep));
            }
            State::new([rng.normal()], [rng.uniform()])
        }
    };
    let ensemble = with_all(&method, PATHS)
        .start(Starts::each(start(if is_last { 0 } else { 20 })))
        .threads(1)
        .checkpoint(&file, Duration::from_millis(1))
        .stop_when(|| is_last && asked.fetch_add(1, Ordering::Relaxed) >= 9);
    let summary = sve_mpi::run(&ensemble, &given.communicator).unwrap();
    assert!(
        summary.paths() >= 9 * 64 && summary.paths() < PATHS,
        "{summary:?}"
    );
    same_on_all(given, &bits(&summary));
    let again = || with_all(&method, PATHS).start(Starts::each(start(0)));
    let whole = again()
        .checkpoint(&file, Duration::from_secs(60))
        .resume(true);
    let alone = bits(&again().run().unwrap());
    assert_eq!(
        bits(&sve_mpi::run(&whole, &given.communicator).unwrap()),
        alone
    );
    // a run that is stopped at once
    let ensemble = with_all(&method, PATHS).stop_when(move || true);
    let nothing = sve_mpi::run(&ensemble, &given.communicator);
    assert!(matches!(nothing, Err(Error::NothingRun(_))), "{nothing:?}");
}

/// Asserts that bytes are the same on all ranks.
fn same_on_all(given: &World, bytes: &[u8]) {
    let sum = bytes.iter().fold(0_u64, |sum, &byte| {
        sum.wrapping_mul(31).wrapping_add(byte.into())
    });
    let (mut least, mut most) = (0_u64, 0_u64);
    given
        .communicator
        .all_reduce_into(&sum, &mut least, SystemOperation::min());
    given
        .communicator
        .all_reduce_into(&sum, &mut most, SystemOperation::max());
    assert_eq!(least, most);
}

/// Checks that all ranks continue a file that one machine has written, and the reverse.
pub(crate) fn restarted_alone(given: &World) {
    let method = kubo();
    let alone = bits(&with_all(&method, PATHS).run().unwrap());
    let file = scratch(&format!("alone-{}.sve", given.last));
    let part = |stop: u64| {
        let asked = AtomicU64::new(0);
        with_all(&method, PATHS)
            .checkpoint(&file, Duration::from_secs(60))
            .stop_when(move || asked.fetch_add(1, Ordering::Relaxed) >= stop)
    };
    if given.rank == 0 {
        part(50).run().unwrap();
    }
    let more = sve_mpi::run(&part(20).resume(true), &given.communicator).unwrap();
    assert!(more.paths() > 50 * 64 && more.paths() < PATHS);
    if given.rank == 0 {
        let whole = with_all(&method, PATHS).checkpoint(&file, Duration::from_secs(60));
        assert_eq!(bits(&whole.resume(true).run().unwrap()), alone);
    }
}

/// Returns the path of the file of a run that is killed.
fn killed_file(number: i32) -> PathBuf {
    scratch(&format!("killed-{number}.sve"))
}

/// Returns an ensemble whose blocks take some time.
fn slow<'a>(method: &'a Method, ran: &'a AtomicU64) -> Ensemble<'a, Method> {
    with_all(method, PATHS).start(Starts::each(move |path, rng| {
        if path % 64 == 33 {
            ran.fetch_add(1, Ordering::Relaxed);
            thread::sleep(Duration::from_millis(5));
        }
        State::new([rng.normal()], [rng.uniform()])
    }))
}

/// Kills the last rank once a few checkpoints exist.
pub(crate) fn killed(given: &World) {
    let (method, ran) = (kubo(), AtomicU64::new(0));
    let file = killed_file(given.last + 1);
    if given.rank == 0 {
        let _ = std::fs::remove_file(&file);
    }
    // The barrier keeps a file of an earlier run from being mistaken for a file of this run.
    given.communicator.barrier();
    let (is_last, watched) = (given.rank == given.last, file.clone());
    if is_last {
        thread::spawn(move || {
            // each file has more blocks than the one before
            let written = || watched.metadata().and_then(|file| file.modified()).ok();
            let (mut last, mut files) = (None, 0);
            while files < 4 {
                let now = written();
                files += u32::from(now != last);
                last = now;
                thread::sleep(Duration::from_millis(1));
            }
            // The signal is the same as when the system ends a process that takes too much memory.
            let own = std::process::id().to_string();
            let _ = std::process::Command::new("kill")
                .args(["-9", &own])
                .status();
        });
    }
    let ensemble = slow(&method, &ran)
        .threads(1)
        .checkpoint(&file, Duration::from_millis(20));
    let ended = sve_mpi::run(&ensemble, &given.communicator);
    panic!("{ended:?} without the last rank");
}

/// Checks that each run that was killed is continued, on the given number of ranks.
pub(crate) fn continued(given: &World) {
    let (method, ran) = (kubo(), AtomicU64::new(0));
    let alone = bits(&slow(&method, &ran).run().unwrap());
    for number in 2..=4 {
        let (from, file) = (
            killed_file(number),
            scratch(&format!("continued-{}.sve", given.last)),
        );
        if given.rank == 0 {
            std::fs::copy(&from, &file).expect("the case `killed` has run");
        }
        let ran = AtomicU64::new(0);
        let ensemble = slow(&method, &ran)
            .checkpoint(&file, Duration::from_secs(60))
            .resume(true);
        let summary = sve_mpi::run(&ensemble, &given.communicator).unwrap();
        assert_eq!(bits(&summary), alone);
        let (ran, mut sum) = (ran.load(Ordering::Relaxed), 0_u64);
        given
            .communicator
            .all_reduce_into(&ran, &mut sum, SystemOperation::sum());
        // Without a checkpoint there would be a start for each of 200 blocks, and the starts for
        // the fingerprints.
        assert!(sum < 200, "{sum}");
    }
}
