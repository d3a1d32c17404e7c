//! All problems of one file, each with its place.

use super::{nearest, visible};
use std::fmt;
use std::ops::Range;

/// More are not shown: whoever mends these has the next ones in the next run.
pub const MOST_PROBLEMS: usize = 50;
/// Characters of a file that a message repeats.
const LONGEST_EXCERPT: usize = 60;
/// What some programs, among them Excel, put before a text; it is no part of it.
pub const BYTE_ORDER_MARK: char = '\u{feff}';

/// One thing wrong with a file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Problem {
    /// File as the user named it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Bytes of the text it is about.
    pub span: Range<usize>,
    /// Full dotted path of the key; empty for a syntax error.
    pub key: String,
    /// The value as it stands in the file.
    pub value: Option<String>,
    /// What is wrong.
    pub message: String,
    /// What would be right.
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
    /// Place, key, value and what is wrong, in one line: whatever the file holds, made visible.
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
    /// Its whole text, so that the place can be shown.
    pub text: String,
    /// The problems, sorted by position; at most [`MOST_PROBLEMS`].
    pub list: Vec<Problem>,
    /// Further ones.
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

/// Gathers problems while a file is checked. It costs nothing before the first of them.
///
/// # Limits
/// [`MOST_PROBLEMS`] are kept, further ones counted: `a_flood_of_problems_is_cut_and_counted`.
#[derive(Debug, Clone)]
pub struct Collector<'a> {
    file: &'a str,
    text: &'a str,
    list: Vec<Problem>,
    left_out: usize,
    /// What is written to when the list is full.
    ignored: Problem,
    /// How many of the first problems are syntax errors ([`super::parse_toml`]).
    syntax: usize,
}

/// How the message of a key that a table lacks begins.
pub const MISSING: &str = "missing";

impl<'a> Collector<'a> {
    /// For one file.
    #[must_use]
    pub fn new(file: &'a str, text: &'a str) -> Self {
        Self { file, text, list: Vec::new(), left_out: 0, ignored: Problem::default(), syntax: 0 }
    }

    /// Whether nothing was wrong so far.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Problems so far, those included that are only counted.
    #[must_use]
    pub fn count(&self) -> usize {
        self.list.len() + self.left_out
    }

    /// Whether further problems are only counted: nobody reads what is said of them, so it need not be found out.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.list.len() >= MOST_PROBLEMS
    }

    /// Adds a problem at `span`; the returned reference takes value, allowed and nearest. Line and column are those of the
    /// finished list.
    pub fn add(&mut self, span: Range<usize>, key: impl Into<String>, message: impl Into<String>) -> &mut Problem {
        if self.is_full() {
            self.left_out += 1;
            return &mut self.ignored;
        }
        let (span, file) = (self.clamp(span), self.file.to_owned());
        self.list.push(Problem { file, span, key: key.into(), message: message.into(), ..Problem::default() });
        self.list.last_mut().expect("pushed just above")
    }

    /// The candidate nearest to `given`, for [`Problem::nearest`]; none is searched for when nobody would see it.
    #[must_use]
    pub fn nearest<'n>(&self, given: &str, candidates: impl IntoIterator<Item = &'n str>) -> Option<String> {
        if self.is_full() { None } else { nearest(given, candidates).map(str::to_owned) }
    }

    /// The piece of text at `span` as it can be shown in one line.
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

    /// Bytes of a part of what a string says, which stands at `span`; all of it where escapes make it another length.
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

    /// `Ok` if nothing was wrong.
    ///
    /// # Errors
    /// All problems, sorted by position.
    pub fn finish(self) -> Result<(), Problems> {
        if self.list.is_empty() { Ok(()) } else { Err(self.into_problems()) }
    }

    /// All problems so far are syntax errors. Later ones that follow from them are dropped at the end: a key that is missing, and anything
    /// on a line with a syntax error or without a place.
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

    /// The problems so far, sorted by position.
    #[must_use]
    pub fn into_problems(mut self) -> Problems {
        if self.syntax > 0 {
            self.drop_what_follows_from_syntax();
        }
        self.list.sort_by_key(|problem| problem.span.start);
        // One pass over the text for all of them.
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

    /// A span that may be used on the text whatever the parser said.
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

/// A piece of input as a message may show it: at most `most` characters.
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
