//! Tests of file checks by a place, and of replacing files.

use super::*;
use crate::folder::Folder;
use std::os::unix::fs::symlink;
use std::os::unix::net::UnixListener;

fn reason(error: &FileError) -> String {
    error.source.to_string()
}

#[test]
fn only_regular_files_are_opened_and_nothing_is_waited_for() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let folder = Folder::open(directory.path()).expect("opened");
    std::fs::write(directory.path().join("whole"), b"0123456789").expect("written");
    assert_eq!(folder.place("whole").read(10).expect("read"), b"0123456789");
    let error = folder.place("whole").read(9).expect_err("too large");
    assert_eq!(reason(&error), "it has 10 bytes; at most 9 are read");
    symlink("whole", directory.path().join("link")).expect("linked");
    symlink("nowhere", directory.path().join("broken")).expect("linked");
    std::fs::create_dir(directory.path().join("folder")).expect("created");
    let _socket = UnixListener::bind(directory.path().join("socket")).expect("bound");
    fs::mknodat(CWD, directory.path().join("pipe"), FileType::Fifo, Mode::RWXU, 0).expect("made");
    for (name, why) in [
        ("link", "symbolic link"),
        ("broken", "symbolic link"),
        ("folder", "a directory"),
        ("socket", "a socket"),
        ("pipe", "a named pipe"),
    ] {
        let place = folder.place(name);
        assert!(place.exists() && !place.is_file());
        for opened in [place.open(), place.open_own(), place.open_or_create(), place.append()] {
            let error = opened.expect_err("not a file");
            assert!(reason(&error).contains(why), "{name}: {}", reason(&error));
        }
        assert!(place.create_new().is_err() && place.exists(), "{name} is not removed");
    }
    assert_eq!(std::fs::read(directory.path().join("whole")).expect("there"), b"0123456789");
    assert!(!directory.path().join("nowhere").exists());
    // A link is followed if the user names it.
    symlink("whole", directory.path().join("named")).expect("linked");
    assert_eq!(Place::named(&directory.path().join("named")).read_checked(10).expect("read"), b"0123456789");
    assert!(Place::named(Path::new("/dev/zero")).read_checked(10).is_err());
}

#[test]
fn what_has_another_name_is_not_written_in_place() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let folder = Folder::open(directory.path()).expect("opened");
    std::fs::write(directory.path().join("mine"), b"mine").expect("written");
    std::fs::hard_link(directory.path().join("mine"), directory.path().join("log")).expect("linked");
    let place = folder.place("log");
    for opened in [place.open_own(), place.open_or_create(), place.append()] {
        assert!(reason(&opened.expect_err("two names")).contains("2 hard links"));
    }
    assert_eq!(std::fs::read(directory.path().join("mine")).expect("there"), b"mine");
}

#[test]
fn what_may_be_locked_is_closed_to_others_from_its_making_and_when_it_is_opened_again() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    let directory = tempfile::tempdir().expect("temporary directory");
    let folder = Folder::open(directory.path()).expect("opened");
    let mode = |name: &str| std::fs::metadata(directory.path().join(name)).expect("there").mode() & 0o777;
    folder.place("lock").open_or_create().expect("made");
    folder.place("record").create_closed().expect("made");
    assert_eq!((mode("lock"), mode("record")), (0o600, 0o600));
    // The mode that earlier builds set.
    let open = std::fs::Permissions::from_mode(0o664);
    std::fs::set_permissions(directory.path().join("lock"), open).expect("opened to others");
    folder.place("lock").open_or_create().expect("opened");
    assert_eq!(mode("lock"), 0o600);
    folder.place("log").append().expect("made");
    assert_eq!(mode("log") & 0o600, 0o600);
}
