//! Errors of the subcommands, with their exit codes.

use super::exit::Exit;
use super::refusals::{DesignExportError, NoDirectory, NotAsked, NotCompared, ReplayError, SampleError, WhyError};
use crate::dispatch::Signal;
use crate::engine::EngineError;
use crate::history::HistoryError;
use crate::questions::AnsweringError;
use crate::run::RunError;
use crate::run::directory::LEDGER;
use crate::run::shards::ShardError;
use crate::start_check::StartError;
use crate::submit::SubmitError;
use bladeoff_answers::compare::CompareError;
use bladeoff_answers::figures::FigureError;
use bladeoff_answers::tables::TableError;
use bladeoff_record::RecordError;
use bladeoff_study::sampling::combinations::CombinationError;
use bladeoff_study::{InputError, StudyError, meant};
use bladeoff_system::call;
use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use bladeoff_system::threads::{AddressSpaceError, ThreadsError};
use bladeoff_text::document::Problems;
use bladeoff_worker::job_spec::JobSpecError;
use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};

/// Error of a subcommand.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// Problems in a machine file, with the place of each.
    #[error(transparent)]
    Machine(#[from] Problems),
    /// Problems of a machine whose file is overridden by options.
    #[error("{problems}")]
    Overridden {
        /// The problems, at their places in the file.
        problems: Problems,
        /// Text of the options.
        given: String,
    },
    /// A study file given as a machine file.
    #[error("{} is a study file, not a machine{}", shown(path), of_a_study(path, machine.as_deref()))]
    AStudy {
        /// Path of the file.
        path: PathBuf,
        /// Machine file named in the study.
        machine: Option<String>,
    },
    /// A formula study given where a machine is needed.
    #[error("{what}: {} has model = \"function\" and no machine", shown(path))]
    Formulas {
        /// Path of the file.
        path: PathBuf,
        /// Name of the operation.
        what: &'static str,
    },
    /// A study that cannot be run.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A study with samples that cannot be run.
    #[error(transparent)]
    Start(#[from] StartError),
    /// An input file that cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A value on the command line that the machine rejects.
    #[error("{argument}: {message}")]
    Argument {
        /// The argument as given.
        argument: String,
        /// Description of the error.
        message: String,
        /// Allowed values.
        allowed: Option<String>,
    },
    /// Invalid gates on the command line, each with its error.
    #[error("{0}")]
    Gates(String),
    /// The solver refused the machine before the first step.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// A study could not be run to its end.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A result directory with shards, given for a run without shards.
    #[error(
        "{} holds shards: `run --shard 0/1` computes what is missing there, `merge` makes the table; for a run of its own choose another --out",
        shown(path)
    )]
    OfShards {
        /// Path of the directory.
        path: PathBuf,
    },
    /// Options that contradict each other.
    #[error("{what}")]
    Unmeant {
        /// Description of the conflict.
        what: String,
    },
    /// Shards that could not be submitted.
    #[error(transparent)]
    Submit(#[from] SubmitError),
    /// An error of shards.
    #[error(transparent)]
    Shard(#[from] ShardError),
    /// A table that cannot be read or written.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A file operation that failed.
    #[error(transparent)]
    File(#[from] FileError),
    /// The record of finished samples.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A figure that cannot be drawn.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// A history that cannot be written or read.
    #[error(transparent)]
    History(#[from] HistoryError),
    /// A sample of a study that cannot be computed again.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// A file that is already there and is not overwritten.
    #[error("{} already exists; it is not overwritten", shown(path))]
    Exists {
        /// Path of the file.
        path: PathBuf,
    },
    /// `--kind` for a machine template.
    #[error("--kind is for studies: new study --kind risk; machines have one template")]
    NoKind,
    /// A directory without a result table.
    #[error(
        "{}",
        if path.join(LEDGER).exists() {
            let status = call::command([OsStr::new("status"), call::path_word(path).as_os_str()]);
            format!("{} has no table yet; progress and how to resume: {status}", shown(path))
        } else {
            no_directory(path, "it has no results.parquet")
        }
    )]
    NoResults {
        /// Path of the directory.
        path: PathBuf,
    },
    /// A directory that is not a result directory.
    #[error("{}", no_directory(path, "no study was run in it"))]
    NotARun {
        /// Path of the directory.
        path: PathBuf,
    },
    /// No directory is given, and there is no default one.
    #[error(transparent)]
    NoDirectory(#[from] NoDirectory),
    /// Questions that cannot be answered.
    #[error(transparent)]
    Answering(#[from] AnsweringError),
    /// A design that cannot be exported.
    #[error(transparent)]
    Design(#[from] DesignExportError),
    /// A study without questions or gates.
    #[error(transparent)]
    NotAsked(#[from] NotAsked),
    /// Two tables that cannot be compared.
    #[error(transparent)]
    NotCompared(#[from] NotCompared),
    /// A sample that cannot be described.
    #[error(transparent)]
    Why(#[from] WhyError),
    /// A command line without a valid sample number.
    #[error(transparent)]
    Sample(#[from] SampleError),
    /// Threads that could not be started.
    #[error(transparent)]
    Threads(#[from] ThreadsError),
    /// An address space limit that is too small.
    #[error(transparent)]
    AddressSpace(#[from] AddressSpaceError),
    /// A run with a history, ended by a signal.
    #[error("{words}")]
    Stopped {
        /// The signal.
        signal: Signal,
        /// Text on the remaining part of the history.
        words: String,
    },
    /// Standard output that cannot be written.
    #[error("cannot write to standard output")]
    Stdout {
        /// Error of the operating system.
        #[source]
        source: io::Error,
    },
    /// The reader of standard output has closed it, which is not reported.
    #[error("the reader of standard output has closed it")]
    ReaderLeft,
}

/// Message that there is no such directory, or why it is not a result directory.
fn no_directory(path: &Path, why: &str) -> String {
    let near = meant(path);
    match path.symlink_metadata() {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            format!("there is no directory {}{near}", shown(path))
        }
        _ => format!("{} is not a result directory: {why}{near}", shown(path)),
    }
}

impl CliError {
    /// For `map_err` on writes to standard output.
    pub fn stdout(source: io::Error) -> Self {
        if source.kind() == io::ErrorKind::BrokenPipe { CliError::ReaderLeft } else { CliError::Stdout { source } }
    }

    /// Error for a directory without a table, or one that cannot be entered.
    #[must_use]
    pub fn no_results(path: &Path) -> Self {
        match path.join(LEDGER).symlink_metadata() {
            Err(source) if source.kind() == io::ErrorKind::PermissionDenied => {
                FileError::at("enter", path)(source).into()
            }
            _ => Self::NoResults { path: path.to_path_buf() },
        }
    }

    /// Exit code of the error.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            CliError::Machine(_)
            | CliError::AStudy { .. }
            | CliError::Formulas { .. }
            | CliError::Overridden { .. }
            | CliError::Argument { .. }
            | CliError::Gates(_)
            | CliError::Exists { .. }
            | CliError::NoResults { .. }
            | CliError::NotARun { .. }
            | CliError::OfShards { .. }
            | CliError::NoDirectory(_)
            | CliError::NotAsked(_) => Exit::Input,
            CliError::Why(WhyError::Beginning { .. }) => Exit::Incomplete,
            CliError::Why(_) => Exit::Input,
            CliError::Sample(error) => sample_exit(error),
            CliError::Study(StudyError::Problems(_) | StudyError::AMachine { .. } | StudyError::OfRoss(_))
            | CliError::Start(_) => Exit::Input,
            CliError::Unmeant { .. }
            | CliError::NoKind
            | CliError::Study(StudyError::Combinations(CombinationError::Scale { .. } | CombinationError::Nothing)) => {
                Exit::Usage
            }
            CliError::Study(StudyError::Combinations(_)) => Exit::Input,
            CliError::Study(StudyError::Threads(_)) | CliError::Threads(_) | CliError::AddressSpace(_) => Exit::Io,
            CliError::Study(StudyError::Input(error)) | CliError::Input(error) => input_exit(error),
            CliError::Engine(_) => Exit::Input,
            CliError::Replay(ReplayError::Which { .. }) => Exit::Usage,
            CliError::Replay(ReplayError::Plan(JobSpecError::File(_) | JobSpecError::Changed { .. })) => Exit::Io,
            CliError::Run(error) if error.is_refusal() => Exit::Input,
            CliError::Shard(ShardError::Missing { .. }) => Exit::Incomplete,
            CliError::Shard(error) if error.is_refusal() => Exit::Input,
            CliError::Shard(_) | CliError::Submit(_) => Exit::Io,
            CliError::Run(_) => Exit::Io,
            CliError::History(
                HistoryError::Extension { .. }
                | HistoryError::DecimalComma { .. }
                | HistoryError::Channel { .. }
                | HistoryError::Missing { .. }
                | HistoryError::NotAHistory { .. }
                | HistoryError::Mcap { action: "read", .. }
                | HistoryError::Table(TableError::Table { action: "read", .. } | TableError::Damaged { .. })
                | HistoryError::Number { .. }
                | HistoryError::NothingToRecover { .. },
            )
            | CliError::Figure(FigureError::Extension { .. } | FigureError::Spectrum(_))
            | CliError::Replay(_) => Exit::Input,
            CliError::Figure(_) => Exit::Io,
            CliError::History(_) => Exit::Io,
            CliError::Design(_) => Exit::Input,
            CliError::Answering(AnsweringError::Table(TableError::Version { .. })) => Exit::Input,
            CliError::Answering(AnsweringError::Table(_) | AnsweringError::Row { .. }) => Exit::Io,
            CliError::Answering(_) => Exit::Input,
            CliError::Table(TableError::Version { .. }) => Exit::Input,
            CliError::Table(_) | CliError::File(_) | CliError::Record(_) | CliError::Stdout { .. } => Exit::Io,
            CliError::NotCompared(NotCompared::Compare(error)) => compare_exit(error),
            CliError::NotCompared(NotCompared::Changing) => Exit::Io,
            CliError::NotCompared(_) => Exit::Input,
            CliError::Stopped { signal, .. } => (*signal).into(),
            CliError::ReaderLeft => Exit::Ok,
        }
    }
}

/// Commands for a study that was given as a machine.
fn of_a_study(path: &Path, machine: Option<&str>) -> String {
    let command = |word: &str, path: &Path| call::command([OsStr::new(word), call::path_word(path).as_os_str()]);
    let mut text = format!("\n  all its runs: {}\n  its content: {}", command("run", path), command("check", path));
    if let Some(machine) = machine {
        let machine = path.parent().unwrap_or(Path::new("")).join(machine);
        text.push_str(&format!("\n  one run of its machine: {}", command("simulate", &machine)));
    }
    text
}

fn sample_exit(error: &SampleError) -> Exit {
    match error {
        SampleError::Number { .. }
        | SampleError::Twice { .. }
        | SampleError::Order { .. }
        | SampleError::Samples { .. }
        | SampleError::SampleAndWorst { .. }
        | SampleError::Which { .. } => Exit::Usage,
        SampleError::File { .. } | SampleError::Sample { .. } | SampleError::NoRow { .. } => Exit::Input,
    }
}

fn compare_exit(error: &CompareError) -> Exit {
    match error {
        CompareError::Asked(_) | CompareError::NoColumn { .. } | CompareError::Table(TableError::Version { .. }) => {
            Exit::Input
        }
        CompareError::Table(_) | CompareError::Row { .. } => Exit::Io,
    }
}

fn input_exit(error: &InputError) -> Exit {
    match error {
        InputError::Io { .. } => Exit::Io,
        InputError::Missing { .. }
        | InputError::NotAFile { .. }
        | InputError::Link { .. }
        | InputError::TooLarge { .. }
        | InputError::NotText { .. }
        | InputError::Escapes { .. } => Exit::Input,
    }
}
