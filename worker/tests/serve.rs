//! The worker's loop over the in-memory transport: what is asked, reported, held back, and what a panic does.

use std::collections::BTreeMap;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use bladeoff_model::outcome::{Cause, CauseSet, EndCause, Outcome, Status};
use bladeoff_protocol::link::{HubLink, Incoming, WorkerLink};
use bladeoff_protocol::messages::{Batch, BatchId, Body, Hello, Report, RunId, SampleReport, ToWorker, WorkerId};
use bladeoff_protocol::transport::{MemoryHub, MemoryNet};
use bladeoff_worker::fault::Faults;
use bladeoff_worker::pulse::Pulse;
use bladeoff_worker::serve::{ServeError, Solver, serve};

const RUN: RunId = RunId(5);
const WORKER: WorkerId = WorkerId(1);

/// Panics on 13, is slow on 7, returns NaN on 8, too much on 9.
struct Moody {
    n_values: usize,
    recovered: u32,
}

impl Solver for Moody {
    fn solve(&mut self, sample: u64, params: &[f64]) -> Outcome {
        match sample {
            13 => panic!("the thirteenth"),
            7 => thread::sleep(Duration::from_millis(250)),
            _ => {}
        }
        let mut values = vec![Some(params[0] * 2.0 + f64::from(self.recovered)); self.n_values];
        match sample {
            8 => values[0] = Some(f64::NAN),
            9 => values.resize(300, None),
            _ => {}
        }
        let (status, causes) = (Status::Ok, CauseSet::default());
        Outcome { status, cause: None, causes, end_cause: EndCause::Stopped, values }
    }
    fn recover(&mut self) {
        self.recovered += 1;
    }
}

fn start(net: &MemoryNet, n_values: usize) -> JoinHandle<Result<(), ServeError>> {
    let link = WorkerLink::new(net.worker(), RUN, WORKER);
    thread::spawn(move || {
        let hello = Hello { pid: 1, build: 1 };
        serve(link, hello, &mut Moody { n_values, recovered: 0 }, &Pulse::default(), &Faults::default())
    })
}

fn receive(hub: &mut HubLink<MemoryHub>) -> Incoming {
    loop {
        if let Some(incoming) = hub.try_receive().expect("memory does not fail") {
            return incoming;
        }
        hub.wait(Duration::from_secs(60)).expect("memory does not fail");
    }
}

fn report(incoming: Incoming) -> Report {
    match incoming.message.body {
        Body::Report(report) => report,
        Body::Hello(_) => panic!("a second hello"),
    }
}

fn batch(samples: Vec<u64>) -> ToWorker {
    let params = samples.iter().map(|&sample| sample as f64).collect();
    ToWorker::Batch(Batch { batch: BatchId(1), attempt: 1, n_params: 1, samples, params })
}

/// Greets the worker and gives it one batch; returns its reports.
fn play(samples: Vec<u64>, n_values: usize) -> Vec<Report> {
    let net = MemoryNet::default();
    let mut hub = HubLink::new(net.hub(), RUN);
    let worker = start(&net, n_values);
    let hello = receive(&mut hub);
    assert!(matches!(hello.message.body, Body::Hello(_)));
    hub.answer(hello.ticket, WORKER, &ToWorker::Continue).expect("answered");
    let first = receive(&mut hub);
    let ticket = first.ticket;
    assert_eq!(report(first), Report { batch: None, samples: Vec::new(), asks: true });
    hub.answer(ticket, WORKER, &batch(samples)).expect("answered");
    let mut reports = Vec::new();
    loop {
        let incoming = receive(&mut hub);
        let ticket = incoming.ticket;
        let next = report(incoming);
        assert_eq!(next.batch, Some((BatchId(1), 1)));
        let is_last = next.asks;
        reports.push(next);
        let answer = if is_last { ToWorker::Stop } else { ToWorker::Continue };
        hub.answer(ticket, WORKER, &answer).expect("answered");
        if is_last {
            worker.join().expect("no panic").expect("told to stop");
            return reports;
        }
    }
}

fn results(reports: &[Report]) -> BTreeMap<u64, &SampleReport> {
    reports.iter().flat_map(|report| &report.samples).map(|done| (done.sample, done)).collect()
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
    let reports = play((20..84).collect(), 256);
    assert_eq!(reports.len(), 4);
    assert_eq!(results(&reports).len(), 64);
    assert!(reports[..3].iter().all(|report| !report.asks && report.samples.len() == 16));
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
    // The solver was told to recover, once.
    assert_eq!(results[&14].outcome.values, [Some(29.0); 4]);
}

#[test]
fn a_worker_told_to_stop_in_a_batch_hands_over_what_is_finished_and_leaves() {
    let net = MemoryNet::default();
    let mut hub = HubLink::new(net.hub(), RUN);
    let worker = start(&net, 256);
    for answer in [ToWorker::Continue, batch((20..84).collect()), ToWorker::Stop] {
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
    assert!(known.keys().all(|sample| (36..84).contains(sample)) && !known.is_empty(), "{known:?}");
}

#[test]
fn a_worker_whose_orchestrator_is_gone_ends_with_an_error() {
    let net = MemoryNet::default();
    let hub = net.hub();
    let worker = start(&net, 4);
    drop(hub);
    assert!(worker.join().expect("no panic").is_err());
}
