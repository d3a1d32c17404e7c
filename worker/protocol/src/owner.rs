//! The owner's file in /dev/shm, which shows whether the memory of a run is in use.
//!
//! `bladeoff_ID_owner` is created first of all files of a domain, locked by its orchestrator as long as that lives, and removed last. The
//! lock belongs to the kernel and lies beside the memory. So every process that sees the memory sees the lock, even from a container with
//! another /tmp or other process numbers, and can distinguish memory of a dead run from that of a run in progress. Memory whose root is
//! gone is removed by the next run that has its roots in the same place, or by any run when that place is gone. Memory without an owner's
//! file is left alone.
//!
//! Every user may create files in /dev/shm under any name: only regular files of this user are read, and opening never blocks.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use rustix::fs::FlockOperation;

use crate::domain_error::Left;
use crate::names::{Address, PRODUCT, SHM, is_id, prefix_of};
use crate::shm;
use bladeoff_system::files::FileError;

const NAME: &str = "owner";
/// Separator before the path of the root in the file's text.
const BEFORE_ROOT: &str = ", files in ";
/// Longest text that is read \[bytes\]; a root has at most 65.
const LONGEST: u64 = 4096;

fn path_of(prefix: &str) -> PathBuf {
    Path::new(SHM).join(format!("{prefix}{NAME}"))
}

/// Id of the run, from the name of its owner's file.
fn id_of(name: &str) -> Option<&str> {
    let id = name.strip_suffix(NAME)?.strip_suffix('_')?.strip_prefix(PRODUCT)?.strip_prefix('_')?;
    is_id(id).then_some(id)
}

/// Creates and locks the file; the domain belongs to this process until the result is dropped. `None`: the name is taken, or another process
/// holds the lock.
///
/// # Errors
/// The system refused; no file is left behind.
pub(crate) fn claim(address: &Address) -> Result<Option<File>, FileError> {
    let path = path_of(&address.prefix);
    let text = format!("process {}{BEFORE_ROOT}{}\n", std::process::id(), address.root.display());
    let mut file = match OpenOptions::new().write(true).create_new(true).mode(0o600).open(&path) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => return Ok(None),
        made => made.map_err(FileError::at("create", &path))?,
    };
    // A sweep does not touch an empty file.
    let is_locked = rustix::fs::flock(&file, FlockOperation::NonBlockingLockExclusive).is_ok();
    let written = if is_locked { file.write_all(text.as_bytes()) } else { Ok(()) };
    if !is_locked || written.is_err() {
        let _ = fs::remove_file(&path);
    }
    written.map_err(FileError::at("write", &path))?;
    Ok(is_locked.then_some(file))
}

/// Removes the files of a domain in /dev/shm, the owner's file last, and returns the files that are left. A file that cannot be removed does
/// not keep the others.
pub(crate) fn remove(prefix: &str) -> Vec<Left> {
    let owner = path_of(prefix);
    let all = match shm::files(prefix) {
        Ok(all) => all.map(|entry| entry.path()),
        Err(error) => return vec![FileError::at("read", Path::new(SHM))(error).into()],
    };
    let others = all.filter(|path| *path != owner).collect::<Vec<_>>();
    others.iter().chain([&owner]).filter_map(|path| remove_one(path)).collect()
}

fn remove_one(path: &Path) -> Option<Left> {
    match shm::owner_of(path) {
        Ok(None) => None,
        Ok(Some(owner)) if !shm::is_own(owner) => Some(Left::Foreign { path: path.to_owned(), owner }),
        _ => match fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Some(FileError::at("remove", path)(error).into()),
            _ => None,
        },
    }
}

/// Removes the memory of dead runs of this user whose root is gone, if that root was in one of `bases` or in a directory that no longer
/// exists. Files that cannot be removed are left for the next sweep.
pub(crate) fn sweep(bases: &[&Path]) {
    for entry in fs::read_dir(SHM).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let Some(id) = name.to_str().and_then(id_of) else { continue };
        let Ok(Some(mut file)) = shm::open_own(&entry.path(), shm::Access::Read) else { continue };
        // An empty file is not claimed yet.
        let Some(root) = root_in(&mut file) else { continue };
        let Some(base) = root.parent() else { continue };
        let is_ours = bases.contains(&base) || !base.exists();
        if is_ours && !root.exists() && rustix::fs::flock(&file, FlockOperation::NonBlockingLockExclusive).is_ok() {
            remove(&prefix_of(id));
        }
    }
}

/// Path of the root in the text of an owner's file.
fn root_in(file: &mut File) -> Option<PathBuf> {
    let mut text = String::new();
    file.take(LONGEST).read_to_string(&mut text).ok()?;
    let (_, root) = text.strip_suffix('\n')?.split_once(BEFORE_ROOT)?;
    Some(PathBuf::from(root)).filter(|root| root.is_absolute())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::time::{Duration, Instant};

    /// Waits until a condition holds. The tests of this program run in parallel: one may sweep the files of another and hold its lock for that
    /// moment, and a starting child process holds copies of all locks until it executes its program.
    pub(crate) fn within_moments(mut is_so: impl FnMut() -> bool) -> bool {
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_secs(60) {
            if is_so() {
                return true;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        false
    }

    fn address(id: &str, base: &Path) -> Address {
        Address { root: base.join(id), prefix: prefix_of(id) }
    }

    #[test]
    fn memory_without_a_root_goes_when_its_owner_is_dead_and_not_before() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let base = dir.path();
        let address = address("00000000b1", base);
        let memory = Path::new(SHM).join(format!("{}memory", address.prefix));
        let claimed = claim(&address).expect("claimed").expect("free");
        fs::write(&memory, b"x").expect("written");
        sweep(&[base]);
        assert!(memory.exists() && path_of(&address.prefix).exists(), "of a living owner");
        drop(claimed);
        fs::create_dir(&address.root).expect("created");
        sweep(&[base]);
        assert!(memory.exists(), "as long as there is a root, it decides");
        fs::remove_dir(&address.root).expect("removed");
        sweep(&[Path::new("/tmp")]);
        assert!(memory.exists(), "of a place that is there and not ours");
        let is_gone = || {
            sweep(&[base]);
            !memory.exists() && !path_of(&address.prefix).exists()
        };
        assert!(within_moments(is_gone));
    }

    #[test]
    fn memory_whose_place_is_gone_is_removed_by_anybody() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let address = address("00000000b4", dir.path());
        drop(claim(&address).expect("claimed").expect("free"));
        drop(dir);
        let is_gone = || {
            sweep(&[]);
            !path_of(&address.prefix).exists()
        };
        assert!(within_moments(is_gone));
    }

    #[test]
    fn memory_of_which_nothing_is_known_is_left_alone() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let [nobody, unclaimed] = ["00000000b2", "00000000b3"].map(|id| address(id, dir.path()));
        let memory = Path::new(SHM).join(format!("{}memory", nobody.prefix));
        fs::write(&memory, b"x").expect("written");
        // State between creation and lock.
        fs::write(path_of(&unclaimed.prefix), b"").expect("written");
        sweep(&[dir.path()]);
        assert!(memory.exists() && path_of(&unclaimed.prefix).exists());
        assert!(claim(&unclaimed).expect("no error").is_none(), "the name is taken");
        let left: usize = [nobody, unclaimed].iter().map(|address| remove(&address.prefix).len()).sum();
        assert!(left == 0 && !memory.exists() && !path_of("bladeoff_00000000b3_").exists());
    }

    #[test]
    fn nothing_else_with_an_owners_name_is_waited_for_or_believed() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let path = |id: &str| path_of(&prefix_of(id));
        let [pipe, link, huge] = ["00000000b5", "00000000b6", "00000000b7"].map(path);
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, 0o666.into(), 0).expect("a FIFO");
        std::os::unix::fs::symlink("/proc/self/mem", &link).expect("linked");
        File::create(&huge).and_then(|file| file.set_len(1 << 40)).expect("sparse");
        // Opening the FIFO for reading would block this thread for ever.
        let (done, is_done) = std::sync::mpsc::channel();
        let base = dir.path().to_owned();
        std::thread::spawn(move || {
            sweep(&[&base]);
            let _ = done.send(());
        });
        let waited = is_done.recv_timeout(std::time::Duration::from_secs(60));
        // Releases a sweep that is blocked by the FIFO, so that a failing test ends.
        drop(OpenOptions::new().read(true).write(true).open(&pipe));
        let are_there = [&pipe, &link, &huge].map(|path| fs::symlink_metadata(path).is_ok());
        [pipe, link, huge].iter().for_each(|path| fs::remove_file(path).expect("removed"));
        assert!(waited.is_ok(), "the sweep does not end");
        assert_eq!(are_there, [true; 3]);
    }

    #[test]
    fn what_cannot_be_removed_keeps_nothing_else() {
        let prefix = prefix_of("00000000b8");
        let path = |name: &str| Path::new(SHM).join(format!("{prefix}{name}"));
        // Names that a directory listing returns before and after the owner's file.
        let names = ["a", "b", "c", "d", "e", "f"].map(path);
        names.iter().for_each(|path| fs::write(path, b"x").expect("written"));
        let stays = path("c2");
        fs::create_dir(&stays).expect("created");
        let left = remove(&prefix);
        let others = names.iter().filter(|path| path.exists()).count();
        fs::remove_dir(&stays).expect("removed");
        assert!(matches!(&left[..], [Left::File(error)] if error.path == stays), "{left:?}");
        assert_eq!(others, 0);
    }
}
