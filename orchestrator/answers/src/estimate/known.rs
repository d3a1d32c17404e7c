//! What is known of each point of a group: whether a condition holds, or a column's value.
//!
//! ```text
//! ok row                          the condition by its program, the value as it stands
//! bad row, column given           the value; where there is none, it was to be derived and does not exist: nothing
//! bad row, column that grows      [what was reached while all guards held, no bound); where nothing but a step limit ended the run,
//!                                 that is the value as it stands
//! bad row, time of a first event  the value, where it happened and nothing but a step limit ended the run; else nothing
//! bad row, any other column       nothing
//! beyond row (beyond the model)   as a bad row; where its run ended at the limit, as one that a step limit ended
//! any row, time of a limit        the value, an empty cell too: no limit was exceeded
//! ```
//! An empty cell of an ok row (nothing of the kind happened): no comparison with it holds but `!=`; it has no value, and is counted.
//! A condition that has no value itself (the square root of a negative number) is not known, in an ok row as in a bad one.
//!
//! A mean takes a bad row's value as anything at all, also where a part of it was reached. A quantile does so for failed and invalid rows;
//! of a beyond row, whose numerical checks passed, it takes what was reached as the least value.

use super::bad::Bad;
use super::formula::Formula;
use super::input::{InputError, Nature, Study};
use super::span::Span;
use super::truth::{Truth, truth, truth_of_known};
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
    /// Ok rows where the condition has no value (the square root of a negative number): they are open.
    pub undefined: u64,
}

impl Truths {
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
    // nothing is wrong with the run up to its end
    let is_cut_off = || match study.status[row] {
        Status::Beyond => study.at_limit[row],
        _ => causes.iter().eq([Cause::StepLimit]),
    };
    match nature {
        Nature::Given => value.map_or(Span::LOST, Span::point),
        // a process that died, and a solver that panicked, lost what the run had recorded
        Nature::Limit if study.status[row] == Status::Quarantined || causes.contains(Cause::Panicked) => Span::WHOLE,
        Nature::Limit => value.map_or(Span::NONE, Span::point),
        Nature::Once if is_cut_off() => value.map_or(Span::WHOLE, Span::point),
        // sound as far as it went
        Nature::Grows(_) if is_cut_off() => value.map_or(Span::WHOLE, Span::from),
        Nature::Grows(held) => held.and_then(|held| held[row]).map_or(Span::WHOLE, Span::from),
        Nature::Once | Nature::Free => Span::WHOLE,
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
    let points = rows.len();
    let mut found = Truths { of: Vec::with_capacity(points), status: Vec::with_capacity(points), ..Truths::default() };
    let (mut known, mut spans) = (Vec::new(), Vec::new());
    for row in rows {
        let ok = study.status[row] == Status::Ok;
        found.status.push(study.status[row]);
        found.of.push(if ok {
            found.empty += u64::from(columns.iter().any(|(values, _)| values[row].is_none()));
            let of = |number: usize| columns[number].0[row].unwrap_or(f64::NAN);
            let truth = truth_of_known(&formula.program, of, &mut known);
            found.undefined += u64::from(truth == Truth::Open);
            truth
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

/// `has_reached`: whether what a row of this status had reached is taken as its least value.
fn values_as(
    study: &Study<'_>,
    column: &str,
    rows: impl Iterator<Item = (usize, usize)>,
    has_reached: impl Fn(Status) -> bool,
) -> Result<Values, InputError> {
    let (cells, nature) = study.numbers(column)?;
    let mut found = Values::default();
    for (point, row) in rows {
        let span = if study.status[row] == Status::Ok {
            found.bad.see(Status::Ok, false);
            let Some(value) = cells[row].filter(|value| !value.is_nan()) else {
                found.empty += 1;
                continue;
            };
            Span::point(value)
        } else {
            found.bad.see(study.status[row], false);
            let is_known = matches!(nature, Nature::Given | Nature::Limit) || has_reached(study.status[row]);
            let span = span(study, row, cells[row], if is_known { nature } else { Nature::Free });
            if span == Span::NONE {
                found.empty += 1;
                continue;
            }
            span
        };
        found.point.push(point as u32);
        found.low.push(span.lo);
        found.high.push(span.hi);
    }
    Ok(found)
}
