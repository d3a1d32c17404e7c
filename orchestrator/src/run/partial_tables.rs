//! The rows finished so far, readable while the study runs: `parts/part-000001.parquet` and so on.
//!
//! A part holds the rows that have become durable since the one before, in ascending order, with the columns and the metadata
//! of the final table and the key `bladeoff.incomplete`. A part never changes, so at every moment the parts together hold
//! every finished row once, but the newest; writing costs what is new. Each is written aside, synced and renamed, by a thread
//! of its own that only reads what is durable.
//!
//! A run that finds finished samples begins by writing all of them as fresh parts in a folder aside, which then takes the place
//! of the old one in one rename. Where row numbers or entries change, the old parts are removed before the record is
//! replaced. So a kill at any moment leaves parts that are right, or none.

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

/// Most rows of a part; so many waiting rows are written before their time has come.
pub(super) const PART_ROWS: usize = 65_536;
/// Pause after a part that could not be written.
const RETRY: Duration = Duration::from_secs(10);

/// What the writer of parts is told.
enum Told {
    /// These samples have become durable.
    Durable(Vec<u64>),
    /// The run ends before it is complete: whatever is left becomes a part.
    WriteRest,
}

/// Tells the writer of parts; dropped, it ends.
pub(super) struct Teller<'a> {
    told: Option<Sender<Told>>,
    is_rest_wanted: Cell<bool>,
    /// Nothing that is not written yet is needed any more.
    is_over: &'a AtomicBool,
}

impl Teller<'_> {
    /// These samples have become durable.
    pub fn durable(&self, samples: Vec<u64>) {
        self.tell(Told::Durable(samples));
    }

    /// The run ends before it is complete: whatever is left becomes a part.
    pub fn write_rest(&self) {
        self.is_rest_wanted.set(true);
        self.tell(Told::WriteRest);
    }

    fn tell(&self, what: Told) {
        // The writer ends after us, or by a panic, which is passed on when it is waited for.
        let _ = self.told.as_ref().is_some_and(|told| told.send(what).is_ok());
    }
}

impl Drop for Teller<'_> {
    fn drop(&mut self) {
        self.is_over.store(!self.is_rest_wanted.get(), Ordering::Relaxed);
        self.told = None;
    }
}

/// Does the work while parts are written: every `every`, earlier when there are many rows, and for many rows alone if it is
/// zero. `there`: what was durable before. Without [`Teller::write_rest`] nothing more is written once the work is done; the
/// second result is that of writing the rest.
///
/// # Errors
/// The thread that writes parts cannot be started; nothing was done.
pub(super) fn written_beside<T>(
    every: Duration,
    (directory, prepared, record): (&RunDirectory, &Prepared<'_>, &Reader),
    there: Option<View>,
    faults: &dyn Faults,
    work: impl FnOnce(&Teller<'_>) -> T,
) -> Result<(T, Result<(), RunError>), RunError> {
    let is_over = AtomicBool::new(false);
    thread::scope(|scope| {
        let (told, receiver) = channel();
        // Dropped when the work panics, too: the thread is waited for.
        let teller = Teller { told: Some(told), is_rest_wanted: Cell::new(false), is_over: &is_over };
        let is_over = &is_over;
        let body = move || {
            let waiting = Vec::new();
            Writer { directory, prepared, record, faults, is_over, there, waiting, next: 1 }.run(every, &receiver)
        };
        let thread = thread::Builder::new()
            .name("parts".into())
            .spawn_scoped(scope, body)
            .map_err(|source| DispatchError::System { doing: "starting the thread that writes parts", source })?;
        let done = work(&teller);
        drop(teller);
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
    /// Rows of earlier runs that are not in fresh parts yet.
    there: Option<View>,
    /// Durable and in no part.
    waiting: Vec<u64>,
    /// Number of the next part.
    next: u32,
}

/// Why writing ended early.
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
    fn run(mut self, every: Duration, told: &Receiver<Told>) -> Result<(), RunError> {
        let mut due = if self.there.is_some() { Instant::now() } else { Instant::now() + every };
        let mut failed = None;
        loop {
            let wait = if every.is_zero() && self.there.is_none() { RETRY } else { due - Instant::now().min(due) };
            match told.recv_timeout(wait) {
                Ok(Told::Durable(samples)) => self.waiting.extend(samples),
                Ok(Told::WriteRest) => return self.write(&|| false).or_else(Stop::into_result),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            let now = Instant::now();
            let is_time = now >= due && !(every.is_zero() && self.there.is_none());
            let may = failed.is_none_or(|failed: Instant| now.duration_since(failed) >= RETRY);
            if (is_time || self.waiting.len() >= PART_ROWS) && may {
                let is_over = self.is_over;
                // What fails here fails at the end, too, where it is said.
                let written = self.write(&|| is_over.load(Ordering::Relaxed));
                failed = written.is_err().then(Instant::now);
            }
            if now >= due {
                due = Instant::now() + if failed.is_some() { RETRY } else { every };
            }
        }
    }

    /// Writes everything that is in no part.
    fn write(&mut self, is_cancelled: &dyn Fn() -> bool) -> Result<(), Stop> {
        if let Some(there) = &self.there {
            self.next = self.write_afresh(there, is_cancelled)?;
            self.there = None;
        }
        if self.waiting.is_empty() {
            return Ok(());
        }
        let (parts, timings) = (self.directory.folder(PARTS)?, self.directory.folder(TIMING_PARTS)?);
        self.waiting.sort_unstable();
        while !self.waiting.is_empty() {
            let rows = &self.waiting[..self.waiting.len().min(PART_ROWS)];
            let mut part = self.part(self.next, &parts, &timings)?;
            self.record.view()?.for_each_of(rows, |sample, entry| {
                if is_cancelled() { Err(Stop::Cancelled) } else { Ok(part.push(sample, entry)?) }
            })?;
            self.faults.reached(At::Parting, self.next.into(), None);
            // Should it fail after its rename, the next try takes its name.
            part.finish()?;
            self.faults.reached(At::Parted, self.next.into(), None);
            self.next += 1;
            self.waiting.drain(..self.waiting.len().min(PART_ROWS));
        }
        Ok(())
    }

    /// Writes rows as parts from the first on, in folders aside that then take the places of the old ones; gives the next
    /// number.
    fn write_afresh(&self, there: &View, is_cancelled: &dyn Fn() -> bool) -> Result<u32, Stop> {
        let parts = self.directory.new_folder(PARTS)?;
        let timings = self.directory.new_folder(TIMING_PARTS)?;
        let (mut next, mut rows) = (1, 0);
        let mut open: Option<RowsWriter<'_>> = None;
        there.for_each::<Stop>(|sample, entry| {
            if is_cancelled() {
                return Err(Stop::Cancelled);
            }
            let mut part = match open.take() {
                Some(part) => part,
                None => self.part(next, &parts, &timings)?,
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

    /// A part under construction. Until it has its name it lies beside the folder: whoever reads the folder sees whole files
    /// only.
    fn part(&self, number: u32, parts: &Folder, timings: &Folder) -> Result<RowsWriter<'_>, RunError> {
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
