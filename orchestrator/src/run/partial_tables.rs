//! Partial tables: finished rows, readable while the study runs, in `parts/part-000001.parquet` and so on.
//!
//! A part contains the rows that became durable since the previous part, in ascending order, with the columns and metadata of the
//! final table and the key `bladeoff.incomplete`. A part never changes. So all parts together contain every finished row once,
//! except the newest ones, and only new rows are written. A thread of its own reads durable rows only; it writes each part under
//! a temporary name, syncs it and renames it.
//!
//! A resumed run first writes all finished samples as new parts into a temporary folder, which then replaces the old folder in
//! one rename. Where row numbers or entries change, the old parts are removed before the record is replaced. So after a kill at
//! any time the parts are correct or absent.

use super::directory::{PARTS, RunDirectory, TIMING_PARTS, part_name};
use super::error::RunError;
use super::prepare::Prepared;
use super::tables::RowsWriter;
use crate::dispatch::DispatchError;
use bladeoff_answers::tables::TableError;
use bladeoff_record::{Reader, RecordError, View};
use bladeoff_system::files::{FileError, Pending};
use bladeoff_system::folder::Folder;
use bladeoff_worker::fault::{At, Faults};
use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Largest number of rows of a part; so many waiting rows are written before the interval is over.
pub(super) const PART_ROWS: usize = 65_536;
/// Time of the first part after the start; the time between parts doubles from it until it is the asked one.
const FIRST: Duration = Duration::from_secs(2);
/// Pause after a part that could not be written.
const RETRY: Duration = Duration::from_secs(10);

/// Message to the writer of parts.
enum PartsRequest {
    /// Samples have become durable.
    Durable(Vec<u64>),
    /// The run ends before the study is complete: write the remaining rows as a part.
    WriteRest,
}

/// Handle to the writer of parts; dropping it ends the writer.
pub(super) struct PartsHandle<'a> {
    requests: Option<Sender<PartsRequest>>,
    is_rest_wanted: Cell<bool>,
    /// Set when rows that are not written yet are no longer needed.
    is_over: &'a AtomicBool,
}

impl PartsHandle<'_> {
    /// Reports samples that have become durable.
    pub fn samples_durable(&self, samples: Vec<u64>) {
        self.send(PartsRequest::Durable(samples));
    }

    /// Requests a part with all remaining rows, because the run ends before the study is complete.
    pub fn write_rest(&self) {
        self.is_rest_wanted.set(true);
        self.send(PartsRequest::WriteRest);
    }

    fn send(&self, request: PartsRequest) {
        // The writer ends after this handle, or by a panic, which `join` passes on.
        let _ = self.requests.as_ref().is_some_and(|requests| requests.send(request).is_ok());
    }
}

impl Drop for PartsHandle<'_> {
    fn drop(&mut self) {
        self.is_over.store(!self.is_rest_wanted.get(), Ordering::Relaxed);
        self.requests = None;
    }
}

/// Runs `work` while parts are written: every `every`, more often at the start ([`FIRST`]) and with many rows, and only with many rows if
/// `every` is zero.
/// `there`: rows of earlier runs. After `work` nothing more is written without [`PartsHandle::write_rest`]; the second result is
/// that of writing the rest.
///
/// # Errors
/// The writer thread cannot be started; `work` was not run.
pub(super) fn written_beside<T>(
    every: Duration,
    (directory, prepared, record): (&RunDirectory, &Prepared<'_>, &Reader),
    earlier: Option<View>,
    faults: &dyn Faults,
    work: impl FnOnce(&PartsHandle<'_>) -> T,
) -> Result<(T, Result<(), RunError>), RunError> {
    let is_over = AtomicBool::new(false);
    thread::scope(|scope| {
        let (sender, receiver) = channel();
        // Dropped also when the work panics: the thread is joined.
        let handle = PartsHandle { requests: Some(sender), is_rest_wanted: Cell::new(false), is_over: &is_over };
        let is_over = &is_over;
        let body = move || {
            let waiting = Vec::new();
            Writer { directory, prepared, record, faults, is_over, earlier, waiting, next: 1 }.run(every, &receiver)
        };
        let thread = thread::Builder::new()
            .name("parts".into())
            .spawn_scoped(scope, body)
            .map_err(|source| DispatchError::System { doing: "starting the thread that writes parts", source })?;
        let done = work(&handle);
        drop(handle);
        let written = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        Ok((done, written))
    })
}

struct Writer<'a> {
    directory: &'a RunDirectory,
    prepared: &'a Prepared<'a>,
    record: &'a Reader,
    faults: &'a dyn Faults,
    is_over: &'a AtomicBool,
    /// Rows of earlier runs that no new part contains yet.
    earlier: Option<View>,
    /// Durable samples that no part contains.
    waiting: Vec<u64>,
    /// Number of the next part.
    next: u32,
}

/// Reason why writing ended early.
enum Stop {
    Cancelled,
    Failed(RunError),
}

impl From<RunError> for Stop {
    fn from(error: RunError) -> Self {
        Self::Failed(error)
    }
}

impl From<RecordError> for Stop {
    fn from(error: RecordError) -> Self {
        Self::Failed(error.into())
    }
}

impl From<TableError> for Stop {
    fn from(error: TableError) -> Self {
        Self::Failed(error.into())
    }
}

impl From<FileError> for Stop {
    fn from(error: FileError) -> Self {
        Self::Failed(error.into())
    }
}

impl Writer<'_> {
    fn run(mut self, every: Duration, requests: &Receiver<PartsRequest>) -> Result<(), RunError> {
        let mut between = FIRST.min(every);
        let mut due = if self.earlier.is_some() { Instant::now() } else { Instant::now() + between };
        let mut failed = None;
        loop {
            let wait = if every.is_zero() && self.earlier.is_none() { RETRY } else { due - Instant::now().min(due) };
            match requests.recv_timeout(wait) {
                Ok(PartsRequest::Durable(samples)) => self.waiting.extend(samples),
                Ok(PartsRequest::WriteRest) => return self.write(&|| false).or_else(Stop::into_result),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            let now = Instant::now();
            let is_time = now >= due && !(every.is_zero() && self.earlier.is_none());
            let may = failed.is_none_or(|failed: Instant| now.duration_since(failed) >= RETRY);
            if (is_time || self.waiting.len() >= PART_ROWS) && may {
                let is_over = self.is_over;
                // A failure is repeated at the end and reported there.
                let written = self.write(&|| is_over.load(Ordering::Relaxed));
                failed = written.is_err().then(Instant::now);
            }
            if now >= due {
                between = (between * 2).min(every);
                due = Instant::now() + if failed.is_some() { RETRY } else { between };
            }
        }
    }

    /// Writes all rows that no part contains.
    fn write(&mut self, is_cancelled: &dyn Fn() -> bool) -> Result<(), Stop> {
        if let Some(earlier) = &self.earlier {
            self.next = self.rewrite_all(earlier, is_cancelled)?;
            self.earlier = None;
        }
        if self.waiting.is_empty() {
            return Ok(());
        }
        let (parts, timings) = (self.directory.folder(PARTS)?, self.directory.folder(TIMING_PARTS)?);
        self.waiting.sort_unstable();
        while !self.waiting.is_empty() {
            let rows = &self.waiting[..self.waiting.len().min(PART_ROWS)];
            let mut part = self.create_part(self.next, &parts, &timings)?;
            self.record.view()?.for_each_of(rows, |sample, entry| {
                if is_cancelled() { Err(Stop::Cancelled) } else { Ok(part.push(sample, entry)?) }
            })?;
            self.faults.reached(At::Parting, self.next.into(), None);
            // If it fails after its rename, the next try uses the same name.
            part.finish()?;
            self.faults.reached(At::Parted, self.next.into(), None);
            self.next += 1;
            self.waiting.drain(..self.waiting.len().min(PART_ROWS));
        }
        Ok(())
    }

    /// Writes rows as parts from number 1 in temporary folders, which then replace the old ones; returns the next number.
    fn rewrite_all(&self, earlier: &View, is_cancelled: &dyn Fn() -> bool) -> Result<u32, Stop> {
        let parts = self.directory.new_folder(PARTS)?;
        let timings = self.directory.new_folder(TIMING_PARTS)?;
        let (mut next, mut rows) = (1, 0);
        let mut open: Option<RowsWriter<'_>> = None;
        earlier.for_each::<Stop>(|sample, entry| {
            if is_cancelled() {
                return Err(Stop::Cancelled);
            }
            let mut part = match open.take() {
                Some(part) => part,
                None => self.create_part(next, &parts, &timings)?,
            };
            part.push(sample, entry)?;
            rows += 1;
            if rows == PART_ROWS {
                part.finish()?;
                (next, rows) = (next + 1, 0);
            } else {
                open = Some(part);
            }
            Ok(())
        })?;
        if let Some(part) = open {
            part.finish()?;
            next += 1;
        }
        self.faults.reached(At::Swapping, 0, None);
        self.directory.put_new_folder(TIMING_PARTS)?;
        self.directory.put_new_folder(PARTS)?;
        Ok(next)
    }

    /// Creates a part. Until it is complete it lies beside the folder, so that readers of the folder find complete files only.
    fn create_part(&self, number: u32, parts: &Folder, timings: &Folder) -> Result<RowsWriter<'_>, RunError> {
        let pending = |folder: &Folder, kind: &str| {
            Pending::create_at(folder.place(part_name(number)), &self.directory.file(kind))
        };
        let more = [("incomplete", "true".to_owned()), ("part", number.to_string())];
        let more = more.map(|(key, value)| (key.to_owned(), value));
        Ok(RowsWriter::create(self.prepared, pending(parts, PARTS)?, pending(timings, TIMING_PARTS)?, &more)?)
    }
}

impl Stop {
    fn into_result(self) -> Result<(), RunError> {
        match self {
            Self::Cancelled => Ok(()),
            Self::Failed(error) => Err(error),
        }
    }
}
