//! Several users of one host: a user with read permission cannot block a run with a lock, gets the public part of its status, and cannot resume
//! it; the holder of a lock is named.

use crate::running::{PAUSE, Running, STUDY, handed_out, signal, wait_until};
use crate::support::skipped::skipped;
use crate::support::{Folder, RUNTIME_VARIABLE, Said, alone, bladeoff, said, say};
use std::fs::{self, Permissions};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt, chown};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A user id that is not in use.
const OTHER: u32 = 54_323;

fn set(path: &Path, mode: u32) {
    fs::set_permissions(path, Permissions::from_mode(mode)).expect("set");
}

fn mode(path: &Path) -> u32 {
    fs::metadata(path).expect("there").mode() & 0o777
}

/// Another user, with a readable copy of the program, and a folder and sockets of their own.
struct Other {
    folder: Folder,
    study: String,
    out: PathBuf,
}

impl Other {
    /// Prepares the other user; `None`, with a report, if the test cannot run as another user.
    fn new(what: &str) -> Option<Self> {
        if fs::metadata("/proc/self").expect("Linux").uid() != 0 {
            skipped(what, "takes root, to be somebody else");
            return None;
        }
        let folder = Folder::new();
        let study = folder.write("s.toml", &STUDY.replace("0.1 s", "0.02 s"));
        crate::support::copy_binary(&folder.path("bladeoff"));
        ["", "machines", "bladeoff"].iter().for_each(|name| set(&folder.path(name), 0o755));
        for name in ["home", "r"] {
            fs::DirBuilder::new().mode(0o700).create(folder.path(name)).expect("created");
            chown(folder.path(name), Some(OTHER), Some(OTHER)).expect("given away");
        }
        let out = folder.path("out");
        Some(Self { folder, study, out })
    }

    fn out(&self) -> &str {
        self.out.to_str().expect("UTF-8")
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(self.folder.path("bladeoff"));
        command.args(args).current_dir(self.folder.path("home")).env(RUNTIME_VARIABLE, self.folder.path("r"));
        command.env_remove("BLADEOFF_FAULT").uid(OTHER).gid(OTHER);
        command
    }

    /// Runs a command as the other user.
    fn say(&self, args: &[&str]) -> Said {
        said(self.command(args).output().expect("it starts"))
    }

    fn status(&self) -> serde_json::Value {
        let said = self.say(&["status", self.out(), "--json"]);
        assert_eq!(said.code, 0, "{}", said.err);
        serde_json::from_str(&said.out).expect("JSON")
    }

    /// Whether the other user can take a shared lock on a file.
    fn locks(&self, name: &str) -> bool {
        let mut command = Command::new("flock");
        command.args(["--shared", "--nonblock"]).arg(self.out.join(name)).arg("true");
        command.uid(OTHER).gid(OTHER).output().expect("flock runs").status.success()
    }
}

#[test]
fn who_may_read_a_run_cannot_lock_it() {
    let _alone = alone();
    let Some(other) = Other::new("locks of other users") else { return };
    let run = || say(&["run", &other.study, "--out", other.out(), "--workers", "2"]);
    assert_eq!(run().code, 0);
    for name in ["run.lock", "ledger.redb"] {
        assert!(mode(&other.out.join(name)) == 0o600 && !other.locks(name), "{name}");
    }
    assert!(mode(&other.out.join("results.parquet")) == 0o644 && other.locks("results.parquet"));
    // file modes of earlier builds
    for name in ["run.lock", "ledger.redb"] {
        set(&other.out.join(name), 0o644);
        assert!(other.locks(name), "{name}");
    }
    assert!(run().err.contains("every sample is already finished"));
    for name in ["run.lock", "ledger.redb"] {
        assert!(mode(&other.out.join(name)) == 0o600 && !other.locks(name), "{name}");
    }
}

#[test]
fn who_reads_a_complete_run_of_somebody_else_is_told_all_of_it() {
    let _alone = alone();
    let Some(other) = Other::new("what other users are told") else { return };
    let made = say(&["run", &other.study, "--out", other.out(), "--workers", "2"]);
    assert_eq!(made.code, 0, "{}", made.err);
    let said = other.say(&["status", other.out(), "--verify"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.contains("state      complete\n"), "{}", said.out);
    assert!(said.out.contains("done       20 of 20 samples (100.0 %)\n"), "{}", said.out);
    assert!(said.out.contains("its user alone may read it"), "{}", said.out);
    assert!(!said.out.contains("damaged") && !said.out.contains("killed"), "{}", said.out);
    assert_eq!(other.status()["state"], "complete");
    let why = other.say(&["why", other.out(), "3"]);
    assert!(why.code == 0 && why.out.contains("of 20 in "), "{}{}", why.out, why.err);
    assert_eq!(other.say(&["export", other.out(), "--csv"]).out.lines().count(), 21);
    let replay = other.say(&["replay", other.out(), "--sample", "3"]);
    assert!(replay.code == 0 && replay.out.contains("bit for bit"), "{}{}", replay.out, replay.err);
    // nothing is left to compute; otherwise the other user may not compute it
    let run = ["run", &other.study, "--out", other.out(), "--workers", "1"];
    let again = other.say(&run);
    assert!(again.code == 0 && again.err.contains("every sample is already finished"), "{}", again.err);
    let (table, away) = (other.out.join("results.parquet"), other.folder.path("away"));
    fs::rename(&table, &away).expect("renamed");
    let refused = other.say(&run);
    assert!(refused.code == 3 && refused.err.contains("contains a run of another user (uid 0)"), "{}", refused.err);
    fs::rename(&away, &table).expect("renamed");
    // for an inaccessible directory only that is reported
    for closed in [0o700, 0o744] {
        set(&other.out, closed);
        for words in
            [vec!["status"], vec!["why", "3", "--dir"], vec!["export", "--csv"], vec!["replay", "--sample", "3"]]
        {
            let said = other.say(&[&words[..], &[other.out()]].concat());
            assert!(said.code == 6 && said.err.contains("Permission denied"), "{closed:o} {words:?}: {}", said.err);
        }
    }
}

#[test]
fn of_a_run_whose_lock_is_closed_nothing_is_claimed_that_is_not_known() {
    let _alone = alone();
    let Some(other) = Other::new("what other users are told of a run under way") else { return };
    let fault = |place, what| format!("who=orchestrator,at=recorded,sample={},do={what}", handed_out(20, place));
    let faults = format!("{PAUSE};{};{}", fault(3, "stop"), fault(15, "kill"));
    let mut run = Running::start_with(&other.folder, &other.study, other.out(), &faults, &["--refresh", "0.01"]);
    wait_until("the first fault", || run.fired() > 0);
    wait_until("it is stopped", || other.status()["state"] == "stopped");
    assert_eq!(other.status()["pid"], run.child.id(), "the kernel says that it has the lock");
    let refused = other.say(&["run", &other.study, "--out", other.out(), "--workers", "1"]);
    assert!(refused.code == 3 && refused.err.contains(&format!("process {} (", run.child.id())), "{}", refused.err);
    assert!(signal(run.child.id(), "CONT"));
    assert_eq!((run.end().signal(), run.fired()), (Some(9), 2), "{}", run.said());
    // the last report says that the run is in progress
    let seen = other.status();
    assert_eq!((&seen["state"], &seen["last_state"]), (&"unknown".into(), &"running".into()), "{seen}");
    assert!(seen["unknown"].as_str().is_some_and(|why| why.contains("only its owner (uid 0)")), "{seen}");
    let said = other.say(&["status", other.out(), "--verify"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let line =
        "state      unknown whether a run is alive: only its owner (uid 0) can read run.lock; its last message, at 20";
    assert!(said.out.contains(line) && said.out.contains("done       at least "), "{}", said.out);
    for word in ["killed", "interrupted", "did not end", "resume ", "damaged"] {
        assert!(!said.out.contains(word), "{word}: {}", said.out);
    }
    let sample = handed_out(20, 19).to_string();
    let why = other.say(&["why", other.out(), &sample]);
    assert!(why.code == 0 && why.out.contains("unknown whether a run is alive"), "{}{}", why.out, why.err);
    // the owner gets more details
    let own = say(&["status", other.out()]);
    assert!(own.out.contains("state      killed: process "), "{}", own.out);
    let told = other.say(&["run", &other.study, "--out", other.out(), "--workers", "1"]);
    assert!(
        told.code == 3 && told.err.contains("contains a run of another user (uid 0)"),
        "{}: {}",
        told.code,
        told.err
    );
}

#[test]
fn a_run_of_somebody_else_is_not_gone_on_with_whoever_may_write_there() {
    let _alone = alone();
    let Some(other) = Other::new("directories of several users") else { return };
    fs::create_dir(&other.out).expect("created");
    set(&other.out, 0o777);
    let run = ["run", &other.study, "--out", other.out(), "--workers", "2", "--trust-dir"];
    assert_eq!(say(&run).code, 0);
    for name in ["run.lock", "ledger.redb"] {
        assert_eq!(mode(&other.out.join(name)), 0o600, "{name}");
    }
    let refused = other.say(&run);
    assert_eq!(refused.code, 3, "{}", refused.err);
    assert!(refused.err.contains("contains a run of another user (uid 0)"), "{}", refused.err);
    assert!(refused.err.contains("only that user can resume it; choose another --out"), "{}", refused.err);
    assert!(say(&run).err.contains("every sample is already finished"), "its own user's it remains");
}

#[test]
fn who_keeps_a_lock_is_named_and_no_dead_process() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", &STUDY.replace("0.1 s", "0.02 s"));
    let out = folder.name("out");
    let mut run = Running::start(&folder, &study, &out, "who=orchestrator,at=recorded,sample=7,do=kill");
    let dead = run.child.id();
    assert_eq!((run.end().signal(), run.fired()), (Some(9), 1), "{}", run.said());
    let own = format!("process {} (", std::process::id());
    let again = || say(&["run", &study, "--out", &out, "--workers", "1"]);
    for (name, code) in [("run.lock", 3), ("ledger.redb", 6)] {
        let file = fs::File::open(folder.path(&format!("out/{name}"))).expect("own");
        file.lock_shared().expect("free");
        let said = again();
        assert_eq!(said.code, code, "{name}: {}", said.err);
        let error = &said.err[said.err.find("error: ").expect("an error")..];
        assert!(error.contains(&own) && error.contains(name), "{name}: {error}");
        assert!(!error.contains(&format!("process {dead} ")) && !error.contains("another run"), "{name}: {error}");
    }
    // a run that ends normally, or is rejected, removes its name from the lock file
    let lock = fs::File::open(folder.path("out/run.lock")).expect("own");
    lock.lock().expect("free");
    let status = say(&["status", &out]).out;
    let line = format!("state      unknown whether a run is alive: run.lock is locked by {own}");
    assert!(status.contains(&line), "{status}");
    lock.unlock().expect("held");
    assert_eq!(again().code, 0);
}

#[test]
fn a_directory_that_is_closed_during_a_run_is_said_to_keep_what_is_finished() {
    let _alone = alone();
    let folder = Folder::new();
    let study = folder.write("s.toml", &STUDY.replace("0.1 s", "0.02 s"));
    let is_root = fs::metadata("/proc/self").expect("Linux").uid() == 0;
    // root can enter every directory: another user runs instead
    let other = if is_root { Other::new("unreachable") } else { None };
    let (home, study) = match &other {
        Some(other) => (other.folder.path("home"), other.study.clone()),
        None => (folder.path(""), study),
    };
    let out = home.join("out");
    let args = ["run", &study, "--out", out.to_str().expect("UTF-8"), "--workers", "2", "--json-events"];
    let command = || match &other {
        Some(other) => other.command(&args),
        None => bladeoff(&args),
    };
    let scratch = folder.path("scratch");
    fs::create_dir(&scratch).expect("created");
    set(&folder.path(""), 0o755);
    let fault = format!("who=orchestrator,at=recorded,sample={},do=stop", handed_out(20, 10));
    let mut run = bladeoff_dev::chaos::Running::start(command(), &scratch, &fault).expect("it starts");
    set(&run.fired, 0o777);
    wait_until("the fault", || run.fired().len() == 1);
    set(&out, 0);
    assert!(signal(run.child.id(), "CONT"));
    let ended = run.end(|_| {}).expect("it ends");
    set(&out, 0o755);
    let said = run.said();
    assert_eq!(ended.code(), Some(6), "{said}");
    assert!(said.contains("was closed to this user during the run; 20 finished samples are kept in it"), "{said}");
    assert!(said.contains("chmod u+rwx") && said.contains("because: Permission denied"), "{said}");
    let go_on = format!("finished samples are kept; resume with: {}", command().get_program().to_string_lossy());
    assert!(said.contains(&go_on), "{go_on}: {said}");
    let again = crate::support::said(command().output().expect("it starts"));
    assert!(again.code == 0 && again.err.contains("20 of 20 samples are already finished"), "{}", again.err);
}
