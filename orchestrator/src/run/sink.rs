//! From the dispatch loop into the ledger, counting on the way.

use crate::dispatch::{Observer, SampleResult, Sink, SinkError};
use crate::ledger::{Entry, Ledger, LedgerError};
use crate::report::{Progress, Tally};
use crate::schedule::Snapshot;
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

/// Records results and counts them.
#[derive(Debug)]
pub(super) struct LedgerSink<'a> {
    pub ledger: &'a mut Ledger,
    pub tally: Rc<RefCell<Tally>>,
}

impl Sink for LedgerSink<'_> {
    fn record(&mut self, result: SampleResult) -> Result<(), SinkError> {
        self.tally.borrow_mut().add(&result.outcome);
        let entry =
            Entry { outcome: result.outcome, cpu_s: result.cpu_s, worker: result.worker, attempt: result.attempt };
        self.ledger.put(result.sample, &entry, Instant::now()).map_err(refused)
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        self.ledger.commit().map_err(refused)
    }
}

fn refused(error: LedgerError) -> SinkError {
    SinkError { what: "finished samples cannot be recorded".to_owned(), source: Some(Box::new(error)) }
}

/// Shows how far the study is.
#[derive(Debug)]
pub(super) struct ProgressObserver {
    pub progress: Progress,
    pub tally: Rc<RefCell<Tally>>,
}

impl Observer for ProgressObserver {
    fn progress(&mut self, _snapshot: &Snapshot) {
        self.progress.update(&self.tally.borrow(), Instant::now());
    }
}
