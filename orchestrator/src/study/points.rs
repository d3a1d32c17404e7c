//! `[points]`: a CSV file whose header names parameters and whose rows are combinations. One axis of the study.
//!
//! Comma-separated; cells may be quoted; blank lines and lines that begin with `#` are skipped. A header cell is a
//! path, the end of one, or a column name of a result table (`diaphragms.seal.contact.gap_m`).

use super::axis::{Axis, ValueList, Varied};
use super::vary::{PathTable, of_one_kind};
use bladeoff_core::document::{Collector, Problems};
use bladeoff_core::machine::ParamValue;
use std::ops::Range;

/// A cell and its bytes in the text.
struct Cell {
    text: String,
    span: Range<usize>,
}

/// Reads the points of `text`, named `file` in messages and `named` at `place` in the study.
pub(super) fn read_points(
    file: &str,
    named: &str,
    text: &str,
    place: &Range<usize>,
    paths: &PathTable,
) -> Result<Axis, Problems> {
    let mut problems = Collector::new(file, text);
    let mut lines = lines(text);
    let Some(header) = lines.next() else {
        problems.add(0..0, "", "there is no header line").allowed = Some("a line of parameter paths".to_owned());
        problems.finish()?;
        unreachable!("a problem was added");
    };
    let header = split(text, header, &mut problems);
    let parameters: Vec<_> = header
        .iter()
        .map(|cell| paths.resolve_column(&cell.text, cell.span.clone(), &cell.text, &mut problems))
        .collect();
    for (at, info) in parameters.iter().enumerate() {
        if info.is_some() && parameters[..at].contains(info) {
            problems.add(header[at].span.clone(), &*header[at].text, "names the same parameter as an earlier column");
        }
    }
    let mut columns: Vec<Vec<ParamValue>> = header.iter().map(|_| Vec::new()).collect();
    let mut rows = 0;
    for line in lines {
        rows += 1;
        let cells = split(text, line.clone(), &mut problems);
        if cells.len() != header.len() {
            let message = format!("has {} cells, the header has {}", cells.len(), header.len());
            problems.add(line, "", message);
            continue;
        }
        for ((cell, info), column) in cells.iter().zip(&parameters).zip(&mut columns) {
            if let Some(info) = info {
                column.extend(paths.value(info, &cell.text, cell.span.clone(), &info.path, &mut problems));
            }
        }
    }
    if rows == 0 {
        problems.add(text.len()..text.len(), "", "there are no points below the header");
    }
    for (cell, column) in header.iter().zip(&columns) {
        of_one_kind(column, cell.span.clone(), &cell.text, &mut problems);
    }
    problems.finish()?;
    let varied = parameters.into_iter().zip(columns);
    let varied: Vec<Varied> = varied
        .filter_map(|(info, values)| {
            Some(Varied { info: info?, values: ValueList::Listed(values), place: place.clone() })
        })
        .collect();
    Ok(Axis { name: format!("points of {named}"), varied, length: rows })
}

/// The bytes of each line that says something.
fn lines(text: &str) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    text.split('\n').filter_map(move |line| {
        let span = start..start + line.trim_end_matches('\r').len();
        start += line.len() + 1;
        let content = line.trim();
        (!content.is_empty() && !content.starts_with('#')).then_some(span)
    })
}

/// The cells of a line. A cell that begins with a quote ends at the next lone quote; "" inside stands for one.
fn split(text: &str, line: Range<usize>, problems: &mut Collector) -> Vec<Cell> {
    let mut cells = Vec::new();
    let mut at = line.start;
    loop {
        let rest = &text[at..line.end];
        let blank = rest.len() - rest.trim_start_matches([' ', '\t']).len();
        if rest[blank..].starts_with('"') {
            let (cell, length) = quoted(&rest[blank + 1..]);
            let end = (at + blank + 1 + length).min(line.end);
            let after = &text[end..line.end];
            let to_comma = after.find(',').unwrap_or(after.len());
            if cell.is_none() || !after[..to_comma].trim().is_empty() {
                problems.add(at + blank..end, "", "a quoted cell must end with a quote before the comma");
            }
            cells.push(Cell { text: cell.unwrap_or_default(), span: at + blank..end });
            at = end + to_comma;
        } else {
            let length = rest.find(',').unwrap_or(rest.len());
            let content = rest[..length].trim();
            let start = at + (rest[..length].len() - rest[..length].trim_start().len());
            cells.push(Cell { text: content.to_owned(), span: start..start + content.len() });
            at += length;
        }
        if at >= line.end {
            return cells;
        }
        at += 1; // the comma
    }
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
        let mut problems = Collector::new("f", line);
        let cells = split(line, 0..line.len(), &mut problems);
        assert!(problems.is_empty(), "{line:?}");
        cells.into_iter().map(|cell| cell.text).collect()
    }

    #[test]
    fn cells_are_trimmed_and_may_be_quoted() {
        assert_eq!(texts("0.5 mm, 0.2 ,hyp1"), ["0.5 mm", "0.2", "hyp1"]);
        assert_eq!(texts("\"a,b\" , \"say \"\"x\"\"\",,"), ["a,b", "say \"x\"", "", ""]);
    }

    #[test]
    fn blank_lines_and_remarks_are_skipped() {
        let text = "# remark\na,b\r\n\n1,2\n";
        assert_eq!(lines(text).map(|span| &text[span]).collect::<Vec<_>>(), ["a,b", "1,2"]);
    }

    proptest! {
        #[test]
        fn any_text_gives_cells_inside_its_line(line in "[^\n]{0,60}") {
            let mut problems = Collector::new("f", &line);
            for cell in split(&line, 0..line.len(), &mut problems) {
                prop_assert!(cell.span.start <= cell.span.end && cell.span.end <= line.len());
                prop_assert!(line.is_char_boundary(cell.span.start) && line.is_char_boundary(cell.span.end));
            }
        }
    }
}
