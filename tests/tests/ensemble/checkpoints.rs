//! Checkpoints of a stopped run: files that are damaged, of another run or of another program are
//! errors that name the file.

use std::path::PathBuf;
use std::time::Duration;

use sve_models::checks::assert_says;
use sve_models::models::Kubo;
use sve_runtime::ensemble::{Damage, Difference};
use sve_runtime::prelude::*;

use crate::runs::{KuboMethod, kubo, scratch};

/// An ensemble with one of each kind of result, and so few paths that its file is small.
fn ensemble(method: &KuboMethod) -> Ensemble<'_, KuboMethod> {
    Ensemble::new(method)
        .paths(20)
        .seed(3)
        .steps(0.05, 4)
        .start(Starts::each(|_, rng| {
            State::new([rng.normal()], [rng.uniform()])
        }))
        .observe("q", |_, s| if s.q[0] > 1.5 { f64::NAN } else { s.q[0] })
        .histogram("q", -2.0..2.0, Bins::at_end(3))
        .covariance("q", "q")
        .quantiles("q", 2)
        .keep_final_states(true)
}

/// Writes a checkpoint. Returns its path, its bytes and the summary.
fn written(name: &str) -> (PathBuf, Vec<u8>, Summary) {
    let (method, path) = (kubo(), scratch(name));
    let summary = ensemble(&method).checkpoint(&path, Duration::ZERO).run();
    let bytes = std::fs::read(&path).unwrap();
    (path, bytes, summary.unwrap())
}

/// Replaces a file. Overwriting the existing file would synchronise it with the disk each time.
fn replaced(path: &PathBuf, bytes: &[u8]) {
    std::fs::remove_file(path).unwrap();
    std::fs::write(path, bytes).unwrap();
}

fn resumed(method: &KuboMethod, path: &PathBuf) -> Result<Summary, EnsembleError> {
    let ensemble = ensemble(method).checkpoint(path, Duration::from_secs(60));
    ensemble.resume(true).threads(1).run()
}

#[test]
fn every_flipped_bit_is_an_error() {
    let method = kubo();
    let (path, bytes, whole) = written("flipped.sve");
    assert!(whole.failed() > 0 && bytes.len() < 1500, "{}", bytes.len());
    assert_eq!(resumed(&method, &path).unwrap(), whole);
    for at in 0..bytes.len() {
        for bit in 0..8 {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1 << bit;
            replaced(&path, &damaged);
            let error = resumed(&method, &path).unwrap_err();
            match (at, &error) {
                (..8, EnsembleError::NotACheckpoint { .. })
                | (8.., EnsembleError::DamagedCheckpoint { .. }) => {}
                (_, other) => panic!("byte {at}, bit {bit}: {other}"),
            }
            assert!(error.to_string().contains("flipped.sve"), "{error}");
        }
    }
    std::fs::remove_file(path).unwrap();
}

#[test]
fn every_length_is_checked() {
    let method = kubo();
    let (path, bytes, _) = written("cut.sve");
    let longer = [&bytes[..], &[0]].concat();
    let cut = (0..bytes.len()).map(|length| &bytes[..length]);
    for damaged in cut.chain([&longer[..]]) {
        replaced(&path, damaged);
        match resumed(&method, &path) {
            Err(EnsembleError::NotACheckpoint { .. }) if damaged.len() < 8 => {}
            Err(EnsembleError::DamagedCheckpoint {
                damage: Damage::Length { found, expected },
                ..
            }) => {
                assert_eq!(found, damaged.len() as u64);
                assert!(expected == bytes.len() as u64 || damaged.len() < 28);
            }
            other => panic!("{} bytes: {other:?}", damaged.len()),
        }
    }
    std::fs::remove_file(path).unwrap();
}

/// A sound file of another format, and one whose content is nonsense with a right checksum.
#[test]
fn versions_and_contents_are_checked() {
    let method = kubo();
    let (path, bytes, _) = written("version.sve");
    let with = |version: u32, content: &[u8]| {
        let head = [
            &version.to_le_bytes()[..],
            &(content.len() as u64).to_le_bytes(),
        ]
        .concat();
        let mut hash = twox_hash::XxHash64::default();
        std::hash::Hasher::write(&mut hash, &head);
        std::hash::Hasher::write(&mut hash, content);
        let checksum = std::hash::Hasher::finish(&hash).to_le_bytes();
        [&bytes[..8], &head, &checksum, content].concat()
    };
    assert_eq!(with(6, &bytes[28..]), bytes);
    for version in [5, 7] {
        std::fs::write(&path, with(version, &bytes[28..])).unwrap();
        let error = resumed(&method, &path).unwrap_err();
        let found = format!("version.sve has format {version}");
        assert_says(error, &[&found, "reads format 6"]);
    }
    // the content with one of its bytes another: refused, or one that fits together by chance
    let mut refused = 0;
    for at in (28..bytes.len()).step_by(5) {
        let mut content = bytes[28..].to_vec();
        content[at - 28] ^= 0x55;
        replaced(&path, &with(6, &content));
        if let Err(error) = resumed(&method, &path) {
            assert!(error.to_string().contains("version.sve"), "{error}");
            refused += 1;
        }
    }
    assert!(refused > 20, "{refused}");
    std::fs::remove_file(path).unwrap();
}

#[test]
fn other_runs_are_refused_by_what_differs() {
    let method = kubo();
    let (path, ..) = written("other.sve");
    let refused = |other: Ensemble<'_, KuboMethod>, expected: Difference| {
        let error = other.checkpoint(&path, Duration::ZERO).resume(true).run();
        match error {
            Err(error @ EnsembleError::OtherCheckpoint { what, .. }) => {
                assert_eq!(what, expected);
                let (text, name) = (error.to_string(), path.display().to_string());
                assert!(text.contains(&name) && !text.replace(&name, "").contains("merge"));
            }
            other => panic!("{other:?}"),
        }
    };
    refused(ensemble(&method).seed(4), Difference::Seed);
    refused(ensemble(&method).paths(21), Difference::Paths);
    let many = || ensemble(&method).paths(200);
    many()
        .shard(0, 2)
        .checkpoint(&path, Duration::ZERO)
        .run()
        .unwrap();
    refused(many().shard(1, 2), Difference::Shard);
    refused(many(), Difference::Shard);
    ensemble(&method)
        .checkpoint(&path, Duration::ZERO)
        .run()
        .unwrap();
    refused(
        ensemble(&method).observe("p", |_, s| s.p[0]),
        Difference::Observables,
    );
    let truncated = Truncated::new(Wiener::new(3)).deviations(3.0).unwrap();
    refused(ensemble(&method).noise(truncated), Difference::Noise);
    refused(ensemble(&method).steps(0.05, 5), Difference::Times);
    let starts = ensemble(&method).start(State::new([1.0], [0.0]));
    refused(starts, Difference::Starts);
    let next = Kubo {
        a: 1.0,
        sigma: 0.5_f64.next_up(),
    };
    let next = Integrator::new(next, Midpoint);
    refused(ensemble(&next), Difference::Parameters);
    std::fs::remove_file(&path).unwrap();
}

/// A run that is stopped before its first block leaves the file of an earlier one.
#[test]
fn a_run_without_results_writes_nothing() {
    let method = kubo();
    let (path, bytes, _) = written("kept.sve");
    let stopped = ensemble(&method)
        .checkpoint(&path, Duration::ZERO)
        .stop_when(|| true);
    assert!(matches!(stopped.run(), Err(EnsembleError::NothingRun)));
    assert_eq!(std::fs::read(&path).unwrap(), bytes);
    std::fs::remove_file(path).unwrap();
}
