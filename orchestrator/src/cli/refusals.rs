//! Errors of commands on result directories.

use bladeoff_answers::compare::CompareError;
use bladeoff_answers::summary::counted;
use bladeoff_answers::tables::TableError;
use bladeoff_study::{StudyError, meant};
use bladeoff_system::call;
use bladeoff_system::shown;
use bladeoff_worker::core_solver::SolverError;
use bladeoff_worker::job_spec::JobSpecError;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// No result directory is given, and there is no default one.
#[derive(Debug, thiserror::Error)]
#[error("there is no result directory here nor below runs/; name one")]
pub struct NoDirectory;

/// A study without questions or gates.
#[derive(Debug, thiserror::Error)]
pub enum NotAsked {
    /// A study file without questions.
    #[error(
        "{} asks no question; a [[question]] in a study file does, and `--study FILE` takes those of another file",
        shown(file)
    )]
    Questions {
        /// Path of the study file.
        file: PathBuf,
    },
    /// A study file without gates, and no `--require`.
    #[error(
        "no gate: {} has none, and no --require is given; such as\n  {}",
        shown(file),
        call::command([
            OsStr::new("gate"),
            call::path_word(directory).as_os_str(),
            OsStr::new("--require"),
            OsStr::new(example)
        ])
    )]
    Gates {
        /// Path of the study file.
        file: PathBuf,
        /// Path of the result directory.
        directory: PathBuf,
        /// An example of a gate for this study.
        example: String,
    },
}

/// Reason why a design cannot be exported.
#[derive(Debug, thiserror::Error)]
pub enum DesignExportError {
    /// A study without a design.
    #[error("{} has no [design]: there are no random points to write", shown(path))]
    None {
        /// Path of the study file or result directory.
        path: PathBuf,
    },
    /// A response that is not a result of the study.
    #[error("--response {column}: {why}")]
    Response {
        /// Name of the column.
        column: String,
        /// Description of the error.
        why: String,
    },
}

/// Reason why two tables cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum NotCompared {
    /// A path that does not exist.
    #[error("{} does not exist; allowed: a result directory or a result table{}", shown(path), meant(path))]
    Missing {
        /// The path.
        path: PathBuf,
    },
    /// A file that is not a result table.
    #[error("{} is no result table", shown(path))]
    NoTable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the table reader.
        #[source]
        source: TableError,
    },
    /// An error of the comparison.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// Files that were replaced during every attempt to read them.
    #[error("the tables were replaced while they were read, several times: a run is writing them")]
    Changing,
}

/// Reason why a command line has no valid sample number.
#[derive(Debug, thiserror::Error)]
pub enum SampleError {
    /// A word that is not a number.
    #[error(
        "{word:?} is not the number of a sample: samples are numbered from 0, as in the column `sample` of the table"
    )]
    Number {
        /// Word of the command line.
        word: String,
    },
    /// Two directories on one command line.
    #[error("the directory is given twice: {} and {}", shown(first), shown(second))]
    Twice {
        /// Directory before the sample.
        first: PathBuf,
        /// Directory of `--dir`.
        second: PathBuf,
    },
    /// A sample number before the directory.
    #[error("the directory comes first: {}", sample_command(command, directory, sample))]
    Order {
        /// Name of the command.
        command: &'static str,
        /// Path of the directory.
        directory: PathBuf,
        /// The number.
        sample: String,
    },
    /// A file instead of a directory.
    #[error(
        "{} is a file, not a result directory{}",
        shown(file),
        meant.as_ref().map(|meant| format!("; its directory is {}", shown(meant))).unwrap_or_default()
    )]
    File {
        /// Path of the file.
        file: PathBuf,
        /// Result directory of the table, if the file is one.
        meant: Option<PathBuf>,
    },
    /// Two sample numbers on one command line.
    #[error("the sample is given twice: {first} and --sample {second}")]
    Samples {
        /// Number after the directory.
        first: u64,
        /// Number of `--sample`.
        second: u64,
    },
    /// A sample number and `--worst`.
    #[error("the sample is given twice: {first} and --worst {column}")]
    SampleAndWorst {
        /// Number after the directory.
        first: u64,
        /// Column of `--worst`.
        column: String,
    },
    /// No sample number.
    #[error(
        "which sample of {}? its samples are 0 to {}; for example: {}",
        shown(directory),
        count - 1,
        sample_command("why", directory, &(count / 2).to_string())
    )]
    Which {
        /// Path of the directory.
        directory: PathBuf,
        /// Number of samples of the study.
        count: u64,
    },
    /// A sample number outside the study.
    #[error("the study in {} has no sample {sample}; its samples are 0 to {}", shown(directory), count - 1)]
    Sample {
        /// Path of the directory.
        directory: PathBuf,
        /// The number.
        sample: u64,
        /// Number of samples of the study.
        count: u64,
    },
    /// A sample without a row in the table.
    #[error(
        "sample {sample} has no row in {}, which has {}; its state: {}",
        shown(table),
        counted(*rows as u64, "row"),
        sample_command("why", directory, &sample.to_string())
    )]
    NoRow {
        /// Path of the directory.
        directory: PathBuf,
        /// Path of the table, or of the folder of its parts.
        table: PathBuf,
        /// The number.
        sample: u64,
        /// Number of rows of the table.
        rows: usize,
    },
}

/// Command for a sample.
fn sample_command(command: &str, directory: &Path, sample: &str) -> String {
    call::command([OsStr::new(command), call::path_word(directory).as_ref(), OsStr::new(sample)])
}

/// Reason why a sample cannot be described.
#[derive(Debug, thiserror::Error)]
pub enum WhyError {
    /// A run that has not yet written its study to the directory.
    #[error("the run in {} is starting: its study is not written yet", shown(directory))]
    Beginning {
        /// Path of the directory.
        directory: PathBuf,
    },
    /// A frozen study that cannot be read.
    #[error(
        "the frozen study in {} can no longer be read{}",
        shown(directory),
        again.as_ref().map(|command| format!("; this writes it there again: {command}")).unwrap_or_default()
    )]
    Frozen {
        /// Path of the directory.
        directory: PathBuf,
        /// Command that restores a missing study.
        again: Option<String>,
        /// Error of the study.
        #[source]
        source: StudyError,
    },
}

/// Reason why a sample cannot be recomputed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// Neither a sample number nor a column.
    #[error(
        "which sample of {}? its samples are up to {last}; --worst COLUMN selects the one with the largest value; for example:\n  {}\n  {}",
        shown(directory),
        sample_command("replay", directory, &example.to_string()),
        replay(directory, "--worst", "max_bearing_load_N")
    )]
    Which {
        /// Path of the directory.
        directory: PathBuf,
        /// Number of an example sample.
        example: u64,
        /// Number of the last sample.
        last: u64,
    },
    /// A column that does not exist or is not numeric.
    #[error("{} has no column {column:?} of numbers{}", shown(table), nearest.as_ref().map(|name| format!("; did you mean {name}?")).unwrap_or_default())]
    Column {
        /// Path of the table.
        table: PathBuf,
        /// The name.
        column: String,
        /// Nearest column name.
        nearest: Option<String>,
    },
    /// A column of words, which has no largest value.
    #[error(
        "`{column}` is a column of words, not of numbers ({}); allowed: --worst with a column of numbers",
        shown(table)
    )]
    Words {
        /// Path of the table.
        table: PathBuf,
        /// Name of the column.
        column: String,
    },
    /// A column without values in ok rows.
    #[error("no row of {} that is ok has a value in {column}", shown(table))]
    Empty {
        /// Path of the table.
        table: PathBuf,
        /// Name of the column.
        column: String,
    },
    /// A table without the hash of its plan.
    #[error("{} does not name the plan it was computed from", shown(table))]
    NoPlan {
        /// Path of the table.
        table: PathBuf,
    },
    /// A formula study, which has no transients.
    #[error(
        "replay computes a transient again: the study in {} has model = \"function\" and has rows only (`why`, `export`)",
        shown(directory)
    )]
    Function {
        /// Path of the directory.
        directory: PathBuf,
    },
    /// An error of the plan.
    #[error(transparent)]
    Plan(#[from] JobSpecError),
    /// An error of the solver.
    #[error("the sample cannot be computed")]
    Solver(#[from] SolverError),
    /// A parameter of the plan without a column in the table.
    #[error("{} has no column for the parameter {path}", shown(table))]
    Parameter {
        /// Path of the table.
        table: PathBuf,
        /// Path of the parameter.
        path: String,
    },
}

fn replay(directory: &Path, option: &str, value: &str) -> String {
    let directory = call::path_word(directory);
    let words: [&OsStr; 4] = ["replay".as_ref(), directory.as_ref(), option.as_ref(), value.as_ref()];
    call::command(words)
}
