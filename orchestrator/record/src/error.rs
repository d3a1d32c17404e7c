//! Errors of the record, and which of them mean damage.

use super::entry::EntryError;
use super::layout::RECORD_VERSION;
use bladeoff_system::files::FileError;
use bladeoff_system::locks::{self, LockHolder};
use bladeoff_system::place::Place;
use bladeoff_system::shown;
use std::io;
use std::path::{Path, PathBuf};

/// Error of the record.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// An operation of the store failed.
    #[error("cannot {action} the record of finished samples {}", shown(path))]
    Store {
        /// "create", "open", "write" or "read".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// Error of the store.
        #[source]
        source: Box<redb::Error>,
    },
    /// The file is damaged.
    #[error("the record of finished samples {} is damaged: {detail}", shown(path))]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Description of the damage.
        detail: String,
    },
    /// Another process has locked the file.
    #[error(
        "the record of finished samples {} is locked by {}; when it has ended, rerun the same command to resume",
        shown(path),
        by.as_ref().map_or("a process that this system does not name (it may be of another host or container)".to_owned(), ToString::to_string)
    )]
    Held {
        /// The file.
        path: PathBuf,
        /// Holder of the lock, if the system lists it.
        by: Option<LockHolder>,
    },
    /// The store has another version.
    #[error(
        "{} was written by another version of the program (its layout is {found}, this one's {RECORD_VERSION}); choose another \
         --out",
        shown(path)
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// Version in the store.
        found: String,
    },
    /// An entry cannot be read.
    #[error("sample {sample} in {} cannot be read", shown(path))]
    Record {
        /// Number of the sample.
        sample: u64,
        /// The file.
        path: PathBuf,
        /// Reason.
        #[source]
        source: EntryError,
    },
    /// The result of a recorded sample is missing.
    #[error("sample {sample} is missing in {}", shown(path))]
    Missing {
        /// Number of the sample.
        sample: u64,
        /// The file.
        path: PathBuf,
    },
    /// A file operation failed.
    #[error(transparent)]
    File(#[from] FileError),
}

impl RecordError {
    /// Converts an error of the store during `action`.
    pub(super) fn store(action: &'static str, path: &Path, source: redb::Error) -> Self {
        let path = path.to_path_buf();
        let is_reading = matches!(action, "open" | "read");
        match source {
            redb::Error::Corrupted(detail) => Self::Damaged { path, detail },
            redb::Error::DatabaseAlreadyOpen => {
                let file = Place::from(&path).identity().ok().flatten();
                let by = file.and_then(|file| locks::holder(file, None).ok().flatten());
                Self::Held { path, by }
            }
            // The store reports these errors for a truncated or foreign file.
            redb::Error::Io(source)
                if is_reading && matches!(source.kind(), io::ErrorKind::UnexpectedEof | io::ErrorKind::InvalidData) =>
            {
                Self::Damaged { path, detail: source.to_string() }
            }
            // Our stores never had another format of the library: a changed byte can look like one.
            redb::Error::UpgradeRequired(found) => {
                Self::Damaged { path, detail: format!("its header names the older format {found} of the store") }
            }
            redb::Error::TableDoesNotExist(table) => Self::Damaged { path, detail: format!("it has no table {table}") },
            source @ (redb::Error::TableTypeMismatch { .. }
            | redb::Error::TypeDefinitionChanged { .. }
            | redb::Error::TableIsMultimap(_)) => Self::Damaged { path, detail: source.to_string() },
            source => Self::Store { action, path, source: Box::new(source) },
        }
    }
}

/// The library panics on some damaged files; that is reported as damage, too.
pub(super) fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, RecordError>) -> Result<T, RecordError> {
    bladeoff_system::guarded::guarded(read).unwrap_or_else(|| {
        Err(RecordError::Damaged { path: path.to_path_buf(), detail: "its structure contradicts itself".to_owned() })
    })
}
