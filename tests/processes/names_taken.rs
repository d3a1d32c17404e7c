//! Another user watches /dev/shm and occupies the names of a run as soon as its first file reveals them.

use std::collections::BTreeSet;
use std::mem::MaybeUninit;
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
use std::os::unix::process::CommandExt;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::support::Folder;
use crate::support::processes::{STUDY, wait_until};
use crate::support::skipped::skipped;
use crate::workers::OWN_UMASK;
use rustix::fs::inotify::{self, CreateFlags, Reader, WatchFlags};

/// A user id that is not in use.
const NOBODY: u32 = 54_322;
/// Ending of the first file of a run in /dev/shm, and of the first file of iceoryx2.
const OWNER: &str = "_owner";
const COUNTER: &str = ".global_mgmt";
const SHM: &str = "/dev/shm";
/// Largest number of runs until a name was occupied in time, which happens in about every second run.
const RUNS: usize = 30;

/// Calls `see` with every name created in /dev/shm, until `is_over`; `watches` is set before the first.
fn watch(watches: &AtomicBool, is_over: &AtomicBool, mut see: impl FnMut(&str)) {
    let watcher = inotify::init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC).expect("inotify");
    inotify::add_watch(&watcher, SHM, WatchFlags::CREATE | WatchFlags::MOVED_TO).expect("watched");
    watches.store(true, Ordering::Relaxed);
    let mut buffer = [MaybeUninit::uninit(); 4096];
    let mut events = Reader::new(watcher, &mut buffer);
    while !is_over.load(Ordering::Relaxed) {
        match events.next() {
            Ok(event) => {
                if let Some(name) = event.file_name().and_then(|name| name.to_str().ok()) {
                    see(name);
                }
            }
            Err(rustix::io::Errno::WOULDBLOCK) => std::hint::spin_loop(),
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn whoever_takes_the_names_of_a_run_does_not_stop_it() {
    if std::fs::metadata("/proc/self").expect("Linux").uid() != 0 {
        return skipped("names taken in /dev/shm", "takes root, to be somebody else");
    }
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let own = |name: &str, mode| {
        std::fs::set_permissions(folder.path(name), std::fs::Permissions::from_mode(mode)).expect("set");
    };
    crate::support::copy_binary(&folder.path("bladeoff"));
    ["", "machines", "bladeoff"].iter().for_each(|name| own(name, 0o755));
    for (name, mode) in [("home", 0o755), ("r", 0o700)] {
        std::fs::create_dir(folder.path(name)).expect("created");
        own(name, mode);
        chown(folder.path(name), Some(NOBODY), Some(NOBODY)).expect("given away");
    }
    let run = |out: usize| {
        let mut command = Command::new("sh");
        command.args(OWN_UMASK).arg(folder.path("bladeoff"));
        command.args(["run", &study, "--workers", "1", "--out"]).arg(folder.path(&format!("home/out{out}")));
        command.env("BLADEOFF_RUNTIME_DIR", folder.path("r")).current_dir(folder.path("home"));
        crate::support::said(command.uid(NOBODY).gid(NOBODY).output().expect("it starts"))
    };
    // part after the id of the occupied name
    let (watches, over) = (AtomicBool::new(false), AtomicBool::new(false));
    let behind = std::thread::scope(|scope| {
        let seen = scope.spawn(|| {
            let mut names = Vec::new();
            watch(&watches, &over, |name| names.push(name.to_owned()));
            names
        });
        wait_until("it watches", || watches.load(Ordering::Relaxed));
        let said = run(RUNS);
        over.store(true, Ordering::Relaxed);
        assert_eq!(said.code, 0, "{}", said.err);
        let names = seen.join().expect("watched");
        let of_run = |owner: &String| owner.strip_suffix("owner").map(str::to_owned);
        let prefixes: Vec<String> = names.iter().filter(|name| name.ends_with(OWNER)).filter_map(of_run).collect();
        let found = |name: &String| {
            let prefix = prefixes.iter().find(|prefix| name.starts_with(*prefix))?;
            name.ends_with(COUNTER).then(|| name[prefix.len()..].to_owned())
        };
        names.iter().find_map(found).expect("iceoryx2 makes its counter")
    });
    let mut taken = 0;
    for number in 0..RUNS {
        let (watches, over) = (AtomicBool::new(false), AtomicBool::new(false));
        let ids = std::thread::scope(|scope| {
            let attacker = scope.spawn(|| {
                let mut ids = BTreeSet::new();
                watch(&watches, &over, |name| {
                    let Some(prefix) = name.strip_suffix("owner").filter(|prefix| prefix.starts_with("bladeoff_"))
                    else {
                        return;
                    };
                    // only names of this run: other tests use other users
                    let owner = std::fs::symlink_metadata(format!("{SHM}/{name}"));
                    if owner.is_ok_and(|owner| owner.uid() == NOBODY) && ids.len() < 3 && ids.insert(prefix.to_owned())
                    {
                        let path = format!("{SHM}/{prefix}{behind}");
                        let fifo = rustix::fs::FileType::Fifo;
                        let _ = rustix::fs::mknodat(rustix::fs::CWD, path, fifo, 0o666.into(), 0);
                    }
                });
                ids
            });
            wait_until("it watches", || watches.load(Ordering::Relaxed));
            let said = run(number);
            over.store(true, Ordering::Relaxed);
            assert_eq!(said.code, 0, "{}", said.err);
            attacker.join().expect("watched")
        });
        for prefix in &ids {
            let _ = std::fs::remove_file(format!("{SHM}/{prefix}{behind}"));
        }
        // another name was tried: the first one was occupied in time
        taken += usize::from(ids.len() > 1);
        if taken > 1 {
            break;
        }
    }
    assert!(taken > 0, "no name was taken in time in {RUNS} runs");
}
