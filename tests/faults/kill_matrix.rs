//! {worker, orchestrator} x {claimed, running, sent, recorded} x {KILL, STOP}, through `bladeoff run`. Every cell asserts that its fault occurred, by
//! the file that it writes, and that results.parquet is byte for byte equal to that of an undisturbed run.

use crate::running::{Running, SAMPLES, STUDY, handed_out, left_behind, lives, signal, state, wait_until};
use crate::support::Folder;
use bladeoff_system::files::is_temporary;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::time::Duration;

const STATES: [&str; 4] = ["claimed", "running", "sent", "recorded"];
/// Longer than the silence after which a worker is reported as stale.
const STOPPED_FOR: Duration = Duration::from_secs(6);

struct Matrix {
    folder: Folder,
    study: String,
    calm: Vec<u8>,
    /// Sample at which faults occur: one that is dispatched early, so that other samples remain.
    sample: u64,
}

impl Matrix {
    fn new() -> Self {
        let folder = Folder::new();
        let study = folder.write("s.toml", STUDY);
        let mut run = Running::start(&folder, &study, &folder.name("calm"), "");
        assert!(run.end().success(), "{}", run.said());
        let calm = fs::read(folder.path("calm/results.parquet")).expect("the table");
        Self { folder, study, calm, sample: handed_out(SAMPLES, 2) }
    }

    fn start(&self, out: &str, fault: &str) -> Running {
        Running::start_slow(&self.folder, &self.study, &self.folder.name(out), fault)
    }

    /// Runs all cells of a row at the same time, because they mostly wait.
    fn each_state(&self, cell: impl Fn(&str) + Sync) {
        std::thread::scope(|scope| {
            let cells: Vec<_> = STATES.map(|at| (at, scope.spawn(|| cell(at)))).into_iter().collect();
            for (at, cell) in cells {
                assert!(cell.join().is_ok(), "cell {at}");
            }
        });
    }

    fn assert_undisturbed(&self, run: &mut Running, out: &str) {
        let status = run.end();
        assert!(status.success(), "{out}: {status}: {}", run.said());
        let table = fs::read(self.folder.path(out).join("results.parquet")).expect("the table");
        assert!(table == self.calm, "{out}: another table than the undisturbed one");
        let left = left_behind(&self.folder.name(out));
        assert!(left.is_empty(), "{out}: {left:?} are left");
        assert!(run.workers().iter().all(|&pid| !lives(pid)), "{out}: a worker outlived its run");
    }

    fn worker_fault(&self, at: &str, what: &str) -> String {
        let sample = self.sample;
        match at {
            // A worker does not know when its result is durable.
            "recorded" => format!("who=orchestrator,at=recorded,sample={sample},do={what}-worker"),
            at => format!("who=worker,at={at},sample={sample},do={what}"),
        }
    }
}

/// Number of the worker whose process has this id.
fn number_of(run: &Running, pid: u32) -> serde_json::Value {
    let started = run.events().into_iter().find(|event| event["event"] == "worker_started" && event["pid"] == pid);
    started.expect("it was started")["worker"].clone()
}

/// Number of events of this name about this worker so far.
fn of_worker(run: &Running, name: &str, worker: &serde_json::Value) -> usize {
    run.events().iter().filter(|event| event["event"] == name && event["worker"] == *worker).count()
}

#[test]
fn a_killed_worker_changes_no_byte() {
    let matrix = Matrix::new();
    matrix.each_state(|at| {
        let out = format!("worker-kill-{at}");
        let mut run = matrix.start(&out, &matrix.worker_fault(at, "kill"));
        matrix.assert_undisturbed(&mut run, &out);
        assert_eq!(run.fired(), 1, "{at}: the kill happened");
        let killed = run.events().iter().filter(|event| event["died"] == true).count();
        assert_eq!(killed, 1, "{at}: {}", run.said());
    });
}

#[test]
fn a_stopped_worker_is_shown_and_goes_on_or_is_replaced_and_changes_no_byte() {
    let matrix = Matrix::new();
    let stopped = |run: &Running| run.workers().into_iter().find(|&pid| state(pid) == Some('T'));
    matrix.each_state(|at| {
        let out = format!("worker-stop-{at}");
        let mut run = matrix.start(&out, &matrix.worker_fault(at, "stop"));
        wait_until("the worker stops", || run.fired() == 1 && stopped(&run).is_some());
        let worker = number_of(&run, stopped(&run).expect("stopped"));
        // Events of this worker only: on a busy machine other workers may be silent for a moment, too.
        let stale = |run: &Running| of_worker(run, "worker_stale", &worker);
        wait_until("it is called stale", || stale(&run) == 1);
        // One cell waits until the worker is replaced, in the others the worker continues.
        if at != "running" {
            let pid = stopped(&run).expect("still stopped");
            assert!(signal(pid, "CONT"));
        }
        matrix.assert_undisturbed(&mut run, &out);
        let killed = of_worker(&run, "worker_killed", &worker);
        let died = run.events().iter().any(|event| event["died"] == true && event["worker"] == worker);
        assert_eq!((killed, died), if at == "running" { (1, true) } else { (0, false) }, "{at}: {}", run.said());
        assert_eq!(stale(&run), 1, "{at}: nobody is called stale after he goes on");
    });
}

#[test]
fn a_killed_orchestrator_is_continued_and_changes_no_byte() {
    let matrix = Matrix::new();
    matrix.each_state(|at| {
        let out = format!("orchestrator-kill-{at}");
        let mut run = matrix.start(&out, &format!("who=orchestrator,at={at},sample={},do=kill", matrix.sample));
        assert_eq!(run.end().signal(), Some(9), "{at}: {}", run.said());
        assert_eq!(run.fired(), 1, "{at}: the kill happened");
        let workers = run.workers();
        wait_until("its workers leave", || workers.iter().all(|&pid| !lives(pid)));
        assert!(!matrix.folder.path(&out).join("results.parquet").exists());
        let mut again = matrix.start(&out, "");
        matrix.assert_undisturbed(&mut again, &out);
        if at == "recorded" {
            assert!(again.events()[0]["recorded"].as_u64() > Some(0), "recorded samples are kept");
        }
    });
}

/// Heartbeats come every half second; nevertheless the orchestrator's fault must find a sample that runs for a millisecond.
#[test]
fn an_orchestrator_is_killed_while_a_short_sample_runs() {
    let folder = Folder::new();
    let study = folder.write("short.toml", &STUDY.replace("0.1 s", "0.001 s"));
    for sample in [2, 19] {
        let fault = format!("who=orchestrator,at=running,sample={sample},do=kill");
        let mut run = Running::start(&folder, &study, &folder.name(&format!("short-{sample}")), &fault);
        assert_eq!((run.end().signal(), run.fired()), (Some(9), 1), "{sample}: {}", run.said());
    }
}

#[test]
fn a_stopped_orchestrator_goes_on_calls_nobody_stale_and_changes_no_byte() {
    let matrix = Matrix::new();
    matrix.each_state(|at| {
        let out = format!("orchestrator-stop-{at}");
        let mut run = matrix.start(&out, &format!("who=orchestrator,at={at},sample={},do=stop", matrix.sample));
        let pid = run.child.id();
        wait_until("it stops", || run.fired() == 1 && state(pid) == Some('T'));
        // This is the duration of the stop, not a wait for a condition.
        std::thread::sleep(STOPPED_FOR);
        assert!(signal(pid, "CONT"));
        matrix.assert_undisturbed(&mut run, &out);
        let troubles = ["worker_stale", "worker_killed"].map(|event| run.count(event));
        assert_eq!(troubles, [0, 0], "{at}: {}", run.said());
    });
}

#[test]
fn an_orchestrator_killed_before_its_tables_is_continued() {
    let matrix = Matrix::new();
    let mut run = matrix.start("tables", "who=orchestrator,at=writing,sample=0,do=kill");
    assert_eq!((run.end().signal(), run.fired()), (Some(9), 1));
    let mut again = matrix.start("tables", "");
    matrix.assert_undisturbed(&mut again, "tables");
    assert_eq!(again.count("sample"), 0, "nothing is computed again");
}

#[test]
fn an_orchestrator_killed_while_a_grown_study_takes_over_its_record_is_continued() {
    let matrix = Matrix::new();
    let small = matrix.folder.write("small.toml", &STUDY.replace("count = 5", "count = 3"));
    // The first and the last sample that are reused.
    for sample in [0, 19] {
        let out = format!("grown-{sample}");
        let mut run = Running::start(&matrix.folder, &small, &matrix.folder.name(&out), "");
        assert!(run.end().success(), "{}", run.said());
        let mut run = matrix.start(&out, &format!("who=orchestrator,at=growing,sample={sample},do=kill"));
        assert_eq!((run.end().signal(), run.fired()), (Some(9), 1), "{}", run.said());
        let begun = || {
            let names = std::fs::read_dir(matrix.folder.path(&out)).expect("readable").flatten();
            names.filter(|entry| is_temporary(&entry.file_name(), "ledger.redb")).count()
        };
        assert_eq!(begun(), 1, "the new record lies aside");
        let mut again = matrix.start(&out, "");
        matrix.assert_undisturbed(&mut again, &out);
        assert_eq!(again.events()[0]["recorded"].as_u64(), Some(12), "what the small study had is used");
        assert_eq!(begun(), 0, "what was begun is removed");
    }
}
