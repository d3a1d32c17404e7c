//! One orchestrator per result directory.
//!
//! The lock is the operating system's on an open file (`flock`), held as long as the process lives: the kernel releases it
//! however the process ends, and a stopped process keeps it. What the file says is only for messages. An orderly end
//! empties the file, so that one with a holder and no lock tells of a run that was killed.

use crate::files::FileError;
use crate::run::manifest::{host, timestamp};
use bladeoff_core::document::visible;
use serde_json::{Value, json};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, SystemTime};

/// How long a lock is tried for: whoever only looks at it (`bladeoff status`) holds it for microseconds.
const PATIENCE: Duration = Duration::from_millis(500);
const STEP: Duration = Duration::from_millis(20);

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
    #[error("another run works in {}: {}", directory.display(), holder.as_ref().map_or("unknown".to_owned(), ToString::to_string))]
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
    pub fn take(directory: &Path, name: &str) -> Result<Self, LockError> {
        let path = directory.join(name);
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(FileError::at("create", &path))?;
        let mut waited = Duration::ZERO;
        loop {
            match file.try_lock() {
                Ok(()) => break,
                Err(TryLockError::WouldBlock) if waited < PATIENCE => {
                    thread::sleep(STEP);
                    waited += STEP;
                }
                Err(TryLockError::WouldBlock) => {
                    return Err(LockError::Held { directory: directory.to_path_buf(), holder: read(&mut file) });
                }
                Err(TryLockError::Error(source)) => return Err(FileError::at("lock", &path)(source).into()),
            }
        }
        let left_by = read(&mut file);
        let text = json!({
            "pid": std::process::id(),
            "host": host(),
            "started": timestamp(SystemTime::now()),
        });
        let write = |file: &mut File| {
            file.set_len(0)?;
            file.rewind()?;
            writeln!(file, "{text}")
        };
        write(&mut file).map_err(FileError::at("write", &path))?;
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
        let _ = self.file.set_len(0);
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
pub fn look(directory: &Path, name: &str) -> Result<Look, FileError> {
    let path = directory.join(name);
    let mut file = match File::open(&path) {
        Ok(file) => file,
        Err(source) if source.kind() == std::io::ErrorKind::NotFound => return Ok(Look::Free),
        Err(source) => return Err(FileError::at("read", &path)(source)),
    };
    match file.try_lock_shared() {
        Ok(()) => Ok(read(&mut file).map_or(Look::Free, Look::Abandoned)),
        Err(TryLockError::WouldBlock) => Ok(Look::Held(read(&mut file))),
        Err(TryLockError::Error(source)) => Err(FileError::at("lock", &path)(source)),
    }
}

fn read(file: &mut File) -> Option<Holder> {
    let mut text = String::new();
    file.rewind().and_then(|()| file.take(4096).read_to_string(&mut text)).ok()?;
    let value: Value = serde_json::from_str(&text).ok()?;
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
        let take = || Lock::take(directory.path(), "lock");
        assert_eq!(look(directory.path(), "lock").expect("readable"), Look::Free);
        let first = take().expect("free");
        assert_eq!(first.left_by(), None);
        let Err(LockError::Held { holder: Some(holder), .. }) = take() else { panic!("taken twice") };
        assert_eq!(holder.pid, std::process::id());
        assert_eq!(look(directory.path(), "lock").expect("readable"), Look::Held(Some(holder)));
        drop(first);
        assert_eq!(look(directory.path(), "lock").expect("readable"), Look::Free);
        assert_eq!(take().expect("free again").left_by(), None);
    }
}
