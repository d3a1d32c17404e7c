//! Regimes of all runs that have one, by status: runs that are not ok are counted and marked.

use super::rows::{ByStatus, Seen};
use super::words::{by_status, percent};
use crate::run::TableColumn;
use bladeoff_answers::page::chart::{Axis, Chart, Series, Shape};
use bladeoff_answers::page::{Block, Table};
use std::collections::BTreeSet;

/// Counts of one result column that has words.
struct Counts<'a> {
    seen: &'a Seen,
    column: &'a str,
}

impl<'a> Counts<'a> {
    fn entries(&self) -> impl Iterator<Item = (&'a str, &'a str, &'a ByStatus)> {
        let column = self.column;
        let all = self.seen.regimes.iter().filter(move |((name, ..), _)| name == column);
        all.map(|((_, detection, word), by)| (detection.as_str(), word.as_str(), by))
    }

    fn of(&self, detection: &str, word: &str) -> Option<&'a ByStatus> {
        self.entries().find(|(d, w, _)| *d == detection && *w == word).map(|(.., by)| by)
    }

    /// Number of runs with a given detection that have a regime.
    fn total(&self, detection: &str) -> u64 {
        self.entries().filter(|(d, w, _)| *d == detection && !w.is_empty()).map(|(.., by)| sum(by)).sum()
    }

    /// Number of runs with (or without) a regime, by status.
    fn by_status(&self, has_regime: bool) -> ByStatus {
        let mut all = ByStatus::new();
        for (_, _, by) in self.entries().filter(|(_, word, _)| word.is_empty() != has_regime) {
            by.iter().for_each(|(status, count)| *all.entry(status.clone()).or_default() += count);
        }
        all
    }
}

fn sum(by: &ByStatus) -> u64 {
    by.values().sum()
}

fn not_ok(by: &ByStatus) -> u64 {
    by.iter().filter(|(status, _)| *status != "ok").map(|(_, count)| count).sum()
}

/// The number of runs in each regime.
pub(super) fn regimes(seen: &Seen, columns: &[TableColumn]) -> Vec<Block> {
    let names: BTreeSet<&str> = seen.regimes.keys().map(|(column, ..)| column.as_str()).collect();
    let of = |column: &str| {
        let field = columns.iter().map(|of| &of.field).find(|field| field.name == column);
        let meaning = field.filter(|field| !field.meaning.is_empty());
        let meaning = meaning.map(|field| Block::Note(format!("{}: {}.", column.replace('_', " "), field.meaning)));
        let block = block(&Counts { seen, column });
        let meaning = meaning.filter(|_| block.is_some());
        block.into_iter().chain(meaning).collect::<Vec<_>>()
    };
    names.into_iter().flat_map(of).collect()
}

fn block(counts: &Counts<'_>) -> Option<Block> {
    let detections: BTreeSet<&str> = counts.entries().map(|(detection, ..)| detection).collect();
    let words: BTreeSet<&str> = counts.entries().map(|(_, word, _)| word).filter(|word| !word.is_empty()).collect();
    if words.is_empty() {
        return None;
    }
    let name = counts.column.replace('_', " ");
    let mut head = vec![name.clone()];
    head.extend(detections.iter().map(|of| if of.is_empty() { "runs".to_owned() } else { (*of).to_owned() }));
    let share =
        |detection: &str, by: Option<&ByStatus>| by.map_or(0, sum) as f64 / counts.total(detection).max(1) as f64;
    let cell = |detection: &str, word: &str| {
        let by = counts.of(detection, word);
        let marks = by.filter(|by| not_ok(by) > 0).map(|by| format!(": {}", by_status(by))).unwrap_or_default();
        format!("{} ({}){marks}", by.map_or(0, sum), percent(share(detection, by)))
    };
    let row = |word: &&str| {
        let cells = detections.iter().map(|detection| cell(detection, word));
        std::iter::once((*word).to_owned()).chain(cells).collect()
    };
    let rows: Vec<Vec<String>> = words.iter().map(row).collect();
    let places: Vec<(&str, &str)> =
        detections.iter().flat_map(|detection| words.iter().map(move |word| (*detection, *word))).collect();
    let bars: Vec<(f64, f64)> = places
        .iter()
        .enumerate()
        .map(|(at, (detection, word))| (at as f64, 100.0 * share(detection, counts.of(detection, word))))
        .collect();
    let label = |(detection, word): &(&str, &str)| {
        let by = counts.of(detection, word);
        let marked = by.map_or(0, not_ok);
        let mark = if marked > 0 { format!(" ({marked} of {} not ok)", by.map_or(0, sum)) } else { String::new() };
        if detection.is_empty() || detections.len() == 1 {
            format!("{word}{mark}")
        } else {
            format!("{detection}: {word}{mark}")
        }
    };
    let chart = Chart {
        x: Axis::numbers("share of the runs that have one [%]", bars.iter().map(|bar| bar.1).chain([0.0])),
        y: Axis::words(places.iter().map(label).collect()),
        series: vec![Series { name: String::new(), colour: "c0", shape: Shape::Bars(bars, 0.64) }],
        height: 20 + 24 * places.len() as u32,
    };
    let table = Table { head, rows, verbatim: Vec::new() };
    Some(chart.figure(caption(&name, counts), Some(table)).into())
}

/// Caption: which runs are counted, and how many are not.
fn caption(name: &str, counts: &Counts<'_>) -> String {
    let (with, without) = (counts.by_status(true), counts.by_status(false));
    let mut text = format!("{name} of all runs that have one: {}.", by_status(&with));
    if not_ok(&with) > 0 {
        text += " For a run that is not ok it describes the whole computed motion.";
    }
    if !without.is_empty() {
        text += &format!(" Without one: {}.", by_status(&without));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn runs_that_are_not_ok_are_counted_and_marked() {
        let by = |counts: &[(&str, u64)]| counts.iter().map(|(status, n)| ((*status).to_owned(), *n)).collect();
        let key = |word: &str| ("whirl".to_owned(), "hyp2".to_owned(), word.to_owned());
        let regimes = BTreeMap::from([
            (key("forward"), by(&[("ok", 22)])),
            (key("backward"), by(&[("invalid", 2), ("beyond", 1)])),
            (key(""), by(&[("failed", 4)])),
        ]);
        let seen = Seen {
            coordinates: Vec::new(),
            words: Vec::new(),
            rows: 29,
            kinds: Vec::new(),
            picked: Vec::new(),
            ends: Vec::new(),
            regimes,
        };
        let blocks = regimes_of(&seen);
        let Block::Figure(figure) = &blocks[0] else { panic!("a figure") };
        assert_eq!(
            figure.caption,
            "whirl of all runs that have one: 22 ok, 1 beyond the model, 2 invalid. For a run that is not ok it describes the whole computed motion. \
             Without one: 4 failed."
        );
        let rows = &figure.table.as_ref().expect("a table").rows;
        assert_eq!(rows[0], ["backward", "3 (12 %): 1 beyond the model, 2 invalid"]);
        assert_eq!(rows[1], ["forward", "22 (88 %)"]);
    }

    fn regimes_of(seen: &Seen) -> Vec<Block> {
        super::regimes(seen, &[])
    }
}
