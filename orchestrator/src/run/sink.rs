//! Sink of the dispatch loop: records results and counts them.

use super::directory_lost::DirectoryWatch;
use super::partial_tables::PartsHandle;
use super::telling::Known;
use crate::dispatch::{More, Sink, SinkError};
use bladeoff_model::outcome::Status;
use bladeoff_record::{Entry, Record, RecordError};
use bladeoff_study::SampleKeys;
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

/// Receiver of durable samples, which may supply further ones.
pub(super) trait DurableListener {
    /// Reports samples that have become durable.
    fn samples_durable(&self, samples: Vec<u64>);

    /// Further samples, as [`Sink::more`].
    fn more(&self) -> Result<More, SinkError> {
        Ok(More::Nothing)
    }

    /// Checks whether the run may continue, as [`Sink::check`].
    fn check(&self) -> Result<(), SinkError> {
        Ok(())
    }
}

impl DurableListener for PartsHandle<'_> {
    fn samples_durable(&self, samples: Vec<u64>) {
        self.samples_durable(samples);
    }
}

/// Sink that records results and counts them.
pub(super) struct RecordSink<'a> {
    record: &'a mut Record,
    keys: &'a SampleKeys<'a>,
    known: Rc<RefCell<Known>>,
    /// Received samples that are not durable yet.
    uncommitted: Vec<u64>,
    /// Receiver of durable samples.
    listener: &'a dyn DurableListener,
    /// Check of the directory.
    watch: DirectoryWatch<'a>,
}

impl<'a> RecordSink<'a> {
    pub fn new(
        record: &'a mut Record,
        keys: &'a SampleKeys<'a>,
        known: &Rc<RefCell<Known>>,
        listener: &'a dyn DurableListener,
        watch: DirectoryWatch<'a>,
    ) -> Self {
        Self { record, keys, known: Rc::clone(known), uncommitted: Vec::new(), listener, watch }
    }

    /// Counts the samples that a commit has made durable. After a failed commit all stay uncommitted.
    fn note_durable(&mut self) {
        if self.record.gathered() == 0 && !self.uncommitted.is_empty() {
            let known = &mut *self.known.borrow_mut();
            known.durable = known.taken.clone();
            self.listener.samples_durable(std::mem::take(&mut self.uncommitted));
            known.events.iter_mut().for_each(|events| events.durable());
        }
    }

    /// Commits the remaining samples.
    pub fn close(mut self) -> Result<(), RecordError> {
        let committed = self.record.commit();
        self.note_durable();
        committed
    }
}

impl Sink for RecordSink<'_> {
    fn record_all(&mut self, results: Vec<(u64, Entry)>) -> Result<(), SinkError> {
        // The samples of one message come from one worker. The time of a sample that killed its workers is unknown.
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
            known.so_far.see(&entry.outcome);
            known.events.iter_mut().for_each(|events| events.sample(sample, &entry));
        }
        self.uncommitted.push(sample);
        self.record.put(sample, self.keys.key(sample), &entry, Instant::now()).map_err(not_recorded)?;
        self.note_durable();
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        self.record.commit().map_err(not_recorded)?;
        self.note_durable();
        Ok(())
    }

    fn more(&mut self) -> Result<More, SinkError> {
        self.listener.more()
    }

    fn check(&mut self) -> Result<(), SinkError> {
        self.listener.check()?;
        if self.watch.finds_loss(self.record) {
            // The reason is determined and reported when the run has stopped.
            return Err(SinkError {
                what: "the result directory was moved or removed during the run".to_owned(),
                source: None,
            });
        }
        Ok(())
    }
}

fn not_recorded(error: RecordError) -> SinkError {
    SinkError { what: "finished samples cannot be recorded".to_owned(), source: Some(Box::new(error)) }
}
