//! `replay --set`: a row of a study compared with the outcome of the same sample with changed values.

use super::error::CliError;
use super::machine::set;
use crate::engine;
use bladeoff_answers::summary::{Align, TextTable};
use bladeoff_answers::tables::{ENGINE, NOTES, Table, TableSchema};
use bladeoff_model::machine::{Machine, MachineDef, ParamValue, PathError};
use bladeoff_model::outcome::{Outcome, Part};
use bladeoff_study::show;
use bladeoff_text::document::units::{format_digits, format_quantity};
use bladeoff_text::document::{cut, nearest};
use bladeoff_worker::core_solver::SolverError;

/// Reason why a changed sample has no machine.
#[derive(Debug)]
pub(super) enum Unchanged {
    /// An argument of `--set` is invalid.
    Argument(CliError),
    /// The machine with the changed values is rejected.
    Solver(SolverError),
}

impl From<SolverError> for Unchanged {
    fn from(error: SolverError) -> Self {
        Self::Solver(error)
    }
}

/// A value of `--set`.
pub(super) struct Set {
    /// Path of the parameter.
    pub path: String,
    /// New value, as printed.
    pub now: String,
    /// Value of the row, as printed.
    pub before: String,
}

/// Names of a study that `--set` may use instead of paths.
#[derive(Debug, Default)]
pub(super) struct StudyNames {
    /// Short name (`as`) and path of each parameter that has one.
    pub parameters: Vec<(String, String)>,
    /// Variables of formulas, which the machine does not have.
    pub variables: Vec<String>,
    /// Paths of the parameters that formulas compute.
    pub derived: Vec<String>,
}

impl StudyNames {
    /// The path for which a word of `--set` stands.
    ///
    /// # Errors
    /// The reason, in words, why the word stands for no path.
    fn path(&self, machine: &MachineDef, word: &str) -> Result<String, String> {
        let of_study = self.parameters.iter().find(|(short, _)| short == word).map(|(_, path)| path);
        match (of_study, machine.find(word)) {
            (Some(path), Ok(info)) if info.path != *path => Err(format!(
                "`{word}` names two parameters: {path} by the study, {} by its ending; write the whole path",
                info.path
            )),
            (Some(path), _) => Ok(path.clone()),
            (None, Err(PathError::Unknown { .. })) if self.variables.iter().any(|name| name == word) => {
                Err(format!("`{word}` is a variable of formulas; set the parameters that are derived from it"))
            }
            (None, Err(PathError::Unknown { .. })) => {
                let shorts = self.parameters.iter().map(|(short, _)| short.as_str());
                match nearest(word, shorts) {
                    Some(near) => Err(format!(
                        "neither the study nor its machine has a parameter `{}`; did you mean `{near}`?",
                        cut(word, 120)
                    )),
                    None => Ok(word.to_owned()),
                }
            }
            (None, _) => Ok(word.to_owned()),
        }
    }
}

/// Sets the values of `--set` and adds each to `changes`.
pub(super) fn change(
    machine: &mut MachineDef,
    given: &[String],
    names: &StudyNames,
    changes: &mut Vec<Set>,
) -> Result<(), Unchanged> {
    for argument in given {
        let shown = format!("--set {argument}");
        let Some((path, value)) = argument.split_once('=') else {
            let (message, allowed) = ("there is no `=`".to_owned(), Some("PATH=VALUE".to_owned()));
            return Err(Unchanged::Argument(CliError::Argument { argument: shown, message, allowed }));
        };
        let path = names.path(machine, path.trim()).map_err(|message| {
            Unchanged::Argument(CliError::Argument { argument: shown.clone(), message, allowed: None })
        })?;
        let (path, value) = (path.as_str(), value.trim());
        let before = machine.resolve(path).map(|info| info.shown).unwrap_or_default();
        set(machine, path, value, &shown).map_err(Unchanged::Argument)?;
        if let Ok(info) = machine.resolve(path) {
            let value: Option<ParamValue> = machine.parse_value(&info, value).ok();
            let now = value.map(|value| show(&info, &value)).unwrap_or_default();
            let before = if before.is_empty() { "its default".to_owned() } else { before };
            changes.push(Set { path: info.path.clone(), now, before });
        }
    }
    Ok(())
}

/// Every column for which row or outcome has a value, with a mark if they differ; the number of columns that differ, and of all.
pub(super) fn beside(row: &Table, machine: &Machine, outcome: &Outcome) -> String {
    let mut lines = Lines::default();
    let word = |name: &str| row.words(name).and_then(|words| words[0].clone());
    let ours = [
        ("status", Some(outcome.status.word().to_owned())),
        ("causes", outcome.causes.words()),
        (NOTES, outcome.notes.words()),
        ("end_cause", Some(outcome.end_cause.word().to_owned())),
        (ENGINE, Some(machine.run.engine.word().to_owned())),
    ];
    for (name, changed) in ours {
        lines.words(name, word(name), changed);
    }
    let columns = engine::columns(machine);
    let schema = TableSchema::new(Vec::new(), &columns);
    let of_values = schema.outcome().iter().zip(&columns).zip(&outcome.values);
    for ((field, column), value) in of_values.filter(|((_, column), _)| column.part != Part::Guarded) {
        match row.numbers(&field.name) {
            Some(values) => lines.numbers(&field.name, column.unit, values[0], *value),
            None => {
                let changed = value.and_then(|value| field.kind.word(value)).map(str::to_owned);
                lines.words(&field.name, word(&field.name), changed);
            }
        }
    }
    lines.text()
}

#[derive(Default)]
struct Lines {
    rows: Vec<[String; 5]>,
    differ: usize,
}

impl Lines {
    fn words(&mut self, name: &str, row: Option<String>, changed: Option<String>) {
        let differs = row != changed;
        self.line(name, [row, changed], differs, String::new());
    }

    fn numbers(&mut self, name: &str, unit: &str, row: Option<f64>, changed: Option<f64>) {
        let by = match (row, changed) {
            (Some(row), Some(changed)) if row != changed && row != 0.0 => {
                let percent = 100.0 * (changed - row) / row.abs();
                format!("{}{} %", if percent > 0.0 { "+" } else { "" }, format_digits(percent, "", 3))
            }
            _ => String::new(),
        };
        let shown = [row, changed].map(|value| value.map(|value| format_quantity(value, unit)));
        self.line(name, shown, row.map(f64::to_bits) != changed.map(f64::to_bits), by);
    }

    fn line(&mut self, name: &str, [row, changed]: [Option<String>; 2], differs: bool, by: String) {
        if row.is_none() && changed.is_none() {
            return;
        }
        self.differ += usize::from(differs);
        let [row, changed] = [row, changed].map(|value| value.unwrap_or_else(|| "-".to_owned()));
        self.rows.push([if differs { "*" } else { "" }.to_owned(), name.to_owned(), row, changed, by]);
    }

    fn text(self) -> String {
        let all = self.rows.len();
        let mut table = TextTable::new(&[
            ("", Align::Left),
            ("column", Align::Left),
            ("row", Align::Right),
            ("changed", Align::Right),
            ("difference", Align::Right),
        ]);
        self.rows.into_iter().for_each(|row| table.row(row.to_vec()));
        format!("\n{}\n{} of {all} columns differ (*); nothing is written\n", table.render(""), self.differ)
    }
}
