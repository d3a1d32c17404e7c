//! Exit codes, the same for every subcommand.

use crate::dispatch::Signal;
use std::process::ExitCode;

/// Exit code of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Everything requested was done; the number of invalid and beyond samples is within the study's limits.
    Ok = 0,
    /// An internal error, or results that differ although they must be equal.
    Bug = 1,
    /// Invalid command line.
    Usage = 2,
    /// A file, machine, study or result directory is missing or rejected.
    Input = 3,
    /// Complete, but with more failed, invalid or beyond samples than the study allows; a failed `simulate`; a failed gate; a comparison out of
    /// tolerance; a replay that differs from the row of another numerics version.
    Failures = 4,
    /// Some samples have not been computed, or a gate is open.
    Incomplete = 5,
    /// An operation on a file, the disk, shared memory or a process failed.
    Io = 6,
    /// Ended by Ctrl-C.
    Interrupted = 130,
    /// Ended by SIGTERM.
    Terminated = 143,
}

impl Exit {
    /// All exit codes in ascending order.
    pub const ALL: [Exit; 9] = [
        Self::Ok,
        Self::Bug,
        Self::Usage,
        Self::Input,
        Self::Failures,
        Self::Incomplete,
        Self::Io,
        Self::Interrupted,
        Self::Terminated,
    ];

    /// Meaning of the exit code, for the reference.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Ok => "done; all samples `ok`, or `invalid` or `beyond` within the limits of the study",
            Self::Bug => {
                "internal error (a bug: please report it), or results that differ although they must not (`replay`, `verify`)"
            }
            Self::Usage => "invalid command line: unknown option or subcommand, invalid value, missing argument",
            Self::Input => {
                "invalid input: a file, study, machine or result directory that is missing, of the wrong kind, or rejected; \
                 a value that this machine, study or history does not accept"
            }
            Self::Failures => {
                "complete, but more samples failed, were invalid or were beyond the model than the study allows; \
                 a `simulate` that failed; a `gate` that failed; a `compare` out of tolerance; a `replay` that differs from the row of \
                 another numerics version"
            }
            Self::Incomplete => {
                "incomplete: some samples were not computed, and the same command resumes; a `gate` that is open"
            }
            Self::Io => "a file, the disk, shared memory or a process failed; a damaged table or record",
            Self::Interrupted => "ended by Ctrl-C; finished samples are kept",
            Self::Terminated => "ended by SIGTERM; finished samples are kept",
        }
    }

    /// The exit code for the code with which a merge in another process ended.
    #[must_use]
    pub fn of_merge(code: i32) -> Self {
        let known =
            [Self::Ok, Self::Input, Self::Failures, Self::Incomplete, Self::Io, Self::Interrupted, Self::Terminated];
        known.into_iter().find(|exit| *exit as i32 == code).unwrap_or(Self::Io)
    }
}

impl From<Signal> for Exit {
    fn from(signal: Signal) -> Self {
        match signal {
            Signal::Interrupt => Exit::Interrupted,
            Signal::Terminate => Exit::Terminated,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(exit as u8)
    }
}

/// Text at the end of `bladeoff --help`: its lines fit a narrow terminal, because clap would break longer lines without the indentation.
pub const EXIT_CODES: &str = "\
Exit codes:
  0    done; all samples ok, or invalid or beyond the model
       within the limits of the study
  1    internal error (a bug: please report it); replay or
       verify: results that differ although they must not
  2    invalid command line
  3    invalid input: a file, machine, study or result
       directory that is missing or rejected
  4    complete, but more samples failed, are invalid or
       beyond the model than the study allows; a gate that
       failed; a comparison out of tolerance
  5    incomplete: some samples were not computed; a gate
       that is open
  6    a file, the disk, shared memory or a process failed
  130  ended by Ctrl-C; 143 by SIGTERM; finished samples
       are kept";
