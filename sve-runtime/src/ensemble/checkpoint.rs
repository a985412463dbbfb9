//! Checkpoints: files from which a stopped run continues.
//!
//! Input: the merged results of the finished blocks. Output: a file, which replaces the previous
//! file atomically, so that a complete file always exists. Invariants: a continued run has the bits
//! of an uninterrupted run, since blocks merge in the same tree; the content of a file is read only
//! if its length and checksum are right; a file that cannot be written is an error before the first
//! path, and a warning after it, so that no results are lost.
//!
//! Layout: [`MAGIC`], version (4 bytes), length of the content (8), checksum (8), content. Numbers
//! are little-endian. The checksum is XXH64 of version, length and content. The content is
//! [`Contents`], serialised by postcard.

use core::hash::Hasher as _;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use twox_hash::XxHash64;

use super::attempts::Attempts;
use super::difference::{Damage, Difference};
use super::execution::locked;
use super::info::Info;
use super::merge_tree::MergeTree;
use super::settings::Settings;
use super::stored::{FORMAT, LoadedSummary, StoredSummary};
use super::{Ensemble, EnsembleError, Warning};
use crate::ensemble::PathMethod;

/// The first bytes of a file of any version.
const MAGIC: &[u8; 8] = b"sve run\0";

/// Bytes before the content.
const HEADER_LENGTH: usize = MAGIC.len() + 4 + 8 + 8;

impl<I: PathMethod, K> Ensemble<'_, I, K> {
    /// Writes the results of finished blocks to a file, at this interval and at the end, for
    /// [`resume`](Self::resume).
    ///
    /// The file is always complete: a new file is written, synchronised with the disk and renamed.
    /// A run without `resume` replaces an existing file once a block of paths has ended.
    ///
    /// A file that cannot be written is an error before the first path is computed: the run tries
    /// the write. If a later write fails, for example since the disk is full, the run continues. It
    /// prints a message on standard error, tries again after the interval, or after 10 s if the
    /// interval is longer, and at the end. The summary then has a [`Warning::Checkpoint`].
    /// Temporary files that killed runs have left beside this file are removed; the files of runs
    /// that still write are locked, and stay. On a file system without locks all of them stay:
    /// `.checkpoint.sve.1234-0.new` is a temporary file of `checkpoint.sve`.
    ///
    #[doc = include_str!("example.md")]
    /// # let folder = std::env::temp_dir().join(format!("sve-checkpoint-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder)?;
    /// use std::time::Duration;
    /// let file = folder.join("checkpoint.sve");
    /// ensemble().checkpoint(&file, Duration::from_secs(60)).run()?;
    /// assert!(file.exists());
    /// # std::fs::remove_dir_all(&folder)?;
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn checkpoint(mut self, path: impl Into<PathBuf>, every: Duration) -> Self {
        self.execution.checkpoint = Some((path.into(), every));
        self
    }

    /// Continues from the file of [`checkpoint`](Self::checkpoint) if it exists, with the bits of a
    /// run that was not stopped.
    ///
    /// The file has to be undamaged, which its length and a checksum show, and of the same run:
    /// settings, formulas and parameters of the system, method and starts. Otherwise
    /// [`run`](Self::run) returns an error that names the damage or the difference between the
    /// runs. Closures are compared by samples only, see [`Summary::merge`](super::Summary::merge).
    ///
    #[doc = include_str!("example.md")]
    /// # let folder = std::env::temp_dir().join(format!("sve-resume-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder)?;
    /// use std::time::Duration;
    /// let file = folder.join("resume.sve");
    /// let run = || ensemble().checkpoint(&file, Duration::from_secs(60)).resume(true).run();
    /// assert_eq!(run()?["q"].mean(), run()?["q"].mean()); // the second one only reads
    /// # std::fs::remove_dir_all(&folder)?;
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn resume(mut self, resume: bool) -> Self {
        self.execution.resume = resume;
        self
    }
}

impl<I: PathMethod> Ensemble<'_, I> {
    /// Checks that the file of [`checkpoint`](Self::checkpoint) can be written, if there is one,
    /// and that a file to [`resume`](Self::resume) is undamaged. Removes the temporary files that
    /// killed runs have left. [`run`](Self::run) begins with this check.
    ///
    /// # Errors
    /// [`EnsembleError::Checkpoint`] if the file cannot be read or written, and errors that
    /// describe its content if the content is wrong.
    pub fn try_checkpoint(&self) -> Result<(), EnsembleError> {
        let Some((path, _)) = &self.execution.checkpoint else {
            return Ok(());
        };
        if self.execution.resume {
            read(path)?;
        }
        crate::file::remove_leftovers(path);
        // a device that is full takes no byte
        crate::file::try_replace(path, |to| to.write_all(&header(&[])))
            .map_err(|error| failed(path, error))
    }
}

impl<I: PathMethod> Settings<'_, I> {
    /// Returns the checkpoint of the run, if there is one.
    pub(super) fn checkpoint(&self, info: &Info) -> Option<CheckpointFile> {
        let (path, interval) = self.ensemble.execution.checkpoint.clone()?;
        Some(CheckpointFile {
            path,
            info: info.clone(),
            shard: self.shard,
            attempts: Mutex::new(Attempts::new(interval)),
        })
    }
}

/// The content of a file in the form in which it is written.
#[derive(Serialize)]
struct Contents<'a> {
    shard: [u64; 2],
    summary: StoredSummary<'a>,
}

/// The content of a file in the form in which it is read.
#[derive(Deserialize)]
struct LoadedContents {
    shard: [u64; 2],
    summary: LoadedSummary,
}

/// The checkpoint file of a run.
pub(super) struct CheckpointFile {
    path: PathBuf,
    info: Info,
    shard: [u64; 2],
    attempts: Mutex<Attempts>,
}

impl CheckpointFile {
    /// Reads the results of the file, if it exists.
    pub(super) fn load(&self) -> Result<Option<MergeTree>, EnsembleError> {
        let path = || self.path.clone();
        let Some(bytes) = read(&self.path)? else {
            return Ok(None);
        };
        let inconsistent = || EnsembleError::DamagedCheckpoint {
            path: path(),
            damage: Damage::Content,
        };
        let Ok((LoadedContents { shard, summary }, [])) =
            postcard::take_from_bytes(&bytes[HEADER_LENGTH..])
        else {
            return Err(inconsistent());
        };
        let of_another_run = |what| Err(EnsembleError::OtherCheckpoint { path: path(), what });
        if let Some(what) = self.info.difference(&summary.run) {
            return of_another_run(what);
        }
        if shard != self.shard {
            return of_another_run(Difference::Shard);
        }
        let (_, tree) = summary.checked().ok_or_else(inconsistent)?;
        Ok(Some(tree))
    }

    /// Returns whether the file is due to be written, and starts the next interval if it is. The
    /// caller that gets `true` writes the file.
    pub(super) fn is_due(&self) -> bool {
        locked(&self.attempts).is_due(Instant::now())
    }

    /// Writes the file, if there are results. If writing fails, prints a message on standard error,
    /// unless the attempt before has failed too; the next attempt comes soon.
    pub(super) fn save(&self, tree: &MergeTree) {
        if tree.nodes.is_empty() {
            return;
        }
        let written = self.write(tree);
        let error = written.as_ref().err().map(io::Error::to_string);
        let is_first = locked(&self.attempts).add(written);
        if let Some(error) = error.filter(|_| is_first) {
            let path = self.path.display();
            eprintln!(
                "the checkpoint {path} could not be written: {error}; the run goes on and tries again"
            );
        }
    }

    fn write(&self, tree: &MergeTree) -> io::Result<()> {
        let contents = Contents {
            shard: self.shard,
            summary: StoredSummary::new(&self.info, tree),
        };
        let content = postcard::to_stdvec(&contents).map_err(io::Error::other)?;
        let header = header(&content);
        crate::file::replace(&self.path, |to| {
            to.write_all(&header)?;
            to.write_all(&content)
        })
    }

    /// Returns the warning about attempts to write the file that failed, if there are some.
    pub(super) fn warning(&self) -> Option<Warning> {
        locked(&self.attempts).warning(&self.path)
    }
}

/// Reads a file, if it exists, and checks its length, checksum and version.
fn read(path: &Path) -> Result<Option<Vec<u8>>, EnsembleError> {
    let bytes = match fs::metadata(path).map(|old| old.is_file()) {
        // A device has no results, and may have no end.
        Ok(false) => return Ok(None),
        Ok(true) => fs::read(path),
        Err(error) => Err(error),
    };
    let bytes = match bytes {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(failed(path, error)),
    };
    let path = path.to_owned();
    match check(&bytes) {
        Ok(()) => Ok(Some(bytes)),
        Err(Unreadable::NotACheckpoint) => Err(EnsembleError::NotACheckpoint { path }),
        Err(Unreadable::Version(version)) => Err(EnsembleError::CheckpointVersion {
            path,
            version,
            expected: FORMAT,
        }),
        Err(Unreadable::Damaged(damage)) => Err(EnsembleError::DamagedCheckpoint { path, damage }),
    }
}

fn failed(path: &Path, source: io::Error) -> EnsembleError {
    let path = path.to_owned();
    EnsembleError::Checkpoint { path, source }
}

/// Returns the bytes that precede a content.
fn header(content: &[u8]) -> Vec<u8> {
    let (version, length) = (FORMAT.to_le_bytes(), (content.len() as u64).to_le_bytes());
    let checksum = checksum(&version, &length, content).to_le_bytes();
    [&MAGIC[..], &version, &length, &checksum].concat()
}

fn checksum(version: &[u8], length: &[u8], content: &[u8]) -> u64 {
    let mut hash = XxHash64::default();
    hash.write(version);
    hash.write(length);
    hash.write(content);
    hash.finish()
}

/// The reason why the content of a file cannot be read.
enum Unreadable {
    /// The file is not a checkpoint.
    NotACheckpoint,
    /// The file has another version, which is given here.
    Version(u32),
    /// The file is damaged.
    Damaged(Damage),
}

/// Checks that the length, checksum and version of a file are right.
fn check(bytes: &[u8]) -> Result<(), Unreadable> {
    let found = bytes.len() as u64;
    let rest = bytes
        .strip_prefix(MAGIC)
        .ok_or(Unreadable::NotACheckpoint)?;
    let parts = rest.split_first_chunk::<4>().and_then(|(version, rest)| {
        let (length, rest) = rest.split_first_chunk::<8>()?;
        let (checksum, content) = rest.split_first_chunk::<8>()?;
        Some((version, length, u64::from_le_bytes(*checksum), content))
    });
    let damaged = |damage| Err(Unreadable::Damaged(damage));
    let Some((version, length, expected, content)) = parts else {
        return damaged(Damage::Length {
            expected: HEADER_LENGTH as u64,
            found,
        });
    };
    let expected_length = u64::from_le_bytes(*length).saturating_add(HEADER_LENGTH as u64);
    if expected_length != found {
        return damaged(Damage::Length {
            expected: expected_length,
            found,
        });
    }
    let checksum = checksum(version, length, content);
    if checksum != expected {
        let found = checksum;
        return damaged(Damage::Checksum { expected, found });
    }
    match u32::from_le_bytes(*version) {
        FORMAT => Ok(()),
        other => Err(Unreadable::Version(other)),
    }
}
