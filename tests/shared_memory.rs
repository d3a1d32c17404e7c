//! Shared memory of real runs: closed to others, there before it is needed, removed by whoever comes next.

mod support;

use std::collections::BTreeSet;
use std::io::Write;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use bladeoff::chaos::lives;
use bladeoff::dispatch::{self, Observer, Snapshot};
use support::workers::*;

/// Not a test by itself: started by tests.
#[test]
fn orchestrator_process() {
    be_orchestrator();
}

/// Everything a run has in /dev/shm and below its root.
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
    // The first batches take long enough to be seen.
    let run = Run::new(2, 50_000);
    let (mut table, mut observer) =
        (Table::default(), Looking { dir: run.dir.path().to_owned(), looks: 0, without_memory: 0 });
    dispatch::run(&run.options, &Numbers, SAMPLES, &mut table, &mut observer).expect("a run");
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
    // Of another run it is not touched as long as this one lives.
    Run::new(1, 0).play(1);
    assert!(memory() >= 10 && lives(orchestrator.id()));
    orchestrator.kill().expect("killed");
    orchestrator.wait().expect("a child");
    wait_until("workers leave", || workers.iter().all(|&pid| !lives(pid)));
    assert!(memory() >= 10 && !dir.path().join("ended").exists());
    Run::new(1, 0).play(1);
    assert_nothing_left(dir.path());
}

/// An orchestrator with a /dev/shm of its own, of 2 MB, removed when dropped; `None` where that is not allowed.
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
            // Past the harness, which shows only what failing tests say.
            let _ = writeln!(
                std::io::stderr(),
                "SKIPPED, not tested: a /dev/shm of its own takes root and `unshare --mount`"
            );
            return None;
        }
        Some(Self(own(orchestrate(dir, None)).spawn().expect("started")))
    }

    /// Takes all memory that is left.
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
        // Has ended, unless the test fails.
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
    orchestrator.fill();
    assert!(recorded(dir.path()).len() < SAMPLES as usize, "filled too late");
    wait_until("it ends", || orchestrator.has_ended());
    assert_eq!(std::fs::read_to_string(dir.path().join("ended")).expect("an orderly end"), "Complete");
    assert_eq!(recorded(dir.path()).into_iter().collect::<BTreeSet<_>>(), (0..SAMPLES).collect());
}

#[test]
fn a_worker_that_finds_no_shared_memory_says_so_and_the_run_ends_in_order() {
    let _alone = alone();
    // What the dead worker gives back may be taken by its replacement before it is by us: then the run is complete, in order too.
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
