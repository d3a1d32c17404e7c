//! The worker's loop: ask, compute, report.
//!
//! Results leave with the request for the next batch, or during the batch when [`REPORT_EVERY`] has passed or the message
//! is full. A report during the batch is not waited for: its answer is taken when it is there, and the next report needs
//! it, so that at most one request is ever open. The answer to any report can be the order to stop, or to leave the rest of the batch to others:
//! after a long sample it is waited for, because by then that has become likely.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use bladeoff_protocol::link::{LinkError, WorkerLink};
use bladeoff_protocol::messages::{Batch, Body, Hello, Report, SampleReport, ToWorker};
use bladeoff_protocol::transport::WorkerPort;

use crate::batch_recorder::{BatchRecorder, Sample};
use crate::fault::{At, Faults};
use crate::heartbeat::Heartbeat;
use crate::solver::{Solver, solve_all};

/// A finished result is held back at most this long, plus the sample after it.
pub const REPORT_EVERY: Duration = Duration::from_millis(100);
/// The answer to a report is waited for when nothing was reported for so long: an exchange of some ten microseconds.
const WAIT_FROM: Duration = Duration::from_millis(400);

/// Why a worker ended without being told to.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The connection, or a message that may not be believed.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// An answer that does not belong to the request.
    #[error("the orchestrator answered {answer} to {request}")]
    Answer {
        /// What it answered.
        answer: &'static str,
        /// To what.
        request: &'static str,
    },
}

/// Serves samples until told to stop.
///
/// # Errors
/// A broken connection, or an answer that makes no sense: the process should end.
pub fn serve<P: WorkerPort, S: Solver>(
    mut link: WorkerLink<P>,
    hello: Hello,
    solver: &mut S,
    heartbeat: &Heartbeat,
    faults: &dyn Faults,
) -> Result<(), ServeError> {
    link.send(Body::Hello(hello))?;
    match link.receive()? {
        ToWorker::Continue => {}
        ToWorker::Stop => return Ok(()),
        ToWorker::Batch(_) => return Err(ServeError::Answer { answer: "a batch", request: "hello" }),
        ToWorker::Leave => return Err(ServeError::Answer { answer: "leave", request: "hello" }),
    }
    let mut report = Report { batch: None, samples: Vec::new(), asks: true };
    loop {
        send(&mut link, &mut report, faults)?;
        heartbeat.waiting();
        let batch = match link.receive()? {
            ToWorker::Batch(batch) => batch,
            ToWorker::Stop => return Ok(()),
            ToWorker::Continue => return Err(ServeError::Answer { answer: "continue", request: "a request for work" }),
            ToWorker::Leave => return Err(ServeError::Answer { answer: "leave", request: "a request for work" }),
        };
        let mut run = BatchRun {
            link: &mut link,
            heartbeat,
            faults,
            report: Report { batch: Some((batch.batch, batch.attempt)), samples: Vec::new(), asks: false },
            answer_is_open: false,
            sent: Instant::now(),
        };
        if run.compute(&batch, solver)? == Next::Stop {
            return Ok(());
        }
        report = run.report;
        report.asks = true;
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
    GoOn,
    /// With the next batch.
    Leave,
    Stop,
}

struct BatchRun<'a, P> {
    link: &'a mut WorkerLink<P>,
    heartbeat: &'a Heartbeat,
    faults: &'a dyn Faults,
    report: Report,
    answer_is_open: bool,
    sent: Instant,
}

impl<P: WorkerPort> BatchRun<'_, P> {
    /// Computes the samples of a batch; what is not reported at the end is left in `report`.
    fn compute<S: Solver>(&mut self, batch: &Batch, solver: &mut S) -> Result<Next, ServeError> {
        if !self.faults.is_empty() {
            batch.samples.iter().for_each(|&sample| self.faults.reached(At::Claimed, sample, None));
        }
        let samples: Vec<Sample<'_>> = batch.iter().map(|(number, params)| Sample { number, params }).collect();
        let (heartbeat, faults) = (self.heartbeat, self.faults);
        let mut end = None;
        let mut hand_in = |done: SampleReport| match self.hand_in(done) {
            Ok(Next::GoOn) => ControlFlow::Continue(()),
            stop => {
                end = Some(stop);
                ControlFlow::Break(())
            }
        };
        solve_all(solver, &mut BatchRecorder::new(batch.batch, &samples, heartbeat, faults, &mut hand_in));
        end.unwrap_or_else(|| self.settle(true))
    }

    /// Takes a result, and sends those at hand when it is time.
    fn hand_in(&mut self, done: SampleReport) -> Result<Next, ServeError> {
        if !self.report.has_room(done.outcome.values.len()) {
            match self.settle(true)? {
                Next::GoOn => self.flush()?,
                // Told to leave: so it was taken back, and is computed by another.
                next => return Ok(next),
            }
        }
        self.report.samples.push(done);
        let since = self.sent.elapsed();
        if since < REPORT_EVERY {
            return Ok(Next::GoOn);
        }
        let next = self.settle(false)?;
        if next != Next::GoOn || self.answer_is_open {
            return Ok(next);
        }
        self.flush()?;
        if since >= WAIT_FROM { self.settle(true) } else { Ok(Next::GoOn) }
    }

    /// Sends what is finished, without waiting for the answer.
    fn flush(&mut self) -> Result<(), ServeError> {
        send(self.link, &mut self.report, self.faults)?;
        self.answer_is_open = true;
        self.sent = Instant::now();
        Ok(())
    }

    /// Takes the answer to the last report, if one is open and there or to be waited for.
    fn settle(&mut self, wait: bool) -> Result<Next, ServeError> {
        if !self.answer_is_open {
            return Ok(Next::GoOn);
        }
        let mut answer = self.link.try_receive()?;
        if answer.is_none() && wait {
            // Should the answer be lost, the heartbeat has to say so.
            self.heartbeat.waiting();
            answer = Some(self.link.receive()?);
        }
        self.answer_is_open = answer.is_none();
        match answer {
            None | Some(ToWorker::Continue) => Ok(Next::GoOn),
            Some(ToWorker::Leave) => Ok(Next::Leave),
            Some(ToWorker::Stop) => {
                // What is finished is kept; nobody answers any more.
                if !self.report.samples.is_empty() {
                    send(self.link, &mut self.report, self.faults)?;
                }
                Ok(Next::Stop)
            }
            Some(ToWorker::Batch(_)) => Err(ServeError::Answer { answer: "a batch", request: "a report" }),
        }
    }
}

/// Sends a report and empties it.
fn send<P: WorkerPort>(link: &mut WorkerLink<P>, report: &mut Report, faults: &dyn Faults) -> Result<(), ServeError> {
    let next = Report { batch: report.batch, samples: Vec::new(), asks: report.asks };
    let body = Body::Report(std::mem::replace(report, next));
    let Body::Report(sent) = link.send(body)? else { return Ok(()) };
    if !faults.is_empty() {
        sent.samples.iter().for_each(|done| faults.reached(At::Sent, done.sample, None));
    }
    Ok(())
}
