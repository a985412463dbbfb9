//! Tests of the writing of files: errors, panics, links, devices, processes that are killed.

use std::fs;
use std::io::{self, Write as _};
use std::path::PathBuf;

use super::write;

/// Creates an empty folder for one test.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("sve-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn files(folder: &PathBuf) -> usize {
    fs::read_dir(folder).unwrap().count()
}

#[test]
fn a_write_that_fails_half_way_leaves_the_old_file_and_nothing_else() {
    let folder = folder("half");
    let path = folder.join("x.csv");
    let half = |to: &mut io::BufWriter<fs::File>| {
        to.write_all(&vec![b'x'; 100_000])?;
        Err(io::Error::from(io::ErrorKind::StorageFull))
    };
    let error = write(&path, half).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    assert!(error.to_string().contains("x.csv"), "{error}");
    assert_eq!(files(&folder), 0);
    write(&path, |to| to.write_all(b"old")).unwrap();
    write(&path, half).unwrap_err();
    assert_eq!(
        (fs::read(&path).unwrap(), files(&folder)),
        (b"old".to_vec(), 1)
    );
    write(&path, |to| to.write_all(b"new")).unwrap();
    assert_eq!(
        (fs::read(&path).unwrap(), files(&folder)),
        (b"new".to_vec(), 1)
    );
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_panic_leaves_nothing() {
    let folder = folder("panic");
    let path = folder.join("x");
    let panics = std::panic::catch_unwind(|| write(&path, |_| panic!("as if killed")));
    assert!(panics.is_err());
    assert_eq!(files(&folder), 0);
    fs::remove_dir_all(folder).unwrap();
}

#[cfg(unix)]
#[test]
fn links_and_permissions_stay() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = folder("links");
    let (file, link) = (folder.join("file"), folder.join("link"));
    fs::write(&file, b"old").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    std::os::unix::fs::symlink("file", &link).unwrap();
    write(&link, |to| to.write_all(b"new")).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read(&file).unwrap(), b"new");
    let mode = fs::metadata(&file).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o640);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn folders_that_are_none_are_errors() {
    let folder = folder("none");
    let file = folder.join("file");
    fs::write(&file, b"").unwrap();
    for path in [file.join("x"), folder.join("no/x"), folder.clone()] {
        let error = write(&path, |to| to.write_all(b"x")).unwrap_err();
        assert!(error.to_string().contains("sve-"), "{error}");
    }
    assert_eq!(files(&folder), 1);
    fs::remove_dir_all(folder).unwrap();
}

#[cfg(target_os = "linux")]
#[test]
fn full_devices_are_errors() {
    let path = std::path::Path::new("/dev/full");
    // The content has few bytes, so that only the flush writes them.
    let error = write(path, |to| to.write_all(b"x")).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    assert!(error.to_string().contains("/dev/full"), "{error}");
    assert!(!path.metadata().unwrap().is_file());
}

/// Checks that a link to a file that does not exist yet is followed, too.
#[cfg(unix)]
#[test]
fn a_link_without_a_file_stays() {
    let folder = folder("dangling");
    fs::create_dir(folder.join("disk")).unwrap();
    let (near, far) = (folder.join("near"), folder.join("far"));
    std::os::unix::fs::symlink("disk/file", &far).unwrap();
    std::os::unix::fs::symlink("far", &near).unwrap();
    write(&near, |to| to.write_all(b"new")).unwrap();
    assert!([near, far].iter().all(|link| link.is_symlink()));
    assert_eq!(fs::read(folder.join("disk/file")).unwrap(), b"new");
    let (first, second) = (folder.join("first"), folder.join("second"));
    std::os::unix::fs::symlink(&first, &second).unwrap();
    std::os::unix::fs::symlink(&second, &first).unwrap();
    write(&first, |_| Ok(())).unwrap_err();
    fs::remove_dir_all(folder).unwrap();
}

#[cfg(feature = "checkpoint")]
mod leftovers {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    use super::super::{is_temporary_name, remove_leftovers, try_replace};
    use super::*;

    /// The folder in which a copy of this test writes until it is killed.
    const FOLDER: &str = "SVE_TEST_WRITER_THAT_IS_KILLED";

    #[test]
    fn a_trial_leaves_the_old_file_and_nothing_else() {
        let folder = folder("trial");
        let path = folder.join("x");
        let trial = |to: &mut io::BufWriter<fs::File>| to.write_all(b"trial");
        try_replace(&path, trial).unwrap();
        assert_eq!(files(&folder), 0);
        fs::write(&path, b"old").unwrap();
        try_replace(&path, trial).unwrap();
        assert_eq!(
            (fs::read(&path).unwrap(), files(&folder)),
            (b"old".to_vec(), 1)
        );
        let full = |_: &mut io::BufWriter<fs::File>| Err(io::ErrorKind::StorageFull.into());
        let error = try_replace(&path, full).unwrap_err();
        assert_eq!(
            (error.kind(), files(&folder)),
            (io::ErrorKind::StorageFull, 1)
        );
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn names_of_temporary_files_belong_to_one_file() {
        let is_of = |name: &str, target: &str| is_temporary_name(name.as_ref(), target.as_ref());
        assert!(is_of(".run.sve.12-0.new", "run.sve"));
        for (name, target) in [
            (".run.sve.12-0.new", "run"),
            (".run.sve.12-0.new", "sve"),
            (".run.sve.12-0.new", "run.sve.12"),
            (".run.sve.old.12-0.new", "run.sve"),
            ("run.sve.12-0.new", "run.sve"),
            (".run.sve.12-0.new2", "run.sve"),
            (".run.sve.12.new", "run.sve"),
            (".run.sve.12-.new", "run.sve"),
            (".run.sve.-0.new", "run.sve"),
            (".run.sve.1-2-3.new", "run.sve"),
            (".run.sve.+1-2.new", "run.sve"),
            (".run.sve.new", "run.sve"),
        ] {
            assert!(!is_of(name, target), "{name} of {target}");
        }
    }

    /// Waits until another process has reached a state.
    fn wait(until: impl Fn() -> bool) {
        let start = Instant::now();
        while !until() {
            assert!(start.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn the_file_of_a_killed_writer_is_removed_and_that_of_a_living_one_stays() {
        if let Some(folder) = std::env::var_os(FOLDER) {
            let path = PathBuf::from(folder).join("x.sve");
            let error = write(&path, |to| {
                to.write_all(b"half")?;
                to.flush()?;
                std::thread::sleep(Duration::from_secs(600));
                Ok(())
            });
            panic!("{error:?}: not killed");
        }
        let folder = folder("killed");
        let path = folder.join("x.sve");
        let others = [".x.sve.old.1-0.new", ".y.sve.1-0.new", "x.sve.1-0.new"];
        for name in others {
            fs::write(folder.join(name), b"").unwrap();
        }
        let name = "the_file_of_a_killed_writer_is_removed_and_that_of_a_living_one_stays";
        let mut writer = Command::new(std::env::current_exe().unwrap())
            .args([name, "--test-threads", "1"])
            .env(FOLDER, &folder)
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        wait(|| {
            let mut entries = fs::read_dir(&folder).unwrap();
            entries.any(|entry| fs::read(entry.unwrap().path()).is_ok_and(|text| text == b"half"))
        });
        remove_leftovers(&path);
        assert_eq!(files(&folder), 1 + others.len());
        // Another run may write the same file beside the temporary file of the living writer.
        write(&path, |to| to.write_all(b"whole")).unwrap();
        assert_eq!(files(&folder), 2 + others.len());
        writer.kill().unwrap();
        writer.wait().unwrap();
        assert_eq!(files(&folder), 2 + others.len());
        remove_leftovers(&path);
        assert_eq!(files(&folder), 1 + others.len());
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        fs::remove_dir_all(folder).unwrap();
    }
}
