//! The lines around a problem in a file: nothing else of the file is shown, so that large files and long lines do not fill the terminal.

use bladeoff_text::document::{BYTE_ORDER_MARK, Problem, pictured_lines, visible};
use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};
use std::ops::Range;

/// Largest number of lines shown of a span; of a longer span the first lines are shown.
const MOST_LINES: usize = 20;
/// Number of bytes of a line shown before and after the position of a problem.
const MOST_BEFORE: usize = 60;
const MOST_AFTER: usize = 180;

/// A part of a file with its position in the file.
#[derive(Debug)]
pub(super) struct Excerpt {
    name: String,
    text: String,
    /// Number of lines of the file before the part.
    lines_before: usize,
    /// Number of bytes before the problem in its line of the file, less those in `text`: bytes cut off at the beginning of the line, and differences in
    /// length where a hidden character is replaced by a sign.
    missing_before: isize,
    /// The span of the problem in `text`.
    pub span: Range<usize>,
}

impl Excerpt {
    /// The line of a problem in a file with this text, with one line before it and one after it.
    pub fn new(problem: &Problem, text: &str) -> Self {
        let mark = if text.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len_utf8() } else { 0 };
        let at = problem.span.start.max(mark);
        let mut end = problem.span.end.max(at);
        let begin = text[..at].rfind('\n').map_or(mark, |newline| newline + 1);
        if text[at..end].matches('\n').nth(MOST_LINES).is_some() {
            end = line_end(text, at);
        }
        let mut shown = String::new();
        let mut lines_before = problem.line - 1;
        if lines_before > 0 {
            let above = &text[..begin - 1];
            let above = &above[above.rfind('\n').map_or(0, |newline| newline + 1)..];
            let above = above.strip_suffix('\r').unwrap_or(above);
            shown.push_str(&pictured_lines(first(above.trim_start_matches(BYTE_ORDER_MARK), MOST_AFTER)));
            shown.push('\n');
            lines_before -= 1;
        }
        let from = if at - begin > MOST_BEFORE + MOST_AFTER { ceil(text, at - MOST_BEFORE) } else { begin };
        let before = pictured_lines(&text[from..at.min(shown_end(text, line_end(text, at)))]).len();
        let span_start = shown.len() + before;
        let mut span_end = span_start;
        // The lines of the span and the line after it, each shortened to the limits.
        let mut line = from;
        loop {
            let whole = line_end(text, line);
            let most = if line <= at { at - line + MOST_AFTER } else { MOST_AFTER };
            let kept = first(&text[line..shown_end(text, whole)], most);
            if end >= line {
                let inside = first(kept, end - line);
                span_end = (shown.len() + pictured_lines(inside).len()).max(span_start);
            }
            shown.push_str(&pictured_lines(kept));
            shown.push('\n');
            if line > end || whole + 1 >= text.len() {
                break;
            }
            line = whole + 1;
        }
        let span = span_start..span_end.min(shown.len());
        let missing_before = (at - begin) as isize - before as isize;
        Self { name: visible(&problem.file).into_owned(), text: shown, lines_before, missing_before, span }
    }
}

/// End of the shown part of a line: before its carriage return.
fn shown_end(text: &str, line_end: usize) -> usize {
    if text[..line_end].ends_with('\r') { line_end - 1 } else { line_end }
}

/// End of the line that contains this byte, without its line feed.
fn line_end(text: &str, at: usize) -> usize {
    text[at..].find('\n').map_or(text.len(), |newline| at + newline)
}

fn ceil(text: &str, mut at: usize) -> usize {
    while !text.is_char_boundary(at) {
        at += 1;
    }
    at
}

/// The first bytes of a text, at most `most`, up to a character boundary.
fn first(text: &str, most: usize) -> &str {
    let mut end = most.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    &text[..end]
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let found = self.text.read_span(span, before, after)?;
        // Without a line before it the part begins in the line of the problem itself.
        let column =
            if before == 0 { found.column().saturating_add_signed(self.missing_before) } else { found.column() };
        Ok(Box::new(MietteSpanContents::new_named(
            self.name.clone(),
            found.data(),
            *found.span(),
            self.lines_before + found.line(),
            column,
            found.line_count(),
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_text::document::Collector;
    use miette::NamedSource;
    use proptest::prelude::*;

    fn problem(text: &str, span: Range<usize>) -> Problem {
        let mut problems = Collector::new("f", text);
        problems.add(span, "k", "wrong");
        problems.into_problems().list.remove(0)
    }

    /// Line, column and text of a span with its surrounding lines.
    fn read(source: &dyn SourceCode, span: Range<usize>) -> (usize, usize, String) {
        let span = SourceSpan::from(span);
        let place = source.read_span(&span, 0, 0).expect("in the text");
        let lines = source.read_span(&span, 1, 1).expect("in the text");
        let text = String::from_utf8_lossy(lines.data()).trim_end().to_owned();
        (place.line() + 1, place.column() + 1, format!("{} {text}", lines.line() + 1))
    }

    proptest! {
        #[test]
        fn of_short_lines_it_is_what_the_whole_file_would_show(lines in prop::collection::vec("[a-z\u{b5}]{1,9}", 1..9), at: prop::sample::Index, length in 1..4_usize) {
            let text = lines.join("\n") + "\n";
            let places: Vec<usize> = text.match_indices(|c| c != '\n').map(|(at, _)| at).collect();
            let at = places[at.index(places.len())];
            let rest = text[at..].find('\n').expect("a line feed");
            let end = text[at..at + rest].char_indices().nth(length).map_or(at + rest, |(end, _)| at + end);
            let problem = problem(&text, at..end);
            let excerpt = Excerpt::new(&problem, &text);
            prop_assert_eq!(&excerpt.text[excerpt.span.clone()], &text[at..end]);
            prop_assert_eq!(read(&excerpt, excerpt.span.clone()), read(&NamedSource::new("f", text.clone()), at..end));
        }

        #[test]
        fn any_place_of_any_text_has_an_excerpt(text in "\u{feff}?[a\r\n\u{b5}\u{1b}\u{9b}]{0,600}", from in 0..700_usize, length in 0..700_usize) {
            let excerpt = Excerpt::new(&problem(&text, from..from + length), &text);
            prop_assert!(excerpt.text.get(excerpt.span.clone()).is_some());
            prop_assert!(!excerpt.text.contains(BYTE_ORDER_MARK));
            prop_assert!(excerpt.read_span(&SourceSpan::from(excerpt.span.clone()), 1, 1).is_ok());
        }
    }

    #[test]
    fn hidden_characters_are_signs_that_move_no_place() {
        let text = "a\u{1b}[31m\r\nb = \"\u{9b}2J\u{202e}x\" wrong\r\nlast\u{7f}\n";
        let at = text.find("wrong").expect("there");
        let problem = problem(text, at..at + 5);
        let excerpt = Excerpt::new(&problem, text);
        assert_eq!(&excerpt.text, "a␛[31m\nb = \"\u{fffd}2J\u{fffd}x\" wrong\nlast␡\n");
        assert_eq!(&excerpt.text[excerpt.span.clone()], "wrong");
        let column = at - text.find("b =").expect("there") + 1;
        assert_eq!(read(&excerpt, excerpt.span.clone()).1, column, "of the file");
    }

    #[test]
    fn a_long_line_is_cut_around_its_place() {
        let text = format!("first\n{}\nlast\n", "ab,".repeat(100_000));
        let problem = problem(&text, 150_006..150_008);
        let excerpt = Excerpt::new(&problem, &text);
        assert!(excerpt.text.len() < 300);
        let (line, column, _) = read(&excerpt, excerpt.span.clone());
        assert_eq!((line, column, &excerpt.text[excerpt.span.clone()]), (2, 150_001, "ab"));
    }
}
