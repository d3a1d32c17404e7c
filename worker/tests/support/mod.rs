//! One worker over the in-memory transport, and an orchestrator that sends one batch.

// Each test file uses what it needs.
#![allow(dead_code)]

#[path = "../../protocol/tests/transports/mod.rs"]
pub mod transports;

use std::collections::BTreeMap;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use bladeoff_model::outcome::{CauseSet, EndCause, Outcome, Status};
use bladeoff_protocol::link::{HubLink, Incoming, WorkerLink};
use bladeoff_protocol::messages::{Batch, BatchId, Body, Hello, Report, RunId, SampleReport, ToWorker, WorkerId};
use bladeoff_protocol::transport::WorkerPort;
use bladeoff_worker::fault::NoFaults;
use bladeoff_worker::heartbeat::Heartbeat;
use bladeoff_worker::serve::{ServeError, serve};
use bladeoff_worker::solver::Solver;
use transports::{MemoryHub, MemoryNet};

pub const RUN: RunId = RunId(5);
pub const WORKER: WorkerId = WorkerId(1);
/// Limit that no step of these tests reaches.
const WATCHDOG: Duration = Duration::from_secs(300);

/// Starts a worker whose solver is created in its thread.
pub fn start<P: WorkerPort + Send + 'static, S: Solver>(
    port: P,
    heartbeat: &Heartbeat,
    make: impl FnOnce() -> S + Send + 'static,
) -> JoinHandle<Result<(), ServeError>> {
    let heartbeat = heartbeat.clone();
    let link = WorkerLink::new(port, RUN, WORKER);
    thread::spawn(move || serve(link, Hello { pid: 1, build: 1 }, &mut make(), &heartbeat, &NoFaults))
}

pub fn receive(hub: &mut HubLink<MemoryHub>) -> Incoming {
    let begun = Instant::now();
    loop {
        if let Some(incoming) = hub.try_receive().expect("memory does not fail") {
            return incoming;
        }
        assert!(begun.elapsed() < WATCHDOG, "the worker says nothing");
        hub.wait(Duration::from_secs(1)).expect("memory does not fail");
    }
}

pub fn report(incoming: Incoming) -> Report {
    match incoming.message.body {
        Body::Report(report) => report,
        Body::Hello(_) => panic!("a second hello"),
    }
}

/// Samples with their numbers as their only parameter.
pub fn batch(samples: Vec<u64>) -> Batch {
    let params = samples.iter().map(|&sample| sample as f64).collect();
    Batch { batch: BatchId(1), attempt: 1, n_params: 1, samples, params }
}

/// Greets the worker and sends one batch; returns the worker's reports.
pub fn play<S: Solver>(make: impl FnOnce() -> S + Send + 'static, batch: Batch) -> Vec<Report> {
    let net = MemoryNet::default();
    let mut hub = HubLink::new(net.hub(), RUN);
    let worker = start(net.worker(), &Heartbeat::default(), make);
    let hello = receive(&mut hub);
    assert!(matches!(hello.message.body, Body::Hello(_)));
    hub.answer(hello.ticket, WORKER, &ToWorker::Continue).expect("answered");
    let first = receive(&mut hub);
    let ticket = first.ticket;
    assert_eq!(report(first), Report { batch: None, samples: Vec::new(), asks: true });
    hub.answer(ticket, WORKER, &ToWorker::Batch(batch)).expect("answered");
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

/// Results by sample number; each sample must occur once.
pub fn results(reports: &[Report]) -> BTreeMap<u64, &SampleReport> {
    let all: Vec<&SampleReport> = reports.iter().flat_map(|report| &report.samples).collect();
    let by_sample: BTreeMap<u64, &SampleReport> = all.iter().map(|done| (done.sample, *done)).collect();
    assert_eq!(by_sample.len(), all.len(), "a sample was reported twice");
    by_sample
}

/// A valid outcome.
pub fn fine(values: Vec<Option<f64>>) -> Outcome {
    let (status, causes) = (Status::Ok, CauseSet::default());
    Outcome { status, cause: None, causes, notes: CauseSet::default(), end_cause: EndCause::Stopped, values }
}
