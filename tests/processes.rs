//! Real worker processes that compute nothing, and what befalls them: killed, stopped, out of memory, stuck, orphaned.
//! Every test of a fault asserts that the fault happened, by the file it leaves.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::io::Write;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use bladeoff::chaos::{lives, state};
use bladeoff::dispatch::{
    self, DispatchError, DispatchOptions, DispatchReport, Ended, Observer, SampleResult, Samples, Sink, SinkError,
    Snapshot, Todo,
};
use bladeoff_core::outcome::{Cause, Outcome, Status};
use bladeoff_worker::fault::FAULT_VARIABLE;
use bladeoff_worker::noop::noop_outcome;

/// Nothing here takes as long on any machine; what hangs fails.
const WATCHDOG: Duration = Duration::from_secs(120);
/// Tells this test program to be an orchestrator, and in which directory.
const ORCHESTRATE: &str = "BLADEOFF_TEST_ORCHESTRATE";
const SAMPLES: u64 = 40;

struct Numbers;

impl Samples for Numbers {
    fn params(&self, sample: u64, out: &mut Vec<f64>) {
        out.extend(params(sample));
    }
}

fn params(sample: u64) -> [f64; 3] {
    [sample as f64, 0.25, -1.5]
}

#[derive(Default)]
struct Table(BTreeMap<u64, SampleResult>);

impl Sink for Table {
    fn record(&mut self, result: SampleResult) -> Result<(), SinkError> {
        let sample = result.sample;
        assert!(self.0.insert(sample, result).is_none(), "sample {sample} recorded twice");
        Ok(())
    }
    fn flush(&mut self) -> Result<(), SinkError> {
        Ok(())
    }
}

impl Table {
    /// Every sample is there and right, except these.
    fn assert_undisturbed_except(&self, count: u64, except: &[u64]) {
        assert_eq!(self.0.len() as u64, count);
        for (sample, result) in self.0.iter().filter(|(sample, _)| !except.contains(sample)) {
            assert_eq!(result.outcome, noop_outcome(*sample, &params(*sample)), "sample {sample}");
        }
    }
    fn outcome(&self, sample: u64) -> &Outcome {
        &self.0[&sample].outcome
    }
}

/// Sees workers come and go.
#[derive(Default)]
struct Watcher {
    pids: BTreeSet<u32>,
    was_stale: bool,
}

impl Observer for Watcher {
    fn progress(&mut self, snapshot: &Snapshot) {
        self.pids.extend(snapshot.workers.iter().filter_map(|worker| worker.pid));
        self.was_stale |= snapshot.workers.iter().any(|worker| worker.stale);
    }
}

/// One test at a time: they count processes and files.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Run {
    dir: tempfile::TempDir,
    options: DispatchOptions,
}

impl Run {
    /// A run of samples that keep a worker busy for so many microseconds.
    fn new(workers: usize, micros: u64) -> Self {
        let dir = tempfile::tempdir().expect("temporary directory");
        let options = options(dir.path(), workers, micros, None);
        Self { dir, options }
    }

    /// With a fault in its workers; `dir` is added.
    fn with_fault(workers: usize, micros: u64, fault: &str) -> Self {
        let mut run = Self::new(workers, micros);
        run.options = options(run.dir.path(), workers, micros, Some(fault));
        run
    }

    fn play(&self, todo: impl Into<Todo>) -> (DispatchReport, Table, Watcher) {
        let (mut table, mut watcher) = (Table::default(), Watcher::default());
        let start = Instant::now();
        let report = dispatch::run(&self.options, &Numbers, todo, &mut table, &mut watcher).expect("a run");
        assert!(start.elapsed() < WATCHDOG);
        assert_nothing_left(self.dir.path());
        assert!(watcher.pids.iter().all(|&pid| !lives(pid)), "a worker outlived its run");
        (report, table, watcher)
    }

    fn fired(&self, what: &str) -> usize {
        let names = std::fs::read_dir(self.dir.path()).expect("readable").flatten();
        names.filter(|entry| entry.file_name().to_string_lossy().starts_with(&format!("fired-{what}-"))).count()
    }

    fn log(&self) -> String {
        std::fs::read_to_string(&self.options.worker_log).expect("a log")
    }
}

/// Worker faults go through `env`, so that tests do not share an environment; it becomes the worker by exec.
fn options(dir: &Path, workers: usize, micros: u64, fault: Option<&str>) -> DispatchOptions {
    let mut command: Vec<OsString> = Vec::new();
    if let Some(fault) = fault {
        command.extend(["env".into(), format!("{FAULT_VARIABLE}={fault},dir={}", dir.display()).into()]);
    }
    command.extend([env!("CARGO_BIN_EXE_bladeoff").into(), "worker".into()]);
    let mut options = DispatchOptions::new(workers, command, dir.to_owned(), "no plan".into());
    options.noop = Some(micros);
    options
}

/// Where the runs of a directory had their shared memory, by its log.
fn roots(dir: &Path) -> Vec<PathBuf> {
    let log = std::fs::read_to_string(dir.join("workers.log")).unwrap_or_default();
    log.lines().filter_map(|line| line.split_once("shared memory in ")).map(|(_, root)| PathBuf::from(root)).collect()
}

fn assert_nothing_left(dir: &Path) {
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

fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < WATCHDOG, "{what}: not within {WATCHDOG:?}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn any_number_of_workers_gives_the_same_table() {
    let _alone = alone();
    for workers in [1, 2, 3] {
        let (report, table, _) = Run::new(workers, 0).play(20_000);
        assert_eq!((report.ended, report.done, report.worker_deaths), (Ended::Complete, 20_000, 0));
        assert_eq!(report.dropped_messages, 0);
        table.assert_undisturbed_except(20_000, &[]);
    }
}

#[test]
fn a_run_of_nothing_is_complete() {
    let _alone = alone();
    let run = Run::new(2, 0);
    let (mut table, mut watcher) = (Table::default(), Watcher::default());
    let report = dispatch::run(&run.options, &Numbers, 0, &mut table, &mut watcher).expect("a run");
    assert_eq!((report.ended, report.done, watcher.pids.len()), (Ended::Complete, 0, 0));
}

#[test]
fn ranges_are_computed_and_nothing_else() {
    let _alone = alone();
    let (report, table, _) = Run::new(2, 0).play(Todo::from_iter([5..9, 100..103]));
    assert_eq!(report.done, 7);
    assert_eq!(table.0.into_keys().collect::<Vec<_>>(), [5, 6, 7, 8, 100, 101, 102]);
}

#[test]
fn a_killed_worker_changes_no_result() {
    let _alone = alone();
    for at in ["claimed", "running", "sent"] {
        let run = Run::with_fault(2, 2000, &format!("who=worker,at={at},sample=17,do=kill"));
        let (report, table, _) = run.play(SAMPLES);
        assert_eq!((run.fired(at), report.worker_deaths, report.ended), (1, 1, Ended::Complete), "{at}");
        table.assert_undisturbed_except(SAMPLES, &[]);
        assert!(run.log().contains("SIGKILL"), "{}", run.log());
    }
}

#[test]
fn a_stopped_worker_is_shown_replaced_and_changes_no_result() {
    let _alone = alone();
    for at in ["claimed", "running", "sent"] {
        let mut run = Run::with_fault(2, 2000, &format!("who=worker,at={at},sample=17,do=stop"));
        run.options.stale_after = Duration::from_secs(1);
        run.options.replace_after = Duration::from_secs(3);
        let (report, table, watcher) = run.play(SAMPLES);
        assert_eq!((run.fired(at), report.worker_deaths, report.ended), (1, 1, Ended::Complete), "{at}");
        assert!(watcher.was_stale);
        table.assert_undisturbed_except(SAMPLES, &[]);
    }
}

#[test]
fn a_worker_that_goes_on_in_time_is_not_replaced() {
    let _alone = alone();
    let mut run = Run::with_fault(1, 2000, "who=worker,at=running,sample=17,do=stop");
    run.options.stale_after = Duration::from_secs(1);
    struct Continuing(Watcher);
    impl Observer for Continuing {
        fn progress(&mut self, snapshot: &Snapshot) {
            self.0.progress(snapshot);
            for worker in snapshot.workers.iter().filter(|worker| worker.stale) {
                let pid = worker.pid.expect("a stale worker has a process").to_string();
                assert!(Command::new("kill").args(["-CONT", &pid]).status().expect("kill runs").success());
            }
        }
    }
    let (mut table, mut observer) = (Table::default(), Continuing(Watcher::default()));
    let report = dispatch::run(&run.options, &Numbers, SAMPLES, &mut table, &mut observer).expect("a run");
    assert_eq!((run.fired("running"), report.worker_deaths), (1, 0));
    assert!(observer.0.was_stale && observer.0.pids.len() == 1);
    table.assert_undisturbed_except(SAMPLES, &[]);
}

#[test]
fn a_sample_that_kills_its_worker_alone_is_quarantined_and_no_other() {
    let _alone = alone();
    for (what, cause) in [("kill", Cause::WorkerKilled), ("abort", Cause::WorkerKilled)] {
        let run = Run::with_fault(2, 2000, &format!("who=worker,at=running,sample=17,do={what},times=99"));
        let (report, table, _) = run.play(SAMPLES);
        assert_eq!(report.ended, Ended::Complete);
        table.assert_undisturbed_except(SAMPLES, &[17]);
        let outcome = table.outcome(17);
        assert_eq!((outcome.status, outcome.cause), (Status::Quarantined, Some(cause)));
        // Twice alone, and once before if it was in a batch.
        assert!((2..=3).contains(&run.fired("running")), "{}", run.fired("running"));
    }
}

#[test]
fn a_sample_that_takes_all_memory_is_quarantined_for_it() {
    let _alone = alone();
    let mut run = Run::with_fault(2, 2000, "who=worker,at=running,sample=17,do=hoard,times=99");
    run.options.memory_limit = Some(200 << 20);
    let (_, table, _) = run.play(SAMPLES);
    table.assert_undisturbed_except(SAMPLES, &[17]);
    assert_eq!(table.outcome(17).cause, Some(Cause::OutOfMemory));
}

#[test]
fn a_stuck_sample_is_quarantined_for_its_time() {
    let _alone = alone();
    let mut run = Run::with_fault(2, 2000, "who=worker,at=running,sample=17,do=hang,times=99");
    run.options.time_limit_s = Some(1.5);
    let (_, table, _) = run.play(SAMPLES);
    table.assert_undisturbed_except(SAMPLES, &[17]);
    assert_eq!(table.outcome(17).cause, Some(Cause::TimeLimit));
}

#[test]
fn a_panic_fails_its_sample_without_a_death() {
    let _alone = alone();
    let run = Run::with_fault(2, 2000, "who=worker,at=running,sample=17,do=panic,times=99");
    let (report, table, _) = run.play(SAMPLES);
    assert_eq!((report.worker_deaths, run.fired("running")), (0, 1));
    table.assert_undisturbed_except(SAMPLES, &[17]);
    assert_eq!((table.outcome(17).status, table.outcome(17).cause), (Status::Failed, Some(Cause::Panicked)));
    assert!(run.log().contains("asked for by BLADEOFF_FAULT"), "the panic's message is in the log");
}

#[test]
fn workers_that_cannot_start_end_the_run_with_their_words() {
    let _alone = alone();
    let mut run = Run::new(2, 0);
    // A real worker then, and there is no plan.
    run.options.noop = None;
    let (mut table, mut watcher) = (Table::default(), Watcher::default());
    let error = dispatch::run(&run.options, &Numbers, SAMPLES, &mut table, &mut watcher).expect_err("no plan");
    let DispatchError::WorkersDoNotStart { last_words, .. } = &error else { panic!("{error}") };
    assert!(last_words.contains("plan.json"), "{last_words}");
    assert_nothing_left(run.dir.path());
}

#[test]
fn the_words_of_a_worker_that_cannot_start_are_not_those_of_one_that_can() {
    let _alone = alone();
    let mut run = Run::new(2, 100_000);
    // The first one to come becomes a worker, which is killed when the run is given up.
    let script = format!("mkdir {}/first || {{ echo no luck >&2; exit 9; }}; exec \"$@\"", run.dir.path().display());
    let command = std::mem::take(&mut run.options.worker_command);
    run.options.worker_command = ["sh", "-c", &script, "sh"].map(OsString::from).into_iter().chain(command).collect();
    let (mut table, mut watcher) = (Table::default(), Watcher::default());
    let error = dispatch::run(&run.options, &Numbers, 1000, &mut table, &mut watcher).expect_err("no second worker");
    let DispatchError::WorkersDoNotStart { last_words, .. } = &error else { panic!("{error}") };
    assert_eq!(last_words, "no luck");
    assert!(run.log().contains("SIGKILL"), "the healthy one ended after it: {}", run.log());
    assert_nothing_left(run.dir.path());
}

#[test]
fn a_stale_worker_with_the_last_sample_is_heard() {
    let _alone = alone();
    let fault = format!("who=worker,at=running,sample={},do=stop", SAMPLES - 1);
    let mut run = Run::with_fault(1, 2000, &fault);
    run.options.stale_after = Duration::from_secs(1);
    #[derive(Default)]
    struct Listening {
        stale: BTreeSet<u32>,
        heard: BTreeSet<u32>,
    }
    impl Observer for Listening {
        fn progress(&mut self, snapshot: &Snapshot) {
            for worker in &snapshot.workers {
                if !worker.stale {
                    self.heard.extend(self.stale.take(&worker.worker));
                } else if self.stale.insert(worker.worker) {
                    let pid = worker.pid.expect("a stale worker has a process").to_string();
                    assert!(Command::new("kill").args(["-CONT", &pid]).status().expect("kill runs").success());
                }
            }
        }
    }
    let (mut table, mut observer) = (Table::default(), Listening::default());
    let report = dispatch::run(&run.options, &Numbers, SAMPLES, &mut table, &mut observer).expect("a run");
    assert_eq!((run.fired("running"), report.worker_deaths, report.ended), (1, 0, Ended::Complete));
    assert_eq!(observer.heard.len(), 1, "stale for ever: {:?}", observer.stale);
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
fn workers_of_another_build_are_refused() {
    let _alone = alone();
    let mut run = Run::new(1, 0);
    run.options.build = Some(1);
    let (mut table, mut watcher) = (Table::default(), Watcher::default());
    let error = dispatch::run(&run.options, &Numbers, SAMPLES, &mut table, &mut watcher).expect_err("another build");
    assert!(matches!(error, DispatchError::WorkersDoNotStart { .. }), "{error}");
    assert!(run.log().contains("another build of the program") && table.0.is_empty(), "{}", run.log());
    assert_nothing_left(run.dir.path());
}

#[test]
fn budgets_stop_a_run_with_what_is_finished() {
    let _alone = alone();
    let mut run = Run::new(2, 20_000);
    run.options.wall = Some(Duration::from_millis(500));
    let (report, table, _) = run.play(1_000_000);
    assert_eq!(report.ended, Ended::Wall);
    table.assert_undisturbed_except(report.done, &[]);
    let mut run = Run::with_fault(2, 2000, "who=worker,at=running,sample=any,do=panic,times=99");
    run.options.max_failures = Some(3);
    let (report, table, _) = run.play(1_000_000);
    assert_eq!(report.ended, Ended::TooManyFailures);
    assert!(table.0.len() as u64 == report.done && report.done >= 4);
}

#[test]
fn two_runs_at_once_do_not_disturb_each_other() {
    let _alone = alone();
    std::thread::scope(|scope| {
        let runs = [1, 2].map(|workers| scope.spawn(move || Run::new(workers, 100).play(2000)));
        for run in runs {
            let (report, table, _) = run.join().expect("no panic");
            assert_eq!((report.ended, report.dropped_messages), (Ended::Complete, 0));
            table.assert_undisturbed_except(2000, &[]);
        }
    });
}

#[test]
fn a_second_signal_waits_for_nobody() {
    let _alone = alone();
    let mut run = Run::with_fault(1, 2000, "who=worker,at=running,sample=3,do=hang");
    // Without the second signal the run would last as long as this.
    run.options.grace = Duration::from_secs(3600);
    struct Impatient(u32);
    impl Observer for Impatient {
        fn progress(&mut self, snapshot: &Snapshot) {
            let is_stuck = snapshot
                .workers
                .iter()
                .any(|worker| matches!(worker.activity, dispatch::Activity::Busy { sample: Some(3), .. }));
            if is_stuck && self.0 < 2 {
                self.0 += 1;
                let pid = std::process::id().to_string();
                assert!(Command::new("kill").args(["-INT", &pid]).status().expect("kill runs").success());
            }
        }
    }
    let (mut table, mut observer) = (Table::default(), Impatient(0));
    let report = dispatch::run(&run.options, &Numbers, SAMPLES, &mut table, &mut observer).expect("a run");
    assert_eq!((observer.0, report.ended), (2, Ended::Signalled(dispatch::Signal::Interrupt)));
    assert!(table.0.len() < SAMPLES as usize && run.fired("running") == 1);
    assert_nothing_left(run.dir.path());
}

/// Not a test by itself: this program as an orchestrator of its own, started by the tests below.
#[test]
fn orchestrator_process() {
    let Some(dir) = std::env::var_os(ORCHESTRATE).map(PathBuf::from) else { return };
    let options = options(&dir, 2, 100_000, None);
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

/// Sample numbers, appended when flushed.
struct File {
    path: PathBuf,
    waiting: Vec<u64>,
}

impl Sink for File {
    fn record(&mut self, result: SampleResult) -> Result<(), SinkError> {
        assert_eq!(result.outcome, noop_outcome(result.sample, &params(result.sample)));
        self.waiting.push(result.sample);
        Ok(())
    }
    fn flush(&mut self) -> Result<(), SinkError> {
        let text: String = self.waiting.drain(..).map(|sample| format!("{sample}\n")).collect();
        let file = std::fs::OpenOptions::new().create(true).append(true).open(&self.path);
        file.and_then(|mut file| file.write_all(text.as_bytes()))
            .map_err(|error| SinkError { what: "writing".into(), source: Some(Box::new(error)) })
    }
}

fn orchestrate(dir: &Path, fault: Option<&str>) -> Command {
    // Whoever runs the tests may ignore SIGHUP, and children inherit that; `env` becomes the program.
    let mut command = Command::new("env");
    command.arg("--default-signal=HUP").arg(std::env::current_exe().expect("this program"));
    command.args(["--exact", "orchestrator_process", "--nocapture"]).env(ORCHESTRATE, dir);
    if let Some(fault) = fault {
        command.env(FAULT_VARIABLE, format!("{fault},dir={}", dir.display()));
    }
    command
}

fn recorded(dir: &Path) -> Vec<u64> {
    let text = std::fs::read_to_string(dir.join("recorded")).unwrap_or_default();
    text.lines().map(|line| line.parse().expect("a number")).collect()
}

fn children(pid: u32) -> Vec<u32> {
    let path = format!("/proc/{pid}/task/{pid}/children");
    let mut found: Vec<u32> =
        std::fs::read_to_string(path).unwrap_or_default().split_whitespace().filter_map(|p| p.parse().ok()).collect();
    // Workers are started by the thread that runs the test.
    for task in std::fs::read_dir(format!("/proc/{pid}/task")).into_iter().flatten().flatten() {
        let text = std::fs::read_to_string(task.path().join("children")).unwrap_or_default();
        found.extend(text.split_whitespace().filter_map(|p| p.parse::<u32>().ok()));
    }
    found.sort_unstable();
    found.dedup();
    found
}

#[test]
fn after_a_killed_orchestrator_workers_leave_and_the_next_run_goes_on() {
    let _alone = alone();
    for at in ["claimed", "running", "sent", "recorded"] {
        let dir = tempfile::tempdir().expect("temporary directory");
        let fault = format!("who=orchestrator,at={at},sample=any,do=kill");
        let mut orchestrator = orchestrate(dir.path(), Some(&fault)).spawn().expect("started");
        let mut workers = BTreeSet::new();
        wait_until("the orchestrator is killed", || {
            workers.extend(children(orchestrator.id()));
            orchestrator.try_wait().expect("a child").is_some()
        });
        assert!(
            std::fs::read_dir(dir.path())
                .expect("readable")
                .flatten()
                .any(|entry| { entry.file_name().to_string_lossy().starts_with(&format!("fired-{at}-")) })
        );
        assert!(!dir.path().join("ended").exists() && !roots(dir.path()).is_empty());
        wait_until("workers leave", || workers.iter().all(|&pid| !lives(pid)));
        // What was flushed counts; the next run computes the rest and removes what the dead one left.
        let before = recorded(dir.path());
        let left: BTreeSet<u64> = (0..SAMPLES).filter(|sample| !before.contains(sample)).collect();
        assert!(!left.is_empty(), "killed too late");
        let run = Run::new(2, 0);
        let (report, table, _) = run.play(Todo::from_iter(left.iter().map(|&sample| sample..sample + 1)));
        assert_eq!(report.ended, Ended::Complete);
        assert_eq!(table.0.into_keys().collect::<BTreeSet<_>>(), left);
        assert_nothing_left(dir.path());
    }
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
    let dir = tempfile::tempdir().expect("temporary directory");
    let Some(mut orchestrator) = SmallMemory::orchestrate(dir.path()) else { return };
    wait_until("it works", || !recorded(dir.path()).is_empty());
    let first = *children(orchestrator.0.id()).first().expect("a worker");
    orchestrator.fill();
    assert!(Command::new("kill").args(["-KILL", &first.to_string()]).status().expect("kill runs").success());
    wait_until("it ends", || {
        // What the dead worker gives back is taken before its replacement is so far.
        orchestrator.fill();
        orchestrator.has_ended()
    });
    let ended = std::fs::read_to_string(dir.path().join("ended")).expect("an orderly end");
    assert!(ended.contains("/dev/shm is full"), "{ended}");
}

#[test]
fn signals_end_a_run_in_order() {
    let _alone = alone();
    for (signal, word) in
        [("INT", "Signalled(Interrupt)"), ("TERM", "Signalled(Terminate)"), ("HUP", "Signalled(Terminate)")]
    {
        let dir = tempfile::tempdir().expect("temporary directory");
        // Stopped at a known state, so that the signal comes in the middle.
        let fault = "who=orchestrator,at=recorded,sample=0,do=stop";
        let mut orchestrator = orchestrate(dir.path(), Some(fault)).spawn().expect("started");
        wait_until("the orchestrator stops", || {
            dir.path().join("fired-recorded-0-1").exists() && state(orchestrator.id()) == Some('T')
        });
        let workers = children(orchestrator.id());
        for signal in [signal, "CONT"] {
            let sent = Command::new("kill").args([&format!("-{signal}"), &orchestrator.id().to_string()]).status();
            assert!(sent.expect("kill runs").success());
        }
        wait_until("the orchestrator ends", || orchestrator.try_wait().expect("a child").is_some());
        assert!(!workers.is_empty() && workers.iter().all(|&pid| !lives(pid)));
        assert_eq!(std::fs::read_to_string(dir.path().join("ended")).expect("an orderly end"), word);
        let recorded = recorded(dir.path());
        assert!(recorded.contains(&0) && (recorded.len() as u64) < SAMPLES, "{recorded:?}");
        assert_nothing_left(dir.path());
    }
}
