//! Progress of a study on standard error: a bar on a terminal, plain lines elsewhere.

use super::bar::{Bar, fitting};
use super::eta::Eta;
use super::tally::Tally;
use bladeoff_answers::summary::{counted, duration};
use bladeoff_model::outcome::Status;
use bladeoff_text::document::visible_lines;
use std::io::Write;
use std::time::{Duration, Instant};

/// Smallest time between two plain lines; a line is due after 1/LINES of the study or after the longest time.
const LINE_EVERY: Duration = Duration::from_secs(2);
const LINES: u64 = 20;
const LINE_AT_LEAST_EVERY: Duration = Duration::from_secs(60);

/// Progress display of a study.
#[derive(Debug)]
pub struct Progress {
    total: u64,
    /// Samples finished before this run, which do not count for its pace.
    before: u64,
    started: Instant,
    display: Display,
}

#[derive(Debug)]
enum Display {
    Bar(Bar),
    Lines { last: Instant, shown: u64 },
}

impl Progress {
    /// Starts the display of a study of `total` samples, `before` of them finished earlier.
    #[must_use]
    pub fn start(total: u64, before: u64, now: Instant) -> Self {
        let display = Bar::on_terminal().map_or(Display::Lines { last: now, shown: before }, Display::Bar);
        Self { total, before, started: now, display }
    }

    /// Whether progress is on a terminal, so that the user can type commands.
    #[must_use]
    pub fn is_on_terminal(&self) -> bool {
        matches!(self.display, Display::Bar(_))
    }

    /// Shows the present counts if an update is due; `stale`: number of workers without recent messages; `so_far`: results as text.
    pub fn update(&mut self, tally: &Tally, eta: Option<Eta>, (stale, so_far): (usize, &str), now: Instant) {
        let done = tally.done();
        let view = View { stale, so_far, ..self.view(tally, now, eta.map_or(Left::Unknown, Left::Range)) };
        match &mut self.display {
            Display::Bar(bar) => bar.draw(view.fitting(Bar::columns())),
            Display::Lines { last, shown } => {
                let since = now.duration_since(*last);
                let due = since >= LINE_AT_LEAST_EVERY
                    || since >= LINE_EVERY && done.saturating_sub(*shown) * LINES >= self.total;
                if due && done < self.total {
                    (*last, *shown) = (now, done);
                    // a closed standard error does not stop the study
                    let _ = writeln!(std::io::stderr(), "{}", view.text());
                }
            }
        }
    }

    /// Writes lines above the bar or between the plain lines.
    pub fn note(&mut self, text: &str) {
        let text = &*visible_lines(text);
        match &mut self.display {
            Display::Bar(bar) => bar.note(text),
            Display::Lines { .. } => {
                let _ = writeln!(std::io::stderr(), "{text}");
            }
        }
    }

    /// The user has typed a line, which the terminal has echoed.
    pub fn typed(&mut self) {
        if let Display::Bar(bar) = &mut self.display {
            bar.typed();
        }
    }

    /// Removes the bar before other output.
    pub fn clear(&mut self) {
        if let Display::Bar(bar) = &mut self.display {
            bar.clear();
        }
    }

    /// Ends the display with a last line.
    pub fn finish(&mut self, tally: &Tally, now: Instant) {
        self.clear();
        let _ = writeln!(std::io::stderr(), "{}", self.view(tally, now, Left::Over).text());
    }

    fn view<'a>(&self, tally: &'a Tally, now: Instant, left: Left) -> View<'a> {
        let elapsed = now.duration_since(self.started);
        View { tally, before: self.before, total: self.total, elapsed, left, stale: 0, so_far: "" }
    }
}

/// Remaining time.
#[derive(Clone, Copy)]
enum Left {
    /// No estimate yet.
    Unknown,
    Range(Eta),
    /// The computation has ended.
    Over,
}

/// Data of a progress line.
struct View<'a> {
    tally: &'a Tally,
    before: u64,
    total: u64,
    elapsed: Duration,
    left: Left,
    stale: usize,
    /// Worst value and first answer, as text.
    so_far: &'a str,
}

impl View<'_> {
    /// The complete line.
    fn text(&self) -> String {
        let beyond = match self.tally.of(Status::Beyond) {
            0 => String::new(),
            _ => format!("beyond {}, ", self.tally.words(&[Status::Beyond])),
        };
        let outcome = format!(
            "; {beyond}invalid {}, failed {}",
            self.tally.words(&[Status::Invalid]),
            self.tally.words(&[Status::Failed, Status::Quarantined])
        );
        let so_far = if self.so_far.is_empty() { String::new() } else { format!("; {}", self.so_far) };
        format!("{}{}{}{outcome}{}{so_far}", self.count(), self.rate(), self.left(), self.silent())
    }

    /// The line shortened to the width of a terminal, behind a bar.
    fn fitting(&self, columns: usize) -> String {
        let (count, rate, left, silent) = (self.count(), self.rate(), self.left(), self.silent());
        let counts = [self.tally.of(Status::Beyond), self.tally.of(Status::Invalid), self.tally.failed()];
        let beyond = if counts[0] > 0 { format!("beyond {}, ", counts[0]) } else { String::new() };
        let bad: String = counts
            .iter()
            .zip(["beyond", "invalid", "failed"])
            .filter(|(number, _)| **number > 0)
            .map(|(number, what)| format!(", {number} {what}"))
            .collect();
        let texts = [
            self.text(),
            format!("{count}{rate}{left}; {beyond}invalid {}, failed {}{silent}", counts[1], counts[2]),
            format!("{count}{rate}{left}{bad}{silent}"),
            format!("{count}{left}{bad}"),
            format!("{count}{left}"),
            count,
        ];
        fitting(self.tally.done() as f64 / self.total.max(1) as f64, &texts, columns)
    }

    fn count(&self) -> String {
        format!("{}/{}", self.tally.done(), self.total)
    }

    fn rate(&self) -> String {
        let new = self.tally.done().saturating_sub(self.before);
        let rate = new as f64 / self.elapsed.as_secs_f64();
        match rate {
            _ if new == 0 || !rate.is_finite() => String::new(),
            1.0.. => format!(", {rate:.1}/s"),
            _ => format!(", {:.1}/min", rate * 60.0),
        }
    }

    fn left(&self) -> String {
        match self.left {
            _ if self.tally.done() == self.total => format!(", {}", duration(self.elapsed)),
            Left::Unknown => ", time left not known yet".to_owned(),
            Left::Range(eta) => format!(", {}", eta.text()),
            Left::Over => String::new(),
        }
    }

    fn silent(&self) -> String {
        if self.stale > 0 { format!("; {} silent", counted(self.stale as u64, "worker")) } else { String::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::outcome::{Cause, CauseSet, EndCause, Outcome};

    fn tally(causes: &[Option<Cause>]) -> Tally {
        let mut tally = Tally::default();
        for &cause in causes {
            let status = if cause.is_some() { Status::Failed } else { Status::Ok };
            let causes = CauseSet::default();
            tally.add(&Outcome {
                status,
                cause,
                causes,
                notes: CauseSet::default(),
                end_cause: EndCause::EndTime,
                values: Vec::new(),
            });
        }
        tally
    }

    fn view(tally: &Tally, total: u64, left: Left) -> View<'_> {
        View { tally, before: 0, total, elapsed: Duration::from_secs(2), left, stale: 0, so_far: "" }
    }

    fn range(low: u64, high: u64) -> Left {
        Left::Range(Eta { low: Duration::from_secs(low), high: Duration::from_secs(high) })
    }

    #[test]
    fn the_line_has_rate_remaining_time_and_failures_by_cause() {
        let tally = tally(&[None, None, Some(Cause::Diverged)]);
        let line = |left| view(&tally, 9, left).text();
        assert_eq!(line(range(4, 4)), "3/9, 1.5/s, 4.0 s left; invalid 0, failed 1 (1 diverged)");
        assert_eq!(line(range(50, 80)), "3/9, 1.5/s, 50 s to 1 min 20 s left; invalid 0, failed 1 (1 diverged)");
        assert_eq!(view(&tally, 3, Left::Over).text(), "3/3, 1.5/s, 2.0 s; invalid 0, failed 1 (1 diverged)");
        let line = View { before: 2, ..view(&tally, 9, Left::Over) }.text();
        assert!(line.starts_with("3/9, 30.0/min; invalid"), "two were there before, and it was stopped: {line}");
    }

    #[test]
    fn results_so_far_stand_at_the_end_where_there_is_room() {
        let tally = tally(&[None]);
        let view = View { so_far: "largest bearing load 1.6 MN, overload 1 of 2", ..view(&tally, 3, range(4, 4)) };
        let line = view.text();
        assert!(line.ends_with("failed 0; largest bearing load 1.6 MN, overload 1 of 2"), "{line}");
        assert!(view.fitting(140).contains("overload 1 of 2") && !view.fitting(80).contains("overload"));
    }

    #[test]
    fn runs_beyond_the_model_are_counted_where_there_are_some() {
        let mut tally = tally(&[None]);
        (0..2).for_each(|_| tally.count(Status::Beyond, Some(Cause::RingDisplacement)));
        let line = view(&tally, 3, Left::Over).text();
        assert_eq!(line, "3/3, 1.5/s, 2.0 s; beyond 2 (2 ring_displacement), invalid 0, failed 0");
        assert!(view(&tally, 3, Left::Over).fitting(60).contains("2 beyond"));
    }

    #[test]
    fn the_time_left_is_not_told_before_it_is_known_and_begins_with_no_zero() {
        let tally = tally(&[None, None, None]);
        let line = |left| view(&tally, 9, left).text();
        assert_eq!(line(Left::Unknown), "3/9, 1.5/s, time left not known yet; invalid 0, failed 0");
        assert_eq!(line(range(0, 80)), "3/9, 1.5/s, up to 1 min 20 s left; invalid 0, failed 0");
        let nothing = Tally::default();
        let beginning = View { elapsed: Duration::ZERO, ..view(&nothing, 9, Left::Unknown) };
        assert_eq!(beginning.text(), "0/9, time left not known yet; invalid 0, failed 0");
    }

    #[test]
    fn a_bar_fits_60_columns_and_keeps_what_matters_longest() {
        let mut counts = tally(&[Some(Cause::Diverged); 7]);
        (0..12_338).for_each(|_| counts.count(Status::Ok, None));
        for left in [Left::Unknown, range(50, 80), range(25_500, 36_060)] {
            for columns in [30, 40, 60, 80, 100, 120] {
                let line = view(&counts, 100_000, left).fitting(columns);
                assert!(line.chars().count() < columns, "{columns}: {line}");
                assert!(line.contains("12345/100000"), "{columns}: {line}");
                assert!(columns < 60 || line.contains(" left") && line.contains('░'), "{columns}: {line}");
                assert!(columns < 80 || line.contains("failed"), "{columns}: {line}");
                assert!(columns < 120 || line.contains("failed 7 (7 diverged)"), "{columns}: {line}");
            }
        }
    }
}
