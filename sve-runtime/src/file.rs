//! Atomic writing of files.
//!
//! Input: a path, and a function that writes the content. Output: the file, or an error with the
//! path. Invariant: at any time the path leads to the old file or to the complete new one; after an
//! error nothing of the new file remains.
//!
//! The content goes into a temporary file of the same folder, which is flushed, synchronised with
//! the disk and renamed. A path that is not a regular file, such as a device or a pipe, is written
//! directly: it has no content to replace.
//!
//! A killed process leaves its temporary file. A writer holds a lock on its temporary file until
//! the file is renamed, and the system releases the locks of a process that ends. So a temporary
//! file that can be locked has no writer, on any machine, and [`remove_leftovers`] removes it.

use core::fmt;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions, Permissions, TryLockError};
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

/// Writes a file as [`write`] does, with the errors of the system themselves.
pub(crate) fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    match Target::of(path)? {
        Target::Special => write_special(path, write),
        Target::Regular { path, permissions } => {
            let (new, file) = NewFile::with_content(&path, permissions, write)?;
            let renamed = new.rename(&path);
            // The lock is held until the file has its name, so that no other process takes the file
            // for a leftover.
            drop(file);
            renamed
        }
    }
}

/// Checks that a file can be written: does the same as [`replace`], but leaves an old file
/// unchanged.
///
/// # Errors
/// As [`replace`].
#[cfg(feature = "checkpoint")]
pub(crate) fn try_replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    match Target::of(path)? {
        Target::Special => write_special(path, write),
        Target::Regular { path, permissions } => {
            NewFile::with_content(&path, permissions, write).map(drop)
        }
    }
}

/// Removes the temporary files that killed writers of a file have left. Files that cannot be
/// removed stay, and so do files on a file system without locks.
#[cfg(feature = "checkpoint")]
pub(crate) fn remove_leftovers(path: &Path) {
    let Ok(Target::Regular { path, .. }) = Target::of(path) else {
        return;
    };
    let Some(name) = path.file_name() else {
        return;
    };
    let folder = folder_of(&path);
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !is_file || !is_temporary_name(&entry.file_name(), name) {
            continue;
        }
        let path = entry.path();
        if let Ok(file) = OpenOptions::new().write(true).open(&path)
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(path);
        }
    }
}

/// The kind of file that a path leads to.
enum Target {
    /// A device, a pipe or a folder.
    Special,
    /// A regular file, or a file that does not exist yet. Links are followed: the file that a link
    /// leads to is replaced, and the link stays.
    Regular {
        path: PathBuf,
        /// The permissions of the old file, if there is one.
        permissions: Option<Permissions>,
    },
}

impl Target {
    fn of(path: &Path) -> io::Result<Self> {
        match fs::metadata(path) {
            Ok(old) if old.is_file() => {
                // a file without write permission is not replaced
                OpenOptions::new().write(true).open(path)?;
                Ok(Self::Regular {
                    path: fs::canonicalize(path)?,
                    permissions: Some(old.permissions()),
                })
            }
            Ok(_) => Ok(Self::Special),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let mut path = path.to_owned();
                // An endless chain of links is another error than a missing file.
                while let Ok(next) = fs::read_link(&path) {
                    path = folder_of(&path).join(next);
                }
                let permissions = None;
                Ok(Self::Regular { path, permissions })
            }
            Err(error) => Err(error),
        }
    }
}

fn write_special(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    let mut special = BufWriter::new(OpenOptions::new().write(true).open(path)?);
    write(&mut special)?;
    special.flush()
}

/// Returns the folder of a file.
fn folder_of(path: &Path) -> &Path {
    let folder = path.parent().filter(|folder| folder != &Path::new(""));
    folder.unwrap_or(Path::new("."))
}

/// Returns the name of a temporary file: the name of the target between dots, the number of the
/// process, and `number`.
fn temporary_name(target: &OsStr, number: u64) -> OsString {
    let mut name = OsString::from(".");
    name.push(target);
    name.push(format!(".{}-{number}.new", std::process::id()));
    name
}

/// Returns whether a file has the name of a temporary file of this target.
#[cfg(feature = "checkpoint")]
fn is_temporary_name(name: &OsStr, target: &OsStr) -> bool {
    let are_digits = |bytes: &[u8]| !bytes.is_empty() && bytes.iter().all(u8::is_ascii_digit);
    let name = name.as_encoded_bytes();
    let numbers = (name.strip_prefix(b"."))
        .and_then(|rest| rest.strip_prefix(target.as_encoded_bytes()))
        .and_then(|rest| rest.strip_prefix(b"."))
        .and_then(|rest| rest.strip_suffix(b".new"));
    let mut numbers = numbers.into_iter().flat_map(|n| n.split(|&b| b == b'-'));
    numbers.next().is_some_and(are_digits)
        && numbers.next().is_some_and(are_digits)
        && numbers.next().is_none()
}

/// A temporary file that is removed unless it is renamed.
struct NewFile {
    path: PathBuf,
    is_renamed: bool,
}

impl NewFile {
    /// Writes a temporary file in the folder of another one, and synchronises it with the disk.
    fn with_content(
        target: &Path,
        permissions: Option<Permissions>,
        write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> io::Result<(Self, File)> {
        let (new, file) = Self::beside(target)?;
        let mut to = BufWriter::new(file);
        write(&mut to)?;
        let file = to.into_inner().map_err(io::IntoInnerError::into_error)?;
        if let Some(permissions) = permissions {
            file.set_permissions(permissions)?;
        }
        file.sync_all()?;
        Ok((new, file))
    }

    /// Creates a temporary file in the folder of another one, and locks it.
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
            let path = target.with_file_name(temporary_name(name, number));
            let file = match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => file,
                // a killed process with this number left the file
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                Err(error) => return Err(error),
            };
            let is_renamed = false;
            let new = Self { path, is_renamed };
            // Before the lock, another process can have taken the file for a leftover. A file
            // system without locks returns another error.
            let is_taken = matches!(file.try_lock(), Err(TryLockError::WouldBlock))
                || matches!(new.path.try_exists(), Ok(false));
            if !is_taken {
                return Ok((new, file));
            }
        }
    }

    fn rename(mut self, target: &Path) -> io::Result<()> {
        fs::rename(&self.path, target)?;
        self.is_renamed = true;
        // Synchronising the folder writes the new name. Some file systems do not support this, and
        // write the name later.
        #[cfg(unix)]
        if let Ok(folder) = File::open(folder_of(target)) {
            let _ = folder.sync_all();
        }
        Ok(())
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        if !self.is_renamed {
            // The earlier error is reported.
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
#[path = "file_tests.rs"]
mod tests;
