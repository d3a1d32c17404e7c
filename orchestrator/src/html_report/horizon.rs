//! Times and speeds at which a study's ok runs ended, because what follows is unknown.

use bladeoff_answers::summary::counted;
use bladeoff_answers::tables::{END_CAUSE, END_SPEED, END_TIME, Table, TableError};
use bladeoff_model::outcome::{EndCause, Status};
use bladeoff_text::document::units::format_digits;
use std::path::PathBuf;

/// Counts of ok runs, and of those that ended at their end time or at their end speed.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Horizon {
    ok: u64,
    at_time: Ended,
    at_speed: Ended,
}

/// Runs that ended for one reason.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Ended {
    count: u64,
    /// Smallest and largest value at the end, of the time \[s\] or the speed \[rad/s\].
    range: Option<[f64; 2]>,
}

impl Ended {
    fn see(&mut self, value: f64) {
        self.count += 1;
        let [least, most] = self.range.unwrap_or([value; 2]);
        self.range = Some([least.min(value), most.max(value)]);
    }

    /// Number of runs and their values: "904 of 904 ok runs ended at their end time, 6 s".
    fn words(&self, ok: u64, what: &str, unit: &str, shown: &str) -> Option<String> {
        let [least, most] = self.range?.map(|value| format_digits(value, unit, 4));
        let values = if least == most { least } else { format!("{least} to {most}") };
        Some(format!("{} of {} ended at their {what}, {values}; {shown}", self.count, counted(ok, "ok run")))
    }
}

impl Horizon {
    /// Counts the rows of these files.
    ///
    /// # Errors
    /// A table cannot be read.
    pub fn of(files: &[PathBuf]) -> Result<Self, TableError> {
        let mut found = Self::default();
        Table::for_each_piece(files, &["status", END_CAUSE, END_TIME, END_SPEED], |piece| {
            let (status, cause) = (piece.words("status").unwrap_or(&[]), piece.words(END_CAUSE).unwrap_or(&[]));
            let (times, speeds) = (piece.numbers(END_TIME).unwrap_or(&[]), piece.numbers(END_SPEED).unwrap_or(&[]));
            for (row, (status, cause)) in status.iter().zip(cause).enumerate() {
                if status.as_deref() == Some(Status::Ok.word()) {
                    let at = |values: &[Option<f64>]| values.get(row).copied().flatten();
                    found.see(cause.as_deref(), at(times), at(speeds));
                }
            }
            Ok(())
        })?;
        Ok(found)
    }

    fn see(&mut self, cause: Option<&str>, time: Option<f64>, speed: Option<f64>) {
        self.ok += 1;
        match cause.and_then(EndCause::from_word) {
            Some(EndCause::EndTime) => time.into_iter().for_each(|time| self.at_time.see(time)),
            Some(EndCause::EndSpeed) => speed.into_iter().for_each(|speed| self.at_speed.see(speed)),
            _ => {}
        }
    }

    /// A sentence for each reason for which ok runs ended before the rotor was at rest.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let time = self.at_time.words(self.ok, "end time", "s", "later events are unknown");
        let lower = "what happens at lower speeds is unknown, critical speeds included";
        time.into_iter().chain(self.at_speed.words(self.ok, "end speed", "rad/s", lower)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sentences_name_the_times_and_speeds_at_which_runs_ended() {
        let mut horizon = Horizon::default();
        assert_eq!(horizon.sentences(), [] as [String; 0]);
        horizon.see(Some("stopped"), Some(2.0), Some(0.0));
        assert_eq!(horizon.sentences(), [] as [String; 0], "a rotor at rest has no later events");
        horizon.see(Some("end_time"), Some(6.0), Some(9.0));
        let said = "1 of 2 ok runs ended at their end time, 6 s; later events are unknown";
        assert_eq!(horizon.sentences(), [said]);
        horizon.see(Some("end_time"), Some(4.0), Some(9.0));
        horizon.see(Some("end_speed"), Some(1.0), Some(314.159_265));
        let [time, speed] = &horizon.sentences()[..] else { panic!("{:?}", horizon.sentences()) };
        assert_eq!(time, "2 of 4 ok runs ended at their end time, 4 s to 6 s; later events are unknown");
        let said = "1 of 4 ok runs ended at their end speed, 3000 rpm; what happens at lower speeds is unknown, critical speeds included";
        assert_eq!(speed, said);
    }
}
