//! The rows finished so far, readable while the study runs.
//!
//! `results-incomplete.parquet` is written from the record from time to time, by a thread of its own that only reads what
//! is durable. Each writing is whole or absent, and all together take at most about a hundredth of the time. One table and
//! not many parts: whoever looks at a running study reads one file, with the columns and in the order of the final one.

use super::directory::{INCOMPLETE_RESULTS, RunDirectory};
use super::prepare::Prepared;
use super::tables;
use crate::ledger::Reader;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// A writing that took so long is followed by a pause of so many times that.
const PAUSE_PER_WRITING: u32 = 100;

/// Does the work while the table of what is finished is kept fresh: every `every`, less often when that takes long, never
/// if that is zero.
pub(super) fn refreshed<T>(
    every: Duration,
    directory: &RunDirectory,
    prepared: &Prepared<'_>,
    record: &Reader,
    work: impl FnOnce() -> T,
) -> T {
    if every.is_zero() {
        return work();
    }
    let is_over = AtomicBool::new(false);
    thread::scope(|scope| {
        let (end, ended) = channel::<()>();
        let is_over = &is_over;
        scope.spawn(move || {
            let (mut pause, mut written) = (every, 0);
            while ended.recv_timeout(pause) == Err(RecvTimeoutError::Timeout) {
                let begun = Instant::now();
                // What fails here fails at the end, too, where it is said.
                let there = record.len().unwrap_or(0);
                if there > written && there < prepared.samples.count() {
                    let path = directory.file(INCOMPLETE_RESULTS);
                    let ended = || is_over.load(Ordering::Relaxed);
                    if let Ok(true) = tables::write(directory, &path, prepared, record, &ended) {
                        written = there;
                    }
                }
                pause = every.max(begun.elapsed() * PAUSE_PER_WRITING);
            }
        });
        // Also when the work panics: the thread is waited for.
        let _end = EndOnDrop(is_over, Some(end));
        work()
    })
}

/// Tells the thread that the work is over.
struct EndOnDrop<'a>(&'a AtomicBool, Option<std::sync::mpsc::Sender<()>>);

impl Drop for EndOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
        self.1 = None;
    }
}
