//! Shared memory of real runs: inaccessible to other users, reserved before it is needed, removed by the next run; and errors of runs without
//! free threads or file descriptors.

use std::collections::BTreeSet;
use std::io::Write;
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::Folder;
use crate::support::processes::{STUDY, signal};
use crate::support::processes::{lives, state};
use crate::support::skipped::skipped;
use crate::workers::*;
use bladeoff::dispatch::{self, Observer, Snapshot};

/// Files of a run in /dev/shm and below its root.
fn files(root: &Path) -> Vec<PathBuf> {
    let prefix = format!("bladeoff_{}_", root.file_name().expect("an id").to_string_lossy());
    let mut all: Vec<PathBuf> = std::fs::read_dir("/dev/shm").expect("readable").flatten().map(|e| e.path()).collect();
    all.retain(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(&prefix)));
    let mut dirs = vec![root.to_owned()];
    while let Some(dir) = dirs.pop() {
        let inside: Vec<_> = std::fs::read_dir(&dir).into_iter().flatten().flatten().map(|e| e.path()).collect();
        dirs.extend(inside.iter().filter(|path| path.is_dir()).cloned());
        all.extend(inside);
        all.push(dir);
    }
    all
}

#[test]
fn no_file_of_a_run_is_open_to_others_and_all_of_its_memory_is_there() {
    let _alone = alone();
    struct Looking {
        dir: PathBuf,
        looks: usize,
        without_memory: usize,
    }
    impl Observer for Looking {
        fn progress(&mut self, snapshot: &Snapshot) {
            let is_busy = |worker: &dispatch::WorkerView| matches!(worker.activity, dispatch::Activity::Busy { .. });
            if snapshot.workers.len() < 2 || !snapshot.workers.iter().all(is_busy) {
                return;
            }
            let root = roots(&self.dir).pop().expect("a root");
            let found: Vec<_> = files(&root).into_iter().filter_map(|p| Some((p.metadata().ok()?, p))).collect();
            for (metadata, path) in &found {
                assert_eq!(metadata.mode() & 0o077, 0, "{} is open to others: {:o}", path.display(), metadata.mode());
            }
            let is_memory = |path: &Path| path.starts_with("/dev/shm");
            assert!(found.iter().filter(|(_, path)| is_memory(path)).count() >= 10);
            assert!(found.iter().filter(|(_, path)| path.starts_with(&root)).count() >= 10);
            let has_memory = |metadata: &std::fs::Metadata| metadata.blocks() * 512 >= metadata.len();
            self.without_memory += found.iter().filter(|(m, path)| is_memory(path) && !has_memory(m)).count();
            self.looks += 1;
        }
    }
    // the first batches take long enough to be observed
    let run = Run::new(2, 50_000);
    let (mut table, mut observer) =
        (Table::default(), Looking { dir: run.dir.path().to_owned(), looks: 0, without_memory: 0 });
    let report = dispatch::run(&run.options, &Numbers, SAMPLES, &mut table, &mut observer).expect("a run");
    dispatch::give_back(report.memory, &mut observer);
    assert!(observer.looks > 0 && observer.without_memory == 0, "{}, {}", observer.looks, observer.without_memory);
    assert_nothing_left(run.dir.path());
}

#[test]
fn memory_of_a_killed_run_is_removed_when_its_root_is_gone() {
    let _alone = alone();
    let dir = tempfile::tempdir().expect("temporary directory");
    let mut orchestrator = orchestrate(dir.path(), None).spawn().expect("started");
    wait_until("it works", || !recorded(dir.path()).is_empty());
    let workers = children(orchestrator.id());
    let root = roots(dir.path()).pop().expect("a root");
    std::fs::remove_dir_all(&root).expect("removed");
    let memory = || files(&root).iter().filter(|path| path.starts_with("/dev/shm")).count();
    // another run does not touch the files of a live one
    Run::new(1, 0).play(1);
    assert!(memory() >= 10 && lives(orchestrator.id()));
    orchestrator.kill().expect("killed");
    orchestrator.wait().expect("a child");
    wait_until("workers leave", || workers.iter().all(|&pid| !lives(pid)));
    assert!(memory() >= 10 && !dir.path().join("ended").exists());
    Run::new(1, 0).play(1);
    assert_nothing_left(dir.path());
}

/// An orchestrator with its own /dev/shm of 2 MB, removed when dropped; `None` if that is not permitted.
struct SmallMemory(std::process::Child);

impl SmallMemory {
    fn orchestrate(dir: &Path) -> Option<Self> {
        let mount = "mount -t tmpfs -o size=2m,mode=1777 tmpfs /dev/shm && exec \"$@\"";
        let own = |command: Command| {
            let mut unshare = Command::new("unshare");
            unshare.args(["--mount", "sh", "-c", mount, "sh"]).arg(command.get_program()).args(command.get_args());
            unshare.envs(command.get_envs().filter_map(|(key, value)| Some((key, value?))));
            unshare
        };
        if !own(Command::new("true")).output().is_ok_and(|output| output.status.success()) {
            skipped("runs in a /dev/shm that fills up", "takes root and `unshare --mount`");
            return None;
        }
        Some(Self(own(orchestrate(dir, None)).spawn().expect("started")))
    }

    /// Fills the remaining shared memory.
    fn fill(&self) {
        let path = format!("/proc/{}/root/dev/shm/filler", self.0.id());
        let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
        while file.as_ref().is_ok_and(|mut file| file.write_all(&[0; 4096]).is_ok()) {}
    }

    fn has_ended(&mut self) -> bool {
        self.0.try_wait().expect("a child").is_some()
    }
}

impl Drop for SmallMemory {
    fn drop(&mut self) {
        // already ended, unless the test fails
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_run_under_way_does_not_mind_that_shared_memory_fills_up() {
    let _alone = alone();
    let dir = tempfile::tempdir().expect("temporary directory");
    let Some(mut orchestrator) = SmallMemory::orchestrate(dir.path()) else { return };
    wait_until("it works", || !recorded(dir.path()).is_empty());
    let pid = orchestrator.0.id();
    assert!(signal(pid, "STOP"));
    wait_until("it is stopped", || state(pid) == Some('T'));
    assert!(recorded(dir.path()).len() < SAMPLES as usize, "stopped too late");
    orchestrator.fill();
    assert!(signal(pid, "CONT"));
    wait_until("it ends", || orchestrator.has_ended());
    assert_eq!(std::fs::read_to_string(dir.path().join("ended")).expect("an orderly end"), "Complete");
    assert_eq!(recorded(dir.path()).into_iter().collect::<BTreeSet<_>>(), (0..SAMPLES).collect());
}

#[test]
fn a_worker_that_finds_no_shared_memory_says_so_and_the_run_ends_in_order() {
    let _alone = alone();
    // the replacement may take the memory that the dead worker freed before the test does: then the run is complete, and that is correct
    let found = (0..20).any(|_| {
        let dir = tempfile::tempdir().expect("temporary directory");
        let Some(mut orchestrator) = SmallMemory::orchestrate(dir.path()) else { return true };
        wait_until("it works", || !recorded(dir.path()).is_empty());
        let first = *children(orchestrator.0.id()).first().expect("a worker");
        orchestrator.fill();
        assert!(Command::new("kill").args(["-KILL", &first.to_string()]).status().expect("kill runs").success());
        wait_until("it ends", || {
            orchestrator.fill();
            orchestrator.has_ended()
        });
        let ended = std::fs::read_to_string(dir.path().join("ended")).expect("an orderly end");
        assert!(ended == "Complete" || ended.contains("/dev/shm is full"), "{ended}");
        ended != "Complete"
    });
    assert!(found, "every replacement found memory");
}

/// A user id that is not in use.
const NOBODY: u32 = 54_321;

/// A folder in which that user has a study, the program and a `home`; `None` if the test cannot run as another user.
fn folder_of_nobody(what: &str) -> Option<(Folder, String)> {
    if std::fs::metadata("/proc/self").expect("Linux").uid() != 0 {
        skipped(what, "takes root, to be somebody else");
        return None;
    }
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let set = |name: &str, mode| {
        std::fs::set_permissions(folder.path(name), std::fs::Permissions::from_mode(mode)).expect("set");
    };
    crate::support::copy_binary(&folder.path("bladeoff"));
    ["", "machines", "bladeoff"].iter().for_each(|name| set(name, 0o755));
    for (name, mode) in [("home", 0o755), ("r", 0o700)] {
        std::fs::create_dir(folder.path(name)).expect("created");
        set(name, mode);
        chown(folder.path(name), Some(NOBODY), Some(NOBODY)).expect("given away");
    }
    Some((folder, study))
}

/// A process that is killed when dropped.
struct Ending(std::process::Child);

impl Drop for Ending {
    fn drop(&mut self) {
        // already ended, unless the test fails
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn what_others_make_in_shared_memory_costs_no_run_its_table() {
    let _alone = alone();
    let Some((folder, study)) = folder_of_nobody("what other users do in /dev/shm") else { return };
    let (out, fired, log) = (folder.name("home/out"), folder.name("home/fired"), folder.path("log"));
    std::fs::create_dir(&fired).expect("created");
    chown(&fired, Some(NOBODY), None).expect("given away");
    // in its own /dev/shm: a FIFO of another user there blocked every run of earlier builds
    let script = "mount -t tmpfs -o size=16m,mode=1777 tmpfs /dev/shm && mkfifo -m 666 /dev/shm/bladeoff_cccccccccc_owner && \
                  umask 022 && exec setpriv --reuid 54321 --regid 54321 --clear-groups \"$@\"";
    let mut command = Command::new("unshare");
    command.args(["--mount", "sh", "-c", script, "sh"]).arg(folder.path("bladeoff"));
    command.args(["run", &study, "--out", &out, "--workers", "2"]).current_dir(folder.path("home"));
    command.env("BLADEOFF_RUNTIME_DIR", folder.path("r"));
    command.env("BLADEOFF_FAULT", format!("who=orchestrator,at=recorded,sample=any,do=stop,dir={fired}"));
    let log_file = std::fs::File::create(&log).expect("created");
    let mut run = Ending(command.stderr(log_file).stdout(std::process::Stdio::null()).spawn().expect("started"));
    let said = || std::fs::read_to_string(&log).expect("readable");
    let mut status = None;
    wait_until("it stops in the middle, or cannot mount", || {
        status = run.0.try_wait().expect("a child");
        status.is_some() || state(run.0.id()) == Some('T')
    });
    if said().contains("unshare") || said().contains("mount:") {
        return skipped("what other users do in /dev/shm", "takes `unshare --mount`");
    }
    assert!(status.is_none(), "{status:?}: {}", said());
    let root = roots(Path::new(&out)).pop().expect("a root");
    assert!(root.starts_with(folder.path("r")), "{}", root.display());
    let id = root.file_name().expect("an id").to_string_lossy();
    let shm = PathBuf::from(format!("/proc/{}/root/dev/shm", run.0.id()));
    assert!(shm.join(format!("bladeoff_{id}_owner")).exists());
    // names that sort first and last
    for name in ["0_foreign", "zz_foreign"] {
        std::fs::write(shm.join(format!("bladeoff_{id}_{name}")), b"x").expect("written");
    }
    let fifo = rustix::fs::FileType::Fifo;
    let pipe = shm.join(format!("bladeoff_{id}_pipe"));
    rustix::fs::mknodat(rustix::fs::CWD, &pipe, fifo, 0o666.into(), 0).expect("a FIFO");
    // the run stops once for every sample
    wait_until("it ends", || {
        if state(run.0.id()) == Some('T') {
            assert!(signal(run.0.id(), "CONT"));
        }
        status = run.0.try_wait().expect("a child");
        status.is_some()
    });
    assert_eq!(status.and_then(|status| status.code()), Some(0), "{}", said());
    assert!(Path::new(&out).join("results.parquet").exists() && !root.exists());
    let left = said().matches("is left: it belongs to user 0, who made it during the run").count();
    assert_eq!(left, 3, "{}", said());
}

/// Output of a run of that user with this resource limit.
fn run_limited(folder: &Folder, study: &str, limit: &str) -> crate::support::Said {
    let out = tempfile::tempdir_in(folder.path("home")).expect("a folder");
    std::fs::set_permissions(out.path(), std::fs::Permissions::from_mode(0o700)).expect("set");
    chown(out.path(), Some(NOBODY), Some(NOBODY)).expect("given away");
    let out = out.path().join("out");
    let mut command = Command::new("sh");
    command
        .args(OWN_UMASK)
        .args(["prlimit", limit])
        .arg(folder.path("bladeoff"))
        .args(["run", study, "--workers", "2", "--out"])
        .arg(&out);
    command.env("BLADEOFF_RUNTIME_DIR", folder.path("r")).current_dir(folder.path("home"));
    let said = crate::support::said(command.uid(NOBODY).gid(NOBODY).output().expect("it starts"));
    assert!(!said.err.contains("internal error") && !said.err.contains("InternalError"), "{limit}: {}", said.err);
    assert!(said.code == 0 || said.code == 6, "{limit}: {}: {}", said.code, said.err);
    said
}

#[test]
fn whoever_may_start_no_threads_is_told_so() {
    let _alone = alone();
    let Some((folder, study)) = folder_of_nobody("limits on processes and threads") else { return };
    let mut refused = 0;
    for processes in 1..=9 {
        let said = run_limited(&folder, &study, &format!("--nproc={processes}"));
        // the system's message, or its explanation if the threads of Polars are the first that cannot start
        let names_cause =
            ["Resource temporarily unavailable", "(ulimit -u"].iter().any(|cause| said.err.contains(cause));
        assert!(said.code == 0 || names_cause, "{processes}: {}", said.err);
        refused += u32::from(said.code == 6);
    }
    assert!(refused >= 4, "{refused}");
}

#[test]
fn whoever_may_open_no_files_is_told_so() {
    let _alone = alone();
    let Some((folder, study)) = folder_of_nobody("limits on open files") else { return };
    for files in [8, 12, 16, 24, 32, 48, 60] {
        let said = run_limited(&folder, &study, &format!("--nofile={files}"));
        let names_cause = ["Too many open files", "(ulimit -n)"].iter().any(|cause| said.err.contains(cause));
        assert!(said.code == 6 && names_cause, "{files}: {}", said.err);
    }
    // a soft limit that may be raised is raised
    assert_eq!(run_limited(&folder, &study, "--nofile=40:4096").code, 0);
}
