//! What a run tells of itself while it goes on: `status.json`, replaced about once a second.
//!
//! The record cannot be read by another process while the run lives, so `bladeoff status` reads this file, and the lock to
//! know whether anybody is still there. It is renamed into place but not synced: after a power cut it may be old or
//! missing, and the record says what is true.

use super::directory::{LEDGER, LOCK, RESULTS};
use super::lock::{Holder, Look, look};
use super::manifest::{host, timestamp};
use super::sink::describe;
use crate::files::FileError;
use crate::report::{Eta, Tally};
use crate::schedule::Snapshot;
use crate::study::Samples;
use bladeoff_core::outcome::{Cause, Status};
use serde_json::{Map, Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// Name of the file in a result directory.
pub const STATUS: &str = "status.json";
/// Version of its layout.
const STATUS_SCHEMA: u64 = 1;
/// Least time between two writings.
const EVERY: Duration = Duration::from_secs(1);

/// Writes the file of one run.
#[derive(Debug)]
pub(super) struct StatusWriter {
    path: PathBuf,
    /// What does not change during the run.
    fixed: Map<String, Value>,
    reused: u64,
    total: u64,
    written: Option<Instant>,
    last: Option<Snapshot>,
    left: Option<Eta>,
}

impl StatusWriter {
    pub fn new(directory: &Path, samples: &Samples, reused: u64) -> Self {
        let fixed = json!({
            "schema": STATUS_SCHEMA,
            "study": samples.study().name,
            "pid": std::process::id(),
            "host": host(),
            "started": timestamp(SystemTime::now()),
            "total": samples.count(),
            "reused": reused,
            "go_on": go_on(directory, samples),
        });
        let Value::Object(fixed) = fixed else { unreachable!("written as an object") };
        Self {
            path: directory.join(STATUS),
            fixed,
            reused,
            total: samples.count(),
            written: None,
            last: None,
            left: None,
        }
    }

    /// Writes the present state, if it is time to; `left`: time for the rest. A failure is none of the study's: the next one may
    /// succeed.
    pub fn update(&mut self, snapshot: &Snapshot, left: Option<Eta>, tally: &Tally, now: Instant) {
        if self.written.is_some_and(|written| now.duration_since(written) < EVERY) {
            return;
        }
        self.written = Some(now);
        self.last = Some(snapshot.clone());
        self.left = left;
        let _ = self.write("running", None, Some(snapshot), tally);
    }

    /// Writes the last state; `error`: why the run failed.
    pub fn finish(&mut self, state: &str, error: Option<&str>, tally: &Tally) {
        let last = self.last.take();
        self.left = None;
        // What workers were doing a moment ago is no longer true.
        let last = last.map(|snapshot| Snapshot { workers: Vec::new(), rate: 0.0, ..snapshot });
        let _ = self.write(state, error, last.as_ref(), tally);
    }

    fn write(
        &self,
        state: &str,
        error: Option<&str>,
        snapshot: Option<&Snapshot>,
        tally: &Tally,
    ) -> std::io::Result<()> {
        let mut status = self.fixed.clone();
        let mut put = |key: &str, value: Value| drop(status.insert(key.to_owned(), value));
        put("state", json!(state));
        put("error", json!(error));
        put("updated", json!(timestamp(SystemTime::now())));
        put("done", json!(tally.done()));
        put("left", json!(self.total - tally.done().min(self.total)));
        let by_status = Status::ALL.iter().map(|status| (status.word().to_owned(), json!(tally.of(*status))));
        put("by_status", Value::Object(by_status.collect()));
        let causes = Cause::ALL.iter().map(|cause| (cause.word().to_owned(), tally.of_cause(*cause)));
        let causes = causes.filter(|(_, count)| *count > 0).map(|(word, count)| (word, json!(count)));
        put("by_cause", Value::Object(causes.collect()));
        let none = Vec::new();
        put("elapsed_s", json!(snapshot.map(|snapshot| snapshot.elapsed.as_secs_f64())));
        put("computed", json!(tally.done().saturating_sub(self.reused)));
        put("rate_per_s", json!(snapshot.map(|snapshot| snapshot.rate)));
        put("left_from_s", json!(self.left.map(|left| left.low.as_secs_f64())));
        put("left_to_s", json!(self.left.map(|left| left.high.as_secs_f64())));
        put("worker_deaths", json!(snapshot.map_or(0, |snapshot| snapshot.worker_deaths)));
        put("dropped_messages", json!(snapshot.map_or(0, |snapshot| snapshot.dropped_messages)));
        let workers = snapshot.map_or(&none, |snapshot| &snapshot.workers).iter().map(|worker| {
            json!({ "worker": worker.worker, "pid": worker.pid, "silent": worker.stale, "doing": describe(worker) })
        });
        put("workers", workers.collect());
        let mut text = serde_json::to_string_pretty(&Value::Object(status)).unwrap_or_default();
        text.push('\n');
        let aside = self.path.with_extension("json.tmp");
        fs::write(&aside, text)?;
        fs::rename(&aside, &self.path)
    }
}

/// The command that continues a study.
#[must_use]
pub fn go_on(directory: &Path, samples: &Samples) -> String {
    let mut words = vec!["bladeoff run".to_owned(), word(&samples.study().file)];
    words.extend(["--out".to_owned(), word(&directory.display().to_string())]);
    words.extend(samples.scale().map(|scale| format!("--scale {scale}")));
    words.extend(samples.limit().map(|limit| format!("--limit {limit}")));
    words.join(" ")
}

/// A word of a command line, quoted for a shell where it has to be.
fn word(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:,@%".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

/// What is known of a result directory from outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// Whether somebody works in it.
    pub state: RunState,
    /// What the last run told of itself, if it did.
    pub told: Option<Map<String, Value>>,
}

/// How it stands with a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RunState {
    /// A process works in it; `stopped`: the process is stopped (SIGSTOP, Ctrl-Z).
    Running {
        /// Who.
        holder: Option<Holder>,
        /// Whether it is stopped.
        stopped: bool,
    },
    /// The last run did not end in order.
    Killed(Holder),
    /// Complete: the table is there.
    Complete,
    /// Ended in order before it was complete, or failed.
    Ended,
}

impl RunState {
    /// One word for programs.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            RunState::Running { stopped: false, .. } => "running",
            RunState::Running { stopped: true, .. } => "stopped",
            RunState::Killed(_) => "killed",
            RunState::Complete => "complete",
            RunState::Ended => "ended",
        }
    }
}

/// Looks at a result directory without disturbing who works in it; `None` if it is none.
///
/// # Errors
/// It cannot be read.
pub fn see(directory: &Path) -> Result<Option<Seen>, FileError> {
    if !directory.join(LEDGER).exists() && !directory.join(LOCK).exists() {
        return Ok(None);
    }
    let state = match look(directory, LOCK)? {
        Look::Held(holder) => {
            let stopped =
                holder.as_ref().is_some_and(|holder| Some(&holder.host) == host().as_ref() && is_stopped(holder.pid));
            RunState::Running { holder, stopped }
        }
        Look::Abandoned(holder) => RunState::Killed(holder),
        Look::Free if directory.join(RESULTS).exists() => RunState::Complete,
        Look::Free => RunState::Ended,
    };
    let text = fs::read_to_string(directory.join(STATUS)).unwrap_or_default();
    let told = match serde_json::from_str(&text) {
        Ok(Value::Object(told)) if told.get("schema") == Some(&json!(STATUS_SCHEMA)) => Some(told),
        _ => None,
    };
    // What the run before told says nothing of one that has just begun.
    let told = told.filter(|told| match &state {
        RunState::Running { holder: Some(holder), .. } => told.get("pid") == Some(&json!(holder.pid)),
        _ => true,
    });
    Ok(Some(Seen { state, told }))
}

fn is_stopped(pid: u32) -> bool {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    // The name in parentheses may hold anything; the state is the first word after it.
    stat.rsplit_once(") ").is_some_and(|(_, rest)| rest.starts_with(['T', 't']))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_a_command_are_quoted_where_they_have_to_be() {
        assert_eq!(word("runs/a-b_1.toml"), "runs/a-b_1.toml");
        assert_eq!(word("my study's.toml"), "'my study'\\''s.toml'");
        assert_eq!(word(""), "''");
    }

    #[test]
    fn a_folder_without_a_run_is_none() {
        let folder = tempfile::tempdir().expect("temporary directory");
        assert_eq!(see(folder.path()).expect("readable"), None);
    }
}
