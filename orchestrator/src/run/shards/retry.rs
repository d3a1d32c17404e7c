//! Retries while the shared file system is unavailable, with a note and a time limit.

use super::error::ShardError;
use super::shared::Shared;
use bladeoff_answers::summary::duration;
use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Pause between two tries.
const STEP: Duration = Duration::from_millis(500);

/// Retries of operations on the shared directory.
pub(super) struct Retry<'a> {
    shared: &'a Shared,
    most: Duration,
    /// Set when the run has ended; retries then stop.
    is_over: &'a AtomicBool,
    note: &'a (dyn Fn(&str) + Sync),
}

impl<'a> Retry<'a> {
    pub fn new(shared: &'a Shared, most: Duration, is_over: &'a AtomicBool, note: &'a (dyn Fn(&str) + Sync)) -> Self {
        Self { shared, most, is_over, note }
    }

    /// Repeats an operation until it succeeds.
    ///
    /// # Errors
    /// The time limit is over, or the directory was removed.
    pub fn run<T>(&self, mut work: impl FnMut() -> Result<T, FileError>) -> Result<T, ShardError> {
        let begun = Instant::now();
        let mut first: Option<FileError> = None;
        loop {
            let error = match work() {
                Ok(done) => {
                    if first.is_some() {
                        let waited = duration(begun.elapsed());
                        (self.note)(&format!("{} is available again after {waited}", shown(self.shared.path())));
                    }
                    return Ok(done);
                }
                Err(error) => error,
            };
            let path = || self.shared.path().to_path_buf();
            if self.shared.is_removed() {
                return Err(ShardError::Replaced { path: path() });
            }
            if first.is_none() {
                let most = duration(self.most);
                (self.note)(&format!("{error} ({}): retrying for at most {most}", error.source));
            }
            let source = first.get_or_insert(error);
            if begun.elapsed() >= self.most || self.is_over.load(Ordering::Relaxed) {
                let source = FileError::at(source.action, &source.path)(std::io::Error::from(source.source.kind()));
                return Err(ShardError::Away { path: path(), waited: begun.elapsed(), source });
            }
            thread::sleep(STEP.min(self.most));
        }
    }
}
