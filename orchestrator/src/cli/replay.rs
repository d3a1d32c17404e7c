//! `bladeoff replay`: one sample of a study is computed again, bit for bit, with its history.

use super::beside::{StudyNames, Unchanged, beside, change};
use super::error::CliError;
use super::exit::Exit;
use super::history::{HistoryArgs, watched};
use super::json::{self, JsonObject, pretty};
use super::machine::refused;
use super::output::{print_json, remark, tell};
use super::refusals::{ReplayError, SampleError};
use super::sample_words;
use super::simulate;
use super::why::frozen;
use crate::engine;
use crate::html_report::{Computed, Envelope};
use crate::run::directory::{PARTS, RESULTS, read_current};
use crate::run::shards::row_files;
use crate::run::{is_of_formulas, refuse_changed};
use crate::terminal::{OutcomeView, bearing_remarks, describe_outcome, with_word};
use bladeoff_answers::tables::{DETECTION, ENGINE, NOTES, Table, TableError, TableSchema, read_metadata};
use bladeoff_core::NUMERICS_VERSION;
use bladeoff_core::engine::exponential::EXPONENTIAL_REVISION;
use bladeoff_core::record::NoHistory;
use bladeoff_model::machine::{Machine, is_detection};
use bladeoff_model::outcome::{Cause, Outcome};
use bladeoff_study::Origin;
use bladeoff_system::{call, shown};
use bladeoff_worker::core_solver::{CoreSolver, SolverError};
use bladeoff_worker::job_spec::{JobSpec, MachineJob};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Compute one sample of a study again and compare it with its row
///
/// The sample is computed from the machine, overrides and basis that are frozen in the result directory, with the
/// parameters of its row. Every column is compared with the row, bit for bit. Differences are listed. The exit code is
/// then 4 if another numerics version computed the row, and 1 otherwise: the same numerics give the same bytes, so such a
/// difference is a bug.
///
/// With --set the sample is computed with changed values, and row and result are printed side by side with the
/// differences marked. Nothing is written, and the exit code is 0.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff replay runs/first-look 17
  bladeoff replay runs/first-look --history worst.mcap \\
    --worst max_bearing_load_N
  bladeoff replay runs/first-look 17 --set contact.gap=0.6mm

  Of the last study:
  bladeoff replay --worst max_bearing_load_N")]
pub struct Args {
    /// Result directory of a study [default: the current one if it contains a study, otherwise the newest one below
    /// runs/], and a sample number: DIRECTORY SAMPLE, or DIRECTORY#SAMPLE
    #[arg(value_name = "DIRECTORY", num_args = 0..=2)]
    words: Vec<String>,

    /// Sample number, as in the column `sample`
    #[arg(long, value_name = "N")]
    sample: Option<u64>,

    /// Select the sample with the largest value of this column among the rows that are ok
    #[arg(long, value_name = "COLUMN", conflicts_with = "sample")]
    worst: Option<String>,

    /// Compute the sample with this value and print it beside its row; may be given several times. PATH is a parameter's
    /// name in the study, a path of the machine, or its unique ending
    #[arg(long = "set", value_name = "PATH=VALUE", conflicts_with = "history")]
    set: Vec<String>,

    #[command(flatten)]
    history: HistoryArgs,

    /// Print JSON: the result as `simulate --json` prints it, and the columns that differ from the row; with --set the
    /// changes and the row instead
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let is_known = args.sample.is_some() || args.worst.is_some();
    let (directory, given) = sample_words::read("replay", &args.words, is_known, None)?;
    let asked = match (given, args.sample, &args.worst) {
        (Some(first), Some(second), _) => return Err(SampleError::Samples { first, second }.into()),
        (Some(first), _, Some(column)) => {
            return Err(SampleError::SampleAndWorst { first, column: column.clone() }.into());
        }
        (given, sample, _) => given.or(sample),
    };
    if row_files(&directory).is_empty() {
        return Err(CliError::no_results(&directory));
    }
    let (table, path, sample) = read_current(&directory, row_files, |files| {
        refuse_changed(&directory)?;
        find((asked, args.worst.as_deref()), &directory, files)
    })??;
    let other = other_numerics(&read_metadata(&path)?);
    let (mut solver, params) = solver_of(&directory, &table, &path)?;
    let what = || format!("computing the matrices of sample {sample}");
    let mut prepare = || solver.prepare(&params).map(drop);
    if args.json { prepare() } else { with_word(what, prepare) }.map_err(ReplayError::Solver)?;
    if !args.set.is_empty() {
        let named = names(&directory);
        return changed(args, &named, &mut solver, &params, &table, (sample, &path));
    }
    let (machine, structure) = solver.prepare(&params).map_err(ReplayError::Solver)?;
    let step = engine::time_step(&machine, structure)?;
    let history = args.history.settings(&machine, &step)?;
    let (outcome, history) = watched(&machine, structure, history.as_ref(), !args.json)?;
    let columns = engine::columns(&machine);
    let view = OutcomeView { columns: &columns, outcome: &outcome };
    let compared = compared(&table, &machine, &outcome);
    if args.json {
        let mut object = head(sample, &path);
        compared.add_to(&mut object);
        object.raw("result", simulate::json(&machine, view).trim_end());
        print_json(&object.finish())?;
    } else {
        tell(&format!("{:<32} {sample} of {}\n", "sample", shown(&path)))?;
        tell(&describe_outcome(&machine, view))?;
    }
    for note in bearing_remarks(&machine, structure, step.step).iter().chain(&history) {
        remark(note);
    }
    if !args.json {
        tell(&compared.text())?;
    }
    match other {
        _ if compared.differences.is_empty() => Ok(Exit::Ok),
        // expected, not a bug
        Some(other) => {
            remark(&format!("note: {other}, so differences are expected"));
            Ok(Exit::Failures)
        }
        None => Ok(Exit::Bug),
    }
}

/// The difference in numerics between the program that computed a row and this one; `None`: no difference.
fn other_numerics(metadata: &[(String, String)]) -> Option<String> {
    let of_table = |key: &str| metadata.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str());
    let own = [
        ("bladeoff.numerics_version", "numerics version", NUMERICS_VERSION.to_string()),
        ("bladeoff.exponential_revision", "revision of the exponential engine", EXPONENTIAL_REVISION.to_string()),
    ];
    own.into_iter().find_map(|(key, name, own)| {
        let found = of_table(key).filter(|found| *found != own)?;
        Some(format!("the row was computed with {name} {found}, and this program has {own}"))
    })
}

/// Computes a sample again and keeps its largest values over time, for the page of `report`. Prints nothing.
pub(super) fn computed_again(directory: &Path, sample: u64) -> Result<Computed, CliError> {
    let rows = read_current(directory, row_files, |files| Table::row(files, sample))?;
    let (row, path) = rows.ok_or_else(|| CliError::no_results(directory))?;
    let (mut solver, params) = solver_of(directory, &row, &path)?;
    let (mut machine, structure) = solver.prepare(&params).map_err(ReplayError::Solver)?;
    let time_step = engine::resolve_step(&mut machine, structure, &mut NoHistory)?;
    let mut envelope = Envelope::new(&machine, time_step.step);
    let outcome = engine::simulate_watched(&machine, structure, &mut envelope)?;
    let found = compared(&row, &machine, &outcome);
    let differs = (!found.differences.is_empty()).then(|| {
        format!(
            "This run differs from its row in {} of {} columns: the directory is of another version of the program, or was changed. `bladeoff replay` lists \
             the differences.",
            found.differences.len(),
            found.columns
        )
    });
    Ok(Computed { machine, envelope, differs })
}

/// The solver of a directory, and the parameters of one of its rows.
fn solver_of(directory: &Path, row: &Table, path: &Path) -> Result<(CoreSolver, Vec<f64>), CliError> {
    let hash = read_metadata(path)?.into_iter().find(|(key, _)| key == "bladeoff.plan_blake3").map(|(_, hash)| hash);
    let hash = hash.ok_or_else(|| ReplayError::NoPlan { table: path.to_path_buf() })?;
    let job = match JobSpec::read(directory, &hash).map_err(ReplayError::Plan)? {
        JobSpec::Machine(job) => job,
        JobSpec::Function(_) => return Err(ReplayError::Function { directory: directory.to_path_buf() }.into()),
    };
    let solver = CoreSolver::new(&job).map_err(ReplayError::Solver)?;
    let params = parameters(&job, &solver, &columns_by_path(directory), row, path)?;
    Ok((solver, params))
}

/// Sample and table, with which every JSON object of this command begins.
fn head(sample: u64, table: &Path) -> JsonObject {
    let mut object = JsonObject::default();
    object.raw("sample", &sample.to_string());
    object.word("table", Some(&shown(table)));
    object
}

/// The sample with the values of `--set`, compared with its row.
fn changed(
    args: &Args,
    named: &StudyNames,
    solver: &mut CoreSolver,
    params: &[f64],
    row: &Table,
    (sample, path): (u64, &Path),
) -> Result<Exit, CliError> {
    let mut sets = Vec::new();
    let prepared = solver.prepare_changed(params, |machine| change(machine, &args.set, named, &mut sets));
    let (machine, structure) = prepared.map_err(|unchanged| match unchanged {
        Unchanged::Argument(error) => error,
        Unchanged::Solver(SolverError::Machine(problems)) => {
            let given = args.set.iter().map(|argument| format!("--set {}", call::word(argument)));
            refused(problems, &given.collect::<Vec<_>>())
        }
        Unchanged::Solver(error) => ReplayError::Solver(error).into(),
    })?;
    let (outcome, _) = watched(&machine, structure, None, !args.json)?;
    if args.json {
        let columns = engine::columns(&machine);
        let fields = TableSchema::new(Vec::new(), &columns);
        let mut object = head(sample, path);
        let sets = sets.iter().map(|set| json!({ "path": set.path, "now": set.now, "row": set.before }));
        object.raw("set", pretty(&sets.collect()).trim_end());
        object.raw("row", json::row(row, &Table::names_in(path)?, fields.fields()).trim_end());
        let view = OutcomeView { columns: &columns, outcome: &outcome };
        object.raw("result", simulate::json(&machine, view).trim_end());
        print_json(&object.finish())?;
        return Ok(Exit::Ok);
    }
    if let Some(note) = kept(named, &sets.iter().map(|set| set.path.as_str()).collect::<Vec<_>>()) {
        remark(&note);
    }
    let lines = sets.iter().map(|set| format!("{:<32} {} = {}, in the row {}\n", "set", set.path, set.now, set.before));
    let lines: String = lines.collect();
    tell(&format!("{:<32} {sample} of {}\n{lines}{}", "sample", shown(path), beside(row, &machine, &outcome)))?;
    Ok(Exit::Ok)
}

/// A note on the parameters that formulas of the study computed: a change of an input does not change them.
fn kept(named: &StudyNames, set: &[&str]) -> Option<String> {
    let kept: Vec<&str> = named.derived.iter().map(String::as_str).filter(|path| !set.contains(path)).collect();
    (!kept.is_empty()).then(|| {
        format!("note: derived parameters keep the values of the row; --set changes each alone: {}", kept.join(", "))
    })
}

/// The requested row, its file and its sample.
fn find(
    (asked, column): (Option<u64>, Option<&str>),
    directory: &Path,
    files: &[PathBuf],
) -> Result<Result<(Table, PathBuf, u64), CliError>, TableError> {
    let Some(table) = files.first() else {
        return Ok(Err(CliError::no_results(directory)));
    };
    if is_of_formulas(table)? {
        return Ok(Err(ReplayError::Function { directory: directory.to_path_buf() }.into()));
    }
    let sample = match (asked, column) {
        (Some(sample), _) => sample,
        (None, Some(column)) => match worst(files, table, column)? {
            Ok(sample) => sample,
            Err(error) => return Ok(Err(error.into())),
        },
        (None, None) => {
            let mut numbers = Vec::new();
            Table::for_each_piece(files, &["sample"], |piece| {
                numbers.extend(piece.numbers("sample").into_iter().flatten().flatten().map(|number| *number as u64));
                Ok(())
            })?;
            let last = numbers.iter().copied().max().unwrap_or(0);
            let example = numbers.get(numbers.len() / 2).copied().unwrap_or(0);
            return Ok(Err(ReplayError::Which { directory: directory.to_path_buf(), example, last }.into()));
        }
    };
    if let Some((row, path)) = Table::row(files, sample)? {
        return Ok(Ok((row, path, sample)));
    }
    let directory = directory.to_path_buf();
    if let Some(count) = frozen(&directory).ok().map(|samples| samples.count()).filter(|count| sample >= *count) {
        return Ok(Err(SampleError::Sample { directory, sample, count }.into()));
    }
    let rows = Table::count_rows(files)?;
    let table = directory.join(if table.ends_with(RESULTS) { RESULTS } else { PARTS });
    Ok(Err(SampleError::NoRow { directory, table, sample, rows }.into()))
}

/// The sample with the largest value of a column; the first one if several are equal.
fn worst(files: &[PathBuf], table: &Path, column: &str) -> Result<Result<u64, ReplayError>, TableError> {
    let names = Table::number_names_in(table)?;
    let mut best: Option<(f64, u64)> = None;
    let mut is_there = true;
    Table::for_each_piece(files, &["sample", "status", column], |piece| {
        let (Some(samples), Some(values)) = (piece.numbers("sample"), piece.numbers(column)) else {
            is_there = false;
            return Ok(());
        };
        let status = piece.words("status").unwrap_or_default();
        for ((sample, value), status) in samples.iter().zip(values).zip(status) {
            let (Some(sample), Some(value), Some("ok")) = (sample, *value, status.as_deref()) else { continue };
            let sample = *sample as u64;
            if best.is_none_or(|(most, first)| value > most || value == most && sample < first) {
                best = Some((value, sample));
            }
        }
        Ok(())
    })?;
    let (table, column) = (table.to_path_buf(), column.to_owned());
    if !is_there {
        if Table::names_in(&table)?.contains(&column) {
            return Ok(Err(ReplayError::Words { table, column }));
        }
        let likeness = |name: &String| strsim::jaro_winkler(name, &column);
        let nearest = names.into_iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
        let nearest = nearest.filter(|name| likeness(name) > 0.7);
        return Ok(Err(ReplayError::Column { table, column, nearest }));
    }
    Ok(best.map(|(_, sample)| sample).ok_or(ReplayError::Empty { table, column }))
}

/// Columns whose name differs from that of their parameter: a study may give short names (`as`), which the plan does not contain.
fn columns_by_path(directory: &Path) -> BTreeMap<String, String> {
    let Ok(samples) = frozen(directory) else { return BTreeMap::new() };
    samples.parameters().iter().map(|given| (given.info.path.clone(), given.column().name)).collect()
}

/// Names that the study gives to its parameters, and its variables of formulas.
fn names(directory: &Path) -> StudyNames {
    let mut names = StudyNames::default();
    for given in frozen(directory).iter().flat_map(|samples| samples.parameters()) {
        if matches!(given.origin, Origin::Derived(_)) && !given.is_variable {
            names.derived.push(given.info.path.clone());
        }
        match &given.short {
            _ if given.is_variable => names.variables.push(given.info.path.clone()),
            Some(short) => names.parameters.push((short.clone(), given.info.path.clone())),
            None => {}
        }
    }
    names
}

/// The parameters of a row, in the form that a worker receives.
fn parameters(
    job: &MachineJob,
    solver: &CoreSolver,
    named: &BTreeMap<String, String>,
    row: &Table,
    path: &Path,
) -> Result<Vec<f64>, ReplayError> {
    let missing = |name: &str| ReplayError::Parameter { table: path.to_path_buf(), path: name.to_owned() };
    job.varied
        .iter()
        .zip(solver.parameter_columns())
        .map(|(varied, column)| match &varied.choices {
            None => {
                let column = named.get(&varied.path).unwrap_or(&column);
                row.numbers(column).and_then(|values| values[0]).ok_or_else(|| missing(&varied.path))
            }
            Some(choices) => {
                let named = named.get(&varied.path).unwrap_or(&varied.path);
                let name = if is_detection(&varied.path) { DETECTION } else { named.as_str() };
                let word =
                    row.words(name).and_then(|words| words[0].as_deref()).ok_or_else(|| missing(&varied.path))?;
                let at = choices.iter().position(|choice| choice == word).ok_or_else(|| missing(&varied.path))?;
                Ok(at as f64)
            }
        })
        .collect()
}

/// A column whose value differs from that of the row.
struct Difference {
    column: String,
    now: Option<String>,
    row: Option<String>,
}

/// Result of a comparison with the row.
struct Compared {
    columns: usize,
    differences: Vec<Difference>,
    /// Reason why nothing is compared.
    nothing: Option<String>,
}

impl Compared {
    fn text(&self) -> String {
        if let Some(why) = &self.nothing {
            return format!("\n{why}\n");
        }
        if self.differences.is_empty() {
            return format!("\nequal to the row in all {} columns, bit for bit\n", self.columns);
        }
        let shown = |value: &Option<String>| value.clone().unwrap_or_else(|| "null".to_owned());
        let line = |found: &Difference| {
            format!("  {}: {} now, {} in the row\n", found.column, shown(&found.now), shown(&found.row))
        };
        let lines: String = self.differences.iter().map(line).collect();
        format!("\ndifferent from the row in {} of {} columns\n{lines}", self.differences.len(), self.columns)
    }

    fn add_to(&self, object: &mut JsonObject) {
        object.raw("compared", &self.columns.to_string());
        let difference = |found: &Difference| json!({ "column": found.column, "now": found.now, "row": found.row });
        object.raw("differences", pretty(&self.differences.iter().map(difference).collect()).trim_end());
        object.word("nothing_compared", self.nothing.as_deref());
    }
}

/// Compares the outcome with the row, column by column.
fn compared(row: &Table, machine: &Machine, outcome: &Outcome) -> Compared {
    let cause = row.words("cause").and_then(|words| words[0].as_deref()).and_then(Cause::from_word);
    if let Some(cause) = cause.filter(|cause| !cause.is_deterministic()) {
        let why = format!("the row is {}: it has no values to compare", cause.word());
        return Compared { columns: 0, differences: Vec::new(), nothing: Some(why) };
    }
    let mut differences = Vec::new();
    let mut compared = 0;
    let word = |name: &str| row.words(name).and_then(|words| words[0].clone());
    let mut compare = |name: &str, now: Option<String>, row: Option<String>| {
        compared += 1;
        if now != row {
            differences.push(Difference { column: name.to_owned(), now, row });
        }
    };
    compare("status", Some(outcome.status.word().to_owned()), word("status"));
    compare("cause", outcome.cause.map(|cause| cause.word().to_owned()), word("cause"));
    compare("causes", outcome.causes.words(), word("causes"));
    compare(NOTES, outcome.notes.words(), word(NOTES));
    compare("end_cause", Some(outcome.end_cause.word().to_owned()), word("end_cause"));
    compare(ENGINE, Some(machine.run.engine.word().to_owned()), word(ENGINE));
    let columns = engine::columns(machine);
    let schema = TableSchema::new(Vec::new(), &columns);
    for (field, value) in schema.outcome().iter().zip(&outcome.values) {
        let text = |value: f64| format!("{value:?}");
        match row.numbers(&field.name) {
            Some(values) => compare(&field.name, value.map(text), values[0].map(text)),
            None => compare(
                &field.name,
                value.and_then(|value| field.kind.word(value)).map(str::to_owned),
                word(&field.name),
            ),
        }
    }
    Compared { columns: compared, differences, nothing: None }
}
