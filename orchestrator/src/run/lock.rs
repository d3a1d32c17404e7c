//! One orchestrator per result directory.
//!
//! The lock is the operating system's on an open file (`flock`), held as long as the process lives: the kernel releases it
//! however the process ends, and a stopped process keeps it. An orderly end takes the holder out of the file, so that one
//! with a holder and no lock tells of a run that was killed. The file is written before anything else in the directory, each
//! time at once and over what was there: what it says tells a directory that a run began from one of somebody else.
//!
//! It is closed to others, who could lock it otherwise, if only to read. So they cannot look at the lock either; who holds one is told
//! by the system (`/proc/locks`), and the file is believed only where that cannot be.

use super::stamp::{host, timestamp};
use crate::dispatch::Ended;
use bladeoff_system::files::FileError;
use bladeoff_system::folder::Folder;
use bladeoff_system::locks::{self, LockHolder};
use bladeoff_system::place::{Identity, Place, identity};
use bladeoff_system::shown;
use bladeoff_text::document::visible;
use rustix::fs::fstat;
use rustix::process::geteuid;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, SystemTime};

/// Who works in the directory.
pub const LOCK: &str = "run.lock";

/// How long a lock is tried for: whoever only looks at it (`bladeoff status`) holds it for microseconds.
const PATIENCE: Duration = Duration::from_millis(500);
const STEP: Duration = Duration::from_millis(20);
/// How long whoever looks gives a run to say that it has the lock.
const SETTLING: Duration = Duration::from_millis(100);
/// By which the file of a lock is known.
const PROGRAM: &str = "bladeoff";
/// Bytes that are written at once, more than what was said before.
const LENGTH: usize = 512;

/// Who holds or held a lock.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Holder {
    /// Process id.
    pub pid: u32,
    /// Host name.
    pub host: String,
    /// When it started, UTC.
    pub started: String,
}

impl std::fmt::Display for Holder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "process {} on {}, started {}", self.pid, visible(&self.host), visible(&self.started))
    }
}

/// Who keeps a lock.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Keeper {
    /// The run that its file tells of; the system says so, too.
    Run(Holder),
    /// The run that its file tells of, which cannot be looked at from here: it is on another host, or the system tells of no
    /// locks.
    Told(Holder),
    /// A process of which its file does not tell.
    Process(LockHolder),
    /// Somebody whom this system does not show.
    Unknown,
}

impl Keeper {
    fn of(file: &File) -> Self {
        let told = holder(file);
        let pid = told.as_ref().map(|told| told.pid);
        let found = fstat(file).map_err(io::Error::from).and_then(|found| locks::holder(identity(&found), pid));
        let is_here = |told: &Holder| host().is_none_or(|host| host == told.host);
        match (found, told) {
            (Ok(Some(found)), Some(told)) if found.is(told.pid, is_here(&told)) => Self::Run(told),
            (Ok(Some(found)), _) => Self::Process(found),
            (Ok(None), Some(told)) if !is_here(&told) => Self::Told(told),
            (Err(_), Some(told)) if !is_here(&told) || lives(told.pid) => Self::Told(told),
            (Ok(None) | Err(_), _) => Self::Unknown,
        }
    }
}

impl std::fmt::Display for Keeper {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Run(holder) => holder.fmt(f),
            Self::Told(holder) => write!(f, "{holder}, as {LOCK} says (it cannot be looked at from here)"),
            Self::Process(holder) => holder.fmt(f),
            Self::Unknown => {
                f.write_str("a process that this system does not name (it may be of another host or container)")
            }
        }
    }
}

/// Why a directory is not ours.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another process has it.
    #[error(
        "{} {}: {by}",
        if matches!(by, Keeper::Run(_) | Keeper::Told(_)) { "another run works in" } else { "another process holds the lock (run.lock) of" },
        shown(directory)
    )]
    Held {
        /// The directory.
        directory: PathBuf,
        /// Who has it.
        by: Keeper,
    },
    /// A run of somebody else began the directory.
    #[error(
        "{} holds a run of another user (uid {owner}): its {LOCK} is theirs, and only that user can resume it; choose another --out",
        shown(directory)
    )]
    Theirs {
        /// The directory.
        directory: PathBuf,
        /// Whose the run is.
        owner: u32,
    },
    /// The file system of the directory grants no locks: Lustre without its option, some network and container mounts.
    #[error(
        "the file system of {} grants no locks (flock), so two runs could work in one directory; choose an --out on a local disk and copy \
         the result, or run the study as one shard, which takes no lock there: `bladeoff run STUDY --shard 0/1 --scratch LOCAL --out {}`, \
         then `bladeoff merge {}`; LOCAL is a folder on a local disk",
        shown(directory),
        shown(directory),
        shown(directory)
    )]
    NotGranted {
        /// The directory.
        directory: PathBuf,
        /// The system's answer.
        #[source]
        source: io::Error,
    },
    /// The lock file.
    #[error(transparent)]
    File(#[from] FileError),
}

/// Error of NFS where it grants no locks (`ENOTSUPP` of the kernel, which has no name outside).
const NOT_SUPPORTED: i32 = 524;

/// The system's answer to a lock, in words.
fn answer(source: io::Error) -> io::Error {
    match source.raw_os_error() {
        Some(NOT_SUPPORTED) => io::Error::new(io::ErrorKind::Unsupported, "not supported (os error 524)"),
        _ => source,
    }
}

/// Locks of this process.
struct Held {
    /// Their files, by number.
    files: BTreeMap<u64, File>,
    /// Why the process ends: a lock that is taken after that is given back at once.
    ended: Option<Ended>,
}

static HELD: Mutex<Held> = Mutex::new(Held { files: BTreeMap::new(), ended: None });
static NUMBERS: AtomicU64 = AtomicU64::new(0);

fn held() -> MutexGuard<'static, Held> {
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes into the files of all locks of this process why it ends in order: for a process that ends before it drops them.
pub fn give_back(ended: Ended) {
    let mut held = held();
    held.ended = Some(ended);
    for file in held.files.values() {
        // Best effort, as at the end of a lock.
        let _ = write(file, &returned(ended));
    }
}

/// Text of a lock that was given back.
fn returned(ended: Ended) -> Value {
    json!({ "program": PROGRAM, "ended": ended.word() })
}

/// Why the last run ended, where it gave its lock back before it wrote its status.
pub(super) fn given_back(directory: &Folder, name: &str) -> Option<String> {
    let file = directory.place(name).open().ok()?;
    Some(said(&file)?.get("ended")?.as_str()?.to_owned())
}

/// A lock that is held.
#[derive(Debug)]
pub struct Lock {
    number: u64,
    file: File,
    left_by: Option<Holder>,
}

impl Lock {
    /// Takes the lock of a directory, a file of the given name in it.
    ///
    /// # Errors
    /// Another process has it; the file cannot be written.
    pub fn take(directory: &Folder, name: &str) -> Result<Self, LockError> {
        let path = directory.place(name);
        let file = match path.open_or_create() {
            Err(error) => return Err(theirs(directory, &path).unwrap_or(error.into())),
            Ok(file) => file,
        };
        let mut waited = Duration::ZERO;
        loop {
            match file.try_lock() {
                Ok(()) => break,
                Err(TryLockError::WouldBlock) if waited < PATIENCE => {
                    thread::sleep(STEP);
                    waited += STEP;
                }
                Err(TryLockError::WouldBlock) => {
                    return Err(LockError::Held { directory: directory.path().to_path_buf(), by: Keeper::of(&file) });
                }
                Err(TryLockError::Error(source)) => {
                    let directory = directory.path().to_path_buf();
                    return Err(LockError::NotGranted { directory, source: answer(source) });
                }
            }
        }
        let left_by = holder(&file);
        // kept while the holder is written, so that a process that ends meanwhile gives this lock back as well
        let mut held = held();
        let holds = || {
            json!({
                "program": PROGRAM,
                "pid": std::process::id(),
                "host": host(),
                "started": timestamp(SystemTime::now()),
            })
        };
        let text = held.ended.map_or_else(holds, returned);
        // Durable before anything that is written after it.
        let written = write(&file, &text).and_then(|()| file.sync_all());
        written.map_err(FileError::at("write", &path))?;
        directory.sync()?;
        let number = NUMBERS.fetch_add(1, Ordering::Relaxed);
        held.files.insert(number, file.try_clone().map_err(FileError::at("open", &path))?);
        Ok(Self { number, file, left_by })
    }

    /// Who held it before and did not end in order.
    #[must_use]
    pub fn left_by(&self) -> Option<&Holder> {
        self.left_by.as_ref()
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // A copy of the handle would keep the lock.
        drop(held().files.remove(&self.number));
        // Best effort: at worst the next run says that this one did not end in order.
        let _ = write(&self.file, &json!({ "program": PROGRAM }));
    }
}

/// The error of a lock that belongs to somebody else and may not be opened.
pub(super) fn theirs(directory: &Folder, lock: &Place) -> Option<LockError> {
    let owner = lock.owner().filter(|owner| *owner != geteuid().as_raw())?;
    let is_closed = lock.open_own().is_err_and(|error| error.source.kind() == io::ErrorKind::PermissionDenied);
    is_closed.then(|| LockError::Theirs { directory: directory.path().to_path_buf(), owner })
}

/// What a look at a lock tells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Look {
    /// A living (or stopped) process has it.
    Held(Keeper),
    /// Its file may be read by its owner alone. Who keeps it, if the system tells.
    Closed {
        /// Whose it is.
        owner: u32,
        /// Who keeps it.
        by: Option<LockHolder>,
    },
    /// Its last holder was killed.
    Abandoned(Holder),
    /// Nobody has it.
    Free,
}

/// Looks at a lock without taking it for longer than a moment.
///
/// # Errors
/// The file is there but cannot be read.
pub fn look(directory: &Folder, name: &str) -> Result<Look, FileError> {
    let path = directory.place(name);
    let file = match path.open() {
        Ok(file) => file,
        Err(error) if error.source.kind() == io::ErrorKind::NotFound => return Ok(Look::Free),
        Err(error) if error.source.kind() == io::ErrorKind::PermissionDenied => {
            let by = |file: Identity| locks::holder(file, None).ok().flatten();
            let found = path.owner().zip(path.identity().ok().flatten());
            return found.map(|(owner, file)| Look::Closed { owner, by: by(file) }).ok_or(error);
        }
        Err(error) => return Err(error),
    };
    let mut waited = Duration::ZERO;
    loop {
        match file.try_lock_shared() {
            Ok(()) => return Ok(holder(&file).map_or(Look::Free, Look::Abandoned)),
            Err(TryLockError::WouldBlock) => {}
            // Nothing works here by way of this file system, which grants no locks; by way of another one a run may.
            Err(TryLockError::Error(_)) => {
                return Ok(holder(&file).map_or(Look::Free, |told| Look::Held(Keeper::Told(told))));
            }
        }
        match Keeper::of(&file) {
            // A run that has it for a moment and has not said so yet, or gives it back.
            Keeper::Process(_) | Keeper::Unknown if waited < SETTLING => {
                thread::sleep(STEP);
                waited += STEP;
            }
            by => return Ok(Look::Held(by)),
        }
    }
}

/// Whether a process of this number is there.
fn lives(pid: u32) -> bool {
    std::path::Path::new("/proc").join(pid.to_string()).exists()
}

/// What the lock says of a directory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    /// A run began it.
    Run,
    /// Nothing: its file is empty.
    Empty,
    /// Its file is not to be read: it is somebody else's.
    Closed,
    /// There is none, or it is another program's.
    None,
}

/// Whether a run began a directory, by the file of its lock.
pub(super) fn mark(directory: &Folder, name: &str) -> Mark {
    let file = match directory.place(name).open() {
        Ok(file) => file,
        Err(error) if error.source.kind() == io::ErrorKind::PermissionDenied => return Mark::Closed,
        Err(_) => return Mark::None,
    };
    if file.metadata().is_ok_and(|found| found.len() == 0) {
        return Mark::Empty;
    }
    let is_ours = said(&file).is_some_and(|value| value["program"] == PROGRAM);
    // Earlier builds said only who they are.
    if is_ours || holder(&file).is_some() { Mark::Run } else { Mark::None }
}

/// Replaces what the file says: one write over it, so that whoever is killed leaves the old words or the new ones.
fn write(file: &File, value: &Value) -> io::Result<()> {
    let mut text = value.to_string();
    text.push('\n');
    let whole = format!("{text:<LENGTH$}");
    file.write_all_at(whole.as_bytes(), 0)?;
    file.set_len(if whole.len() > LENGTH { whole.len() } else { text.len() } as u64)
}

fn said(file: &File) -> Option<Value> {
    let mut bytes = [0; 4096];
    let count = file.read_at(&mut bytes, 0).ok()?;
    // Behind it may be blanks, or the end of something longer.
    serde_json::Deserializer::from_slice(&bytes[..count]).into_iter().next()?.ok()
}

fn holder(file: &File) -> Option<Holder> {
    let value = said(file)?;
    Some(Holder {
        pid: u32::try_from(value["pid"].as_u64()?).ok()?,
        host: value["host"].as_str().unwrap_or("an unknown host").to_owned(),
        started: value["started"].as_str()?.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_is_held_by_one_and_an_orderly_end_leaves_no_holder() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let folder = Folder::open(directory.path()).expect("opened");
        let take = || Lock::take(&folder, "lock");
        assert_eq!(look(&folder, "lock").expect("readable"), Look::Free);
        assert_eq!(mark(&folder, "lock"), Mark::None);
        let first = take().expect("free");
        assert_eq!(first.left_by(), None);
        let Err(LockError::Held { by: Keeper::Run(holder), .. }) = take() else { panic!("taken twice") };
        assert_eq!(holder.pid, std::process::id());
        assert_eq!(look(&folder, "lock").expect("readable"), Look::Held(Keeper::Run(holder)));
        assert_eq!(mark(&folder, "lock"), Mark::Run);
        drop(first);
        assert_eq!(look(&folder, "lock").expect("readable"), Look::Free);
        assert_eq!(mark(&folder, "lock"), Mark::Run, "it remains the directory of a run");
        assert_eq!(take().expect("free again").left_by(), None);
    }

    #[test]
    fn whoever_keeps_a_lock_is_named_and_nobody_else() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let folder = Folder::open(directory.path()).expect("opened");
        let here = host().expect("a name");
        // What a killed run has left: its process is no more, or is another one by now.
        let left_by = |host: &str| {
            let text = json!({ "program": PROGRAM, "pid": 1, "host": host, "started": "2026" });
            std::fs::write(directory.path().join("lock"), text.to_string()).expect("written");
        };
        left_by(&here);
        let stranger = folder.place("lock").open_or_create().expect("there");
        assert!(matches!(look(&folder, "lock").expect("readable"), Look::Abandoned(_)), "nobody has it");
        for is_shared in [false, true] {
            if is_shared { stranger.lock_shared() } else { stranger.lock() }.expect("free");
            let Err(error @ LockError::Held { .. }) = Lock::take(&folder, "lock") else { panic!("it is held") };
            let words = error.to_string();
            let own = format!("process {} (", std::process::id());
            assert!(words.contains("another process holds the lock") && words.contains(&own), "{words}");
            stranger.unlock().expect("held");
        }
        stranger.lock().expect("free");
        let looked = look(&folder, "lock").expect("readable");
        assert!(matches!(&looked, Look::Held(Keeper::Process(found)) if found.pid == std::process::id()), "{looked:?}");
        // The same word of another host could be a container's: this one sees who it is.
        left_by("elsewhere");
        assert!(matches!(look(&folder, "lock").expect("readable"), Look::Held(Keeper::Process(_))));
    }

    #[test]
    fn a_lock_file_of_another_program_is_no_mark() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let folder = Folder::open(directory.path()).expect("opened");
        for (text, expected) in [
            ("", Mark::Empty),
            ("12345\n", Mark::None),
            ("{\"pid\": 7}", Mark::None),
            ("{\"host\":\"h\",\"pid\":1,\"started\":\"2026\"}\n", Mark::Run),
            ("{\"program\":\"bladeoff\"}  \nrest", Mark::Run),
        ] {
            std::fs::write(directory.path().join("lock"), text).expect("written");
            assert_eq!(mark(&folder, "lock"), expected, "{text:?}");
        }
    }
}
