//! Lock of a result directory: one orchestrator at a time.
//!
//! The lock is `flock` on an open file, held while the process lives: the kernel releases it however the process ends, and a
//! stopped process keeps it. An orderly end removes the holder from the file, so a file with a holder and without a lock was left
//! by a killed run. The file is written before anything else in the directory, each time in one write over the old text. Its text
//! distinguishes a directory begun by a run from any other.
//!
//! Other users cannot open the file, because opening is enough to lock it. So they cannot test the lock either: the system
//! reports the holder (`/proc/locks`), and the text of the file is used only where it does not.

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

/// File name of the lock.
pub const LOCK: &str = "run.lock";

/// Time for which a lock is tried: readers (`bladeoff status`) hold it for microseconds.
const PATIENCE: Duration = Duration::from_millis(500);
const STEP: Duration = Duration::from_millis(20);
/// Time for which a reader waits until a run has written its holder.
const SETTLING: Duration = Duration::from_millis(100);
/// Key that identifies the text of a lock.
const PROGRAM: &str = "bladeoff";
/// Length of the text, larger than any earlier text \[bytes\].
const LENGTH: usize = 512;

/// Present or former holder of a lock.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Holder {
    /// Process id.
    pub pid: u32,
    /// Host name.
    pub host: String,
    /// Start time, UTC.
    pub started: String,
}

impl std::fmt::Display for Holder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "process {} on {}, started {}", self.pid, visible(&self.host), visible(&self.started))
    }
}

/// Process that holds a lock.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LockKeeper {
    /// Run named in the file and confirmed by the system.
    Run(Holder),
    /// Run named in the file, not confirmed: it is on another host, or the system reports no locks.
    Recorded(Holder),
    /// Process that the file does not name.
    Process(LockHolder),
    /// Unknown process, not reported by the system.
    Unknown,
}

impl LockKeeper {
    fn of(file: &File) -> Self {
        let recorded = holder(file);
        let pid = recorded.as_ref().map(|recorded| recorded.pid);
        let found = fstat(file).map_err(io::Error::from).and_then(|found| locks::holder(identity(&found), pid));
        let is_here = |recorded: &Holder| host().is_none_or(|host| host == recorded.host);
        match (found, recorded) {
            (Ok(Some(found)), Some(recorded)) if found.is_process(recorded.pid, is_here(&recorded)) => {
                Self::Run(recorded)
            }
            (Ok(Some(found)), _) => Self::Process(found),
            (Ok(None), Some(recorded)) if !is_here(&recorded) => Self::Recorded(recorded),
            (Err(_), Some(recorded)) if !is_here(&recorded) || lives(recorded.pid) => Self::Recorded(recorded),
            (Ok(None) | Err(_), _) => Self::Unknown,
        }
    }
}

impl std::fmt::Display for LockKeeper {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Run(holder) => holder.fmt(f),
            Self::Recorded(holder) => write!(f, "{holder}, according to {LOCK} (the process cannot be seen from here)"),
            Self::Process(holder) => holder.fmt(f),
            Self::Unknown => {
                f.write_str("a process that this system does not name (it may be of another host or container)")
            }
        }
    }
}

/// Reason why a directory cannot be locked.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another process holds the lock.
    #[error(
        "{} {}: {by}",
        if matches!(by, LockKeeper::Run(_) | LockKeeper::Recorded(_)) { "another run works in" } else { "another process holds the lock (run.lock) of" },
        shown(directory)
    )]
    Held {
        /// The directory.
        directory: PathBuf,
        /// Its holder.
        by: LockKeeper,
    },
    /// A run of another user began the directory.
    #[error(
        "{} contains a run of another user (uid {owner}), who owns its {LOCK}; only that user can resume it; choose \
         another --out",
        shown(directory)
    )]
    Theirs {
        /// The directory.
        directory: PathBuf,
        /// User of the run.
        owner: u32,
    },
    /// The file system grants no locks: Lustre without its option, some network and container mounts.
    #[error(
        "the file system of {} grants no locks (flock), so two runs could write to one directory. Choose an --out on \
         a local disk and copy the result. Or run the study as one shard, which takes no lock there: `bladeoff run \
         STUDY --shard 0/1 --scratch LOCAL --out {}`, then `bladeoff merge {}`, with LOCAL a folder on a local disk",
        shown(directory),
        shown(directory),
        shown(directory)
    )]
    NotGranted {
        /// The directory.
        directory: PathBuf,
        /// Error of the system.
        #[source]
        source: io::Error,
    },
    /// Error of the lock file.
    #[error(transparent)]
    File(#[from] FileError),
}

/// Error of NFS where it grants no locks (`ENOTSUPP` of the kernel, which has no name outside).
const NOT_SUPPORTED: i32 = 524;

/// Describes the error of the system.
fn answer(source: io::Error) -> io::Error {
    match source.raw_os_error() {
        Some(NOT_SUPPORTED) => io::Error::new(io::ErrorKind::Unsupported, "not supported (os error 524)"),
        _ => source,
    }
}

/// Locks of this process.
struct Held {
    /// Open lock files, by number.
    files: BTreeMap<u64, File>,
    /// Reason of the end of the process; a lock taken after that is released at once.
    ended: Option<Ended>,
}

static HELD: Mutex<Held> = Mutex::new(Held { files: BTreeMap::new(), ended: None });
static NUMBERS: AtomicU64 = AtomicU64::new(0);

fn held() -> MutexGuard<'static, Held> {
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes the reason of an orderly end into all lock files, for a process that ends before it drops them.
pub fn give_back(ended: Ended) {
    let mut held = held();
    held.ended = Some(ended);
    for file in held.files.values() {
        // Errors are ignored, as at the end of a lock.
        let _ = write(file, &returned(ended));
    }
}

/// Text of a released lock.
fn returned(ended: Ended) -> Value {
    json!({ "program": PROGRAM, "ended": ended.word() })
}

/// Reads the end of the last run, if it released its lock before it wrote its status.
pub(super) fn given_back(directory: &Folder, name: &str) -> Option<String> {
    let file = directory.place(name).open().ok()?;
    Some(said(&file)?.get("ended")?.as_str()?.to_owned())
}

/// Lock held by this process.
#[derive(Debug)]
pub struct Lock {
    number: u64,
    file: File,
    left_by: Option<Holder>,
}

impl Lock {
    /// Locks a directory by a file of the given name in it.
    ///
    /// # Errors
    /// Another process holds the lock, or the file cannot be written.
    pub fn take(directory: &Folder, name: &str) -> Result<Self, LockError> {
        let path = directory.place(name);
        let file = match path.open_or_create() {
            Err(error) => return Err(foreign_lock(directory, &path).unwrap_or(error.into())),
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
                    return Err(LockError::Held {
                        directory: directory.path().to_path_buf(),
                        by: LockKeeper::of(&file),
                    });
                }
                Err(TryLockError::Error(source)) => {
                    let directory = directory.path().to_path_buf();
                    return Err(LockError::NotGranted { directory, source: answer(source) });
                }
            }
        }
        let left_by = holder(&file);
        // The list stays locked until the holder is written, so that a process that ends meanwhile releases this lock as well.
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
        // Durable before anything else is written.
        let written = write(&file, &text).and_then(|()| file.sync_all());
        written.map_err(FileError::at("write", &path))?;
        directory.sync()?;
        let number = NUMBERS.fetch_add(1, Ordering::Relaxed);
        held.files.insert(number, file.try_clone().map_err(FileError::at("open", &path))?);
        Ok(Self { number, file, left_by })
    }

    /// Previous holder, if it was killed.
    #[must_use]
    pub fn left_by(&self) -> Option<&Holder> {
        self.left_by.as_ref()
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Another copy of the handle would keep the lock.
        drop(held().files.remove(&self.number));
        // Errors are ignored: at worst the next run reports that this one was killed.
        let _ = write(&self.file, &json!({ "program": PROGRAM }));
    }
}

/// Error of a lock file of another user that cannot be opened; `None`: it is not one.
pub(super) fn foreign_lock(directory: &Folder, lock: &Place) -> Option<LockError> {
    let owner = lock.owner().filter(|owner| *owner != geteuid().as_raw())?;
    let is_closed = lock.open_own().is_err_and(|error| error.source.kind() == io::ErrorKind::PermissionDenied);
    is_closed.then(|| LockError::Theirs { directory: directory.path().to_path_buf(), owner })
}

/// State of a lock.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LockState {
    /// Held by a live or stopped process.
    Held(LockKeeper),
    /// Only the owner of the file may open it.
    Unreadable {
        /// Owner of the file.
        owner: u32,
        /// Process that holds the lock; `None`: the system does not report it.
        holder: Option<LockHolder>,
    },
    /// Not held; the last holder was killed.
    Abandoned(Holder),
    /// Not held.
    Free,
}

/// Reads the state of a lock; holds it for a moment at most.
///
/// # Errors
/// The file exists but cannot be read.
pub fn lock_state(directory: &Folder, name: &str) -> Result<LockState, FileError> {
    let path = directory.place(name);
    let file = match path.open() {
        Ok(file) => file,
        Err(error) if error.source.kind() == io::ErrorKind::NotFound => return Ok(LockState::Free),
        Err(error) if error.source.kind() == io::ErrorKind::PermissionDenied => {
            let by = |file: Identity| locks::holder(file, None).ok().flatten();
            let found = path.owner().zip(path.identity().ok().flatten());
            return found.map(|(owner, file)| LockState::Unreadable { owner, holder: by(file) }).ok_or(error);
        }
        Err(error) => return Err(error),
    };
    let mut waited = Duration::ZERO;
    loop {
        match file.try_lock_shared() {
            Ok(()) => return Ok(holder(&file).map_or(LockState::Free, LockState::Abandoned)),
            Err(TryLockError::WouldBlock) => {}
            // This file system grants no locks. A run may still hold the lock through another mount.
            Err(TryLockError::Error(_)) => {
                return Ok(
                    holder(&file).map_or(LockState::Free, |recorded| LockState::Held(LockKeeper::Recorded(recorded)))
                );
            }
        }
        match LockKeeper::of(&file) {
            // A run that has just taken the lock and not written its holder, or that is releasing it.
            LockKeeper::Process(_) | LockKeeper::Unknown if waited < SETTLING => {
                thread::sleep(STEP);
                waited += STEP;
            }
            by => return Ok(LockState::Held(by)),
        }
    }
}

/// Whether a process of this number exists.
fn lives(pid: u32) -> bool {
    std::path::Path::new("/proc").join(pid.to_string()).exists()
}

/// Origin of a directory by its lock file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    /// Begun by a run.
    Run,
    /// Empty lock file.
    Empty,
    /// Unreadable lock file, of another user.
    Closed,
    /// No lock file, or that of another program.
    None,
}

/// Determines from the lock file whether a run began a directory.
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
    // Earlier builds wrote only the holder.
    if is_ours || holder(&file).is_some() { Mark::Run } else { Mark::None }
}

/// Replaces the text in one write, so that a killed process leaves either the old or the new text.
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
    // Blanks or the end of a longer text may follow.
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
        assert_eq!(lock_state(&folder, "lock").expect("readable"), LockState::Free);
        assert_eq!(mark(&folder, "lock"), Mark::None);
        let first = take().expect("free");
        assert_eq!(first.left_by(), None);
        let Err(LockError::Held { by: LockKeeper::Run(holder), .. }) = take() else { panic!("taken twice") };
        assert_eq!(holder.pid, std::process::id());
        assert_eq!(lock_state(&folder, "lock").expect("readable"), LockState::Held(LockKeeper::Run(holder)));
        assert_eq!(mark(&folder, "lock"), Mark::Run);
        drop(first);
        assert_eq!(lock_state(&folder, "lock").expect("readable"), LockState::Free);
        assert_eq!(mark(&folder, "lock"), Mark::Run, "it remains the directory of a run");
        assert_eq!(take().expect("free again").left_by(), None);
    }

    #[test]
    fn whoever_keeps_a_lock_is_named_and_nobody_else() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let folder = Folder::open(directory.path()).expect("opened");
        let here = host().expect("a name");
        // Left by a killed run: its process number is free or another process's.
        let left_by = |host: &str| {
            let text = json!({ "program": PROGRAM, "pid": 1, "host": host, "started": "2026" });
            std::fs::write(directory.path().join("lock"), text.to_string()).expect("written");
        };
        left_by(&here);
        let stranger = folder.place("lock").open_or_create().expect("there");
        assert!(matches!(lock_state(&folder, "lock").expect("readable"), LockState::Abandoned(_)), "nobody has it");
        for is_shared in [false, true] {
            if is_shared { stranger.lock_shared() } else { stranger.lock() }.expect("free");
            let Err(error @ LockError::Held { .. }) = Lock::take(&folder, "lock") else { panic!("it is held") };
            let words = error.to_string();
            let own = format!("process {} (", std::process::id());
            assert!(words.contains("another process holds the lock") && words.contains(&own), "{words}");
            stranger.unlock().expect("held");
        }
        stranger.lock().expect("free");
        let looked = lock_state(&folder, "lock").expect("readable");
        assert!(
            matches!(&looked, LockState::Held(LockKeeper::Process(found)) if found.pid == std::process::id()),
            "{looked:?}"
        );
        // A holder on another host could be in a container: this system sees the process itself.
        left_by("elsewhere");
        assert!(matches!(lock_state(&folder, "lock").expect("readable"), LockState::Held(LockKeeper::Process(_))));
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
