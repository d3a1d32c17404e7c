//! Status of a run in progress: `status.json`, replaced about once a second, and its readers.
//!
//! Other processes cannot read the record while the run lives, so `bladeoff status` reads this file, and the lock to determine
//! whether the run still lives. Its counts are those of durable samples. The file is renamed into place but not synced: after a
//! power failure it may be old or missing. When no process uses the directory, the record is counted.

use super::directory::{LEDGER, LOCK, RESULTS, STATUS};
use super::end::{TableEnd, end_of_table};
use super::lock::{Holder, LockKeeper, LockState, given_back, lock_state};
use super::stamp::{host, timestamp};
use crate::schedule::{Activity, Ended, Snapshot, WorkerView};
use crate::terminal::{Eta, Tally};
use bladeoff_answers::summary::{counted, duration};
use bladeoff_model::outcome::{Cause, Status};
use bladeoff_record::Reader;
use bladeoff_study::Samples;
use bladeoff_system::call;
use bladeoff_system::files::{FileError, Pending};
use bladeoff_system::folder::Folder;
use bladeoff_system::locks::LockHolder;
use bladeoff_system::place::Place;
use bladeoff_system::with_causes;
use serde_json::{Map, Value, json};
use std::error::Error;
use std::ffi::OsString;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};

/// Version of the layout.
const STATUS_SCHEMA: u64 = 1;
/// Option for a directory to which other users may write.
pub const TRUST: &str = " --trust-dir";
/// Largest status file that is read \[bytes\].
const MOST_STATUS: u64 = 4 << 20;
/// Smallest interval between two writes.
const EVERY: Duration = Duration::from_secs(1);

/// Writer of the status of one run.
#[derive(Debug)]
pub(super) struct StatusWriter {
    path: Place,
    /// Values that do not change during the run.
    fixed: Map<String, Value>,
    reused: u64,
    total: u64,
    /// Samples in the record beyond the end of the table.
    surplus: u64,
    written: Option<Instant>,
    last: Option<Snapshot>,
    left: Option<Eta>,
    begun: Instant,
    elapsed: Duration,
}

impl StatusWriter {
    pub fn new(folder: &Folder, samples: &Samples, reused: u64) -> Self {
        let directory = folder.path();
        let fixed = json!({
            "schema": STATUS_SCHEMA,
            "study": samples.study().name,
            "pid": std::process::id(),
            "host": host(),
            "started": timestamp(SystemTime::now()),
            "total": samples.count(),
            "points": samples.points(),
            "reused": reused,
            "resume": resume_command(directory, samples),
            "study_file": samples.study().file,
            "started_in": std::env::current_dir().ok().map(|folder| folder.to_string_lossy().into_owned()),
            "directory": std::path::absolute(directory).unwrap_or_else(|_| directory.to_path_buf()).to_string_lossy(),
            "scale": samples.scale(),
            "limit": samples.limit(),
        });
        let Value::Object(fixed) = fixed else { unreachable!("written as an object") };
        Self {
            path: folder.place(STATUS),
            fixed,
            reused,
            total: samples.count(),
            surplus: 0,
            written: None,
            last: None,
            left: None,
            begun: Instant::now(),
            elapsed: Duration::ZERO,
        }
    }

    /// Adds `--trust-dir` to the command that continues the study, if this run has it.
    pub fn trusting(mut self, trusts: bool) -> Self {
        if let Some(Value::String(command)) = self.fixed.get_mut("resume").filter(|_| trusts) {
            command.push_str(TRUST);
        }
        self.fixed.insert("trust_dir".to_owned(), json!(trusts));
        self
    }

    /// Writes the state of a run that begins. Failures are ignored here and below: the next write may succeed.
    pub fn begin(&mut self, durable: &Tally) {
        let _ = self.replace(&self.text("running", None, None, durable));
    }

    /// Writes the present state if it is due; `left`: estimate of the remaining time.
    pub fn update(&mut self, snapshot: &Snapshot, left: Option<Eta>, durable: &Tally, now: Instant) {
        // The final state uses the last snapshot, written or not.
        self.last = Some(snapshot.clone());
        // time of all stages; the snapshot contains the present stage only
        self.elapsed = now.saturating_duration_since(self.begun);
        if self.written.is_some_and(|written| now.duration_since(written) < EVERY) {
            return;
        }
        self.written = Some(now);
        self.left = left;
        let _ = self.replace(&self.text("running", None, Some(snapshot), durable));
    }

    /// Sets the reason of the end, and the end of the table if it is not that of its design.
    pub fn tell_end(&mut self, ended: Ended, end: Option<TableEnd>) {
        self.fixed.insert("ended".to_owned(), json!(ended.word()));
        self.fixed.insert("stop".to_owned(), json!(end.map(|end| end.json())));
    }

    /// Writes the final state; `error`: error of the run; `tally`: counts of the table; `surplus`: further samples in the record.
    pub fn finish(&mut self, state: &str, error: Option<&(dyn Error + 'static)>, tally: &Tally, surplus: u64) {
        self.surplus = surplus;
        let last = self.last.take();
        self.left = None;
        // The activities of the workers are over.
        let last = last.map(|snapshot| Snapshot { workers: Vec::new(), rate: 0.0, ..snapshot });
        let error = error.map(with_causes);
        let text = self.text(state, error.as_deref(), last.as_ref(), tally);
        if self.replace(&text).is_err() {
            // On a full disk the old file has space that a new one does not get.
            let over = || {
                let mut file = self.path.open_own().map_err(|error| error.source)?;
                file.write_all(text.as_bytes())?;
                file.set_len(text.len() as u64)
            };
            let _: std::io::Result<()> = over();
        }
    }

    /// Writes to another path, for tests.
    #[cfg(test)]
    pub fn written_to(&mut self, path: Place) {
        self.path = path;
    }

    fn replace(&self, text: &str) -> Result<(), FileError> {
        let mut pending = Pending::create(&self.path)?;
        pending.file().write_all(text.as_bytes()).map_err(FileError::at("write", &self.path))?;
        pending.put_in_place()
    }

    fn text(&self, state: &str, error: Option<&str>, snapshot: Option<&Snapshot>, tally: &Tally) -> String {
        let mut status = self.fixed.clone();
        let mut put = |key: &str, value: Value| drop(status.insert(key.to_owned(), value));
        put("state", json!(state));
        put("error", json!(error));
        put("updated", json!(timestamp(SystemTime::now())));
        let none = Vec::new();
        put("elapsed_s", json!(snapshot.map(|_| self.elapsed.as_secs_f64())));
        put("rate_per_s", json!(snapshot.map(|snapshot| snapshot.rate)));
        put("left_from_s", json!(self.left.map(|left| left.low.as_secs_f64())));
        put("left_to_s", json!(self.left.map(|left| left.high.as_secs_f64())));
        put("worker_deaths", json!(snapshot.map_or(0, |snapshot| snapshot.worker_deaths)));
        put("dropped_messages", json!(snapshot.map_or(0, |snapshot| snapshot.dropped_messages)));
        let workers = snapshot.map_or(&none, |snapshot| &snapshot.workers).iter().map(|worker| {
            json!({ "worker": worker.worker, "pid": worker.pid, "silent": worker.stale, "doing": describe(worker) })
        });
        put("workers", workers.collect());
        let ends_early = self.fixed.get("stop").is_some_and(|stop| !stop.is_null());
        put_counts(&mut status, tally, (self.total, self.reused), ends_early.then_some(self.surplus));
        let mut text = serde_json::to_string_pretty(&Value::Object(status)).unwrap_or_default();
        text.push('\n');
        text
    }
}

/// Adds the counts of finished samples; `reused`: samples of earlier runs; `beyond`: samples in the record beyond the end of a
/// table that `[stop]` ended, so that no sample is left to compute.
fn put_counts(status: &mut Map<String, Value>, tally: &Tally, (total, reused): (u64, u64), beyond: Option<u64>) {
    let mut put = |key: &str, value: Value| drop(status.insert(key.to_owned(), value));
    put("done", json!(tally.done()));
    put("surplus", json!(beyond.unwrap_or(0)));
    put("left", json!(beyond.map_or(total.saturating_sub(tally.done()), |_| 0)));
    let by_status = Status::ALL.iter().map(|status| (status.word().to_owned(), json!(tally.of(*status))));
    put("by_status", Value::Object(by_status.collect()));
    let causes = Cause::ALL.iter().map(|cause| (cause.word().to_owned(), tally.of_cause(*cause)));
    let causes = causes.filter(|(_, count)| *count > 0).map(|(word, count)| (word, json!(count)));
    put("by_cause", Value::Object(causes.collect()));
    put("computed", json!((tally.done() + beyond.unwrap_or(0)).saturating_sub(reused)));
}

/// Command that continues a study, with the present name of this program.
#[must_use]
pub fn resume_command(directory: &Path, samples: &Samples) -> String {
    resume_command_with(Path::new(&samples.study().file), directory, samples.scale(), samples.limit())
}

fn resume_command_with(study: &Path, directory: &Path, scale: Option<f64>, limit: Option<u64>) -> String {
    let (study, directory) = (call::path_word(study), call::path_word(directory));
    let mut words: Vec<OsString> = vec!["run".into(), study.into(), "--out".into(), directory.into()];
    words.extend(scale.into_iter().flat_map(|scale| ["--scale".into(), scale.to_string().into()]));
    words.extend(limit.into_iter().flat_map(|limit| ["--limit".into(), limit.to_string().into()]));
    call::command(words)
}

/// Status of a result directory for other processes.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectoryStatus {
    /// State of the run.
    pub state: RunState,
    /// Last report of the last run, if it exists, with the counts of the record if no run lives.
    pub last_report: Option<Map<String, Value>>,
    /// Whether the counts are those of the record instead of the last report.
    pub is_counted: bool,
}

/// State of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RunState {
    /// A run lives; `stopped`: its process is stopped (SIGSTOP, Ctrl-Z).
    Running {
        /// Its process, if known.
        holder: Option<Holder>,
        /// Whether it is stopped.
        stopped: bool,
    },
    /// The last run was killed; its process is unknown if only its last report remains.
    Killed(Option<Holder>),
    /// The study is complete: the table exists.
    Complete,
    /// The last run ended in order before the study was complete, or failed.
    Ended,
    /// Unknown whether a run lives.
    Unknown {
        /// Reason.
        why: String,
    },
}

impl RunState {
    /// Word for programs.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            RunState::Running { stopped: false, .. } => "running",
            RunState::Running { stopped: true, .. } => "stopped",
            RunState::Killed(_) => "killed",
            RunState::Complete => "complete",
            RunState::Ended => "ended",
            RunState::Unknown { .. } => "unknown",
        }
    }
}

/// Reads the status of a result directory without an effect on its run; `None`: it is no result directory.
///
/// # Errors
/// The directory cannot be read.
pub fn directory_status(directory: &Path) -> Result<Option<DirectoryStatus>, FileError> {
    let folder = match Folder::open(directory) {
        Ok(folder) => folder,
        Err(source) if matches!(source.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
            return Ok(None);
        }
        Err(source) => return Err(FileError::at("open", directory)(source)),
    };
    // An unreadable directory is an error, not a missing run.
    let is_there = |name| {
        let place = folder.place(name);
        place.identity().map(|found| found.is_some()).map_err(FileError::at("look at", &place))
    };
    if !is_there(LEDGER)? && !is_there(LOCK)? {
        return Ok(None);
    }
    loop {
        let locked = lock_state(&folder, LOCK)?;
        let seen = status_by_lock(&folder, &locked);
        // A run that began meanwhile was changing the files.
        if matches!(locked, LockState::Held(_)) || lock_state(&folder, LOCK)? == locked {
            return Ok(Some(seen));
        }
    }
}

/// Whether the last report describes a complete study.
pub(super) fn tells_complete(directory: &Folder) -> bool {
    last_report(directory).is_some_and(|report| report.get("state") == Some(&json!("complete")))
}

fn last_report(directory: &Folder) -> Option<Map<String, Value>> {
    let text = directory.place(STATUS).read(MOST_STATUS).unwrap_or_default();
    match serde_json::from_slice(&text) {
        Ok(Value::Object(report)) if report.get("schema") == Some(&json!(STATUS_SCHEMA)) => Some(report),
        _ => None,
    }
}

fn status_by_lock(directory: &Folder, locked: &LockState) -> DirectoryStatus {
    let mut report = last_report(directory);
    // A run that a signal or a limit ended before its first sample reports its end in the lock only.
    if matches!(locked, LockState::Free)
        && let Some(report) = report.as_mut().filter(|report| report.get("state") == Some(&json!("running")))
        && let Some(ended) = given_back(directory, LOCK)
    {
        report.insert("state".to_owned(), json!(ended));
    }
    let is_final = report.as_ref().is_none_or(|report| report.get("state") != Some(&json!("running")));
    let is_complete = || directory.place(RESULTS).is_file();
    let running = |holder: Holder| {
        let stopped = Some(&holder.host) == host().as_ref() && is_stopped(holder.pid);
        RunState::Running { holder: Some(holder), stopped }
    };
    let living = match locked {
        LockState::Held(LockKeeper::Run(holder) | LockKeeper::Recorded(holder)) => Some(holder.clone()),
        LockState::Unreadable { holder: Some(by), .. } => reported_holder(report.as_ref(), by),
        _ => None,
    };
    let state = match (living, locked) {
        (Some(holder), _) => running(holder),
        (_, LockState::Abandoned(holder)) => RunState::Killed(Some(holder.clone())),
        // A run removes the table before it computes.
        _ if is_complete() => RunState::Complete,
        (_, LockState::Held(by)) => RunState::Unknown { why: format!("{LOCK} is locked by {by}") },
        (_, LockState::Unreadable { owner, holder: by }) => {
            let by = by.as_ref().map(|by| format!(", and is locked by {by}")).unwrap_or_default();
            RunState::Unknown { why: format!("only its owner (uid {owner}) can read {LOCK}{by}") }
        }
        (_, LockState::Free) if is_final => RunState::Ended,
        // It ended without a report: its lock was removed, its directory moved, its disk full.
        (_, LockState::Free) => RunState::Killed(None),
    };
    if let RunState::Running { holder, .. } = &state {
        // The report of the previous run does not describe the present one.
        let is_its_own = |report: &Map<String, Value>| {
            holder.as_ref().is_none_or(|holder| report.get("pid") == Some(&json!(holder.pid)))
        };
        let report = report.filter(is_its_own).map(|report| with_command(directory.path(), report));
        return DirectoryStatus { state, last_report: report, is_counted: false };
    }
    if !matches!(locked, LockState::Free | LockState::Abandoned(_)) {
        // A live run may be writing the record.
        return DirectoryStatus {
            state,
            last_report: report.map(|report| with_command(directory.path(), report)),
            is_counted: false,
        };
    }
    let (report, is_counted) = of_record(directory, report, is_final);
    DirectoryStatus { state, last_report: report.map(|report| with_command(directory.path(), report)), is_counted }
}

/// Run of the last report, if it is the process that holds the lock.
fn reported_holder(report: Option<&Map<String, Value>>, by: &LockHolder) -> Option<Holder> {
    let report = report?;
    let text = |key: &str| report.get(key).and_then(Value::as_str).map(str::to_owned);
    let holder = Holder {
        pid: u32::try_from(report.get("pid")?.as_u64()?).ok()?,
        host: text("host").unwrap_or_default(),
        started: text("started")?,
    };
    let is_here = Some(&holder.host) == host().as_ref();
    by.is_process(holder.pid, is_here).then_some(holder)
}

/// Replaces the counts of the last report by those of the record; returns whether the record was read. `is_final`: the report was
/// written at an end, so its counts are correct if the record has as many samples.
fn of_record(
    directory: &Folder,
    report: Option<Map<String, Value>>,
    is_final: bool,
) -> (Option<Map<String, Value>>, bool) {
    let read = || {
        let record = Reader::peek(directory.place(LEDGER)).ok()?;
        let header = record.header().ok()?;
        let total = header.get("samples")?.parse().ok()?;
        let number = |key: &str| report.as_ref().and_then(|report| report.get(key)).and_then(Value::as_u64);
        let recorded = number("done").map(|done| done + number("surplus").unwrap_or(0));
        if is_final && recorded == Some(record.len().ok()?) && number("total") == Some(total) {
            return report.clone();
        }
        // only samples before the end of a table that [stop] ended
        let table = directory.place(RESULTS);
        let end = table.is_file().then(|| end_of_table(&directory.path().join(RESULTS)).ok().flatten()).flatten();
        let (mut tally, mut surplus) = (Tally::default(), 0);
        let counted = record.for_each_head(None, |sample, head| match head {
            _ if end.is_some_and(|end| sample >= end.samples) => surplus += 1,
            Ok(head) => tally.count(head.status, head.cause),
            // Damaged entries are computed again.
            Err(_) => {}
        });
        counted.ok()?;
        let mut report = report.clone().unwrap_or_default();
        report.insert("schema".to_owned(), json!(STATUS_SCHEMA));
        report.insert("study".to_owned(), json!(header.get("study")));
        report.insert("total".to_owned(), json!(total));
        let reused = report.get("reused").and_then(Value::as_u64).unwrap_or(0);
        if let Some(end) = end {
            report.insert("stop".to_owned(), end.json());
        }
        put_counts(&mut report, &tally, (total, reused), end.map(|_| surplus));
        Some(report)
    };
    match read() {
        Some(counted) => (Some(counted), true),
        None => (report, false),
    }
}

/// Adds the command that continues the study from the present folder: the run may have been started from another folder, or the
/// directory may have been moved.
fn with_command(directory: &Path, mut report: Map<String, Value>) -> Map<String, Value> {
    let text = |key: &str| report.get(key).and_then(Value::as_str).map(Path::new);
    if let Some(study) = text("study_file") {
        let here = std::env::current_dir().ok();
        let study = match text("started_in") {
            Some(folder) if here.as_deref() != Some(folder) => folder.join(study),
            _ => study.to_path_buf(),
        };
        let (scale, limit) = (report.get("scale").and_then(Value::as_f64), report.get("limit").and_then(Value::as_u64));
        let trust = if report.get("trust_dir") == Some(&json!(true)) { TRUST } else { "" };
        report.insert("resume".to_owned(), json!(resume_command_with(&study, directory, scale, limit) + trust));
    }
    report
}

fn is_stopped(pid: u32) -> bool {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    // The name in parentheses may contain any characters; the state is the first word after it.
    stat.rsplit_once(") ").is_some_and(|(_, rest)| rest.starts_with(['T', 't']))
}

/// Describes the activity of a worker in one line.
pub(super) fn describe(worker: &WorkerView) -> String {
    let since = duration(worker.since);
    let activity = match worker.activity {
        Activity::Starting => format!("starting for {since}"),
        Activity::Idle => format!("waiting for work for {since}"),
        Activity::Busy { sample: Some(sample), left: 0..=1 } => format!("computing sample {sample} for {since}"),
        Activity::Busy { sample: Some(sample), left } => {
            format!("computing sample {sample} for {since}, then {} more of its batch", left - 1)
        }
        Activity::Busy { sample: None, left } => {
            format!("given a batch of {} {since} ago", counted(left as u64, "sample"))
        }
        Activity::Leaving => format!("asked to end {since} ago"),
        Activity::Gone => format!("died {since} ago; its replacement is starting"),
    };
    let pid = worker.pid.map(|pid| format!(" (process {pid})")).unwrap_or_default();
    let silent = if worker.stale { "; no message from it for a while" } else { "" };
    format!("worker {}{pid}: {activity}{silent}", worker.worker)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_that_goes_on_is_for_whoever_looks() {
        let report = |started_in: &Path| {
            let report =
                json!({ "study_file": "studies/a b.toml", "started_in": started_in, "scale": 0.5, "limit": null });
            let report = with_command(Path::new("out"), report.as_object().cloned().expect("an object"));
            report["resume"].as_str().expect("a command").to_owned()
        };
        let here = std::env::current_dir().expect("a directory");
        assert_eq!(report(&here), format!("{} run 'studies/a b.toml' --out out --scale 0.5", call::program()));
        assert!(report(Path::new("/else where")).contains(" run '/else where/studies/a b.toml' --out out "));
    }

    #[test]
    fn a_folder_without_a_run_is_none() {
        let folder = tempfile::tempdir().expect("temporary directory");
        assert_eq!(directory_status(folder.path()).expect("readable"), None);
    }
}
