//! What a run tells of itself while it goes on: `status.json`, replaced about once a second, and what others see of it.
//!
//! The record cannot be read by another process while the run lives, so `bladeoff status` reads this file, and the lock to
//! know whether anybody is still there. Its counts are those of durable samples. It is renamed into place but not synced:
//! after a power cut it may be old or missing. Once nobody works in the directory the record says what is true.

use super::directory::{LEDGER, LOCK, RESULTS, STATUS};
use super::end::{TableEnd, end_of_table};
use super::lock::{Holder, Keeper, Look, given_back, look};
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

/// Version of its layout.
const STATUS_SCHEMA: u64 = 1;
/// What a command says to work in a directory that others could write in.
pub const TRUST: &str = " --trust-dir";
/// Largest that is read.
const MOST_STATUS: u64 = 4 << 20;
/// Least time between two writings.
const EVERY: Duration = Duration::from_secs(1);

/// Writes the file of one run.
#[derive(Debug)]
pub(super) struct StatusWriter {
    path: Place,
    /// What does not change during the run.
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
            "go_on": go_on(directory, samples),
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

    /// Of a run that was told to trust those who could write in the directory: so must be the one that goes on.
    pub fn trusting(mut self, trusts: bool) -> Self {
        if let Some(Value::String(command)) = self.fixed.get_mut("go_on").filter(|_| trusts) {
            command.push_str(TRUST);
        }
        self.fixed.insert("trust_dir".to_owned(), json!(trusts));
        self
    }

    /// Writes that the run has begun. As with every writing, a failure is none of the study's: the next one may succeed.
    pub fn begin(&mut self, durable: &Tally) {
        let _ = self.replace(&self.text("running", None, None, durable));
    }

    /// Writes the present state, if it is time to; `left`: time for the rest.
    pub fn update(&mut self, snapshot: &Snapshot, left: Option<Eta>, durable: &Tally, now: Instant) {
        // What is told at the end is the last that was seen, written or not.
        self.last = Some(snapshot.clone());
        // of all stages of a run, of which the snapshot knows the present one
        self.elapsed = now.saturating_duration_since(self.begun);
        if self.written.is_some_and(|written| now.duration_since(written) < EVERY) {
            return;
        }
        self.written = Some(now);
        self.left = left;
        let _ = self.replace(&self.text("running", None, Some(snapshot), durable));
    }

    /// What is told with the last state: why the run ended, and where the table ends if that is not where its design does.
    pub fn tell_end(&mut self, ended: Ended, end: Option<TableEnd>) {
        self.fixed.insert("ended".to_owned(), json!(ended.word()));
        self.fixed.insert("stop".to_owned(), json!(end.map(|end| end.json())));
    }

    /// Writes the last state; `error`: why the run failed. `tally`: of the table, `surplus` what the record holds beyond its end.
    pub fn finish(&mut self, state: &str, error: Option<&(dyn Error + 'static)>, tally: &Tally, surplus: u64) {
        self.surplus = surplus;
        let last = self.last.take();
        self.left = None;
        // What workers were doing a moment ago is no longer true.
        let last = last.map(|snapshot| Snapshot { workers: Vec::new(), rate: 0.0, ..snapshot });
        let error = error.map(with_causes);
        let text = self.text(state, error.as_deref(), last.as_ref(), tally);
        if self.replace(&text).is_err() {
            // On a full disk the old file has the room that a new one has not.
            let over = || {
                let mut file = self.path.open_own().map_err(|error| error.source)?;
                file.write_all(text.as_bytes())?;
                file.set_len(text.len() as u64)
            };
            let _: std::io::Result<()> = over();
        }
    }

    /// Writes elsewhere: for tests.
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

/// Puts the counts of finished samples; `reused`: those of earlier runs. `beyond`: samples in the record beyond the end of a table that
/// `[stop]` ends, of which nothing is left to compute.
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

/// The command that continues a study, as this program is called.
#[must_use]
pub fn go_on(directory: &Path, samples: &Samples) -> String {
    go_on_with(Path::new(&samples.study().file), directory, samples.scale(), samples.limit())
}

fn go_on_with(study: &Path, directory: &Path, scale: Option<f64>, limit: Option<u64>) -> String {
    let (study, directory) = (call::path_word(study), call::path_word(directory));
    let mut words: Vec<OsString> = vec!["run".into(), study.into(), "--out".into(), directory.into()];
    words.extend(scale.into_iter().flat_map(|scale| ["--scale".into(), scale.to_string().into()]));
    words.extend(limit.into_iter().flat_map(|limit| ["--limit".into(), limit.to_string().into()]));
    call::command(words)
}

/// What is known of a result directory from outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// Whether somebody works in it.
    pub state: RunState,
    /// What the last run told of itself, if it did, with the counts of the record where nobody works in the directory.
    pub told: Option<Map<String, Value>>,
    /// Whether its counts are those of the record, not those of the moment in which the run told them last.
    pub is_counted: bool,
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
    /// The last run did not end in order; who it was is not known where nothing but its last words tell of it.
    Killed(Option<Holder>),
    /// Complete: the table is there.
    Complete,
    /// Ended in order before it was complete, or failed.
    Ended,
    /// Whether somebody works in it cannot be found out.
    Unknown {
        /// Why not.
        why: String,
    },
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
            RunState::Unknown { .. } => "unknown",
        }
    }
}

/// Looks at a result directory without disturbing who works in it; `None` if it is none.
///
/// # Errors
/// It cannot be read.
pub fn see(directory: &Path) -> Result<Option<Seen>, FileError> {
    let folder = match Folder::open(directory) {
        Ok(folder) => folder,
        Err(source) if matches!(source.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
            return Ok(None);
        }
        Err(source) => return Err(FileError::at("open", directory)(source)),
    };
    // What cannot be looked at is an error: nothing is said of a directory that cannot be entered.
    let is_there = |name| {
        let place = folder.place(name);
        place.identity().map(|found| found.is_some()).map_err(FileError::at("look at", &place))
    };
    if !is_there(LEDGER)? && !is_there(LOCK)? {
        return Ok(None);
    }
    loop {
        let locked = look(&folder, LOCK)?;
        let seen = see_locked(&folder, &locked);
        // A run that began meanwhile was changing what was read.
        if matches!(locked, Look::Held(_)) || look(&folder, LOCK)? == locked {
            return Ok(Some(seen));
        }
    }
}

/// Whether the last run told that the study is complete.
pub(super) fn tells_complete(directory: &Folder) -> bool {
    told(directory).is_some_and(|told| told.get("state") == Some(&json!("complete")))
}

fn told(directory: &Folder) -> Option<Map<String, Value>> {
    let text = directory.place(STATUS).read(MOST_STATUS).unwrap_or_default();
    match serde_json::from_slice(&text) {
        Ok(Value::Object(told)) if told.get("schema") == Some(&json!(STATUS_SCHEMA)) => Some(told),
        _ => None,
    }
}

fn see_locked(directory: &Folder, locked: &Look) -> Seen {
    let mut told = told(directory);
    // A run that a signal or a limit ended before its first sample told nothing of its end but in the lock.
    if matches!(locked, Look::Free)
        && let Some(told) = told.as_mut().filter(|told| told.get("state") == Some(&json!("running")))
        && let Some(ended) = given_back(directory, LOCK)
    {
        told.insert("state".to_owned(), json!(ended));
    }
    let is_final = told.as_ref().is_none_or(|told| told.get("state") != Some(&json!("running")));
    let is_complete = || directory.place(RESULTS).is_file();
    let running = |holder: Holder| {
        let stopped = Some(&holder.host) == host().as_ref() && is_stopped(holder.pid);
        RunState::Running { holder: Some(holder), stopped }
    };
    let living = match locked {
        Look::Held(Keeper::Run(holder) | Keeper::Told(holder)) => Some(holder.clone()),
        Look::Closed { by: Some(by), .. } => holder_told(told.as_ref(), by),
        _ => None,
    };
    let state = match (living, locked) {
        (Some(holder), _) => running(holder),
        (_, Look::Abandoned(holder)) => RunState::Killed(Some(holder.clone())),
        // A run removes the table before it computes.
        _ if is_complete() => RunState::Complete,
        (_, Look::Held(by)) => RunState::Unknown { why: format!("{LOCK} is locked by {by}") },
        (_, Look::Closed { owner, by }) => {
            let by = by.as_ref().map(|by| format!(", and is locked by {by}")).unwrap_or_default();
            RunState::Unknown { why: format!("{LOCK} may be read by its user (uid {owner}) alone{by}") }
        }
        (_, Look::Free) if is_final => RunState::Ended,
        // It ended without a word: its lock was removed, its directory moved, its disk full.
        (_, Look::Free) => RunState::Killed(None),
    };
    if let RunState::Running { holder, .. } = &state {
        // What the run before told says nothing of one that has just begun.
        let is_its_own = |told: &Map<String, Value>| {
            holder.as_ref().is_none_or(|holder| told.get("pid") == Some(&json!(holder.pid)))
        };
        let told = told.filter(is_its_own).map(|told| with_command(directory.path(), told));
        return Seen { state, told, is_counted: false };
    }
    if !matches!(locked, Look::Free | Look::Abandoned(_)) {
        // A run that lives may be writing the record.
        return Seen { state, told: told.map(|told| with_command(directory.path(), told)), is_counted: false };
    }
    let (told, is_counted) = of_record(directory, told, is_final);
    Seen { state, told: told.map(|told| with_command(directory.path(), told)), is_counted }
}

/// The run that told of itself, if it is the process that keeps the lock.
fn holder_told(told: Option<&Map<String, Value>>, by: &LockHolder) -> Option<Holder> {
    let told = told?;
    let text = |key: &str| told.get(key).and_then(Value::as_str).map(str::to_owned);
    let holder = Holder {
        pid: u32::try_from(told.get("pid")?.as_u64()?).ok()?,
        host: text("host").unwrap_or_default(),
        started: text("started")?,
    };
    let is_here = Some(&holder.host) == host().as_ref();
    by.is(holder.pid, is_here).then_some(holder)
}

/// What was told with the counts of the record, and whether it has been read. `is_final`: it was told at an end, so that its
/// counts are right if the record has as many.
fn of_record(
    directory: &Folder,
    told: Option<Map<String, Value>>,
    is_final: bool,
) -> (Option<Map<String, Value>>, bool) {
    let read = || {
        let record = Reader::peek(directory.place(LEDGER)).ok()?;
        let header = record.header().ok()?;
        let total = header.get("samples")?.parse().ok()?;
        let number = |key: &str| told.as_ref().and_then(|told| told.get(key)).and_then(Value::as_u64);
        let recorded = number("done").map(|done| done + number("surplus").unwrap_or(0));
        if is_final && recorded == Some(record.len().ok()?) && number("total") == Some(total) {
            return told.clone();
        }
        // of a table that [stop] ends those up to its end count
        let table = directory.place(RESULTS);
        let end = table.is_file().then(|| end_of_table(&directory.path().join(RESULTS)).ok().flatten()).flatten();
        let (mut tally, mut surplus) = (Tally::default(), 0);
        let counted = record.for_each_head(None, |sample, head| match head {
            _ if end.is_some_and(|end| sample >= end.samples) => surplus += 1,
            Ok(head) => tally.count(head.status, head.cause),
            // What is damaged is computed again.
            Err(_) => {}
        });
        counted.ok()?;
        let mut told = told.clone().unwrap_or_default();
        told.insert("schema".to_owned(), json!(STATUS_SCHEMA));
        told.insert("study".to_owned(), json!(header.get("study")));
        told.insert("total".to_owned(), json!(total));
        let reused = told.get("reused").and_then(Value::as_u64).unwrap_or(0);
        if let Some(end) = end {
            told.insert("stop".to_owned(), end.json());
        }
        put_counts(&mut told, &tally, (total, reused), end.map(|_| surplus));
        Some(told)
    };
    match read() {
        Some(counted) => (Some(counted), true),
        None => (told, false),
    }
}

/// What was told, with the command that goes on from here: the run may have been started from another folder, by another way to
/// this program, and the directory may have been moved since.
fn with_command(directory: &Path, mut told: Map<String, Value>) -> Map<String, Value> {
    let text = |key: &str| told.get(key).and_then(Value::as_str).map(Path::new);
    if let Some(study) = text("study_file") {
        let here = std::env::current_dir().ok();
        let study = match text("started_in") {
            Some(folder) if here.as_deref() != Some(folder) => folder.join(study),
            _ => study.to_path_buf(),
        };
        let (scale, limit) = (told.get("scale").and_then(Value::as_f64), told.get("limit").and_then(Value::as_u64));
        let trust = if told.get("trust_dir") == Some(&json!(true)) { TRUST } else { "" };
        told.insert("go_on".to_owned(), json!(go_on_with(&study, directory, scale, limit) + trust));
    }
    told
}

fn is_stopped(pid: u32) -> bool {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    // The name in parentheses may hold anything; the state is the first word after it.
    stat.rsplit_once(") ").is_some_and(|(_, rest)| rest.starts_with(['T', 't']))
}

/// What a worker is doing, in one line.
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
        Activity::Leaving => format!("told to end {since} ago"),
        Activity::Gone => format!("died {since} ago; the next one starts in a moment"),
    };
    let pid = worker.pid.map(|pid| format!(" (process {pid})")).unwrap_or_default();
    let silent = if worker.stale { "; it has not been heard of for a while" } else { "" };
    format!("worker {}{pid}: {activity}{silent}", worker.worker)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_that_goes_on_is_for_whoever_looks() {
        let told = |started_in: &Path| {
            let told =
                json!({ "study_file": "studies/a b.toml", "started_in": started_in, "scale": 0.5, "limit": null });
            let told = with_command(Path::new("out"), told.as_object().cloned().expect("an object"));
            told["go_on"].as_str().expect("a command").to_owned()
        };
        let here = std::env::current_dir().expect("a directory");
        assert_eq!(told(&here), format!("{} run 'studies/a b.toml' --out out --scale 0.5", call::program()));
        assert!(told(Path::new("/else where")).contains(" run '/else where/studies/a b.toml' --out out "));
    }

    #[test]
    fn a_folder_without_a_run_is_none() {
        let folder = tempfile::tempdir().expect("temporary directory");
        assert_eq!(see(folder.path()).expect("readable"), None);
    }
}
