//! Checksums of the answers in a directory: `answers.b3sum`, which `b3sum --check` reads, too.
//!
//! The file is removed before answers are replaced and written after them. So a program killed in between leaves answers without checksums, and never
//! undamaged answers that appear damaged.

use super::directory::{ANSWER_SUMS, ANSWERS, CURVES};
use bladeoff_system::files::{FileError, write_whole};
use bladeoff_system::folder::Folder;
use blake3::Hash;

/// Largest checksum file that is read \[bytes\]: a study has at most some hundred questions.
const MOST: u64 = 1 << 20;
/// Largest curve or answer text that is hashed \[bytes\].
const MOST_ANSWERS: u64 = 1 << 30;

/// Removes the checksums before their files are replaced.
///
/// # Errors
/// The directory cannot be written.
pub fn forget_sums(folder: &Folder) -> Result<(), FileError> {
    if folder.place(ANSWER_SUMS).remove()? {
        folder.sync()?;
    }
    Ok(())
}

/// Writes the checksums of the answers and of the curves in these files.
///
/// # Errors
/// A file cannot be read, or the checksums not be written.
pub fn keep_sums(folder: &Folder, files: impl Iterator<Item = String>) -> Result<(), FileError> {
    let mut lines = line(&folder.place(ANSWERS).read(MOST_ANSWERS)?, ANSWERS);
    let mut files = files.peekable();
    if files.peek().is_some() {
        let curves = folder.folder(CURVES).map_err(FileError::at("open", &folder.place(CURVES)))?;
        for file in files {
            lines.push_str(&line(&curves.place(&file).read(MOST_ANSWERS)?, &format!("{CURVES}/{file}")));
        }
    }
    write_whole(folder.place(ANSWER_SUMS), lines.as_bytes())
}

/// Whether the checksums match answers without curves.
pub fn are_kept(folder: &Folder) -> bool {
    let wanted = folder.place(ANSWERS).read(MOST_ANSWERS).map(|bytes| line(&bytes, ANSWERS));
    let found = folder.place(ANSWER_SUMS).read(MOST);
    wanted.is_ok_and(|wanted| found.is_ok_and(|found| found == wanted.as_bytes()))
}

fn line(bytes: &[u8], name: &str) -> String {
    format!("{}  {name}\n", blake3::hash(bytes).to_hex())
}

/// Reads the checksums by file name; a damaged line gives a name without one. `None`: the file is missing.
pub(super) fn sums(folder: &Folder) -> Option<Vec<(String, Option<Hash>)>> {
    let text = folder.place(ANSWER_SUMS).read(MOST).ok()?;
    let text = String::from_utf8_lossy(&text);
    let of_line = |line: &str| {
        let (hash, name) = line.split_once("  ").unwrap_or(("", line));
        (name.to_owned(), Hash::from_hex(hash).ok().filter(|_| is_answer(name)))
    };
    Some(text.lines().map(of_line).collect())
}

fn is_answer(name: &str) -> bool {
    let curve = name.strip_prefix(CURVES).and_then(|name| name.strip_prefix('/'));
    name == ANSWERS || curve.is_some_and(|curve| curve.ends_with(".parquet") && !curve.contains('/'))
}
