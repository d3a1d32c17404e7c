//! Removal of outdated answers: `answers.json`, and `answers/NAME.parquet` of questions that no longer exist. Files of other
//! origin are kept.

use super::answer_sums::forget_sums;
use super::directory::{ANSWERS, CURVES};
use bladeoff_answers::tables::{QUESTION_KEY, read_metadata};
use bladeoff_system::files::{FileError, is_temporary};
use bladeoff_system::folder::Folder;
use bladeoff_system::place::Place;
use std::ffi::OsStr;

/// Removes all answers when their table no longer is that of the study.
///
/// # Errors
/// The directory cannot be written.
pub fn forget_answers(folder: &Folder) -> Result<(), FileError> {
    forget_sums(folder)?;
    if folder.place(ANSWERS).remove()? {
        folder.sync()?;
    }
    remove_curves(folder, |_| false)
}

/// File name of a question's curve.
pub fn curve_file(question: &str) -> String {
    format!("{question}.parquet")
}

/// Removes outdated curves, and the folder if it becomes empty.
///
/// # Errors
/// The directory cannot be written.
pub fn remove_curves(folder: &Folder, is_wanted: impl Fn(&str) -> bool) -> Result<(), FileError> {
    // A folder that cannot be opened contains no file of this program.
    let Ok(curves) = folder.folder(CURVES) else { return Ok(()) };
    let names = curves.names().map_err(FileError::at("read", curves.path()))?;
    let mut left = names.len();
    for name in &names {
        let place = curves.place(name);
        let is_stale = name.to_str().is_some_and(|name| !is_wanted(name)) && is_curve(&place, name);
        if is_stale && place.remove()? {
            left -= 1;
        }
    }
    if left < names.len() {
        curves.sync()?;
    }
    if left == 0 && folder.place(CURVES).remove_folder().is_ok() {
        folder.sync()?;
    }
    Ok(())
}

/// Whether a file is a curve, by its name and metadata, or the temporary file of a killed program.
fn is_curve(place: &Place, name: &OsStr) -> bool {
    let text = name.to_string_lossy();
    let question = |stem: &str| stem.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'_' || c == b'-');
    if !place.is_file() {
        return false;
    }
    if let Some(begun) = text.find(".parquet.").map(|dot| &text[..dot + ".parquet".len()]) {
        return is_temporary(name, begun);
    }
    let Some(stem) = text.strip_suffix(".parquet").filter(|stem| question(stem)) else { return false };
    let says =
        |metadata: Vec<(String, String)>| metadata.iter().any(|(key, value)| key == QUESTION_KEY && value == stem);
    read_metadata(place).is_ok_and(says)
}
