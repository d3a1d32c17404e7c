//! The file in /dev/shm that says whether the memory beside it is anybody's.
//!
//! `bladeoff_ID_owner` is made before anything else of a domain, locked by its orchestrator as long as it lives, and removed
//! last. The lock is the kernel's and lies where the memory lies: it is seen by all who see the memory, also from a container with
//! another /tmp or other process numbers. So memory whose root in /tmp is gone can be told from that of a run under way, and is
//! removed by the next run; memory without such a file is left alone.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, OFlags};

use crate::domain::{Address, PRODUCT, is_id, prefix_of};
use crate::files::FileError;
use crate::shm::{self, SHM};

const NAME: &str = "owner";

fn path_of(prefix: &str) -> PathBuf {
    Path::new(SHM).join(format!("{prefix}{NAME}"))
}

/// The run whose owner's file has this name.
fn id_of(name: &str) -> Option<&str> {
    let id = name.strip_suffix(NAME)?.strip_suffix('_')?.strip_prefix(PRODUCT)?.strip_prefix('_')?;
    is_id(id).then_some(id)
}

/// Makes the file; the domain is this process's as long as the result lives.
///
/// # Errors
/// What the system refused; nothing is left behind.
pub(crate) fn claim(address: &Address) -> Result<File, FileError> {
    let path = path_of(&address.prefix);
    let text = format!("process {}, files in {}\n", std::process::id(), address.root.display());
    let mut file = OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(0o600)
        .open(&path)
        .map_err(FileError::at("create", &path))?;
    // While it is empty, it is nobody's to remove: a sweep that has it locked lets it go at once, and is waited for.
    let claimed = rustix::fs::flock(&file, FlockOperation::LockExclusive).map_err(io::Error::from);
    claimed.and_then(|()| file.write_all(text.as_bytes())).map_err(|source| {
        let _ = fs::remove_file(&path);
        FileError::at("lock", &path)(source)
    })?;
    Ok(file)
}

/// Removes the files of a domain in /dev/shm, this one last.
///
/// # Errors
/// What could not be removed.
pub(crate) fn remove(prefix: &str) -> Result<(), FileError> {
    let owner = path_of(prefix);
    let all = shm::files(prefix).map_err(FileError::at("read", Path::new(SHM)))?.map(|entry| entry.path());
    let others = all.filter(|path| *path != owner).collect::<Vec<_>>();
    for path in others.iter().chain([&owner]) {
        match fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(FileError::at("remove", path)(error)),
            _ => {}
        }
    }
    Ok(())
}

/// Removes the memory of dead runs of this user whose root below `base` is gone. What fails is left for the next time.
pub(crate) fn sweep(base: &Path) {
    let uid = rustix::process::getuid().as_raw();
    for entry in fs::read_dir(SHM).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let Some(id) = name.to_str().and_then(id_of).filter(|id| !base.join(id).exists()) else { continue };
        let Ok(file) = OpenOptions::new().read(true).custom_flags(OFlags::NOFOLLOW.bits() as i32).open(entry.path())
        else {
            continue;
        };
        let is_claimed = file.metadata().is_ok_and(|found| found.is_file() && found.uid() == uid && found.len() > 0);
        if is_claimed && rustix::fs::flock(&file, FlockOperation::NonBlockingLockExclusive).is_ok() {
            let _ = remove(&prefix_of(id));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(id: &str, base: &Path) -> Address {
        Address { root: base.join(id), prefix: prefix_of(id) }
    }

    #[test]
    fn memory_without_a_root_goes_when_its_owner_is_dead_and_not_before() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let address = address("00000000b1", dir.path());
        let memory = Path::new(SHM).join(format!("{}memory", address.prefix));
        let claimed = claim(&address).expect("claimed");
        fs::write(&memory, b"x").expect("written");
        sweep(dir.path());
        assert!(memory.exists() && path_of(&address.prefix).exists(), "of a living owner");
        drop(claimed);
        fs::create_dir(&address.root).expect("created");
        sweep(dir.path());
        assert!(memory.exists(), "as long as there is a root, it decides");
        fs::remove_dir(&address.root).expect("removed");
        sweep(dir.path());
        assert!(!memory.exists() && !path_of(&address.prefix).exists());
    }

    #[test]
    fn memory_of_which_nothing_is_known_is_left_alone() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let [nobody, unclaimed] = ["00000000b2", "00000000b3"].map(|id| address(id, dir.path()));
        let memory = Path::new(SHM).join(format!("{}memory", nobody.prefix));
        fs::write(&memory, b"x").expect("written");
        // Between its making and its lock.
        fs::write(path_of(&unclaimed.prefix), b"").expect("written");
        sweep(dir.path());
        assert!(memory.exists() && path_of(&unclaimed.prefix).exists());
        [nobody, unclaimed].iter().for_each(|address| remove(&address.prefix).expect("removed"));
        assert!(!memory.exists() && !path_of("bladeoff_00000000b3_").exists());
    }
}
