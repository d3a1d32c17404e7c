//! Highest values of the rows that are not ok, before a guard or limit was exceeded, beside the worst ok row.
//!
//! A row that is not ok has no value in a median or a maximum. What it reached before a guard or limit was exceeded (columns `guarded_NAME`) is a
//! lower bound of what the run would have reached, so that a summary without it could hide the worst run of a study.

use super::text::counted;
use bladeoff_text::document::units::format_digits;
use std::fmt::Write;

/// A row and what it reached.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    value: f64,
    sample: u64,
    status: String,
}

/// Rows that are not ok, of one quantity and one detection.
#[derive(Debug, Clone, Default)]
pub(super) struct Reached {
    worst: Option<Row>,
    /// Rows of which nothing is known.
    unknown: u64,
}

impl Reached {
    /// A row; `None`: nothing is known of it. Of equal values the sample with the smaller number is named.
    pub fn see(&mut self, value: Option<f64>, sample: u64, status: &str) {
        let Some(value) = value.filter(|value| value.is_finite()) else {
            self.unknown += 1;
            return;
        };
        let is_worse = |row: &Row| value > row.value || (value == row.value && sample < row.sample);
        if self.worst.as_ref().is_none_or(is_worse) {
            self.worst = Some(Row { value, sample, status: status.to_owned() });
        }
    }
}

/// One quantity: its name, its unit, and of each detection what its rows reached and the worst ok value.
pub(super) type Line<'a> = (&'a str, &'a str, Vec<(&'a str, &'a Reached, Option<f64>)>);

/// The lines below the statistics; empty where no row is known.
pub(super) fn reached(lines: &[Line<'_>]) -> String {
    let mut text = String::new();
    let mut unknown = 0;
    for (label, unit, groups) in lines {
        unknown = unknown.max(groups.iter().map(|(_, reached, _)| reached.unknown).sum());
        let rows = groups.iter().filter_map(|(name, reached, ok)| Some((*name, reached.worst.as_ref()?, *ok)));
        let order = |a: &Row, b: &Row| a.value.total_cmp(&b.value).then(b.sample.cmp(&a.sample));
        let Some((name, row, ok)) = rows.max_by(|a, b| order(a.1, b.1)) else { continue };
        let show = |value: f64| format_digits(value, unit, 3);
        let ok = match ok {
            Some(ok) if row.value > ok => format!("more than the worst ok run, {}", show(ok)),
            Some(ok) => format!("the worst ok run: {}", show(ok)),
            None => "no ok run has a value".to_owned(),
        };
        writeln!(text, "  {label}: {} ({name}, sample {}, {}); {ok}", show(row.value), row.sample, row.status)
            .expect("writing to a String cannot fail");
    }
    if unknown > 0 {
        let has = if unknown == 1 { "has" } else { "have" };
        writeln!(text, "  {} {has} no such value", counted(unknown, "run")).expect("writing to a String cannot fail");
    }
    if text.is_empty() {
        return text;
    }
    format!("Highest values of the runs that are not ok, before a guard or limit was exceeded (lower bounds):\n{text}")
}
