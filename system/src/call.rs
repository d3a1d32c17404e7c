//! Commands as they are printed: with the program name as it was called, quoted for a shell, so that a reader can paste them.
//!
//! The program is not always on the PATH as `bladeoff`: `cargo run` starts `target/release/bladeoff`, and a user may call `./bladeoff` or a
//! whole path. The printed name is valid in the working directory from which the program was called.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// How this program was called: the first word of a command that calls it again from here.
#[must_use]
pub fn program() -> &'static str {
    static PROGRAM: LazyLock<String> = LazyLock::new(|| {
        let called = std::env::args_os().next().unwrap_or_default();
        let found = name_of(&called, std::env::var_os("PATH"), Path::new("/proc/self/exe"));
        // A word with `=` before a command would be an assignment.
        let word = word(&found);
        if word.contains('=') && !word.starts_with(['\'', '"']) { format!("'{word}'") } else { word }
    });
    &PROGRAM
}

/// A command of this program. Each element of `words` becomes one shell word, whatever characters it has.
#[must_use]
pub fn command<W: AsRef<OsStr>>(words: impl IntoIterator<Item = W>) -> String {
    let mut text = program().to_owned();
    for one in words {
        text.push(' ');
        text.push_str(&word(one.as_ref()));
    }
    text
}

/// A path as a word of a command: a path that begins with `-` gets `./` before it, so that it is not read as an option.
#[must_use]
pub fn path_word(path: &Path) -> PathBuf {
    if path.as_os_str().as_bytes().starts_with(b"-") { Path::new(".").join(path) } else { path.to_path_buf() }
}

/// Quotes a word for a POSIX shell where that is necessary. A word that ends in a line feed needs bash, ksh or zsh.
#[must_use]
pub fn word(text: impl AsRef<OsStr>) -> String {
    let bytes = text.as_ref().as_bytes();
    let is_plain = |byte: &u8| byte.is_ascii_alphanumeric() || b"/._-+=:,@%".contains(byte);
    match std::str::from_utf8(bytes) {
        Ok(text) if !text.is_empty() && bytes.iter().all(is_plain) => text.to_owned(),
        Ok(text) if !text.chars().any(char::is_control) => format!("'{}'", text.replace('\'', "'\\''")),
        // Control characters and bytes that are not UTF-8 are printed as octal escapes.
        _ => {
            let spelled = |(at, byte): (usize, &u8)| match byte {
                b'-' if at == 0 => "\\055".to_owned(),
                b' '..=b'~' if !b"\\'\"$`%".contains(byte) => char::from(*byte).to_string(),
                _ => format!("\\{byte:03o}"),
            };
            let spelled: String = bytes.iter().enumerate().map(spelled).collect();
            // A shell removes the line feeds at the end of `$(...)`.
            if bytes.ends_with(b"\n") { format!("$'{spelled}'") } else { format!("\"$(printf '{spelled}')\"") }
        }
    }
}

/// The name by which the program `running` can be called again: the name `called` if it still leads to that file, otherwise the file's path.
fn name_of(called: &OsStr, search: Option<OsString>, running: &Path) -> OsString {
    let same = |path: &Path| match (fs::metadata(path), fs::metadata(running)) {
        (Ok(one), Ok(other)) => (one.dev(), one.ino()) == (other.dev(), other.ino()),
        _ => false,
    };
    let has_folder = called.as_bytes().contains(&b'/');
    let leads_here = if has_folder {
        same(Path::new(called))
    } else {
        let folders = search.iter().flat_map(std::env::split_paths);
        let first = folders.map(|folder| folder.join(called)).find(|path| path.is_file());
        !called.is_empty() && first.is_some_and(|path| same(&path))
    };
    if leads_here {
        return called.to_owned();
    }
    // A program file that was replaced while it runs has no path: the new file is called by the name of the old one.
    match fs::read_link(running) {
        Ok(path) if same(&path) => path.into_os_string(),
        _ if called.is_empty() => "bladeoff".into(),
        _ => called.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::ffi::OsStringExt;
    use std::os::unix::fs::symlink;
    use std::process::Command;

    #[test]
    fn words_of_a_command_are_quoted_where_they_have_to_be() {
        assert_eq!(word("runs/a-b_1.toml"), "runs/a-b_1.toml");
        assert_eq!(word("my study's.toml"), "'my study'\\''s.toml'");
        assert_eq!(word(""), "''");
        assert_eq!(path_word(Path::new("-x.toml")), Path::new("./-x.toml"));
        assert_eq!(path_word(Path::new("x.toml")), Path::new("x.toml"));
    }

    /// A shell reads every quoted word back unchanged.
    #[test]
    fn a_shell_reads_every_word_back() {
        let words: [&[u8]; 11] = [
            b"a b",
            b"it's",
            b"$HOME `id` \"x\"",
            b"a\\b*?[c]~#",
            b"-n",
            b"two\nlines",
            b"last\n",
            b"-'100 %'\n\n",
            b"-\x1b[31mred",
            b"%s\x07",
            b"not \xff text",
        ];
        for bytes in words {
            let name = OsString::from_vec(bytes.to_vec());
            let quoted = word(&name);
            assert!(!quoted.chars().any(char::is_control), "{quoted:?}");
            let script = format!("printf %s {quoted}");
            let shell = if bytes.ends_with(b"\n") { "bash" } else { "sh" };
            let said = Command::new(shell).args(["-c", &script]).output().expect("a shell");
            assert_eq!(said.stdout, bytes, "{quoted}");
        }
    }

    #[test]
    fn the_program_is_named_as_it_was_called_where_that_leads_to_it() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let (bin, other) = (folder.path().join("bin"), folder.path().join("other"));
        fs::create_dir(&bin).and_then(|()| fs::create_dir(&other)).expect("created");
        let real = folder.path().join("real");
        fs::write(&real, "program").and_then(|()| fs::write(other.join("bladeoff"), "another")).expect("written");
        symlink(&real, bin.join("bladeoff")).expect("linked");
        let running = folder.path().join("exe");
        symlink(&real, &running).expect("linked");
        let path = |folders: &[&Path]| Some(std::env::join_paths(folders).expect("a path"));
        let named = |called: &Path, search| PathBuf::from(name_of(called.as_os_str(), search, &running));
        // The plain name where the PATH leads to this program first; any path that leads to it as given; otherwise its real path.
        assert_eq!(named(Path::new("bladeoff"), path(&[&bin, &other])), Path::new("bladeoff"));
        assert_eq!(named(Path::new("bladeoff"), path(&[&other, &bin])), real);
        assert_eq!(named(Path::new("bladeoff"), None), real);
        assert_eq!(named(&bin.join("bladeoff"), None), bin.join("bladeoff"));
        assert_eq!(named(&other.join("bladeoff"), None), real);
        assert_eq!(named(Path::new(""), path(&[&bin])), real);
    }
}
