//! Publisher of a shard: a thread that finds chunks to compute and publishes finished ones. A slow file system delays neither
//! workers nor heartbeats.
//!
//! ```text
//! run, by its sink      samples durable in its own record -> publisher: chunk complete -> file, link(2)
//!                       request for samples -> publisher: next missing chunk, hint -> samples missing in its record
//! ```

use super::super::directory::RESULTS;
use super::super::prepare::Prepared;
use super::super::sink::DurableListener;
use super::attempt::{Attempt, Counts, RUNNING, heartbeat_interval, hinted_chunks, is_in_progress_elsewhere};
use super::choose::{Choice, ChunkChooser, ChunkState, Lookup};
use super::chunk::encode;
use super::error::ShardError;
use super::layout::{CHUNKS, Chunks, SHARDS, chunk_name, folder_of};
use super::publish::{Put, put_once};
use super::retry::Retry;
use super::shards_file::ShardsFile;
use super::shared::Shared;
use super::takeover::taken_over;
use crate::dispatch::{More, SinkError};
use crate::schedule::Todo;
use bladeoff_model::outcome::{Cause, Status};
use bladeoff_record::{Head, Reader};
use bladeoff_system::files::FileError;
use bladeoff_system::with_causes;
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

/// Interval of checks of chunks in progress elsewhere.
const POLL_INTERVAL: Duration = Duration::from_secs(1);

/// Message to the publisher.
enum PublisherRequest {
    /// Samples have become durable in the shard's own record.
    Durable(Vec<u64>),
    /// The run asks for more samples.
    MoreSamples,
}

/// Reply of the publisher.
enum PublisherReply {
    /// Samples of a chunk to compute.
    Samples(Todo),
    /// No chunk is left for this attempt.
    NoneLeft,
    /// The publisher has failed, with the message of its error.
    Failed(String),
}

/// Handle of the run to the publisher thread.
pub(super) struct PublisherHandle {
    requests: Option<Sender<PublisherRequest>>,
    replies: Receiver<PublisherReply>,
    is_request_pending: Cell<bool>,
    failed: RefCell<Option<String>>,
}

impl PublisherHandle {
    fn send(&self, request: PublisherRequest) {
        // The thread ends after this handle, or by a panic, which `join` passes on.
        let _ = self.requests.as_ref().is_some_and(|requests| requests.send(request).is_ok());
    }

    fn failure(&self) -> Option<SinkError> {
        let what = self.failed.borrow().clone()?;
        Some(SinkError { what, source: None })
    }

    fn try_reply(&self) -> Result<Option<PublisherReply>, SinkError> {
        match self.replies.try_recv() {
            Ok(PublisherReply::Failed(why)) => {
                *self.failed.borrow_mut() = Some(why);
                Err(self.failure().expect("set above"))
            }
            Ok(given) => Ok(Some(given)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Ok(Some(PublisherReply::NoneLeft)),
        }
    }
}

impl DurableListener for PublisherHandle {
    fn samples_durable(&self, samples: Vec<u64>) {
        self.send(PublisherRequest::Durable(samples));
    }

    fn more(&self) -> Result<More, SinkError> {
        if let Some(failure) = self.failure() {
            return Err(failure);
        }
        if !self.is_request_pending.replace(true) {
            self.send(PublisherRequest::MoreSamples);
        }
        Ok(match self.try_reply()? {
            None => More::Later,
            Some(PublisherReply::NoneLeft | PublisherReply::Failed(_)) => More::Nothing,
            Some(PublisherReply::Samples(todo)) => {
                self.is_request_pending.set(false);
                More::Samples(todo)
            }
        })
    }

    fn check(&self) -> Result<(), SinkError> {
        self.failure().map_or(Ok(()), Err)
    }
}

/// Objects that a publisher uses.
pub(super) struct PublisherContext<'a> {
    pub shared: &'a Shared,
    pub shards_file: &'a ShardsFile,
    pub prepared: &'a Prepared<'a>,
    pub record: &'a Reader,
    pub attempt: &'a Attempt,
    /// Largest set of chunks that the study needs.
    pub needed: Chunks,
    /// Whether a merge may end the study before all chunks exist.
    pub may_end: bool,
    pub patience: Duration,
    pub note: &'a (dyn Fn(&str) + Sync),
}

/// Runs `work` while the publisher thread finds and publishes chunks. The second result has the counts of the publisher or its
/// error.
///
/// # Errors
/// The thread cannot be started; `work` was not run.
pub(super) fn published_beside<T>(
    context: &PublisherContext<'_>,
    work: impl FnOnce(&PublisherHandle) -> T,
) -> Result<(T, Result<Counts, ShardError>), ShardError> {
    let is_over = AtomicBool::new(false);
    let is_over = &is_over;
    thread::scope(|scope| {
        let (requests, receiver) = channel();
        let (sender, replies) = channel();
        let (is_request_pending, failed) = (Cell::new(false), RefCell::new(None));
        // Dropped also when the work panics: the thread is joined.
        let handle = PublisherHandle { requests: Some(requests), replies, is_request_pending, failed };
        let body = move || {
            let mut publisher = Publisher::new(context, is_over);
            let done = publisher.run(&receiver, &sender);
            if let Err(error) = &done {
                // The run stops computing.
                let _ = sender.send(PublisherReply::Failed(with_causes(error)));
            }
            publisher.report_end(done.is_ok());
            done.map(|()| publisher.counts)
        };
        let thread =
            thread::Builder::new().name("publisher".into()).spawn_scoped(scope, body).map_err(ShardError::Thread)?;
        let done = work(&handle);
        is_over.store(true, Ordering::Relaxed);
        drop(handle);
        let published = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        Ok((done, published))
    })
}

/// Chunk in progress in this attempt.
struct ChunkInProgress {
    /// Number of samples that are not durable yet.
    left: u64,
    /// Entries reused from another directory.
    taken_over: BTreeMap<u64, Vec<u8>>,
}

struct Publisher<'a> {
    context: &'a PublisherContext<'a>,
    patience: Retry<'a>,
    chooser: ChunkChooser,
    /// Chunks in progress in this attempt.
    in_progress: BTreeMap<u64, ChunkInProgress>,
    counts: Counts,
    /// Interval of heartbeats.
    heartbeat_interval: Duration,
    /// Last heartbeat: by the clock of this process, and by that of the file server.
    last_heartbeat: Option<(Instant, SystemTime)>,
    /// Whether the record has entries of an earlier attempt on this node.
    has_earlier_entries: bool,
    /// Last listed folder with chunks of other shards.
    listing: Option<FolderListing>,
}

impl<'a> Publisher<'a> {
    fn new(context: &'a PublisherContext<'a>, is_over: &'a AtomicBool) -> Self {
        Self {
            patience: Retry::new(context.shared, context.patience, is_over, context.note),
            chooser: ChunkChooser::new(context.attempt.shard, context.needed.count()),
            in_progress: BTreeMap::new(),
            counts: Counts::default(),
            heartbeat_interval: heartbeat_interval(context.attempt.shard.of),
            last_heartbeat: None,
            has_earlier_entries: context.record.is_empty().is_ok_and(|is_empty| !is_empty),
            listing: None,
            context,
        }
    }

    fn run(
        &mut self,
        requests: &Receiver<PublisherRequest>,
        replies: &Sender<PublisherReply>,
    ) -> Result<(), ShardError> {
        let mut wants = false;
        self.send_heartbeat()?;
        loop {
            match requests.recv_timeout(if wants { POLL_INTERVAL } else { self.heartbeat_interval }) {
                Ok(PublisherRequest::Durable(samples)) => self.count_durable(&samples)?,
                Ok(PublisherRequest::MoreSamples) => wants = true,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            self.send_heartbeat()?;
            if wants && let Some(answer) = self.next_samples()? {
                wants = false;
                // The run may have ended.
                let _ = replies.send(answer);
            }
        }
    }

    /// Chooses the next chunk with missing samples; `None`: not known yet.
    fn next_samples(&mut self) -> Result<Option<PublisherReply>, ShardError> {
        loop {
            match self.choose()? {
                Choice::Wait => return Ok(None),
                Choice::Done => return Ok(Some(PublisherReply::NoneLeft)),
                Choice::Compute(chunk) => {
                    if let Some(todo) = self.start_chunk(chunk)? {
                        return Ok(Some(PublisherReply::Samples(todo)));
                    }
                    self.send_heartbeat()?;
                }
            }
        }
    }

    /// Writes a heartbeat if it is due.
    fn send_heartbeat(&mut self) -> Result<(), ShardError> {
        if self.last_heartbeat.is_some_and(|(sent, _)| sent.elapsed() < self.heartbeat_interval) {
            return Ok(());
        }
        let PublisherContext { attempt, shared, .. } = self.context;
        let counts = self.counts;
        let now = self.patience.run(|| attempt.report(shared, RUNNING, counts))?;
        self.last_heartbeat = Some((Instant::now(), now));
        Ok(())
    }

    /// Reports the end of the attempt.
    fn report_end(&mut self, is_well: bool) {
        let PublisherContext { attempt, shared, .. } = self.context;
        self.in_progress.keys().for_each(|chunk| attempt.remove_hint(shared, *chunk));
        let _ = attempt.report(shared, if is_well { "ended" } else { "failed" }, self.counts);
    }

    fn choose(&mut self) -> Result<Choice, ShardError> {
        let PublisherContext { attempt, shared, .. } = self.context;
        if self.context.may_end && shared.folder().place(RESULTS).is_file() {
            (self.context.note)("already merged, ended by [stop]: nothing to compute here");
            return Ok(Choice::Done);
        }
        let now = self.last_heartbeat.map_or_else(SystemTime::now, |(sent, now)| now + sent.elapsed());
        let (chooser, patience, listing) = (&mut self.chooser, &self.patience, &mut self.listing);
        patience.run(|| {
            chooser.choose(|chunk, lookup| {
                if lookup == Lookup::Folder
                    && let Some(found) = state_by_listing(listing, shared, chunk)?
                {
                    return Ok(found);
                }
                Ok(match is_published(shared, chunk)? {
                    true => ChunkState::Published,
                    false if is_in_progress_elsewhere(shared, chunk, attempt, now) => ChunkState::InProgress,
                    false => ChunkState::Missing,
                })
            })
        })
    }

    /// Starts a chunk; returns its samples that the record lacks, `None` if it has all of them.
    fn start_chunk(&mut self, chunk: u64) -> Result<Option<Todo>, ShardError> {
        self.context.attempt.put_hint(self.context.shared, chunk);
        let range = self.context.shards_file.chunks.range(chunk);
        let PublisherContext { shared, shards_file, prepared, .. } = self.context;
        let taken_over = taken_over(shared, shards_file, prepared, chunk);
        let todo = if self.has_earlier_entries || !taken_over.is_empty() {
            let is_missing = |sample: &u64| {
                !(taken_over.contains_key(sample) || self.has_earlier_entries && self.has_valid_entry(*sample))
            };
            Todo::from_iter(range.filter(is_missing).map(|sample| sample..sample + 1))
        } else {
            Todo::from_iter([range])
        };
        self.in_progress.insert(chunk, ChunkInProgress { left: todo.left(), taken_over });
        if todo.left() == 0 {
            self.publish(chunk)?;
            return Ok(None);
        }
        Ok(Some(todo))
    }

    /// Whether the record has a valid entry of a sample from an earlier attempt.
    fn has_valid_entry(&self, sample: u64) -> bool {
        let PublisherContext { record, prepared, .. } = self.context;
        let bytes = record.bytes(sample).ok().flatten();
        let head = bytes.and_then(|bytes| Head::decode(&bytes, prepared.steps).ok());
        head.is_some_and(|head| {
            let was_killed = head.status == Status::Quarantined && head.cause == Some(Cause::WorkerKilled);
            head.key == prepared.keys.key(sample) && !was_killed
        })
    }

    fn count_durable(&mut self, samples: &[u64]) -> Result<(), ShardError> {
        for &sample in samples {
            let chunk = self.context.shards_file.chunks.of(sample);
            let Some(in_progress) = self.in_progress.get_mut(&chunk) else { continue };
            in_progress.left = in_progress.left.saturating_sub(1);
            if in_progress.left == 0 {
                self.publish(chunk)?;
            }
        }
        Ok(())
    }

    fn publish(&mut self, chunk: u64) -> Result<(), ShardError> {
        let PublisherContext { shared, shards_file, record, attempt, note, .. } = self.context;
        let mut entries = Vec::new();
        let taken_over = self.in_progress.get(&chunk).map(|in_progress| &in_progress.taken_over);
        for sample in shards_file.chunks.range(chunk) {
            if let Some(bytes) = taken_over.and_then(|entries| entries.get(&sample)) {
                entries.push(bytes.clone());
                continue;
            }
            let bytes = record.bytes(sample).map_err(super::super::error::RunError::from)?;
            let path = shared.path().to_path_buf();
            let missing = bladeoff_record::RecordError::Missing { sample, path };
            entries.push(bytes.ok_or_else(|| super::super::error::RunError::from(missing))?);
        }
        let bytes = encode(shards_file, chunk, &attempt.metadata(), &entries);
        let put = self.patience.run(|| {
            let folder = shared.numbered(CHUNKS, folder_of(chunk))?;
            // Another process may have removed the directory and begun another study.
            if shards_file.is_current(shared)? {
                put_once(&folder, &chunk_name(chunk), &bytes).map(Some)
            } else {
                Ok(None)
            }
        })?;
        match put {
            None => return Err(ShardError::Replaced { path: shared.path().to_path_buf() }),
            Some(Put::Won) => {
                self.counts.published += 1;
                self.counts.helped += u64::from(!attempt.shard.owns(chunk));
            }
            Some(Put::Lost) => {
                self.counts.lost += 1;
                note(&format!("chunk {chunk} was already published by another attempt: this copy is discarded"));
            }
        }
        self.in_progress.remove(&chunk);
        attempt.remove_hint(shared, chunk);
        Ok(())
    }
}

/// Listing of a folder of chunks.
struct FolderListing {
    number: u64,
    there: BTreeSet<u64>,
    hinted: BTreeSet<u64>,
}

/// State of a chunk by the listing of its folder. A helper asks for thousands of chunks: two listings replace a question per
/// chunk. `None`: neither file nor hint.
fn state_by_listing(
    listing: &mut Option<FolderListing>,
    shared: &Shared,
    chunk: u64,
) -> Result<Option<ChunkState>, FileError> {
    let number = folder_of(chunk);
    let list = match listing.take().filter(|list| list.number == number) {
        Some(list) => list,
        None => FolderListing { number, there: shared.names_in(number)?, hinted: hinted_chunks(shared, number) },
    };
    let found = match (list.there.contains(&chunk), list.hinted.contains(&chunk)) {
        (true, _) => Some(ChunkState::Published),
        (false, true) => Some(ChunkState::InProgress),
        (false, false) => None,
    };
    *listing = Some(list);
    Ok(found)
}

/// Whether a chunk is published.
fn is_published(shared: &Shared, chunk: u64) -> Result<bool, FileError> {
    let path = || shared.path().join(CHUNKS).join(chunk_name(chunk));
    let folder = match shared.chunks_in(folder_of(chunk)) {
        Ok(Some(folder)) => folder,
        // An unreadable folder is an error; an absent one means that the chunk is missing.
        Ok(None) if shared.folder().place(SHARDS).identity().is_ok_and(|found| found.is_some()) => return Ok(false),
        Ok(None) => return Err(FileError::at("look into", &path())(io::ErrorKind::NotFound.into())),
        Err(error) => return Err(FileError::at("look into", &path())(error)),
    };
    let found = folder.place(chunk_name(chunk)).identity().map_err(FileError::at("look at", &path()))?;
    Ok(found.is_some())
}
