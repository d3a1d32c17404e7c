//! A points file as cells: what separates them, which lines say something, how its numbers are written.
//!
//! ```text
//! first line `sep=;`                  the separator (spreadsheets write and read it)
//! otherwise, outside quotes           of the header: `;` or `,` where only one of them stands there, a tab where neither does
//! decimal comma                       where `;` or a tab separates; never beside decimal points in one file
//! ```
//! What may be read in two ways is refused with its line, never guessed.

use bladeoff_model::document::{BYTE_ORDER_MARK, Collector};
use std::borrow::Cow;
use std::ops::Range;

/// A points file and how it is written.
#[derive(Clone, Copy)]
pub(super) struct Csv<'a> {
    pub text: &'a str,
    /// What separates its cells.
    pub separator: char,
    /// Where its lines begin.
    start: usize,
}

impl<'a> Csv<'a> {
    /// Looks at the first lines; a problem and `None` where the header may be read in two ways.
    pub fn new(text: &'a str, problems: &mut Collector<'_>) -> Option<Self> {
        let begin = if text.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len_utf8() } else { 0 };
        let mut csv = Self { text, separator: ',', start: begin };
        let first = text[begin..].split('\n').next().unwrap_or("");
        let named = first.trim_end_matches('\r').strip_prefix("sep=").and_then(|rest| {
            let mut letters = rest.chars();
            letters.next().filter(|letter| matches!(letter, ',' | ';' | '\t') && letters.next().is_none())
        });
        if let Some(separator) = named {
            csv.separator = separator;
            csv.start = (begin + first.len() + 1).min(text.len());
            return Some(csv);
        }
        let Some(header) = csv.lines().next() else { return Some(csv) };
        let line = &text[header.clone()];
        csv.separator = match (stands_in(line, ';'), stands_in(line, ','), stands_in(line, '\t')) {
            (true, true, _) => {
                problems.add(header, "", "the header has `;` and `,`: which of them separates the columns?").allowed =
                    Some("only one of them, or a first line `sep=;` (or `sep=,`)".to_owned());
                return None;
            }
            (true, false, _) => ';',
            (false, false, true) => '\t',
            _ => ',',
        };
        Some(csv)
    }

    /// The bytes of each line that says something.
    pub fn lines(self) -> impl Iterator<Item = Range<usize>> + 'a {
        let mut start = self.start;
        let separator = self.separator;
        self.text[start..].split('\n').filter_map(move |line| {
            let span = start..start + line.trim_end_matches('\r').len();
            start += line.len() + 1;
            let content = line.trim();
            // A spreadsheet pads empty lines with separators.
            let says = !content.starts_with('#') && content.chars().any(|c| c != separator && !c.is_whitespace());
            says.then_some(span)
        })
    }

    /// The cells of a line, at least one. A cell that begins with a quote ends at the next lone quote; "" inside stands for one.
    pub fn cells(self, line: Range<usize>) -> impl Iterator<Item = Cell<'a>> {
        let Self { text, separator, .. } = self;
        let mut next = Some(line.start);
        std::iter::from_fn(move || {
            let at = next?;
            let rest = &text[at..line.end];
            let is_blank = |c: char| c == ' ' || c == '\t' && separator != '\t';
            let blank = rest.len() - rest.trim_start_matches(is_blank).len();
            let (cell, end) = if rest[blank..].starts_with('"') {
                let (cell, length) = quoted(&rest[blank + 1..]);
                let end = (at + blank + 1 + length).min(line.end);
                let after = &text[end..line.end];
                let to_next = after.find(separator).unwrap_or(after.len());
                let sound = cell.is_some() && after[..to_next].trim().is_empty();
                (Cell { text: cell.unwrap_or_default().into(), span: at + blank..end, sound }, end + to_next)
            } else {
                let length = rest.find(separator).unwrap_or(rest.len());
                let content = rest[..length].trim();
                let start = at + (rest[..length].len() - rest[..length].trim_start().len());
                (Cell { text: content.into(), span: start..start + content.len(), sound: true }, at + length)
            };
            // After the separator, which is one byte.
            next = (end < line.end).then_some(end + 1);
            Some(cell)
        })
    }

    /// The separator in words.
    pub fn separator_in_words(self) -> &'static str {
        match self.separator {
            ';' => "`;`",
            '\t' => "a tab",
            _ => "`,`",
        }
    }
}

/// Whether a letter stands in a line outside quotes.
fn stands_in(line: &str, letter: char) -> bool {
    let mut inside = false;
    line.chars().any(|c| {
        inside ^= c == '"';
        c == letter && !inside
    })
}

/// A cell and its bytes in the text.
pub(super) struct Cell<'a> {
    pub text: Cow<'a, str>,
    pub span: Range<usize>,
    /// A quoted one ends with its quote.
    sound: bool,
}

impl Cell<'_> {
    pub fn refuse_unsound(&self, problems: &mut Collector<'_>) {
        if !self.sound {
            problems.add(self.span.clone(), "", "a quoted cell must end with a quote before the next cell");
        }
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

/// Which decimal sign the file writes, once a cell has shown it.
#[derive(Default)]
pub(super) struct DecimalSign {
    /// First cell with a point, first cell with a comma.
    seen: [Option<Range<usize>>; 2],
}

impl DecimalSign {
    /// The cell with a decimal point where it has a decimal comma; `None`: it has both, which was reported. Of a `free` cell,
    /// which may hold any text (a date, a version), only a comma inside one number is a decimal sign.
    pub fn read<'c>(
        &mut self,
        csv: Csv<'_>,
        cell: &'c Cell<'_>,
        free: bool,
        problems: &mut Collector<'_>,
    ) -> Option<Cow<'c, str>> {
        let text: &str = &cell.text;
        let end = text.find(|c: char| !(c.is_ascii_digit() || "+-.,".contains(c))).unwrap_or(text.len());
        let (number, rest) = text.split_at(end);
        let (points, commas) = (number.matches('.').count(), number.matches(',').count());
        // With commas between the cells a comma in a (quoted) cell is left to the reader of quantities, who names it.
        let plain = csv.separator == ',' || points + commas == 0 || !number.contains(|c: char| c.is_ascii_digit());
        if plain || free && !(rest.is_empty() && commas == 1 && points == 0) {
            return Some(Cow::Borrowed(text));
        }
        if commas > 1 || commas == 1 && points > 0 {
            let message = format!("`{number}` has more than one decimal sign");
            problems.add(cell.span.clone(), "", message).allowed =
                Some("1234,5 or 1234.5, thousands unmarked".to_owned());
            return None;
        }
        self.seen[commas].get_or_insert_with(|| cell.span.clone());
        Some(if commas == 0 { Cow::Borrowed(text) } else { Cow::Owned(format!("{}{rest}", number.replace(',', "."))) })
    }

    /// Refuses points and commas in one file: a point may then mark thousands.
    pub fn refuse_both(self, csv: Csv<'_>, problems: &mut Collector<'_>) {
        let [Some(point), Some(comma)] = self.seen else { return };
        let line = |span: &Range<usize>| 1 + csv.text[..span.start].matches('\n').count();
        let (first, second, signs) = if point.start < comma.start {
            (line(&point), comma, ["point", "comma"])
        } else {
            (line(&comma), point, ["comma", "point"])
        };
        let [before, here] = signs;
        let message =
            format!("a decimal {here} here, a decimal {before} in line {first}: does one of them mark thousands?");
        problems.add(second, "", message).allowed =
            Some("one decimal sign in the whole file, thousands unmarked".to_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(text: &str) -> Csv<'_> {
        let mut problems = Collector::new("p.csv", text);
        let csv = Csv::new(text, &mut problems).expect("one way to read it");
        assert!(problems.is_empty());
        csv
    }

    fn texts(line: &str) -> Vec<String> {
        let csv = Csv { text: line, separator: ',', start: 0 };
        let cells = csv.cells(0..line.len()).inspect(|cell| assert!(cell.sound, "{line:?}"));
        cells.map(|cell| cell.text.into_owned()).collect()
    }

    #[test]
    fn cells_are_trimmed_and_may_be_quoted() {
        assert_eq!(texts("0.5 mm, 0.2 ,hyp1"), ["0.5 mm", "0.2", "hyp1"]);
        assert_eq!(texts("\"a,b\" , \"say \"\"x\"\"\",,"), ["a,b", "say \"x\"", "", ""]);
    }

    #[test]
    fn a_quoted_cell_without_its_end_is_unsound() {
        let sound = |line: &str| {
            let csv = Csv { text: line, separator: ',', start: 0 };
            csv.cells(0..line.len()).map(|cell| cell.sound).collect::<Vec<_>>()
        };
        assert_eq!(sound("\"a"), [false]);
        assert_eq!(sound("\"a\"b,c"), [false, true]);
        assert_eq!(sound("\"a\" ,c"), [true, true]);
    }

    #[test]
    fn blank_lines_and_remarks_are_skipped() {
        let text = "# remark\na,b\r\n\n,,\n1,2\n";
        let lines = |text: &str| of(text).lines().map(|span| text[span].to_owned()).collect::<Vec<_>>();
        assert_eq!(lines(text), ["a,b", "1,2"]);
        assert_eq!(lines(&format!("\u{feff}{text}")), ["a,b", "1,2"]);
    }

    #[test]
    fn the_header_says_what_separates() {
        for (text, separator) in [
            ("a,b\n1,2\n", ','),
            ("a;b\n1,5;2\n", ';'),
            ("a\tb\n1,5\t2\n", '\t'),
            ("a,\tb\n1,2\n", ','),
            ("\"a;x\",b\n", ','),
            ("a\n1\n", ','),
            ("sep=;\r\na;b\r\n", ';'),
            ("sep=\t\na,x\tb\n", '\t'),
            ("", ','),
        ] {
            assert_eq!(of(text).separator, separator, "{text:?}");
        }
        assert_eq!(of("sep=;\r\na;b\r\n").lines().count(), 1, "the line of the separator is no header");
        let text = "# a remark\na;b,c\n";
        let mut problems = Collector::new("p.csv", text);
        assert!(Csv::new(text, &mut problems).is_none());
        let shown = problems.into_problems().to_string();
        assert!(shown.starts_with("p.csv:2:1: the header has `;` and `,`"), "{shown}");
    }

    proptest! {
        #[test]
        fn any_text_gives_cells_inside_its_line(line in "[^\n]{0,60}", separator in prop_oneof![Just(','), Just(';'), Just('\t')]) {
            let csv = Csv { text: &line, separator, start: 0 };
            for cell in csv.cells(0..line.len()) {
                prop_assert!(cell.span.start <= cell.span.end && cell.span.end <= line.len());
                prop_assert!(line.is_char_boundary(cell.span.start) && line.is_char_boundary(cell.span.end));
            }
        }
    }
}
