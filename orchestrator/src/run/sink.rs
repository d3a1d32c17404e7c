//! From the dispatch loop into the ledger, counting on the way.

use super::events::EventStream;
use super::kept::Guard;
use super::parts::Teller;
use super::status::{StatusWriter, describe};
use crate::dispatch::{Notice, Observer, SampleResult, Sink, SinkError};
use crate::ledger::{Entry, Ledger, LedgerError};
use crate::report::{Costs, Progress, Tally, Underway};
use crate::schedule::{Activity, Snapshot, WorkerView};
use bladeoff_core::outcome::Status;
use bladeoff_study::SampleKeys;
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

/// Records results and counts them.
pub(super) struct LedgerSink<'a> {
    pub ledger: &'a mut Ledger,
    pub keys: &'a SampleKeys<'a>,
    /// Everything taken, for the progress shown.
    pub tally: Rc<RefCell<Tally>>,
    /// What of it is durable: that alone is told to others, and counts when the record fails.
    pub durable: Rc<RefCell<Tally>>,
    pub watched: Rc<RefCell<Watched>>,
    /// Taken and not durable yet.
    pub gathered: Vec<u64>,
    /// Who writes rows once they are.
    pub parts: &'a Teller<'a>,
    /// Looks after the directory.
    pub guard: Guard<'a>,
}

/// What sink and observer share beside the counts.
#[derive(Debug, Default)]
pub(super) struct Watched {
    /// What the samples of this run cost.
    pub costs: Costs,
    /// Where programs are told.
    pub events: Option<EventStream>,
}

impl Sink for LedgerSink<'_> {
    fn record_all(&mut self, results: &mut Vec<SampleResult>) -> Result<(), SinkError> {
        // Those of one message are of one worker. What a sample took that killed its workers, nobody has reported.
        let ended = || results.iter().filter(|result| result.outcome.status != Status::Quarantined);
        if let Some(first) = ended().next() {
            let cpu_s: Vec<f64> = ended().map(|result| result.cpu_s).collect();
            self.watched.borrow_mut().costs.add(first.worker, &cpu_s, Instant::now());
        }
        results.drain(..).try_for_each(|result| self.record(result))
    }

    fn record(&mut self, result: SampleResult) -> Result<(), SinkError> {
        self.tally.borrow_mut().add(&result.outcome);
        let mut watched = self.watched.borrow_mut();
        watched.events.iter_mut().for_each(|events| events.sample(&result));
        drop(watched);
        let entry =
            Entry { outcome: result.outcome, cpu_s: result.cpu_s, worker: result.worker, attempt: result.attempt };
        self.gathered.push(result.sample);
        self.ledger.put(result.sample, self.keys.key(result.sample), &entry, Instant::now()).map_err(refused)?;
        self.note_durable();
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        self.ledger.commit().map_err(refused)?;
        self.note_durable();
        Ok(())
    }

    fn check(&mut self) -> Result<(), SinkError> {
        if self.guard.finds_loss(self.ledger) {
            // Why is found out again, and told, when the run has stopped.
            return Err(SinkError {
                what: "the result directory was moved or removed during the run".to_owned(),
                source: None,
            });
        }
        Ok(())
    }
}

impl LedgerSink<'_> {
    /// Whatever a commit has made durable counts from now on, and only that: a commit that fails leaves it all gathered.
    fn note_durable(&mut self) {
        if self.ledger.gathered() == 0 && !self.gathered.is_empty() {
            *self.durable.borrow_mut() = self.tally.borrow().clone();
            self.parts.durable(std::mem::take(&mut self.gathered));
            self.watched.borrow_mut().events.iter_mut().for_each(EventStream::durable);
        }
    }

    /// Commits what is left.
    pub fn close(mut self) -> Result<(), LedgerError> {
        let committed = self.ledger.commit();
        self.note_durable();
        committed
    }
}

fn refused(error: LedgerError) -> SinkError {
    SinkError { what: "finished samples cannot be recorded".to_owned(), source: Some(Box::new(error)) }
}

fn underway(snapshot: &Snapshot, now: Instant) -> Underway {
    let busy = |worker: &&WorkerView| matches!(worker.activity, Activity::Busy { .. });
    Underway {
        left: snapshot.total - snapshot.done,
        computing: snapshot.computing,
        workers: snapshot.workers.len(),
        busy: snapshot.workers.iter().filter(busy).map(|worker| (worker.worker, worker.since)).collect(),
        now,
    }
}

/// Shows how far the study is.
#[derive(Debug)]
pub(super) struct ProgressObserver {
    pub progress: Progress,
    pub status: StatusWriter,
    /// Everything taken.
    pub tally: Rc<RefCell<Tally>>,
    /// What of it is durable.
    pub durable: Rc<RefCell<Tally>>,
    pub watched: Rc<RefCell<Watched>>,
}

impl Observer for ProgressObserver {
    fn progress(&mut self, snapshot: &Snapshot) {
        let stale = snapshot.workers.iter().filter(|worker| worker.stale).count();
        let now = Instant::now();
        let mut watched = self.watched.borrow_mut();
        let eta = watched.costs.eta(&underway(snapshot, now));
        watched.events.iter_mut().for_each(|events| events.progress(snapshot, eta));
        self.progress.update(&self.tally.borrow(), eta, stale, now);
        self.status.update(snapshot, eta, &self.durable.borrow(), now);
    }

    fn asked(&mut self, snapshot: &Snapshot) {
        for worker in &snapshot.workers {
            self.progress.note(&describe(worker));
        }
    }

    fn typed(&mut self) {
        self.progress.typed();
    }

    fn noticed(&mut self, notice: &Notice) {
        self.watched.borrow_mut().events.iter_mut().for_each(|events| events.noticed(notice));
        match notice {
            Notice::Stopping(_) => {
                self.progress.note("stopping: samples in work may finish; a second signal ends them at once");
            }
            Notice::NotRemoved { what } => self.progress.note(what),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_study::{Samples, load};
    use bladeoff_system::folder::Folder;
    use serde_json::Value;
    use std::fs;
    use std::path::Path;
    use std::time::Duration;

    #[test]
    fn the_status_of_a_running_study_counts_what_is_durable() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let rig = Path::new(env!("CARGO_MANIFEST_DIR")).join("../studies/machines/lab_rig.toml");
        fs::copy(rig, folder.path().join("rig.toml")).expect("copied");
        let file = folder.path().join("s.toml");
        fs::write(&file, "schema = 1\nmachine = \"rig.toml\"\n").expect("written");
        let samples = Samples::new(load(&file, |_| Vec::new()).expect("a study"), None, None).expect("one sample");
        let (mut taken, mut durable) = (Tally::default(), Tally::default());
        (0..3).for_each(|_| taken.count(Status::Ok, None));
        durable.count(Status::Ok, None);
        let now = Instant::now();
        let mut observer = ProgressObserver {
            progress: Progress::start(5, 0, now),
            status: StatusWriter::new(&Folder::open(folder.path()).expect("opened"), &samples, 0),
            tally: Rc::new(RefCell::new(taken)),
            durable: Rc::new(RefCell::new(durable)),
            watched: Rc::default(),
        };
        observer.progress(&Snapshot {
            elapsed: Duration::from_secs(1),
            computing: Duration::from_secs(1),
            total: 5,
            done: 3,
            by_status: [0; Status::ALL.len()],
            by_cause: [0; bladeoff_core::outcome::Cause::ALL.len()],
            rate: 1.0,
            worker_deaths: 0,
            dropped_messages: 0,
            workers: Vec::new(),
        });
        let told = || serde_json::from_slice::<Value>(&fs::read(folder.path().join("status.json")).expect("told"));
        let value = told().expect("JSON");
        assert_eq!((&value["state"], &value["done"]), (&"running".into(), &1.into()));
        // No new file can be made beside a name of this length: the end is told in the old one, and nothing is left aside.
        let longest = "s".repeat(250);
        fs::rename(folder.path().join("status.json"), folder.path().join(&longest)).expect("renamed");
        observer.status.written_to(Folder::open(folder.path()).expect("opened").place(&longest));
        let told = || serde_json::from_slice::<Value>(&fs::read(folder.path().join(&longest)).expect("told"));
        let error = std::io::Error::other("no space");
        let durable = observer.durable.borrow().clone();
        observer.status.finish("failed", Some(&error), &durable);
        let value = told().expect("JSON");
        assert_eq!((&value["state"], &value["error"]), (&"failed".into(), &"no space".into()));
    }
}
