//! Files that are either whole or absent: written aside, synced, renamed, the directory synced.
//!
//! The temporary name is unguessable and free: `NAME.0123abcd.tmp`. So no existing file is overwritten or removed.

use std::ffi::OsStr;
use std::fs::File;
use std::hash::{BuildHasher, RandomState};
use std::io::{self, Write};
use std::path::Path;

pub use crate::error::{FileError, sync_parent};
use crate::place::Place;

/// Temporary names that are tried. Each is one of 2^32, so a second try is hardly ever needed.
const MOST_NAMES: u32 = 16;
/// End of the name of an unfinished file.
const TEMPORARY: &str = ".tmp";

/// A file under construction, beside its final place. Dropping the value without finishing removes the file.
#[derive(Debug)]
pub struct Pending {
    file: Option<File>,
    temporary: Place,
    path: Place,
}

impl Pending {
    /// Starts a file that is later renamed to `path`.
    ///
    /// # Errors
    /// The directory cannot be written; a device or a pipe has the name.
    pub fn create(path: impl Into<Place>) -> Result<Self, FileError> {
        let path = path.into();
        path.may_be_replaced()?;
        let (file, temporary) = create_beside(&path, Place::create_new)?;
        Ok(Self { file: Some(file), temporary, path })
    }

    /// Starts a file that is later renamed to `path`, with a temporary name beside another place of the same file system.
    ///
    /// # Errors
    /// The directory of that place cannot be written.
    pub fn create_at(path: impl Into<Place>, beside: &Place) -> Result<Self, FileError> {
        let (file, temporary) = create_beside(beside, Place::create_new)?;
        Ok(Self { file: Some(file), temporary, path: path.into() })
    }

    /// The file to write to.
    pub fn file(&mut self) -> &mut File {
        self.file.as_mut().expect("present until finish consumes self")
    }

    /// Final name of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Name of the file until it is finished.
    #[must_use]
    pub fn temporary(&self) -> &Path {
        &self.temporary
    }

    /// Syncs the file and renames it to its final name, durably.
    ///
    /// # Errors
    /// Disk full, or the rename or sync failed; no file has the final name then.
    pub fn finish(self) -> Result<(), FileError> {
        self.finish_by(Place::rename_to)
    }

    /// Finishes the file like [`Pending::finish`], but never replaces a file that has the final name by then.
    ///
    /// # Errors
    /// As [`Pending::finish`]; a file has the final name.
    pub fn finish_new(self) -> Result<(), FileError> {
        self.finish_by(Place::rename_to_free)
    }

    fn finish_by(mut self, rename: fn(&Place, &Place) -> io::Result<()>) -> Result<(), FileError> {
        let file = self.file.take().expect("present until finish consumes self");
        file.sync_all().map_err(FileError::at("write", &self.path))?;
        drop(file);
        rename(&self.temporary, &self.path).map_err(FileError::at("rename to", &self.path))?;
        self.path.sync_parent()
    }

    /// Renames the file to its final name without a sync: after a power cut, the previous file or no file may be there.
    ///
    /// # Errors
    /// The rename failed.
    pub fn put_in_place(mut self) -> Result<(), FileError> {
        self.file = None;
        self.temporary.rename_to(&self.path).map_err(FileError::at("rename to", &self.path))
    }
}

impl Drop for Pending {
    fn drop(&mut self) {
        // After `finish` the temporary name no longer exists; on the error path the leftover is of no use.
        let _ = self.temporary.remove();
    }
}

/// Creates a file beside `path` with the given function of [`Place`], under a free temporary name; returns the file and its place.
///
/// # Errors
/// The directory cannot be written.
pub fn create_beside(path: &Place, create: fn(&Place) -> Result<File, FileError>) -> Result<(File, Place), FileError> {
    let mut last = io::ErrorKind::AlreadyExists.into();
    for _ in 0..MOST_NAMES {
        let temporary = path.with_suffix(&format!(".{}{TEMPORARY}", unguessable()));
        match create(&temporary) {
            Ok(file) => return Ok((file, temporary)),
            Err(error) if error.source.kind() == io::ErrorKind::AlreadyExists => last = error.source,
            Err(error) => return Err(FileError::at("create", path)(error.source)),
        }
    }
    Err(FileError::at("create", path)(last))
}

/// Eight hexadecimal digits that other users cannot predict.
#[must_use]
pub fn unguessable() -> String {
    // A keyed hash, the key being the system's random numbers.
    format!("{:08x}", RandomState::new().hash_one(std::process::id()) >> 32)
}

/// Whether `name` is a temporary name of the file `of`, as this build or an earlier one forms it.
#[must_use]
pub fn is_temporary(name: &OsStr, of: &str) -> bool {
    let rest = name.to_str().and_then(|name| name.strip_prefix(of)?.strip_suffix(TEMPORARY));
    let is_digits = |text: &str| text.len() == 8 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    rest.is_some_and(|rest| rest.is_empty() || rest.strip_prefix('.').is_some_and(is_digits))
}

/// Writes a whole file durably.
///
/// # Errors
/// As [`Pending::finish`].
pub fn write_whole(path: impl Into<Place>, bytes: &[u8]) -> Result<(), FileError> {
    written(path.into(), bytes)?.finish()
}

/// Writes a whole file durably, under a name that must be free.
///
/// # Errors
/// As [`Pending::finish_new`].
pub fn write_new(path: impl Into<Place>, bytes: &[u8]) -> Result<(), FileError> {
    written(path.into(), bytes)?.finish_new()
}

fn written(path: Place, bytes: &[u8]) -> Result<Pending, FileError> {
    let mut pending = Pending::create(&path)?;
    pending.file().write_all(bytes).map_err(FileError::at("write", &path))?;
    Ok(pending)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn an_unfinished_file_leaves_nothing() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let path = directory.path().join("a.txt");
        let mut pending = Pending::create(&path).expect("create");
        pending.file().write_all(b"half").expect("write");
        assert_eq!(fs::read_dir(directory.path()).expect("list").count(), 1);
        drop(pending);
        assert_eq!(fs::read_dir(directory.path()).expect("list").count(), 0);
        write_whole(&path, b"whole").expect("write");
        assert_eq!(fs::read(&path).expect("read"), b"whole");
        assert_eq!(fs::read_dir(directory.path()).expect("list").count(), 1);
    }

    #[test]
    fn what_stands_beside_a_file_is_no_matter_and_stays() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let path = directory.path().join("a.txt");
        fs::write(directory.path().join("a.txt.tmp"), b"mine").expect("written");
        let (first, second) = (Pending::create(&path).expect("create"), Pending::create(&path).expect("create"));
        let names: Vec<_> = fs::read_dir(directory.path()).expect("list").flatten().map(|e| e.file_name()).collect();
        assert_eq!(names.len(), 3, "{names:?}");
        assert!(names.iter().all(|name| is_temporary(name, "a.txt")), "{names:?}");
        first.finish().expect("free");
        let taken = second.finish_new().expect_err("it is there");
        assert_eq!(taken.source.kind(), io::ErrorKind::AlreadyExists);
        assert!(write_new(&path, b"").is_err() && write_new(directory.path().join("b.txt"), b"").is_ok());
        assert_eq!(fs::read(directory.path().join("a.txt.tmp")).expect("there"), b"mine");
        assert_eq!(fs::read_dir(directory.path()).expect("list").count(), 3);
    }

    #[test]
    fn what_is_no_regular_file_is_not_replaced() {
        use std::os::unix::fs::{FileTypeExt, symlink};
        let directory = tempfile::tempdir().expect("temporary directory");
        let at = |name: &str| directory.path().join(name);
        rustix::fs::mknodat(rustix::fs::CWD, at("pipe"), rustix::fs::FileType::Fifo, rustix::fs::Mode::RWXU, 0)
            .expect("made");
        symlink(at("pipe"), at("to-pipe")).expect("made");
        symlink("/proc/self/fd/1", at("stdout")).expect("made");
        fs::write(at("file"), b"before").expect("written");
        symlink(at("file"), at("to-file")).expect("made");
        for (name, why) in
            [("pipe", "a named pipe"), ("to-pipe", "a named pipe"), ("stdout", "an open file"), (".", "a directory")]
        {
            let refused = write_whole(at(name), b"x").expect_err(name).source.to_string();
            assert!(refused.contains(why) && refused.contains("not a regular file"), "{name}: {refused}");
        }
        assert!(fs::symlink_metadata(at("pipe")).expect("there").file_type().is_fifo());
        assert!(fs::symlink_metadata(at("stdout")).expect("there").is_symlink());
        write_whole(at("to-file"), b"after").expect("a link to a file is replaced");
        assert_eq!(fs::read(at("file")).expect("there"), b"before");
    }

    #[test]
    fn names_under_which_a_file_is_begun_are_known() {
        for (name, is_one) in [
            ("a.toml.tmp", true),
            ("a.toml.0123abcd.tmp", true),
            ("a.toml", false),
            ("a.toml.0123abcd", false),
            ("a.toml.0123abc.tmp", false),
            ("a.toml.0123abcx.tmp", false),
            ("a.toml.old.tmp", false),
            ("ba.toml.tmp", false),
        ] {
            assert_eq!(is_temporary(OsStr::new(name), "a.toml"), is_one, "{name}");
        }
    }
}
