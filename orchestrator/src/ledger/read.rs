//! Reading what is durable, also from another thread while results are added.

use super::{Entry, Head, LedgerError, RESULTS, RecordError, guarded};
use redb::{Database, ReadableDatabase, ReadableTable, ReadableTableMetadata};
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
    pub fn for_each<E: From<LedgerError>>(&self, mut visit: impl FnMut(u64, Entry) -> Result<(), E>) -> Result<(), E> {
        self.for_each_bytes(|sample, bytes| {
            let (_, entry) = Entry::decode(bytes).map_err(|source| LedgerError::Record {
                sample,
                path: self.path.clone(),
                source,
            })?;
            visit(sample, entry)
        })
    }

    fn for_each_bytes<E: From<LedgerError>>(
        &self,
        mut visit: impl FnMut(u64, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let failed = |source| E::from(LedgerError::store("read", &self.path, source));
        let transaction = self.database.begin_read().map_err(|source| failed(source.into()))?;
        let table = transaction.open_table(RESULTS).map_err(|source| failed(source.into()))?;
        for item in table.iter().map_err(|source| failed(source.into()))? {
            let (sample, bytes) = item.map_err(|source| failed(source.into()))?;
            visit(sample.value(), bytes.value())?;
        }
        Ok(())
    }
}
