//! Why commands about a result directory do not do what is asked.

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

/// There is no result directory to take.
#[derive(Debug, thiserror::Error)]
#[error("there is no result directory here nor below runs/; name one")]
pub struct NoDirectory;

/// Why nothing is answered: nothing is asked.
#[derive(Debug, thiserror::Error)]
pub enum NotAsked {
    /// No question.
    #[error(
        "{} asks no question; a [[question]] in a study file does, and `--study FILE` takes those of another file",
        shown(file)
    )]
    Questions {
        /// The study file.
        file: PathBuf,
    },
    /// No gate.
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
        /// The study file.
        file: PathBuf,
        /// The result directory.
        directory: PathBuf,
        /// A gate that this study can have.
        example: String,
    },
}

/// Why a design is not written for other programs.
#[derive(Debug, thiserror::Error)]
pub enum DesignExportError {
    /// There is none.
    #[error("{} has no [design]: there are no random points to write", shown(path))]
    None {
        /// The study, or the result directory.
        path: PathBuf,
    },
    /// A response that the results do not have.
    #[error("--response {column}: {why}")]
    Response {
        /// The column.
        column: String,
        /// What is wrong with it.
        why: String,
    },
}

/// Why two tables are not compared.
#[derive(Debug, thiserror::Error)]
pub enum NotCompared {
    /// Nothing stands under the name.
    #[error("{} does not exist; allowed: a result directory or a result table{}", shown(path), meant(path))]
    Missing {
        /// The name.
        path: PathBuf,
    },
    /// A file that is no table.
    #[error("{} is no result table", shown(path))]
    NoTable {
        /// The file.
        path: PathBuf,
        /// What was found.
        #[source]
        source: TableError,
    },
    /// The comparison.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// Files are replaced again and again.
    #[error("the tables were replaced while they were read, several times: a run is writing them")]
    Changing,
}

/// Why a command line names no sample.
#[derive(Debug, thiserror::Error)]
pub enum SampleError {
    /// Not a number.
    #[error(
        "{word:?} is not the number of a sample: samples are numbered from 0, as in the column `sample` of the table"
    )]
    Number {
        /// Word of the command line.
        word: String,
    },
    /// Two directories.
    #[error("the directory is given twice: {} and {}", shown(first), shown(second))]
    Twice {
        /// Before the sample.
        first: PathBuf,
        /// By --dir.
        second: PathBuf,
    },
    /// The number before the directory.
    #[error("the directory comes first: {}", sample_command(command, directory, sample))]
    Order {
        /// Name of the command.
        command: &'static str,
        /// The directory.
        directory: PathBuf,
        /// The number.
        sample: String,
    },
    /// A file in place of a directory.
    #[error(
        "{} is a file, not a result directory{}",
        shown(file),
        meant.as_ref().map(|meant| format!("; its directory is {}", shown(meant))).unwrap_or_default()
    )]
    File {
        /// The file.
        file: PathBuf,
        /// Directory of a table.
        meant: Option<PathBuf>,
    },
    /// Two samples.
    #[error("the sample is given twice: {first} and --sample {second}")]
    Samples {
        /// After the directory.
        first: u64,
        /// By --sample.
        second: u64,
    },
    /// A sample and a column.
    #[error("the sample is given twice: {first} and --worst {column}")]
    SampleAndWorst {
        /// After the directory.
        first: u64,
        /// By --worst.
        column: String,
    },
    /// No sample.
    #[error(
        "which sample of {}? its samples are 0 to {}; for example: {}",
        shown(directory),
        count - 1,
        sample_command("why", directory, &(count / 2).to_string())
    )]
    Which {
        /// The directory.
        directory: PathBuf,
        /// Samples of the study.
        count: u64,
    },
    /// No such sample.
    #[error("the study in {} has no sample {sample}; its samples are 0 to {}", shown(directory), count - 1)]
    Sample {
        /// The directory.
        directory: PathBuf,
        /// The number.
        sample: u64,
        /// Samples of the study.
        count: u64,
    },
    /// A sample without a row.
    #[error(
        "sample {sample} has no row in {}, which has {}; its state: {}",
        shown(table),
        counted(*rows as u64, "row"),
        sample_command("why", directory, &sample.to_string())
    )]
    NoRow {
        /// The directory.
        directory: PathBuf,
        /// The table, or the folder of its parts.
        table: PathBuf,
        /// The number.
        sample: u64,
        /// Rows of the table.
        rows: usize,
    },
}

/// The command for a sample.
fn sample_command(command: &str, directory: &Path, sample: &str) -> String {
    call::command([OsStr::new(command), call::path_word(directory).as_ref(), OsStr::new(sample)])
}

/// Reasons why a sample cannot be described.
#[derive(Debug, thiserror::Error)]
pub enum WhyError {
    /// A run that has not written down yet what it computes.
    #[error("the run in {} is starting: its study is not written yet", shown(directory))]
    Beginning {
        /// The directory.
        directory: PathBuf,
    },
    /// The study that was frozen in the directory.
    #[error(
        "the frozen study in {} can no longer be read{}",
        shown(directory),
        again.as_ref().map(|command| format!("; this writes it there again: {command}")).unwrap_or_default()
    )]
    Frozen {
        /// The directory.
        directory: PathBuf,
        /// The command that writes it again, where it is gone.
        again: Option<String>,
        /// Why.
        #[source]
        source: StudyError,
    },
}

/// Why a sample cannot be computed again.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// Neither a sample nor a column is named.
    #[error(
        "which sample of {}? its samples are up to {last}; --worst COLUMN selects the one with the largest value; for example:\n  {}\n  {}",
        shown(directory),
        sample_command("replay", directory, &example.to_string()),
        replay(directory, "--worst", "max_bearing_load_N")
    )]
    Which {
        /// Where.
        directory: PathBuf,
        /// A sample of it.
        example: u64,
        /// Its last sample.
        last: u64,
    },
    /// No such column of numbers.
    #[error("{} has no column {column:?} of numbers{}", shown(table), nearest.as_ref().map(|name| format!("; did you mean {name}?")).unwrap_or_default())]
    Column {
        /// The table.
        table: PathBuf,
        /// The name.
        column: String,
        /// The nearest one.
        nearest: Option<String>,
    },
    /// A column that has no largest value.
    #[error(
        "`{column}` is a column of words, not of numbers ({}); allowed: --worst with a column of numbers",
        shown(table)
    )]
    Words {
        /// The table.
        table: PathBuf,
        /// The name.
        column: String,
    },
    /// Nothing in the column.
    #[error("no row of {} that is ok has a value in {column}", shown(table))]
    Empty {
        /// The table.
        table: PathBuf,
        /// The column.
        column: String,
    },
    /// The table does not say which plan it was computed from.
    #[error("{} does not name the plan it was computed from", shown(table))]
    NoPlan {
        /// The table.
        table: PathBuf,
    },
    /// There is no transient.
    #[error(
        "replay computes a transient again: the study in {} has model = \"function\" and has rows only (`why`, `export`)",
        shown(directory)
    )]
    Function {
        /// The directory.
        directory: PathBuf,
    },
    /// The plan.
    #[error(transparent)]
    Plan(#[from] JobSpecError),
    /// The sample.
    #[error("the sample cannot be computed")]
    Solver(#[from] SolverError),
    /// A parameter of the plan without a column.
    #[error("{} has no column for the parameter {path}", shown(table))]
    Parameter {
        /// The table.
        table: PathBuf,
        /// The parameter.
        path: String,
    },
}

fn replay(directory: &Path, option: &str, value: &str) -> String {
    let directory = call::path_word(directory);
    let words: [&OsStr; 4] = ["replay".as_ref(), directory.as_ref(), option.as_ref(), value.as_ref()];
    call::command(words)
}
