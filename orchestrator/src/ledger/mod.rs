//! The durable record of what is done: a result counts when it is here.
//!
//! One embedded transactional store (`ledger.redb`) in the result directory: `results` maps a sample number to its
//! [`Entry`], `header` says which study they belong to. Results are gathered and committed in groups, one sync per
//! group, at the latest [`Ledger::GROUP_AGE`] after the first of them: that is what a crash can cost. The result
//! tables are built from here and from nowhere else.

mod record;

pub use record::{Entry, RecordError};

use redb::{Database, ReadableDatabase, ReadableTable, ReadableTableMetadata, TableDefinition};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const RESULTS: TableDefinition<u64, &[u8]> = TableDefinition::new("results");
const HEADER: TableDefinition<&str, &str> = TableDefinition::new("header");

/// Version of the store's layout.
pub const LEDGER_VERSION: u32 = 1;

/// The open store of one run.
#[derive(Debug)]
pub struct Ledger {
    database: Database,
    path: PathBuf,
    gathered: Vec<(u64, Vec<u8>)>,
    oldest: Option<Instant>,
}

/// What can go wrong with the record.
#[derive(Debug, thiserror::Error)]
pub enum LedgerError {
    /// The store failed.
    #[error("cannot {action} the record of finished samples {}", path.display())]
    Store {
        /// "create", "write" or "read".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the store said.
        #[source]
        source: Box<redb::Error>,
    },
    /// An entry cannot be read.
    #[error("sample {sample} in {} cannot be read", path.display())]
    Record {
        /// Its number.
        sample: u64,
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        #[source]
        source: RecordError,
    },
}

impl Ledger {
    /// Largest age of a gathered result before its group is committed.
    pub const GROUP_AGE: Duration = Duration::from_millis(500);
    /// Largest number of results of one group.
    pub const GROUP_SIZE: usize = 4096;

    /// Creates the store of a new run. `header`: what the entries depend on (study, machine, basis, versions).
    ///
    /// # Errors
    /// The file cannot be created or written.
    pub fn create(path: &Path, header: &[(String, String)]) -> Result<Self, LedgerError> {
        let failed =
            |source| LedgerError::Store { action: "create", path: path.to_path_buf(), source: Box::new(source) };
        let database = Database::create(path).map_err(|source| failed(source.into()))?;
        let ledger = Self { database, path: path.to_path_buf(), gathered: Vec::new(), oldest: None };
        ledger.write_header(header).map_err(failed)?;
        Ok(ledger)
    }

    fn write_header(&self, header: &[(String, String)]) -> Result<(), redb::Error> {
        let transaction = self.database.begin_write()?;
        {
            let mut table = transaction.open_table(HEADER)?;
            table.insert("ledger_version", LEDGER_VERSION.to_string().as_str())?;
            for (key, value) in header {
                table.insert(key.as_str(), value.as_str())?;
            }
            transaction.open_table(RESULTS)?;
        }
        transaction.commit()?;
        Ok(())
    }

    /// Takes a result; it is durable after the next commit. Commits the group when it is full or old enough.
    ///
    /// # Errors
    /// The store cannot be written (disk full): the results gathered so far are kept for another try.
    pub fn put(&mut self, sample: u64, entry: &Entry, now: Instant) -> Result<(), LedgerError> {
        self.gathered.push((sample, entry.encode()));
        self.oldest.get_or_insert(now);
        self.commit_if_due(now)
    }

    /// Commits the gathered results if the group is full or old enough.
    ///
    /// # Errors
    /// As [`Ledger::put`].
    pub fn commit_if_due(&mut self, now: Instant) -> Result<(), LedgerError> {
        let old = self.oldest.is_some_and(|oldest| now.duration_since(oldest) >= Self::GROUP_AGE);
        if old || self.gathered.len() >= Self::GROUP_SIZE { self.commit() } else { Ok(()) }
    }

    /// Commits the gathered results.
    ///
    /// # Errors
    /// As [`Ledger::put`].
    pub fn commit(&mut self) -> Result<(), LedgerError> {
        if self.gathered.is_empty() {
            return Ok(());
        }
        self.write_gathered().map_err(|source| self.failed("write", source))?;
        self.gathered.clear();
        self.oldest = None;
        Ok(())
    }

    fn write_gathered(&self) -> Result<(), redb::Error> {
        let transaction = self.database.begin_write()?;
        {
            let mut table = transaction.open_table(RESULTS)?;
            for (sample, bytes) in &self.gathered {
                table.insert(sample, bytes.as_slice())?;
            }
        }
        transaction.commit()?;
        Ok(())
    }

    /// Number of samples with a durable result.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn len(&self) -> Result<u64, LedgerError> {
        let read = || -> Result<u64, redb::Error> { Ok(self.database.begin_read()?.open_table(RESULTS)?.len()?) };
        read().map_err(|source| self.failed("read", source))
    }

    /// Whether no sample has a durable result.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn is_empty(&self) -> Result<bool, LedgerError> {
        Ok(self.len()? == 0)
    }

    /// Calls `visit` for every durable result in ascending order of its sample number.
    ///
    /// # Errors
    /// The store cannot be read, or an entry of it; what `visit` returns.
    pub fn for_each<E: From<LedgerError>>(&self, mut visit: impl FnMut(u64, Entry) -> Result<(), E>) -> Result<(), E> {
        let failed = |source| E::from(self.failed("read", source));
        let transaction = self.database.begin_read().map_err(|source| failed(source.into()))?;
        let table = transaction.open_table(RESULTS).map_err(|source| failed(source.into()))?;
        for item in table.iter().map_err(|source| failed(source.into()))? {
            let (sample, bytes) = item.map_err(|source| failed(source.into()))?;
            let sample = sample.value();
            let entry = Entry::decode(bytes.value())
                .map_err(|source| E::from(LedgerError::Record { sample, path: self.path.clone(), source }))?;
            visit(sample, entry)?;
        }
        Ok(())
    }

    fn failed(&self, action: &'static str, source: redb::Error) -> LedgerError {
        LedgerError::Store { action, path: self.path.clone(), source: Box::new(source) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_core::outcome::{CauseSet, EndCause, Outcome, Status};

    fn entry(value: f64) -> Entry {
        let outcome = Outcome {
            status: Status::Ok,
            cause: None,
            causes: CauseSet::default(),
            end_cause: EndCause::EndTime,
            values: vec![Some(value), None],
        };
        Entry { outcome, cpu_s: 0.5, worker: 1, attempt: 2 }
    }

    #[test]
    fn results_come_back_in_order_of_their_number() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let mut ledger = Ledger::create(&directory.path().join("ledger.redb"), &[]).expect("create");
        let now = Instant::now();
        for sample in [5u64, 1, 3] {
            ledger.put(sample, &entry(sample as f64), now).expect("put");
        }
        assert_eq!(ledger.len().expect("read"), 0, "not yet committed");
        ledger.commit_if_due(now + Ledger::GROUP_AGE).expect("commit");
        let mut seen = Vec::new();
        ledger
            .for_each::<LedgerError>(|sample, found| {
                assert_eq!(found, entry(sample as f64));
                seen.push(sample);
                Ok(())
            })
            .expect("read");
        assert_eq!(seen, [1, 3, 5]);
    }

    #[test]
    fn a_second_opener_is_refused_while_the_first_lives() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let path = directory.path().join("ledger.redb");
        let first = Ledger::create(&path, &[]).expect("create");
        assert!(matches!(Ledger::create(&path, &[]), Err(LedgerError::Store { .. })));
        drop(first);
    }
}
