//! Standard output is data, standard error everything else. Neither ever makes the program panic, and neither passes on what
//! would act on a terminal: whatever came from files, their names and other programs is made visible here.

use super::error::CliError;
use bladeoff_answers::summary::{counted, fitted};
use bladeoff_system::call::program;
use bladeoff_text::document::{visible_json, visible_lines};
use std::borrow::Cow;
use std::io::{self, IsTerminal, Write};

/// Fewest columns of a terminal that lines are broken for.
const NARROWEST: usize = 20;

/// Writes data to standard output.
///
/// # Errors
/// The reader's disk is full or the like; a reader that went away (`| head`) is [`CliError::ReaderLeft`].
pub fn print(text: &str) -> Result<(), CliError> {
    write(&visible_lines(text))
}

/// Writes what a person reads to standard output: on a terminal in lines that fit it.
///
/// # Errors
/// As [`print`].
pub fn tell(text: &str) -> Result<(), CliError> {
    write(&visible_lines(&for_terminal(text, width())))
}

/// Columns of the terminal that standard output is; `None` where it is none: whoever reads from a pipe wants lines, however long.
#[must_use]
pub fn width() -> Option<usize> {
    columns(io::stdout())
}

/// The same of standard error.
#[must_use]
pub fn width_of_errors() -> Option<usize> {
    columns(io::stderr())
}

fn columns(stream: impl IsTerminal + std::os::fd::AsFd) -> Option<usize> {
    let size = Some(stream).filter(IsTerminal::is_terminal).and_then(terminal_size::terminal_size_of);
    // A terminal of no width does not know it; in one of a few letters nothing can be done.
    size.map(|(terminal_size::Width(columns), _)| usize::from(columns)).filter(|columns| *columns >= NARROWEST)
}

/// Lines that are broken between words where they are longer than a terminal is wide; a command stays a line, so that it can be
/// pasted.
pub fn for_terminal(text: &str, width: Option<usize>) -> Cow<'_, str> {
    match width {
        Some(width) => Cow::Owned(fitted(text, width, |line| line.contains(program()))),
        None => Cow::Borrowed(text),
    }
}

/// Replaces what a terminal shows by a page: its first lines where the terminal has fewer.
///
/// # Errors
/// As [`print`].
pub fn redraw(page: &str) -> Result<(), CliError> {
    let height =
        terminal_size::terminal_size_of(io::stdout()).map(|(_, terminal_size::Height(rows))| usize::from(rows));
    let page = fitting(&for_terminal(page, width()), height);
    let mut out = io::stdout().lock();
    // to the first line, and everything erased
    let written = write!(out, "\u{1b}[H\u{1b}[2J{}", visible_lines(&page));
    written.and_then(|()| out.flush()).map_err(CliError::stdout)
}

/// The lines that fit a terminal of so many rows.
fn fitting(text: &str, height: Option<usize>) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let Some(room) = height.map(|height| height.saturating_sub(2)).filter(|room| *room > 0 && *room < lines.len())
    else {
        return text.to_owned();
    };
    let more = counted((lines.len() - room) as u64, "more line");
    format!("{}\n... {more}; a higher window shows them\n", lines[..room].join("\n"))
}

/// Writes JSON to standard output.
///
/// # Errors
/// As [`print`].
pub fn print_json(json: &str) -> Result<(), CliError> {
    write(&visible_json(json))
}

fn write(text: &str) -> Result<(), CliError> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(CliError::stdout)
}

/// Writes a remark to standard error; if nobody can read it, that is no reason to stop.
pub fn remark(text: &str) {
    let _ = writeln!(io::stderr(), "{}", visible_lines(&for_terminal(text, width_of_errors())));
}

/// The same for an error as [`super::render::render`] made it, which has colours of its own and nothing else.
pub fn rendered(text: &str) {
    let _ = writeln!(io::stderr(), "{}", text.trim_end());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_cut_to_the_window() {
        let text = "1\n2\n3\n4\n5\n";
        assert_eq!(fitting(text, Some(40)), text);
        assert_eq!(fitting(text, None), text);
        assert_eq!(fitting(text, Some(5)), "1\n2\n3\n... 2 more lines; a higher window shows them\n");
    }
}
