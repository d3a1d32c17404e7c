//! Files `answers.json` and `answers/NAME.parquet` of a result directory, with their checksums. They are replaced as a whole and never
//! written through links. Curves of removed questions are deleted; files of other origin stay.

use super::Answering;
use crate::run::directory::{ANSWERS, CURVES};
use crate::run::{Untrusted, are_kept, check_trust, curve_file, forget_sums, keep_sums, remove_curves};
use bladeoff_answers::tables::{TableError, write_curve};
use bladeoff_system::files::{FileError, Pending, write_whole};
use bladeoff_system::folder::Folder;
use std::io::ErrorKind;
use std::path::Path;

/// Reason why answers cannot be stored.
#[derive(Debug, thiserror::Error)]
pub enum KeepError {
    /// A file operation that failed.
    #[error(transparent)]
    File(#[from] FileError),
    /// A curve that cannot be written.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A directory to which other users can write.
    #[error(transparent)]
    Untrusted(#[from] Untrusted),
    /// Answers that cannot be converted to JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}

impl KeepError {
    /// Whether the directory may not be written, as opposed to an error of a file.
    #[must_use]
    pub fn is_refusal(&self) -> bool {
        match self {
            Self::Untrusted(_) => true,
            Self::File(error) | Self::Table(TableError::File(error)) => {
                matches!(error.source.kind(), ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem)
            }
            Self::Table(_) | Self::Json(_) => false,
        }
    }
}

/// Writes the answers of a complete study into its directory; `trusts`: also if other users can write there.
///
/// # Errors
/// The answers cannot be written. Answers of another study or of other questions may still be there.
pub fn keep(directory: &Path, answering: &Answering, trusts: bool) -> Result<(), KeepError> {
    let folder = Folder::open(directory).map_err(FileError::at("open", directory))?;
    if let Some(doubt) = check_trust(&folder, trusts)? {
        return Err(doubt.into());
    }
    let text = answering.answers.json()?;
    let place = folder.place(ANSWERS);
    let is_same = place.read(text.len() as u64).is_ok_and(|found| found == text.as_bytes());
    if is_same && answering.curves.is_empty() {
        remove_curves(&folder, |_| false)?;
        // no change: a directory that may not be written stays unchanged
        let kept = if are_kept(&folder) { Ok(()) } else { keep_sums(&folder, std::iter::empty()) };
        return kept.map_err(KeepError::from).or_else(|error| if error.is_refusal() { Ok(()) } else { Err(error) });
    }
    forget_sums(&folder)?;
    if !answering.curves.is_empty() {
        let curves = curves(&folder)?;
        for (name, curve) in &answering.curves {
            write_curve(Pending::create(curves.place(curve_file(name)))?, curve, name)?;
        }
    }
    if !is_same {
        write_whole(&place, text.as_bytes())?;
    }
    remove_curves(&folder, |name| answering.curves.iter().any(|(known, _)| name == curve_file(known)))?;
    Ok(keep_sums(&folder, answering.curves.iter().map(|(name, _)| curve_file(name)))?)
}

/// The folder of curves; created if it does not exist.
fn curves(folder: &Folder) -> Result<Folder, FileError> {
    let place = folder.place(CURVES);
    match folder.folder(CURVES) {
        Err(source) if source.kind() == ErrorKind::NotFound => {
            let made = place.create_folder().and_then(|()| folder.folder(CURVES));
            let made = made.map_err(FileError::at("create", &place))?;
            folder.sync()?;
            Ok(made)
        }
        found => found.map_err(FileError::at("use", &place)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::forget_answers as forget;
    use bladeoff_answers::ask::{Answers, SCHEMA};
    use bladeoff_answers::estimate::curve::{Curve, CurveCells};
    use std::fs;
    use std::os::unix::fs::symlink;

    fn answering(curves: &[&str]) -> Answering {
        let curve = Curve { columns: vec![("level".to_owned(), CurveCells::Numbers(vec![Some(1.0)]))] };
        Answering {
            answers: Answers { schema: SCHEMA, complete: true, answers: Vec::new() },
            curves: curves.iter().map(|name| ((*name).to_owned(), curve.clone())).collect(),
            points: 1,
            of: 1,
            design: 1,
            is_design: true,
            is_known: true,
            is_open: false,
        }
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        let mut names: Vec<String> = entries.map(|entry| entry.file_name().into_string().expect("UTF-8")).collect();
        names.sort();
        names
    }

    #[test]
    fn curves_of_questions_that_are_gone_go_and_nothing_else() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let (root, curves) = (folder.path(), folder.path().join(CURVES));
        keep(root, &answering(&["a", "b"]), false).expect("writable");
        assert_eq!(
            (names(root), names(&curves)),
            (
                vec!["answers".into(), "answers.b3sum".into(), ANSWERS.to_owned()],
                vec!["a.parquet".into(), "b.parquet".into()]
            )
        );
        // a file of another origin, and one of a killed program
        fs::write(curves.join("mine.parquet"), "mine").expect("written");
        fs::copy(curves.join("a.parquet"), curves.join("copy.parquet")).expect("copied");
        fs::write(curves.join("a.parquet.0123abcd.tmp"), "begun").expect("written");
        keep(root, &answering(&["b"]), false).expect("writable");
        assert_eq!(names(&curves), ["b.parquet", "copy.parquet", "mine.parquet"]);
        forget(&Folder::open(root).expect("there")).expect("writable");
        assert_eq!(
            (names(root), names(&curves)),
            (vec!["answers".to_owned()], vec!["copy.parquet".into(), "mine.parquet".into()])
        );
        fs::remove_dir_all(&curves).expect("removed");
        keep(root, &answering(&["b"]), false).expect("writable");
        forget(&Folder::open(root).expect("there")).expect("writable");
        assert!(names(root).is_empty(), "{:?}", names(root));
    }

    #[test]
    fn nothing_is_written_through_a_link() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let (root, other) = (folder.path().join("run"), folder.path().join("other"));
        [&root, &other].iter().for_each(|path| fs::create_dir(path).expect("created"));
        fs::write(other.join("kept"), "kept").expect("written");
        symlink(&other, root.join(CURVES)).expect("linked");
        assert!(keep(&root, &answering(&["a"]), false).is_err());
        assert_eq!(names(&other), ["kept"]);
        // a link with the name of the file is replaced, not followed
        symlink(other.join("kept"), root.join(ANSWERS)).expect("linked");
        keep(&root, &answering(&[]), false).expect("no curves, no folder");
        assert_eq!(fs::read_to_string(other.join("kept")).expect("there"), "kept");
        assert!(fs::symlink_metadata(root.join(ANSWERS)).expect("there").is_file());
    }
}
