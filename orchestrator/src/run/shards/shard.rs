//! One shard: an ordinary run on one node, with a record of its own in scratch, fed chunk by chunk from what the shared directory lacks.
//!
//! The scratch directory is a result directory like any other, on a disk of the node. Its lock is the node's kernel's. One that an attempt
//! has left that was killed is taken up by the next one on the same node: what it had computed of unfinished chunks is not lost.

use super::super::directory::{MANIFEST, RunDirectory};
use super::super::directory_lost::Guard;
use super::super::error::RunError;
use super::super::lock::LockError;
use super::super::manifest::{Course, manifest};
use super::super::open::Session;
use super::super::prepare::Prepared;
use super::super::request::Request;
use super::super::resume::{Again, Opened, compare};
use super::super::sink::RecordSink;
use super::super::telling::{Known, Telling};
use super::super::{interrupt, options};
use super::attempt::{Attempt, Counts, TIME_WAS_OVER};
use super::error::ShardError;
use super::freeze::{freeze, refuse_refined};
use super::frozen::Frozen;
use super::layout::{Chunks, Shard};
use super::measure::chunk_size;
use super::publisher::{Parts, Post, published_beside};
use super::shared::Shared;
use super::takeover::{refuse_no_old, take_over};
use crate::dispatch::{self, DispatchReport, Ended};
use crate::schedule::Todo;
use bladeoff_answers::summary::counted;
use bladeoff_answers::tables::start_threads;
use bladeoff_study::Samples;
use bladeoff_system::files::{unguessable, write_whole};
use bladeoff_system::shown;
use std::fs;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::{Duration, Instant};

/// Scratch directories of one study that are tried on one node.
const MOST_SCRATCH: u32 = 1000;

/// What is asked of a shard.
#[derive(Debug, Clone)]
pub struct ShardRequest {
    /// As of a run; `out` is the directory that all shards share.
    pub run: Request,
    /// Which shard.
    pub shard: Shard,
    /// Samples of a chunk, where the directory is begun.
    pub chunk: Option<u64>,
    /// A directory whose samples are taken over.
    pub reuse: Option<PathBuf>,
    /// Where its own record lies.
    pub scratch: PathBuf,
    /// How long the shared directory may be away.
    pub patience: Duration,
}

/// How a shard ended.
#[derive(Debug, Clone, Copy)]
pub struct ShardFinished {
    /// Why; complete: nothing is left for it to do.
    pub ended: Ended,
    /// Chunks that it has published.
    pub published: u64,
    /// Of these, such that are other shards'.
    pub helped: u64,
    /// Chunks that others had published before it.
    pub lost: u64,
    /// Chunks of the study.
    pub chunks: u64,
}

/// Computes the missing chunks of a shard, and then of others, and publishes them.
///
/// # Errors
/// See [`ShardError`]; what was published is there.
pub fn run_shard(
    request: &ShardRequest,
    samples: &Samples,
    note: &(dyn Fn(&str) + Sync),
) -> Result<ShardFinished, ShardError> {
    start_threads().map_err(RunError::from)?;
    dispatch::preflight(request.run.workers).map_err(RunError::from)?;
    refuse_refined(samples)?;
    refuse_no_old(request.reuse.as_deref())?;
    let shared = Shared::claim(&request.run.out, request.run.trusts, note)?;
    let workers = request.run.workers;
    let size = |prepared: &Prepared<'_>| chunk_size(prepared, workers, request.shard.of);
    let (frozen, prepared) = freeze(&shared, samples, (request.chunk, request.reuse.as_deref()), size, note)?;
    let last = request.run.looking.as_ref().and_then(|looking| Some(looking.stages().last()?.samples));
    let chunks = frozen.needed(last);
    note(&format!(
        "shard {} of {} in chunks of {}",
        request.shard,
        counted(chunks.count(), "chunk"),
        counted(chunks.size(), "sample")
    ));
    if request.run.looking.is_some() {
        note("where the study ends by its [stop] is decided by `bladeoff merge`, which may be tried at any time");
    }
    let attempt = Attempt::begin(request.shard, workers)?;
    if let Some(old) = &request.reuse {
        take_over(old, &shared, (&frozen, &prepared), &attempt, note)?;
    }
    let (directory, opened) = scratch(request, &frozen, &prepared)?;
    let mut own = Request { out: directory.path().to_path_buf(), ..request.run.clone() };
    // `wall` of [stop] counts from here
    own.limits = own.limits.after(own.begun.elapsed());
    own.begun = Instant::now();
    let wall = request.run.looking.as_ref().and_then(|looking| looking.wall());
    let is_by_stop = wall.is_some_and(|wall| own.limits.wall.is_none_or(|asked| wall < asked));
    own.limits.wall = own.limits.wall.into_iter().chain(wall).min();
    let mut session = Session { request: &own, prepared, opened, directory };
    let found = session.opened.tally.done();
    if found > 0 {
        let found = counted(found, "sample");
        note(&format!("{found} of an earlier attempt on this node, in {}", shown(session.directory.path())));
    }
    let (report, counts) = compute(&mut session, (request, chunks), (&shared, &frozen, &attempt), note)?;
    let mut ended = report.ended;
    if ended == Ended::Wall && is_by_stop {
        ended = Ended::Stop;
        // The merge waits for nobody then.
        attempt.say(&shared, TIME_WAS_OVER, counts)?;
    }
    let finished = ShardFinished {
        ended,
        published: counts.published,
        helped: counts.helped,
        lost: counts.lost,
        chunks: chunks.count(),
    };
    if finished.ended == Ended::Complete {
        let Session { directory, opened, .. } = session;
        drop(opened);
        remove(directory);
    }
    Ok(finished)
}

/// Removes a scratch directory of which everything is published. It has another name and no files before its lock is given back: another
/// attempt on this node begins in one of its own, and never in this.
fn remove(directory: RunDirectory) {
    let path = directory.absolute().to_path_buf();
    let mut aside = path.clone().into_os_string();
    aside.push(format!(".done-{}", unguessable()));
    // A leftover is in nobody's way.
    let _ = fs::rename(&path, &aside).and_then(|()| fs::remove_dir_all(&aside));
    drop(directory);
}

/// A directory of its own on the node, with the record of an earlier attempt if there is one that nobody works in.
fn scratch(
    request: &ShardRequest,
    frozen: &Frozen,
    prepared: &Prepared<'_>,
) -> Result<(RunDirectory, Opened), ShardError> {
    let name = format!("bladeoff-shard-{}", &frozen.hash[..16]);
    let mut number = 0;
    loop {
        let path = request.scratch.join(format!("{name}-{number}"));
        number += 1;
        let opened = || {
            let directory = RunDirectory::claim(&path, false, Some(prepared.samples.study()))?;
            let again = Again { rerun: None, suspects: false };
            let opened = compare(directory.open(), prepared, again)?.go_on(&directory, prepared, request.run.faults)?;
            Ok::<_, RunError>((directory, opened))
        };
        match opened() {
            // Whoever works there, or whoever's it is: there are other names.
            Err(
                RunError::Lock(LockError::Held { .. } | LockError::Theirs { .. })
                | RunError::Foreign { .. }
                | RunError::Untrusted(_)
                | RunError::NotADirectory { .. }
                | RunError::Changed { .. }
                | RunError::Record(_),
            ) if number < MOST_SCRATCH => {}
            Err(RunError::Lock(LockError::NotGranted { source, .. })) => {
                return Err(ShardError::ScratchWithoutLocks { path: request.scratch.clone(), source });
            }
            // Who has published everything in it has just removed it.
            Err(_) if number < MOST_SCRATCH && !path.exists() => {}
            found => return Ok(found?),
        }
    }
}

/// Has the samples computed that the shared directory lacks.
fn compute(
    session: &mut Session<'_>,
    (request, needed): (&ShardRequest, Chunks),
    (shared, frozen, attempt): (&Shared, &Frozen, &Attempt),
    note: &(dyn Fn(&str) + Sync),
) -> Result<(DispatchReport, Counts), ShardError> {
    let known = Known::begin(session.request)?;
    let mut telling = Telling::begin(session, &known);
    let course = Course::begun(session.opened.tally.done());
    let text = manifest(session.request, session.prepared.samples, &session.prepared.provenance, &course);
    write_whole(session.directory.file(MANIFEST), text.as_bytes())?;
    let mut options = options(session)?;
    options.schedule.is_fed = true;
    telling.started(session);
    let record = session.opened.record.reader().clone();
    let Session { prepared, opened, directory, .. } = session;
    let (may_end, patience) = (request.run.looking.is_some(), request.patience);
    let parts = Parts { shared, frozen, prepared, record: &record, attempt, needed, may_end, patience, note };
    let work = |post: &Post| {
        let known = Rc::clone(&telling.known);
        let mut sink = RecordSink::new(&mut opened.record, &prepared.keys, &known, post, Guard::new(directory));
        let report = dispatch::run(&options, prepared.samples, Todo::default(), &mut sink, &mut telling);
        let committed = sink.close();
        telling.progress.clear();
        if let Ok(report) = &report {
            let memory = report.memory.as_ref().map(|domain| domain.address().clone());
            interrupt::end_at_once_when_told(matches!(report.ended, Ended::Signalled(_)), request.run.faults, memory);
        }
        (report, committed)
    };
    let ((report, committed), published) = published_beside(&parts, work)?;
    telling.progress.finish(&telling.durable(), Instant::now());
    let memory = report.map(|mut report| {
        let memory = report.memory.take();
        (report, memory)
    });
    // Why it could not be published says more than that the run was ended by it.
    let counts = match (published, &memory) {
        (Ok(counts), _) => counts,
        (Err(error), _) => {
            drop(memory);
            return Err(error);
        }
    };
    let (report, memory) = memory.map_err(RunError::from)?;
    dispatch::give_back(memory, &mut telling);
    committed.map_err(RunError::from)?;
    Ok((report, counts))
}
