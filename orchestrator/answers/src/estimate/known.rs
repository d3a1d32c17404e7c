//! Bounds at each point of a group: on the truth of a condition, or on the value of a column.
//!
//! ```text
//! ok row                          exact: the condition by its program, the value as recorded
//! ok row, empty cell              an event or motion did not occur in the run; an unjudged quantity has no bound
//! bad row, column given           the value; an empty cell could not be derived: no bound, and possibly no value
//! bad row, column that grows      [value reached while all guards held, infinity); if only a step limit ended the run,
//!                                 the recorded value is the lower bound
//! bad row, time of a first event  the value, if the event happened while all guards and limits held; otherwise no bound
//! bad row, any other column       no bound
//! beyond row (beyond the model)   as a bad row; a column without guarded value, of a run that ended at the limit: as after a step limit
//! beyond row, time of a limit     the value
//! ```
//! An ok row that ended at its end time T leaves later events open. If the truth of a condition changes at times after T (`beyond_s > 6.5`
//! in a run of 6 s), the row is open; if not (`beyond_s > 0`), the condition applies to the simulated time.
//! An empty cell of an ok row (the event did not happen) satisfies no comparison except `!=`. As a value it is missing and counted as empty.
//! A condition whose formula has no value (square root of a negative number) is open, in ok rows and in bad ones.
//!
//! A mean allows any value for a bad row, even where a lower bound is known. A quantile does so for failed and invalid rows;
//! for a beyond row, whose numerical checks passed, it uses the reached value as the lower bound.

use super::bad::Bad;
use super::formula::Formula;
use super::input::{Ended, InputError, Nature, Study};
use super::span::Span;
use super::truth::{Truth, truth, truth_of_known};
use super::undecided::{Undecided, Why};
use bladeoff_model::outcome::{Cause, Status};

/// Bounds on a condition at the points of a group.
#[derive(Debug, Clone, Default)]
pub struct Truths {
    /// Truth at each point, in order.
    pub of: Vec<Truth>,
    /// Status of each point.
    pub status: Vec<Status>,
    /// Ok rows where a column of the condition is empty.
    pub empty: u64,
    /// Ok rows that are open: index in `of`, and the reason.
    pub open: Vec<(usize, Why)>,
}

impl Truths {
    /// Removes all but the first rows.
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

    /// Counts of bad rows, and of bad rows in which the recorded values determine the condition.
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
    /// Index of the point.
    pub point: Vec<u32>,
    /// Lower bound.
    pub low: Vec<f64>,
    /// Upper bound.
    pub high: Vec<f64>,
    /// Counts of bad rows.
    pub bad: Bad,
    /// Number of ok rows without a value.
    pub empty: u64,
}

/// Bounds on the value of a bad row.
fn span(study: &Study<'_>, row: usize, value: Option<f64>, nature: Nature<'_>) -> Span {
    let causes = study.causes[row];
    // the run is valid up to its end; of a run beyond the model the end instant lies behind the step that counts
    let is_cut_off = || match study.status[row] {
        Status::Beyond => study.ends[row] == Ended::Limit && nature.held().and_then(|held| held[row]).is_none(),
        _ => causes.iter().eq([Cause::StepLimit]),
    };
    match nature {
        Nature::Given => value.map_or(Span::LOST, Span::point),
        Nature::Limit(_) if study.status[row] == Status::Beyond => value.map_or(Span::WHOLE, Span::point),
        Nature::Once(_) | Nature::Limit(_) if is_cut_off() => value.map_or(Span::WHOLE, Span::point),
        Nature::Once(held) | Nature::Limit(held) => held.and_then(|held| held[row]).map_or(Span::WHOLE, Span::point),
        // the recorded value is a valid lower bound
        Nature::Grows(_) if is_cut_off() => value.map_or(Span::WHOLE, Span::from),
        // if nothing was reached (0), the complete run might have had no value either
        Nature::Grows(held) => held
            .and_then(|held| held[row])
            .map_or(Span::WHOLE, |reached| Span { empty: reached <= 0.0, ..Span::from(reached) }),
        Nature::Free => Span::WHOLE,
    }
}

/// Truth of a condition at each point of a group.
///
/// # Errors
/// The study has no such column.
pub fn truths(study: &Study<'_>, formula: &Formula, group: usize) -> Result<Truths, InputError> {
    truths_at(study, formula, (0..study.points()).map(|point| study.row(point, group)))
}

/// [`truths`] for any rows, in the order of `rows`.
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
            // `later`: missing events may come after the end of the run
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

/// Values of a column in a group. A bad row has bounds of minus and plus infinity, unless the column is an input of the run.
///
/// # Errors
/// The study has no such column of numbers.
pub fn values(study: &Study<'_>, column: &str, group: usize) -> Result<Values, InputError> {
    values_at(study, column, of_group(study, group))
}

/// [`values`] for any rows; `rows` gives point and row.
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

/// Values for a quantile: the lower bound of a beyond row is the value it reached inside the model.
///
/// # Errors
/// As [`values`].
pub fn levels(study: &Study<'_>, column: &str, group: usize) -> Result<Values, InputError> {
    levels_at(study, column, of_group(study, group))
}

/// [`levels`] for any rows; `rows` gives point and row.
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

/// Values for an exceedance curve: the lower bound of every bad row is the value reached while all guards held, so that it exceeds all
/// levels below.
///
/// # Errors
/// As [`values`].
pub fn reached(study: &Study<'_>, column: &str, group: usize) -> Result<Values, InputError> {
    reached_at(study, column, of_group(study, group))
}

/// [`reached`] for any rows; `rows` gives point and row.
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

/// `has_reached`: whether the reached value is the lower bound for rows of this status; for ok rows, whether an unjudged empty cell
/// may have any value.
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
