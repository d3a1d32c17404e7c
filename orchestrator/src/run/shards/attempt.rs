//! Who computes: an attempt at a shard, with a file that it touches as long as it lives, and hints at the chunks that it is at.
//!
//! An attempt has a name of its own, 128 random bits: schedulers use the numbers of jobs again. Its file `attempts/NAME.json` is replaced
//! every [`BEAT`]; that of an attempt not heard of for [`FRESH`] is stale. Both times are the file server's, by the files' own dates: the
//! clocks of nodes are no matter. A hint names the attempt that is at a chunk. Hints direct who helps; nothing is right or wrong by them.

use super::super::stamp::{host, timestamp};
use super::layout::{ATTEMPTS, HINTS, Shard, folder_name, folder_of, hint_name};
use super::shared::Shared;
use bladeoff_system::files::{FileError, Pending, write_new};
use bladeoff_system::folder::Folder;
use serde_json::{Map, Value, json};
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;
use std::time::{Duration, SystemTime};

/// How often an attempt says that it lives.
pub(super) const BEAT: Duration = Duration::from_secs(15);
/// Silence after which its hints count no more.
pub(super) const FRESH: Duration = Duration::from_secs(60);
/// Largest file of an attempt, or hint, that is read.
const MOST: u64 = 64 << 10;
/// What schedulers say of a job, the most telling first.
const JOBS: [&str; 5] = ["SLURM_JOB_ID", "PBS_JOBID", "LSB_JOBID", "HQ_JOB_ID", "JOB_ID"];

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
        let place = shared.made(ATTEMPTS)?.place(name_of(&self.id));
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

/// Name of an attempt's file.
fn name_of(id: &str) -> String {
    format!("{id}.json")
}

/// Whether an attempt that lives is at a chunk, other than those of `own` shard: whoever is at the same shard is thought to be dead by
/// the scheduler, or he would not have begun another attempt. `now`: the time of the file server.
pub(super) fn is_at(shared: &Shared, chunk: u64, own: Shard, now: SystemTime) -> bool {
    let at = || -> Option<bool> {
        let id = hints(shared, chunk).ok()?.place(hint_name(chunk)).read(MOST).ok()?;
        let id = String::from_utf8(id).ok().filter(|id| is_id(id))?;
        let place = shared.folder().folder(ATTEMPTS).ok()?.place(name_of(&id));
        let file = place.open().ok()?;
        let dated = file.metadata().ok()?.modified().ok()?;
        let said: Value = serde_json::from_slice(&place.read(MOST).ok()?).ok()?;
        let is_fresh = now.duration_since(dated).map_or(true, |since| since < FRESH);
        Some(is_fresh && said["state"] == "running" && said["shard"] != json!(own.to_string()))
    };
    at().unwrap_or(false)
}

fn is_id(text: &str) -> bool {
    text.len() == 32 && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// Every attempt that has said something, and how long ago by the file server: `now` is its time, if it is known.
pub(super) fn all(shared: &Shared, now: Option<SystemTime>) -> Vec<(Map<String, Value>, Option<Duration>)> {
    let Ok(folder) = shared.folder().folder(ATTEMPTS) else { return Vec::new() };
    let mut found = Vec::new();
    for name in folder.names().unwrap_or_default() {
        let is_one = name.to_str().and_then(|name| name.strip_suffix(".json")).is_some_and(is_id);
        let place = folder.place(&name);
        let Ok(bytes) = place.read(MOST) else { continue };
        if let (true, Ok(Value::Object(said))) = (is_one, serde_json::from_slice(&bytes)) {
            let dated = place.open().ok().and_then(|file| file.metadata().ok()?.modified().ok());
            let silent = dated.zip(now).map(|(dated, now)| now.duration_since(dated).unwrap_or_default());
            found.push((said, silent));
        }
    }
    found
}
