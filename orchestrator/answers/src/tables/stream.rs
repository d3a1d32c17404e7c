//! Output stream of a table. The bytes are hashed before they are written, so that the checksum is that of the intended content. The
//! operating system's error is kept, because Polars replaces it by its own text ("transport error" for a full disk).

use super::TableError;
use bladeoff_system::files::{FileError, Pending};
use blake3::{Hash, Hasher};
use polars::error::PolarsError;
use std::cell::RefCell;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Writer passed to Polars.
pub(super) type Out = BufWriter<Stream>;
/// Buffer size: Polars writes the headers of pages byte by byte.
const BUFFER: usize = 1 << 16;

/// Checksum and size of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Checksum {
    /// BLAKE3 of the bytes.
    pub hash: Hash,
    /// Number of bytes.
    pub bytes: u64,
}

/// Writing end of the stream, owned by Polars.
#[derive(Debug)]
pub(super) struct Stream {
    file: File,
    seen: Rc<RefCell<Seen>>,
}

/// Observing end of the stream, with checksum and error.
#[derive(Debug)]
pub(super) struct Watch {
    path: PathBuf,
    seen: Rc<RefCell<Seen>>,
}

#[derive(Debug, Default)]
struct Seen {
    hasher: Hasher,
    bytes: u64,
    error: Option<io::Error>,
}

/// Opens both ends of the stream into a file.
///
/// # Errors
/// No file descriptor is available.
pub(super) fn open(pending: &mut Pending) -> Result<(Out, Watch), TableError> {
    let file = pending.file().try_clone().map_err(FileError::at("write", pending.path()))?;
    Ok(ends(file, pending.path()))
}

fn ends(file: File, path: &Path) -> (Out, Watch) {
    let seen = Rc::new(RefCell::new(Seen::default()));
    let watch = Watch { path: path.to_path_buf(), seen: Rc::clone(&seen) };
    (BufWriter::with_capacity(BUFFER, Stream { file, seen }), watch)
}

impl Watch {
    /// Error of a failed write: the operating system's if there was one, otherwise that of Polars.
    pub fn failed(&self, source: PolarsError) -> TableError {
        match self.seen.borrow_mut().error.take() {
            Some(source) => FileError::at("write", &self.path)(source).into(),
            None => TableError::Table { action: "write", path: self.path.clone(), source },
        }
    }

    /// Checksum of all bytes so far.
    pub fn checksum(&self) -> Checksum {
        let seen = self.seen.borrow();
        Checksum { hash: seen.hasher.finalize(), bytes: seen.bytes }
    }
}

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes);
        let mut seen = self.seen.borrow_mut();
        match &written {
            Ok(count) => {
                seen.hasher.update(&bytes[..*count]);
                seen.bytes += *count as u64;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => {
                // the first error is the cause
                seen.error.get_or_insert_with(|| {
                    error.raw_os_error().map_or_else(|| error.kind().into(), io::Error::from_raw_os_error)
                });
            }
        }
        written
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::{Timing, TimingsWriter};
    use polars::prelude::{DataFrame, ParquetWriter};
    use std::error::Error;
    use std::fs::OpenOptions;

    #[test]
    fn a_full_disk_is_called_so() {
        let full = OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
        let (out, watch) = ends(full, Path::new("out/results.parquet"));
        let refused = ParquetWriter::new(out).finish(&mut DataFrame::empty()).expect_err("nothing fits");
        let error = watch.failed(refused);
        assert_eq!(error.to_string(), "cannot write out/results.parquet");
        assert!(error.source().is_some_and(|source| source.to_string().contains("No space left on device")));
    }

    #[test]
    fn the_checksum_is_that_of_the_file() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let path = folder.path().join("t.parquet");
        let mut writer = TimingsWriter::create(Pending::create(&path).expect("created")).expect("begun");
        for sample in 0..40_000 {
            writer.push(Timing { sample, cpu_s: 0.5, worker: 1, attempt: 1 }).expect("taken");
        }
        let checksum = writer.finish().expect("written");
        let bytes = std::fs::read(&path).expect("readable");
        assert_eq!(checksum, Checksum { hash: blake3::hash(&bytes), bytes: bytes.len() as u64 });
    }
}
