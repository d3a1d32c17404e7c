//! The worker's loop over the in-memory transport: requests, reports, delayed results, panics.

mod support;

use std::thread;
use std::time::Duration;

use bladeoff_model::outcome::{Cause, Status};
use bladeoff_protocol::link::HubLink;
use bladeoff_protocol::messages::{MAX_VALUES, Report, ToWorker};
use bladeoff_worker::batch_recorder::{BatchRecorder, Sample, Stopped};
use bladeoff_worker::heartbeat::Heartbeat;
use bladeoff_worker::solver::Solver;
use support::transports::MemoryNet;
use support::{RUN, WORKER, batch, fine, receive, report, results, start};

/// Panics on sample 13, is slow on 7, returns NaN on 8, too many values on 9.
struct Moody {
    n_values: usize,
    recovered: u32,
}

impl Solver for Moody {
    fn solve_batch(&mut self, samples: &[Sample<'_>], recorder: &mut BatchRecorder<'_>) -> Result<(), Stopped> {
        for index in 0..samples.len() {
            let begun = recorder.begin(index);
            match begun.sample.number {
                13 => panic!("the thirteenth"),
                7 => thread::sleep(Duration::from_millis(250)),
                _ => {}
            }
            let mut values = vec![Some(begun.sample.params[0] * 2.0 + f64::from(self.recovered)); self.n_values];
            match begun.sample.number {
                8 => values[0] = Some(f64::NAN),
                9 => values.resize(MAX_VALUES + 1, None),
                _ => {}
            }
            recorder.finish(begun, fine(values))?;
        }
        Ok(())
    }
    fn recover(&mut self) {
        self.recovered += 1;
    }
}

fn moody(n_values: usize) -> impl FnOnce() -> Moody + Send + 'static {
    move || Moody { n_values, recovered: 0 }
}

fn play(samples: Vec<u64>, n_values: usize) -> Vec<Report> {
    support::play(moody(n_values), batch(samples))
}

#[test]
fn short_samples_leave_together_with_the_next_request() {
    let reports = play((20..84).collect(), 4);
    assert_eq!(reports.len(), 1);
    assert_eq!(reports[0].samples.len(), 64);
    assert_eq!(results(&reports)[&20].outcome.values, [Some(40.0); 4]);
}

#[test]
fn more_results_than_a_message_holds_leave_in_several() {
    let reports = play((20..84).collect(), 512);
    assert_eq!(reports.len(), 5);
    assert_eq!(results(&reports).len(), 64);
    assert!(reports[..4].iter().all(|report| !report.asks && report.samples.len() == 15));
}

#[test]
fn a_finished_result_is_not_held_back_by_the_rest_of_its_batch() {
    let reports = play(vec![20, 7, 21], 4);
    assert_eq!(reports.len(), 2);
    assert_eq!(results(&reports[..1]).into_keys().collect::<Vec<_>>(), [7, 20]);
}

#[test]
fn a_panic_or_an_impossible_result_fails_its_sample_and_no_other() {
    let reports = play(vec![12, 13, 8, 9, 14], 4);
    let results = results(&reports);
    let failure = |sample: u64| (results[&sample].outcome.status, results[&sample].outcome.cause);
    assert_eq!(failure(13), (Status::Failed, Some(Cause::Panicked)));
    assert_eq!(failure(8), (Status::Failed, Some(Cause::NonFinite)));
    assert_eq!(failure(9), (Status::Failed, Some(Cause::Panicked)));
    assert_eq!(results[&12].outcome.values, [Some(24.0); 4]);
    // The solver's `recover` was called once.
    assert_eq!(results[&14].outcome.values, [Some(29.0); 4]);
}

#[test]
fn a_worker_told_to_stop_in_a_batch_hands_over_what_is_finished_and_leaves() {
    let net = MemoryNet::default();
    let mut hub = HubLink::new(net.hub(), RUN);
    let worker = start(net.worker(), &Heartbeat::default(), moody(256));
    for answer in [ToWorker::Continue, ToWorker::Batch(batch((20..84).collect())), ToWorker::Stop] {
        let ticket = receive(&mut hub).ticket;
        hub.answer(ticket, WORKER, &answer).expect("answered");
    }
    worker.join().expect("no panic").expect("told to stop");
    let mut last = Vec::new();
    while let Some(incoming) = hub.try_receive().expect("memory does not fail") {
        last.push(report(incoming));
    }
    assert!(last.iter().all(|report| !report.asks));
    let known = results(&last);
    assert!(known.keys().all(|sample| (35..84).contains(sample)) && !known.is_empty(), "{:?}", known.keys());
}

#[test]
fn a_worker_whose_orchestrator_is_gone_ends_with_an_error() {
    let net = MemoryNet::default();
    let hub = net.hub();
    let worker = start(net.worker(), &Heartbeat::default(), moody(4));
    drop(hub);
    assert!(worker.join().expect("no panic").is_err());
}
