//! Reading of durable results, also from another thread while results are added.

use super::entry::{Entry, EntryError, Head};
use super::error::{RecordError, guarded};
use super::layout::{CACHE_BYTES, HEADER, RECORD_VERSION, RESULTS, VERSION_KEY};
use super::overlay::Overlay;
use super::store::Store;
use bladeoff_system::place::Place;
use redb::{Database, ReadTransaction, ReadableDatabase, ReadableTable, ReadableTableMetadata};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The durable results of a store. Each call sees one state of the store, whatever is added meanwhile.
#[derive(Debug, Clone)]
pub struct Reader {
    pub(super) store: Arc<Store>,
    pub(super) path: Place,
}

impl Reader {
    /// Opens the store of an earlier run for reading, and checks every page. The file is not changed, not even to repair traces of a crash.
    ///
    /// # Errors
    /// [`RecordError::Damaged`] if the store is damaged; another version; not readable.
    pub fn open(path: impl Into<Place>) -> Result<Self, RecordError> {
        Self::over(&path.into(), true)
    }

    /// Opens the store without checking all pages, to show figures quickly: entries are checked when they are read.
    ///
    /// # Errors
    /// As [`Reader::open`].
    pub fn peek(path: impl Into<Place>) -> Result<Self, RecordError> {
        Self::over(&path.into(), false)
    }

    fn over(path: &Place, is_checked: bool) -> Result<Self, RecordError> {
        let failed = |source| RecordError::store("open", path, source);
        let open = || {
            let file = Overlay::over(path.open()?).map_err(|source| failed(source.into()))?;
            let builder = &mut Database::builder();
            let opened = builder.set_cache_size(CACHE_BYTES).create_with_backend(file);
            let mut database = opened.map_err(|source| failed(source.into()))?;
            if !is_checked || database.check_integrity().map_err(|source| failed(source.into()))? {
                return Ok(database);
            }
            let detail = "its pages do not fit together".to_owned();
            Err(RecordError::Damaged { path: path.to_path_buf(), detail })
        };
        let reader = Self { store: Arc::new(Store::new(guarded(path, open)?)), path: path.clone() };
        match reader.header()?.get(VERSION_KEY) {
            Some(version) if *version == RECORD_VERSION.to_string() => Ok(reader),
            Some(found) => Err(RecordError::Version { path: path.to_path_buf(), found: found.clone() }),
            None => Err(RecordError::Damaged { path: path.to_path_buf(), detail: "its header is empty".to_owned() }),
        }
    }

    /// The properties that the entries depend on, as last passed to [`Record::create`](super::Record::create) or
    /// [`Record::replace_header`](super::Record::replace_header).
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn header(&self) -> Result<BTreeMap<String, String>, RecordError> {
        let read = || -> Result<_, redb::Error> {
            let table = self.store.begin_read()?.open_table(HEADER)?;
            let pairs = table.iter()?.map(|pair| pair.map(|(k, v)| (k.value().to_owned(), v.value().to_owned())));
            Ok(pairs.collect::<Result<_, _>>()?)
        };
        guarded(&self.path, || read().map_err(|source| RecordError::store("read", &self.path, source)))
    }

    /// Number of samples with a durable result.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn len(&self) -> Result<u64, RecordError> {
        let read = || -> Result<u64, redb::Error> { Ok(self.store.begin_read()?.open_table(RESULTS)?.len()?) };
        guarded(&self.path, || read().map_err(|source| RecordError::store("read", &self.path, source)))
    }

    /// Whether no sample has a durable result.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn is_empty(&self) -> Result<bool, RecordError> {
        Ok(self.len()? == 0)
    }

    /// The bytes of a sample's entry.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn bytes(&self, sample: u64) -> Result<Option<Vec<u8>>, RecordError> {
        let read = || -> Result<_, redb::Error> {
            let table = self.store.begin_read()?.open_table(RESULTS)?;
            Ok(table.get(sample)?.map(|bytes| bytes.value().to_vec()))
        };
        guarded(&self.path, || read().map_err(|source| RecordError::store("read", &self.path, source)))
    }

    /// Calls `visit` for the head of every durable result, in ascending order of sample numbers. An entry that is damaged or has another
    /// version is passed as an error. `column`: as in [`Head::decode`].
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn for_each_head(
        &self,
        column: Option<usize>,
        mut visit: impl FnMut(u64, Result<Head, EntryError>),
    ) -> Result<(), RecordError> {
        guarded(&self.path, || {
            self.for_each_bytes(|sample, bytes| {
                visit(sample, Head::decode(bytes, column));
                Ok::<(), RecordError>(())
            })
        })
    }

    /// Calls `visit` for every durable result, in ascending order of sample numbers.
    ///
    /// # Errors
    /// The store or one of its entries cannot be read; errors of `visit`.
    pub fn for_each<E: From<RecordError>>(&self, visit: impl FnMut(u64, Entry) -> Result<(), E>) -> Result<(), E> {
        self.view()?.for_each(visit)
    }

    /// Calls `visit` for the bytes of every durable result, in ascending order of sample numbers.
    ///
    /// # Errors
    /// As [`Reader::for_each`].
    pub fn for_each_bytes<E: From<RecordError>>(
        &self,
        visit: impl FnMut(u64, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        self.view()?.for_each_bytes(visit)
    }

    /// The present state of the store, for later reading whatever is added meanwhile. The store cannot reuse space while the view exists.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn view(&self) -> Result<View, RecordError> {
        let transaction =
            self.store.begin_read().map_err(|source| RecordError::store("read", &self.path, source.into()))?;
        Ok(View { transaction, path: self.path.clone() })
    }
}

/// The durable results of a store at one moment.
pub struct View {
    transaction: ReadTransaction,
    path: Place,
}

impl View {
    /// Calls `visit` for every result, in ascending order of sample numbers.
    ///
    /// # Errors
    /// As [`Reader::for_each`].
    pub fn for_each<E: From<RecordError>>(&self, mut visit: impl FnMut(u64, Entry) -> Result<(), E>) -> Result<(), E> {
        self.for_each_bytes(|sample, bytes| visit(sample, self.entry(sample, bytes)?))
    }

    /// Calls `visit` for the results of these samples, in this order.
    ///
    /// # Errors
    /// As [`Reader::for_each`]; a sample without a result.
    pub fn for_each_of<E: From<RecordError>>(
        &self,
        samples: &[u64],
        mut visit: impl FnMut(u64, Entry) -> Result<(), E>,
    ) -> Result<(), E> {
        let failed = |source| E::from(RecordError::store("read", &self.path, source));
        let table = self.transaction.open_table(RESULTS).map_err(|source| failed(source.into()))?;
        for &sample in samples {
            let bytes = table.get(sample).map_err(|source| failed(source.into()))?;
            let bytes = bytes.ok_or_else(|| RecordError::Missing { sample, path: self.path.to_path_buf() })?;
            visit(sample, self.entry(sample, bytes.value())?)?;
        }
        Ok(())
    }

    fn for_each_bytes<E: From<RecordError>>(
        &self,
        mut visit: impl FnMut(u64, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let failed = |source| E::from(RecordError::store("read", &self.path, source));
        let table = self.transaction.open_table(RESULTS).map_err(|source| failed(source.into()))?;
        for item in table.iter().map_err(|source| failed(source.into()))? {
            let (sample, bytes) = item.map_err(|source| failed(source.into()))?;
            visit(sample.value(), bytes.value())?;
        }
        Ok(())
    }

    fn entry(&self, sample: u64, bytes: &[u8]) -> Result<Entry, RecordError> {
        let decoded = Entry::decode(bytes);
        let (_, entry) =
            decoded.map_err(|source| RecordError::Record { sample, path: self.path.to_path_buf(), source })?;
        Ok(entry)
    }
}
