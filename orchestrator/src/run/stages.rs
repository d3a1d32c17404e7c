//! Study with interim analyses: samples in ascending order up to an analysis, all of them finished before it, and so on.
//!
//! ```text
//! missing samples before the first analysis -> workers -> record -> temporary table -> precise enough? -> end of the table
//! missing samples before the next one       -> ...                                     no: continue
//! ```
//! An analysis reads the rows of its own first samples and nothing else. So the end of the table does not depend on the order in
//! which runs finish, on kills, or on the number of earlier analyses. Further samples in the record, of a run with another rule,
//! are kept.

use super::directory::{LOOK, RunDirectory};
use super::end::{EndWhy, PrecisionCheck, PrecisionResult, Stage, TableEnd};
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

/// Objects of a run in stages.
pub(super) struct Staged<'a> {
    pub looking: &'a dyn PrecisionCheck,
    pub directory: &'a RunDirectory,
    pub prepared: &'a Prepared<'a>,
    pub record: &'a Reader,
    pub faults: &'a dyn Faults,
}

/// Result of the stages, and the end of the table if it is known.
pub(super) type Course = (Result<DispatchReport, DispatchError>, Result<Option<TableEnd>, RunError>);

impl Staged<'_> {
    /// Computes the samples, stage by stage.
    pub fn compute(
        &self,
        mut options: DispatchOptions,
        mut todo: Todo,
        sink: &mut RecordSink<'_>,
        telling: &mut Telling,
    ) -> Course {
        let (begun, wall, own) = (Instant::now(), options.schedule.run.wall, self.looking.wall());
        let signal_slot = signals_between();
        let mut all = DispatchReport::nothing(Ended::Complete);
        let mut last: Option<&Stage> = None;
        let mut known: Vec<String> = Vec::new();
        for (number, stage) in self.looking.stages().iter().enumerate() {
            let part = todo.below(stage.samples);
            // the first one in any case: it removes the files of a killed run
            if part.total() > 0 || number == 0 {
                let left = |limit: Duration| limit.saturating_sub(begun.elapsed());
                options.schedule.run.wall = wall.into_iter().chain(own).map(left).min();
                options.schedule.failed_before = telling.known.borrow().taken.failed();
                match dispatch::run(&options, self.prepared.samples, part, sink, telling) {
                    Ok(report) => add(&mut all, report),
                    Err(error) => return (Err(error), Ok(None)),
                }
            }
            // before the analysis, so that a kill during it leaves no file
            dispatch::give_back(all.memory.take(), telling);
            if let Err(error) = sink.flush() {
                return (Err(error.into()), Ok(None));
            }
            if all.ended == Ended::Complete {
                let signal = signal_slot.lock().unwrap_or_else(PoisonError::into_inner).take();
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
                    Ok(PrecisionResult { is_enough: true, .. }) => {
                        all.ended = Ended::Stop;
                        return (Ok(all), Ok(Some(ended(stage, EndWhy::Precision))));
                    }
                    // reported at the first analysis only
                    Ok(PrecisionResult { hindered, .. }) => {
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

    /// Analyses a stage.
    fn look(&self, stage: &Stage) -> Result<PrecisionResult, RunError> {
        let place = self.directory.file(LOOK);
        write_rows(&place, self.prepared, self.record, &(0..stage.samples).collect::<Vec<_>>())?;
        self.faults.reached(At::Looking, stage.samples, None);
        let said = self.looking.look(stage, &place);
        self.directory.remove(LOOK)?;
        Ok(said?)
    }

    /// End of the table when the time is over: the last analysis, or before the first one the last whole block of points.
    fn by_wall(&self, last: Option<&Stage>) -> Result<Option<TableEnd>, RunError> {
        if let Some(stage) = last {
            return Ok(Some(ended(stage, EndWhy::Wall)));
        }
        let mut next = 0;
        self.record.for_each_head(None, |sample, _| next += u64::from(sample == next))?;
        Ok(before_any_look(self.prepared.samples, next))
    }
}

/// End of a study whose last stage is finished and was not precise enough; `None`: the end of its design, without interim
/// analyses.
pub(super) fn at_the_last(last: &Stage, looking: &dyn PrecisionCheck, samples: &Samples) -> Option<TableEnd> {
    if last.samples < samples.count() {
        return Some(ended(last, EndWhy::Samples));
    }
    looking.looks().then(|| ended(last, EndWhy::Design))
}

/// End of a study whose time was over before its first analysis: the last whole block of points among the finished samples.
pub(super) fn before_any_look(samples: &Samples, first: u64) -> Option<TableEnd> {
    let points = whole_points(samples, first);
    let stage = Stage { points, samples: points * samples.groups().len() as u64, share: 1.0 };
    (points > 0).then(|| ended(&stage, EndWhy::Wall))
}

/// End of the table at a stage.
pub(super) fn ended(stage: &Stage, why: EndWhy) -> TableEnd {
    let &Stage { points, samples, share } = stage;
    TableEnd { points, samples, share, why }
}

/// Number of points in whole blocks among the first samples.
fn whole_points(samples: &Samples, first: u64) -> u64 {
    let points = first / samples.groups().len() as u64;
    let layout = samples.layout().filter(|layout| points >= layout.rows());
    layout.map_or(0, |layout| layout.limited(points))
}

/// Adds the result of a further stage.
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

/// Signal that arrives while no dispatch loop handles it.
pub(super) fn signals_between() -> Arc<Mutex<Option<Signal>>> {
    let signal_slot = Arc::new(Mutex::new(None));
    let slot = Arc::clone(&signal_slot);
    dispatch::watch_afterwards(move |signal| {
        slot.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(signal);
    });
    signal_slot
}
