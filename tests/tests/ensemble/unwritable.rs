//! Checkpoints that cannot be written: an error before the first path, a warning after it, and no
//! results are lost.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use sve_models::checks::assert_says;
use sve_runtime::ensemble::Warning;
use sve_runtime::prelude::*;

use crate::runs::{KuboMethod, kubo};

/// Number of blocks of the runs here.
const BLOCKS: u64 = 6;

fn ensemble(method: &KuboMethod) -> Ensemble<'_, KuboMethod> {
    Ensemble::new(method)
        .paths(64 * BLOCKS)
        .steps(0.05, 4)
        .threads(1)
        .start(State::new([1.0], [0.0]))
        .observe("q", |_, s| s.q[0])
}

/// An empty folder.
fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let name = |entry: fs::DirEntry| entry.file_name().into_string().unwrap();
    let mut names: Vec<_> = entries.map(|entry| name(entry.unwrap())).collect();
    names.sort();
    names
}

#[test]
fn a_path_that_cannot_be_written_is_an_error_before_the_first_path() {
    let (method, folder) = (kubo(), folder("unwritable_checkpoints"));
    let file = folder.join("file");
    fs::write(&file, b"").unwrap();
    let mut paths = vec![file.join("x"), folder.join("no/x"), folder.clone()];
    if cfg!(target_os = "linux") {
        // a full disk; a folder that not even an administrator may write to
        paths.extend(["/dev/full", "/proc/x.sve"].map(PathBuf::from));
    }
    let closed = folder.join("closed");
    fs::create_dir(&closed).unwrap();
    let mut permissions = fs::metadata(&closed).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&closed, permissions).unwrap();
    // an administrator may write there all the same
    if fs::File::create(closed.join("y")).is_err() {
        paths.push(closed.join("x"));
    }
    for path in paths {
        for resume in [false, true] {
            let observed = AtomicU64::new(0);
            let run = ensemble(&method)
                .observe("count", |_, _| {
                    observed.fetch_add(1, Ordering::Relaxed) as f64
                })
                .checkpoint(&path, Duration::from_secs(3600))
                .resume(resume)
                .run();
            let Err(error @ EnsembleError::Checkpoint { .. }) = run else {
                panic!("{}: {run:?}", path.display());
            };
            assert_says(&error, &[path.to_str().unwrap(), "no path was computed"]);
            assert_eq!(observed.into_inner(), 0, "{error}");
        }
    }
}

/// A device without an end is not read, and takes what is written.
#[cfg(target_os = "linux")]
#[test]
fn a_device_has_no_results() {
    let method = kubo();
    let run = ensemble(&method).checkpoint("/dev/zero", Duration::ZERO);
    let summary = run.resume(true).run().unwrap();
    assert_eq!(summary, ensemble(&method).run().unwrap());
    assert!(summary.warnings().is_empty());
}

/// The checkpoint of a run whose file another function takes away before block 2 and gives back
/// before another block, and the summary.
fn disturbed(
    method: &KuboMethod,
    path: &Path,
    take: &(dyn Fn() + Sync),
    give: (u64, &(dyn Fn() + Sync)),
) -> Summary {
    let block = AtomicU64::new(0);
    let disturb = || {
        match block.fetch_add(1, Ordering::Relaxed) {
            2 => take(),
            block if block == give.0 => give.1(),
            _ => {}
        }
        false
    };
    let run = ensemble(method).checkpoint(path, Duration::ZERO);
    run.stop_when(disturb).run().unwrap()
}

/// Asserts that a summary has all results, and a warning about so many attempts that failed.
fn assert_warned(method: &KuboMethod, summary: &Summary, path: &Path, count: u64, is_last: bool) {
    assert_eq!(*summary, ensemble(method).run().unwrap());
    let warnings = summary.warnings();
    let [
        Warning::Checkpoint {
            path: named,
            failed,
            error,
            is_written,
        },
    ] = &warnings[..]
    else {
        panic!("{warnings:?}");
    };
    assert_eq!(named, path.to_str().unwrap());
    assert!((*failed, *is_written) == (count, !is_last) && !error.is_empty());
    let text = summary.to_string();
    let end = if is_last {
        "lacks"
    } else {
        "has these results"
    };
    assert!(text.contains(error) && text.contains(end), "{text}");
}

#[test]
fn a_folder_that_vanishes_during_the_run_is_a_warning() {
    let (method, folder) = (kubo(), folder("vanishing"));
    let (shown, hidden) = (folder.join("shown"), folder.join("hidden"));
    fs::create_dir(&shown).unwrap();
    let path = shown.join("x.sve");
    let take = || fs::rename(&shown, &hidden).unwrap();
    let give = || fs::rename(&hidden, &shown).unwrap();
    // blocks 2 and 3 are not written, later ones are
    let summary = disturbed(&method, &path, &take, (4, &give));
    assert_warned(&method, &summary, &path, 2, false);
    let never = || panic!("no block is run from the file of a complete run");
    let resumed = ensemble(&method)
        .checkpoint(&path, Duration::ZERO)
        .resume(true);
    let resumed = resumed.stop_when(never).run().unwrap();
    assert_eq!(resumed, summary);
    assert!(resumed.warnings().is_empty());
    // blocks 2 to 5 and the end are not written
    let summary = disturbed(&method, &path, &take, (BLOCKS, &give));
    assert_warned(&method, &summary, &path, 5, true);
    assert!(!shown.exists());
    assert_eq!(names(&hidden), ["x.sve"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_is_full_during_the_run_is_a_warning() {
    let (method, folder) = (kubo(), folder("full"));
    let path = folder.join("x.sve");
    let take = || {
        fs::remove_file(&path).unwrap();
        std::os::unix::fs::symlink("/dev/full", &path).unwrap();
    };
    let give = || fs::remove_file(&path).unwrap();
    let summary = disturbed(&method, &path, &take, (5, &give));
    assert_warned(&method, &summary, &path, 3, false);
    assert!(summary.to_string().contains("No space left"), "{summary}");
    assert_eq!(names(&folder), ["x.sve"]);
}

/// Shards keep the warnings of each run.
#[test]
fn merged_summaries_keep_their_warnings() {
    let (method, folder) = (kubo(), folder("merged"));
    let shard = |index: u64| {
        let path = folder.join(index.to_string()).join("x.sve");
        fs::create_dir(path.parent().unwrap()).unwrap();
        let vanish = || {
            let _ = fs::remove_dir_all(path.parent().unwrap());
            false
        };
        let run = ensemble(&method)
            .shard(index, 3)
            .checkpoint(&path, Duration::ZERO);
        run.stop_when(vanish).run().unwrap()
    };
    let mut summary = shard(0);
    summary.merge(shard(1)).unwrap();
    summary
        .merge(ensemble(&method).shard(2, 3).run().unwrap())
        .unwrap();
    assert_eq!(summary, ensemble(&method).run().unwrap());
    let warnings = summary.warnings();
    let is_of = |shard: &str, warning: &Warning| matches!(warning, Warning::Checkpoint { path, is_written: false, .. } if path.contains(shard));
    assert!(warnings.len() == 2, "{warnings:?}");
    assert!(is_of("0", &warnings[0]) && is_of("1", &warnings[1]));
}

/// A run removes the temporary files of killed runs of its own checkpoint. A living run holds a
/// lock on its file.
#[test]
fn temporary_files_of_killed_runs_are_removed() {
    let (method, folder) = (kubo(), folder("leftovers"));
    let path = folder.join("x.sve");
    let run = || {
        let ensemble = ensemble(&method).checkpoint(&path, Duration::ZERO);
        ensemble.resume(true).run().unwrap()
    };
    // both before there is a checkpoint and after it
    for _ in 0..2 {
        for number in 0..76 {
            let file = format!(".x.sve.77{number}-{number}.new");
            fs::write(folder.join(file), [0; 99]).unwrap();
        }
        let living = fs::File::create(folder.join(".x.sve.1-1.new")).unwrap();
        living.try_lock().unwrap();
        fs::write(folder.join(".y.sve.1-1.new"), b"").unwrap();
        assert!(run().is_complete());
        let left = [".x.sve.1-1.new", ".y.sve.1-1.new", "x.sve"];
        assert_eq!(names(&folder), left);
        drop(living);
    }
    assert!(run().is_complete());
    assert_eq!(names(&folder), [".y.sve.1-1.new", "x.sve"]);
}
