//! Bounds at each point of a group: whether a condition holds, or a column's value.
//!
//! ```text
//! ok row                          the condition by its program, the value as it stands
//! ok row, empty cell              of an event or a motion: it did not occur in the run; of a quantity that nothing judged: nothing
//! bad row, column given           the value; where there is none, it was to be derived and does not exist: nothing
//! bad row, column that grows      [what was reached while all guards held, no bound); where nothing but a step limit ended the run,
//!                                 that is the value as it stands
//! bad row, time of a first event  the value, where it happened while all guards and limits held; else nothing
//! bad row, any other column       nothing
//! beyond row (beyond the model)   as a bad row; a column without a guarded value, of a run that ended at the limit: as if a step limit ended it
//! beyond row, time of a limit     the value
//! ```
//! An ok row that ended at its end time T leaves later events open. Where the truth of a condition changes at times after T (`beyond_s > 6.5`
//! of a run of 6 s), the row is open; where it does not (`beyond_s > 0`), the condition is that of the simulated time.
//! An empty cell of an ok row (nothing of the kind happened): no comparison with it holds but `!=`; it has no value, and is counted.
//! A condition that has no value itself (the square root of a negative number) is not known, in an ok row as in a bad one.
//!
//! A mean takes a bad row's value as anything at all, also where a part of it was reached. A quantile does so for failed and invalid rows;
//! of a beyond row, whose numerical checks passed, it takes what was reached as the least value.

use super::bad::Bad;
use super::formula::Formula;
use super::input::{Ended, InputError, Nature, Study};
use super::span::Span;
use super::truth::{Truth, truth, truth_of_known};
use super::undecided::{Undecided, Why};
use bladeoff_model::outcome::{Cause, Status};

/// Whether a condition holds at each point of a group.
#[derive(Debug, Clone, Default)]
pub struct Truths {
    /// Of each point, in order.
    pub of: Vec<Truth>,
    /// Status of each point.
    pub status: Vec<Status>,
    /// Ok rows where a column of the condition is empty.
    pub empty: u64,
    /// Ok rows that are open, by their places here, and why.
    pub open: Vec<(usize, Why)>,
}

impl Truths {
    /// The first of these rows alone.
    pub fn truncate(&mut self, rows: usize) {
        self.of.truncate(rows);
        self.status.truncate(rows);
        self.open.retain(|(row, _)| *row < rows);
    }

    /// Counts of the ok rows that are open.
    #[must_use]
    pub fn undecided(&self) -> Undecided {
        let mut found = Undecided::default();
        self.open.iter().for_each(|(_, why)| found.see(*why));
        found
    }

    /// Bad rows, and how many of them are decided by what is known.
    #[must_use]
    pub fn bad(&self) -> Bad {
        let mut found = Bad::default();
        self.of.iter().zip(&self.status).for_each(|(truth, status)| found.see(*status, *truth != Truth::Open));
        found
    }
}

/// Bounds of a column's values at the points of a group that have one.
#[derive(Debug, Clone, Default)]
pub struct Values {
    /// Number of the point.
    pub point: Vec<u32>,
    /// Least value.
    pub low: Vec<f64>,
    /// Largest value.
    pub high: Vec<f64>,
    /// Bad rows.
    pub bad: Bad,
    /// Ok rows without a value.
    pub empty: u64,
}

/// A bad row's cell.
fn span(study: &Study<'_>, row: usize, value: Option<f64>, nature: Nature<'_>) -> Span {
    let causes = study.causes[row];
    // nothing is wrong with the run up to its end; the end instant of a run beyond the model is behind the step that counts
    let is_cut_off = || match study.status[row] {
        Status::Beyond => study.ends[row] == Ended::Limit && nature.held().and_then(|held| held[row]).is_none(),
        _ => causes.iter().eq([Cause::StepLimit]),
    };
    match nature {
        Nature::Given => value.map_or(Span::LOST, Span::point),
        Nature::Limit(_) if study.status[row] == Status::Beyond => value.map_or(Span::WHOLE, Span::point),
        Nature::Once(_) | Nature::Limit(_) if is_cut_off() => value.map_or(Span::WHOLE, Span::point),
        Nature::Once(held) | Nature::Limit(held) => held.and_then(|held| held[row]).map_or(Span::WHOLE, Span::point),
        // sound as far as it went
        Nature::Grows(_) if is_cut_off() => value.map_or(Span::WHOLE, Span::from),
        // zero where nothing had been reached: the whole run may have no such value
        Nature::Grows(held) => held
            .and_then(|held| held[row])
            .map_or(Span::WHOLE, |reached| Span { empty: reached <= 0.0, ..Span::from(reached) }),
        Nature::Free => Span::WHOLE,
    }
}

/// Whether a condition holds, in a group.
///
/// # Errors
/// The study lacks a column of it.
pub fn truths(study: &Study<'_>, formula: &Formula, group: usize) -> Result<Truths, InputError> {
    truths_at(study, formula, (0..study.points()).map(|point| study.row(point, group)))
}

/// The same of any rows, in their order.
///
/// # Errors
/// As [`truths`].
pub fn truths_at(
    study: &Study<'_>,
    formula: &Formula,
    rows: impl ExactSizeIterator<Item = usize>,
) -> Result<Truths, InputError> {
    let columns: Vec<_> = formula.columns.iter().map(|name| study.numbers(name)).collect::<Result<_, _>>()?;
    let unjudged: Vec<bool> = formula
        .columns
        .iter()
        .map(|name| study.column(name).map(|column| column.unjudged))
        .collect::<Result<_, _>>()?;
    let points = rows.len();
    let mut found = Truths { of: Vec::with_capacity(points), status: Vec::with_capacity(points), ..Truths::default() };
    let (mut known, mut spans) = (Vec::new(), Vec::new());
    for row in rows {
        let ok = study.status[row] == Status::Ok;
        found.status.push(study.status[row]);
        found.of.push(if ok {
            let cells = |number: usize| columns[number].0[row];
            found.empty += u64::from((0..columns.len()).any(|number| cells(number).is_none() && !unjudged[number]));
            let lacks = (0..columns.len()).any(|number| cells(number).is_none() && unjudged[number]);
            let ended = if let Ended::Time(end) = study.ends[row] { Some(end) } else { None };
            let is_event = |number: usize| matches!(columns[number].1, Nature::Once(_) | Nature::Limit(_));
            let waits = ended.is_some() && (0..columns.len()).any(|number| cells(number).is_none() && is_event(number));
            // `later`: events that the run does not have come after its end
            let bounds = |number: usize, later: bool| match (cells(number), ended) {
                (Some(value), _) => Span::point(value),
                (None, _) if unjudged[number] => Span::WHOLE,
                (None, Some(end)) if later && is_event(number) => Span::from(end),
                (None, _) => Span::NONE,
            };
            let (mut why, mut holds) = if lacks {
                (Why::Unjudged, truth(&formula.program, |number| bounds(number, false), &mut spans))
            } else {
                let known = truth_of_known(&formula.program, |number| cells(number).unwrap_or(f64::NAN), &mut known);
                (Why::NoValue, known)
            };
            if waits
                && holds != Truth::Open
                && truth(&formula.program, |number| bounds(number, true), &mut spans) == Truth::Open
            {
                (why, holds) = (Why::Later, Truth::Open);
            }
            if holds == Truth::Open {
                found.open.push((found.of.len(), why));
            }
            holds
        } else {
            let of = |number: usize| span(study, row, columns[number].0[row], columns[number].1);
            truth(&formula.program, of, &mut spans)
        });
    }
    Ok(found)
}

/// Values of a column, in a group; a bad row's is anything from minus to plus infinity, unless it went into the run.
///
/// # Errors
/// The study has no such column of numbers.
pub fn values(study: &Study<'_>, column: &str, group: usize) -> Result<Values, InputError> {
    values_at(study, column, of_group(study, group))
}

/// The same of any rows, each with the number of its point.
///
/// # Errors
/// As [`values`].
pub fn values_at(
    study: &Study<'_>,
    column: &str,
    rows: impl Iterator<Item = (usize, usize)>,
) -> Result<Values, InputError> {
    values_as(study, column, rows, |_| false)
}

/// Values for a quantile: a beyond row's is at least what it reached inside the model.
///
/// # Errors
/// As [`values`].
pub fn levels(study: &Study<'_>, column: &str, group: usize) -> Result<Values, InputError> {
    levels_at(study, column, of_group(study, group))
}

/// The same of any rows, each with the number of its point.
///
/// # Errors
/// As [`values`].
pub fn levels_at(
    study: &Study<'_>,
    column: &str,
    rows: impl Iterator<Item = (usize, usize)>,
) -> Result<Values, InputError> {
    values_as(study, column, rows, |status| status == Status::Beyond)
}

/// The same, where every bad row's is at least what was reached while all guards held: it exceeds the levels below in any case.
///
/// # Errors
/// As [`values`].
pub fn reached(study: &Study<'_>, column: &str, group: usize) -> Result<Values, InputError> {
    reached_at(study, column, of_group(study, group))
}

/// The same of any rows, each with the number of its point.
///
/// # Errors
/// As [`values`].
pub fn reached_at(
    study: &Study<'_>,
    column: &str,
    rows: impl Iterator<Item = (usize, usize)>,
) -> Result<Values, InputError> {
    values_as(study, column, rows, |_| true)
}

/// Points and rows of a group.
fn of_group(study: &Study<'_>, group: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..study.points()).map(move |point| (point, study.row(point, group)))
}

/// `has_reached`: whether what a row of this status had reached is taken as its least value; of an ok row that nothing judged, whether its
/// value may be any.
fn values_as(
    study: &Study<'_>,
    column: &str,
    rows: impl Iterator<Item = (usize, usize)>,
    has_reached: impl Fn(Status) -> bool,
) -> Result<Values, InputError> {
    let (cells, nature) = study.numbers(column)?;
    let is_unjudged = study.column(column)?.unjudged;
    let mut found = Values::default();
    for (point, row) in rows {
        let span = if study.status[row] == Status::Ok {
            found.bad.see(Status::Ok, false);
            match cells[row].filter(|value| !value.is_nan()) {
                Some(value) => Span::point(value),
                None if is_unjudged && has_reached(Status::Ok) => Span::WHOLE,
                None => {
                    found.empty += 1;
                    continue;
                }
            }
        } else {
            found.bad.see(study.status[row], false);
            let is_known = matches!(nature, Nature::Given | Nature::Limit(_)) || has_reached(study.status[row]);
            span(study, row, cells[row], if is_known { nature } else { Nature::Free })
        };
        found.point.push(point as u32);
        found.low.push(span.lo);
        found.high.push(span.hi);
    }
    Ok(found)
}
