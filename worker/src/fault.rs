//! Hooks by which tests make a process die or stop at a known state of a known sample; nothing without the variable.
//!
//! `BLADEOFF_FAULT` holds one or more faults, separated by `;`, each a list of `key=value` separated by `,`:
//!
//! | key | values |
//! |---|---|
//! | `who` | `worker`, `orchestrator`: who acts |
//! | `at` | `claimed` (batch received or assigned), `running` (sample begun, or said so by a heartbeat), `sent` (result sent or received), `recorded` (result durable), `writing` (sample 0: all that will be done is recorded, the tables are written next), and of the orchestrator alone: `looking` (rows of so many samples stand aside to be looked at), `growing` (sample taken over into a new record), `parting`, `parted` (part of this number about to get, or having, its name), `swapping` (fresh parts stand aside), `retiring` (the table is there, the parts are removed next) |
//! | `sample` | number, or `any` |
//! | `do` | `kill`, `stop`, `abort`, `panic`, `hang`, `hoard` (allocate until it fails), `kill-worker`, `stop-worker` (the orchestrator signals the worker of that sample) |
//! | `times` | how often at most for one sample, over all processes; default 1 |
//! | `dir` | an existing directory: every firing leaves a file `fired-AT-SAMPLE-N` there, which counts it and proves it |
//!
//! A worker is at `recorded` only in the eyes of the orchestrator: use `who=orchestrator,at=recorded,do=kill-worker`. And the
//! orchestrator learns only by a heartbeat, two a second, that a sample is running: a worker that comes to a sample for which
//! the orchestrator has a fault `at=running` waits there until it has fired, however short the sample is.

use std::fs::OpenOptions;
use std::path::PathBuf;
use std::time::Duration;

use rustix::process::Signal;

use crate::process::{signal, signal_self};

/// Name of the environment variable.
pub const FAULT_VARIABLE: &str = "BLADEOFF_FAULT";
/// How often a worker looks whether the orchestrator's fault has fired.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// Which process a hook is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Who {
    /// A worker.
    Worker,
    /// The orchestrator.
    Orchestrator,
}

/// Where in the life of a sample a hook is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum At {
    /// In a batch that was received or assigned.
    Claimed,
    /// Begun.
    Running,
    /// Its result was sent or received.
    Sent,
    /// Its result is durable.
    Recorded,
    /// Rows of a beginning stand aside to be looked at; their number stands for the sample.
    Looking,
    /// The run is over, the tables are written next; sample 0 stands for all.
    Writing,
    /// Taken over into a record that is made aside.
    Growing,
    /// A part of the rows is written and has no name yet; the number of the part stands for the sample.
    Parting,
    /// It has its name.
    Parted,
    /// Fresh parts are about to take the place of the old ones; sample 0 stands for all.
    Swapping,
    /// The table has its name, the parts are about to go; sample 0 stands for all.
    Retiring,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Do {
    Kill,
    Stop,
    Abort,
    Panic,
    Hang,
    Hoard,
    KillWorker,
    StopWorker,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Fault {
    who: Who,
    at: At,
    sample: Option<u64>,
    what: Do,
    times: u32,
    dir: PathBuf,
}

/// The faults of this process.
#[derive(Debug, Clone, Default)]
pub struct Faults {
    own: Vec<Fault>,
    /// Faults of the orchestrator that a worker has to wait for.
    awaited: Vec<Fault>,
}

/// The variable cannot be read. A test that asks for a fault must not run without it.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error("{FAULT_VARIABLE}: {key:?} is missing or has an unknown value in {text:?}")]
pub struct FaultError {
    /// Which key.
    pub key: &'static str,
    /// The fault it is missing in.
    pub text: String,
}

impl Faults {
    /// The faults that the environment asks of one kind of process.
    ///
    /// # Errors
    /// A variable that cannot be read.
    pub fn from_environment(who: Who) -> Result<Self, FaultError> {
        match std::env::var(FAULT_VARIABLE) {
            Ok(text) => Self::parse(&text, who),
            Err(_) => Ok(Self::default()),
        }
    }

    fn parse(text: &str, who: Who) -> Result<Self, FaultError> {
        let faults =
            text.split(';').filter(|text| !text.is_empty()).map(Fault::parse).collect::<Result<Vec<_>, _>>()?;
        let (own, others): (Vec<_>, Vec<_>) = faults.into_iter().partition(|fault| fault.who == who);
        let awaited = others.into_iter().filter(|fault| who == Who::Worker && fault.at == At::Running).collect();
        Ok(Self { own, awaited })
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.own.is_empty()
    }

    /// A sample has come to a state; `worker` is the process that has it, for the orchestrator.
    ///
    /// # Panics
    /// When the fault is to panic.
    pub fn reached(&self, at: At, sample: u64, worker: Option<u32>) {
        for fault in self.own.iter().filter(|fault| fault.concerns(at, sample)) {
            if fault.counts(sample) {
                fault.act(worker);
            }
        }
        for fault in self.awaited.iter().filter(|fault| fault.concerns(at, sample)) {
            while !fault.proof(sample, 1).exists() {
                std::thread::sleep(LOOK_EVERY);
            }
        }
    }
}

impl Fault {
    fn parse(text: &str) -> Result<Self, FaultError> {
        let value = |key: &'static str| {
            text.split(',').find_map(|pair| pair.trim().split_once('=').filter(|(found, _)| *found == key)).map(|p| p.1)
        };
        let wrong = |key| FaultError { key, text: text.to_owned() };
        let who = match value("who") {
            Some("worker") => Who::Worker,
            Some("orchestrator") => Who::Orchestrator,
            _ => return Err(wrong("who")),
        };
        let at = match value("at") {
            Some("claimed") => At::Claimed,
            Some("running") => At::Running,
            Some("sent") => At::Sent,
            Some("recorded") => At::Recorded,
            Some("looking") => At::Looking,
            Some("writing") => At::Writing,
            Some("growing") => At::Growing,
            Some("parting") => At::Parting,
            Some("parted") => At::Parted,
            Some("swapping") => At::Swapping,
            Some("retiring") => At::Retiring,
            _ => return Err(wrong("at")),
        };
        let what = match value("do") {
            Some("kill") => Do::Kill,
            Some("stop") => Do::Stop,
            Some("abort") => Do::Abort,
            Some("panic") => Do::Panic,
            Some("hang") => Do::Hang,
            Some("hoard") => Do::Hoard,
            Some("kill-worker") => Do::KillWorker,
            Some("stop-worker") => Do::StopWorker,
            _ => return Err(wrong("do")),
        };
        let sample = match value("sample") {
            Some("any") => None,
            Some(number) => Some(number.parse().map_err(|_| wrong("sample"))?),
            None => return Err(wrong("sample")),
        };
        let times = value("times").unwrap_or("1").parse().map_err(|_| wrong("times"))?;
        let dir = value("dir").map(PathBuf::from).ok_or_else(|| wrong("dir"))?;
        Ok(Self { who, at, sample, what, times, dir })
    }

    fn concerns(&self, at: At, sample: u64) -> bool {
        self.at == at && self.sample.is_none_or(|wanted| wanted == sample)
    }

    /// The file that the `n`-th firing for a sample leaves.
    fn proof(&self, sample: u64, n: u32) -> PathBuf {
        let at = format!("{:?}", self.at).to_lowercase();
        self.dir.join(format!("fired-{at}-{sample}-{n}"))
    }

    /// Takes one of the allowed firings, if one is left, by creating its file: exact over any number of processes.
    fn counts(&self, sample: u64) -> bool {
        (1..=self.times).any(|n| OpenOptions::new().write(true).create_new(true).open(self.proof(sample, n)).is_ok())
    }

    fn act(&self, worker: Option<u32>) {
        match self.what {
            Do::Kill => signal_self(Signal::KILL),
            Do::Stop => signal_self(Signal::STOP),
            Do::Abort => std::process::abort(),
            Do::Panic => panic!("asked for by {FAULT_VARIABLE}"),
            Do::Hang => loop {
                std::thread::park();
            },
            Do::Hoard => {
                let mut hoard = Vec::new();
                loop {
                    hoard.push(std::hint::black_box(vec![1_u8; 1 << 20]));
                }
            }
            Do::KillWorker => {
                let _ = worker.is_some_and(|pid| signal(pid, Signal::KILL));
            }
            Do::StopWorker => {
                let _ = worker.is_some_and(|pid| signal(pid, Signal::STOP));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_read_and_wrong_ones_are_named() {
        let text =
            "who=worker,at=running,sample=7,do=panic,dir=/tmp;who=orchestrator,at=sent,sample=any,do=stop,dir=/x";
        assert_eq!(Faults::parse(text, Who::Worker).expect("valid").own.len(), 1);
        assert!(Faults::parse("", Who::Worker).expect("valid").is_empty());
        let error = Faults::parse("who=worker,at=nowhere", Who::Worker).expect_err("wrong");
        assert_eq!(error.key, "at");
    }

    #[test]
    fn a_fault_fires_as_often_as_it_says_and_leaves_proof() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let text = format!("who=worker,at=sent,sample=7,do=panic,times=2,dir={}", dir.path().display());
        let fire = |sample| {
            let faults = Faults::parse(&text, Who::Worker).expect("valid");
            std::panic::catch_unwind(|| faults.reached(At::Sent, sample, None)).is_err()
        };
        assert_eq!([fire(6), fire(7), fire(7), fire(7)], [false, true, true, false]);
        assert!(dir.path().join("fired-sent-7-2").exists());
    }

    #[test]
    fn a_worker_waits_for_the_orchestrators_fault_in_a_running_sample() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let text = format!("who=orchestrator,at=running,sample=7,do=panic,dir={}", dir.path().display());
        let worker = Faults::parse(&text, Who::Worker).expect("valid");
        worker.reached(At::Running, 6, None);
        worker.reached(At::Sent, 7, None);
        let waiting = std::thread::spawn(move || worker.reached(At::Running, 7, None));
        std::thread::sleep(10 * LOOK_EVERY);
        assert!(!waiting.is_finished());
        let orchestrator = Faults::parse(&text, Who::Orchestrator).expect("valid");
        let fired = std::panic::catch_unwind(|| orchestrator.reached(At::Running, 7, None));
        assert!(fired.is_err() && waiting.join().is_ok());
    }
}
