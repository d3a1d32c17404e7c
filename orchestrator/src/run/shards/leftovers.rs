//! Cleanup of unfinished tables that killed merges leave in the shared directory.
//!
//! No information on a shared disk proves that a process of another node is dead. So a merge writes a note beside its tables with
//! its process number. Tables of a dead process of the same system are removed. Tables of unknown writers and of other nodes are
//! removed when they have not changed for an hour.

use super::super::directory::{RESULTS, TIMINGS};
use super::shared::Shared;
use bladeoff_system::files::{FileError, create_beside, is_temporary};
use bladeoff_system::folder::Folder;
use bladeoff_system::place::Place;
use serde_json::{Value, json};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::time::Duration;

/// Age of an unfinished table that is removed.
const LEFTOVER: Duration = Duration::from_secs(3600);
/// Base name of a note, which has the form `merge.0123abcd.tmp`.
const NOTE: &str = "merge";
/// Largest note that is read \[bytes\].
const MOST: u64 = 4096;

/// Note of a merge in progress; dropping it removes the file.
#[derive(Debug)]
pub(super) struct MergeNote(Place);

impl MergeNote {
    /// Writes the note that names this process and its tables.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn begin(folder: &Folder, tables: &[&Path]) -> Result<Self, FileError> {
        let (mut file, place) = create_beside(&folder.place(NOTE), Place::create_new)?;
        let note = Self(place);
        let names = tables.iter().filter_map(|table| table.file_name()?.to_str());
        let text = json!({ "system": system(), "pid": std::process::id(), "began": began("self"), "tables": names.collect::<Vec<_>>() });
        file.write_all(text.to_string().as_bytes()).map_err(FileError::at("write", &note.0))?;
        Ok(note)
    }
}

impl Drop for MergeNote {
    fn drop(&mut self) {
        // A leftover note names a process that has ended.
        let _ = self.0.remove();
    }
}

/// Identity of the process table of this system: boot and container.
fn system() -> Option<String> {
    let start = fs::read_to_string("/proc/sys/kernel/random/boot_id").ok()?;
    let container = fs::read_link("/proc/self/ns/pid").ok()?;
    Some(format!("{} {}", start.trim(), container.to_string_lossy()))
}

/// Start time of a process in clock ticks, because process numbers are reused.
fn began(pid: &str) -> Option<u64> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name in parentheses may contain any characters; this is the 20th word after it.
    stat.rsplit_once(") ")?.1.split(' ').nth(19)?.parse().ok()
}

/// Whether the process that wrote a note has certainly ended.
fn is_writer_gone(note: &Value) -> bool {
    let (Some(own), Some(pid), Some(start)) = (system(), note["pid"].as_u64(), note["began"].as_u64()) else {
        return false;
    };
    note["system"] == json!(own) && began(&pid.to_string()) != Some(start)
}

/// Removes the tables of killed merges.
pub(super) fn remove(shared: &Shared) {
    let folder = shared.folder();
    let names = folder.names().unwrap_or_default();
    let is_old = |place: &Place| {
        let age = || place.symlink_metadata().ok()?.modified().ok()?.elapsed().ok();
        age().is_some_and(|age| age > LEFTOVER)
    };
    let is_table = |name: &std::ffi::OsStr| [RESULTS, TIMINGS].iter().any(|table| is_temporary(name, table));
    // A file that cannot be removed has no effect.
    for name in names.iter().filter(|name| is_temporary(name, NOTE)) {
        let place = folder.place(name);
        let note = place.read(MOST).ok().and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok());
        if let Some(note) = note.filter(is_writer_gone) {
            let tables = note["tables"].as_array().into_iter().flatten().filter_map(Value::as_str);
            for table in tables.filter(|table| is_table(table.as_ref())) {
                let _ = folder.place(table).remove();
            }
            let _ = place.remove();
        } else if is_old(&place) {
            let _ = place.remove();
        }
    }
    for name in names.iter().filter(|name| is_table(name)) {
        let place = folder.place(name);
        if is_old(&place) {
            let _ = place.remove();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_of_a_living_process_or_another_system_is_not_of_a_dead_one() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let open = Folder::open(folder.path()).expect("opened");
        let note = MergeNote::begin(&open, &[Path::new("/a/results.parquet.0123abcd.tmp")]).expect("written");
        let text = note.0.read(MOST).expect("there");
        let mut said: Value = serde_json::from_slice(&text).expect("JSON");
        assert_eq!(said["tables"], json!(["results.parquet.0123abcd.tmp"]));
        assert!(!is_writer_gone(&said), "this process lives");
        said["began"] = json!(1);
        assert!(is_writer_gone(&said), "its number is another process's");
        said["system"] = json!("another");
        assert!(!is_writer_gone(&said) && !is_writer_gone(&json!([])) && !is_writer_gone(&json!({})));
        drop(note);
        assert_eq!(fs::read_dir(folder.path()).expect("listed").count(), 0);
    }
}
