//! The base directory in which runs create their sockets: of this user, closed to others, with a short path.
//!
//! ```text
//! $BLADEOFF_RUNTIME_DIR       where it is set: there, or an error
//! $XDG_RUNTIME_DIR/bladeoff   where that is what it should be: absolute, of this user, 0700, short
//! /tmp/bladeoff-UID           otherwise
//! /tmp/bladeoff-UID-ID        where somebody else has taken that name: a directory for each run
//! ```
//! Any user who may write to /tmp may take a name in it, so no particular name there is required. A run removes leftovers of dead runs in all
//! of these directories; with `$BLADEOFF_RUNTIME_DIR` set, only there.

use std::ffi::OsStr;
use std::fs::{self, DirBuilder, File, OpenOptions, Permissions};
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::OFlags;

use crate::domain_error::DomainError;
use crate::names::{ID_LENGTH, LONGEST_ADDRESS, PRODUCT, REFUSED_SIGNS, is_id, prefix_of};
use bladeoff_system::files::FileError;

pub use crate::names::RUNTIME_VARIABLE;

/// A directory that contains the roots of runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Base {
    pub dir: PathBuf,
    /// Text before the id in the name of a root.
    before: String,
}

impl Base {
    /// A directory that the user has chosen, created if it is missing.
    ///
    /// # Errors
    /// The path is relative or too long, or has a rejected character; the directory belongs to another user or is open to others.
    pub fn given(dir: &Path) -> Result<Self, DomainError> {
        let base = Self { dir: dir.to_owned(), before: String::new() };
        if !dir.is_absolute() {
            return Err(DomainError::BaseRelative { path: dir.to_owned() });
        }
        base.check_name()?;
        make(dir)?;
        check(dir)?;
        Ok(base)
    }

    /// A directory with a name reserved for this user, created if it is missing, then set to mode 0700.
    fn own(dir: PathBuf) -> Result<Self, DomainError> {
        let base = Self { dir, before: String::new() };
        base.check_name()?;
        make(&base.dir)?;
        let named = named(&base.dir).map_err(FileError::at("open", &base.dir))?;
        let found = named.metadata().map_err(FileError::at("read", &base.dir))?;
        if found.uid() == uid() && found.mode() & 0o777 != 0o700 {
            // Set through the handle, because another user's file could have the name by now.
            let handle = format!("/proc/self/fd/{}", named.as_raw_fd());
            let made_ours = fs::set_permissions(handle, Permissions::from_mode(0o700));
            made_ours.map_err(FileError::at("set the permissions of", &base.dir))?;
        }
        check(&base.dir)?;
        Ok(base)
    }

    /// Root of the run with this id.
    pub fn root(&self, id: &str) -> PathBuf {
        self.dir.join(format!("{}{id}", self.before))
    }

    /// Id of the run, from the name of its root.
    pub fn id_of<'a>(&self, name: &'a OsStr) -> Option<&'a str> {
        name.to_str()?.strip_prefix(&self.before).filter(|id| is_id(id))
    }

    /// Rejects characters that the transport rejects, and paths that are too long for a socket's name.
    fn check_name(&self) -> Result<(), DomainError> {
        let refused = || REFUSED_SIGNS.bytes().filter(|byte| *byte != b' ');
        let is_refused = |byte: &u8| !matches!(byte, b' '..=b'~') || refused().any(|refused| refused == *byte);
        if let Some(byte) = self.dir.as_os_str().as_bytes().iter().find(|byte| is_refused(byte)) {
            let sign = match byte {
                b' '..=b'~' => format!("{:?}", char::from(*byte)),
                0x80.. => "a sign that is not ASCII".to_owned(),
                _ => format!("the control character 0x{byte:02x}"),
            };
            return Err(DomainError::BaseSigns { path: self.dir.clone(), sign });
        }
        let id = "0".repeat(ID_LENGTH);
        let length = self.root(&id).as_os_str().len() + prefix_of(&id).len();
        if length > LONGEST_ADDRESS {
            return Err(DomainError::PathTooLong { path: self.root(&id), length });
        }
        Ok(())
    }
}

/// Base directory of a new run, and the directories in which leftovers of dead runs are removed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Runtime {
    pub base: Base,
    pub swept: Vec<Base>,
}

impl Runtime {
    /// Chooses the directories from the environment.
    ///
    /// # Errors
    /// `$BLADEOFF_RUNTIME_DIR` is invalid, or nothing can be created in /tmp.
    pub fn find() -> Result<Self, DomainError> {
        let named = |name| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        match named(RUNTIME_VARIABLE) {
            Some(dir) => Self::within(&dir),
            None => Self::choose(named("XDG_RUNTIME_DIR").as_deref(), Path::new("/tmp")),
        }
    }

    /// Uses this directory for everything.
    ///
    /// # Errors
    /// As [`Base::given`].
    pub fn within(dir: &Path) -> Result<Self, DomainError> {
        let base = Base::given(dir)?;
        Ok(Self { swept: vec![base.clone()], base })
    }

    fn choose(runtime: Option<&Path>, tmp: &Path) -> Result<Self, DomainError> {
        let ours = format!("{PRODUCT}-{}", uid());
        let of_session = runtime
            .filter(|dir| dir.is_absolute() && check(dir).is_ok())
            .and_then(|dir| Base::own(dir.join(PRODUCT)).ok());
        let in_tmp = Base::own(tmp.join(&ours));
        let for_itself = Base { dir: tmp.to_owned(), before: format!("{ours}-") };
        let base = match (&of_session, &in_tmp) {
            (Some(base), _) | (None, Ok(base)) => base.clone(),
            // Another user's directory, a link, or not a directory: the name is taken.
            (None, Err(DomainError::BaseUnsafe { .. } | DomainError::File(_))) => for_itself.clone(),
            (None, Err(_)) => return in_tmp.map(|base| Self { swept: Vec::new(), base }),
        };
        let swept = of_session.into_iter().chain(in_tmp).chain([for_itself]).collect();
        Ok(Self { base, swept })
    }
}

fn uid() -> u32 {
    rustix::process::getuid().as_raw()
}

fn make(dir: &Path) -> Result<(), FileError> {
    match make_closed(dir) {
        Err(source) if source.kind() != io::ErrorKind::AlreadyExists => Err(FileError::at("create", dir)(source)),
        _ => Ok(()),
    }
}

/// Creates a directory for this user alone. The mode is set again afterwards, because iceoryx2 changes the umask of the process while another
/// thread creates a socket.
pub(crate) fn make_closed(dir: &Path) -> io::Result<()> {
    DirBuilder::new().mode(0o700).create(dir)?;
    fs::set_permissions(dir, Permissions::from_mode(0o700))
}

/// Opens a directory, but not through a symbolic link.
pub(crate) fn open(dir: &Path) -> io::Result<File> {
    OpenOptions::new().read(true).custom_flags((OFlags::DIRECTORY | OFlags::NOFOLLOW).bits() as i32).open(dir)
}

/// Opens a directory without reading it (`O_PATH`), but not through a symbolic link; works without read permission.
fn named(dir: &Path) -> io::Result<File> {
    let flags = OFlags::PATH | OFlags::DIRECTORY | OFlags::NOFOLLOW;
    OpenOptions::new().read(true).custom_flags(flags.bits() as i32).open(dir)
}

/// Checks that a path is a directory of this user with mode 0700.
fn check(dir: &Path) -> Result<(), DomainError> {
    let found = fs::symlink_metadata(dir).map_err(FileError::at("read", dir))?;
    let (owner, mode) = (found.uid(), found.mode() & 0o777);
    if found.is_dir() && owner == uid() && mode == 0o700 {
        return Ok(());
    }
    let kind = match found.file_type() {
        kind if kind.is_symlink() => "a symbolic link",
        kind if kind.is_dir() => "a directory",
        _ => "no directory",
    };
    Err(DomainError::BaseUnsafe { path: dir.to_owned(), uid: uid(), kind, owner, mode })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> tempfile::TempDir {
        let closed = std::os::unix::fs::PermissionsExt::from_mode(0o700);
        tempfile::Builder::new().prefix("bo").permissions(closed).tempdir_in("/tmp").expect("temporary directory")
    }

    fn chosen(runtime: Option<&Path>, tmp: &Path) -> PathBuf {
        Runtime::choose(runtime, tmp).expect("a place").base.root("0123456789")
    }

    #[test]
    fn the_sessions_directory_is_taken_where_it_is_what_it_should_be() {
        let (session, tmp) = (folder(), folder());
        let in_tmp = tmp.path().join(format!("bladeoff-{}/0123456789", uid()));
        assert_eq!(chosen(None, tmp.path()), in_tmp);
        assert_eq!(chosen(Some(session.path()), tmp.path()), session.path().join("bladeoff/0123456789"));
        // Each is invalid: relative, missing, a link, too long, or open to others.
        let link = tmp.path().join("link");
        std::os::unix::fs::symlink(session.path(), &link).expect("linked");
        let long = session.path().join("a-name-that-takes-more-than-sockets-allow");
        fs::create_dir(&long).expect("created");
        fs::set_permissions(&long, Permissions::from_mode(0o700)).expect("closed");
        for runtime in [Path::new("run"), &session.path().join("nowhere"), &link, &long] {
            assert_eq!(chosen(Some(runtime), tmp.path()), in_tmp, "{}", runtime.display());
        }
        fs::set_permissions(session.path(), Permissions::from_mode(0o755)).expect("opened");
        assert_eq!(chosen(Some(session.path()), tmp.path()), in_tmp);
    }

    #[test]
    fn a_name_in_tmp_that_somebody_has_taken_stops_nobody() {
        let tmp = folder();
        let name = tmp.path().join(format!("bladeoff-{}", uid()));
        let for_itself = tmp.path().join(format!("bladeoff-{}-0123456789", uid()));
        fs::write(&name, b"").expect("written");
        assert_eq!(chosen(None, tmp.path()), for_itself);
        fs::remove_file(&name).expect("removed");
        std::os::unix::fs::symlink("/", &name).expect("linked");
        assert_eq!(chosen(None, tmp.path()), for_itself);
        fs::remove_file(&name).expect("removed");
        if uid() == 0 {
            fs::create_dir(&name).expect("created");
            std::os::unix::fs::chown(&name, Some(65_534), None).expect("given away");
            assert_eq!(chosen(None, tmp.path()), for_itself);
            assert_eq!(fs::metadata(&name).expect("there").uid(), 65_534, "it is left as it was");
            fs::remove_dir(&name).expect("removed");
        }
        let base = Runtime::choose(None, tmp.path()).expect("a place").base;
        assert_eq!(base.id_of(OsStr::new("0123456789")), Some("0123456789"));
        assert_eq!(fs::metadata(&base.dir).expect("made").mode() & 0o777, 0o700);
    }

    #[test]
    fn our_own_directory_is_made_ours_again() {
        let tmp = folder();
        let own = tmp.path().join(format!("bladeoff-{}", uid()));
        fs::create_dir(&own).expect("created");
        for mode in [0o500, 0o000, 0o300, 0o755, 0o777] {
            fs::set_permissions(&own, Permissions::from_mode(mode)).expect("set");
            assert_eq!(chosen(None, tmp.path()), own.join("0123456789"), "{mode:o}");
            assert_eq!(fs::metadata(&own).expect("there").mode() & 0o777, 0o700, "{mode:o}");
        }
    }

    #[test]
    fn a_name_that_the_transport_does_not_take_is_refused_with_what_is_allowed() {
        let dir = folder();
        for (name, sign) in [
            ("a\"b".as_bytes(), "'\"'"),
            (b"a*", "'*'"),
            (b"a\x01", "the control character 0x01"),
            (b"a\x7f", "the control character 0x7f"),
            (b"a\xff", "a sign that is not ASCII"),
            ("\u{e9}".as_bytes(), "a sign that is not ASCII"),
        ] {
            let named = dir.path().join(OsStr::from_bytes(name));
            let error = Runtime::within(&named).expect_err("refused");
            let words = error.to_string();
            assert!(matches!(error, DomainError::BaseSigns { .. }), "{words}");
            assert!(words.contains(RUNTIME_VARIABLE) && words.contains(sign) && words.contains("printable"), "{words}");
            assert!(words.chars().all(|sign| !sign.is_control()), "{words:?}");
            assert!(!named.exists());
            // A session's directory with such a name is not used.
            fs::DirBuilder::new().mode(0o700).create(&named).expect("created");
            let in_tmp = dir.path().join(format!("bladeoff-{}/0123456789", uid()));
            assert_eq!(chosen(Some(&named), dir.path()), in_tmp);
        }
        // Names that a shell must quote and the transport accepts.
        for name in ["a b", "a'b", "a\\b", "a:b", "$a;b"] {
            let domain = crate::domain::Domain::create_below(&dir.path().join(name), 1).expect(name);
            assert!(domain.close().is_empty());
        }
    }

    #[test]
    fn a_directory_that_was_named_is_used_or_refused_and_never_changed() {
        let dir = folder();
        let fresh = dir.path().join("b");
        let runtime = Runtime::within(&fresh).expect("made");
        assert_eq!((runtime.base.dir.as_path(), runtime.swept.len()), (fresh.as_path(), 1));
        fs::set_permissions(&fresh, Permissions::from_mode(0o755)).expect("opened");
        let error = Runtime::within(&fresh).expect_err("open to others");
        assert!(matches!(error, DomainError::BaseUnsafe { mode: 0o755, .. }), "{error}");
        assert_eq!(fs::metadata(&fresh).expect("there").mode() & 0o777, 0o755);
        fs::set_permissions(&fresh, Permissions::from_mode(0o500)).expect("closed to us, too");
        let error = Runtime::within(&fresh).expect_err("nothing could be made there");
        assert!(matches!(error, DomainError::BaseUnsafe { mode: 0o500, .. }), "{error}");
        assert!(matches!(Runtime::within(Path::new("b")), Err(DomainError::BaseRelative { .. })));
        let long = dir.path().join("a-name-that-takes-more-than-the-socket-path-allows");
        assert!(matches!(Runtime::within(&long), Err(DomainError::PathTooLong { .. })) && !long.exists());
    }
}
