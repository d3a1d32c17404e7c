//! Publishes a file exactly once: it is written under a temporary name, synced, and linked to its name by `link(2)`. The first process wins; the file is
//! complete or absent.
//!
//! At most one link to a name succeeds, on local and on network file systems, so no lock is needed. A network file system may send the request twice and then
//! report that the name exists, although its own first request made it. So the link count of the file and the inode behind the name decide, not the return code.

use bladeoff_system::files::{FileError, create_beside};
use bladeoff_system::folder::Folder;
use bladeoff_system::place::Place;
use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::MetadataExt;

/// Owner of the published file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Put {
    /// Ours.
    Won,
    /// Another process published first; our copy is removed.
    Lost,
}

/// Publishes a file in a folder unless the name exists. The published file, ours or another's, is durable when this returns.
///
/// # Errors
/// The file system rejected the operation; the name then does not exist, or its file cannot be examined.
pub(super) fn put_once(folder: &Folder, name: &str, bytes: &[u8]) -> Result<Put, FileError> {
    put_once_by(folder, name, bytes, Place::link_to)
}

fn put_once_by(
    folder: &Folder,
    name: &str,
    bytes: &[u8],
    link: impl FnOnce(&Place, &Place) -> io::Result<()>,
) -> Result<Put, FileError> {
    let place = folder.place(name);
    let (mut file, temporary) = create_beside(&place, Place::create_new)?;
    let name = TemporaryName(temporary);
    file.write_all(bytes).and_then(|()| file.sync_all()).map_err(FileError::at("write", &place))?;
    let put = match link(&name.0, &place) {
        Ok(()) => Put::Won,
        Err(error) => match has_the_name(&file, &place) {
            Ok(Some(put)) => put,
            Ok(None) | Err(_) => return Err(FileError::at("publish", &place)(error)),
        },
    };
    drop(name);
    // Also if another process won: the caller discards its own copy.
    folder.sync()?;
    Ok(put)
}

/// Owner of the published file after `link` returned an error; `None`: the name does not exist.
fn has_the_name(own: &File, place: &Place) -> io::Result<Option<Put>> {
    let own = own.metadata()?;
    // The temporary name and this one: no other process links our file.
    if own.nlink() > 1 {
        return Ok(Some(Put::Won));
    }
    // The name may be visible before the link count is.
    Ok(place.identity()?.map(|found| if found == (own.dev(), own.ino()) { Put::Won } else { Put::Lost }))
}

/// Temporary name of a file; dropping it removes the name.
struct TemporaryName(Place);

impl Drop for TemporaryName {
    fn drop(&mut self) {
        // A leftover file has no effect.
        let _ = self.0.remove();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::io::ErrorKind;
    use std::thread;

    fn folder() -> (tempfile::TempDir, Folder) {
        let directory = tempfile::tempdir().expect("temporary directory");
        let folder = Folder::open(directory.path()).expect("opened");
        (directory, folder)
    }

    #[test]
    fn of_many_who_publish_at_once_one_wins_and_its_file_is_whole() {
        let (directory, folder) = folder();
        let put = |number: u8| put_once(&folder, "a", &vec![number; 10_000]).expect("writable");
        let wins: Vec<u8> = thread::scope(|scope| {
            let all: Vec<_> = (1..=16u8).map(|number| scope.spawn(move || (number, put(number)))).collect();
            let all = all.into_iter().map(|one| one.join().expect("no panic"));
            all.filter(|(_, put)| *put == Put::Won).map(|(number, _)| number).collect()
        });
        assert_eq!(wins.len(), 1);
        assert_eq!(fs::read(directory.path().join("a")).expect("there"), vec![wins[0]; 10_000]);
        assert_eq!(fs::read_dir(directory.path()).expect("listed").count(), 1, "nothing is left beside it");
    }

    #[test]
    fn an_answer_that_is_an_error_although_it_happened_is_a_win() {
        let (directory, folder) = folder();
        let lies = |kind: ErrorKind| {
            move |from: &Place, to: &Place| {
                from.link_to(to)?;
                Err(kind.into())
            }
        };
        for (name, kind) in [("a", ErrorKind::AlreadyExists), ("b", ErrorKind::TimedOut)] {
            assert_eq!(put_once_by(&folder, name, b"ours", lies(kind)).expect("it happened"), Put::Won);
        }
        // The link was not made: another file has the name, or none has.
        let refuses = |_: &Place, _: &Place| Err(ErrorKind::AlreadyExists.into());
        assert_eq!(put_once_by(&folder, "a", b"later", refuses).expect("theirs"), Put::Lost);
        assert_eq!(fs::read(directory.path().join("a")).expect("there"), b"ours");
        let refuses = |_: &Place, _: &Place| Err(ErrorKind::TimedOut.into());
        let error = put_once_by(&folder, "c", b"never", refuses).expect_err("not there");
        assert_eq!(error.source.kind(), ErrorKind::TimedOut);
        assert_eq!(fs::read_dir(directory.path()).expect("listed").count(), 2);
    }
}
