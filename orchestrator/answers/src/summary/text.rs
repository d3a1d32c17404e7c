//! Plain aligned tables and durations.

use std::fmt::Write;
use std::time::Duration;

/// Alignment of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Left, for words.
    Left,
    /// Right, for numbers.
    Right,
}

/// A text table: two spaces between columns, no lines, no trailing blanks.
#[derive(Debug, Clone)]
pub struct TextTable {
    align: Vec<Align>,
    rows: Vec<Vec<String>>,
}

impl TextTable {
    /// A table with a header row.
    #[must_use]
    pub fn new(header: &[(&str, Align)]) -> Self {
        Self {
            align: header.iter().map(|(_, align)| *align).collect(),
            rows: vec![header.iter().map(|(title, _)| (*title).to_owned()).collect()],
        }
    }

    /// Adds a row with as many cells as the header.
    pub fn row(&mut self, cells: Vec<String>) {
        debug_assert_eq!(cells.len(), self.align.len());
        self.rows.push(cells);
    }

    /// The table if it fits this width; otherwise several lines for each row: its first cell, then each other cell with its title, all within
    /// the width.
    #[must_use]
    pub fn fitting(&self, indent: &str, width: Option<usize>) -> String {
        let whole = self.render(indent);
        let Some(width) = width.filter(|width| whole.lines().any(|line| line.chars().count() > *width)) else {
            return whole;
        };
        let (below, further) = (format!("{indent}  "), format!("{indent}      "));
        let (titles, rows) = self.rows.split_first().expect("made with a header");
        let mut text = String::new();
        for row in rows {
            text.push_str(&wrapped(&row[0], width, indent, &below));
            for (title, cell) in titles.iter().zip(row).skip(1).filter(|(_, cell)| !cell.is_empty()) {
                let told = if title.is_empty() { cell.clone() } else { format!("{title}: {cell}") };
                text.push_str(&wrapped(&told, width, &below, &further));
            }
        }
        text
    }

    /// The lines of the table, each preceded by `indent`.
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

/// Text in lines of at most `width` characters, broken between words; `first` precedes the first line, `others` the other lines. A longer word
/// is not broken.
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

/// Text with lines of at most `width` characters, broken between words. The rest of a line is indented: below the text in a line of name and
/// text, otherwise slightly more than the line. Lines for which `stays` is true (commands to copy), lines with tabs, and longer words are not
/// broken.
#[must_use]
pub fn fitted(text: &str, width: usize, stays: impl Fn(&str) -> bool) -> String {
    let mut fitting = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let bare = line.strip_suffix('\n').unwrap_or(line);
        if bare.chars().count() <= width || bare.contains('\t') || stays(bare) {
            fitting.push_str(line);
            continue;
        }
        fitting.push_str(&broken(bare, width));
        fitting.push_str(&line[bare.len()..]);
    }
    fitting
}

/// Breaks one line into several; blanks within the lines are kept.
fn broken(line: &str, width: usize) -> String {
    let letters: Vec<char> = line.chars().collect();
    let own = letters.iter().take_while(|letter| **letter == ' ').count();
    // begin of the text in a line of name and text
    let name = letters[own..].windows(2).position(|pair| pair == [' ', ' ']).map(|end| own + end);
    let begin = name.map(|end| end + letters[end..].iter().take_while(|letter| **letter == ' ').count());
    let hanging = begin.filter(|begin| 3 * begin <= 2 * width).unwrap_or(own + 2);
    let (mut text, mut rest, mut indent) = (String::new(), &letters[..], 0);
    while indent + rest.len() > width {
        // the last blank within the width that has a word before it; a longer word extends to its end
        let first_word = rest.iter().position(|letter| *letter != ' ').unwrap_or(0);
        let room = width.saturating_sub(indent);
        let within = (first_word + 1..=room.min(rest.len() - 1)).rev().find(|at| rest[*at] == ' ');
        let Some(end) = within.or_else(|| (first_word + 1..rest.len()).find(|at| rest[*at] == ' ')) else { break };
        text.extend(std::iter::repeat_n(' ', indent));
        text.push_str(rest[..end].iter().collect::<String>().trim_end());
        text.push('\n');
        rest = &rest[end..];
        rest = &rest[rest.iter().take_while(|letter| **letter == ' ').count()..];
        indent = hanging;
        if rest.is_empty() {
            text.pop();
            return text;
        }
    }
    text.extend(std::iter::repeat_n(' ', indent));
    text.extend(rest);
    text
}

/// A count with its noun: "1 sample", "2 samples".
#[must_use]
pub fn counted(count: u64, one: &str) -> String {
    if count == 1 { format!("1 {one}") } else { format!("{count} {one}s") }
}

/// The verb for a count: "1 sample is", "2 samples are".
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
    fn lines_fit_and_lose_no_word() {
        let say = |text: &str, width| fitted(text, width, |line| line.contains("run this"));
        assert_eq!(say("aa bb cc dd\nee\n", 5), "aa bb\n  cc\n  dd\nee\n");
        assert_eq!(say("  aa bb cc", 7), "  aa bb\n    cc");
        assert_eq!(say("name  aa bb cc dd\n", 12), "name  aa bb\n      cc dd\n", "below its text");
        assert_eq!(say("run this long command\na\tb c d e f g h\n", 5), "run this long command\na\tb c d e f g h\n");
        assert_eq!(say("incomprehensible a b", 4), "incomprehensible\n  a\n  b");
        assert_eq!(say("aaa bbb      ", 5), "aaa\n  bbb");
        assert_eq!(say("", 5), "");
    }

    #[test]
    fn a_table_that_is_too_wide_becomes_lines() {
        let mut table = TextTable::new(&[("load", Align::Left), ("hyp1", Align::Right), ("", Align::Left)]);
        table.row(vec!["largest".into(), "12 N | 13 N".into(), "ok".into()]);
        table.row(vec!["end".into(), "7 N".into(), String::new()]);
        let whole = table.render(" ");
        assert_eq!((table.fitting(" ", None), table.fitting(" ", Some(40))), (whole.clone(), whole));
        let lines = " largest\n   hyp1: 12 N |\n       13 N\n   ok\n end\n   hyp1: 7 N\n";
        assert_eq!(table.fitting(" ", Some(15)), lines);
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
