//! Arguments for result directory and sample number, in the same forms for `why` and `replay`.
//!
//! ```text
//! 17                 sample 17 of the study of the present directory, or of the newest one below runs/
//! runs/first 17      sample 17 of runs/first
//! runs/first#17      the same
//! runs/first         no sample
//! ```

use super::error::CliError;
use super::place::default_directory;
use super::refusals::SampleError;
use crate::run::directory::RESULTS;
use std::path::{Path, PathBuf};

/// Parses the arguments; `known`: whether an option gives the sample number, so that a single number is a
/// directory.
///
/// # Errors
/// [`SampleError`]; no directory is given, and no default is found.
pub(super) fn read(
    command: &'static str,
    words: &[String],
    known: bool,
    option: Option<&Path>,
) -> Result<(PathBuf, Option<u64>), CliError> {
    let (directory, sample) = match words {
        [] => (None, None),
        [word] => of_one(word, known)?,
        [directory, word] if word.parse::<u64>().is_err() && directory.parse::<u64>().is_ok() => {
            let (directory, sample) = (word.into(), directory.clone());
            return Err(SampleError::Order { command, directory, sample }.into());
        }
        [directory, word, ..] => (Some(PathBuf::from(directory)), Some(number(word)?)),
    };
    let directory = match (directory, option) {
        (Some(first), Some(second)) => return Err(SampleError::Twice { first, second: second.to_path_buf() }.into()),
        (Some(directory), None) => directory,
        (None, Some(directory)) => directory.to_path_buf(),
        (None, None) => default_directory()?,
    };
    if directory.is_file() {
        let is_table = directory.file_name().is_some_and(|name| name == RESULTS);
        let parent =
            directory.parent().map(|parent| if parent.as_os_str().is_empty() { Path::new(".") } else { parent });
        let meant = parent.filter(|_| is_table).map(Path::to_path_buf);
        return Err(SampleError::File { file: directory, meant }.into());
    }
    Ok((directory, sample))
}

/// Parses one argument: a number, or a directory with or without a number.
fn of_one(word: &str, known: bool) -> Result<(Option<PathBuf>, Option<u64>), SampleError> {
    let path = PathBuf::from(word);
    if let (false, Ok(sample)) = (known, word.parse()) {
        return Ok((None, Some(sample)));
    }
    if path.exists() {
        return Ok((Some(path), None));
    }
    match word.rsplit_once('#') {
        Some((directory, sample)) if !directory.is_empty() => Ok((Some(directory.into()), Some(number(sample)?))),
        // without any part of a path: a number was intended
        _ if !known && !word.contains(['/', '.']) && word.starts_with(|c: char| c.is_ascii_digit() || c == '-') => {
            number(word).map(|sample| (None, Some(sample)))
        }
        _ => Ok((Some(path), None)),
    }
}

fn number(word: &str) -> Result<u64, SampleError> {
    word.parse().map_err(|_| SampleError::Number { word: word.to_owned() })
}
