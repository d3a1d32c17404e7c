//! Reads files that the user names: regular UTF-8 files of limited size, in allowed places.

use bladeoff_system::place::{Place, Unfit};
use bladeoff_system::shown;
use bladeoff_text::document::{cut, nearest};
use std::io;
use std::path::{Component, Path, PathBuf};

/// Reason for not reading an input file.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// The file does not exist.
    #[error("there is no file {}{}", shown(path), did_you_mean(nearest.as_deref()))]
    Missing {
        /// The file.
        path: PathBuf,
        /// The file in the same directory with the most similar name.
        nearest: Option<PathBuf>,
    },
    /// A directory, device, pipe ...
    #[error("{} is not a regular file", shown(path))]
    NotAFile {
        /// The path.
        path: PathBuf,
    },
    /// A symbolic link in a result directory.
    #[error("{} is a symbolic link, which is not followed in a result directory", shown(path))]
    Link {
        /// The path.
        path: PathBuf,
    },
    /// A file that exceeds the size limit.
    #[error("{} has {bytes} bytes; at most {limit} are read", shown(path))]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Size of the file.
        bytes: u64,
        /// Largest allowed.
        limit: u64,
    },
    /// A file that is not text.
    #[error("{} is neither UTF-8 text (byte {at}) nor UTF-16 with its byte order mark: save it as UTF-8", shown(path))]
    NotText {
        /// The file.
        path: PathBuf,
        /// Position of the first byte that is not UTF-8.
        at: usize,
    },
    /// A path in a study file that leads out of the allowed folders.
    #[error("{named:?} is outside the folders that a study may read: {reason}")]
    Escapes {
        /// Path in the study file.
        named: String,
        /// Violated rule.
        reason: &'static str,
    },
    /// Error of the system.
    #[error("cannot read {}", shown(path))]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        #[source]
        source: io::Error,
    },
}

/// Reads a text file, named by the user, of at most `limit` bytes.
///
/// # Errors
/// See [`InputError`].
pub fn read_input(path: &Path, limit: u64) -> Result<String, InputError> {
    read_text(&Place::named(path), limit).map_err(|error| match error {
        InputError::Missing { path, .. } => InputError::Missing { nearest: nearest_path(&path), path },
        other => other,
    })
}

/// Most names of a directory that are compared with a misspelled one.
const MOST_NAMES: usize = 10_000;

/// The existing path most similar to a missing one; also if an earlier part of the path is missing.
fn nearest_path(missing: &Path) -> Option<PathBuf> {
    let (parent, name) = (missing.parent()?, missing.file_name()?.to_str()?);
    let folder = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
    if !folder.exists() {
        return Some(nearest_path(parent)?.join(name)).filter(|path| path.exists());
    }
    let names =
        std::fs::read_dir(folder).ok()?.take(MOST_NAMES).filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter(|name| !name.starts_with('.')).collect();
    // directory listings are unordered
    names.sort();
    nearest(name, names.iter().map(String::as_str)).map(|name| parent.join(name))
}

/// End of a message about a path: the name most likely meant, if the path does not exist.
#[must_use]
pub fn meant(path: &Path) -> String {
    if path.symlink_metadata().is_ok() { String::new() } else { did_you_mean(nearest_path(path).as_deref()) }
}

fn did_you_mean(nearest: Option<&Path>) -> String {
    nearest.map_or_else(String::new, |path| format!("; did you mean {}?", shown(path)))
}

/// Reads a file from the copies in a result directory.
///
/// # Errors
/// See [`InputError`].
pub fn read_frozen(path: &Path, limit: u64) -> Result<String, InputError> {
    read_text(&Place::from(path), limit)
}

fn read_text(path: &Place, limit: u64) -> Result<String, InputError> {
    let path_buf = || path.to_path_buf();
    let failed = |source: io::Error| match source.kind() {
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => {
            InputError::Missing { path: path_buf(), nearest: None }
        }
        _ => InputError::Io { path: path_buf(), source },
    };
    let bytes = path.read_checked(limit).map_err(|unfit| match unfit {
        Unfit::Kind(_) | Unfit::Links { .. } => InputError::NotAFile { path: path_buf() },
        Unfit::Link => InputError::Link { path: path_buf() },
        Unfit::TooLarge { bytes, limit } => InputError::TooLarge { path: path_buf(), bytes, limit },
        Unfit::Io(source) => failed(source),
    })?;
    decode(bytes).map_err(|at| InputError::NotText { path: path_buf(), at })
}

/// Decodes UTF-8, or UTF-16 with a byte order mark, as spreadsheets save "Unicode text"; otherwise returns the position of the first byte
/// that is not text. UTF-16 without a mark is recognised by the zeros among its first bytes.
fn decode(bytes: Vec<u8>) -> Result<String, usize> {
    let unit: fn([u8; 2]) -> u16 = match bytes.first_chunk() {
        Some([0xff, 0xfe]) => u16::from_le_bytes,
        Some([0xfe, 0xff]) => u16::from_be_bytes,
        _ => {
            if let Some(at) = bytes.iter().take(4).position(|byte| *byte == 0) {
                return Err(at);
            }
            return String::from_utf8(bytes).map_err(|error| error.utf8_error().valid_up_to());
        }
    };
    let (units, rest) = bytes[2..].as_chunks::<2>();
    let mut text = String::with_capacity(units.len());
    for (position, letter) in char::decode_utf16(units.iter().map(|pair| unit(*pair))).enumerate() {
        text.push(letter.map_err(|_| 2 * (position + 1))?);
    }
    if rest.is_empty() { Ok(text) } else { Err(bytes.len() - 1) }
}

/// Most `..` at the beginning of a path in a study.
const MOST_PARENTS: usize = 2;
/// Longest path on Linux \[bytes\].
const LONGEST_PATH: usize = 4096;

/// Path of a file named in a study: relative to the study file; `..` only at the beginning and at most twice (`../machines/rig.toml` is
/// a usual layout); never absolute. So a study from another person reads only files around itself. Symbolic links there are followed,
/// because the user who made them is responsible for their target.
///
/// # Errors
/// [`InputError::Escapes`].
pub fn beside(study_file: &Path, named: &str) -> Result<PathBuf, InputError> {
    let escapes = |reason| InputError::Escapes { named: cut(named, 120), reason };
    if named.len() > LONGEST_PATH {
        return Err(escapes("longer than a path may be"));
    }
    let mut parents = 0;
    let mut inside = false;
    for component in Path::new(named).components() {
        match component {
            Component::RootDir | Component::Prefix(_) => {
                return Err(escapes("an absolute path; name it relative to the study file"));
            }
            Component::ParentDir if inside => return Err(escapes("`..` after a folder name")),
            Component::ParentDir => parents += 1,
            Component::Normal(_) => inside = true,
            Component::CurDir => {}
        }
    }
    if parents > MOST_PARENTS {
        return Err(escapes("more than two `..`"));
    }
    if !inside || named.contains('\0') {
        return Err(escapes("it names no file"));
    }
    Ok(study_file.parent().unwrap_or(Path::new("")).join(named))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn files_beside_the_study_and_up_to_two_levels_above_are_found() {
        let study = Path::new("studies/rub/a.toml");
        assert_eq!(beside(study, "m.toml").expect("beside"), Path::new("studies/rub/m.toml"));
        assert_eq!(beside(study, "../machines/m.toml").expect("above"), Path::new("studies/rub/../machines/m.toml"));
        for named in ["/etc/passwd", "../../../x.toml", "a/../../x", "", "..", ".", "a\0b", &"a".repeat(5000)] {
            assert!(matches!(beside(study, named), Err(InputError::Escapes { .. })), "{named:?}");
        }
    }

    #[test]
    fn a_mistyped_name_finds_the_file_beside_it() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let at = |name: &str| directory.path().join(name);
        fs::create_dir(at("studies")).expect("a directory");
        for name in ["studies/first_look.toml", "studies/lab_rig.toml"] {
            fs::write(at(name), "").expect("written");
        }
        for (given, meant) in [
            ("studies/first-look.toml", Some("studies/first_look.toml")),
            ("studies/lab_rig", Some("studies/lab_rig.toml")),
            ("studis/lab_rig.toml", Some("studies/lab_rig.toml")),
            ("studies/turbine.toml", None),
            ("nowhere/lab_rig.toml", None),
        ] {
            let error = read_input(&at(given), 10).expect_err("missing");
            assert!(
                matches!(&error, InputError::Missing { nearest, .. } if *nearest == meant.map(at)),
                "{given}: {error}"
            );
            assert_eq!(error.to_string().contains("; did you mean "), meant.is_some(), "{error}");
        }
    }

    #[test]
    fn only_regular_text_files_of_sensible_size_are_read() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let path = directory.path().join("f");
        assert!(matches!(read_input(&path, 10), Err(InputError::Missing { .. })));
        assert!(matches!(read_input(directory.path(), 10), Err(InputError::NotAFile { .. })));
        assert!(matches!(read_input(Path::new("/dev/zero"), 10), Err(InputError::NotAFile { .. })));
        fs::write(&path, b"0123456789").expect("write");
        assert_eq!(read_input(&path, 10).expect("read"), "0123456789");
        assert!(matches!(read_input(&path, 9), Err(InputError::TooLarge { bytes: 10, .. })));
        let link = directory.path().join("link");
        std::os::unix::fs::symlink("f", &link).expect("linked");
        assert_eq!(read_input(&link, 10).expect("what the user names"), "0123456789");
        assert!(matches!(read_frozen(&link, 10), Err(InputError::Link { .. })));
        fs::write(&path, b"ab\xff").expect("write");
        assert!(matches!(read_input(&path, 10), Err(InputError::NotText { at: 2, .. })));
    }

    #[test]
    fn utf_16_is_read_where_its_mark_says_so() {
        let bytes = |mark: [u8; 2], to: fn(u16) -> [u8; 2]| -> Vec<u8> {
            mark.into_iter().chain("a;µ\r\n😀".encode_utf16().flat_map(to)).collect()
        };
        for bytes in [bytes([0xff, 0xfe], u16::to_le_bytes), bytes([0xfe, 0xff], u16::to_be_bytes)] {
            assert_eq!(decode(bytes.clone()).as_deref(), Ok("a;µ\r\n😀"));
            assert_eq!(decode(bytes[..bytes.len() - 1].to_vec()), Err(12), "half a letter");
            assert!(decode(bytes[..bytes.len() - 2].to_vec()).is_err(), "half a pair");
            assert!(decode(bytes[2..].to_vec()).is_err(), "no mark");
        }
        assert_eq!(decode(b"a\0".to_vec()), Err(1));
        assert_eq!(decode(Vec::new()).as_deref(), Ok(""));
    }
}
