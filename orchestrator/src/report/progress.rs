//! Progress of a study on standard error: a bar on a terminal, plain lines elsewhere.

use super::eta::Eta;
use super::tally::Tally;
use super::text::duration;
use bladeoff_core::document::visible_lines;
use bladeoff_core::outcome::Status;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

/// Least time between two plain lines; then one is due after this part of the study or this time.
const LINE_EVERY: Duration = Duration::from_secs(2);
const LINES: u64 = 20;
const LINE_AT_LEAST_EVERY: Duration = Duration::from_secs(60);

/// Shows how far a study is.
#[derive(Debug)]
pub struct Progress {
    total: u64,
    /// Finished before this run: they say nothing about its pace.
    before: u64,
    started: Instant,
    display: Display,
}

#[derive(Debug)]
enum Display {
    Bar(ProgressBar),
    Lines { last: Instant, shown: u64 },
}

impl Progress {
    /// Starts the display of a study of `total` samples, of which some were finished before.
    #[must_use]
    pub fn start(total: u64, before: u64, now: Instant) -> Self {
        let display = if std::io::stderr().is_terminal() {
            let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
            // A fixed template; should it ever be wrong, the library's own bar is good enough.
            if let Ok(style) = ProgressStyle::with_template("{bar:30} {msg}") {
                bar.set_style(style);
            }
            Display::Bar(bar)
        } else {
            Display::Lines { last: now, shown: before }
        };
        Self { total, before, started: now, display }
    }

    /// Shows the present counts, if it is time to; `stale`: workers not heard of for a while.
    pub fn update(&mut self, tally: &Tally, eta: Option<Eta>, stale: usize, now: Instant) {
        let done = tally.done();
        let mut message = message(tally, self.before, self.total, now.duration_since(self.started), eta);
        if stale > 0 {
            message.push_str(&format!("; {stale} workers silent"));
        }
        match &mut self.display {
            Display::Bar(bar) => {
                bar.set_position(done);
                bar.set_message(message);
            }
            Display::Lines { last, shown } => {
                let since = now.duration_since(*last);
                let due = since >= LINE_AT_LEAST_EVERY
                    || since >= LINE_EVERY && done.saturating_sub(*shown) * LINES >= self.total;
                if due && done < self.total {
                    (*last, *shown) = (now, done);
                    // Nobody reads: the study goes on.
                    let _ = writeln!(std::io::stderr(), "{message}");
                }
            }
        }
    }

    /// Writes lines between the progress.
    pub fn note(&self, text: &str) {
        let text = visible_lines(text);
        match &self.display {
            Display::Bar(bar) => bar.println(text),
            Display::Lines { .. } => {
                let _ = writeln!(std::io::stderr(), "{text}");
            }
        }
    }

    /// Ends the display with a last line.
    pub fn finish(&self, tally: &Tally, now: Instant) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
        let text = message(tally, self.before, self.total, now.duration_since(self.started), None);
        let _ = writeln!(std::io::stderr(), "{text}");
    }
}

fn message(tally: &Tally, before: u64, total: u64, elapsed: Duration, eta: Option<Eta>) -> String {
    let done = tally.done();
    let seconds = elapsed.as_secs_f64();
    let mut text = format!("{done}/{total}");
    let new = done.saturating_sub(before);
    if new > 0 && seconds > 0.0 {
        let rate = new as f64 / seconds;
        text.push_str(&if rate >= 1.0 { format!(", {rate:.1}/s") } else { format!(", {:.1}/min", rate * 60.0) });
        if done == total {
            text.push_str(&format!(", {}", duration(elapsed)));
        }
        // Before the range is known, nothing is better than a wrong number.
        if let Some(eta) = eta {
            text.push_str(&format!(", {}", eta.text()));
        }
    }
    text.push_str(&format!(
        "; invalid {}, failed {}",
        tally.words(&[Status::Invalid]),
        tally.words(&[Status::Failed, Status::Quarantined])
    ));
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_core::outcome::{Cause, CauseSet, EndCause, Outcome};

    #[test]
    fn the_line_has_rate_remaining_time_and_failures_by_cause() {
        let mut tally = Tally::default();
        for cause in [None, None, Some(Cause::Diverged)] {
            let status = if cause.is_some() { Status::Failed } else { Status::Ok };
            let causes = CauseSet::default();
            tally.add(&Outcome { status, cause, causes, end_cause: EndCause::EndTime, values: Vec::new() });
        }
        let seconds = Duration::from_secs;
        let line = |low, high| message(&tally, 0, 9, seconds(2), Some(Eta { low: seconds(low), high: seconds(high) }));
        assert_eq!(line(4, 4), "3/9, 1.5/s, 4.0 s left; invalid 0, failed 1 (1 diverged)");
        assert_eq!(line(50, 80), "3/9, 1.5/s, 50 s to 1 min 20 s left; invalid 0, failed 1 (1 diverged)");
        assert_eq!(message(&tally, 0, 3, seconds(2), None), "3/3, 1.5/s, 2.0 s; invalid 0, failed 1 (1 diverged)");
        assert_eq!(message(&Tally::default(), 0, 9, Duration::ZERO, None), "0/9; invalid 0, failed 0");
        let line = message(&tally, 2, 9, seconds(2), None);
        assert!(line.starts_with("3/9, 30.0/min"), "two were there before: {line}");
    }
}
