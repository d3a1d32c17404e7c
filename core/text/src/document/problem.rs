//! All problems of one file, with their positions.

use super::{nearest, visible};
use std::fmt;
use std::ops::Range;

/// Most problems that are shown. After these are corrected, the next run shows the others.
pub const MOST_PROBLEMS: usize = 50;
/// Most characters of the file that a message quotes.
const LONGEST_EXCERPT: usize = 60;
/// The mark that some programs, among them Excel, write before a text; it does not belong to the text.
pub const BYTE_ORDER_MARK: char = '\u{feff}';

/// One problem of a file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Problem {
    /// File as the user named it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Byte range in the text of the file.
    pub span: Range<usize>,
    /// Full dotted path of the key; empty for a syntax error.
    pub key: String,
    /// The value as written in the file.
    pub value: Option<String>,
    /// Description of the problem.
    pub message: String,
    /// Allowed values.
    pub allowed: Option<String>,
    /// The name most likely meant.
    pub nearest: Option<String>,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.headline())?;
        if let Some(allowed) = &self.allowed {
            write!(f, "; allowed: {}", visible(allowed))?;
        }
        if let Some(nearest) = &self.nearest {
            write!(f, "; did you mean `{}`?", visible(nearest))?;
        }
        Ok(())
    }
}

impl Problem {
    /// Position, key, value and description in one line, with hidden characters escaped.
    #[must_use]
    pub fn headline(&self) -> String {
        let Self { file, line, column, key, value, message, .. } = self;
        let what = match (key.as_str(), value) {
            ("", _) => String::new(),
            (key, None) => format!("{}: ", visible(key)),
            (key, Some(value)) => format!("{} = {}: ", visible(key), visible(value)),
        };
        format!("{}:{line}:{column}: {what}{}", visible(file), visible(message))
    }
}

/// Every problem of one file, in the order of its text. Never empty when returned as an error.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problems {
    /// File as the user named it.
    pub file: String,
    /// Whole text of the file, for excerpts.
    pub text: String,
    /// The problems, sorted by position; at most [`MOST_PROBLEMS`].
    pub list: Vec<Problem>,
    /// Number of further problems that are not listed.
    pub left_out: usize,
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.list.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{problem}")?;
        }
        if self.left_out > 0 {
            write!(f, "\nand {} more", self.left_out)?;
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

/// Collects problems while a file is checked. Nothing is allocated before the first problem.
///
/// # Limits
/// Keeps [`MOST_PROBLEMS`] problems and counts further ones: `a_flood_of_problems_is_cut_and_counted`.
#[derive(Debug, Clone)]
pub struct Collector<'a> {
    file: &'a str,
    text: &'a str,
    list: Vec<Problem>,
    left_out: usize,
    /// Receives the details of problems that are only counted.
    ignored: Problem,
    /// Number of problems at the start of the list that are syntax errors ([`super::parse_toml`]).
    syntax: usize,
}

/// Start of the message about a required key that a table lacks.
pub const MISSING: &str = "missing";

impl<'a> Collector<'a> {
    /// An empty collector for one file.
    #[must_use]
    pub fn new(file: &'a str, text: &'a str) -> Self {
        Self { file, text, list: Vec::new(), left_out: 0, ignored: Problem::default(), syntax: 0 }
    }

    /// Whether no problem was found so far.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Number of problems so far, including those that are only counted.
    #[must_use]
    pub fn count(&self) -> usize {
        self.list.len() + self.left_out
    }

    /// Whether further problems are only counted, so that their details need not be computed.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.list.len() >= MOST_PROBLEMS
    }

    /// Adds a problem at `span`. The returned reference is for setting value, allowed and nearest. Line and column are set when the list is
    /// finished.
    pub fn add(&mut self, span: Range<usize>, key: impl Into<String>, message: impl Into<String>) -> &mut Problem {
        if self.is_full() {
            self.left_out += 1;
            return &mut self.ignored;
        }
        let (span, file) = (self.clamp(span), self.file.to_owned());
        self.list.push(Problem { file, span, key: key.into(), message: message.into(), ..Problem::default() });
        self.list.last_mut().expect("pushed just above")
    }

    /// The candidate nearest to `given`, for [`Problem::nearest`]; `None` without a search when further problems are only counted.
    #[must_use]
    pub fn nearest<'n>(&self, given: &str, candidates: impl IntoIterator<Item = &'n str>) -> Option<String> {
        if self.is_full() { None } else { nearest(given, candidates).map(str::to_owned) }
    }

    /// The text at `span` in a form that fits in one line.
    #[must_use]
    pub fn excerpt(&self, span: Range<usize>) -> String {
        let piece = &self.text[self.clamp(span)];
        let line = piece.lines().next().unwrap_or("");
        let mut shown = cut(line, LONGEST_EXCERPT);
        if shown.len() == line.len() && line.len() < piece.trim_end().len() {
            shown.push_str("...");
        }
        shown
    }

    /// Byte range in the file of a part of a string value that is at `span`; all of `span` if escapes change its length.
    #[must_use]
    pub fn inside(&self, span: &Range<usize>, said: &str, part: &Range<usize>) -> Range<usize> {
        let written = self.text.get(span.clone()).unwrap_or("");
        let is_plain = written.len() == said.len() + 2 && written.get(1..=said.len()) == Some(said);
        if is_plain && part.end <= said.len() {
            span.start + 1 + part.start..span.start + 1 + part.end
        } else {
            span.clone()
        }
    }

    /// `Ok` if there are no problems.
    ///
    /// # Errors
    /// All problems, sorted by position.
    pub fn finish(self) -> Result<(), Problems> {
        if self.list.is_empty() { Ok(()) } else { Err(self.into_problems()) }
    }

    /// Marks all problems so far as syntax errors. Later problems that follow from them are discarded at the end: missing keys, and problems on
    /// a line with a syntax error or without a position.
    pub(super) fn keep_apart_from_syntax(&mut self) {
        self.syntax = self.list.len();
    }

    fn drop_what_follows_from_syntax(&mut self) {
        let line = |at: usize| self.text[..at].rfind('\n').map_or(0, |newline| newline + 1);
        let mut rest = self.list.split_off(self.syntax);
        let broken: Vec<usize> = self.list.iter().map(|problem| line(problem.span.start)).collect();
        rest.retain(|problem| {
            !problem.message.starts_with(MISSING) && problem.span.end > 0 && !broken.contains(&line(problem.span.start))
        });
        self.list.append(&mut rest);
    }

    /// All problems so far, sorted by position.
    #[must_use]
    pub fn into_problems(mut self) -> Problems {
        if self.syntax > 0 {
            self.drop_what_follows_from_syntax();
        }
        self.list.sort_by_key(|problem| problem.span.start);
        // One pass over the text for all problems.
        let (mut line, mut start, mut seen) = (1, if self.text.starts_with(BYTE_ORDER_MARK) { 3 } else { 0 }, 0);
        for problem in &mut self.list {
            let at = problem.span.start;
            for (newline, _) in self.text[seen..at].match_indices('\n') {
                (line, start) = (line + 1, seen + newline + 1);
            }
            seen = at;
            (problem.line, problem.column) = (line, self.text[start.min(at)..at].chars().count() + 1);
        }
        Problems { file: self.file.to_owned(), text: self.text.to_owned(), list: self.list, left_out: self.left_out }
    }

    /// A span limited to valid positions of the text, whatever the parser returned.
    fn clamp(&self, span: Range<usize>) -> Range<usize> {
        let floor = |mut at: usize| {
            at = at.min(self.text.len());
            while !self.text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let start = floor(span.start);
        start..floor(span.end).max(start)
    }
}

/// An excerpt of the input for a message: at most `most` characters.
#[must_use]
pub fn cut(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn problems_are_sorted_and_know_line_and_column() {
        let mut all = Collector::new("m.toml", "a = 1\nµb = 2\n");
        all.add(8..10, "b", "second").value = Some("2".into());
        let first = all.add(0..1, "a", "first");
        first.allowed = Some("> 1".into());
        first.nearest = Some("c".into());
        let problems = all.finish().unwrap_err();
        assert_eq!((problems.list[1].line, problems.list[1].column), (2, 2));
        assert_eq!(
            problems.to_string(),
            "m.toml:1:1: a: first; allowed: > 1; did you mean `c`?\nm.toml:2:2: b = 2: second"
        );
    }

    #[test]
    fn spans_outside_the_text_and_inside_a_character_are_safe() {
        let mut all = Collector::new("m", "µ");
        all.add(1..900, "", "x");
        assert_eq!(all.excerpt(1..900), "µ");
        assert_eq!(all.finish().unwrap_err().list[0].span, 0..2);
    }

    #[test]
    fn a_flood_of_problems_is_cut_and_counted() {
        let mut all = Collector::new("m", "text");
        for _ in 0..1000 {
            all.add(0..1, "k", "wrong");
        }
        let problems = all.finish().unwrap_err();
        assert_eq!((problems.list.len(), problems.left_out), (MOST_PROBLEMS, 950));
        assert!(problems.to_string().ends_with("\nand 950 more"));
    }

    #[test]
    fn a_byte_order_mark_is_no_column_and_a_long_piece_is_cut() {
        let text = "\u{feff}ab = 1\n";
        let mut all = Collector::new("m", text);
        all.add(3..5, "ab", "x");
        all.add(4..5, "b", "y");
        let places: Vec<_> =
            all.finish().unwrap_err().list.iter().map(|problem| (problem.line, problem.column)).collect();
        assert_eq!(places, [(1, 1), (1, 2)]);
        assert_eq!(cut("µµµ", 3), "µµµ");
        assert_eq!(cut("µµµµ", 3), "µµµ...");
        let long = "x".repeat(61);
        assert_eq!(Collector::new("m", &long).excerpt(0..61), format!("{}...", "x".repeat(60)));
        assert_eq!(Collector::new("m", "a\nb").excerpt(0..3), "a...");
    }
}
