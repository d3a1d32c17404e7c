//! A points file as cells: separator, lines and decimal sign.
//!
//! ```text
//! first line `sep=;`                  the separator (spreadsheets write and read this line)
//! otherwise, outside quotes           in the header: `;` or `,` if only one of them occurs, a tab if neither does,
//!                                     blanks if none of these occurs and header and first row have several words
//! decimal comma                       allowed with the separators `;`, tab and blank; never together with decimal points in one file
//! quoted cells                        may have line breaks (RFC 4180)
//! header of Dakota                    begins with `%`, which is not part of the first name
//! ```
//! Ambiguous text is rejected with its line, never guessed.

use bladeoff_text::document::units::parse_any_quantity;
use bladeoff_text::document::{BYTE_ORDER_MARK, Collector};
use std::borrow::Cow;
use std::ops::Range;

/// Most line breaks of a quoted cell. A quote that is not closed within them is reported at its own line.
const MOST_BREAKS: usize = 16;

/// A points file and its format.
#[derive(Clone, Copy)]
pub(super) struct Csv<'a> {
    pub text: &'a str,
    /// Separator of cells; a blank means any number of blanks and tabs.
    pub separator: char,
    /// Position of the first line.
    start: usize,
}

impl<'a> Csv<'a> {
    /// Detects the format from the first lines; a problem and `None` if the header is ambiguous.
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
                problems.add(header, "", "the header contains `;` and `,`: which one separates the columns?").allowed =
                    Some("only one of the two, or a first line `sep=;` (or `sep=,`)".to_owned());
                return None;
            }
            (true, false, _) => ';',
            (false, false, true) => '\t',
            (false, false, false) if csv.is_blank_separated() => ' ',
            _ => ',',
        };
        Some(csv)
    }

    /// Whether header and first row, without any other separator, have several words. A single quantity is one cell.
    fn is_blank_separated(self) -> bool {
        let blanks = Self { separator: ' ', ..self };
        let mut lines = blanks.lines();
        let (Some(header), Some(row)) = (lines.next(), lines.next()) else { return false };
        let has_several = |line: Range<usize>| blanks.cells(line).nth(1).is_some();
        has_several(header) && has_several(row.clone()) && parse_any_quantity(&self.text[row]).is_err()
    }

    /// Byte range of each line with content; line breaks in a quoted cell do not end the line.
    pub fn lines(self) -> impl Iterator<Item = Range<usize>> + 'a {
        let Self { text, separator, start } = self;
        let mut next = Some(start);
        std::iter::from_fn(move || {
            loop {
                let start = next?;
                let end = self.line_end(start);
                next = (end < text.len()).then_some(end + 1);
                let content = text[start..end].trim();
                // Spreadsheets pad empty lines with separators.
                if !content.starts_with('#') && content.chars().any(|c| c != separator && !c.is_whitespace()) {
                    return Some(start..start + text[start..end].trim_end_matches('\r').len());
                }
            }
        })
    }

    /// End of the line that begins at `start`.
    fn line_end(self, start: usize) -> usize {
        let ends = self.text[start..].match_indices('\n').map(|(at, _)| start + at).chain([self.text.len()]);
        let mut ends = ends.take(1 + MOST_BREAKS);
        let first = ends.next().unwrap_or(self.text.len());
        let is_closed = |end: usize| {
            let line = &self.text[start..end];
            !line.contains('"')
                || line.trim_start().starts_with('#')
                || self.cells(start..end).all(|cell| cell.is_closed)
        };
        if is_closed(first) { first } else { ends.find(|end| is_closed(*end)).unwrap_or(first) }
    }

    /// Cells of the header. Dakota's header begins with `%`; a unit in brackets belongs to the name before it.
    pub fn header(self, line: Range<usize>) -> Vec<Cell<'a>> {
        let mut header: Vec<Cell<'a>> = Vec::new();
        for cell in self.cells(line) {
            match header.last_mut() {
                Some(before) if self.separator == ' ' && cell.text.starts_with('[') => {
                    before.text = format!("{} {}", before.text, cell.text).into();
                    before.span.end = cell.span.end;
                }
                _ => header.push(cell),
            }
        }
        if let Some(first) = header.first_mut()
            && let Some(name) = first.text.strip_prefix('%')
        {
            first.text = name.trim_start().to_owned().into();
        }
        header
    }

    /// Cells of a line, at least one. A cell that begins with a quote ends at the next single quote sign; "" inside means one quote.
    pub fn cells(self, line: Range<usize>) -> impl Iterator<Item = Cell<'a>> {
        let Self { text, separator, .. } = self;
        let mut next = Some(line.start);
        std::iter::from_fn(move || {
            let at = next?;
            let rest = &text[at..line.end];
            let is_blank = |c: char| c == ' ' || c == '\t' && separator != '\t';
            let separates = |c: char| c == separator || separator == ' ' && is_blank(c);
            let blank = rest.len() - rest.trim_start_matches(is_blank).len();
            let (cell, end) = if rest[blank..].starts_with('"') {
                let (cell, length) = quoted(&rest[blank + 1..]);
                let end = (at + blank + 1 + length).min(line.end);
                let after = &text[end..line.end];
                let to_next = after.find(separates).unwrap_or(after.len());
                let is_closed = cell.is_some();
                let sound = is_closed && after[..to_next].trim().is_empty();
                let text = cell.unwrap_or_default().into();
                (Cell { text, span: at + blank..end, sound, is_closed }, end + to_next)
            } else {
                let from = if separator == ' ' { blank } else { 0 };
                let length = rest[from..].find(separates).map_or(rest.len(), |length| from + length);
                let content = rest[..length].trim();
                let start = at + (rest[..length].len() - rest[..length].trim_start().len());
                let span = start..start + content.len();
                (Cell { text: content.into(), span, sound: true, is_closed: true }, at + length)
            };
            // The position after the separator: one byte, or all blanks up to the next cell.
            next = match separator {
                ' ' => Some(line.end - text[end..line.end].trim_start().len()).filter(|next| *next < line.end),
                _ => (end < line.end).then_some(end + 1),
            };
            Some(cell)
        })
    }

    /// The separator in words.
    pub fn separator_in_words(self) -> &'static str {
        match self.separator {
            ';' => "`;`",
            '\t' => "a tab",
            ' ' => "blanks",
            _ => "`,`",
        }
    }
}

/// Whether a letter occurs in a line outside quotes.
fn stands_in(line: &str, letter: char) -> bool {
    let mut inside = false;
    line.chars().any(|c| {
        inside ^= c == '"';
        c == letter && !inside
    })
}

/// A cell and its byte range in the text.
pub(super) struct Cell<'a> {
    pub text: Cow<'a, str>,
    pub span: Range<usize>,
    /// Whether a quoted cell ends with its quote.
    sound: bool,
    /// Whether a quoted cell has its closing quote.
    is_closed: bool,
}

impl Cell<'_> {
    pub fn refuse_unsound(&self, problems: &mut Collector<'_>) {
        if !self.sound {
            problems.add(self.span.clone(), "", "a quoted cell must end with a quote before the next cell");
        }
    }
}

/// Text of a quoted cell (`None`: no closing quote), and its length in bytes with the closing quote.
fn quoted(rest: &str) -> (Option<String>, usize) {
    let mut content = String::new();
    let mut characters = rest.char_indices().peekable();
    while let Some((at, character)) = characters.next() {
        if character == '\r' && characters.peek().is_some_and(|&(_, next)| next == '\n') {
            // A line break is read as one character on every system.
        } else if character != '"' {
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

/// Decimal sign of the file, as first seen in a cell.
#[derive(Default)]
pub(super) struct DecimalSign {
    /// First cell with a point, first cell with a comma.
    seen: [Option<Range<usize>>; 2],
}

impl DecimalSign {
    /// The cell with a decimal point in place of a decimal comma; `None`: the cell has both, which was reported. In a `free` cell, which may have any
    /// text (a date, a version), only a comma inside a single number is a decimal sign.
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
        // With commas as separators, a comma in a quoted cell is left to the reader of quantities, which reports it.
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

    /// Rejects points and commas in one file: the points may separate thousands.
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
            format!("a decimal {here} here, a decimal {before} in line {first}: is one of them a thousands separator?");
        problems.add(second, "", message).allowed =
            Some("one decimal sign in the whole file, no thousands separator".to_owned());
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
            ("a b\n1 2\n", ' '),
            ("a  b \n 1\t2 \n", ' '),
            ("%eval_id interface a\n1 NO_ID 0.4\n", ' '),
            ("wear rate\n0.3 mm\n", ','),
            ("wear rate\n0.3\n", ','),
            ("\"wear rate\"\n\"0,3 mm\"\n", ','),
            ("a b\n", ','),
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
        assert!(shown.starts_with("p.csv:2:1: the header contains `;` and `,`"), "{shown}");
    }

    #[test]
    fn a_quoted_cell_may_have_line_breaks() {
        let text = "a;b\r\n1;\"two\r\nlines; \"\"x\"\"\"\r\n# \"remark\n2;\"\n\n\"\n";
        let csv = of(text);
        let rows: Vec<Vec<String>> =
            csv.lines().map(|line| csv.cells(line).map(|cell| cell.text.into_owned()).collect()).collect();
        assert_eq!(rows, [["a", "b"], ["1", "two\nlines; \"x\""], ["2", "\n\n"]]);
        // A quote without its partner does not include later lines.
        for text in ["a,b\n1,\"x\n2,y\n".to_owned(), format!("a,b\n1,\"x\n{}9,\"\n", "2,y\n".repeat(MOST_BREAKS))] {
            let csv = of(&text);
            let unsound: Vec<bool> = csv.lines().map(|line| csv.cells(line).all(|cell| cell.sound)).collect();
            assert_eq!((unsound[1], unsound[2]), (false, true), "{text}");
        }
    }

    #[test]
    fn blanks_separate_and_a_header_of_dakota_begins_with_a_sign() {
        let text = "%eval_id interface gap [mm]  \"my note\" \n 1   NO_ID\t0.4 \"a b\" \n";
        let csv = of(text);
        let [header, row] = [0, 1].map(|line| csv.lines().nth(line).expect("two lines"));
        let names: Vec<String> = csv.header(header).into_iter().map(|cell| cell.text.into_owned()).collect();
        assert_eq!(names, ["eval_id", "interface", "gap [mm]", "my note"]);
        let cells: Vec<String> = csv.cells(row).map(|cell| cell.text.into_owned()).collect();
        assert_eq!(cells, ["1", "NO_ID", "0.4", "a b"]);
    }

    proptest! {
        #[test]
        fn any_text_gives_cells_inside_its_line(line in "[^\n]{0,60}|[ a\"\n\r;]{0,12}", separator in prop_oneof![Just(','), Just(';'), Just('\t'), Just(' ')]) {
            let csv = Csv { text: &line, separator, start: 0 };
            for cell in csv.cells(0..line.len()) {
                prop_assert!(cell.span.start <= cell.span.end && cell.span.end <= line.len());
                prop_assert!(line.is_char_boundary(cell.span.start) && line.is_char_boundary(cell.span.end));
            }
            let spans: Vec<Range<usize>> = csv.lines().collect();
            prop_assert!(spans.windows(2).all(|pair| pair[0].end < pair[1].start));
            prop_assert!(spans.iter().all(|span| span.end <= line.len() && csv.cells(span.clone()).count() > 0));
        }
    }
}
