//! Reports of a run in progress to the terminal, to `status.json` and to programs: results and workers.

use super::error::RunError;
use super::events::EventStream;
use super::open::Session;
use super::request::{Finished, Request};
use super::so_far::SoFar;
use super::status::{StatusWriter, describe};
use crate::dispatch::{DispatchError, Notice, Observer};
use crate::schedule::{Activity, Snapshot, WorkerView};
use crate::terminal::{Costs, Progress, Tally, Underway};
use std::cell::RefCell;
use std::io::{self, IsTerminal};
use std::path::Path;
use std::rc::Rc;
use std::time::Instant;

/// Counts shared by the sink of results and the observer of workers.
#[derive(Debug, Default)]
pub(super) struct Known {
    /// Received results, for the progress display.
    pub taken: Tally,
    /// Durable results; only these are reported to others and count if the record fails.
    pub durable: Tally,
    /// Costs of the samples of this run.
    pub costs: Costs,
    /// Worst value and first answer of this run.
    pub so_far: SoFar,
    /// Events for programs.
    pub events: Option<EventStream>,
}

impl Known {
    /// Begins with empty counts and starts the events, if requested.
    pub fn begin(request: &Request) -> Result<Rc<RefCell<Self>>, RunError> {
        let events = request.json_events.then(|| EventStream::start(io::stdout())).transpose();
        let events = events.map_err(|source| DispatchError::System { doing: "starting the thread for events", source });
        Ok(Rc::new(RefCell::new(Self { events: events?, ..Self::default() })))
    }

    /// Reports the end of the run, with so many samples, to programs; returns it.
    pub fn end(&mut self, finished: Result<Finished, RunError>, samples: u64) -> Result<Finished, RunError> {
        if let Some(events) = self.events.take() {
            match &finished {
                Ok(done) => {
                    let table = done.table.as_deref().unwrap_or(Path::new("")).to_string_lossy();
                    events.finished(done.ended, done.tally.done(), samples, &table);
                }
                Err(error) => events.failed(error),
            }
        }
        finished
    }
}

/// Reporter of the progress of a study.
#[derive(Debug)]
pub(super) struct Telling {
    pub progress: Progress,
    status: StatusWriter,
    pub known: Rc<RefCell<Known>>,
}

impl Telling {
    /// Begins the status file of the run.
    pub fn begin(session: &Session<'_>, known: &Rc<RefCell<Known>>) -> Self {
        let (samples, tally) = (session.prepared.samples, &session.opened.tally);
        let reused = tally.done();
        {
            let known = &mut *known.borrow_mut();
            (known.taken, known.durable) = (tally.clone(), tally.clone());
            known.so_far = SoFar::new(&session.request.watched, session.prepared.schema.outcome());
        }
        let status = StatusWriter::new(session.directory.open(), samples, reused).trusting(session.request.trusts);
        let progress = Progress::start(samples.count(), reused, Instant::now());
        let mut telling = Self { progress, status, known: Rc::clone(known) };
        telling.status.begin(tally);
        telling
    }

    /// Reports that computing begins.
    pub fn started(&mut self, session: &Session<'_>) {
        if self.progress.is_on_terminal() && io::stdin().is_terminal() {
            self.progress.note("s and Enter: what each worker does; Ctrl-C: ends in order");
        }
        if let Some(events) = &mut self.known.borrow_mut().events {
            let (samples, reused) = (session.prepared.samples, session.opened.tally.done());
            let directory = session.directory.path().to_string_lossy();
            events.started(&samples.study().name, &directory, samples.count(), reused, session.request.workers);
        }
    }

    /// Counts of the durable results.
    pub fn durable(&self) -> Tally {
        self.known.borrow().durable.clone()
    }

    /// Writes the end of the run into the status file, after success and failure.
    pub fn end(&mut self, finished: &Result<Finished, RunError>) {
        let durable = self.durable();
        match finished {
            Ok(finished) => {
                self.status.tell_end(finished.ended, finished.end);
                let surplus = durable.done().saturating_sub(finished.tally.done());
                self.status.finish(finished.ended.state(), None, &finished.tally, surplus);
            }
            Err(error) => self.status.finish("failed", Some(error), &durable, 0),
        }
    }
}

impl Observer for Telling {
    fn progress(&mut self, snapshot: &Snapshot) {
        let stale = snapshot.workers.iter().filter(|worker| worker.stale).count();
        let now = Instant::now();
        let known = &mut *self.known.borrow_mut();
        let eta = known.costs.eta(&underway(snapshot, now));
        known.events.iter_mut().for_each(|events| events.progress(snapshot, eta));
        self.progress.update(&known.taken, eta, (stale, &known.so_far.text()), now);
        self.status.update(snapshot, eta, &known.durable, now);
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
        self.known.borrow_mut().events.iter_mut().for_each(|events| events.noticed(notice));
        match notice {
            Notice::Stopping(_) => {
                self.progress.note("stopping: waiting for samples in progress; a second signal ends them at once");
            }
            Notice::NotRemoved { what } => self.progress.note(what),
            _ => {}
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::outcome::Status;
    use bladeoff_study::{Samples, load};
    use bladeoff_system::folder::Folder;
    use serde_json::Value;
    use std::fs;
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
        let mut observer = Telling {
            progress: Progress::start(5, 0, now),
            status: StatusWriter::new(&Folder::open(folder.path()).expect("opened"), &samples, 0),
            known: Rc::new(RefCell::new(Known { taken, durable, ..Known::default() })),
        };
        observer.progress(&Snapshot {
            elapsed: Duration::from_secs(1),
            computing: Duration::from_secs(1),
            total: 5,
            done: 3,
            by_status: [0; Status::ALL.len()],
            by_cause: [0; bladeoff_model::outcome::Cause::ALL.len()],
            rate: 1.0,
            worker_deaths: 0,
            dropped_messages: 0,
            workers: Vec::new(),
        });
        let told = || serde_json::from_slice::<Value>(&fs::read(folder.path().join("status.json")).expect("told"));
        let value = told().expect("JSON");
        assert_eq!((&value["state"], &value["done"]), (&"running".into(), &1.into()));
        // A name of this length leaves no space for a temporary name: the end is written into the old file, and no temporary file
        // remains.
        let longest = "s".repeat(250);
        fs::rename(folder.path().join("status.json"), folder.path().join(&longest)).expect("renamed");
        observer.status.written_to(Folder::open(folder.path()).expect("opened").place(&longest));
        let told = || serde_json::from_slice::<Value>(&fs::read(folder.path().join(&longest)).expect("told"));
        let error = std::io::Error::other("no space");
        let durable = observer.durable();
        observer.status.finish("failed", Some(&error), &durable, 0);
        let value = told().expect("JSON");
        assert_eq!((&value["state"], &value["error"]), (&"failed".into(), &"no space".into()));
    }
}
