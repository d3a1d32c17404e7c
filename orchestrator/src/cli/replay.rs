//! `bladeoff replay`: one sample of a study again, bit for bit, with its history.

use super::error::CliError;
use super::exit::Exit;
use super::history::{HistoryArgs, watched};
use super::output::{print, remark};
use crate::engine;
use crate::report::{OutcomeView, beyond_small_displacements, describe_outcome};
use crate::results::{DETECTION, Table, TableSchema, read_metadata};
use crate::run::directory::{INCOMPLETE_RESULTS, RESULTS};
use bladeoff_core::machine::Machine;
use bladeoff_core::outcome::{Cause, Outcome};
use bladeoff_worker::core_solver::{CoreSolver, SolverError};
use bladeoff_worker::plan::{PlanFileError, WorkPlan};
use std::path::{Path, PathBuf};

/// Compute one sample of a study again and compare it with its row
///
/// The sample is computed from the machine, overrides and basis that are frozen in the result directory, with the parameters
/// of its row. Every column of the row is compared bit for bit; a difference is listed and the exit code is 1: the same build
/// on the same inputs gives the same bytes, so another build of the program (or a bug) made it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff replay runs/first-look --sample 17
  bladeoff replay runs/first-look --worst max_bearing_load_N --history worst.mcap")]
pub struct Args {
    /// Result directory of a study
    directory: PathBuf,

    /// Sample number, as in the column `sample`
    #[arg(long, value_name = "N", required_unless_present = "worst")]
    sample: Option<u64>,

    /// The sample with the largest value of this column among the rows that are ok
    #[arg(long, value_name = "COLUMN", conflicts_with = "sample")]
    worst: Option<String>,

    #[command(flatten)]
    history: HistoryArgs,
}

/// Why a sample cannot be computed again.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// No such sample.
    #[error("{} has no sample {sample}; it has {rows} rows", table.display())]
    Sample {
        /// The table.
        table: PathBuf,
        /// The number.
        sample: u64,
        /// Rows there are.
        rows: usize,
    },
    /// No such column of numbers.
    #[error("{} has no column {column:?} of numbers{}", table.display(), nearest.as_ref().map(|name| format!("; did you mean {name}?")).unwrap_or_default())]
    Column {
        /// The table.
        table: PathBuf,
        /// The name.
        column: String,
        /// The nearest one.
        nearest: Option<String>,
    },
    /// Nothing in the column.
    #[error("no row of {} that is ok has a value in {column}", table.display())]
    Empty {
        /// The table.
        table: PathBuf,
        /// The column.
        column: String,
    },
    /// The table does not say which plan it was computed from.
    #[error("{} does not name the plan it was computed from", table.display())]
    NoPlan {
        /// The table.
        table: PathBuf,
    },
    /// The plan.
    #[error(transparent)]
    Plan(#[from] PlanFileError),
    /// The sample.
    #[error("the sample cannot be computed")]
    Solver(#[from] SolverError),
    /// A parameter of the plan without a column.
    #[error("{} has no column for the parameter {path}", table.display())]
    Parameter {
        /// The table.
        table: PathBuf,
        /// The parameter.
        path: String,
    },
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let path = table_of(&args.directory)?;
    let table = Table::read(&path)?;
    let row = match (args.sample, &args.worst) {
        (Some(sample), _) => row_of(&table, &path, sample)?,
        (None, Some(column)) => worst(&table, &path, column)?,
        (None, None) => unreachable!("clap asks for one of the two"),
    };
    let sample = table.numbers("sample").and_then(|samples| samples[row]).map_or(row as u64, |sample| sample as u64);
    let hash = read_metadata(&path)?.into_iter().find(|(key, _)| key == "bladeoff.plan_blake3").map(|(_, hash)| hash);
    let hash = hash.ok_or_else(|| ReplayError::NoPlan { table: path.clone() })?;
    let plan = WorkPlan::read(&args.directory, &hash).map_err(ReplayError::Plan)?;
    let mut solver = CoreSolver::new(&plan).map_err(ReplayError::Solver)?;
    let params = parameters(&plan, &solver, &table, &path, row)?;
    let (machine, structure) = solver.prepare(&params).map_err(ReplayError::Solver)?;
    let step = engine::plan(&machine, structure)?;
    let (outcome, history) = watched(&machine, structure, &step, args.history.settings()?.as_ref())?;
    let columns = engine::columns(&machine);
    print(&format!("{:<32} {sample} of {}\n", "sample", path.display()))?;
    let view = OutcomeView { columns: &columns, outcome: &outcome };
    print(&describe_outcome(view))?;
    for note in beyond_small_displacements(&machine, view).iter().chain(&history) {
        remark(note);
    }
    verdict(&table, row, &machine, &outcome)
}

fn table_of(directory: &Path) -> Result<PathBuf, CliError> {
    [RESULTS, INCOMPLETE_RESULTS]
        .iter()
        .map(|name| directory.join(name))
        .find(|path| path.is_file())
        .ok_or_else(|| CliError::NoResults { path: directory.to_path_buf() })
}

fn row_of(table: &Table, path: &Path, sample: u64) -> Result<usize, ReplayError> {
    let samples = table.numbers("sample").unwrap_or_default();
    samples.iter().position(|found| *found == Some(sample as f64)).ok_or_else(|| ReplayError::Sample {
        table: path.to_path_buf(),
        sample,
        rows: table.rows(),
    })
}

fn worst(table: &Table, path: &Path, column: &str) -> Result<usize, ReplayError> {
    let values = table.numbers(column).ok_or_else(|| ReplayError::Column {
        table: path.to_path_buf(),
        column: column.to_owned(),
        nearest: table
            .names()
            .map(|name| (strsim::jaro_winkler(name, column), name))
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .filter(|(likeness, _)| *likeness > 0.7)
            .map(|(_, name)| name.to_owned()),
    })?;
    let status = table.words("status").unwrap_or_default();
    let ok = |row: usize| status.get(row).is_some_and(|word| word.as_deref() == Some("ok"));
    let rows = values.iter().enumerate().filter_map(|(row, value)| Some((row, (*value)?))).filter(|(row, _)| ok(*row));
    // the first of several equal ones
    rows.fold(
        None,
        |best: Option<(usize, f64)>, next| if best.is_none_or(|best| next.1 > best.1) { Some(next) } else { best },
    )
    .map(|(row, _)| row)
    .ok_or_else(|| ReplayError::Empty { table: path.to_path_buf(), column: column.to_owned() })
}

/// The parameters of a row, as a worker gets them.
fn parameters(
    plan: &WorkPlan,
    solver: &CoreSolver,
    table: &Table,
    path: &Path,
    row: usize,
) -> Result<Vec<f64>, ReplayError> {
    let missing = |name: &str| ReplayError::Parameter { table: path.to_path_buf(), path: name.to_owned() };
    plan.varied
        .iter()
        .zip(solver.parameter_columns())
        .map(|(varied, column)| match &varied.choices {
            None => table.numbers(&column).and_then(|values| values[row]).ok_or_else(|| missing(&varied.path)),
            Some(choices) => {
                let name = if varied.path.ends_with(".contact.detection") { DETECTION } else { varied.path.as_str() };
                let word =
                    table.words(name).and_then(|words| words[row].as_deref()).ok_or_else(|| missing(&varied.path))?;
                let at = choices.iter().position(|choice| choice == word).ok_or_else(|| missing(&varied.path))?;
                Ok(at as f64)
            }
        })
        .collect()
}

/// Compares the outcome with the row, column by column.
fn verdict(table: &Table, row: usize, machine: &Machine, outcome: &Outcome) -> Result<Exit, CliError> {
    let cause = table.words("cause").and_then(|words| words[row].as_deref()).and_then(Cause::from_word);
    if let Some(cause) = cause.filter(|cause| !cause.is_deterministic()) {
        print(&format!("\nthe row is {}: there is nothing in it to compare\n", cause.word()))?;
        return Ok(Exit::Ok);
    }
    let mut differences = Vec::new();
    let mut compared = 0;
    let word = |name: &str| table.words(name).and_then(|words| words[row].clone());
    let mut compare = |name: &str, ours: Option<String>, theirs: Option<String>| {
        compared += 1;
        if ours != theirs {
            let shown = |value: Option<String>| value.unwrap_or_else(|| "null".to_owned());
            differences.push(format!("  {name}: {} now, {} in the row", shown(ours), shown(theirs)));
        }
    };
    compare("status", Some(outcome.status.word().to_owned()), word("status"));
    compare("cause", outcome.cause.map(|cause| cause.word().to_owned()), word("cause"));
    compare("causes", outcome.causes.words(), word("causes"));
    compare("end_cause", Some(outcome.end_cause.word().to_owned()), word("end_cause"));
    let columns = engine::columns(machine);
    let schema = TableSchema::new(Vec::new(), &columns);
    for (field, value) in schema.outcome().iter().zip(&outcome.values) {
        let text = |value: f64| format!("{value:?}");
        match table.numbers(&field.name) {
            Some(values) => compare(&field.name, value.map(text), values[row].map(text)),
            None => compare(
                &field.name,
                value.and_then(|value| field.kind.word(value)).map(str::to_owned),
                word(&field.name),
            ),
        }
    }
    if differences.is_empty() {
        print(&format!("\nequal to the row in all {compared} columns, bit for bit\n"))?;
        return Ok(Exit::Ok);
    }
    print(&format!(
        "\ndifferent from the row in {} of {compared} columns\n{}\n",
        differences.len(),
        differences.join("\n")
    ))?;
    Ok(Exit::Bug)
}
