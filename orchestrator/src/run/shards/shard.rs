//! Shard: an ordinary run on one node with a record of its own in scratch, which computes the missing chunks of the shared
//! directory.
//!
//! The scratch directory is an ordinary result directory on a disk of the node, locked by the kernel of the node. The next
//! attempt on the same node continues the scratch directory of a killed one, so finished samples of unfinished chunks are kept.

use super::super::directory::{MANIFEST, RunDirectory};
use super::super::directory_lost::DirectoryWatch;
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
use super::layout::{Chunks, Shard};
use super::measure::chunk_size;
use super::publisher::{PublisherContext, PublisherHandle, published_beside};
use super::shards_file::ShardsFile;
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

/// Largest number of scratch directories of one study on one node.
const MOST_SCRATCH: u32 = 1000;

/// Request to compute a shard.
#[derive(Debug, Clone)]
pub struct ShardRequest {
    /// Request as for a run; `out` is the shared directory.
    pub run: Request,
    /// Shard.
    pub shard: Shard,
    /// Chunk size of a new directory.
    pub chunk: Option<u64>,
    /// Directory whose samples are reused.
    pub reuse: Option<PathBuf>,
    /// Folder of the scratch directory.
    pub scratch: PathBuf,
    /// Longest time for retries while the shared directory is unavailable.
    pub patience: Duration,
}

/// Result of a shard.
#[derive(Debug, Clone, Copy)]
pub struct ShardFinished {
    /// Reason of the end; complete: no chunk is left for this shard.
    pub ended: Ended,
    /// Published chunks.
    pub published: u64,
    /// Published chunks of other shards.
    pub helped: u64,
    /// Chunks that another attempt published first.
    pub lost: u64,
    /// Chunks of the study.
    pub chunks: u64,
}

/// Computes and publishes the missing chunks of a shard, then those of others.
///
/// # Errors
/// See [`ShardError`]; published chunks remain.
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
    let (shards_file, prepared) = freeze(&shared, samples, (request.chunk, request.reuse.as_deref()), size, note)?;
    let last = request.run.looking.as_ref().and_then(|looking| Some(looking.stages().last()?.samples));
    let chunks = shards_file.needed(last);
    note(&format!(
        "shard {} of {} in chunks of {}",
        request.shard,
        counted(chunks.count(), "chunk"),
        counted(chunks.size(), "sample")
    ));
    if request.run.looking.is_some() {
        note("`bladeoff merge` determines where [stop] ends the study; it can be tried at any time");
    }
    let attempt = Attempt::begin(request.shard, workers)?;
    if let Some(old) = &request.reuse {
        take_over(old, &shared, (&shards_file, &prepared), &attempt, note)?;
    }
    let (directory, opened) = scratch(request, &shards_file, &prepared)?;
    let mut own = Request { out: directory.path().to_path_buf(), ..request.run.clone() };
    // `wall` of [stop] counts from here.
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
    let (report, counts) = compute(&mut session, (request, chunks), (&shared, &shards_file, &attempt), note)?;
    let mut ended = report.ended;
    if ended == Ended::Wall && is_by_stop {
        ended = Ended::Stop;
        // The merge then does not wait for this shard.
        attempt.report(&shared, TIME_WAS_OVER, counts)?;
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

/// Removes a scratch directory after all its samples are published. It is renamed and emptied before its lock is released, so
/// that another attempt on this node begins in a directory of its own.
fn remove(directory: RunDirectory) {
    let path = directory.absolute().to_path_buf();
    let mut aside = path.clone().into_os_string();
    aside.push(format!(".done-{}", unguessable()));
    // A leftover folder has no effect.
    let _ = fs::rename(&path, &aside).and_then(|()| fs::remove_dir_all(&aside));
    drop(directory);
}

/// Opens a scratch directory: that of an earlier attempt if no process uses it, otherwise a new one.
fn scratch(
    request: &ShardRequest,
    shards_file: &ShardsFile,
    prepared: &Prepared<'_>,
) -> Result<(RunDirectory, Opened), ShardError> {
    let name = format!("bladeoff-shard-{}", &shards_file.hash[..16]);
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
            // Another process or user has this name: try the next one.
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
            // Its owner has published everything and removed it.
            Err(_) if number < MOST_SCRATCH && !path.exists() => {}
            found => return Ok(found?),
        }
    }
}

/// Computes the samples that the shared directory lacks.
fn compute(
    session: &mut Session<'_>,
    (request, needed): (&ShardRequest, Chunks),
    (shared, shards_file, attempt): (&Shared, &ShardsFile, &Attempt),
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
    let context =
        PublisherContext { shared, shards_file, prepared, record: &record, attempt, needed, may_end, patience, note };
    let work = |handle: &PublisherHandle| {
        let known = Rc::clone(&telling.known);
        let mut sink =
            RecordSink::new(&mut opened.record, &prepared.keys, &known, handle, DirectoryWatch::new(directory));
        let report = dispatch::run(&options, prepared.samples, Todo::default(), &mut sink, &mut telling);
        let committed = sink.close();
        telling.progress.clear();
        if let Ok(report) = &report {
            let memory = report.memory.as_ref().map(|domain| domain.address().clone());
            interrupt::end_at_once_when_told(matches!(report.ended, Ended::Signalled(_)), request.run.faults, memory);
        }
        (report, committed)
    };
    let ((report, committed), published) = published_beside(&context, work)?;
    telling.progress.finish(&telling.durable(), Instant::now());
    let memory = report.map(|mut report| {
        let memory = report.memory.take();
        (report, memory)
    });
    // The error of the publisher explains more than the end of the run that it caused.
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
