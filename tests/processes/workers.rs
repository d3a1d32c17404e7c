//! Real worker processes without computation, started by this program, or by this program as a separate orchestrator process.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use bladeoff::dispatch::{
    self, DispatchOptions, DispatchReport, Observer, Parameters, Sink, SinkError, Snapshot, Todo,
};
use bladeoff_dev::faults::FAULT_VARIABLE;
use bladeoff_model::outcome::Outcome;
use bladeoff_protocol::runtime::RUNTIME_VARIABLE;
use bladeoff_record::Entry;
use bladeoff_worker::noop::noop_outcome;

pub use crate::support::alone;
pub use crate::support::processes::children;
use crate::support::processes::lives;
use crate::support::runtime;

/// Longer than any of these tests takes on any machine; a test that hangs fails after this time.
pub const WATCHDOG: Duration = Duration::from_secs(120);
/// Arguments of `sh` that start the command that follows with a usual umask.
///
/// iceoryx2 sets the umask of a test program for a moment while a test in it runs a study, and a command that another test starts inherits it. Root is
/// not affected; another user cannot enter the directories that the command creates.
pub const OWN_UMASK: [&str; 3] = ["-c", "umask 022 && exec \"$@\"", "sh"];

/// Environment variable that makes this test program an orchestrator; its value is the directory.
pub const ORCHESTRATE: &str = "BLADEOFF_TEST_ORCHESTRATE";
pub const SAMPLES: u64 = 40;

pub struct Numbers;

impl Parameters for Numbers {
    fn params(&self, sample: u64, out: &mut Vec<f64>) {
        out.extend(params(sample));
    }
}

pub fn params(sample: u64) -> [f64; 3] {
    [sample as f64, 0.25, -1.5]
}

#[derive(Default)]
pub struct Table(pub BTreeMap<u64, Entry>);

impl Sink for Table {
    fn record(&mut self, sample: u64, entry: Entry) -> Result<(), SinkError> {
        assert!(self.0.insert(sample, entry).is_none(), "sample {sample} recorded twice");
        Ok(())
    }
    fn flush(&mut self) -> Result<(), SinkError> {
        Ok(())
    }
}

impl Table {
    /// Asserts that every sample except `except` is present and correct.
    pub fn assert_undisturbed_except(&self, count: u64, except: &[u64]) {
        assert_eq!(self.0.len() as u64, count);
        for (sample, result) in self.0.iter().filter(|(sample, _)| !except.contains(sample)) {
            assert_eq!(result.outcome, noop_outcome(*sample, &params(*sample)), "sample {sample}");
        }
    }
    pub fn outcome(&self, sample: u64) -> &Outcome {
        &self.0[&sample].outcome
    }
}

/// Observer of starting and ending workers.
#[derive(Default)]
pub struct Watcher {
    pub pids: BTreeSet<u32>,
    pub was_stale: bool,
}

impl Observer for Watcher {
    fn progress(&mut self, snapshot: &Snapshot) {
        self.pids.extend(snapshot.workers.iter().filter_map(|worker| worker.pid));
        self.was_stale |= snapshot.workers.iter().any(|worker| worker.stale);
    }
}

pub struct Run {
    pub dir: tempfile::TempDir,
    pub options: DispatchOptions,
}

impl Run {
    /// A run of samples that keep a worker busy for a given number of microseconds.
    pub fn new(workers: usize, micros: u64) -> Self {
        let dir = tempfile::tempdir().expect("temporary directory");
        let options = options(dir.path(), workers, micros, None);
        Self { dir, options }
    }

    /// A run with a fault in its workers; `dir` is added to the fault.
    pub fn with_fault(workers: usize, micros: u64, fault: &str) -> Self {
        let mut run = Self::new(workers, micros);
        run.options = options(run.dir.path(), workers, micros, Some(fault));
        run
    }

    pub fn play(&self, todo: impl Into<Todo>) -> (DispatchReport, Table, Watcher) {
        let (mut table, mut watcher) = (Table::default(), Watcher::default());
        let start = Instant::now();
        let mut report = dispatch::run(&self.options, &Numbers, todo, &mut table, &mut watcher).expect("a run");
        dispatch::give_back(report.memory.take(), &mut watcher);
        assert!(start.elapsed() < WATCHDOG);
        assert_nothing_left(self.dir.path());
        assert!(watcher.pids.iter().all(|&pid| !lives(pid)), "a worker outlived its run");
        (report, table, watcher)
    }

    pub fn fired(&self, what: &str) -> usize {
        let names = std::fs::read_dir(self.dir.path()).expect("readable").flatten();
        names.filter(|entry| entry.file_name().to_string_lossy().starts_with(&format!("fired-{what}-"))).count()
    }

    pub fn log(&self) -> String {
        std::fs::read_to_string(&*self.options.worker_log).expect("a log")
    }
}

/// Worker faults are passed by `env`, so that tests do not share an environment; `env` is replaced by the worker through exec.
pub fn options(dir: &Path, workers: usize, micros: u64, fault: Option<&str>) -> DispatchOptions {
    let mut command: Vec<OsString> = Vec::new();
    if let Some(fault) = fault {
        command.extend(["env".into(), format!("{FAULT_VARIABLE}={fault},dir={}", dir.display()).into()]);
    }
    command.extend([crate::support::BINARY.into(), "worker".into()]);
    let mut options = DispatchOptions::new(workers, command, dir.to_owned(), "no plan".into());
    options.noop = Some(micros);
    options.runtime = Some(runtime().to_owned());
    options
}

/// Shared memory directories of the runs of a result directory, according to its log.
pub fn roots(dir: &Path) -> Vec<PathBuf> {
    let log = std::fs::read_to_string(dir.join("workers.log")).unwrap_or_default();
    log.lines().filter_map(|line| line.split_once("shared memory in ")).map(|(_, root)| PathBuf::from(root)).collect()
}

pub fn assert_nothing_left(dir: &Path) {
    let roots = roots(dir);
    assert!(!roots.is_empty(), "the log does not say where shared memory was");
    for root in roots {
        assert!(!root.exists(), "{} is left", root.display());
        let prefix = format!("bladeoff_{}_", root.file_name().expect("an id").to_string_lossy());
        let shm = std::fs::read_dir("/dev/shm").expect("readable").flatten();
        let left: Vec<_> = shm.map(|e| e.file_name()).filter(|n| n.to_string_lossy().starts_with(&prefix)).collect();
        assert!(left.is_empty(), "{left:?} are left");
    }
}

pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < WATCHDOG, "{what}: not within {WATCHDOG:?}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// This program as a separate orchestrator, if [`orchestrate`] has started it as one.
#[test]
fn orchestrator_process() {
    let Some(dir) = std::env::var_os(ORCHESTRATE).map(PathBuf::from) else { return };
    let mut options = options(&dir, 2, 250_000, None);
    // The runtime directory is set by the test that started this process.
    options.runtime = None;
    options.faults = bladeoff_dev::faults::EnvironmentFaults::of_process(bladeoff_dev::faults::Who::Orchestrator)
        .expect("valid faults");
    let mut sink = File { path: dir.join("recorded"), waiting: Vec::new() };
    let ended = match dispatch::run(&options, &Numbers, SAMPLES, &mut sink, &mut Watcher::default()) {
        Ok(report) => format!("{:?}", report.ended),
        Err(error) => {
            let causes = std::iter::successors(Some(&error as &dyn std::error::Error), |error| error.source());
            causes.map(ToString::to_string).collect::<Vec<_>>().join(": ")
        }
    };
    std::fs::write(dir.join("ended"), ended).expect("written");
}

/// Sink that appends sample numbers to a file at each flush.
struct File {
    path: PathBuf,
    waiting: Vec<u64>,
}

impl Sink for File {
    fn record(&mut self, sample: u64, entry: Entry) -> Result<(), SinkError> {
        assert_eq!(entry.outcome, noop_outcome(sample, &params(sample)));
        self.waiting.push(sample);
        Ok(())
    }
    fn flush(&mut self) -> Result<(), SinkError> {
        let text: String = self.waiting.drain(..).map(|sample| format!("{sample}\n")).collect();
        let file = std::fs::OpenOptions::new().create(true).append(true).open(&self.path);
        file.and_then(|mut file| file.write_all(text.as_bytes()))
            .map_err(|error| SinkError { what: "writing".into(), source: Some(Box::new(error)) })
    }
}

pub fn orchestrate(dir: &Path, fault: Option<&str>) -> Command {
    // The process that runs the tests may ignore SIGHUP, which children inherit; `env` resets it and is replaced by the program.
    let mut command = Command::new("env");
    command.arg("--default-signal=HUP").arg(std::env::current_exe().expect("this program"));
    command
        .args(["--exact", "workers::orchestrator_process", "--nocapture"])
        .env(ORCHESTRATE, dir)
        .env(RUNTIME_VARIABLE, runtime());
    if let Some(fault) = fault {
        command.env(FAULT_VARIABLE, format!("{fault},dir={}", dir.display()));
    }
    command
}

pub fn recorded(dir: &Path) -> Vec<u64> {
    let text = std::fs::read_to_string(dir.join("recorded")).unwrap_or_default();
    text.lines().map(|line| line.parse().expect("a number")).collect()
}
