//! Errors are the same on all ranks, with the rank where they occurred.

use std::time::Duration;

use sve_mpi::Error;
use sve_runtime::ensemble::{Failure, Warning};
use sve_runtime::prelude::*;

use super::World;
use super::models::{Kubo, Method, bits, kubo, scratch, with_all};

fn error(ensemble: &Ensemble<'_, Method>, given: &World) -> Error {
    sve_mpi::run(ensemble, &given.communicator).expect_err("an error")
}

/// Checks a run in which more paths fail than a summary keeps.
pub(crate) fn failing_paths(given: &World) {
    let method = kubo();
    let ensemble = with_all(&method, 6400).bound("energy", ..=1.5);
    let (summary, alone) = (
        sve_mpi::run(&ensemble, &given.communicator).unwrap(),
        ensemble.run().unwrap(),
    );
    assert!(alone.failed() > 300 && alone.failures().len() == 256);
    assert_eq!(summary.failures(), alone.failures());
    assert_eq!(summary.failed(), alone.failed());
    assert_eq!(bits(&summary), bits(&alone));
}

pub(crate) fn stop_on_failure(given: &World) {
    let method = kubo();
    // a rare failure in the middle, and a frequent one
    for least in [2.45, 3.5] {
        let ensemble = with_all(&method, 12_800)
            .observe("start", |_, s| s.q[0])
            .bound("start", -least..=2.5)
            .stop_on_failure(true);
        let alone: Failure = match ensemble.run() {
            Err(EnsembleError::Failed(failure)) => *failure,
            other => panic!("{other:?}"),
        };
        match error(&ensemble, given) {
            Error::Failed(failure) => assert_eq!(*failure, alone),
            other => panic!("{other:?}"),
        }
    }
}

/// Checks a panic on the last rank, in a start that the settings draw, and in a later one.
pub(crate) fn panics(given: &World) {
    let (method, is_last) = (kubo(), given.rank == given.last);
    let panicking = |first: u64| {
        let draw = move |path: u64, rng: &mut StartRng| {
            let is_path = path == first || (first > 0 && path > first && path % 64 == 7);
            assert!(!(is_last && is_path), "no start for the test");
            State::new([rng.normal()], [0.0])
        };
        Ensemble::new(&method)
            .paths(64_000)
            .steps(0.1, 50)
            .start(Starts::each(draw))
    };
    for first in [0, 40] {
        match error(&panicking(first), given) {
            Error::Panicked { rank, message } => {
                assert_eq!((rank, &message[..]), (given.last, "no start for the test"));
            }
            other => panic!("{other:?}"),
        }
    }
}

/// Checks an invalid setting on one rank.
pub(crate) fn wrong_settings(given: &World) {
    let method = kubo();
    for wrong in 0..=given.last {
        let ensemble = with_all(&method, 500);
        let ensemble = if given.rank == wrong {
            ensemble.every(0)
        } else {
            ensemble
        };
        match error(&ensemble, given) {
            Error::OnRank {
                rank,
                message,
                source,
            } => {
                assert_eq!(rank, wrong);
                assert!(message.contains("`every` was given 0"), "{message}");
                let is_source = matches!(source.as_deref(), Some(EnsembleError::Zero { .. }));
                assert_eq!(is_source, given.rank == wrong);
            }
            other => panic!("{other:?}"),
        }
    }
}

/// Checks a valid setting that has another value on the last rank.
pub(crate) fn differing_settings(given: &World) {
    let (method, is_last) = (kubo(), given.rank == given.last);
    let next = Kubo {
        a: 1.0_f64.next_up(),
        sigma: 0.5,
    };
    let other = Integrator::new(next, Midpoint);
    let settings = |method, k: u32| {
        let ensemble = with_all(method, if k == 0 { 501 } else { 500 });
        match k {
            1 => ensemble.seed(4),
            2 => ensemble.observe("p", |_, s| s.p[0]),
            3 => ensemble.stop_on_failure(true),
            4 => ensemble.shard(0, 2),
            5 => ensemble.steps(0.05_f64.next_up(), 30),
            6 => ensemble.start(State::new([1.0], [0.0])),
            _ => ensemble,
        }
    };
    let names = [
        "number of paths",
        "seed",
        "observables",
        "settings",
        "shard",
        "times",
        "starts",
    ];
    for (k, expected) in (0..).zip(names) {
        let ensemble = settings(&method, if is_last { k } else { 99 });
        differs(&error(&ensemble, given), given.last, expected);
    }
    let ensemble = settings(if is_last { &other } else { &method }, 99);
    differs(&error(&ensemble, given), given.last, "parameters");
}

fn differs(error: &Error, last: i32, expected: &str) {
    match error {
        Error::Differs { rank, what } => {
            assert_eq!(*rank, last);
            assert!(what.contains(expected), "{what}");
        }
        other => panic!("{other:?}"),
    }
}

/// Checks that checkpoints that cannot be read or written at the start are errors of rank 0, on all
/// ranks.
pub(crate) fn bad_files(given: &World) {
    let method = kubo();
    let damaged = scratch(&format!("damaged-{}.sve", given.last));
    if given.rank == 0 {
        std::fs::write(&damaged, b"sve run\0 and nothing else").unwrap();
    }
    let mut paths = vec![(damaged.clone(), true), (damaged.join("x"), false)];
    if cfg!(target_os = "linux") {
        paths.push(("/dev/full".into(), false));
    }
    for (path, resume) in paths {
        for interval in [Duration::ZERO, Duration::from_secs(600)] {
            let ensemble = with_all(&method, 3000)
                .checkpoint(&path, interval)
                .resume(resume);
            match error(&ensemble, given) {
                Error::OnRank {
                    rank,
                    message,
                    source,
                } => {
                    assert_eq!(rank, 0);
                    assert!(message.contains(path.to_str().unwrap()), "{message}");
                    assert_eq!(source.is_some(), given.rank == 0);
                }
                other => panic!("{other:?}"),
            }
        }
    }
}

/// Checks that a checkpoint that cannot be written during the run is a warning on all ranks, and
/// that no results are lost.
pub(crate) fn vanishing_folders(given: &World) {
    let method = kubo();
    let folder = scratch(&format!("vanishing-{}", given.last));
    let file = folder.join("x.sve");
    for interval in [Duration::from_millis(1), Duration::from_secs(600)] {
        if given.rank == 0 {
            std::fs::create_dir_all(&folder).unwrap();
        }
        let is_first = given.rank == 0;
        let vanish = || {
            if is_first {
                let _ = std::fs::remove_dir_all(&folder);
            }
            false
        };
        let run = with_all(&method, 6400).checkpoint(&file, interval);
        let summary = sve_mpi::run(&run.stop_when(vanish), &given.communicator).unwrap();
        assert_eq!(
            bits(&summary),
            bits(&with_all(&method, 6400).run().unwrap())
        );
        let is_of_file = |warning: &Warning| matches!(warning, Warning::Checkpoint { path, is_written: false, .. } if *path == file.display().to_string());
        assert!(
            summary.warnings().iter().any(is_of_file),
            "{:?}",
            summary.warnings()
        );
    }
}

pub(crate) fn thread_level(given: &World) {
    let method = kubo();
    match error(&with_all(&method, 500), given) {
        error @ Error::ThreadLevel { rank: 0 } => {
            assert!(
                error.to_string().contains("initialize_with_threading"),
                "{error}"
            );
        }
        other => panic!("{other:?}"),
    }
}
