//! Loop of a worker: ask, compute, report.
//!
//! Results are sent with the request for the next batch, or during the batch when [`REPORT_EVERY`] has passed or the message is
//! full. The worker does not wait for the answer to a report during the batch. It takes the answer when it has arrived; the next
//! report needs it, so at most one request is open. The answer to any report can be the order to stop, or to leave the rest of
//! the batch to others. After a long sample the worker waits for the answer, because such an order has become likely.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use bladeoff_protocol::link::{LinkError, WorkerLink};
use bladeoff_protocol::messages::{Batch, Body, Hello, Report, SampleReport, ToWorker};
use bladeoff_protocol::transport::WorkerPort;

use crate::batch_recorder::{BatchRecorder, Sample};
use crate::fault::{At, Faults};
use crate::heartbeat::Heartbeat;
use crate::solver::{Solver, solve_all};

/// Longest time for which a finished result is held back, plus the sample after it.
pub const REPORT_EVERY: Duration = Duration::from_millis(100);
/// Time without a report after which the worker waits for the answer: an exchange takes some ten microseconds.
const WAIT_FROM: Duration = Duration::from_millis(400);

/// Error that ends a worker.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// Broken connection or invalid message.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// Answer that does not belong to the request.
    #[error("the orchestrator answered {answer} to {request}")]
    Answer {
        /// Answer.
        answer: &'static str,
        /// Request.
        request: &'static str,
    },
}

/// Serves samples until the order to stop.
///
/// # Errors
/// A broken connection or an invalid answer: the process should end.
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
    /// Computes the samples of a batch; unreported results remain in `report`.
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

    /// Takes a result; sends all results if it is time.
    fn hand_in(&mut self, done: SampleReport) -> Result<Next, ServeError> {
        if !self.report.has_room(done.outcome.values.len()) {
            match self.settle(true)? {
                Next::GoOn => self.flush()?,
                // The sample was taken back and is computed by another worker.
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

    /// Sends finished results without waiting for the answer.
    fn flush(&mut self) -> Result<(), ServeError> {
        send(self.link, &mut self.report, self.faults)?;
        self.answer_is_open = true;
        self.sent = Instant::now();
        Ok(())
    }

    /// Takes the answer to the last report, if it has arrived or must be waited for.
    fn settle(&mut self, wait: bool) -> Result<Next, ServeError> {
        if !self.answer_is_open {
            return Ok(Next::GoOn);
        }
        let mut answer = self.link.try_receive()?;
        if answer.is_none() && wait {
            // If the answer is lost, the heartbeats show the waiting.
            self.heartbeat.waiting();
            answer = Some(self.link.receive()?);
        }
        self.answer_is_open = answer.is_none();
        match answer {
            None | Some(ToWorker::Continue) => Ok(Next::GoOn),
            Some(ToWorker::Leave) => Ok(Next::Leave),
            Some(ToWorker::Stop) => {
                // Finished results are kept; no further answer comes.
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
