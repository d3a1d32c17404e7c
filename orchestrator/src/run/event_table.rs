//! Table of the events of `--json-events`, from which the reference is generated. A test of [`super::events`] compares it with the printed events.

/// One kind of event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EventKind {
    /// Value of the field `event`.
    pub name: &'static str,
    /// When it is printed.
    pub meaning: &'static str,
    /// Fields with their meanings, except `event` and `elapsed_s`, which every event has.
    pub fields: &'static [(&'static str, &'static str)],
}

const fn event(
    name: &'static str,
    meaning: &'static str,
    fields: &'static [(&'static str, &'static str)],
) -> EventKind {
    EventKind { name, meaning, fields }
}

const TIME: (&str, &str) = ("time", "time in UTC");
const WORKER: (&str, &str) = ("worker", "number of the worker, over all that the run has started");

#[rustfmt::skip]
/// Every event, in the order of a run.
pub const EVENTS: &[EventKind] = &[
    event("started", "samples are about to be computed", &[
        ("version", "version of this format; raised when a field changes its meaning or is removed"), TIME,
        ("study", "name of the study"), ("directory", "result directory"), ("samples", "samples of the study"),
        ("recorded", "samples that earlier runs finished"), ("workers", "worker processes"),
    ]),
    event("worker_started", "a worker process was started", &[
        WORKER, ("pid", "process id"), ("replaces", "dead worker that it replaces, the earliest one; null for the first workers"),
    ]),
    event("worker_stale", "a worker has sent no message for 5 s", &[WORKER]),
    event("worker_heard", "a stale worker has sent a message again", &[WORKER]),
    event("worker_killed", "the run kills a worker", &[
        WORKER, ("why", "`time_limit`, `silent` (no message for 30 s), `lost` (it missed a message), `ending`"),
    ]),
    event("worker_ended", "a worker process ended", &[
        WORKER, ("how", "exit status or signal"), ("died", "true if it should not have ended"),
    ]),
    event("sample", "the result of a sample is durable", &[
        ("sample", "number of the sample"), ("status", "`ok`, `beyond`, `invalid`, `failed`, `quarantined`"), ("cause", "cause of a status that is not `ok`, or null"),
        ("cpu_s", "CPU time"), WORKER, ("attempt", "number of the attempt"),
    ]),
    event("progress", "once a second at most, and at the last sample", &[
        ("done", "finished samples of this run"), ("total", "samples of this run"), ("by_status", "number of samples for each status"), ("per_second", "pace"),
        ("left_from_s", "least remaining time, or null"), ("left_to_s", "most remaining time, or null"), ("worker_deaths", "workers that died"),
        ("dropped_messages", "messages that were rejected (damaged, of another run), and results that were late, doubled or not requested"),
    ]),
    event("stopping", "no further sample is assigned", &[
        ("why", "`interrupted`, `terminated`, `wall`, `until`, `max_failures`"),
    ]),
    event("not_removed", "a file of the run in /dev/shm is left; not an error of the run", &[("what", "file and reason")]),
    event("finished", "the run is over and its tables are written", &[
        ("why", "as in `stopping`, or `complete`, or `stop` (complete by `[stop]` or `[refine]`)"), TIME,
        ("done", "finished samples of the study"), ("samples", "samples of the study"),
        ("table", "results.parquet, or the folder of the parts of an incomplete study; empty before there is a row"),
    ]),
    event("failed", "the run ended by an error", &[TIME, ("error", "message")]),
    event("lost", "the reader was slow and events are missing here", &[("events", "number of missing events")]),
];
