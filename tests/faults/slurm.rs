//! A study on a real Slurm with four nodes on this host (`scripts/slurm-on-one-host`), while nodes fail or are disconnected, the controller is
//! killed, and tasks are cancelled. Each case asserts that the fault happened, and that the table equals that of one machine byte for byte.

#![expect(clippy::print_stdout, reason = "says what happened to nodes and tasks")]

use crate::running::{signal, state};
use crate::support::docs::{blocks, with};
use crate::support::skipped::skipped;
use crate::support::{Folder, bladeoff, root, say};
use bladeoff_dev::chaos::PAUSE;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// Longest duration of a case.
const WATCHDOG: Duration = Duration::from_secs(420);

/// 60 samples; with [`PAUSE`] each takes a tenth of a second.
const STUDY: &str = r#"schema = 1
name = "night"
machine = "machines/rig.toml"

[set]
"run.end_time" = "0.1 s"

[[vary]]
path = "contact.gap"
from = "0.5 mm"
to = "0.9 mm"
count = 6

[[vary]]
path = "blade_off.mass"
from = "3 g"
to = "10 g"
count = 10
"#;
/// Samples per chunk.
const CHUNK: u64 = 3;

fn script(folder: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(root().join("scripts/slurm-on-one-host"));
    command.args(words).env("SLURM_DIR", folder).env("CPUS", "2").env("NODES", "4").output().expect("bash runs it")
}

/// A Slurm installation, ended and removed when dropped.
struct Slurm {
    world: Folder,
    study: String,
}

impl Drop for Slurm {
    fn drop(&mut self) {
        script(&self.dir(), &["down"]);
    }
}

impl Slurm {
    fn start() -> Option<Self> {
        let world = Folder::new();
        let lacks = script(&world.path("slurm"), &["check"]);
        if !lacks.status.success() {
            skipped("a study on a real Slurm", String::from_utf8_lossy(&lacks.stdout).trim());
            return None;
        }
        let study = world.write("night.toml", STUDY);
        let slurm = Self { world, study };
        let up = script(&slurm.dir(), &["up"]);
        assert!(up.status.success(), "{}", String::from_utf8_lossy(&up.stderr));
        let one = say(&["run", &slurm.study, "--out", &slurm.world.name("one")]);
        assert_eq!(one.code, 0, "{}", one.err);
        Some(slurm)
    }

    fn dir(&self) -> PathBuf {
        self.world.path("slurm")
    }

    fn does(&self, words: &[&str]) {
        let output = script(&self.dir(), words);
        assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    }

    fn asks(&self, program: &str, words: &[&str]) -> Output {
        let mut command = Command::new("timeout");
        command.arg("20").arg(program).args(words).env("SLURM_CONF", self.dir().join("slurm.conf"));
        command.output().expect("timeout is there")
    }

    /// Submits the study; `faults` as in `BLADEOFF_FAULT`, without their folder. Returns the id of the array and the folder of the faults.
    fn submit(&self, out: &str, shards: &str, faults: &[String]) -> (String, PathBuf) {
        self.submit_with(out, &["--shards", shards, "--cpus", "1", "--time", "20min"], faults)
    }

    fn submit_with(&self, out: &str, more: &[&str], faults: &[String]) -> (String, PathBuf) {
        let fired = tempfile::tempdir_in(self.world.path("")).expect("a folder").keep();
        let (out, scratch) = (self.world.name(out), self.world.name("slurm/local"));
        let chunk = CHUNK.to_string();
        let own =
            ["submit", &self.study, "--scheduler", "slurm", "--out", &out, "--chunk", &chunk, "--scratch", &scratch];
        let mut command = bladeoff(&[&own, more].concat());
        command.env("SLURM_CONF", self.dir().join("slurm.conf")).env_remove("BLADEOFF_RUNTIME_DIR");
        // pauses, so that no shard takes the chunks of another one that has not begun yet
        let faults = faults.iter().map(|fault| format!("{fault},dir={}", fired.display()));
        let faults: Vec<String> = faults.chain([PAUSE.to_owned()]).collect();
        // Slurm splits the values of --export at commas, but not inherited variables
        command.env("BLADEOFF_FAULT", faults.join(";"));
        let output = command.output().expect("it starts");
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
        let number =
            said.trim().rsplit("handed in as ").next().and_then(|jobs| jobs.split(',').next()).expect("a number");
        (number.to_owned(), fired)
    }

    fn wait(&self, out: &str, what: &str, mut is_so: impl FnMut() -> bool) {
        let begun = Instant::now();
        while !is_so() {
            if begun.elapsed() > WATCHDOG {
                let status = say(&["status", &self.world.name(out)]).out;
                let queue = self.asks("squeue", &["--array", "--states=all"]);
                let logs = Command::new("tail").arg("-n5").args(self.logs(out)).output().expect("tail");
                panic!(
                    "{what}: not within {WATCHDOG:?}\n{status}\n{}\n{}",
                    String::from_utf8_lossy(&queue.stdout),
                    String::from_utf8_lossy(&logs.stdout)
                );
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Output of `status`, including chunks and scheduler.
    fn status(&self, out: &str) -> String {
        let mut command = bladeoff(&["status", &self.world.name(out)]);
        let output = command.env("SLURM_CONF", self.dir().join("slurm.conf")).output().expect("it starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    fn logs(&self, out: &str) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.world.path(out).join("scheduler")).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|end| end == "log")).collect()
    }

    fn chunks(&self, out: &str) -> usize {
        fs::read_dir(self.world.path(out).join("chunks/000")).map_or(0, |names| {
            names.flatten().filter(|name| name.path().extension().is_some_and(|end| end == "bin")).count()
        })
    }

    fn attempts(&self, out: &str) -> Vec<Value> {
        let folders = fs::read_dir(self.world.path(out).join("attempts")).into_iter().flatten().flatten();
        let entries = folders.flat_map(|folder| fs::read_dir(folder.path()).into_iter().flatten().flatten());
        entries.filter_map(|entry| serde_json::from_slice(&fs::read(entry.path()).ok()?).ok()).collect()
    }

    /// The shard whose orchestrator is stopped: the owner of the chunk, or a helping shard that was faster.
    fn held(&self, out: &str) -> String {
        let folder = self.world.name(out);
        self.wait(out, "one orchestrator is stopped", || stopped(&folder).len() == 1);
        let line = fs::read(format!("/proc/{}/cmdline", stopped(&folder)[0])).expect("it is there");
        let line = String::from_utf8_lossy(&line).into_owned();
        let (_, shard) = line.split_once("--shard\0").expect("a shard");
        shard.split('\0').next().expect("its number").to_owned()
    }

    /// Node of the attempt at a shard.
    fn node_of(&self, out: &str, shard: &str) -> String {
        let attempts = self.attempts(out);
        let found = attempts.iter().find(|attempt| attempt["shard"] == shard).expect("it has begun");
        found["host"].as_str().expect("a name").trim_start_matches("node").to_owned()
    }

    fn is_merged_and_that_of_one_machine(&self, out: &str) {
        self.wait(out, "the merge", || self.world.path(&format!("{out}/manifest.json")).is_file());
        let read = |name: &str| fs::read(self.world.path(name)).expect("there");
        assert!(read("one/results.parquet") == read(&format!("{out}/results.parquet")), "{out}: other bytes");
    }
}

/// Fault that stops the orchestrator once when it has the result of this sample, so that the attempt is held within that chunk.
fn holding(sample: u64) -> String {
    format!("who=orchestrator,at=sent,sample={sample},do=stop")
}

/// Fault that makes the worker hang once when it begins this sample.
fn hanging(sample: u64) -> String {
    format!("who=worker,at=running,sample={sample},do=hang")
}

fn fired(folder: &Path) -> usize {
    fs::read_dir(folder).map_or(0, Iterator::count)
}

/// Process ids of the stopped orchestrators of a directory.
fn stopped(out: &str) -> Vec<u32> {
    let pids =
        fs::read_dir("/proc").expect("Linux").flatten().filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    let is_one = |pid: &u32| {
        let line = fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
        let line = String::from_utf8_lossy(&line).replace('\0', " ");
        line.contains("--shard") && line.contains(out) && state(*pid) == Some('T')
    };
    pids.filter(is_one).collect()
}

#[test]
fn a_study_on_a_real_slurm_is_that_of_one_machine_whatever_happens_to_nodes_controller_and_tasks() {
    let Some(slurm) = Slurm::start() else { return };
    as_the_page_says(&slurm);
    // the time limit takes a minute, during which the next case runs
    let over = time_is_over(&slurm);
    half_is_cancelled(&slurm);
    is_requeued(&slurm, &over);
    node_dies(&slurm);
    node_is_cut_off(&slurm);
    controller_is_killed(&slurm);
}

/// The command of docs/cluster.md as written, with other paths. This Slurm has the same partition.
fn as_the_page_says(slurm: &Slurm) {
    let written = blocks("docs/cluster.md", "--scheduler slurm");
    let [written] = &written[..] else { panic!("{written:?}") };
    let (program, out) = (format!("{} ", crate::support::BINARY), slurm.world.name("page"));
    let paths = [
        ("bladeoff ", program.as_str()),
        ("studies/gap-friction-map.toml", slurm.study.as_str()),
        ("runs/night", &out),
    ];
    let mut command = Command::new("bash");
    command.args(["-ec", &with(written, &paths)]).env("SLURM_CONF", slurm.dir().join("slurm.conf"));
    let output = command.env_remove("BLADEOFF_RUNTIME_DIR").current_dir(root()).output().expect("bash");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    slurm.is_merged_and_that_of_one_machine("page");
    let partitions = slurm.asks("scontrol", &["show", "job"]);
    assert!(String::from_utf8_lossy(&partitions.stdout).contains("Partition=long"), "it went where it was told to");
    let attempts = slurm.attempts("page").len();
    assert!(attempts >= 16, "each of 16 shards began: {attempts}");
    println!("the command of docs/cluster.md: {attempts} attempts at 16 shards");
}

/// A task whose time limit expires within a chunk. Returns the folder of the fault.
fn time_is_over(slurm: &Slurm) -> PathBuf {
    // one worker that hangs: only the time limit ends it
    let more = ["--shards", "2", "--cpus", "1", "--time", "1min"];
    let (_, fires) = slurm.submit_with("over", &more, &[hanging(CHUNK + 1)]);
    slurm.wait("over", "shard 1 is in the middle of a chunk", || fired(&fires) == 1);
    fires
}

/// The task has ended shortly before its time limit, and was requeued.
fn is_requeued(slurm: &Slurm, fires: &Path) {
    slurm.is_merged_and_that_of_one_machine("over");
    assert_eq!(fired(fires), 1, "once");
    let log = fs::read_to_string(slurm.world.path("over/scheduler/shard-1.log")).expect("written");
    let (first, second) = (log.find("\nwall: "), log.rfind("\ncomplete: "));
    assert!(first.is_some() && first < second, "{log}");
    let attempts = slurm.attempts("over").len();
    assert!(attempts > 2, "more attempts than shards: {attempts}");
    println!("time over in mid-chunk: requeued, {attempts} attempts at 2 shards");
}

/// A node fails within a shard: Slurm gives its tasks to other nodes.
fn node_dies(slurm: &Slurm) {
    let (_, fires) = slurm.submit("dies", "8", &[holding(2 * CHUNK + 1)]);
    slurm.wait("dies", "a shard is in the middle of a chunk", || fired(&fires) == 1);
    let shard = slurm.held("dies");
    let node = slurm.node_of("dies", &shard);
    slurm.does(&["kill", &node]);
    slurm.wait("dies", "nothing is left of the node", || stopped(&slurm.world.name("dies")).is_empty());
    slurm.is_merged_and_that_of_one_machine("dies");
    let attempts = slurm.attempts("dies");
    assert!(attempts.iter().filter(|attempt| attempt["shard"] == *shard).count() > 1, "{attempts:?}");
    assert!(attempts.len() > 8, "more attempts than shards: {}", attempts.len());
    println!("node {node} killed in mid-shard: {} attempts at 8 shards", attempts.len());
    slurm.does(&["revive", &node]);
}

/// A disconnected node continues while other nodes repeat its work: the second writer discards its copy.
fn node_is_cut_off(slurm: &Slurm) {
    let (_, fires) = slurm.submit("cut", "8", &[holding(3 * CHUNK + 1)]);
    slurm.wait("cut", "a shard is in the middle of a chunk", || fired(&fires) == 1);
    let node = slurm.node_of("cut", &slurm.held("cut"));
    slurm.does(&["cut", &node]);
    let chunk = slurm.world.path("cut/chunks/000/chunk-000003.bin");
    slurm.wait("cut", "another attempt has published the chunk", || chunk.exists());
    let held = stopped(&slurm.world.name("cut"));
    assert_eq!(held.len(), 1, "it is there still");
    assert!(signal(held[0], "CONT"), "it computes on");
    let lost = || slurm.attempts("cut").iter().filter_map(|attempt| attempt["lost"].as_u64()).sum::<u64>();
    slurm.wait("cut", "a lost race", || lost() > 0);
    slurm.is_merged_and_that_of_one_machine("cut");
    let attempts = slurm.attempts("cut").len();
    assert!(attempts > 8, "more attempts than shards: {attempts}");
    println!("node {node} cut off: {attempts} attempts at 8 shards, {} lost races", lost());
    slurm.does(&["heal", &node]);
}

/// Half of the array is cancelled; the merge names the missing chunks; an array with another number of shards computes them.
fn half_is_cancelled(slurm: &Slurm) {
    // as long as the cost of a sample is unknown, a shard takes no second chunk, for which another one might wait
    let (job, fires) = slurm.submit("half", "2", &[hanging(CHUNK)]);
    slurm.wait("half", "shard 1 is in the middle of a chunk", || fired(&fires) == 1);
    // the other shard would help as long as it runs
    let ended = || slurm.attempts("half").iter().any(|attempt| attempt["state"] == "ended");
    slurm.wait("half", "the other one has done its work", ended);
    let cancelled = slurm.asks("scancel", &[&format!("{job}_1")]);
    assert!(cancelled.status.success(), "{}", String::from_utf8_lossy(&cancelled.stderr));
    let log = slurm.world.path("half/scheduler/merge.log");
    slurm.wait("half", "the merge says what is missing", || {
        fs::read_to_string(&log).is_ok_and(|log| log.contains("missing: 1\n"))
    });
    assert!(!slurm.world.path("half/results.parquet").exists());
    let kept = slurm.chunks("half");
    let status = slurm.status("half");
    assert!(status.contains(&format!("{kept} of 20 of 3 samples")) && status.contains("cancelled"), "{status}");
    assert_eq!(kept, 19, "the other one has published all that it could");
    // whole nodes, as without a number of cores
    slurm.submit_with("half", &["--shards", "3"], &[]);
    slurm.is_merged_and_that_of_one_machine("half");
    let attempts = slurm.attempts("half");
    let other =
        attempts.iter().filter(|attempt| attempt["shard"].as_str().is_some_and(|shard| shard.ends_with("/3"))).count();
    assert!(other >= 1, "{attempts:?}");
    println!("half of the array cancelled: {kept} chunks kept, the rest by {other} of 3 shards");
}

/// The controller is killed and loses part of its state; the files on disk count.
fn controller_is_killed(slurm: &Slurm) {
    let (_, fires) = slurm.submit("controller", "8", &[holding(5 * CHUNK + 1)]);
    slurm.wait("controller", "shard 5 is in the middle of a chunk", || fired(&fires) == 1);
    slurm.does(&["crash"]);
    assert!(!slurm.asks("squeue", &[]).status.success(), "the controller is dead");
    let status = slurm.status("controller");
    assert!(status.contains(" of 20 of 3 samples") && status.contains("unknown"), "{status}");
    stopped(&slurm.world.name("controller")).iter().for_each(|pid| assert!(signal(*pid, "CONT")));
    let all = (60 / CHUNK) as usize;
    slurm.does(&["start"]);
    // if it starts no lost task again, the study is submitted again, as its user would do
    let begun = Instant::now();
    let is_idle = || {
        let queue = slurm.asks("squeue", &["--noheader", "--states=PENDING,RUNNING,COMPLETING", "--format=%A"]);
        queue.status.success() && queue.stdout.is_empty()
    };
    let mut idle = 0;
    while slurm.chunks("controller") < all && idle < 3 && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_secs(1));
        idle = if is_idle() { idle + 1 } else { 0 };
    }
    for node in 1..=4 {
        // drained because of tasks that it no longer knew
        slurm.asks("scontrol", &["update", &format!("nodename=node{node}"), "state=resume"]);
    }
    let before = slurm.chunks("controller");
    let merged = || slurm.world.path("controller/manifest.json").is_file();
    if !merged() {
        slurm.submit("controller", "8", &[]);
        // it reuses lost job ids; a node that remembers one rejects the task, and Slurm holds the task for its user
        slurm.wait("controller", "the merge after it was submitted again", || {
            let pending = slurm.asks("squeue", &["--noheader", "--states=PENDING", "--format=%A"]);
            for job in String::from_utf8_lossy(&pending.stdout).split_whitespace() {
                slurm.asks("scontrol", &["release", job]);
            }
            merged()
        });
    }
    slurm.is_merged_and_that_of_one_machine("controller");
    println!("controller killed: {before} of {all} chunks before it was submitted again");
}
