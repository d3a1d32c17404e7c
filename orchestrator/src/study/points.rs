//! `[points]`: a CSV file whose header names parameters and whose rows are combinations. One axis of the study.
//!
//! Comma-separated; cells may be quoted; blank lines and lines that begin with `#` are skipped. A header cell is a
//! path, the end of one, or a column name of a result table (`diaphragms.seal.contact.gap_m`). Rows and columns are counted
//! before a value is read; of a cell only its value is kept.

use super::axis::{Axis, Varied};
use super::values::Gathered;
use super::vary::{MOST_POINTS, PathTable, one_kind};
use bladeoff_core::document::{BYTE_ORDER_MARK, Collector, Problems, cut};
use bladeoff_core::machine::PathInfo;
use bladeoff_protocol::messages::MAX_PARAMS;
use std::borrow::Cow;
use std::ops::Range;

/// Reads the points of `text`, named `file` in messages and `named` at `place` in the study.
pub(super) fn read_points(
    file: &str,
    named: &str,
    text: &str,
    place: &Range<usize>,
    paths: &PathTable,
) -> Result<Axis, Problems> {
    let mut problems = Collector::new(file, text);
    let axis = read(named, text, place, paths, &mut problems);
    problems.finish()?;
    Ok(axis.expect("without a problem there is an axis"))
}

/// `None`: the reason is among the problems.
fn read(
    named: &str,
    text: &str,
    place: &Range<usize>,
    paths: &PathTable,
    problems: &mut Collector<'_>,
) -> Option<Axis> {
    let Some(header) = lines(text).next() else {
        problems.add(0..0, "", "there is no header line").allowed = Some("a line of parameter paths".to_owned());
        return None;
    };
    let rows = lines(text).skip(1).count();
    if rows == 0 {
        problems.add(text.len()..text.len(), "", "there are no points below the header");
    }
    if let Some(surplus) = lines(text).nth(1 + MOST_POINTS) {
        problems.add(surplus, "", format!("{rows} points")).allowed = Some(format!("at most {MOST_POINTS}"));
        return None;
    }
    let columns = cells(text, header.clone()).count();
    if columns > MAX_PARAMS {
        let message = format!("the header has {columns} columns");
        problems.add(header, "", message).allowed = Some(format!("at most {MAX_PARAMS} parameters"));
        return None;
    }
    let header: Vec<Cell> = cells(text, header).collect();
    let parameters = parameters(&header, paths, problems);
    let mut values: Vec<Option<Gathered>> =
        parameters.iter().map(|info| info.as_ref().map(|info| Gathered::new(info, rows))).collect();
    for line in lines(text).skip(1) {
        let found = cells(text, line.clone()).inspect(|cell| cell.refuse_unsound(problems)).count();
        if found != columns {
            problems.add(line, "", format!("has {found} cells, the header has {columns}"));
            continue;
        }
        for ((cell, info), values) in cells(text, line).zip(&parameters).zip(&mut values) {
            if let (Some(info), Some(values)) = (info, values)
                && let Some(value) = paths.value(info, &cell.text, cell.span, &info.path, problems)
            {
                values.push(&value);
            }
        }
    }
    let mut varied = Vec::new();
    for ((cell, info), values) in header.iter().zip(parameters).zip(values) {
        // A column without a parameter was reported.
        let (Some(info), Some(values)) = (info, values) else { continue };
        if let Some(values) = one_kind(values, cell.span.clone(), &cell.text, problems) {
            varied.push(Varied { info, values, place: place.clone() });
        }
    }
    Some(Axis { name: format!("points of {named}"), varied, length: rows as u64 })
}

/// The parameters that the cells of the header name.
fn parameters(header: &[Cell<'_>], paths: &PathTable, problems: &mut Collector<'_>) -> Vec<Option<PathInfo>> {
    let columns = paths.columns();
    let mut parameters: Vec<Option<PathInfo>> = Vec::new();
    for cell in header {
        cell.refuse_unsound(problems);
        let key = cut(&cell.text, 80);
        let info = match columns.get(&*cell.text) {
            Some(info) => Some(info.clone()),
            None => paths.resolve(&cell.text, cell.span.clone(), &key, problems),
        };
        if info.is_some() && parameters.contains(&info) {
            problems.add(cell.span.clone(), key, "names the same parameter as an earlier column");
        }
        parameters.push(info);
    }
    parameters
}

/// The bytes of each line that says something.
fn lines(text: &str) -> impl Iterator<Item = Range<usize>> {
    let mut start = if text.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len_utf8() } else { 0 };
    text[start..].split('\n').filter_map(move |line| {
        let span = start..start + line.trim_end_matches('\r').len();
        start += line.len() + 1;
        let content = line.trim();
        (!content.is_empty() && !content.starts_with('#')).then_some(span)
    })
}

/// A cell and its bytes in the text.
struct Cell<'a> {
    text: Cow<'a, str>,
    span: Range<usize>,
    /// A quoted one ends with its quote.
    sound: bool,
}

impl Cell<'_> {
    fn refuse_unsound(&self, problems: &mut Collector<'_>) {
        if !self.sound {
            problems.add(self.span.clone(), "", "a quoted cell must end with a quote before the comma");
        }
    }
}

/// The cells of a line, at least one. A cell that begins with a quote ends at the next lone quote; "" inside stands for one.
fn cells(text: &str, line: Range<usize>) -> impl Iterator<Item = Cell<'_>> {
    let mut next = Some(line.start);
    std::iter::from_fn(move || {
        let at = next?;
        let rest = &text[at..line.end];
        let blank = rest.len() - rest.trim_start_matches([' ', '\t']).len();
        let (cell, end) = if rest[blank..].starts_with('"') {
            let (cell, length) = quoted(&rest[blank + 1..]);
            let end = (at + blank + 1 + length).min(line.end);
            let after = &text[end..line.end];
            let to_comma = after.find(',').unwrap_or(after.len());
            let sound = cell.is_some() && after[..to_comma].trim().is_empty();
            (Cell { text: cell.unwrap_or_default().into(), span: at + blank..end, sound }, end + to_comma)
        } else {
            let length = rest.find(',').unwrap_or(rest.len());
            let content = rest[..length].trim();
            let start = at + (rest[..length].len() - rest[..length].trim_start().len());
            (Cell { text: content.into(), span: start..start + content.len(), sound: true }, at + length)
        };
        // After the comma.
        next = (end < line.end).then_some(end + 1);
        Some(cell)
    })
}

/// What a quoted cell says (`None` if it never ends) and its length in bytes, the closing quote included.
fn quoted(rest: &str) -> (Option<String>, usize) {
    let mut content = String::new();
    let mut characters = rest.char_indices().peekable();
    while let Some((at, character)) = characters.next() {
        if character != '"' {
            content.push(character);
        } else if characters.peek().is_some_and(|&(_, next)| next == '"') {
            characters.next();
            content.push('"');
        } else {
            return (Some(content), at + 1);
        }
    }
    (None, rest.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn texts(line: &str) -> Vec<String> {
        let cells = cells(line, 0..line.len()).inspect(|cell| assert!(cell.sound, "{line:?}"));
        cells.map(|cell| cell.text.into_owned()).collect()
    }

    #[test]
    fn cells_are_trimmed_and_may_be_quoted() {
        assert_eq!(texts("0.5 mm, 0.2 ,hyp1"), ["0.5 mm", "0.2", "hyp1"]);
        assert_eq!(texts("\"a,b\" , \"say \"\"x\"\"\",,"), ["a,b", "say \"x\"", "", ""]);
    }

    #[test]
    fn a_quoted_cell_without_its_end_is_unsound() {
        let sound = |line: &str| cells(line, 0..line.len()).map(|cell| cell.sound).collect::<Vec<_>>();
        assert_eq!(sound("\"a"), [false]);
        assert_eq!(sound("\"a\"b,c"), [false, true]);
        assert_eq!(sound("\"a\" ,c"), [true, true]);
    }

    #[test]
    fn blank_lines_and_remarks_are_skipped() {
        let text = "# remark\na,b\r\n\n1,2\n";
        assert_eq!(lines(text).map(|span| &text[span]).collect::<Vec<_>>(), ["a,b", "1,2"]);
        let marked = format!("\u{feff}{text}");
        assert_eq!(lines(&marked).map(|span| &marked[span]).collect::<Vec<_>>(), ["a,b", "1,2"]);
    }

    proptest! {
        #[test]
        fn any_text_gives_cells_inside_its_line(line in "[^\n]{0,60}") {
            for cell in cells(&line, 0..line.len()) {
                prop_assert!(cell.span.start <= cell.span.end && cell.span.end <= line.len());
                prop_assert!(line.is_char_boundary(cell.span.start) && line.is_char_boundary(cell.span.end));
            }
        }
    }
}
