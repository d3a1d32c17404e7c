//! `bladeoff why`: everything recorded about one sample.

use super::error::CliError;
use super::exit::Exit;
use super::json::{JsonObject, number, pretty};
use super::output::{print_json, tell};
use super::refusals::{SampleError, WhyError};
use super::sample_words;
use crate::engine;
use crate::engine_choice::as_planned;
use crate::run::directory::{LEDGER, MANIFEST, RESULTS, WORKER_LOG, read_current};
use crate::run::shards::{directory_status, row_files, samples_of, timing_files};
use crate::run::{
    DirectoryStatus, RunState, TableEnd, end_of_table, function_columns, own_columns, refuse_changed,
    refuse_changed_timings,
};
use crate::terminal::{
    BACKWARD, Change, Ran, advice, broken_by, cause_in_words, describe_values, diverged_at, end_cause_in_words,
    exceeded_at, exceeded_by, mentions, ok_in_words, step_key,
};
use bladeoff_answers::summary::duration;
use bladeoff_answers::summary::{are, counted};
use bladeoff_answers::tables::{Table, TableError, TableSchema, Timing};
use bladeoff_model::machine::{ContactPoints, Detection, Diaphragm, Engine, Machine, ParamValue, TWIN};
use bladeoff_model::outcome::{Cause, CauseSet, Column, ColumnKind, EndCause, Status};
use bladeoff_study::{FrozenFiles, InputError, Samples, StudyError, load_frozen, show};
use bladeoff_system::call;
use bladeoff_system::place::Place;
use bladeoff_system::shown;
use bladeoff_text::document::units::{format_digits, format_quantity};
use bladeoff_text::document::visible;
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Largest number of lines of the workers' log that are shown.
const SHOWN_LINES: usize = 20;
/// Largest manifest that is read \[bytes\].
const MOST_MANIFEST: u64 = 16 << 20;
/// Length of the end of the workers' log that is searched \[bytes\]; one run writes at most 16 MB.
const MOST_LOG: u64 = 64 << 20;

/// Print everything recorded about one sample
///
/// Parameters, status, cause with its meaning and advice, end of the run, worker and attempts, lines of the workers' log,
/// the command that computes the sample again, and the results as `simulate` prints them.
///
/// Without a directory the current one is used if it contains a study, otherwise the newest one below runs/. The output
/// names it.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "bladeoff why [DIRECTORY] SAMPLE\n       bladeoff why DIRECTORY#SAMPLE\n       bladeoff why SAMPLE --dir DIRECTORY",
    after_help = "Examples:
  bladeoff why 17
  bladeoff why runs/first-look 17
  bladeoff why 17 --dir runs/first-look
  bladeoff why 17 --json | jq .row.max_bearing_load_N"
)]
pub struct Args {
    /// Sample number, as in the column `sample`, optionally after a result directory
    #[arg(value_name = "SAMPLE", required = true, num_args = 1..=2, allow_negative_numbers = true)]
    words: Vec<String>,

    /// Result directory of the study
    #[arg(long, value_name = "DIRECTORY")]
    dir: Option<PathBuf>,

    /// Print JSON: parameters in SI, the printed lines with their names, and all columns of the row or null
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let (directory, sample) = sample_words::read("why", &args.words, false, args.dir.as_deref())?;
    let Some(sample) = sample else { return Err(which(&directory)) };
    let known = known(&directory, sample)?;
    if args.json {
        print_json(&as_json(&known, &directory, sample)?)?;
    } else {
        tell(&known.text())?;
    }
    Ok(Exit::Ok)
}

/// Error of a missing sample number, or of a directory without samples.
fn which(directory: &Path) -> CliError {
    let samples = match directory_status(directory) {
        Ok(Some(_)) => frozen(directory),
        Ok(None) => Err(CliError::NotARun { path: directory.to_path_buf() }),
        Err(error) => Err(error.into()),
    };
    match samples {
        Ok(samples) => SampleError::Which { directory: directory.to_path_buf(), count: samples.count() }.into(),
        Err(error) => error,
    }
}

/// Everything recorded about a sample, as text.
///
/// # Errors
/// There is no such directory or sample, or files of the directory cannot be read.
pub fn text(directory: &Path, sample: u64) -> Result<String, CliError> {
    Ok(known(directory, sample)?.text())
}

/// Everything recorded about a sample.
struct Known {
    lines: Lines,
    samples: Samples,
    machine: Option<Machine>,
    row: Option<(Table, PathBuf)>,
}

impl Known {
    fn text(&self) -> String {
        let lines = self.lines.0.iter().map(|(name, text)| format!("{name:<32} {text}\n"));
        let values = self.row.as_ref().map(|(row, _)| values(row, &self.samples, self.machine.as_ref()));
        lines.collect::<String>() + &values.unwrap_or_default()
    }
}

fn as_json(known: &Known, directory: &Path, sample: u64) -> Result<String, CliError> {
    let mut object = JsonObject::default();
    object.raw("sample", &sample.to_string());
    object.raw("samples", &known.samples.count().to_string());
    object.word("directory", Some(&shown(directory)));
    let mut parameters = JsonObject::default();
    for (varied, value) in known.samples.parameters().iter().zip(known.samples.values(sample)) {
        match value {
            ParamValue::Number(value) => parameters.raw(&varied.info.path, &number(value)),
            ParamValue::Choice(word) => parameters.word(&varied.info.path, Some(&word)),
        }
    }
    object.raw("parameters", parameters.finish().trim_end());
    let lines: Vec<Value> = known.lines.0.iter().map(|(name, text)| json!({ "name": name, "text": text })).collect();
    object.raw("lines", pretty(&lines.into()).trim_end());
    let columns = columns(&known.samples, known.machine.as_ref()).unwrap_or_default();
    let row = match &known.row {
        None => "null".to_owned(),
        Some((row, path)) => {
            let fields = TableSchema::new(Vec::new(), &columns);
            super::json::row(row, &Table::names_in(path)?, fields.fields())
        }
    };
    object.raw("row", row.trim_end());
    Ok(object.finish())
}

/// Collects the data of a sample.
fn known(directory: &Path, sample: u64) -> Result<Known, CliError> {
    let seen = directory_status(directory)?.ok_or_else(|| CliError::NotARun { path: directory.to_path_buf() })?;
    let samples = frozen(directory)?;
    if sample >= samples.count() {
        return Err(SampleError::Sample { directory: directory.to_path_buf(), sample, count: samples.count() }.into());
    }
    let mut lines = Lines::default();
    lines.push("sample", format!("{sample} of {} in {}", samples.count(), shown(directory)));
    for (varied, value) in samples.parameters().iter().zip(samples.values(sample)) {
        lines.push(&varied.info.path, show(&varied.info, &value));
    }
    for (name, value) in samples.extra_columns(sample) {
        match value {
            Some(ParamValue::Number(number)) => lines.push(name, format!("{number:?}")),
            Some(ParamValue::Choice(word)) => lines.push(name, word),
            None => lines.push(name, "-"),
        }
    }
    if let Some(twin) = twin(&samples, sample) {
        lines.push(TWIN, twin);
    }
    let resume = resume_command(&seen);
    let row = read_current(directory, row_files, |files| {
        refuse_changed(directory)?;
        Table::row(files, sample)
    })?;
    let machine = samples.try_machine(sample).ok().flatten().and_then(|machine| machine.build().ok());
    match row.as_ref().map(|(row, _)| row) {
        Some(row) if samples.study().function().is_some() && is_not_finite(row) => {
            lines.push("status", "failed: a formula gave no finite number (non_finite); what the others gave is kept");
        }
        Some(row) => finished(&mut lines, row, machine.as_ref(), (directory, sample, resume.as_deref())),
        None if let Some(end) = end_before(directory, sample) => {
            let words = end.words(&samples);
            let why = if end.is_chosen() { "not among those of the table" } else { "beyond the end of the table" };
            lines.push("status", format!("{why}: {words}; it may be in the record, but has no row"));
        }
        None => {
            lines.push("status", unfinished(&seen.state, seen.last_report.as_ref(), sample, resume.as_deref()));
        }
    }
    timing(&mut lines, directory, sample);
    log(&mut lines, directory, sample);
    // the study computes samples without a row
    if row.is_some() && samples.study().function().is_none() {
        lines.push("compute it", compute_it(directory, sample));
    }
    Ok(Known { lines, samples, machine, row })
}

/// End of the table, if it is before this sample.
fn end_before(directory: &Path, sample: u64) -> Option<TableEnd> {
    let end = end_of_table(&directory.join(RESULTS)).ok().flatten();
    // samples that [refine] has not chosen have any number
    end.filter(|end| sample >= end.samples || end.is_chosen())
}

/// Text on `run.twin` of a sample with a twin, unless it varies and is shown as a parameter.
fn twin(samples: &Samples, sample: u64) -> Option<String> {
    if samples.parameters().iter().any(|varied| varied.info.path == TWIN) {
        return None;
    }
    let shift = samples.twin(sample).unwrap_or_else(|| samples.study().shift());
    (shift != 0.0).then(|| format!("{} (a second run starts by this part faster)", format_digits(shift, "", 6)))
}

/// The command that recomputes a sample with its history.
fn compute_it(directory: &Path, sample: u64) -> String {
    let (number, history) = (sample.to_string(), format!("sample-{sample}.mcap"));
    let directory = call::path_word(directory);
    let words: [&OsStr; 6] = [
        "replay".as_ref(),
        directory.as_ref(),
        "--sample".as_ref(),
        number.as_ref(),
        "--history".as_ref(),
        history.as_ref(),
    ];
    call::command(words)
}

/// The outcome as `simulate` prints it; empty for a row without values or a machine that cannot be built.
fn values(row: &Table, samples: &Samples, machine: Option<&Machine>) -> String {
    let Some(columns) = columns(samples, machine) else { return String::new() };
    let value = |name: &str, kind: ColumnKind| match kind {
        ColumnKind::Choice(words) => {
            let word = row.words(name).and_then(|words| words[0].clone())?;
            words.iter().position(|known| *known == word).map(|at| at as f64)
        }
        ColumnKind::Real | ColumnKind::Count => row.numbers(name).and_then(|values| values[0]),
    };
    let values: Vec<Option<f64>> = columns.iter().map(|column| value(&column.name, column.kind)).collect();
    if values.iter().all(Option::is_none) {
        return String::new();
    }
    describe_values(&columns, &values)
}

/// Columns of the values; `None` if the machine cannot be built.
fn columns(samples: &Samples, machine: Option<&Machine>) -> Option<Vec<Column>> {
    samples.study().function().map(function_columns).or_else(|| machine.map(engine::columns))
}

fn causes(row: &Table) -> Vec<Cause> {
    words_of(row, "causes")
}

/// Causes in a column of words joined by commas.
fn words_of(row: &Table, column: &str) -> Vec<Cause> {
    let words = row.words(column).and_then(|words| words[0].as_deref()).unwrap_or_default();
    words.split(',').filter_map(Cause::from_word).collect()
}

/// Lines with a name and a text.
#[derive(Default)]
struct Lines(Vec<(String, String)>);

impl Lines {
    fn push(&mut self, name: &str, text: impl AsRef<str>) {
        self.0.push((name.to_owned(), visible(text.as_ref()).into_owned()));
    }
}

/// The study as frozen in the directory, with the part of it that was run.
pub(super) fn frozen(directory: &Path) -> Result<Samples, CliError> {
    if let Some(samples) = samples_of(directory)? {
        return Ok(samples);
    }
    let failed = |source| unread(directory, source);
    let mut study = load_frozen(FrozenFiles::of(directory), own_columns).map_err(failed)?;
    as_planned(&mut study, directory);
    let manifest: Value = Place::from(&directory.join(MANIFEST))
        .read(MOST_MANIFEST)
        .ok()
        .and_then(|text| serde_json::from_slice(&text).ok())
        .unwrap_or_default();
    Ok(Samples::new(study, manifest["scale"].as_f64(), manifest["limit"].as_u64()).map_err(failed)?)
}

/// Error for a missing frozen study: the run has not written it yet, or it was removed.
fn unread(directory: &Path, source: StudyError) -> WhyError {
    let seen = directory_status(directory).ok().flatten();
    // the record is created after all inputs are written
    let is_beginning = !directory.join(LEDGER).exists();
    let is_gone = matches!(source, StudyError::Input(InputError::Missing { .. }));
    let directory = directory.to_path_buf();
    match seen {
        Some(seen) if is_beginning && matches!(seen.state, RunState::Running { .. }) => {
            WhyError::Beginning { directory }
        }
        seen => WhyError::Frozen {
            directory,
            again: seen.filter(|_| is_gone).and_then(|seen| resume_command(&seen)),
            source,
        },
    }
}

/// The command that resumes the study of a directory.
pub(super) fn resume_command(seen: &DirectoryStatus) -> Option<String> {
    seen.last_report.as_ref()?.get("resume").and_then(Value::as_str).map(str::to_owned)
}

/// The command that recomputes a sample with a changed machine and prints both rows; `None` if the step of the run is unknown.
fn try_it(machine: &Machine, directory: &Path, sample: u64, change: Change) -> Option<String> {
    let set = match change {
        // the record does not contain which of several contacts is meant
        Change::Set(path, _) if path.starts_with("contact.") && machine.diaphragms.len() > 1 => return None,
        // other engines have no contact step, and a command cannot remove a key
        Change::Set("run.engine", _) if machine.run.contact_step.is_some() => return None,
        Change::Set(path, value) => format!("{path}={value}"),
        Change::Step(ratio) => {
            let structure = engine::build(machine).ok()?;
            let step = engine::time_step(machine, &structure).ok()?.step * ratio;
            format!("{}={}", step_key(machine.run.engine), format_digits(step, "s", 3))
        }
    };
    let (number, directory) = (sample.to_string(), call::path_word(directory));
    let words: [&OsStr; 6] =
        ["replay".as_ref(), directory.as_ref(), "--sample".as_ref(), number.as_ref(), "--set".as_ref(), set.as_ref()];
    Some(call::command(words))
}

/// Properties of a run on which the advice depends.
fn ran(machine: Option<&Machine>, regime: Option<&str>) -> Ran {
    let has_one_point = |diaphragm: &Diaphragm| {
        diaphragm.contact.detection != Detection::Hyp2 || diaphragm.contact.points == ContactPoints::One
    };
    Ran {
        engine: machine.map_or(Engine::Reduced, |machine| machine.run.engine),
        is_backward: regime == Some(BACKWARD),
        has_one_point: machine.is_some_and(|machine| machine.diaphragms.iter().any(has_one_point)),
    }
}

fn finished(
    lines: &mut Lines,
    row: &Table,
    machine: Option<&Machine>,
    (directory, sample, resume_command): (&Path, u64, Option<&str>),
) {
    let word = |name: &str| row.words(name).and_then(|words| words[0].as_deref());
    let number = |name: &str| row.numbers(name).and_then(|values| values[0]);
    let status = word("status").unwrap_or("unknown");
    let mut notes = CauseSet::default();
    words_of(row, "notes").into_iter().for_each(|note| notes.insert(note));
    lines.push(
        "status",
        Status::from_word(status).map_or_else(|| status.to_owned(), |known| status_in_words(known, notes)),
    );
    for cause in causes(row) {
        lines.push(cause.word(), cause_in_words(cause));
        if cause == Cause::Diverged {
            lines.push("  until then", diverged_at(number).unwrap_or_default());
        }
        if let Some(broken) = machine.and_then(|machine| broken_by(cause, machine, number)) {
            lines.push("  by how much", broken);
        }
        let advised = advice(cause, ran(machine, word("rub_regime")));
        lines.push("  what to do", advised.text);
        let tried = machine.zip(advised.change);
        if let Some(command) = tried.and_then(|(machine, change)| try_it(machine, directory, sample, change)) {
            lines.push("  try it", command);
        }
        if let Some(command) = resume_command.filter(|_| !cause.is_deterministic()) {
            lines.push("  try again", format!("{command} --rerun cause={}", cause.word()));
        }
    }
    if let Some(at) = exceeded_at(causes(row).into_iter(), number) {
        lines.push("limit exceeded", at);
    }
    for note in notes.iter() {
        lines.push(note.word(), format!("noted: {}", cause_in_words(note)));
        if let Some(broken) = exceeded_by(note, number) {
            lines.push("  by how much", broken);
        }
    }
    if let Some(end) = word("end_cause").and_then(EndCause::from_word) {
        let at = number("end_time_s").map(|time| format!(" at {}", format_quantity(time, "s"))).unwrap_or_default();
        let spin = number("end_speed_rad_s").map(|spin| format!(", spin {}", format_quantity(spin, "rad/s")));
        lines.push("end", format!("{}{at}{}", end_cause_in_words(end), spin.unwrap_or_default()));
    }
}

/// Status of a row as text.
fn status_in_words(status: Status, notes: CauseSet) -> String {
    let words = match status {
        Status::Ok => return ok_in_words(notes),
        Status::Beyond => {
            "beyond the model: it exceeded a limit of the physical model; its numerical checks passed, and its largest values are lower bounds"
        }
        Status::Invalid => "invalid: it finished, but a numerical check failed; its values are kept",
        Status::Failed => "failed: it ended early; its values are those up to then",
        Status::Quarantined => "quarantined: given up after repeated deaths of its worker; it has no values",
    };
    words.to_owned()
}

fn is_not_finite(row: &Table) -> bool {
    row.words("cause").is_some_and(|words| words[0].as_deref() == Some(Cause::NonFinite.word()))
}

fn unfinished(
    state: &RunState,
    said: Option<&serde_json::Map<String, Value>>,
    sample: u64,
    resume_command: Option<&str>,
) -> String {
    let resume_command = resume_command.map(|command| format!("; resume with: {command}")).unwrap_or_default();
    match state {
        RunState::Running { .. } => {
            let workers = said.and_then(|said| said.get("workers")).and_then(Value::as_array);
            let doing = workers.into_iter().flatten().filter_map(|worker| worker["doing"].as_str());
            let here = doing.into_iter().find(|doing| mentions(doing, sample));
            let here =
                here.map_or("not finished, or too recently to be in a part of the table".to_owned(), str::to_owned);
            format!("{here}; the study is running")
        }
        RunState::Killed(_) => {
            format!(
                "not finished, or recorded by the run that was killed before it wrote a part of the table{resume_command}"
            )
        }
        RunState::Complete | RunState::Ended => format!("not finished{resume_command}"),
        RunState::Unknown { why } => {
            format!("not finished, or not yet in a part of the table; unknown whether a run is alive: {why}")
        }
    }
}

fn timing(lines: &mut Lines, directory: &Path, sample: u64) {
    let find = |files: &[PathBuf]| refuse_changed_timings(directory).and_then(|_| Timing::find(files, sample));
    match read_current(directory, timing_files, find) {
        Ok(Some(Timing { cpu_s, worker, attempt, .. })) => {
            let cpu = Duration::try_from_secs_f64(cpu_s).unwrap_or_default();
            lines.push("computed by", format!("worker {worker} in attempt {attempt}, {} of CPU time", duration(cpu)));
        }
        Ok(None) => {}
        Err(error @ TableError::Changed { .. }) => lines.push("computed by", format!("unknown: {error}")),
        // shown only as a remark beside the row
        Err(error) => lines.push("computed by", format!("unknown: {error} (the command of the study makes it again)")),
    }
}

/// Lines of the workers' log about the sample, the latest last.
fn log(lines: &mut Lines, directory: &Path, sample: u64) {
    let Ok(mut file) = Place::from(&directory.join(WORKER_LOG)).open() else { return };
    let length = file.metadata().map_or(0, |found| found.len());
    let _ = file.seek(SeekFrom::Start(length.saturating_sub(MOST_LOG)));
    let (mut shown, mut skipped) = (VecDeque::new(), 0u64);
    for line in BufReader::new(file.take(MOST_LOG)).split(b'\n').map_while(Result::ok) {
        let line = String::from_utf8_lossy(&line).into_owned();
        if mentions(&line, sample) {
            shown.push_back(line);
        }
        if shown.len() > SHOWN_LINES {
            shown.pop_front();
            skipped += 1;
        }
    }
    if skipped > 0 {
        lines.push(
            "log",
            format!(
                "{} {} in {}",
                counted(skipped, "earlier line"),
                are(skipped),
                bladeoff_system::shown(directory.join(WORKER_LOG))
            ),
        );
    }
    shown.iter().for_each(|line| lines.push("log", line));
}
