//! The simulated time of a study's ok runs: nothing is known of what follows it.

use bladeoff_answers::summary::counted;
use bladeoff_answers::tables::{END_CAUSE, END_TIME, Table, TableError};
use bladeoff_model::outcome::{EndCause, Status};
use bladeoff_text::document::units::format_digits;
use std::path::PathBuf;

/// Counts of ok runs, and of those that ended at their end time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Horizon {
    ok: u64,
    ended: u64,
    /// Shortest and longest end time \[s\].
    times: Option<[f64; 2]>,
}

impl Horizon {
    /// Counts the rows of these files.
    ///
    /// # Errors
    /// A table that cannot be read.
    pub fn of(files: &[PathBuf]) -> Result<Self, TableError> {
        let mut found = Self::default();
        Table::for_each_piece(files, &["status", END_CAUSE, END_TIME], |piece| {
            let (status, cause) = (piece.words("status").unwrap_or(&[]), piece.words(END_CAUSE).unwrap_or(&[]));
            let times = piece.numbers(END_TIME).unwrap_or(&[]);
            for ((status, cause), time) in status.iter().zip(cause).zip(times) {
                if status.as_deref() == Some(Status::Ok.word()) {
                    found.see(cause.as_deref() == Some(EndCause::EndTime.word()), *time);
                }
            }
            Ok(())
        })?;
        Ok(found)
    }

    fn see(&mut self, is_end: bool, time: Option<f64>) {
        self.ok += 1;
        let Some(time) = time.filter(|_| is_end) else { return };
        self.ended += 1;
        let [least, most] = self.times.unwrap_or([time; 2]);
        self.times = Some([least.min(time), most.max(time)]);
    }

    /// "904 of 904 ok runs ended at their end time, 6 s; later events are unknown"; `None` where no ok run ended so.
    #[must_use]
    pub fn sentence(&self) -> Option<String> {
        let [least, most] = self.times?.map(|time| format_digits(time, "s", 4));
        let times = if least == most { least } else { format!("{least} to {most}") };
        let ok = counted(self.ok, "ok run");
        Some(format!("{} of {ok} ended at their end time, {times}; later events are unknown", self.ended))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sentence_names_the_times_at_which_runs_ended() {
        let mut horizon = Horizon::default();
        assert_eq!(horizon.sentence(), None);
        horizon.see(false, Some(2.0));
        assert_eq!(horizon.sentence(), None, "a rotor at rest has no later events");
        horizon.see(true, Some(6.0));
        let said = "1 of 2 ok runs ended at their end time, 6 s; later events are unknown";
        assert_eq!(horizon.sentence().as_deref(), Some(said));
        horizon.see(true, Some(4.0));
        let said = "2 of 3 ok runs ended at their end time, 4 s to 6 s; later events are unknown";
        assert_eq!(horizon.sentence().as_deref(), Some(said));
    }
}
