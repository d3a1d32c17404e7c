//! Worker log: standard error of the workers and events of their lives, one line each.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::PathBuf;

use bladeoff_protocol::messages::WorkerId;
use bladeoff_system::place::Place;
use bladeoff_text::document::visible;

use super::error::DispatchError;
use crate::schedule::KillReason;

/// Longest line kept.
pub(super) const LONGEST_LINE: usize = 4096;
/// Largest growth of a log in one run, so that a sample with a message at every step does not fill the disk.
const LONGEST_LOG: u64 = 16 << 20;

pub(super) struct Log {
    path: PathBuf,
    file: File,
    written: u64,
    /// Last line of each worker, or about it before its end.
    words: BTreeMap<WorkerId, String>,
}

impl Log {
    pub fn open(place: &Place) -> Result<Self, DispatchError> {
        let path = place.to_path_buf();
        match place.append() {
            Ok(file) => Ok(Self { path, file, written: 0, words: BTreeMap::new() }),
            Err(error) => Err(DispatchError::Log { path, source: error.source }),
        }
    }

    /// Writes a line after the number of its worker.
    pub fn line(&mut self, worker: Option<WorkerId>, text: &str) -> Result<(), DispatchError> {
        // Control characters that a library may have written are replaced, because the log is read in terminals.
        let text = &*visible(text);
        // The last line of a panic only says how to print a backtrace.
        if let Some(worker) = worker.filter(|_| !text.starts_with("note: ")) {
            self.words.insert(worker, text.to_owned());
        }
        self.write(worker, text)
    }

    /// Writes the reason of a kill.
    pub fn killed(&mut self, worker: WorkerId, why: KillReason) -> Result<(), DispatchError> {
        let words = match why {
            KillReason::TimeLimit => "killed: its sample exceeds the time limit",
            KillReason::Silent => "killed: nothing was heard of it",
            KillReason::Lost => "killed: it waits for an answer that was already sent",
            KillReason::Ending => "killed: the run ends",
        };
        self.line(Some(worker), words)
    }

    /// Writes the number of discarded messages and the reason of the last one.
    pub fn dropped(&mut self, count: u64, why: &impl std::fmt::Display) -> Result<(), DispatchError> {
        let what =
            if count == 1 { "message dropped".to_owned() } else { format!("{count} messages dropped, the last") };
        self.line(None, &format!("{what}: {why}"))
    }

    /// Writes the end of a worker, if it left no message.
    pub fn ended(&mut self, worker: WorkerId, text: &str) -> Result<(), DispatchError> {
        self.words.entry(worker).or_insert_with(|| text.to_owned());
        self.write(Some(worker), text)
    }

    /// Returns the last line of an ended worker, once.
    pub fn last_words(&mut self, worker: WorkerId) -> Option<String> {
        self.words.remove(&worker)
    }

    fn write(&mut self, worker: Option<WorkerId>, text: &str) -> Result<(), DispatchError> {
        let line = match worker {
            Some(worker) => format!("{worker}: {text}\n"),
            None => format!("orchestrator: {text}\n"),
        };
        let before = self.written;
        self.written += line.len() as u64;
        let result = match (before < LONGEST_LOG, self.written < LONGEST_LOG) {
            (true, true) => self.file.write_all(line.as_bytes()),
            (true, false) => {
                self.file.write_all(b"orchestrator: the log is full; further messages of this run are not kept\n")
            }
            _ => Ok(()),
        };
        result.map_err(|source| DispatchError::Log { path: self.path.clone(), source })
    }
}
