//! `[points]`: a CSV file whose header names parameters and whose rows are combinations. One axis of the study.
//!
//! For its syntax see `csv.rs`. A header cell is a path or the end of a path, the name or the end of the name of a column of a result table
//! (`diaphragms.seal.contact.gap_m`, `contact.gap_m`), or a path with a unit in brackets (`contact.gap [mm]`). Other columns are copied to
//! the table or ignored as the study specifies (`extra_columns.rs`). Rows and columns are counted before any value is read; a cell's text is
//! not kept.

use super::axis::MOST_VARIED;
use super::axis::{Axis, Varied};
use super::csv::{Cell, Csv, DecimalSign};
use super::extra_columns::{ExtraColumn, Gathering, Others};
use super::header::{refuse_numbers, unit_for, with_unit};
use super::values::Gathered;
use super::vary::{MOST_POINTS, PathTable, one_kind};
use bladeoff_model::machine::PathInfo;
use bladeoff_text::document::{Collector, Problems, cut};
use std::ops::Range;

/// The points file and its settings in the study.
pub(super) struct PointsFile<'a> {
    /// File name in messages.
    pub file: &'a str,
    /// Name in the study, and its position there.
    pub named: &'a str,
    pub place: Range<usize>,
    pub text: &'a str,
    /// Columns that are not parameters.
    pub others: &'a Others,
}

/// Reads the points.
pub(super) fn read_points(file: &PointsFile<'_>, paths: &PathTable) -> Result<(Axis, Vec<ExtraColumn>), Problems> {
    let mut problems = Collector::new(file.file, file.text);
    let found = read(file, paths, &mut problems);
    problems.finish()?;
    Ok(found.expect("without a problem there is an axis"))
}

/// `None`: problems were added.
fn read(file: &PointsFile<'_>, paths: &PathTable, problems: &mut Collector<'_>) -> Option<(Axis, Vec<ExtraColumn>)> {
    let text = file.text;
    let csv = Csv::new(text, problems)?;
    let Some(header) = csv.lines().next() else {
        problems.add(0..0, "", "there is no header line").allowed = Some("a line of parameter paths".to_owned());
        return None;
    };
    let rows = csv.lines().skip(1).count();
    if rows == 0 {
        problems.add(text.len()..text.len(), "", "no points below the header");
    }
    if let Some(surplus) = csv.lines().nth(1 + MOST_POINTS) {
        problems.add(surplus, "", format!("{rows} points")).allowed = Some(format!("at most {MOST_POINTS}"));
        return None;
    }
    let columns = csv.cells(header.clone()).count();
    let of_dakota = text[header.clone()].starts_with("%eval_id");
    if columns > MOST_VARIED + file.others.count() + if of_dakota { DAKOTA_COLUMNS.len() } else { 0 } {
        let message = format!("the header has {columns} columns");
        problems.add(header, "", message).allowed = Some(format!("at most {MOST_VARIED} parameters"));
        return None;
    }
    let header: Vec<Cell> = csv.header(header);
    let columns = header.len();
    if refuse_numbers(&header, problems) {
        return None;
    }
    let mut meanings = meanings(&header, (file.others, of_dakota), rows, paths, problems);
    if meanings.iter().all(|meaning| matches!(meaning, Meaning::ExtraColumn(_) | Meaning::Ignored)) {
        let span = header.first().map_or(0..0, |cell| cell.span.clone());
        problems.add(span, "", "no column names a parameter");
    }
    let mut sign = DecimalSign::default();
    for line in csv.lines().skip(1) {
        let found = csv.cells(line.clone()).inspect(|cell| cell.refuse_unsound(problems)).count();
        if found != columns {
            let hint = mismatch(csv, &text[line.clone()]);
            let message =
                format!("has {found} cells, the header has {columns} (separated by {})", csv.separator_in_words());
            problems.add(line, "", message).allowed = hint;
            continue;
        }
        for (cell, meaning) in csv.cells(line).zip(&mut meanings) {
            if matches!(meaning, Meaning::Unknown | Meaning::Ignored) {
                continue;
            }
            let free = matches!(meaning, Meaning::ExtraColumn(_));
            let Some(shown) = sign.read(csv, &cell, free, problems) else { continue };
            match meaning {
                Meaning::Parameter(info, unit, values) => {
                    let shown = with_unit(shown, unit);
                    if let Some(value) = paths.value(info, &shown, cell.span.clone(), &info.path, problems) {
                        values.push(&value);
                    }
                }
                Meaning::ExtraColumn(values) => values.push(&cell, &shown, problems),
                Meaning::Unknown | Meaning::Ignored => {}
            }
        }
    }
    sign.refuse_both(csv, problems);
    let (mut varied, mut extra) = (Vec::new(), Vec::new());
    for (cell, meaning) in header.iter().zip(meanings) {
        match meaning {
            Meaning::Parameter(info, _, values) => {
                if let Some(values) = one_kind(values, cell.span.clone(), &cell.text, problems) {
                    let place = file.place.clone();
                    varied.push(Varied { info, short: None, is_variable: false, values, place });
                }
            }
            Meaning::ExtraColumn(values) => extra.push(values.finish()),
            Meaning::Unknown | Meaning::Ignored => {}
        }
    }
    Some((Axis { name: format!("points of {}", file.named), varied, length: rows as u64 }, extra))
}

/// Suggestion for a line whose number of cells differs from that of the header.
fn mismatch(csv: Csv<'_>, line: &str) -> Option<String> {
    let comma_between_digits =
        line.as_bytes().windows(3).any(|w| w[0].is_ascii_digit() && w[1] == b',' && w[2].is_ascii_digit());
    match csv.separator {
        ',' if line.contains(';') => {
            Some("one separator in the whole file: with `;` in the header too, `,` is the decimal sign".to_owned())
        }
        ',' if comma_between_digits => {
            Some("decimal points; decimal commas only where `;` or a tab separates the cells".to_owned())
        }
        ' ' => Some(
            "quoted cells, or a number and its unit without a blank (0.4mm); an empty cell is not visible".to_owned(),
        ),
        _ => None,
    }
}

/// Columns that Dakota writes before the variables.
const DAKOTA_COLUMNS: [&str; 2] = ["eval_id", "interface"];

/// Meaning of a column.
enum Meaning {
    /// A parameter, and the unit of its numbers in the header ("" for none).
    Parameter(PathInfo, String, Gathered),
    ExtraColumn(Gathering),
    Ignored,
    /// Unknown, which has been reported.
    Unknown,
}

/// Meanings of the columns by the cells of the header.
fn meanings(
    header: &[Cell<'_>],
    (others, of_dakota): (&Others, bool),
    rows: usize,
    paths: &PathTable,
    problems: &mut Collector<'_>,
) -> Vec<Meaning> {
    let columns = paths.columns();
    let named: Vec<PathInfo> = header.iter().filter_map(|cell| paths.known(&columns, &cell.text)).collect();
    let mut meanings: Vec<Meaning> = Vec::new();
    let mut seen: Vec<&str> = Vec::new();
    for cell in header {
        cell.refuse_unsound(problems);
        let name: &str = &cell.text;
        let key = cut(name, 80);
        let left_out = of_dakota && DAKOTA_COLUMNS.contains(&name) && !others.carries(name);
        if left_out || others.ignores(name) {
            meanings.push(Meaning::Ignored);
            continue;
        }
        if others.carries(name) {
            if seen.contains(&name) {
                problems.add(cell.span.clone(), key, "names the same column as an earlier one");
            }
            seen.push(name);
            meanings.push(Meaning::ExtraColumn(Gathering::new(name)));
            continue;
        }
        let (info, unit) = match (columns.find(name), paths.with_unit(name)) {
            (Some(info), _) => (Some(info.clone()), ""),
            (None, Some((info, unit))) => (Some(info), unit),
            (None, None) => (paths.column(name, cell.span.clone(), &named, problems), ""),
        };
        let unit = match info.as_ref().map(|info| unit_for(unit, info.unit)) {
            Some(Err((message, nearest))) => {
                let problem = problems.add(cell.span.clone(), key, message);
                problem.nearest = nearest;
                meanings.push(Meaning::Unknown);
                continue;
            }
            Some(Ok(unit)) => unit,
            None => String::new(),
        };
        let is_known =
            |known: &Meaning| matches!((known, &info), (Meaning::Parameter(known, ..), Some(info)) if known == info);
        if meanings.iter().any(is_known) {
            problems.add(cell.span.clone(), key, "names the same parameter as an earlier column");
        }
        meanings.push(match info {
            Some(info) => {
                let values = Gathered::new(&info, rows);
                Meaning::Parameter(info, unit, values)
            }
            None => Meaning::Unknown,
        });
    }
    meanings
}
