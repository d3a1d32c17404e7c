//! One orchestrator per result directory.
//!
//! The lock is the operating system's on an open file (`flock`), held as long as the process lives: the kernel releases it
//! however the process ends, and a stopped process keeps it. An orderly end takes the holder out of the file, so that one
//! with a holder and no lock tells of a run that was killed. The file is written before anything else in the directory, each
//! time at once and over what was there: what it says tells a directory that a run began from one of somebody else.

use super::stamp::{host, timestamp};
use bladeoff_model::document::visible;
use bladeoff_system::files::FileError;
use bladeoff_system::folder::Folder;
use bladeoff_system::shown;
use serde_json::{Value, json};
use std::fs::{File, TryLockError};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::PathBuf;
use std::thread;
use std::time::{Duration, SystemTime};

/// Who works in the directory.
pub const LOCK: &str = "run.lock";

/// How long a lock is tried for: whoever only looks at it (`bladeoff status`) holds it for microseconds.
const PATIENCE: Duration = Duration::from_millis(500);
const STEP: Duration = Duration::from_millis(20);
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

/// Why a directory is not ours.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another process has it.
    #[error("another run works in {}: {}", shown(directory), holder.as_ref().map_or("unknown".to_owned(), ToString::to_string))]
    Held {
        /// The directory.
        directory: PathBuf,
        /// Who has it; unknown in the moment in which it takes it.
        holder: Option<Holder>,
    },
    /// The lock file.
    #[error(transparent)]
    File(#[from] FileError),
}

/// A lock that is held.
#[derive(Debug)]
pub struct Lock {
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
        let file = path.open_or_create()?;
        let mut waited = Duration::ZERO;
        loop {
            match file.try_lock() {
                Ok(()) => break,
                Err(TryLockError::WouldBlock) if waited < PATIENCE => {
                    thread::sleep(STEP);
                    waited += STEP;
                }
                Err(TryLockError::WouldBlock) => {
                    return Err(LockError::Held { directory: directory.path().to_path_buf(), holder: holder(&file) });
                }
                Err(TryLockError::Error(source)) => return Err(FileError::at("lock", &path)(source).into()),
            }
        }
        let left_by = holder(&file);
        let text = json!({
            "program": PROGRAM,
            "pid": std::process::id(),
            "host": host(),
            "started": timestamp(SystemTime::now()),
        });
        // Durable before anything that is written after it.
        let written = write(&file, &text).and_then(|()| file.sync_all());
        written.map_err(FileError::at("write", &path))?;
        directory.sync()?;
        Ok(Self { file, left_by })
    }

    /// Who held it before and did not end in order.
    #[must_use]
    pub fn left_by(&self) -> Option<&Holder> {
        self.left_by.as_ref()
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Best effort: at worst the next run says that this one did not end in order.
        let _ = write(&self.file, &json!({ "program": PROGRAM }));
    }
}

/// What a look at a lock tells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Look {
    /// A living (or stopped) process has it.
    Held(Option<Holder>),
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
        Err(error) => return Err(error),
    };
    match file.try_lock_shared() {
        Ok(()) => Ok(holder(&file).map_or(Look::Free, Look::Abandoned)),
        Err(TryLockError::WouldBlock) => Ok(Look::Held(holder(&file))),
        Err(TryLockError::Error(source)) => Err(FileError::at("lock", &path)(source)),
    }
}

/// What the lock says of a directory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    /// A run began it.
    Run,
    /// Nothing: its file is empty.
    Empty,
    /// There is none, or it is another program's.
    None,
}

/// Whether a run began a directory, by the file of its lock.
pub(super) fn mark(directory: &Folder, name: &str) -> Mark {
    let Ok(file) = directory.place(name).open() else { return Mark::None };
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
        let Err(LockError::Held { holder: Some(holder), .. }) = take() else { panic!("taken twice") };
        assert_eq!(holder.pid, std::process::id());
        assert_eq!(look(&folder, "lock").expect("readable"), Look::Held(Some(holder)));
        assert_eq!(mark(&folder, "lock"), Mark::Run);
        drop(first);
        assert_eq!(look(&folder, "lock").expect("readable"), Look::Free);
        assert_eq!(mark(&folder, "lock"), Mark::Run, "it remains the directory of a run");
        assert_eq!(take().expect("free again").left_by(), None);
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
