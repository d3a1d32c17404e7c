//! Plain aligned tables and durations.

use std::fmt::Write;
use std::time::Duration;

/// Side on which a column is flush.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// A table of text: two spaces between columns, no lines, no trailing blanks.
#[derive(Debug, Clone)]
pub struct TextTable {
    align: Vec<Align>,
    rows: Vec<Vec<String>>,
}

impl TextTable {
    /// With a header row.
    #[must_use]
    pub fn new(header: &[(&str, Align)]) -> Self {
        Self {
            align: header.iter().map(|(_, align)| *align).collect(),
            rows: vec![header.iter().map(|(title, _)| (*title).to_owned()).collect()],
        }
    }

    /// Adds a row; it has as many cells as the header.
    pub fn row(&mut self, cells: Vec<String>) {
        debug_assert_eq!(cells.len(), self.align.len());
        self.rows.push(cells);
    }

    /// The lines, each behind `indent`.
    #[must_use]
    pub fn render(&self, indent: &str) -> String {
        let widths: Vec<usize> = (0..self.align.len())
            .map(|column| self.rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0))
            .collect();
        let mut text = String::new();
        for row in &self.rows {
            let mut line = indent.to_owned();
            for (column, cell) in row.iter().enumerate() {
                if column > 0 {
                    line.push_str("  ");
                }
                let pad = widths[column] - cell.chars().count();
                match self.align[column] {
                    Align::Left => write!(line, "{cell}{:pad$}", ""),
                    Align::Right => write!(line, "{:pad$}{cell}", ""),
                }
                .expect("writing to a String cannot fail");
            }
            text.push_str(line.trim_end());
            text.push('\n');
        }
        text
    }
}

/// Text in lines of at most `width` characters, broken between words; `first` stands before the first line, `others` before the
/// others. A word that is longer stays whole.
#[must_use]
pub fn wrapped(text: &str, width: usize, first: &str, others: &str) -> String {
    let mut lines = String::new();
    let mut line = first.to_owned();
    let mut is_empty = true;
    for word in text.split_whitespace() {
        if !is_empty && line.chars().count() + 1 + word.chars().count() > width {
            lines.push_str(&line);
            lines.push('\n');
            line = others.to_owned();
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(word);
        is_empty = false;
    }
    lines.push_str(&line);
    lines.push('\n');
    lines
}

/// How many there are: "1 sample", "2 samples".
#[must_use]
pub fn counted(count: u64, one: &str) -> String {
    if count == 1 { format!("1 {one}") } else { format!("{count} {one}s") }
}

/// The verb of so many: "1 sample is", "2 samples are".
#[must_use]
pub fn are(count: u64) -> &'static str {
    if count == 1 { "is" } else { "are" }
}

/// A duration as "0.8 s", "45 s", "3 min 20 s", "7 h 05 min".
#[must_use]
pub fn duration(duration: Duration) -> String {
    let seconds = duration.as_secs_f64();
    let whole = seconds.round() as u64;
    match whole {
        _ if seconds < 9.95 => format!("{seconds:.1} s"),
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_without_trailing_blanks() {
        let mut table = TextTable::new(&[("name", Align::Left), ("n", Align::Right), ("why", Align::Left)]);
        table.row(vec!["a".into(), "10".into(), String::new()]);
        table.row(vec!["longer".into(), "5".into(), "x".into()]);
        assert_eq!(table.render("  "), "  name     n  why\n  a       10\n  longer   5  x\n");
    }

    #[test]
    fn words_are_wrapped() {
        assert_eq!(wrapped("aa bb cc", 5, "", "  "), "aa bb\n  cc\n");
        assert_eq!(wrapped("toolong b", 3, "", " "), "toolong\n b\n");
        assert_eq!(wrapped("", 3, "-", " "), "-\n");
    }

    #[test]
    fn one_is_one() {
        assert_eq!([0, 1, 2].map(|count| counted(count, "worker")), ["0 workers", "1 worker", "2 workers"]);
        assert_eq!([0, 1, 2].map(are), ["are", "is", "are"]);
    }

    #[test]
    fn durations_read_as_people_say_them() {
        for (seconds, text) in [(0.84, "0.8 s"), (45.2, "45 s"), (200.0, "3 min 20 s"), (25_500.0, "7 h 05 min")] {
            assert_eq!(duration(Duration::from_secs_f64(seconds)), text);
        }
    }
}
