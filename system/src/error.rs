//! The error of a failed file operation, and the sync of a directory, which files and places share.

use crate::shown;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// A file operation that failed, with the path it failed on.
#[derive(Debug, thiserror::Error)]
#[error("cannot {action} {}", shown(path))]
pub struct FileError {
    /// Operation that failed ("write", "create", ...).
    pub action: &'static str,
    /// Path of the file.
    pub path: PathBuf,
    /// Error of the system.
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

/// Action in the error of a name that cannot be made durable. The path in the error is the file's, which names the file concerned.
pub(crate) const SYNC: &str = "sync the directory of";

#[cfg(test)]
mod tests {
    use super::*;

    /// The message must name the file: "cannot sync ." named none.
    #[test]
    fn an_error_of_a_sync_names_the_file_whose_name_is_lost() {
        let error = sync_parent(Path::new("no-such-folder/results.parquet")).expect_err("there is no such folder");
        assert_eq!(error.to_string(), "cannot sync the directory of no-such-folder/results.parquet");
    }
}
