//! Study with a refined map: the first combinations with all their samples, a choice of the next ones by the rows, and so on.
//!
//! ```text
//! missing samples of the chosen combinations -> workers -> record -> temporary table -> next combinations?
//! none: the table contains the chosen combinations;   some: continue with them
//! ```
//! Each choice is a function of the rows of all chosen combinations and of nothing else. So every run begins with the first
//! combinations and repeats the choices of an earlier run without computing recorded samples again. Further samples in the
//! record, of a run with another rule, are kept.

use super::chosen::{Chosen, Refining};
use super::directory::{LOOK, RunDirectory};
use super::end::{EndWhy, TableEnd};
use super::error::RunError;
use super::prepare::Prepared;
use super::sink::RecordSink;
use super::stages::{Course, add, signals_between};
use super::tables::write_rows;
use super::telling::Telling;
use crate::dispatch::{self, DispatchOptions, DispatchReport, Ended, Sink};
use crate::schedule::Todo;
use bladeoff_record::Reader;
use bladeoff_study::Samples;
use bladeoff_worker::fault::{At, Faults};
use std::sync::PoisonError;
use std::time::{Duration, Instant};

/// Objects of a run that refines.
pub(super) struct Refined<'a> {
    pub refining: &'a dyn Refining,
    pub directory: &'a RunDirectory,
    pub prepared: &'a Prepared<'a>,
    pub record: &'a Reader,
    pub faults: &'a dyn Faults,
}

impl Refined<'_> {
    /// Computes the samples, choice by choice; returns the combinations chosen at the end.
    pub fn compute(
        &self,
        mut options: DispatchOptions,
        mut todo: Todo,
        sink: &mut RecordSink<'_>,
        telling: &mut Telling,
    ) -> (Course, Chosen) {
        let (begun, wall) = (Instant::now(), options.schedule.run.wall);
        let samples = self.prepared.samples;
        let signal_slot = signals_between();
        let mut all = DispatchReport::nothing(Ended::Complete);
        let (mut chosen, mut goes_on, mut is_first) = (self.refining.first(), true, true);
        loop {
            let part = todo.those(|sample| chosen.contains(samples, sample));
            // the first one in any case: it removes the files of a killed run
            if part.total() > 0 || is_first {
                is_first = false;
                options.schedule.run.wall = wall.map(|limit: Duration| limit.saturating_sub(begun.elapsed()));
                options.schedule.failed_before = telling.known.borrow().taken.failed();
                match dispatch::run(&options, samples, part, sink, telling) {
                    Ok(report) => add(&mut all, report),
                    Err(error) => return ((Err(error), Ok(None)), chosen),
                }
            }
            // before the analysis, so that a kill during it leaves no file
            dispatch::give_back(all.memory.take(), telling);
            if let Err(error) = sink.flush() {
                return ((Err(error.into()), Ok(None)), chosen);
            }
            if all.ended == Ended::Complete {
                let signal = signal_slot.lock().unwrap_or_else(PoisonError::into_inner).take();
                all.ended = signal.map_or(all.ended, Ended::Signalled);
            }
            if all.ended != Ended::Complete {
                return ((Ok(all), Ok(None)), chosen);
            }
            if !goes_on {
                break;
            }
            match self.look(&chosen) {
                Ok((more, others)) => {
                    goes_on = others;
                    if more.is_empty() {
                        break;
                    }
                    chosen.cells.extend(more);
                }
                Err(error) => return ((Ok(all), Err(error)), chosen),
            }
        }
        let why = match (goes_on, chosen == self.refining.first()) {
            (false, _) => EndWhy::MaxSamples,
            // all combinations are chosen
            (true, true) if chosen.is_all(samples) => EndWhy::Refined,
            (true, true) => EndWhy::Unchanged,
            (true, false) => EndWhy::Refined,
        };
        let end = end(&chosen, samples, why);
        all.ended = Ended::Stop;
        ((Ok(all), Ok(Some(end))), chosen)
    }

    /// Chooses the next combinations.
    fn look(&self, chosen: &Chosen) -> Result<(Vec<[u64; 2]>, bool), RunError> {
        let place = self.directory.file(LOOK);
        let rows: Vec<u64> = chosen.samples(self.prepared.samples).collect();
        write_rows(&place, self.prepared, self.record, &rows)?;
        self.faults.reached(At::Looking, rows.len() as u64, None);
        let said = self.refining.next(chosen, &place);
        self.directory.remove(LOOK)?;
        Ok(said?)
    }
}

/// End of a table of the chosen combinations.
fn end(chosen: &Chosen, samples: &Samples, why: EndWhy) -> TableEnd {
    let count = chosen.samples(samples).count() as u64;
    let points = if samples.layout().is_some() { samples.points() } else { count };
    TableEnd { points, samples: count, share: 1.0, why }
}
