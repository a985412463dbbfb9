//! Checkpoints: files from which a stopped run continues.
//!
//! Input: the merged results of the finished blocks. Output: a file that replaces the old one atomically, so
//! that there is always a complete one. Invariants: the result of a continued run has the bits of one that was not stopped, since blocks
//! merge in the same tree; nothing of a file is read before its length and checksum are right.
//!
//! Layout: [`MAGIC`], version (4 bytes), length of the content (8), checksum (8), content; numbers with their low bytes first.
//! The checksum is XXH64 of all other bytes behind the magic. The content is postcard's form of [`Contents`].

use core::hash::Hasher as _;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use twox_hash::XxHash64;

use super::EnsembleError;
use super::error::{Damage, Difference};
use super::merge_tree::MergeTree;
use super::stored::{LoadedSummary, StoredSummary};
use super::summary::Info;

/// The first bytes of a file, in every version.
const MAGIC: &[u8; 8] = b"sve run\0";

/// Version of the content.
const VERSION: u32 = 2;

/// Bytes before the content.
const HEAD: usize = MAGIC.len() + 4 + 8 + 8;

/// The content that is written.
#[derive(Serialize)]
struct Contents<'a> {
    shard: [u64; 2],
    parts: StoredSummary<'a>,
}

/// The content that is read.
#[derive(Deserialize)]
struct OwnedContents {
    shard: [u64; 2],
    parts: LoadedSummary,
}

/// The checkpoint file of a run.
pub(super) struct CheckpointFile {
    path: PathBuf,
    every: Duration,
    info: Info,
    shard: [u64; 2],
    saved: Mutex<Instant>,
}

impl CheckpointFile {
    pub(super) fn new(path: PathBuf, every: Duration, info: Info, shard: [u64; 2]) -> Self {
        Self {
            path,
            every,
            info,
            shard,
            saved: Mutex::new(Instant::now()),
        }
    }

    /// Reads the results of the file, if it exists.
    pub(super) fn load(&self) -> Result<Option<MergeTree>, EnsembleError> {
        let path = self.path.as_path();
        let bytes = match fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(failed(path, error)),
        };
        let path = || path.to_owned();
        let content = match content_of(&bytes) {
            Ok(content) => content,
            Err(Unreadable::NotACheckpoint) => {
                return Err(EnsembleError::NotACheckpoint { path: path() });
            }
            Err(Unreadable::Version(version)) => {
                return Err(EnsembleError::CheckpointVersion {
                    path: path(),
                    version,
                    expected: VERSION,
                });
            }
            Err(Unreadable::Damaged(damage)) => {
                let path = path();
                return Err(EnsembleError::DamagedCheckpoint { path, damage });
            }
        };
        let inconsistent = || EnsembleError::DamagedCheckpoint {
            path: path(),
            damage: Damage::Content,
        };
        let Ok((OwnedContents { shard, parts }, [])) = postcard::take_from_bytes(content) else {
            return Err(inconsistent());
        };
        let other = |what| Err(EnsembleError::OtherCheckpoint { path: path(), what });
        if let Some(what) = self.info.difference(&parts.run) {
            return other(what);
        }
        if shard != self.shard {
            return other(Difference::Shard);
        }
        let (_, tree) = parts.checked().ok_or_else(inconsistent)?;
        Ok(Some(tree))
    }

    /// Returns whether the file is due to be written. The caller that gets `true` writes it.
    pub(super) fn is_due(&self) -> bool {
        let mut saved = self.saved.lock().unwrap_or_else(PoisonError::into_inner);
        let due = saved.elapsed() >= self.every;
        if due {
            *saved = Instant::now();
        }
        due
    }

    /// Writes the file, if there are results.
    pub(super) fn save(&self, tree: &MergeTree) -> Result<(), EnsembleError> {
        if tree.nodes.is_empty() {
            return Ok(());
        }
        let path = self.path.as_path();
        let contents = Contents {
            shard: self.shard,
            parts: StoredSummary::new(&self.info, tree),
        };
        let content =
            postcard::to_stdvec(&contents).map_err(|e| failed(path, io::Error::other(e)))?;
        let head = head(&content);
        crate::file::write(path, |to| {
            to.write_all(&head)?;
            to.write_all(&content)
        })
        .map_err(|error| failed(path, error))
    }
}

fn failed(path: &Path, source: io::Error) -> EnsembleError {
    let path = path.to_owned();
    EnsembleError::Checkpoint { path, source }
}

/// Returns the header of a content.
fn head(content: &[u8]) -> Vec<u8> {
    let (version, length) = (VERSION.to_le_bytes(), (content.len() as u64).to_le_bytes());
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

/// Why the content of a file is not read.
enum Unreadable {
    /// The file is not a checkpoint.
    NotACheckpoint,
    /// The file has this other version.
    Version(u32),
    /// The file is damaged.
    Damaged(Damage),
}

/// Returns the content of a file whose length, checksum and version are right.
fn content_of(bytes: &[u8]) -> Result<&[u8], Unreadable> {
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
            expected: HEAD as u64,
            found,
        });
    };
    let whole = u64::from_le_bytes(*length).saturating_add(HEAD as u64);
    if whole != found {
        return damaged(Damage::Length {
            expected: whole,
            found,
        });
    }
    let checksum = checksum(version, length, content);
    if checksum != expected {
        let found = checksum;
        return damaged(Damage::Checksum { expected, found });
    }
    match u32::from_le_bytes(*version) {
        VERSION => Ok(content),
        other => Err(Unreadable::Version(other)),
    }
}
