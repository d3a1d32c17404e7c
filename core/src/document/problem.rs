//! All problems of one file, each with its place.

use std::fmt;
use std::ops::Range;

/// More are not shown: a file with this many is not a machine or study file.
const MOST: usize = 200;

/// One thing wrong with a file.
#[derive(Debug, Clone, PartialEq, Eq)]
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
        write!(f, "{}:{}:{}: ", self.file, self.line, self.column)?;
        match (&self.key[..], &self.value) {
            ("", _) => {}
            (key, None) => write!(f, "{key}: ")?,
            (key, Some(value)) => write!(f, "{key} = {value}: ")?,
        }
        f.write_str(&self.message)?;
        if let Some(allowed) = &self.allowed {
            write!(f, "; allowed: {allowed}")?;
        }
        if let Some(nearest) = &self.nearest {
            write!(f, "; did you mean `{nearest}`?")?;
        }
        Ok(())
    }
}

/// Every problem of one file, in the order of its text. Never empty when returned as an error.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problems {
    /// File as the user named it.
    pub file: String,
    /// Its whole text, so that the place can be shown.
    pub text: String,
    /// The problems, sorted by position.
    pub list: Vec<Problem>,
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.list.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{problem}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

/// Gathers problems while a file is checked.
#[derive(Debug, Clone)]
pub struct Collector {
    file: String,
    text: String,
    line_starts: Vec<usize>,
    list: Vec<Problem>,
    left_out: usize,
}

impl Collector {
    /// For one file.
    #[must_use]
    pub fn new(file: &str, text: &str) -> Self {
        let line_starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        Self { file: file.to_owned(), text: text.to_owned(), line_starts, list: Vec::new(), left_out: 0 }
    }

    /// Whether nothing was wrong so far.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Adds a problem at `span`; the returned reference takes value, allowed and nearest.
    pub fn add(&mut self, span: Range<usize>, key: impl Into<String>, message: impl Into<String>) -> &mut Problem {
        if self.list.len() == MOST {
            // The last one is overwritten below by the count in `finish`; it only has to be a place to write to.
            self.left_out += 1;
            self.list.pop();
        }
        let span = self.clamp(span);
        let (line, column) = self.place(span.start);
        self.list.push(Problem {
            file: self.file.clone(),
            line,
            column,
            span,
            key: key.into(),
            value: None,
            message: message.into(),
            allowed: None,
            nearest: None,
        });
        self.list.last_mut().expect("pushed just above")
    }

    /// The piece of text at `span` as it can be shown in one line.
    #[must_use]
    pub fn excerpt(&self, span: Range<usize>) -> String {
        let piece = &self.text[self.clamp(span)];
        let line = piece.lines().next().unwrap_or("");
        let mut shown: String = line.chars().take(60).collect();
        if shown.len() < piece.trim_end().len() {
            shown.push_str("...");
        }
        shown
    }

    /// `Ok` if nothing was wrong.
    ///
    /// # Errors
    /// All problems, sorted by position.
    pub fn finish(self) -> Result<(), Problems> {
        if self.list.is_empty() { Ok(()) } else { Err(self.into_problems()) }
    }

    /// The problems so far, sorted by position.
    #[must_use]
    pub fn into_problems(mut self) -> Problems {
        self.list.sort_by_key(|problem| problem.span.start);
        if self.left_out > 0 {
            let hidden = self.left_out + 1;
            let end = self.text.len();
            self.list.truncate(MOST - 1);
            self.left_out = 0;
            self.add(end..end, "", format!("{hidden} further problems are not shown"));
        }
        Problems { file: self.file, text: self.text, list: self.list }
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

    fn place(&self, at: usize) -> (usize, usize) {
        let line = self.line_starts.partition_point(|&start| start <= at);
        let start = self.line_starts[line - 1];
        (line, self.text[start..at].chars().count() + 1)
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
        assert_eq!(problems.list.len(), MOST);
        assert_eq!(problems.list[MOST - 1].message, "801 further problems are not shown");
    }
}
