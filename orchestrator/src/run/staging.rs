//! Folders of a result directory that are replaced and removed as a whole: parts and curves. During the replacement a folder has
//! a temporary name.

use super::directory::{PARTS, RunDirectory, TIMING_PARTS, is_part};
use bladeoff_system::files::FileError;
use bladeoff_system::folder::Folder;
use bladeoff_system::place::Place;
use std::ffi::OsStr;

impl RunDirectory {
    /// Removes the temporary folders of a killed run; no other process writes here now.
    ///
    /// # Errors
    /// The directory cannot be written, or the name of a folder of parts is that of another file.
    pub fn tidy(&self) -> Result<(), FileError> {
        self.tidy_files()?;
        for folder in [PARTS, TIMING_PARTS] {
            self.empty_aside(folder)?;
            self.folder_if_there(folder)?;
        }
        Ok(())
    }

    /// Creates an empty folder that can replace the one of this name.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn new_folder(&self, name: &str) -> Result<Folder, FileError> {
        self.empty_aside(name)?;
        let place = self.file(&aside(name));
        let made = place.create_folder().and_then(|()| self.open().folder(&aside(name)));
        made.map_err(FileError::at("create", &place))
    }

    /// Replaces the folder of this name by the one of [`RunDirectory::new_folder`]. One of the two exists at every moment, if the
    /// file system can exchange names.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn put_new_folder(&self, name: &str) -> Result<(), FileError> {
        let (new, place) = (self.file(&aside(name)), self.file(name));
        let renamed = |old: Option<Folder>| {
            let Some(old) = old else { return new.rename_to(&place) };
            if new.exchange_with(&place).is_ok() {
                return Ok(());
            }
            // A file system that cannot exchange names: parts are replaced singly.
            remove_parts_in(&old)?;
            let new = self.open().folder(&aside(name))?;
            for part in new.names()? {
                new.place(&part).rename_to(&old.place(&part))?;
            }
            Ok(())
        };
        renamed(self.folder_if_there(name)?).map_err(FileError::at("rename to", &place))?;
        self.open().sync()?;
        self.empty_aside(name)
    }

    /// Removes the folders of finished rows, each at once with all its parts. Files of other origin are kept.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn remove_parts(&self) -> Result<(), FileError> {
        [PARTS, TIMING_PARTS].into_iter().try_for_each(|name| self.remove_folder_of_parts(name))
    }

    /// Removes the folders of finished rows when every row is in the table; failures are reported and ignored.
    #[must_use]
    pub fn try_to_remove_parts(&self) -> Vec<FileError> {
        [PARTS, TIMING_PARTS].into_iter().filter_map(|name| self.remove_folder_of_parts(name).err()).collect()
    }

    fn remove_folder_of_parts(&self, name: &str) -> Result<(), FileError> {
        self.empty_aside(name)?;
        if self.folder_if_there(name)?.is_none() {
            return Ok(());
        }
        let (path, away) = (self.file(name), self.file(&aside(name)));
        path.rename_to(&away).map_err(FileError::at("remove", &path))?;
        self.open().sync()?;
        self.empty_aside(name)
    }

    /// Opens the folder of this name; `None`: it does not exist.
    fn folder_if_there(&self, name: &str) -> Result<Option<Folder>, FileError> {
        match self.open().folder(name) {
            Ok(folder) => Ok(Some(folder)),
            Err(source) if source.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(source) => Err(FileError::at("use", &self.file(name))(source)),
        }
    }

    /// Opens the folder of this name; creates it if necessary.
    ///
    /// # Errors
    /// The folder cannot be created, or another file has the name.
    pub fn folder(&self, name: &str) -> Result<Folder, FileError> {
        if let Some(folder) = self.folder_if_there(name)? {
            return Ok(folder);
        }
        let place = self.file(name);
        let made = place.create_folder().and_then(|()| self.open().folder(name));
        let folder = made.map_err(FileError::at("create", &place))?;
        self.open().sync()?;
        Ok(folder)
    }

    /// Removes a temporary folder of parts. Files of other origin in it are moved back to their place.
    fn empty_aside(&self, name: &str) -> Result<(), FileError> {
        let Some(away) = self.folder_if_there(&aside(name))? else { return Ok(()) };
        let place = self.file(&aside(name));
        let emptied = || {
            remove_parts_in(&away)?;
            for name_in in away.names()? {
                let home = self.folder(name).map_err(|error| error.source)?;
                away.place(&name_in).rename_to_free(&free_place(&home, &name_in))?;
            }
            place.remove_folder()
        };
        emptied().map_err(FileError::at("remove", &place))
    }
}

/// Temporary name of a folder.
fn aside(folder: &str) -> String {
    format!("{folder}.aside")
}

/// Removes the parts in a folder.
fn remove_parts_in(folder: &Folder) -> std::io::Result<()> {
    for name in folder.names()?.into_iter().filter(|name| is_part(name)) {
        folder.place(&name).remove().map_err(|error| error.source)?;
    }
    Ok(())
}

/// Name like this one that no file in the folder has.
fn free_place(folder: &Folder, name: &OsStr) -> Place {
    let mut place = folder.place(name);
    let mut n = 1;
    while place.exists() {
        let mut other = name.to_owned();
        other.push(format!(".kept-{n}"));
        place = folder.place(other);
        n += 1;
    }
    place
}

#[cfg(test)]
mod tests {
    use super::super::directory::{part_name, row_files};
    use super::*;
    use std::fs;
    use std::path::Path;

    #[test]
    fn what_somebody_puts_between_the_parts_stays() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let directory = RunDirectory::claim(folder.path(), false, None).expect("empty");
        let put = |path: &Path, name: &str, text: &str| fs::write(path.join(name), text).expect("written");
        let parts = directory.file(PARTS);
        let names = || {
            let entries = fs::read_dir(&*parts).into_iter().flatten().flatten();
            let mut names: Vec<_> = entries.map(|entry| entry.file_name().into_string().expect("UTF-8")).collect();
            names.sort();
            names
        };
        fs::create_dir(&*parts).expect("created");
        for name in [&part_name(1), &part_name(1_000_000), "part-mine.parquet", "notes.txt"] {
            put(&parts, name, name);
        }
        assert_eq!(row_files(folder.path()).len(), 2);
        // New parts replace the old ones.
        let fresh = directory.new_folder(PARTS).expect("made");
        put(fresh.path(), &part_name(1), "fresh");
        directory.put_new_folder(PARTS).expect("exchanged");
        assert_eq!(names(), ["notes.txt", "part-000001.parquet", "part-mine.parquet"]);
        assert_eq!(fs::read_to_string(parts.join(part_name(1))).expect("there"), "fresh");
        // A kill during the replacement, and a name that was used again meanwhile.
        fs::rename(&*parts, &*directory.file(&aside(PARTS))).expect("renamed");
        fs::create_dir(&*parts).expect("created");
        put(&parts, "notes.txt", "newer");
        directory.remove_parts().expect("removed");
        assert_eq!(names(), ["notes.txt", "notes.txt.kept-1", "part-mine.parquet"]);
        assert_eq!(fs::read_to_string(parts.join("notes.txt.kept-1")).expect("there"), "notes.txt");
        assert!(!directory.file(&aside(PARTS)).exists());
        // Without files of other origin nothing remains.
        fs::remove_dir_all(&*parts).expect("removed");
        fs::create_dir(&*parts).expect("created");
        put(&parts, &part_name(1), "");
        directory.remove_parts().expect("removed");
        assert!(!parts.exists());
    }
}
