//! From the dispatch loop into the record, counting on the way.

use super::directory_lost::Guard;
use super::partial_tables::Teller;
use super::telling::Known;
use crate::dispatch::{More, Sink, SinkError};
use bladeoff_model::outcome::Status;
use bladeoff_record::{Entry, Record, RecordError};
use bladeoff_study::SampleKeys;
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

/// Who hears what has become durable, and may have more to do.
pub(super) trait Hears {
    /// These samples have become durable.
    fn durable(&self, samples: Vec<u64>);

    /// As [`Sink::more`].
    fn more(&self) -> Result<More, SinkError> {
        Ok(More::Nothing)
    }

    /// As [`Sink::check`].
    fn check(&self) -> Result<(), SinkError> {
        Ok(())
    }
}

impl Hears for Teller<'_> {
    fn durable(&self, samples: Vec<u64>) {
        self.durable(samples);
    }
}

/// Records results and counts them.
pub(super) struct RecordSink<'a> {
    record: &'a mut Record,
    keys: &'a SampleKeys<'a>,
    known: Rc<RefCell<Known>>,
    /// Taken and not durable yet.
    gathered: Vec<u64>,
    /// Who is told once they are.
    hears: &'a dyn Hears,
    /// Looks after the directory.
    guard: Guard<'a>,
}

impl<'a> RecordSink<'a> {
    pub fn new(
        record: &'a mut Record,
        keys: &'a SampleKeys<'a>,
        known: &Rc<RefCell<Known>>,
        hears: &'a dyn Hears,
        guard: Guard<'a>,
    ) -> Self {
        Self { record, keys, known: Rc::clone(known), gathered: Vec::new(), hears, guard }
    }

    /// Whatever a commit has made durable counts from now on, and only that: a commit that fails leaves it all gathered.
    fn note_durable(&mut self) {
        if self.record.gathered() == 0 && !self.gathered.is_empty() {
            let known = &mut *self.known.borrow_mut();
            known.durable = known.taken.clone();
            self.hears.durable(std::mem::take(&mut self.gathered));
            known.events.iter_mut().for_each(|events| events.durable());
        }
    }

    /// Commits what is left.
    pub fn close(mut self) -> Result<(), RecordError> {
        let committed = self.record.commit();
        self.note_durable();
        committed
    }
}

impl Sink for RecordSink<'_> {
    fn record_all(&mut self, results: Vec<(u64, Entry)>) -> Result<(), SinkError> {
        // Those of one message are of one worker. What a sample took that killed its workers, nobody has reported.
        let ended = || results.iter().filter(|(_, entry)| entry.outcome.status != Status::Quarantined);
        if let Some((_, first)) = ended().next() {
            let cpu_s: Vec<f64> = ended().map(|(_, entry)| entry.cpu_s).collect();
            self.known.borrow_mut().costs.add(first.worker, &cpu_s, Instant::now());
        }
        results.into_iter().try_for_each(|(sample, entry)| self.record(sample, entry))
    }

    fn record(&mut self, sample: u64, entry: Entry) -> Result<(), SinkError> {
        {
            let known = &mut *self.known.borrow_mut();
            known.taken.add(&entry.outcome);
            known.events.iter_mut().for_each(|events| events.sample(sample, &entry));
        }
        self.gathered.push(sample);
        self.record.put(sample, self.keys.key(sample), &entry, Instant::now()).map_err(refused)?;
        self.note_durable();
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        self.record.commit().map_err(refused)?;
        self.note_durable();
        Ok(())
    }

    fn more(&mut self) -> Result<More, SinkError> {
        self.hears.more()
    }

    fn check(&mut self) -> Result<(), SinkError> {
        self.hears.check()?;
        if self.guard.finds_loss(self.record) {
            // Why is found out again, and told, when the run has stopped.
            return Err(SinkError {
                what: "the result directory was moved or removed during the run".to_owned(),
                source: None,
            });
        }
        Ok(())
    }
}

fn refused(error: RecordError) -> SinkError {
    SinkError { what: "finished samples cannot be recorded".to_owned(), source: Some(Box::new(error)) }
}
