//! Between a shard's run and the directory that all share: a thread of its own finds chunks to compute, and publishes those that are
//! done. However long the file system takes, workers and heartbeats do not wait for it.
//!
//! ```text
//! run, by its sink      samples durable in the own record ─> publisher: chunk complete ─> file, link(2)
//!                       more? ─> publisher: next missing chunk, hint ─> samples that its record does not have yet
//! ```

use super::super::directory::RESULTS;
use super::super::prepare::Prepared;
use super::super::sink::Hears;
use super::attempt::{Attempt, Counts, RUNNING, beat, hints_in, is_at};
use super::choose::{Choice, Chooser, Look, State};
use super::chunk::encode;
use super::error::ShardError;
use super::frozen::Frozen;
use super::layout::{CHUNKS, Chunks, SHARDS, chunk_name, folder_of};
use super::patience::Patience;
use super::publish::{Put, put_once};
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

/// Time between two looks at chunks that others are at.
const LOOK: Duration = Duration::from_secs(1);

/// What the publisher is told.
enum Told {
    /// These samples are durable in the shard's own record.
    Durable(Vec<u64>),
    /// More samples are wanted.
    Wants,
}

/// What it answers.
enum Given {
    Samples(Todo),
    Nothing,
    /// It has given up; why, in words.
    Failed(String),
}

/// The end that the run has.
pub(super) struct Post {
    told: Option<Sender<Told>>,
    given: Receiver<Given>,
    has_asked: Cell<bool>,
    failed: RefCell<Option<String>>,
}

impl Post {
    fn tell(&self, what: Told) {
        // It ends after us, or by a panic, which is passed on when it is waited for.
        let _ = self.told.as_ref().is_some_and(|told| told.send(what).is_ok());
    }

    fn failure(&self) -> Option<SinkError> {
        let what = self.failed.borrow().clone()?;
        Some(SinkError { what, source: None })
    }

    fn take(&self) -> Result<Option<Given>, SinkError> {
        match self.given.try_recv() {
            Ok(Given::Failed(why)) => {
                *self.failed.borrow_mut() = Some(why);
                Err(self.failure().expect("set above"))
            }
            Ok(given) => Ok(Some(given)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Ok(Some(Given::Nothing)),
        }
    }
}

impl Hears for Post {
    fn durable(&self, samples: Vec<u64>) {
        self.tell(Told::Durable(samples));
    }

    fn more(&self) -> Result<More, SinkError> {
        if let Some(failure) = self.failure() {
            return Err(failure);
        }
        if !self.has_asked.replace(true) {
            self.tell(Told::Wants);
        }
        Ok(match self.take()? {
            None => More::Later,
            Some(Given::Nothing | Given::Failed(_)) => More::Nothing,
            Some(Given::Samples(todo)) => {
                self.has_asked.set(false);
                More::Samples(todo)
            }
        })
    }

    fn check(&self) -> Result<(), SinkError> {
        self.failure().map_or(Ok(()), Err)
    }
}

/// What a publisher works with.
pub(super) struct Parts<'a> {
    pub shared: &'a Shared,
    pub frozen: &'a Frozen,
    pub prepared: &'a Prepared<'a>,
    pub record: &'a Reader,
    pub attempt: &'a Attempt,
    /// Chunks that are needed at most.
    pub needed: Chunks,
    /// A merge may end the study before they are there.
    pub may_end: bool,
    pub patience: Duration,
    pub note: &'a (dyn Fn(&str) + Sync),
}

/// Does the work while chunks are found and published beside. The second result: what was published, and why not more.
///
/// # Errors
/// The thread cannot be started; nothing was done.
pub(super) fn published_beside<T>(
    parts: &Parts<'_>,
    work: impl FnOnce(&Post) -> T,
) -> Result<(T, Result<Counts, ShardError>), ShardError> {
    let is_over = AtomicBool::new(false);
    let is_over = &is_over;
    thread::scope(|scope| {
        let (told, receiver) = channel();
        let (sender, given) = channel();
        let (has_asked, failed) = (Cell::new(false), RefCell::new(None));
        // Dropped when the work panics, too: the thread is waited for.
        let post = Post { told: Some(told), given, has_asked, failed };
        let body = move || {
            let mut publisher = Publisher::new(parts, is_over);
            let done = publisher.run(&receiver, &sender);
            if let Err(error) = &done {
                // Whoever computes need not go on.
                let _ = sender.send(Given::Failed(with_causes(error)));
            }
            publisher.farewell(done.is_ok());
            done.map(|()| publisher.counts)
        };
        let thread =
            thread::Builder::new().name("publisher".into()).spawn_scoped(scope, body).map_err(ShardError::Thread)?;
        let done = work(&post);
        is_over.store(true, Ordering::Relaxed);
        drop(post);
        let published = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        Ok((done, published))
    })
}

/// A chunk that is computed.
struct UnderWay {
    /// Samples that are not durable yet.
    left: u64,
    /// Entries of another directory.
    taken_over: BTreeMap<u64, Vec<u8>>,
}

struct Publisher<'a> {
    parts: &'a Parts<'a>,
    patience: Patience<'a>,
    chooser: Chooser,
    /// Chunks under way.
    under_way: BTreeMap<u64, UnderWay>,
    counts: Counts,
    /// How often it says that it lives.
    every: Duration,
    /// When it has said last that it lives: by this clock, and by that of the file server.
    beat: Option<(Instant, SystemTime)>,
    /// The own record may have been begun by an earlier attempt on this node.
    has_earlier: bool,
    /// The folder that was listed last, of chunks of others.
    listed: Option<Listed>,
}

impl<'a> Publisher<'a> {
    fn new(parts: &'a Parts<'a>, is_over: &'a AtomicBool) -> Self {
        Self {
            patience: Patience::new(parts.shared, parts.patience, is_over, parts.note),
            chooser: Chooser::new(parts.attempt.shard, parts.needed.count()),
            under_way: BTreeMap::new(),
            counts: Counts::default(),
            every: beat(parts.attempt.shard.of),
            beat: None,
            has_earlier: parts.record.is_empty().is_ok_and(|is_empty| !is_empty),
            listed: None,
            parts,
        }
    }

    fn run(&mut self, told: &Receiver<Told>, given: &Sender<Given>) -> Result<(), ShardError> {
        let mut wants = false;
        self.beat()?;
        loop {
            match told.recv_timeout(if wants { LOOK } else { self.every }) {
                Ok(Told::Durable(samples)) => self.durable(&samples)?,
                Ok(Told::Wants) => wants = true,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            self.beat()?;
            if wants && let Some(answer) = self.next()? {
                wants = false;
                // Nobody may be there any more.
                let _ = given.send(answer);
            }
        }
    }

    /// The samples of the next chunk that has some left to compute; `None`: not known yet.
    fn next(&mut self) -> Result<Option<Given>, ShardError> {
        loop {
            match self.choose()? {
                Choice::Wait => return Ok(None),
                Choice::Nothing => return Ok(Some(Given::Nothing)),
                Choice::Take(chunk) => {
                    if let Some(todo) = self.take(chunk)? {
                        return Ok(Some(Given::Samples(todo)));
                    }
                    self.beat()?;
                }
            }
        }
    }

    /// Says that it lives, if it is time to.
    fn beat(&mut self) -> Result<(), ShardError> {
        if self.beat.is_some_and(|(said, _)| said.elapsed() < self.every) {
            return Ok(());
        }
        let Parts { attempt, shared, .. } = self.parts;
        let counts = self.counts;
        let now = self.patience.tried(|| attempt.say(shared, RUNNING, counts))?;
        self.beat = Some((Instant::now(), now));
        Ok(())
    }

    /// The last word.
    fn farewell(&mut self, is_well: bool) {
        let Parts { attempt, shared, .. } = self.parts;
        self.under_way.keys().for_each(|chunk| attempt.forget(shared, *chunk));
        let _ = attempt.say(shared, if is_well { "ended" } else { "failed" }, self.counts);
    }

    fn choose(&mut self) -> Result<Choice, ShardError> {
        let Parts { attempt, shared, .. } = self.parts;
        if self.parts.may_end && shared.folder().place(RESULTS).is_file() {
            (self.parts.note)("merged already, by its [stop]: nothing more is computed here");
            return Ok(Choice::Nothing);
        }
        let now = self.beat.map_or_else(SystemTime::now, |(said, now)| now + said.elapsed());
        let (chooser, patience, listed) = (&mut self.chooser, &self.patience, &mut self.listed);
        patience.tried(|| {
            chooser.choose(|chunk, look| {
                if look == Look::Listed
                    && let Some(found) = listed_as(listed, shared, chunk)?
                {
                    return Ok(found);
                }
                Ok(match is_there(shared, chunk)? {
                    true => State::There,
                    false if is_at(shared, chunk, attempt, now) => State::Taken,
                    false => State::Missing,
                })
            })
        })
    }

    /// Begins a chunk: gives the samples of it that the own record does not have; `None` where it has all.
    fn take(&mut self, chunk: u64) -> Result<Option<Todo>, ShardError> {
        self.parts.attempt.hint(self.parts.shared, chunk);
        let range = self.parts.frozen.chunks.range(chunk);
        let Parts { shared, frozen, prepared, .. } = self.parts;
        let taken_over = taken_over(shared, frozen, prepared, chunk);
        let todo = if self.has_earlier || !taken_over.is_empty() {
            let is_missing = |sample: &u64| !(taken_over.contains_key(sample) || self.has_earlier && self.has(*sample));
            Todo::from_iter(range.filter(is_missing).map(|sample| sample..sample + 1))
        } else {
            Todo::from_iter([range])
        };
        self.under_way.insert(chunk, UnderWay { left: todo.left(), taken_over });
        if todo.left() == 0 {
            self.publish(chunk)?;
            return Ok(None);
        }
        Ok(Some(todo))
    }

    /// Whether an earlier attempt on this node has left a sample that counts.
    fn has(&self, sample: u64) -> bool {
        let Parts { record, prepared, .. } = self.parts;
        let bytes = record.bytes(sample).ok().flatten();
        let head = bytes.and_then(|bytes| Head::decode(&bytes, prepared.steps).ok());
        head.is_some_and(|head| {
            let was_killed = head.status == Status::Quarantined && head.cause == Some(Cause::WorkerKilled);
            head.key == prepared.keys.key(sample) && !was_killed
        })
    }

    fn durable(&mut self, samples: &[u64]) -> Result<(), ShardError> {
        for &sample in samples {
            let chunk = self.parts.frozen.chunks.of(sample);
            let Some(under_way) = self.under_way.get_mut(&chunk) else { continue };
            under_way.left = under_way.left.saturating_sub(1);
            if under_way.left == 0 {
                self.publish(chunk)?;
            }
        }
        Ok(())
    }

    fn publish(&mut self, chunk: u64) -> Result<(), ShardError> {
        let Parts { shared, frozen, record, attempt, note, .. } = self.parts;
        let mut entries = Vec::new();
        let taken_over = self.under_way.get(&chunk).map(|under_way| &under_way.taken_over);
        for sample in frozen.chunks.range(chunk) {
            if let Some(bytes) = taken_over.and_then(|entries| entries.get(&sample)) {
                entries.push(bytes.clone());
                continue;
            }
            let bytes = record.bytes(sample).map_err(super::super::error::RunError::from)?;
            let path = shared.path().to_path_buf();
            let missing = bladeoff_record::RecordError::Missing { sample, path };
            entries.push(bytes.ok_or_else(|| super::super::error::RunError::from(missing))?);
        }
        let bytes = encode(frozen, chunk, &attempt.by(), &entries);
        let put = self.patience.tried(|| {
            let folder = shared.numbered(CHUNKS, folder_of(chunk))?;
            // Somebody may have removed everything and begun another study here.
            if frozen.is_it(shared)? { put_once(&folder, &chunk_name(chunk), &bytes).map(Some) } else { Ok(None) }
        })?;
        match put {
            None => return Err(ShardError::Replaced { path: shared.path().to_path_buf() }),
            Some(Put::Won) => {
                self.counts.published += 1;
                self.counts.helped += u64::from(!attempt.shard.owns(chunk));
            }
            Some(Put::Lost) => {
                self.counts.lost += 1;
                note(&format!("chunk {chunk} was published by another attempt before: ours is dropped"));
            }
        }
        self.under_way.remove(&chunk);
        attempt.forget(shared, chunk);
        Ok(())
    }
}

/// A folder of chunks as it was.
struct Listed {
    number: u64,
    there: BTreeSet<u64>,
    hinted: BTreeSet<u64>,
}

/// Whether a chunk was there, or had a hint, when its folder was listed. Who helps looks at thousands that are: two lists instead of questions
/// for each.
fn listed_as(listed: &mut Option<Listed>, shared: &Shared, chunk: u64) -> Result<Option<State>, FileError> {
    let number = folder_of(chunk);
    let list = match listed.take().filter(|list| list.number == number) {
        Some(list) => list,
        None => Listed { number, there: shared.names_in(number)?, hinted: hints_in(shared, number) },
    };
    let found = match (list.there.contains(&chunk), list.hinted.contains(&chunk)) {
        (true, _) => Some(State::There),
        (false, true) => Some(State::Taken),
        (false, false) => None,
    };
    *listed = Some(list);
    Ok(found)
}

/// Whether a chunk is published.
fn is_there(shared: &Shared, chunk: u64) -> Result<bool, FileError> {
    let path = || shared.path().join(CHUNKS).join(chunk_name(chunk));
    let folder = match shared.chunks_in(folder_of(chunk)) {
        Ok(Some(folder)) => folder,
        // What cannot be looked at is away; what is not there is missing.
        Ok(None) if shared.folder().place(SHARDS).identity().is_ok_and(|found| found.is_some()) => return Ok(false),
        Ok(None) => return Err(FileError::at("look into", &path())(io::ErrorKind::NotFound.into())),
        Err(error) => return Err(FileError::at("look into", &path())(error)),
    };
    let found = folder.place(chunk_name(chunk)).identity().map_err(FileError::at("look at", &path()))?;
    Ok(found.is_some())
}
