//! Holder of a kernel lock (`flock`), from `/proc/locks`, which every user may read.
//!
//! Holders on other hosts of a shared file system are not listed, nor those in containers that this one cannot see. Some file systems have
//! another device number in `/proc/locks` than in `stat`. Then only the expected process counts, if it holds a lock on a file with the same inode.

use crate::place::Identity;
use bladeoff_text::document::visible;
use rustix::fs::{major, minor};
use std::fmt;
use std::fs;
use std::io;
use std::os::unix::fs::MetadataExt;

/// A living process that holds a lock.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LockHolder {
    /// Process id.
    pub pid: u32,
    /// User id of the process.
    pub user: u32,
    /// Name of its program, if it can be read.
    pub program: Option<String>,
    /// Process id inside its container, if the process runs in one.
    pub inner: Option<u32>,
}

impl LockHolder {
    /// Whether the process calls itself `pid`. `is_here`: `pid` was recorded on this system, not inside a container.
    #[must_use]
    pub fn is_process(&self, pid: u32, is_here: bool) -> bool {
        is_here && self.pid == pid || self.inner == Some(pid)
    }
}

impl fmt::Display for LockHolder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "process {}", self.pid)?;
        if let Some(program) = &self.program {
            write!(f, " ({})", visible(program))?;
        }
        write!(f, " of user {}", self.user)
    }
}

/// The living process that holds a lock on a file; `None` if none is listed. Where several hold it, `expected` is preferred.
///
/// # Errors
/// `/proc/locks` cannot be read.
pub fn holder(file: Identity, expected: Option<u32>) -> io::Result<Option<LockHolder>> {
    let told = fs::read_to_string("/proc/locks")?;
    Ok(pids(&told, file, expected).into_iter().find_map(living))
}

/// Ids of the processes that hold a lock on the file according to `told`, the expected one first.
fn pids(told: &str, (device, number): Identity, expected: Option<u32>) -> Vec<u32> {
    let mut found = Vec::new();
    for line in told.lines() {
        // 1: FLOCK  ADVISORY  WRITE 3044 fe:00:10158374 0 EOF; a waiting process has -> behind the number.
        let words: Vec<&str> = line.split_whitespace().collect();
        let [_, "FLOCK", _, _, pid, place, ..] = words[..] else { continue };
        let Ok(pid) = pid.parse::<u32>() else { continue };
        let mut parts = place.split(':');
        let mut hex = || u32::from_str_radix(parts.next()?, 16).ok();
        let its_device = hex().zip(hex());
        if parts.next().and_then(|part| part.parse().ok()) != Some(number) {
            continue;
        }
        if its_device == Some((major(device), minor(device))) || Some(pid) == expected {
            found.push(pid);
        }
    }
    found.sort_by_key(|pid| Some(*pid) != expected);
    found
}

fn living(pid: u32) -> Option<LockHolder> {
    let user = fs::metadata(format!("/proc/{pid}")).ok()?.uid();
    let program = fs::read_to_string(format!("/proc/{pid}/comm")).ok().map(|name| name.trim_end().to_owned());
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    // Ids of the process, from this namespace inwards.
    let numbers = status.lines().find_map(|line| line.strip_prefix("NSpid:")).unwrap_or_default();
    let inner = numbers.split_whitespace().skip(1).last().and_then(|number| number.parse().ok());
    Some(LockHolder { pid, user, program, inner })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::Folder;

    #[test]
    fn locks_are_found_by_device_and_number() {
        let told = "1: FLOCK  ADVISORY  WRITE 11 fe:00:77 0 EOF\n1: -> FLOCK  ADVISORY  WRITE 12 fe:00:77 0 EOF\n\
                    2: POSIX  ADVISORY  WRITE 13 fe:00:77 0 EOF\n3: FLOCK  ADVISORY  READ 14 fe:00:78 0 EOF\n\
                    4: OFDLCK ADVISORY  WRITE -1 fe:00:77 0 EOF\n5: FLOCK  ADVISORY  READ 15 00:1b:77 0 EOF\n\
                    6: FLOCK  ADVISORY  READ 16 fe:00:77 0 EOF\n";
        let here = (rustix::fs::makedev(0xfe, 0), 77);
        assert_eq!(pids(told, here, None), [11, 16]);
        assert_eq!(pids(told, here, Some(16)), [16, 11]);
        assert_eq!(pids(told, here, Some(15)), [15, 11, 16], "another number of its device");
        assert_eq!(pids(told, (0, 77), None), [0; 0]);
    }

    #[test]
    fn this_process_is_found_while_it_holds_a_lock() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let place = Folder::open(directory.path()).expect("opened").place("lock");
        let file = place.open_or_create().expect("made");
        let of_file = || {
            let identity = place.identity().expect("known").expect("there");
            holder(identity, None).expect("Linux tells")
        };
        assert_eq!(of_file(), None);
        file.lock().expect("free");
        let found = of_file().expect("held");
        assert_eq!(found.pid, std::process::id());
        assert!(found.is_process(found.pid, true) && !found.is_process(found.pid, false) && !found.is_process(1, true));
        assert!(found.to_string().starts_with(&format!("process {} (", found.pid)), "{found}");
    }
}
