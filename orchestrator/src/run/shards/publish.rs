//! A file that is there once, whole, by whoever comes first: written under a name of its own, synced, given its name by `link(2)`.
//!
//! A name is taken by one link at most, on local and on network file systems alike; no lock is needed. A network file system may send the
//! request twice and answer that the name is taken by what it has just linked itself: how many names the file has decides, and which file
//! has the name, not the answer.

use bladeoff_system::files::{FileError, create_beside};
use bladeoff_system::folder::Folder;
use bladeoff_system::place::Place;
use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::MetadataExt;

/// Whose file has the name now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Put {
    /// Ours.
    Won,
    /// Somebody else's, who was first: ours is dropped.
    Lost,
}

/// Puts a file into a folder unless something has its name; durable when this returns, whosever it is.
///
/// # Errors
/// The file system refused; nothing has the name then, or what has it cannot be looked at.
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
    let (mut file, aside) = create_beside(&place, Place::create_new)?;
    let aside = Aside(aside);
    file.write_all(bytes).and_then(|()| file.sync_all()).map_err(FileError::at("write", &place))?;
    let put = match link(&aside.0, &place) {
        Ok(()) => Put::Won,
        Err(error) => match has_the_name(&file, &place) {
            Ok(Some(put)) => put,
            Ok(None) | Err(_) => return Err(FileError::at("publish", &place)(error)),
        },
    };
    drop(aside);
    // Also of another's: who leaves his own work for it has to be sure of it.
    folder.sync()?;
    Ok(put)
}

/// Whose file has a name, after a link that was answered by an error; `None`: nobody's.
fn has_the_name(own: &File, place: &Place) -> io::Result<Option<Put>> {
    let own = own.metadata()?;
    // Its name aside and this one: nobody else links it.
    if own.nlink() > 1 {
        return Ok(Some(Put::Won));
    }
    // A name may be seen before the count is.
    Ok(place.identity()?.map(|found| if found == (own.dev(), own.ino()) { Put::Won } else { Put::Lost }))
}

/// The name that a file has first, removed in the end.
struct Aside(Place);

impl Drop for Aside {
    fn drop(&mut self) {
        // A leftover is in nobody's way.
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
        // It did not happen: somebody else has the name, or nobody.
        let refuses = |_: &Place, _: &Place| Err(ErrorKind::AlreadyExists.into());
        assert_eq!(put_once_by(&folder, "a", b"later", refuses).expect("theirs"), Put::Lost);
        assert_eq!(fs::read(directory.path().join("a")).expect("there"), b"ours");
        let refuses = |_: &Place, _: &Place| Err(ErrorKind::TimedOut.into());
        let error = put_once_by(&folder, "c", b"never", refuses).expect_err("not there");
        assert_eq!(error.source.kind(), ErrorKind::TimedOut);
        assert_eq!(fs::read_dir(directory.path()).expect("listed").count(), 2);
    }
}
