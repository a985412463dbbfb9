//! Atomic writing of files.
//!
//! Input: a path, and what writes the content. Output: the file, or an error with the path. Invariant: at any time the path leads to
//! the old file or to the complete new one; after an error nothing of the new file remains.
//!
//! The content goes into a new file of the same folder, which is flushed, synchronised with the disk and renamed. A path that is
//! not a regular file, such as a device or a pipe, is written directly: it has no content to replace.

use core::fmt;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::readable::debug_is_display;

/// Writes a file.
///
/// # Errors
/// The errors of the file system and of `write`, with their kind and the path.
pub(crate) fn write(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    replace(path, write).map_err(|error| with_path(path, error))
}

/// Adds the path to an error.
pub(crate) fn with_path(path: &Path, source: io::Error) -> io::Error {
    let path = path.to_owned();
    io::Error::new(source.kind(), AtPath { path, source })
}

fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    let old = match fs::metadata(path) {
        Ok(old) if old.is_file() => {
            // a file without write permission is not replaced
            OpenOptions::new().write(true).open(path)?;
            Some(old)
        }
        Ok(_) => {
            let mut special = BufWriter::new(OpenOptions::new().write(true).open(path)?);
            write(&mut special)?;
            return special.flush();
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => return Err(error),
    };
    // the target of a link is replaced, and the link stays
    let target = if old.is_some() {
        fs::canonicalize(path)?
    } else {
        path.to_owned()
    };
    let (new, file) = NewFile::beside(&target)?;
    let mut to = BufWriter::new(file);
    write(&mut to)?;
    let file = to.into_inner().map_err(io::IntoInnerError::into_error)?;
    if let Some(old) = old {
        file.set_permissions(old.permissions())?;
    }
    file.sync_all()?;
    drop(file);
    new.rename(&target)
}

/// A temporary file that is removed unless it is renamed.
struct NewFile {
    path: PathBuf,
    is_renamed: bool,
}

impl NewFile {
    /// Creates a temporary file in the folder of another one.
    fn beside(target: &Path) -> io::Result<(Self, File)> {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let Some(name) = target.file_name() else {
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                "this path has no file name",
            ));
        };
        loop {
            let number = NUMBER.fetch_add(1, Ordering::Relaxed);
            let mut new = std::ffi::OsString::from(".");
            new.push(name);
            new.push(format!(".{}-{number}.new", std::process::id()));
            let path = target.with_file_name(new);
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => {
                    let is_renamed = false;
                    return Ok((Self { path, is_renamed }, file));
                }
                // a killed process with this number left the file
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
    }

    fn rename(mut self, target: &Path) -> io::Result<()> {
        fs::rename(&self.path, target)?;
        self.is_renamed = true;
        // Synchronising the folder writes the new name. Some file systems do not support this, and write the name later.
        #[cfg(unix)]
        if let Some(folder) = target
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty())
            && let Ok(folder) = File::open(folder)
        {
            let _ = folder.sync_all();
        }
        Ok(())
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        if !self.is_renamed {
            // the earlier error is reported
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Adds the path to an error of the file system.
struct AtPath {
    path: PathBuf,
    source: io::Error,
}

impl fmt::Display for AtPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.path.display(), self.source)
    }
}

debug_is_display!(AtPath);

impl core::error::Error for AtPath {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        Some(&self.source)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::io::{self, Write as _};
    use std::path::PathBuf;

    use super::write;

    /// An empty folder of its own.
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
        // few bytes, which only the flush writes
        let error = write(path, |to| to.write_all(b"x")).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        assert!(error.to_string().contains("/dev/full"), "{error}");
        assert!(!path.metadata().unwrap().is_file());
    }
}
