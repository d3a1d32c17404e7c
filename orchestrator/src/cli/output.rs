//! Standard output carries data, standard error everything else. Neither makes the program panic. Text from files, file names and other
//! programs is escaped so that it cannot control a terminal.

use super::error::CliError;
use bladeoff_answers::summary::{counted, fitted};
use bladeoff_system::call::program;
use bladeoff_text::document::{visible_json, visible_lines};
use std::borrow::Cow;
use std::io::{self, IsTerminal, Write};

/// Smallest terminal width for which lines are broken.
const NARROWEST: usize = 20;

/// Writes data to standard output.
///
/// # Errors
/// The output cannot be written, for example to a full disk; a closed reader (`| head`) is [`CliError::ReaderLeft`].
pub fn print(text: &str) -> Result<(), CliError> {
    write(&visible_lines(text))
}

/// Writes text to standard output; on a terminal in lines that fit it.
///
/// # Errors
/// As [`print`].
pub fn tell(text: &str) -> Result<(), CliError> {
    write(&visible_lines(&for_terminal(text, width())))
}

/// Width of the terminal at standard output; `None` if it is not a terminal, where lines are not broken.
#[must_use]
pub fn width() -> Option<usize> {
    columns(io::stdout())
}

/// Width of the terminal at standard error, likewise.
#[must_use]
pub fn width_of_errors() -> Option<usize> {
    columns(io::stderr())
}

fn columns(stream: impl IsTerminal + std::os::fd::AsFd) -> Option<usize> {
    let size = Some(stream).filter(IsTerminal::is_terminal).and_then(terminal_size::terminal_size_of);
    // a terminal of width 0 does not report its width; a few columns are too few to break lines
    size.map(|(terminal_size::Width(columns), _)| usize::from(columns)).filter(|columns| *columns >= NARROWEST)
}

/// Breaks lines between words at the width of the terminal; a command stays in one line, so that it can be copied.
pub fn for_terminal(text: &str, width: Option<usize>) -> Cow<'_, str> {
    match width {
        Some(width) => Cow::Owned(fitted(text, width, |line| line.contains(program()))),
        None => Cow::Borrowed(text),
    }
}

/// Replaces the screen of a terminal by a page; shows only its first lines if the terminal has fewer.
///
/// # Errors
/// As [`print`].
pub fn redraw(page: &str) -> Result<(), CliError> {
    let height =
        terminal_size::terminal_size_of(io::stdout()).map(|(_, terminal_size::Height(rows))| usize::from(rows));
    let page = fitting(&for_terminal(page, width()), height);
    let mut out = io::stdout().lock();
    // cursor to the first line, and clear the screen
    let written = write!(out, "\u{1b}[H\u{1b}[2J{}", visible_lines(&page));
    written.and_then(|()| out.flush()).map_err(CliError::stdout)
}

/// The lines that fit a terminal with this number of rows.
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

/// Writes a remark to standard error; write errors are ignored.
pub fn remark(text: &str) {
    let _ = writeln!(io::stderr(), "{}", visible_lines(&for_terminal(text, width_of_errors())));
}

/// Writes an error formatted by [`super::render::render`], which contains no control characters except colours.
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
