//! Command line of a worker, written by the orchestrator; not for people, so without help.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

use bladeoff_protocol::domain::Address;
use bladeoff_protocol::messages::{RunId, WorkerId};

/// Arguments of a worker.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WorkerArgs {
    /// Place of the run's shared memory.
    pub address: Address,
    /// The run.
    pub run: RunId,
    /// Number of this worker.
    pub worker: WorkerId,
    /// Process id of the orchestrator, with which the worker ends; `None`: started by hand.
    pub parent: Option<u32>,
    /// Result directory.
    pub run_dir: PathBuf,
    /// blake3 of the plan in it.
    pub plan_hash: String,
    /// Memory limit after the start \[bytes\].
    pub memory_limit: Option<u64>,
    /// Time that each sample takes without computing \[us\], for measurements of the dispatch and for tests.
    pub noop: Option<u64>,
}

/// Error of a worker's command line.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum ArgsError {
    /// An option that does not exist.
    #[error("unknown option {option:?}; `bladeoff worker` is started by `bladeoff run`, not by hand")]
    Unknown {
        /// The option.
        option: OsString,
    },
    /// An option without its value, or with one that cannot be read.
    #[error("option {option} needs a value, not {value:?}")]
    Value {
        /// The option.
        option: &'static str,
        /// Value found.
        value: Option<OsString>,
    },
    /// A required option is missing.
    #[error("option {option} is missing; `bladeoff worker` is started by `bladeoff run`, not by hand")]
    Missing {
        /// The option.
        option: &'static str,
    },
}

const OPTIONS: [&str; 9] =
    ["--root", "--prefix", "--run", "--worker", "--parent", "--dir", "--plan", "--memory", "--noop"];

impl WorkerArgs {
    /// The arguments after `bladeoff worker`.
    #[must_use]
    pub fn to_args(&self) -> Vec<OsString> {
        let mut args: Vec<OsString> = vec![
            "--root".into(),
            self.address.root.clone().into(),
            "--prefix".into(),
            self.address.prefix.clone().into(),
            "--run".into(),
            self.run.to_string().into(),
            "--worker".into(),
            self.worker.0.to_string().into(),
            "--dir".into(),
            self.run_dir.clone().into(),
            "--plan".into(),
            self.plan_hash.clone().into(),
        ];
        let optional =
            [("--parent", self.parent.map(u64::from)), ("--memory", self.memory_limit), ("--noop", self.noop)];
        for (option, value) in optional {
            if let Some(value) = value {
                args.extend([option.into(), value.to_string().into()]);
            }
        }
        args
    }

    /// Reads the arguments after `bladeoff worker`.
    ///
    /// # Errors
    /// The first wrong argument.
    pub fn parse(args: impl IntoIterator<Item = OsString>) -> Result<Self, ArgsError> {
        let mut values: [Option<OsString>; OPTIONS.len()] = Default::default();
        let mut args = args.into_iter();
        while let Some(option) = args.next() {
            let Some(at) = OPTIONS.iter().position(|known| OsStr::new(known) == option) else {
                return Err(ArgsError::Unknown { option });
            };
            let value = args.next().ok_or(ArgsError::Value { option: OPTIONS[at], value: None })?;
            values[at] = Some(value);
        }
        let mut values = values.into_iter().zip(OPTIONS);
        let mut next = || values.next().expect("as many values as options");
        let required = |(value, option): (Option<OsString>, &'static str)| value.ok_or(ArgsError::Missing { option });
        let root = PathBuf::from(required(next())?);
        let prefix = text(required(next())?, "--prefix")?;
        let run = RunId(number(required(next())?, "--run", |text| u64::from_str_radix(text, 16).ok())?);
        let worker = WorkerId(number(required(next())?, "--worker", |text| text.parse().ok())?);
        let parent = next().0.map(|value| number(value, "--parent", |text| text.parse().ok())).transpose()?;
        let run_dir = PathBuf::from(required(next())?);
        let plan_hash = text(required(next())?, "--plan")?;
        let memory_limit = next().0.map(|value| number(value, "--memory", |text| text.parse().ok())).transpose()?;
        let noop = next().0.map(|value| number(value, "--noop", |text| text.parse().ok())).transpose()?;
        let address = Address { root, prefix };
        Ok(Self { address, run, worker, parent, run_dir, plan_hash, memory_limit, noop })
    }
}

fn text(value: OsString, option: &'static str) -> Result<String, ArgsError> {
    value.into_string().map_err(|value| ArgsError::Value { option, value: Some(value) })
}

fn number<T>(value: OsString, option: &'static str, read: impl Fn(&str) -> Option<T>) -> Result<T, ArgsError> {
    match value.to_str().and_then(read) {
        Some(number) => Ok(number),
        None => Err(ArgsError::Value { option, value: Some(value) }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> WorkerArgs {
        WorkerArgs {
            address: Address { root: "/tmp/bladeoff-0/00ff".into(), prefix: "bladeoff_00ff_".into() },
            run: RunId(0xfeed),
            worker: WorkerId(3),
            parent: Some(12),
            run_dir: "runs/a b".into(),
            plan_hash: "abc".into(),
            memory_limit: None,
            noop: Some(5),
        }
    }

    #[test]
    fn arguments_go_there_and_back() {
        assert_eq!(WorkerArgs::parse(example().to_args()), Ok(example()));
    }

    #[test]
    fn wrong_arguments_are_named() {
        let parse = |args: &[&str]| WorkerArgs::parse(args.iter().map(OsString::from));
        assert_eq!(parse(&["--bogus"]), Err(ArgsError::Unknown { option: "--bogus".into() }));
        assert_eq!(parse(&["--root"]), Err(ArgsError::Value { option: "--root", value: None }));
        assert_eq!(parse(&["--root", "/x"]), Err(ArgsError::Missing { option: "--prefix" }));
        let mut args = example().to_args();
        args[7] = "seven".into();
        assert_eq!(WorkerArgs::parse(args), Err(ArgsError::Value { option: "--worker", value: Some("seven".into()) }));
    }
}
