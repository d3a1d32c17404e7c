//! Progress bar: a line of the terminal that is redrawn, with notes written and lines typed meanwhile.
//!
//! The cursor stays directly behind the text. At the right margin, where padding with blanks would leave it, a terminal begins a new line
//! for typed text, and a copy of the bar would remain.

use std::io::{IsTerminal, Stderr, Write, stderr};

/// Columns left free, so that a typed key or two do not begin a new line.
const ROOM: usize = 4;
/// Number of columns if the terminal does not report it.
const USUAL: usize = 80;
/// Divisor of the number of columns for the length of the bar, and its limits.
const SHARE: usize = 6;
const LONGEST: usize = 30;
const SHORTEST: usize = 8;

/// A progress bar.
#[derive(Debug)]
pub(super) struct Bar<W = Stderr> {
    out: W,
    drawn: String,
}

impl Bar {
    /// A bar on standard error; `None` if that is no terminal with cursor control.
    pub fn on_terminal() -> Option<Self> {
        let is_plain = std::env::var_os("TERM").is_none_or(|term| term.is_empty() || term == "dumb");
        (stderr().is_terminal() && !is_plain).then(|| Self::on(stderr()))
    }

    /// Present width of the terminal.
    pub fn columns() -> usize {
        let told = rustix::termios::tcgetwinsize(stderr()).map(|size| usize::from(size.ws_col));
        told.ok().filter(|&columns| columns > 0).unwrap_or(USUAL)
    }
}

impl<W: Write> Bar<W> {
    /// A bar on any writer.
    pub fn on(out: W) -> Self {
        Self { out, drawn: String::new() }
    }

    /// Redraws the line if the text has changed. Errors are ignored.
    pub fn draw(&mut self, text: String) {
        if text != self.drawn {
            let _ = write!(self.out, "\r{text}\x1b[K").and_then(|()| self.out.flush());
            self.drawn = text;
        }
    }

    /// Writes lines above the bar.
    pub fn note(&mut self, text: &str) {
        let _ = write!(self.out, "\r\x1b[K{text}\n{}", self.drawn).and_then(|()| self.out.flush());
    }

    /// The user has typed Enter: the cursor is on the next line, where the bar may have been redrawn, and moves back.
    pub fn typed(&mut self) {
        let _ = write!(self.out, "\x1b[A\r\x1b[J{}", self.drawn).and_then(|()| self.out.flush());
    }

    /// Removes the bar.
    pub fn clear(&mut self) {
        if !self.drawn.is_empty() {
            let _ = write!(self.out, "\r\x1b[K").and_then(|()| self.out.flush());
            self.drawn.clear();
        }
    }
}

/// A bar with the longest of `texts` (from long to short) that fits beside it; if none fits, the last one is cut. The length of the bar
/// depends on the width of the terminal only, so it does not jump.
pub(super) fn fitting(part: f64, texts: &[String], columns: usize) -> String {
    let room = columns.saturating_sub(ROOM);
    let width = (columns / SHARE).clamp(SHORTEST, LONGEST);
    let length = |text: &str| text.chars().count();
    match texts.iter().find(|text| width + 1 + length(text) <= room) {
        Some(text) => {
            let full = ((part * width as f64) as usize).min(width);
            format!("{}{} {text}", "█".repeat(full), "░".repeat(width - full))
        }
        None => texts.last().into_iter().flat_map(|text| text.chars()).take(room).collect(),
    }
}

#[cfg(test)]
#[path = "../../../tests/support/screen.rs"]
mod screen;

#[cfg(test)]
mod tests {
    use super::screen::screen;
    use super::*;

    fn shown(bytes: &[u8]) -> Vec<String> {
        // \n also returns the carriage on a terminal
        screen(&std::str::from_utf8(bytes).expect("UTF-8").replace('\n', "\r\n"), usize::MAX)
    }

    #[test]
    fn keys_leave_no_copy_of_the_line() {
        let mut bar = Bar::on(Vec::new());
        bar.draw("### 1/9".into());
        bar.draw("### 2/9".into());
        // The terminal echoes typed text; the bar may have been redrawn on the next line before Enter is processed.
        for drawn_meanwhile in [false, true] {
            bar.out.extend(b"s\r\n");
            if drawn_meanwhile {
                bar.draw("### 3/9".into());
            }
            bar.typed();
            bar.note("worker 1: idle\nworker 2: idle");
        }
        let worker = |number: u32| format!("worker {number}: idle");
        let expected = [worker(1), worker(2), worker(1), worker(2), "### 3/9".to_owned()];
        assert_eq!(shown(&bar.out), expected);
        bar.clear();
        bar.out.extend(b"done\n");
        assert_eq!(shown(&bar.out)[4..], ["done", ""]);
    }

    #[test]
    fn a_bar_fits_every_width() {
        let texts = ["a long text with many details".to_owned(), "a shorter text".to_owned(), "12/99".to_owned()];
        for columns in 0..120 {
            let line = fitting(0.5, &texts, columns);
            assert!(line.chars().count() <= columns.saturating_sub(ROOM), "{columns}: {line:?}");
        }
        assert!(fitting(0.5, &texts, 80).ends_with("details"));
        assert!(fitting(0.5, &texts, 35).ends_with("░ a shorter text"));
        assert_eq!(fitting(0.5, &texts, 9), "12/99");
        assert_eq!(fitting(0.0, &texts, 80).matches('█').count(), 0);
        assert_eq!(fitting(1.0, &texts, 80).matches('░').count(), 0);
        // the same length for every text
        for columns in [30, 60, 70, 80, 120] {
            let bar = |text: &str| fitting(0.4, &[text.to_owned()], columns).matches(['█', '░']).count();
            assert_eq!([bar("1/99"), bar("10/99, 5.0/s")], [(columns / SHARE).max(SHORTEST); 2], "{columns}");
        }
    }
}
