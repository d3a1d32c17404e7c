//! Check that no other user can change a result directory: in a directory that others own or may write, any name can be replaced
//! at any time.

use super::lock::LOCK;
use bladeoff_system::files::FileError;
use bladeoff_system::folder::Folder;
use bladeoff_system::shown;
use rustix::fs::{Access, AtFlags, accessat, fgetxattr};
use rustix::io::Errno;
use rustix::process::{getegid, geteuid};
use std::io;
use std::path::PathBuf;

/// Directory that other users can change.
#[derive(Debug, thiserror::Error)]
pub enum Untrusted {
    /// Another user owns it.
    #[error(
        "{} belongs to another user (uid {owner}), who could change what the run writes there; choose another --out, \
         or pass --trust-dir if you trust that user",
        shown(path)
    )]
    Owner {
        /// The directory.
        path: PathBuf,
        /// Owner.
        owner: u32,
    },
    /// Other users may write to it.
    #[error(
        "{} can be written by other users (mode {mode:04o}), who could change what the run writes there: `chmod go-w` it, choose \
         another --out, or pass --trust-dir if you trust them",
        shown(path)
    )]
    Mode {
        /// The directory.
        path: PathBuf,
        /// Permissions.
        mode: u32,
    },
}

/// Reason why a directory is rejected: other users may write to it, and `trusts` is not set. A group that only contains the user,
/// by its number, is no reason: many systems create directories in this way (umask 002). A directory of another user to which
/// nothing can be written gives this error as well; it can still be read.
pub(crate) fn check(folder: &Folder, trusts: bool) -> Result<Option<Untrusted>, FileError> {
    let path = || folder.path().to_path_buf();
    let found = folder.stat().map_err(FileError::at("read", folder.path()))?;
    let (user, group) = (geteuid().as_raw(), getegid().as_raw());
    if found.st_uid != user {
        accessat(folder, ".", Access::WRITE_OK, AtFlags::EACCESS)
            .map_err(|errno| FileError::at("create", &folder.place(LOCK))(io::Error::from(errno)))?;
    }
    if trusts {
        return Ok(None);
    }
    if found.st_uid != user {
        return Ok(Some(Untrusted::Owner { path: path(), owner: found.st_uid }));
    }
    // With an access control list, the group bits are the upper bound of all its entries.
    let is_private = found.st_gid == group && group == user && !has_list(folder);
    let others = if is_private { 0o002 } else { 0o022 };
    let mode = found.st_mode & 0o7777;
    Ok((mode & others != 0).then(|| Untrusted::Mode { path: path(), mode }))
}

/// Whether the directory has an access control list.
fn has_list(folder: &Folder) -> bool {
    let mut list = [0; 4096];
    let found = fgetxattr(folder, "system.posix_acl_access", &mut list[..]);
    matches!(found, Ok(1..) | Err(Errno::RANGE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_directory_that_others_may_write_in_is_refused_unless_they_are_trusted() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let check_with = |mode, trusts| {
            fs::set_permissions(directory.path(), fs::Permissions::from_mode(mode)).expect("own");
            check(&Folder::open(directory.path()).expect("opened"), trusts).expect("readable")
        };
        for mode in [0o700, 0o755, 0o750, 0o2755] {
            assert!(check_with(mode, false).is_none(), "{mode:o}");
        }
        for mode in [0o777, 0o1777, 0o702] {
            let refused = check_with(mode, false).expect("others may write");
            assert!(matches!(&refused, Untrusted::Mode { mode: found, .. } if *found == mode), "{refused}");
            assert!(check_with(mode, true).is_none());
        }
        let is_private = geteuid().as_raw() == getegid().as_raw();
        assert_eq!(check_with(0o775, false).is_none(), is_private, "a group of one");
    }

    #[test]
    fn who_is_named_in_an_access_control_list_may_write_whatever_the_group() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let folder = Folder::open(directory.path()).expect("opened");
        // user::rwx user:54321:rwx group::r-x mask::rwx other::r-x, as the kernel keeps it
        let owner = u32::MAX;
        let entries = [(1u16, 7u16, owner), (2, 7, 54_321), (4, 5, owner), (16, 7, owner), (32, 5, owner)];
        let mut list = 2u32.to_le_bytes().to_vec();
        for (tag, permissions, id) in entries {
            list.extend(tag.to_le_bytes());
            list.extend(permissions.to_le_bytes());
            list.extend(id.to_le_bytes());
        }
        let flags = rustix::fs::XattrFlags::empty();
        if rustix::fs::fsetxattr(&folder, "system.posix_acl_access", &list, flags).is_err() {
            println!("SKIPPED: no access control lists in {}", directory.path().display());
            return;
        }
        let refused = check(&folder, false).expect("readable").expect("somebody else may write");
        assert!(matches!(refused, Untrusted::Mode { .. }), "{refused}");
        assert!(check(&folder, true).expect("readable").is_none());
    }
}
