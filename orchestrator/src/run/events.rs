//! `--json-events`: events for other programs. One JSON object per line on standard output; fields: [`super::event_table`].
//!
//! A slow or missing reader never delays a study. Lines wait in a queue of limited length for a writing thread; lines that do not fit are
//! counted and reported (`lost`). A closed pipe ends only the stream.

use super::stamp::timestamp;
use crate::dispatch::{Ended, KillReason, Notice};
use crate::schedule::Snapshot;
use crate::terminal::Eta;
use bladeoff_model::outcome::{Cause, Status};
use bladeoff_record::Entry;
use bladeoff_system::with_causes;
use bladeoff_text::document::visible_json;
use serde_json::{Value, json};
use std::collections::{BTreeSet, VecDeque};
use std::io::{self, BufWriter, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::time::{Duration, Instant, SystemTime};

/// Schema version; increased when a field changes its meaning or is removed.
pub const EVENTS_VERSION: u32 = 2;
/// Largest number of waiting lines, about ten megabytes.
const QUEUE: usize = 65_536;
/// Time between two `progress` events.
const PROGRESS_EVERY: Duration = Duration::from_secs(1);
/// Largest time for which the run waits for the last lines at its end.
const LAST_LINES: Duration = Duration::from_secs(10);

/// Event stream of one run.
#[derive(Debug)]
pub(super) struct EventStream {
    begun: Instant,
    queue: Option<SyncSender<String>>,
    written: Receiver<()>,
    lost: u64,
    progress: Option<Instant>,
    stale: BTreeSet<u32>,
    /// Dead workers not yet replaced.
    dead: VecDeque<u32>,
    /// Results that are not durable yet.
    waiting: Vec<Value>,
}

impl EventStream {
    /// A stream into `out`, written by a thread of its own.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn start(out: impl Write + Send + 'static) -> io::Result<Self> {
        let (queue, lines) = sync_channel(QUEUE);
        let (done, written) = sync_channel(1);
        let body = move || {
            // a closed pipe does not stop the study
            let _ = write_lines(&lines, out);
            let _ = done.send(());
        };
        std::thread::Builder::new().name("events".into()).spawn(body)?;
        Ok(Self {
            begun: Instant::now(),
            queue: Some(queue),
            written,
            lost: 0,
            progress: None,
            stale: BTreeSet::new(),
            dead: VecDeque::new(),
            waiting: Vec::new(),
        })
    }

    /// The run has begun. `recorded`: samples finished before.
    pub fn started(&mut self, study: &str, directory: &str, samples: u64, recorded: u64, workers: usize) {
        self.emit(
            "started",
            json!({
                "version": EVENTS_VERSION,
                "time": timestamp(SystemTime::now()),
                "study": study,
                "directory": directory,
                "samples": samples,
                "recorded": recorded,
                "workers": workers,
            }),
        );
    }

    /// A sample has ended; the event is sent when the result is durable.
    pub fn sample(&mut self, sample: u64, entry: &Entry) {
        self.waiting.push(json!({
            "sample": sample,
            "status": entry.outcome.status.word(),
            "cause": entry.outcome.cause.map(Cause::word),
            "cpu_s": entry.cpu_s,
            "worker": entry.worker,
            "attempt": entry.attempt,
        }));
    }

    /// All results of `sample` so far are durable.
    pub fn durable(&mut self) {
        for sample in std::mem::take(&mut self.waiting) {
            self.emit("sample", sample);
        }
    }

    /// Progress of the run: at most once a second, and at the end.
    pub fn progress(&mut self, snapshot: &Snapshot, eta: Option<Eta>) {
        let stale: BTreeSet<u32> = snapshot.workers.iter().filter(|w| w.stale).map(|w| w.worker).collect();
        let there: BTreeSet<u32> = snapshot.workers.iter().map(|w| w.worker).collect();
        let before = std::mem::replace(&mut self.stale, stale.clone());
        stale.difference(&before).for_each(|&worker| self.emit("worker_stale", json!({ "worker": worker })));
        let heard = before.difference(&stale).filter(|worker| there.contains(worker));
        heard.for_each(|&worker| self.emit("worker_heard", json!({ "worker": worker })));
        let is_last = snapshot.done == snapshot.total;
        if self.progress.is_some_and(|last| last.elapsed() < PROGRESS_EVERY) && !is_last {
            return;
        }
        self.progress = Some(Instant::now());
        let statuses = Status::ALL
            .iter()
            .map(|status| (status.word().to_owned(), Value::from(snapshot.by_status[usize::from(status.code())])));
        self.emit(
            "progress",
            json!({
                "done": snapshot.done,
                "total": snapshot.total,
                "by_status": statuses.collect::<serde_json::Map<_, _>>(),
                "per_second": snapshot.rate,
                "left_from_s": eta.map(|eta| eta.low.as_secs_f64()),
                "left_to_s": eta.map(|eta| eta.high.as_secs_f64()),
                "worker_deaths": snapshot.worker_deaths,
                "dropped_messages": snapshot.dropped_messages,
            }),
        );
    }

    /// Event of a worker or of the run.
    pub fn noticed(&mut self, notice: &Notice) {
        match notice {
            Notice::WorkerStarted { worker, pid } => {
                let replaces = self.dead.pop_front();
                self.emit("worker_started", json!({ "worker": worker, "pid": pid, "replaces": replaces }));
            }
            Notice::WorkerKilled { worker, why } => {
                let why = match why {
                    KillReason::TimeLimit => "time_limit",
                    KillReason::Silent => "silent",
                    KillReason::Lost => "lost",
                    KillReason::Ending => "ending",
                };
                self.emit("worker_killed", json!({ "worker": worker, "why": why }));
            }
            Notice::WorkerEnded { worker, how, died } => {
                if *died {
                    self.dead.push_back(*worker);
                }
                self.emit("worker_ended", json!({ "worker": worker, "how": how, "died": died }));
            }
            Notice::Stopping(why) => self.emit("stopping", json!({ "why": why.word() })),
            Notice::NotRemoved { what } => self.emit("not_removed", json!({ "what": what })),
        }
    }

    /// The run has ended and its table is written.
    pub fn finished(mut self, ended: Ended, done: u64, samples: u64, table: &str) {
        let fields = json!({
            "why": ended.word(),
            "time": timestamp(SystemTime::now()),
            "done": done,
            "samples": samples,
            "table": table,
        });
        self.end("finished", fields);
    }

    /// The run ended with an error. Results that could not be made durable are never reported.
    pub fn failed(mut self, error: &(dyn std::error::Error + 'static)) {
        self.end("failed", json!({ "time": timestamp(SystemTime::now()), "error": with_causes(error) }));
    }

    /// Sends the last event; a slow reader has the same time for it as for all lines before it.
    fn end(&mut self, event: &str, fields: Value) {
        let begun = Instant::now();
        while !self.is_taken(event, &fields) && begun.elapsed() < LAST_LINES {
            std::thread::sleep(Duration::from_millis(1));
        }
        self.queue = None;
        if let Err(RecvTimeoutError::Timeout) = self.written.recv_timeout(LAST_LINES) {
            // a stuck reader: the thread ends with the process
        }
    }

    fn emit(&mut self, event: &str, fields: Value) {
        self.lost += u64::from(!self.is_taken(event, &fields));
    }

    /// Passes an event to the writing thread, preceded by the number of lost events; returns `false` if the queue is full. Without a reader,
    /// the event is discarded and the result is `true`.
    fn is_taken(&mut self, event: &str, fields: &Value) -> bool {
        let Some(queue) = &self.queue else { return true };
        let line = |event: &str, mut fields: Value| {
            fields["event"] = event.into();
            // Milliseconds are enough, and short to read.
            fields["elapsed_s"] = ((self.begun.elapsed().as_secs_f64() * 1e3).round() / 1e3).into();
            fields.to_string()
        };
        if self.lost > 0 {
            match queue.try_send(line("lost", json!({ "events": self.lost }))) {
                Ok(()) => self.lost = 0,
                Err(TrySendError::Full(_)) => return false,
                Err(TrySendError::Disconnected(_)) => {}
            }
        }
        match queue.try_send(line(event, fields.clone())) {
            Ok(()) => true,
            Err(TrySendError::Full(_)) => false,
            Err(TrySendError::Disconnected(_)) => {
                self.queue = None;
                true
            }
        }
    }
}

fn write_lines(lines: &Receiver<String>, out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    while let Ok(first) = lines.recv() {
        writeln!(out, "{}", visible_json(&first))?;
        for line in lines.try_iter() {
            writeln!(out, "{}", visible_json(&line))?;
        }
        out.flush()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Condvar, Mutex};

    /// A reader that takes nothing until the test allows it.
    #[derive(Clone, Default)]
    struct Slow(Arc<(Mutex<(bool, Vec<u8>)>, Condvar)>);

    impl Write for Slow {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let (state, changed) = &*self.0;
            let mut state = changed.wait_while(state.lock().expect("no panic"), |state| !state.0).expect("no panic");
            state.1.extend(bytes);
            Ok(bytes.len())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_slow_reader_holds_up_nobody_and_is_told_what_it_missed() {
        let slow = Slow::default();
        let mut events = EventStream::start(slow.clone()).expect("a thread");
        let notice = Notice::WorkerStarted { worker: 1, pid: 2 };
        let sent = 3 * QUEUE as u64;
        (0..sent).for_each(|_| events.noticed(&notice));
        {
            let (state, changed) = &*slow.0;
            state.lock().expect("no panic").0 = true;
            changed.notify_all();
        }
        // until the queue has room again
        while events.lost > 0 {
            events.noticed(&notice);
            std::thread::yield_now();
        }
        events.finished(Ended::Complete, 0, 0, "t");
        let state = slow.0.0.lock().expect("no panic");
        let text = String::from_utf8(state.1.clone()).expect("UTF-8");
        let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
        let of = |event: &str| lines.iter().filter(|line| line["event"] == event).count() as u64;
        let lost: u64 = lines.iter().filter_map(|line| line["events"].as_u64()).sum();
        assert!(lost > 0 && of("lost") > 0 && of("worker_started") + lost >= sent);
        assert_eq!(lines.last().expect("lines")["event"], "finished");
    }

    /// The table of events lists exactly the events and fields that are sent.
    #[test]
    fn events_have_the_fields_of_their_table() {
        use super::super::event_table::EVENTS;
        use crate::schedule::{Activity, WorkerView};
        use bladeoff_model::outcome::{CauseSet, EndCause, Outcome};
        use std::collections::BTreeMap;
        #[derive(Clone, Default)]
        struct Kept(Arc<Mutex<Vec<u8>>>);
        impl Write for Kept {
            fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
                self.0.lock().expect("no panic").extend(bytes);
                Ok(bytes.len())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let kept = Kept::default();
        let stream = || EventStream::start(kept.clone()).expect("a thread");
        let mut events = stream();
        events.started("study", "runs/study", 2, 0, 1);
        let (causes, notes) = (CauseSet::default(), CauseSet::default());
        let (status, end_cause) = (Status::Ok, EndCause::EndTime);
        let outcome = Outcome { status, cause: None, causes, notes, end_cause, values: Vec::new() };
        events.sample(0, &Entry { outcome, cpu_s: 0.1, worker: 1, attempt: 1 });
        events.durable();
        for stale in [false, true, false] {
            let worker = WorkerView { worker: 1, pid: None, activity: Activity::Idle, stale, since: Duration::ZERO };
            let snapshot = Snapshot {
                elapsed: Duration::ZERO,
                computing: Duration::ZERO,
                total: 2,
                done: 0,
                by_status: [0; Status::ALL.len()],
                by_cause: [0; Cause::ALL.len()],
                rate: 0.0,
                worker_deaths: 0,
                dropped_messages: 0,
                workers: vec![worker],
            };
            events.progress(&snapshot, None);
        }
        events.noticed(&Notice::WorkerStarted { worker: 1, pid: 2 });
        events.noticed(&Notice::WorkerKilled { worker: 1, why: KillReason::Silent });
        events.noticed(&Notice::WorkerEnded { worker: 1, how: "signal 9".to_owned(), died: true });
        events.noticed(&Notice::Stopping(Ended::Wall));
        events.noticed(&Notice::NotRemoved { what: "/dev/shm/x".to_owned() });
        events.lost = 1;
        events.finished(Ended::Wall, 1, 2, "parts");
        stream().failed(&io::Error::other("disk"));
        let bytes = kept.0.lock().expect("no panic").clone();
        let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for line in String::from_utf8(bytes).expect("UTF-8").lines() {
            let mut event: serde_json::Map<String, Value> = serde_json::from_str(line).expect("JSON");
            let name = event.remove("event").and_then(|name| Some(name.as_str()?.to_owned())).expect("a name");
            assert!(event.remove("elapsed_s").is_some_and(|time| time.is_number()), "{line}");
            found.insert(name, event.keys().cloned().collect());
        }
        let names = |fields: &[(&str, &str)]| fields.iter().map(|(name, _)| (*name).to_owned()).collect();
        let table = EVENTS.iter().map(|event| (event.name.to_owned(), names(event.fields)));
        assert_eq!(found, table.collect::<BTreeMap<String, BTreeSet<String>>>());
    }

    #[test]
    fn a_reader_that_left_is_nobody() {
        struct Gone;
        impl Write for Gone {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::ErrorKind::BrokenPipe.into())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let mut events = EventStream::start(Gone).expect("a thread");
        (0..10).for_each(|_| events.noticed(&Notice::Stopping(Ended::Wall)));
        events.finished(Ended::Wall, 0, 0, "t");
    }
}
