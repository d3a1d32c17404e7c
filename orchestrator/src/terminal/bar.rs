//! One line of a terminal that is drawn again and again, and what is written and typed meanwhile.
//!
//! The cursor stays right behind the text. At the right margin, where a line that is filled with blanks would leave it, a terminal
//! begins a new line for whatever is typed, and what was drawn stays behind as a copy.

use std::io::{IsTerminal, Stderr, Write, stderr};

/// Columns that are left free: for a key or two, before the terminal begins a new line.
const ROOM: usize = 4;
/// Columns of a terminal that does not say.
const USUAL: usize = 80;
/// The bar has one part of so many of the columns, within the longest and the shortest bar.
const SHARE: usize = 6;
const LONGEST: usize = 30;
const SHORTEST: usize = 8;

/// The line.
#[derive(Debug)]
pub(super) struct Bar<W = Stderr> {
    out: W,
    drawn: String,
}

impl Bar {
    /// On standard error; `None` where that is no terminal whose cursor can be moved.
    pub fn on_terminal() -> Option<Self> {
        let is_plain = std::env::var_os("TERM").is_none_or(|term| term.is_empty() || term == "dumb");
        (stderr().is_terminal() && !is_plain).then(|| Self::on(stderr()))
    }

    /// Width of the terminal, which may change at any time.
    pub fn columns() -> usize {
        let told = rustix::termios::tcgetwinsize(stderr()).map(|size| usize::from(size.ws_col));
        told.ok().filter(|&columns| columns > 0).unwrap_or(USUAL)
    }
}

impl<W: Write> Bar<W> {
    /// On any writer.
    pub fn on(out: W) -> Self {
        Self { out, drawn: String::new() }
    }

    /// Draws the line again, if it is another one. Nobody who watches: the work goes on.
    pub fn draw(&mut self, text: String) {
        if text != self.drawn {
            let _ = write!(self.out, "\r{text}\x1b[K").and_then(|()| self.out.flush());
            self.drawn = text;
        }
    }

    /// Writes lines above it.
    pub fn note(&mut self, text: &str) {
        let _ = write!(self.out, "\r\x1b[K{text}\n{}", self.drawn).and_then(|()| self.out.flush());
    }

    /// Somebody has ended a line: the cursor is on the next one, where the text may have been drawn again, and goes back.
    pub fn typed(&mut self) {
        let _ = write!(self.out, "\x1b[A\r\x1b[J{}", self.drawn).and_then(|()| self.out.flush());
    }

    /// Takes the line away.
    pub fn clear(&mut self) {
        if !self.drawn.is_empty() {
            let _ = write!(self.out, "\r\x1b[K").and_then(|()| self.out.flush());
            self.drawn.clear();
        }
    }
}

/// A bar with the longest of `texts`, from long to short, that has room beside it; the last one is cut, if nothing else helps. The bar
/// is as long as the terminal's width says: whatever the text, it does not jump.
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
        // a terminal begins a new line where it is told to go one down
        screen(&std::str::from_utf8(bytes).expect("UTF-8").replace('\n', "\r\n"), usize::MAX)
    }

    #[test]
    fn keys_leave_no_copy_of_the_line() {
        let mut bar = Bar::on(Vec::new());
        bar.draw("### 1/9".into());
        bar.draw("### 2/9".into());
        // The terminal shows what is typed; the line may have been drawn again on the next one before that is known.
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
        // Of one length beside every text.
        for columns in [30, 60, 70, 80, 120] {
            let bar = |text: &str| fitting(0.4, &[text.to_owned()], columns).matches(['█', '░']).count();
            assert_eq!([bar("1/99"), bar("10/99, 5.0/s")], [(columns / SHARE).max(SHORTEST); 2], "{columns}");
        }
    }
}
