//! A finished run of the comparison.

use bladeoff_model::outcome::{ColumnKind, Outcome, Status};
use std::fmt::Write;

/// One finished run.
pub struct Done {
    /// Name of the engine.
    pub engine: &'static str,
    /// Name of the contact detection.
    pub detection: &'static str,
    /// Number of the start; 0 is the start that the machine file defines.
    pub start: usize,
    /// CPU time of the transient \[s\].
    pub cpu: f64,
    /// Columns of the outcome.
    pub names: Vec<(String, ColumnKind)>,
    /// The outcome.
    pub outcome: Outcome,
}

impl Done {
    /// Value of a column.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<f64> {
        let at = self.names.iter().position(|(column, _)| column == name)?;
        self.outcome.values.get(at).copied().flatten()
    }

    /// Status of the run.
    #[must_use]
    pub fn status(&self) -> Status {
        self.outcome.status
    }

    /// Status and causes, if the run is not ok.
    #[must_use]
    pub fn trouble(&self) -> Option<String> {
        let causes = || self.outcome.causes.words().map(|words| format!(" ({words})")).unwrap_or_default();
        (self.status() != Status::Ok).then(|| format!("{}{}", self.status().word(), causes()))
    }
}

/// CSV of all runs, one line for each.
#[must_use]
pub fn csv(done: &[Done]) -> String {
    let mut text = String::from("engine,detection,start,cpu_s,status");
    let Some(first) = done.first() else { return text };
    for (name, _) in &first.names {
        write!(text, ",{name}").expect("writing to a String cannot fail");
    }
    text.push('\n');
    for run in done {
        write!(text, "{},{},{},{:?},{}", run.engine, run.detection, run.start, run.cpu, run.outcome.status.word())
            .expect("writing to a String cannot fail");
        for ((_, kind), value) in run.names.iter().zip(&run.outcome.values) {
            text.push(',');
            match (kind, value) {
                (_, None) => {}
                (ColumnKind::Choice(words), Some(value)) => {
                    text.push_str(words.get(*value as usize).copied().unwrap_or(""))
                }
                (_, Some(value)) => write!(text, "{value:?}").expect("writing to a String cannot fail"),
            }
        }
        text.push('\n');
    }
    text
}
