//! Highest values of the rows that are not ok, before a guard or limit was exceeded, next to the worst ok row.
//!
//! A row that is not ok is not in a median or a maximum. Its value before a guard or limit was exceeded (columns `guarded_NAME`) is a lower
//! bound for the complete run, and without it a summary could hide the worst run of a study.

use super::text::counted;
use bladeoff_text::document::units::format_digits;
use std::fmt::Write;

/// A row with its reached value.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    value: f64,
    sample: u64,
    status: String,
}

/// Reached values of the rows that are not ok, for one quantity and one detection.
#[derive(Debug, Clone, Default)]
pub(super) struct Reached {
    worst: Option<Row>,
    /// Number of rows without a reached value.
    unknown: u64,
}

impl Reached {
    /// Adds a row; `None` if it has no reached value. For equal values the smaller sample number is kept.
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

/// A quantity: name, unit, and for each detection the reached values and the worst ok value.
pub(super) type Line<'a> = (&'a str, &'a str, Vec<(&'a str, &'a Reached, Option<f64>)>);

/// Lines below the statistics; empty without reached values.
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
