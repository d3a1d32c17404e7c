//! A file operation that failed, and the one that files and places have in common.

use crate::shown;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// A file operation that failed, with the path it failed on.
#[derive(Debug, thiserror::Error)]
#[error("cannot {action} {}", shown(path))]
pub struct FileError {
    /// What was tried ("write", "create", ...).
    pub action: &'static str,
    /// On what.
    pub path: PathBuf,
    /// What the system said.
    #[source]
    pub source: io::Error,
}

impl FileError {
    /// For `map_err`: attaches action and path.
    pub fn at(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self { action, path, source }
    }
}

/// Makes the name of a file in its directory durable.
///
/// # Errors
/// The directory cannot be opened or synced; the error names the file.
pub fn sync_parent(file: &Path) -> Result<(), FileError> {
    let directory = file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    File::open(directory).and_then(|opened| opened.sync_all()).map_err(FileError::at(SYNC, file))
}

/// The action of an error where the name of a file cannot be made durable: the file alone tells a reader what is concerned.
pub(crate) const SYNC: &str = "sync the directory of";

#[cfg(test)]
mod tests {
    use super::*;

    /// "cannot sync ." named no file.
    #[test]
    fn an_error_of_a_sync_names_the_file_whose_name_is_lost() {
        let error = sync_parent(Path::new("no-such-folder/results.parquet")).expect_err("there is no such folder");
        assert_eq!(error.to_string(), "cannot sync the directory of no-such-folder/results.parquet");
    }
}
