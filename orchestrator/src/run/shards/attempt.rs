//! Attempts: processes that compute a shard, with a heartbeat file for each attempt and hints at the chunks in progress.
//!
//! An attempt has its own name of 128 random bits, because schedulers reuse job numbers. Its file `attempts/NA/NAME.json` is
//! replaced every [`heartbeat_interval`]. An attempt without a heartbeat for [`stale_after`] is stale. Both times use the
//! modification times of the files, so the clock of the file server counts and the clocks of the nodes do not. A hint names the
//! attempt that computes a chunk. Hints only direct the choice of chunks; no result depends on them.

use super::super::stamp::{host, timestamp};
use super::layout::{ATTEMPTS, HINTS, Shard, folder_name, folder_of, hint_name, hinted};
use super::shared::Shared;
use bladeoff_system::files::{FileError, Pending, write_new};
use bladeoff_system::folder::Folder;
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;
use std::time::{Duration, SystemTime};

/// Heartbeat interval with few shards.
const HEARTBEAT: Duration = Duration::from_secs(15);
/// Number of shards from which the heartbeat interval grows, up to [`MAX_FACTOR`] times: the file server serves all attempts.
const MANY: u64 = 500;
/// Largest factor of the heartbeat interval.
const MAX_FACTOR: u64 = 4;
/// State of an attempt that `wall` of `[stop]` ended.
pub(super) const TIME_WAS_OVER: &str = "stop";
/// State of an attempt in progress.
pub(super) const RUNNING: &str = "running";
/// Largest attempt or hint file that is read \[bytes\].
const MOST: u64 = 64 << 10;
/// Environment variables that hold the number of a job, the most specific first.
const JOBS: [&str; 5] = ["SLURM_JOB_ID", "PBS_JOBID", "LSB_JOBID", "HQ_JOB_ID", "JOB_ID"];

/// Heartbeat interval of an attempt, by the number of shards.
pub(super) fn heartbeat_interval(shards: u64) -> Duration {
    HEARTBEAT * u32::try_from((shards / MANY).clamp(1, MAX_FACTOR)).expect("a few")
}

/// Time without a heartbeat after which an attempt is stale, by the number of shards.
pub(super) fn stale_after(shards: u64) -> Duration {
    4 * heartbeat_interval(shards)
}

/// Time without a heartbeat after which the attempt of this report is stale.
fn stale_after_report(report: &Map<String, Value>) -> Duration {
    let shard = report.get("shard").and_then(Value::as_str).and_then(|shard| shard.parse().ok());
    stale_after(shard.map_or(1, |shard: Shard| shard.of))
}

/// Attempt at a shard.
#[derive(Debug, Clone)]
pub(super) struct Attempt {
    /// Name: 128 random bits in hexadecimal digits.
    pub id: String,
    /// Shard that the attempt computes first.
    pub shard: Shard,
    fixed: Map<String, Value>,
}

/// Progress of an attempt.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Counts {
    /// Chunks published.
    pub published: u64,
    /// Published chunks of other shards.
    pub helped: u64,
    /// Chunks that another attempt published first.
    pub lost: u64,
}

impl Attempt {
    /// Begins an attempt in this process.
    ///
    /// # Errors
    /// The system gives no random numbers.
    pub fn begin(shard: Shard, workers: usize) -> Result<Self, FileError> {
        let mut random = [0; 16];
        let source = Path::new("/dev/urandom");
        let read = File::open(source).and_then(|mut file| file.read_exact(&mut random));
        read.map_err(FileError::at("read", source))?;
        let id = random.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        let job = JOBS.iter().find_map(|name| std::env::var(name).ok());
        let array = std::env::var("SLURM_ARRAY_JOB_ID").ok();
        let restart = std::env::var("SLURM_RESTART_COUNT").ok();
        let fixed = json!({
            "attempt": id,
            "shard": shard.to_string(),
            "host": host(),
            "pid": std::process::id(),
            "workers": workers,
            "job": job,
            "array": array,
            "restart": restart,
            "started": timestamp(SystemTime::now()),
        });
        let Value::Object(fixed) = fixed else { unreachable!("written as an object") };
        Ok(Self { id, shard, fixed })
    }

    /// Metadata of the attempt for the head of a chunk.
    pub fn metadata(&self) -> Value {
        Value::Object(self.fixed.clone())
    }

    /// Writes the heartbeat file with a state; returns its time by the clock of the file server.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn report(&self, shared: &Shared, state: &str, counts: Counts) -> Result<SystemTime, FileError> {
        let mut report = self.fixed.clone();
        report.insert("state".to_owned(), json!(state));
        report.insert("published".to_owned(), json!(counts.published));
        report.insert("helped".to_owned(), json!(counts.helped));
        report.insert("lost".to_owned(), json!(counts.lost));
        report.insert("updated".to_owned(), json!(timestamp(SystemTime::now())));
        let place = shared.made_below(ATTEMPTS, folder_of_attempt(&self.id))?.place(name_of(&self.id));
        let mut pending = Pending::create(&place)?;
        let text = Value::Object(report).to_string();
        let dated = pending.file().write_all(text.as_bytes()).and_then(|()| pending.file().metadata()?.modified());
        let dated = dated.map_err(FileError::at("write", &place))?;
        // Not synced: a power failure ends the attempt as well.
        pending.put_in_place()?;
        Ok(dated)
    }

    /// Writes a hint that this attempt computes a chunk; replaces a stale hint. Failures are ignored.
    pub fn put_hint(&self, shared: &Shared, chunk: u64) {
        let hint = || -> Result<(), FileError> {
            let place = shared.numbered(HINTS, folder_of(chunk))?.place(hint_name(chunk));
            place.remove()?;
            write_new(&place, self.id.as_bytes())
        };
        let _ = hint();
    }

    /// Removes the hint of this attempt at a chunk. Failures are ignored.
    pub fn remove_hint(&self, shared: &Shared, chunk: u64) {
        if let Ok(folder) = hints(shared, chunk) {
            let _ = folder.place(hint_name(chunk)).remove();
        }
    }
}

fn hints(shared: &Shared, chunk: u64) -> io::Result<Folder> {
    shared.folder().folder(HINTS)?.folder(&folder_name(folder_of(chunk)))
}

/// Folder of an attempt's file. One folder would become too large with thousands of attempts.
fn folder_of_attempt(id: &str) -> &str {
    id.get(..2).unwrap_or_default()
}

/// Chunks of a folder that have a hint of any attempt. Failures are ignored.
pub(super) fn hinted_chunks(shared: &Shared, folder: u64) -> BTreeSet<u64> {
    let names = || shared.folder().folder(HINTS)?.folder(&folder_name(folder))?.names();
    names().unwrap_or_default().iter().filter_map(|name| hinted(name)).collect()
}

/// File name of an attempt.
fn name_of(id: &str) -> String {
    format!("{id}.json")
}

/// Whether another live attempt computes a chunk. An attempt of the same shard and job is dead: the scheduler started this one in
/// its place. `now`: time by the clock of the file server.
pub(super) fn is_in_progress_elsewhere(shared: &Shared, chunk: u64, own: &Attempt, now: SystemTime) -> bool {
    let at = || -> Option<bool> {
        let id = hints(shared, chunk).ok()?.place(hint_name(chunk)).read(MOST).ok()?;
        let id = String::from_utf8(id).ok().filter(|id| is_id(id))?;
        let folder = shared.folder().folder(ATTEMPTS).and_then(|all| all.folder(folder_of_attempt(&id))).ok()?;
        let place = folder.place(name_of(&id));
        let dated = place.open().ok()?.metadata().ok()?.modified().ok()?;
        let report: Map<String, Value> = serde_json::from_slice(&place.read(MOST).ok()?).ok()?;
        let is_fresh = now.duration_since(dated).map_or(true, |since| since < stale_after_report(&report));
        let is_dead = ["shard", "job"].into_iter().all(|key| report.get(key) == own.fixed.get(key));
        Some(is_fresh && says(&report, RUNNING) && !is_dead)
    };
    at().unwrap_or(false)
}

fn is_id(text: &str) -> bool {
    text.len() == 32 && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// Status of an attempt by its last report.
#[derive(Debug, Clone, PartialEq)]
pub struct AttemptStatus {
    /// Last report.
    pub report: Map<String, Value>,
    /// Age of the last report; correct if the clocks of this node and of the file server agree.
    pub silent: Option<Duration>,
    /// Whether the attempt is in progress and not stale.
    pub lives: bool,
}

impl AttemptStatus {
    /// Whether the last report has this state.
    pub(super) fn has_reported(&self, state: &str) -> bool {
        says(&self.report, state)
    }
}

fn says(report: &Map<String, Value>, state: &str) -> bool {
    report.get("state").and_then(Value::as_str) == Some(state)
}

/// Reads all attempts. The age of a report uses the clock of this node, which may differ from that of the file server.
pub(super) fn all_attempts(shared: &Shared) -> Vec<AttemptStatus> {
    let Ok(folders) = shared.folder().folder(ATTEMPTS) else { return Vec::new() };
    let mut found = Vec::new();
    for name in folders.names().unwrap_or_default() {
        let folder = name.to_str().and_then(|name| folders.folder(name).ok());
        let Some(folder) = folder else { continue };
        for name in folder.names().unwrap_or_default() {
            let is_one = name.to_str().and_then(|name| name.strip_suffix(".json")).is_some_and(is_id);
            let place = folder.place(&name);
            let Ok(bytes) = place.read(MOST) else { continue };
            if let (true, Ok(Value::Object(report))) = (is_one, serde_json::from_slice(&bytes)) {
                let dated = place.open().ok().and_then(|file| file.metadata().ok()?.modified().ok());
                let silent = dated.map(|dated| SystemTime::now().duration_since(dated).unwrap_or_default());
                let lives = says(&report, RUNNING) && silent.is_none_or(|silent| silent < stale_after_report(&report));
                found.push(AttemptStatus { report, silent, lives });
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_shards_say_less_often_that_they_live() {
        let seconds = |shards| (heartbeat_interval(shards).as_secs(), stale_after(shards).as_secs());
        assert_eq!(
            [1, 16, 999, 1000, 10_000, 100_000].map(seconds),
            [(15, 60), (15, 60), (15, 60), (30, 120), (60, 240), (60, 240)]
        );
    }

    #[test]
    fn a_hint_counts_as_long_as_its_attempt_lives_and_is_not_the_predecessor_of_this_one() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let shared = Shared::claim(directory.path(), true, &|_| {}).expect("empty");
        let attempt = |shard: &str, job: &str| {
            let mut attempt = Attempt::begin(shard.parse().expect("a shard"), 1).expect("random numbers");
            attempt.fixed.insert("job".to_owned(), json!(job));
            attempt
        };
        let first = attempt("0/2", "7");
        let now = first.report(&shared, RUNNING, Counts::default()).expect("written");
        first.put_hint(&shared, 3);
        let is_at = |own: &Attempt, now| is_in_progress_elsewhere(&shared, 3, own, now);
        assert!(is_at(&attempt("1/2", "7"), now), "another shard");
        assert!(is_at(&attempt("0/2", "8"), now), "the same in another job: both may live");
        assert!(!is_at(&attempt("0/2", "7"), now), "requeued: the first is dead");
        assert!(!is_at(&attempt("1/2", "7"), now + stale_after(2)), "not heard of");
        first.report(&shared, "ended", Counts::default()).expect("written");
        assert!(!is_at(&attempt("1/2", "7"), now), "it has said so");
        assert!(all_attempts(&shared).iter().all(|seen| !seen.lives && seen.has_reported("ended")));
    }
}
