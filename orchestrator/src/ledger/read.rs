//! Reading what is durable, also from another thread while results are added.

use super::{Entry, Head, LedgerError, RESULTS, RecordError, guarded};
use redb::{Database, ReadTransaction, ReadableDatabase, ReadableTable, ReadableTableMetadata};
use std::path::PathBuf;
use std::sync::Arc;

/// The durable results of an open store. Each call sees one state of it, whatever is added meanwhile.
#[derive(Debug, Clone)]
pub struct Reader {
    pub(super) database: Arc<Database>,
    pub(super) path: PathBuf,
}

impl Reader {
    /// Number of samples with a durable result.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn len(&self) -> Result<u64, LedgerError> {
        let read = || -> Result<u64, redb::Error> { Ok(self.database.begin_read()?.open_table(RESULTS)?.len()?) };
        read().map_err(|source| LedgerError::store("read", &self.path, source))
    }

    /// Whether no sample has a durable result.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn is_empty(&self) -> Result<bool, LedgerError> {
        Ok(self.len()? == 0)
    }

    /// The bytes of a sample's entry.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn bytes(&self, sample: u64) -> Result<Option<Vec<u8>>, LedgerError> {
        let read = || -> Result<_, redb::Error> {
            let table = self.database.begin_read()?.open_table(RESULTS)?;
            Ok(table.get(sample)?.map(|bytes| bytes.value().to_vec()))
        };
        guarded(&self.path, || read().map_err(|source| LedgerError::store("read", &self.path, source)))
    }

    /// Calls `visit` for the head of every durable result in ascending order of its sample number; what is damaged or of
    /// another version comes as an error of that sample.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn for_each_head(&self, mut visit: impl FnMut(u64, Result<Head, RecordError>)) -> Result<(), LedgerError> {
        guarded(&self.path, || {
            self.for_each_bytes(|sample, bytes| {
                visit(sample, Head::decode(bytes));
                Ok::<(), LedgerError>(())
            })
        })
    }

    /// Calls `visit` for every durable result in ascending order of its sample number.
    ///
    /// # Errors
    /// The store cannot be read, or an entry of it; what `visit` returns.
    pub fn for_each<E: From<LedgerError>>(&self, visit: impl FnMut(u64, Entry) -> Result<(), E>) -> Result<(), E> {
        self.state()?.for_each(visit)
    }

    fn for_each_bytes<E: From<LedgerError>>(&self, visit: impl FnMut(u64, &[u8]) -> Result<(), E>) -> Result<(), E> {
        self.state()?.for_each_bytes(visit)
    }

    /// The present state of the store, to be read later whatever is added meanwhile. The store grows as long as it is kept.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn state(&self) -> Result<State, LedgerError> {
        let transaction =
            self.database.begin_read().map_err(|source| LedgerError::store("read", &self.path, source.into()))?;
        Ok(State { transaction, path: self.path.clone() })
    }
}

/// The durable results of a store at one moment.
pub struct State {
    transaction: ReadTransaction,
    path: PathBuf,
}

impl State {
    /// Calls `visit` for every result in ascending order of its sample number.
    ///
    /// # Errors
    /// As [`Reader::for_each`].
    pub fn for_each<E: From<LedgerError>>(&self, mut visit: impl FnMut(u64, Entry) -> Result<(), E>) -> Result<(), E> {
        self.for_each_bytes(|sample, bytes| visit(sample, self.entry(sample, bytes)?))
    }

    /// Calls `visit` for the results of these samples, in this order.
    ///
    /// # Errors
    /// As [`Reader::for_each`]; a sample that has no result.
    pub fn for_each_of<E: From<LedgerError>>(
        &self,
        samples: &[u64],
        mut visit: impl FnMut(u64, Entry) -> Result<(), E>,
    ) -> Result<(), E> {
        let failed = |source| E::from(LedgerError::store("read", &self.path, source));
        let table = self.transaction.open_table(RESULTS).map_err(|source| failed(source.into()))?;
        for &sample in samples {
            let bytes = table.get(sample).map_err(|source| failed(source.into()))?;
            let bytes = bytes.ok_or_else(|| LedgerError::Missing { sample, path: self.path.clone() })?;
            visit(sample, self.entry(sample, bytes.value())?)?;
        }
        Ok(())
    }

    fn for_each_bytes<E: From<LedgerError>>(
        &self,
        mut visit: impl FnMut(u64, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let failed = |source| E::from(LedgerError::store("read", &self.path, source));
        let table = self.transaction.open_table(RESULTS).map_err(|source| failed(source.into()))?;
        for item in table.iter().map_err(|source| failed(source.into()))? {
            let (sample, bytes) = item.map_err(|source| failed(source.into()))?;
            visit(sample.value(), bytes.value())?;
        }
        Ok(())
    }

    fn entry(&self, sample: u64, bytes: &[u8]) -> Result<Entry, LedgerError> {
        let decoded = Entry::decode(bytes);
        let (_, entry) = decoded.map_err(|source| LedgerError::Record { sample, path: self.path.clone(), source })?;
        Ok(entry)
    }
}
