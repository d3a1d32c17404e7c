//! Real worker processes with trivial samples that are killed, stopped, out of memory, stuck or orphaned. Every test of a fault asserts
//! by a file that the fault happened.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::process::Command;
use std::time::Duration;

use crate::support::processes::{lives, state};
use crate::workers::*;
use bladeoff::dispatch::{self, DispatchError, Ended, Observer, Snapshot, Todo};
use bladeoff_model::outcome::{Cause, Status};

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

/// States of a sample, and numbers of workers. A sent result is not lost: with two workers on a busy machine, the other one may have finished all
/// the rest by then, and the end of a worker that is no longer needed is not counted as a death.
const STATES: [(&str, usize); 3] = [("claimed", 2), ("running", 2), ("sent", 1)];

#[test]
fn a_killed_worker_changes_no_result() {
    let _alone = alone();
    for (at, workers) in STATES {
        let run = Run::with_fault(workers, 2000, &format!("who=worker,at={at},sample=17,do=kill"));
        let (report, table, _) = run.play(SAMPLES);
        assert_eq!((run.fired(at), report.worker_deaths, report.ended), (1, 1, Ended::Complete), "{at}");
        table.assert_undisturbed_except(SAMPLES, &[]);
        assert!(run.log().contains("SIGKILL"), "{}", run.log());
    }
}

#[test]
fn a_stopped_worker_is_shown_replaced_and_changes_no_result() {
    let _alone = alone();
    // in parallel: most of the time is spent waiting for a silence that no busy machine causes
    std::thread::scope(|scope| {
        for (at, workers) in STATES {
            scope.spawn(move || {
                let mut run = Run::with_fault(workers, 2000, &format!("who=worker,at={at},sample=17,do=stop"));
                run.options.schedule.stale_after = Duration::from_secs(1);
                run.options.schedule.replace_after = Duration::from_secs(15);
                let (report, table, watcher) = run.play(SAMPLES);
                assert_eq!((run.fired(at), report.worker_deaths, report.ended), (1, 1, Ended::Complete), "{at}");
                assert!(watcher.was_stale);
                table.assert_undisturbed_except(SAMPLES, &[]);
            });
        }
    });
}

#[test]
fn a_worker_that_goes_on_in_time_is_not_replaced() {
    let _alone = alone();
    let mut run = Run::with_fault(1, 2000, "who=worker,at=running,sample=17,do=stop");
    run.options.schedule.stale_after = Duration::from_secs(1);
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
    for (what, cause, limit) in [("kill", Cause::WorkerKilled, 5), ("abort", Cause::WorkerCrashed, 2)] {
        let run = Run::with_fault(2, 2000, &format!("who=worker,at=running,sample=17,do={what},times=99"));
        let (report, table, _) = run.play(SAMPLES);
        assert_eq!(report.ended, Ended::Complete);
        table.assert_undisturbed_except(SAMPLES, &[17]);
        let outcome = table.outcome(17);
        assert_eq!((outcome.status, outcome.cause), (Status::Quarantined, Some(cause)));
        // this many kills alone, and one before if it was in a batch
        assert!((limit..=limit + 1).contains(&run.fired("running")), "{what}: {}", run.fired("running"));
    }
}

/// A sample that an earlier run gave up because of kills has one more try, after all other samples.
#[test]
fn a_suspect_is_tried_last_and_until_the_first_kill() {
    let _alone = alone();
    let suspects = |todo: Todo| todo.with_suspects(vec![17, 29]);
    let todo = || suspects(Todo::from_iter([0..17, 18..29, 30..SAMPLES]));
    let run = Run::with_fault(1, 2000, "who=worker,at=running,sample=17,do=kill,times=99");
    let (report, table, _) = run.play(todo());
    assert_eq!((report.ended, run.fired("running")), (Ended::Complete, 1));
    table.assert_undisturbed_except(SAMPLES, &[17]);
    assert_eq!(table.outcome(17).cause, Some(Cause::WorkerKilled));
    // a crash is not a kill: the suspect is tried again
    let run = Run::with_fault(1, 2000, "who=worker,at=running,sample=17,do=abort");
    let (report, table, _) = run.play(todo());
    assert_eq!((report.ended, report.worker_deaths, run.fired("running")), (Ended::Complete, 1, 1));
    table.assert_undisturbed_except(SAMPLES, &[]);
    // suspects alone are a run, too
    let (report, table, _) = Run::new(2, 0).play(suspects(Todo::default()));
    assert_eq!((report.done, table.0.len()), (2, 2));
}

#[test]
fn a_sample_that_takes_all_memory_is_quarantined_for_it() {
    let _alone = alone();
    let mut run = Run::with_fault(2, 2000, "who=worker,at=running,sample=17,do=hoard,times=99");
    run.options.schedule.sample.memory = Some(200 << 20);
    let (_, table, _) = run.play(SAMPLES);
    table.assert_undisturbed_except(SAMPLES, &[17]);
    assert_eq!(table.outcome(17).cause, Some(Cause::OutOfMemory));
}

#[test]
fn a_stuck_sample_is_quarantined_for_its_time() {
    let _alone = alone();
    let mut run = Run::with_fault(2, 2000, "who=worker,at=running,sample=17,do=hang,times=99");
    run.options.schedule.sample.time = Some(Duration::from_secs(4));
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
    // a real worker, without a plan
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
    // the first process becomes a worker, which is killed when the run is given up
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
    run.options.schedule.stale_after = Duration::from_secs(1);
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
    run.options.schedule.run.wall = Some(Duration::from_millis(500));
    let (report, table, _) = run.play(1_000_000);
    assert_eq!(report.ended, Ended::Wall);
    table.assert_undisturbed_except(report.done, &[]);
    let mut run = Run::with_fault(2, 2000, "who=worker,at=running,sample=any,do=panic,times=99");
    run.options.schedule.run.max_failures = Some(3);
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
    // without the second signal the run would last this long
    run.options.schedule.grace = Duration::from_secs(3600);
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
    let mut report = dispatch::run(&run.options, &Numbers, SAMPLES, &mut table, &mut observer).expect("a run");
    dispatch::give_back(report.memory.take(), &mut observer);
    assert_eq!((observer.0, report.ended), (2, Ended::Signalled(dispatch::Signal::Interrupt)));
    assert!(table.0.len() < SAMPLES as usize && run.fired("running") == 1);
    assert_nothing_left(run.dir.path());
}

#[test]
fn after_a_killed_orchestrator_workers_leave_and_the_next_run_goes_on() {
    let _alone = alone();
    for at in ["claimed", "running", "sent", "recorded"] {
        let dir = tempfile::tempdir().expect("temporary directory");
        // stopped first: the workers of a killed orchestrator may leave before the test sees them
        let fault = format!("who=orchestrator,at={at},sample=any,do=stop");
        let mut orchestrator = orchestrate(dir.path(), Some(&fault)).spawn().expect("started");
        wait_until("the orchestrator stops", || state(orchestrator.id()) == Some('T'));
        let workers = children(orchestrator.id());
        orchestrator.kill().expect("killed");
        orchestrator.wait().expect("a child");
        assert!(
            std::fs::read_dir(dir.path())
                .expect("readable")
                .flatten()
                .any(|entry| { entry.file_name().to_string_lossy().starts_with(&format!("fired-{at}-")) })
        );
        assert!(!dir.path().join("ended").exists() && !roots(dir.path()).is_empty());
        assert!(!workers.is_empty(), "{at}: nobody was seen at work");
        wait_until("workers leave", || workers.iter().all(|&pid| !lives(pid)));
        // flushed results count; the next run computes the rest and removes the files of the dead one
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
fn signals_end_a_run_in_order() {
    let _alone = alone();
    for (signal, word) in
        [("INT", "Signalled(Interrupt)"), ("TERM", "Signalled(Terminate)"), ("HUP", "Signalled(Terminate)")]
    {
        let dir = tempfile::tempdir().expect("temporary directory");
        // stopped at a known state, so that the signal comes within the run
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
