//! Who computes: an attempt at a shard, with a file that it touches as long as it lives, and hints at the chunks that it is at.
//!
//! An attempt has a name of its own, 128 random bits: schedulers use the numbers of jobs again. Its file `attempts/NA/NAME.json` is replaced
//! every [`beat`]; that of an attempt not heard of for [`fresh`] is stale. Both times are the file server's, by the files' own dates: the
//! clocks of nodes are no matter. A hint names the attempt that is at a chunk. Hints direct who helps; nothing is right or wrong by them.

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

/// How often an attempt at one of few shards says that it lives.
const BEAT: Duration = Duration::from_secs(15);
/// From so many shards on they say it less often, up to [`SELDOM`] times: a file server hears all of them.
const MANY: u64 = 500;
/// See [`MANY`].
const SELDOM: u64 = 4;
/// What an attempt says in the end whose time, by `wall` of `[stop]`, was over.
pub(super) const TIME_WAS_OVER: &str = "stop";
/// What it says before.
pub(super) const RUNNING: &str = "running";
/// Largest file of an attempt, or hint, that is read.
const MOST: u64 = 64 << 10;
/// What schedulers say of a job, the most telling first.
const JOBS: [&str; 5] = ["SLURM_JOB_ID", "PBS_JOBID", "LSB_JOBID", "HQ_JOB_ID", "JOB_ID"];

/// How often an attempt at one of so many shards says that it lives.
pub(super) fn beat(shards: u64) -> Duration {
    BEAT * u32::try_from((shards / MANY).clamp(1, SELDOM)).expect("a few")
}

/// Silence after which the hints of one of so many count no more.
pub(super) fn fresh(shards: u64) -> Duration {
    4 * beat(shards)
}

/// The same of an attempt by what it says.
fn fresh_of(said: &Map<String, Value>) -> Duration {
    let shard = said.get("shard").and_then(Value::as_str).and_then(|shard| shard.parse().ok());
    fresh(shard.map_or(1, |shard: Shard| shard.of))
}

/// One attempt at a shard.
#[derive(Debug, Clone)]
pub(super) struct Attempt {
    /// Its name.
    pub id: String,
    /// At which shard.
    pub shard: Shard,
    fixed: Map<String, Value>,
}

/// How far an attempt is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Counts {
    /// Chunks published.
    pub published: u64,
    /// Of these, such that are another shard's.
    pub helped: u64,
    /// Chunks that somebody else had published before it.
    pub lost: u64,
}

impl Attempt {
    /// A new one, of this process.
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

    /// What a chunk says of who computed it.
    pub fn by(&self) -> Value {
        Value::Object(self.fixed.clone())
    }

    /// Says that it lives, or how it ended; gives the time of the file server.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn say(&self, shared: &Shared, state: &str, counts: Counts) -> Result<SystemTime, FileError> {
        let mut said = self.fixed.clone();
        said.insert("state".to_owned(), json!(state));
        said.insert("published".to_owned(), json!(counts.published));
        said.insert("helped".to_owned(), json!(counts.helped));
        said.insert("lost".to_owned(), json!(counts.lost));
        said.insert("updated".to_owned(), json!(timestamp(SystemTime::now())));
        let place = shared.made_below(ATTEMPTS, folder_of_attempt(&self.id))?.place(name_of(&self.id));
        let mut pending = Pending::create(&place)?;
        let text = Value::Object(said).to_string();
        let dated = pending.file().write_all(text.as_bytes()).and_then(|()| pending.file().metadata()?.modified());
        let dated = dated.map_err(FileError::at("write", &place))?;
        // Not synced: a power cut ends the attempt, too.
        pending.put_in_place()?;
        Ok(dated)
    }

    /// Puts a hint that it is at a chunk, in place of one that is stale. Best effort.
    pub fn hint(&self, shared: &Shared, chunk: u64) {
        let hint = || -> Result<(), FileError> {
            let place = shared.numbered(HINTS, folder_of(chunk))?.place(hint_name(chunk));
            place.remove()?;
            write_new(&place, self.id.as_bytes())
        };
        let _ = hint();
    }

    /// Takes its hint away.
    pub fn forget(&self, shared: &Shared, chunk: u64) {
        if let Ok(folder) = hints(shared, chunk) {
            let _ = folder.place(hint_name(chunk)).remove();
        }
    }
}

fn hints(shared: &Shared, chunk: u64) -> io::Result<Folder> {
    shared.folder().folder(HINTS)?.folder(&folder_name(folder_of(chunk)))
}

/// Where the file of an attempt lies: a thousand of many shards would be too many for one folder.
fn folder_of_attempt(id: &str) -> &str {
    id.get(..2).unwrap_or_default()
}

/// The chunks of a folder that have a hint, of whomever. Best effort.
pub(super) fn hints_in(shared: &Shared, folder: u64) -> BTreeSet<u64> {
    let names = || shared.folder().folder(HINTS)?.folder(&folder_name(folder))?.names();
    names().unwrap_or_default().iter().filter_map(|name| hinted(name)).collect()
}

/// Name of an attempt's file.
fn name_of(id: &str) -> String {
    format!("{id}.json")
}

/// Whether another attempt that lives is at a chunk. Whoever is at the same shard in the same job is dead for the scheduler, or it would not
/// have begun this one. `now`: the time of the file server.
pub(super) fn is_at(shared: &Shared, chunk: u64, own: &Attempt, now: SystemTime) -> bool {
    let at = || -> Option<bool> {
        let id = hints(shared, chunk).ok()?.place(hint_name(chunk)).read(MOST).ok()?;
        let id = String::from_utf8(id).ok().filter(|id| is_id(id))?;
        let folder = shared.folder().folder(ATTEMPTS).and_then(|all| all.folder(folder_of_attempt(&id))).ok()?;
        let place = folder.place(name_of(&id));
        let dated = place.open().ok()?.metadata().ok()?.modified().ok()?;
        let said: Map<String, Value> = serde_json::from_slice(&place.read(MOST).ok()?).ok()?;
        let is_fresh = now.duration_since(dated).map_or(true, |since| since < fresh_of(&said));
        let is_dead = ["shard", "job"].into_iter().all(|key| said.get(key) == own.fixed.get(key));
        Some(is_fresh && says(&said, RUNNING) && !is_dead)
    };
    at().unwrap_or(false)
}

fn is_id(text: &str) -> bool {
    text.len() == 32 && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// What is known of an attempt by what it has said last.
#[derive(Debug, Clone, PartialEq)]
pub struct AttemptSeen {
    /// All that it says.
    pub said: Map<String, Value>,
    /// How long ago, if the clocks agree.
    pub silent: Option<Duration>,
    /// Whether it is thought to live.
    pub lives: bool,
}

impl AttemptSeen {
    /// Whether this was its last word.
    pub(super) fn has_said(&self, state: &str) -> bool {
        says(&self.said, state)
    }
}

fn says(said: &Map<String, Value>, state: &str) -> bool {
    said.get("state").and_then(Value::as_str) == Some(state)
}

/// Every attempt that has said something. How long ago is by this clock, which may not be that of the file server.
pub(super) fn all(shared: &Shared) -> Vec<AttemptSeen> {
    let Ok(folders) = shared.folder().folder(ATTEMPTS) else { return Vec::new() };
    let mut found = Vec::new();
    for name in folders.names().unwrap_or_default() {
        let folder = name.to_str().and_then(|name| folders.folder(name).ok());
        let Some(folder) = folder else { continue };
        for name in folder.names().unwrap_or_default() {
            let is_one = name.to_str().and_then(|name| name.strip_suffix(".json")).is_some_and(is_id);
            let place = folder.place(&name);
            let Ok(bytes) = place.read(MOST) else { continue };
            if let (true, Ok(Value::Object(said))) = (is_one, serde_json::from_slice(&bytes)) {
                let dated = place.open().ok().and_then(|file| file.metadata().ok()?.modified().ok());
                let silent = dated.map(|dated| SystemTime::now().duration_since(dated).unwrap_or_default());
                let lives = says(&said, RUNNING) && silent.is_none_or(|silent| silent < fresh_of(&said));
                found.push(AttemptSeen { said, silent, lives });
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
        let seconds = |shards| (beat(shards).as_secs(), fresh(shards).as_secs());
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
        let now = first.say(&shared, RUNNING, Counts::default()).expect("written");
        first.hint(&shared, 3);
        let is_at = |own: &Attempt, now| is_at(&shared, 3, own, now);
        assert!(is_at(&attempt("1/2", "7"), now), "another shard");
        assert!(is_at(&attempt("0/2", "8"), now), "the same in another job: both may live");
        assert!(!is_at(&attempt("0/2", "7"), now), "requeued: the first is dead");
        assert!(!is_at(&attempt("1/2", "7"), now + fresh(2)), "not heard of");
        first.say(&shared, "ended", Counts::default()).expect("written");
        assert!(!is_at(&attempt("1/2", "7"), now), "it has said so");
        assert!(all(&shared).iter().all(|seen| !seen.lives && seen.has_said("ended")));
    }
}
