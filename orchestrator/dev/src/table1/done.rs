//! A run of the comparison that is done.

use bladeoff_model::outcome::{ColumnKind, Outcome, Status};
use std::fmt::Write;

/// One run that is done.
pub struct Done {
    /// Word of its engine.
    pub engine: &'static str,
    /// Word of its contact detection.
    pub detection: &'static str,
    /// Number of its start, 0: the machine's own.
    pub start: usize,
    /// CPU time of the transient \[s\].
    pub cpu: f64,
    /// Columns of its outcome.
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

    /// How it ended.
    #[must_use]
    pub fn status(&self) -> Status {
        self.outcome.status
    }

    /// Status and causes of a run that is not ok.
    #[must_use]
    pub fn trouble(&self) -> Option<String> {
        let causes = || self.outcome.causes.words().map(|words| format!(" ({words})")).unwrap_or_default();
        (self.status() != Status::Ok).then(|| format!("{}{}", self.status().word(), causes()))
    }
}

/// Every run, one line each.
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
