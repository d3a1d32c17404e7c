//! The durable record of finished samples: a result counts once it is in the record.
//!
//! One embedded transactional store (`ledger.redb`) in the result directory: `results` maps a sample number to its [`Entry`] with the
//! [`SampleKey`] of its inputs, `header` identifies the study of the numbers. Results are committed in groups, one sync per group, at the
//! latest [`Record::GROUP_AGE`] after the first result of a group; a crash can lose no more than that. The result tables are built from
//! the record alone.
//!
//! A store is created under a temporary name and renamed, so it is either whole or absent. A change of the numbering or a removal of entries
//! (a larger study, a rerun) writes a new store and renames it over the old one. Reading alone ([`Reader::open`]) never changes the file. A
//! store that cannot be opened any more is searched for entries ([`Remains`]): each has its key and a checksum.

mod entry;
mod error;
mod layout;
mod overlay;
mod read;
mod salvage;
mod store;

pub use entry::{Entry, EntryError, Head};
pub use error::RecordError;
pub use layout::RECORD_VERSION;
pub use read::{Reader, View};
pub use salvage::Remains;

use bladeoff_study::SampleKey;
use bladeoff_system::files::{FileError, create_beside};
use bladeoff_system::place::{Identity, Place};
use error::guarded;
use layout::{CACHE_BYTES, HEADER, RESULTS, VERSION_KEY};
use redb::Database;
use std::fs::File;
use std::os::unix::fs::MetadataExt;
use std::sync::Arc;
use std::time::{Duration, Instant};
use store::Store;

/// The open store of one run.
#[derive(Debug)]
pub struct Record {
    reader: Reader,
    /// Device and inode of the file, independent of its name.
    identity: Identity,
    /// Name of the file until it is published.
    temporary_name: Option<TemporaryName>,
    gathered: Vec<(u64, Vec<u8>)>,
    oldest: Option<Instant>,
}

/// The name of an unpublished store; dropping the value removes the file.
#[derive(Debug)]
struct TemporaryName(Place);

impl Drop for TemporaryName {
    fn drop(&mut self) {
        // A published file has another name by now; after an error the file is useless.
        let _ = self.0.remove();
    }
}

impl Record {
    /// Largest age of a gathered result before its group is committed.
    pub const GROUP_AGE: Duration = Duration::from_millis(500);
    /// Largest number of results of one group.
    pub const GROUP_SIZE: usize = 4096;

    /// Creates a store under a temporary name, closed to other users, who could lock it; [`Record::publish`] renames it. `header`: properties that
    /// the entries depend on.
    ///
    /// # Errors
    /// The file cannot be created or written.
    pub fn create(path: impl Into<Place>, header: &[(String, String)]) -> Result<Self, RecordError> {
        let path = path.into();
        let failed = |source| RecordError::store("create", &path, source);
        let (file, place) = create_beside(&path, Place::create_closed)?;
        let name = TemporaryName(place);
        let record = Self::over(file, &path, failed)?;
        record.write_header(header).map_err(failed)?;
        Ok(Self { temporary_name: Some(name), ..record })
    }

    /// The store in a file that is open for writing.
    fn over(file: File, path: &Place, failed: impl Fn(redb::Error) -> RecordError) -> Result<Self, RecordError> {
        let about = file.metadata().map_err(FileError::at("read", path))?;
        let created = Database::builder().set_cache_size(CACHE_BYTES).create_file(file);
        let database = created.map_err(|source| failed(source.into()))?;
        let reader = Reader { store: Arc::new(Store::new(database)), path: path.clone() };
        let identity = (about.dev(), about.ino());
        Ok(Self { reader, identity, temporary_name: None, gathered: Vec::new(), oldest: None })
    }

    /// Whether the path still leads to this store; also true if the path cannot be examined.
    #[must_use]
    pub fn is_in_place(&self) -> bool {
        self.reader.path.identity().map_or(true, |found| found == Some(self.identity))
    }

    /// Commits the gathered results and renames the store to its final name, replacing the file there.
    ///
    /// # Errors
    /// The store cannot be written or renamed.
    pub fn publish(&mut self) -> Result<(), RecordError> {
        self.commit()?;
        let path = &self.reader.path;
        if let Some(aside) = &self.temporary_name {
            aside.0.rename_to(path).map_err(FileError::at("rename to", path))?;
        }
        self.temporary_name = None;
        Ok(path.sync_parent()?)
    }

    /// Opens the store of an earlier run; all pages are checked before anything is added.
    ///
    /// # Errors
    /// As [`Reader::open`] and [`Reader::into_record`].
    pub fn open(path: impl Into<Place>) -> Result<Self, RecordError> {
        Reader::open(path)?.into_record()
    }

    /// Replaces the header.
    ///
    /// # Errors
    /// The store cannot be written.
    pub fn replace_header(&self, header: &[(String, String)]) -> Result<(), RecordError> {
        self.write_header(header).map_err(|source| RecordError::store("write", &self.reader.path, source))
    }

    fn write_header(&self, header: &[(String, String)]) -> Result<(), redb::Error> {
        let transaction = self.reader.store.begin_write()?;
        {
            let mut table = transaction.open_table(HEADER)?;
            table.retain(|_, _| false)?;
            for (key, value) in header {
                table.insert(key.as_str(), value.as_str())?;
            }
            table.insert(VERSION_KEY, RECORD_VERSION.to_string().as_str())?;
            transaction.open_table(RESULTS)?;
        }
        transaction.commit()?;
        Ok(())
    }

    /// Adds a result, which is durable after the next commit. Commits the group if it is full or old enough.
    ///
    /// # Errors
    /// The store cannot be written (disk full): the gathered results are kept for another attempt.
    pub fn put(&mut self, sample: u64, key: SampleKey, entry: &Entry, now: Instant) -> Result<(), RecordError> {
        self.gathered.push((sample, entry.encode(key)));
        self.oldest.get_or_insert(now);
        self.commit_if_due(now)
    }

    /// Adds the bytes of an entry of another store; the entry is durable after the next commit.
    ///
    /// # Errors
    /// As [`Record::put`].
    pub fn put_bytes(&mut self, sample: u64, bytes: Vec<u8>) -> Result<(), RecordError> {
        self.gathered.push((sample, bytes));
        if self.gathered.len() >= Self::GROUP_SIZE { self.commit() } else { Ok(()) }
    }

    /// Number of results that are not durable yet.
    #[must_use]
    pub fn gathered(&self) -> usize {
        self.gathered.len()
    }

    /// Commits the gathered results if the group is full or old enough.
    ///
    /// # Errors
    /// As [`Record::put`].
    pub fn commit_if_due(&mut self, now: Instant) -> Result<(), RecordError> {
        let old = self.oldest.is_some_and(|oldest| now.duration_since(oldest) >= Self::GROUP_AGE);
        if old || self.gathered.len() >= Self::GROUP_SIZE { self.commit() } else { Ok(()) }
    }

    /// Commits the gathered results.
    ///
    /// # Errors
    /// As [`Record::put`].
    pub fn commit(&mut self) -> Result<(), RecordError> {
        if self.gathered.is_empty() {
            return Ok(());
        }
        self.write_gathered().map_err(|source| RecordError::store("write", &self.reader.path, source))?;
        self.gathered.clear();
        self.oldest = None;
        Ok(())
    }

    fn write_gathered(&self) -> Result<(), redb::Error> {
        let transaction = self.reader.store.begin_write()?;
        {
            let mut table = transaction.open_table(RESULTS)?;
            for (sample, bytes) in &self.gathered {
                table.insert(sample, bytes.as_slice())?;
            }
        }
        transaction.commit()?;
        Ok(())
    }

    /// The reader of this store, which can be used from another thread.
    #[must_use]
    pub fn reader(&self) -> &Reader {
        &self.reader
    }
}

impl Reader {
    /// Reopens the store for writing.
    ///
    /// # Errors
    /// The store cannot be written, or another process has locked it.
    pub fn into_record(self) -> Result<Record, RecordError> {
        let Self { store, path } = self;
        drop(store);
        let failed = |source| RecordError::store("open", &path, source);
        guarded(&path, || Record::over(path.open_own()?, &path, failed))
    }
}

/// First bytes of every store whose header is intact.
const STORE_MAGIC: [u8; 9] = *b"redb\x1A\x0A\xA9\x0D\x0A";

/// Whether a file begins like a store.
#[must_use]
pub fn is_store(place: &Place) -> bool {
    let mut first = [0; STORE_MAGIC.len()];
    let read = |mut file: File| std::io::Read::read_exact(&mut file, &mut first).is_ok();
    place.open().is_ok_and(read) && first == STORE_MAGIC
}

#[cfg(test)]
mod tests;
