//! A study that may end early, computed in stages: samples in their order up to a look, all of them done before the look, then on.
//!
//! ```text
//! missing samples below the first look -> workers -> record -> rows aside -> precise enough? -> the table ends here
//! missing samples below the next one   -> ...                               no: on
//! ```
//! A look sees the rows of its own beginning and nothing else, so where the table ends depends neither on which run finished first, nor
//! on kills, nor on how often somebody looked. What the record holds beyond (of a run with another rule) stays there.

use super::directory::{LOOK, RunDirectory};
use super::end::{EndWhy, Looked, Looking, Stage, TableEnd};
use super::error::RunError;
use super::prepare::Prepared;
use super::sink::RecordSink;
use super::tables::write_rows;
use super::telling::Telling;
use crate::dispatch::{self, DispatchError, DispatchOptions, DispatchReport, Ended, Signal, Sink};
use crate::schedule::Todo;
use bladeoff_record::Reader;
use bladeoff_study::Samples;
use bladeoff_worker::fault::{At, Faults};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// What a run in stages works with.
pub(super) struct Staged<'a> {
    pub looking: &'a dyn Looking,
    pub directory: &'a RunDirectory,
    pub prepared: &'a Prepared<'a>,
    pub record: &'a Reader,
    pub faults: &'a dyn Faults,
}

/// How the stages fared, and where the table ends, if that is known.
pub(super) type Course = (Result<DispatchReport, DispatchError>, Result<Option<TableEnd>, RunError>);

impl Staged<'_> {
    /// Has the samples computed, stage by stage.
    pub fn compute(
        &self,
        mut options: DispatchOptions,
        mut todo: Todo,
        sink: &mut RecordSink<'_>,
        telling: &mut Telling,
    ) -> Course {
        let (begun, wall, own) = (Instant::now(), options.schedule.run.wall, self.looking.wall());
        let told = signals_between();
        let mut all = DispatchReport::nothing(Ended::Complete);
        let mut last: Option<&Stage> = None;
        let mut known: Vec<String> = Vec::new();
        for (number, stage) in self.looking.stages().iter().enumerate() {
            let part = todo.below(stage.samples);
            // the first in any case: it cleans up after a run that was killed
            if part.total() > 0 || number == 0 {
                let left = |limit: Duration| limit.saturating_sub(begun.elapsed());
                options.schedule.run.wall = wall.into_iter().chain(own).map(left).min();
                options.schedule.failed_before = telling.known.borrow().taken.failed();
                match dispatch::run(&options, self.prepared.samples, part, sink, telling) {
                    Ok(report) => add(&mut all, report),
                    Err(error) => return (Err(error), Ok(None)),
                }
            }
            // before the look, so that a kill in it leaves nothing
            dispatch::give_back(all.memory.take(), telling);
            if let Err(error) = sink.flush() {
                return (Err(error.into()), Ok(None));
            }
            if all.ended == Ended::Complete {
                let signal = told.lock().unwrap_or_else(PoisonError::into_inner).take();
                all.ended = signal.map_or(all.ended, Ended::Signalled);
            }
            if all.ended == Ended::Wall && own.is_some_and(|own| wall.is_none_or(|wall| own < wall)) {
                let end = self.by_wall(last);
                if matches!(end, Ok(Some(_))) {
                    all.ended = Ended::Stop;
                }
                return (Ok(all), end);
            }
            if all.ended != Ended::Complete {
                return (Ok(all), Ok(None));
            }
            if self.looking.looks() {
                match self.look(stage) {
                    Ok(Looked { is_enough: true, .. }) => {
                        all.ended = Ended::Stop;
                        return (Ok(all), Ok(Some(ended(stage, EndWhy::Precision))));
                    }
                    // where it is so first, not at every look again
                    Ok(Looked { hindered, .. }) => {
                        for (name, why) in hindered {
                            if !known.contains(&name) {
                                telling.progress.note(&format!("[stop] after {} points: {name}: {why}", stage.points));
                                known.push(name);
                            }
                        }
                    }
                    Err(error) => return (Ok(all), Err(error)),
                }
            }
            last = Some(stage);
        }
        let end = last.and_then(|stage| at_the_last(stage, self.looking, self.prepared.samples));
        if end.is_some_and(|end| end.is_early()) {
            all.ended = Ended::Stop;
        }
        (Ok(all), Ok(end))
    }

    /// What a stage comes to.
    fn look(&self, stage: &Stage) -> Result<Looked, RunError> {
        let place = self.directory.file(LOOK);
        write_rows(&place, self.prepared, self.record, &(0..stage.samples).collect::<Vec<_>>())?;
        self.faults.reached(At::Looking, stage.samples, None);
        let said = self.looking.look(stage, &place);
        self.directory.remove(LOOK)?;
        Ok(said?)
    }

    /// Where the table ends when the time is up: at the last look, before the first one with the last whole block of points.
    fn by_wall(&self, last: Option<&Stage>) -> Result<Option<TableEnd>, RunError> {
        if let Some(stage) = last {
            return Ok(Some(ended(stage, EndWhy::Wall)));
        }
        let mut next = 0;
        self.record.for_each_head(None, |sample, _| next += u64::from(sample == next))?;
        Ok(before_any_look(self.prepared.samples, next))
    }
}

/// Where a study ends of which the last stage is done, and was not precise enough; `None`: with its design, and nobody looked.
pub(super) fn at_the_last(last: &Stage, looking: &dyn Looking, samples: &Samples) -> Option<TableEnd> {
    if last.samples < samples.count() {
        return Some(ended(last, EndWhy::Samples));
    }
    looking.looks().then(|| ended(last, EndWhy::Design))
}

/// Where a study ends whose time was up before its first look, of which the first samples are done: with the last whole block of points.
pub(super) fn before_any_look(samples: &Samples, first: u64) -> Option<TableEnd> {
    let points = whole_points(samples, first);
    let stage = Stage { points, samples: points * samples.groups().len() as u64, share: 1.0 };
    (points > 0).then(|| ended(&stage, EndWhy::Wall))
}

/// The end at a stage.
pub(super) fn ended(stage: &Stage, why: EndWhy) -> TableEnd {
    let &Stage { points, samples, share } = stage;
    TableEnd { points, samples, share, why }
}

/// Points in whole blocks that the first samples are.
fn whole_points(samples: &Samples, first: u64) -> u64 {
    let points = first / samples.groups().len() as u64;
    let plan = samples.layout().filter(|plan| points >= plan.rows());
    plan.map_or(0, |plan| plan.limited(points))
}

/// Adds what a further stage came to.
pub(super) fn add(all: &mut DispatchReport, report: DispatchReport) {
    let DispatchReport { done, ended, worker_deaths, dropped_messages, wall_s, first_ask_s, memory } = report;
    all.memory = memory;
    if all.done == 0 {
        all.first_ask_s = first_ask_s;
    }
    all.done += done;
    all.ended = ended;
    all.worker_deaths += worker_deaths;
    all.dropped_messages += dropped_messages;
    all.wall_s += wall_s;
}

/// A signal that comes while nothing is computed, which nobody else would hear.
pub(super) fn signals_between() -> Arc<Mutex<Option<Signal>>> {
    let told = Arc::new(Mutex::new(None));
    let heard = Arc::clone(&told);
    dispatch::watch_afterwards(move |signal| {
        heard.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(signal);
    });
    told
}
