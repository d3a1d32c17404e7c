//! The worker log: what workers write to standard error and what happened to them, one line each.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::PathBuf;

use bladeoff_protocol::messages::WorkerId;

use super::DispatchError;

/// Longest line kept.
pub(super) const LONGEST_LINE: usize = 4096;
/// A log grows to this and no further in one run, so that a sample that complains at every step does not fill the disk.
const LONGEST_LOG: u64 = 16 << 20;

pub(super) struct Log {
    path: PathBuf,
    file: File,
    written: u64,
}

impl Log {
    pub fn open(path: PathBuf) -> Result<Self, DispatchError> {
        match OpenOptions::new().create(true).append(true).open(&path) {
            Ok(file) => Ok(Self { path, file, written: 0 }),
            Err(source) => Err(DispatchError::Log { path, source }),
        }
    }

    /// Writes a line, the worker's number before it.
    pub fn line(&mut self, worker: Option<WorkerId>, text: &str) -> Result<(), DispatchError> {
        let line = match worker {
            Some(worker) => format!("{worker}: {text}\n"),
            None => format!("orchestrator: {text}\n"),
        };
        let before = self.written;
        self.written += line.len() as u64;
        let result = match (before < LONGEST_LOG, self.written < LONGEST_LOG) {
            (true, true) => self.file.write_all(line.as_bytes()),
            (true, false) => self.file.write_all(b"orchestrator: the log is full, nothing more is kept of this run\n"),
            _ => Ok(()),
        };
        result.map_err(|source| DispatchError::Log { path: self.path.clone(), source })
    }
}
