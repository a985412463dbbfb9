//! A file from which a run that was stopped continues.
//!
//! Input: the merged results of the blocks that have ended. Output: a file, written beside the old one and put in its place at once, so
//! that there is always a whole one. Invariant: the result of a continued run has the bits of one that was not stopped, since blocks
//! merge in the same tree.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::EnsembleError;
use super::summary::{Info, Summary};
use super::tree::Tree;

/// The first bytes of a file, and what they say of its format.
const MAGIC: &[u8; 8] = b"sve run1";

/// What a file has after those.
#[derive(Serialize, Deserialize)]
struct Contents {
    shard: [u64; 2],
    summary: Summary,
}

/// Keeps the file of a run.
pub(super) struct Keeper {
    path: PathBuf,
    every: Duration,
    info: Info,
    shard: [u64; 2],
    saved: Mutex<Instant>,
}

impl Keeper {
    pub(super) fn new(path: PathBuf, every: Duration, info: Info, shard: [u64; 2]) -> Self {
        Self {
            path,
            every,
            info,
            shard,
            saved: Mutex::new(Instant::now()),
        }
    }

    /// The results in the file, where there is one.
    pub(super) fn load(&self) -> Result<Option<Tree>, EnsembleError> {
        let path = self.path.as_path();
        let bytes = match fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(failed(path, error)),
        };
        let contents: Contents = bytes
            .strip_prefix(MAGIC)
            .and_then(|bytes| postcard::from_bytes(bytes).ok())
            .ok_or_else(|| EnsembleError::NotACheckpoint {
                path: path.to_owned(),
            })?;
        self.info.same_run(&contents.summary.info)?;
        if contents.shard != self.shard {
            return Err(EnsembleError::OtherRun { what: "shard" });
        }
        Ok(Some(contents.summary.tree))
    }

    /// Whether it is time to write the file; the one that is told so writes it.
    pub(super) fn is_due(&self) -> bool {
        let mut saved = self.saved.lock().unwrap_or_else(PoisonError::into_inner);
        let due = saved.elapsed() >= self.every;
        if due {
            *saved = Instant::now();
        }
        due
    }

    /// Writes the file.
    pub(super) fn save(&self, tree: &Tree) -> Result<(), EnsembleError> {
        let path = self.path.as_path();
        let contents = Contents {
            shard: self.shard,
            summary: Summary::new(self.info.clone(), tree.clone()),
        };
        let bytes =
            postcard::to_stdvec(&contents).map_err(|e| failed(path, io::Error::other(e)))?;
        replace(path, &bytes).map_err(|error| failed(path, error))
    }
}

fn failed(path: &Path, source: io::Error) -> EnsembleError {
    let path = path.to_owned();
    EnsembleError::Checkpoint { path, source }
}

/// Writes a file beside the old one and puts it in its place.
fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut name = path.as_os_str().to_owned();
    name.push(".new");
    let mut file = File::create(&name)?;
    file.write_all(MAGIC)?;
    file.write_all(bytes)?;
    file.sync_all()?;
    fs::rename(&name, path)
}
