//! Faults from the environment: a test makes a process die or stop at a known state of a known sample.
//!
//! `BLADEOFF_FAULT` holds one or more faults, separated by `;`. Each fault is a list of `key=value`, separated by `,`:
//!
//! | key | values |
//! |---|---|
//! | `who` | process that acts: `worker`, `orchestrator` |
//! | `at` | state ([`At`]) in lower case. Both processes have `claimed`, `running`, `sent`, `recorded`, `writing`; the orchestrator alone has the others |
//! | `sample` | number, or `any` |
//! | `do` | `kill`, `stop`, `abort`, `panic`, `hang`, `hoard` (allocate until it fails), `pause` (wait 0.1 s each time, without a file); of the orchestrator also `kill-worker`, `stop-worker`: it signals the worker of that sample |
//! | `times` | largest number of firings for one sample, over all processes; default 1 |
//! | `dir` | an existing directory. Each firing creates a file `fired-AT-SAMPLE-N` there: it counts the firing and proves it |
//!
//! Only the orchestrator sees that a sample is `recorded`: use `who=orchestrator,at=recorded,do=kill-worker`. The orchestrator learns
//! from a heartbeat, twice a second, that a sample is running. A worker therefore waits in a sample for which the orchestrator has a
//! fault `at=running`, until that fault has fired.
//!
//! `pause` gives samples a duration that takes no CPU time: other samples remain when a fault fires, at any load of the machine.

use bladeoff_worker::fault::{At, Faults};
use bladeoff_worker::process::{signal, signal_self};
use rustix::process::Signal;
use std::env::VarError;
use std::fs::OpenOptions;
use std::path::PathBuf;
use std::time::Duration;

/// Name of the environment variable.
pub const FAULT_VARIABLE: &str = "BLADEOFF_FAULT";
/// Interval at which a worker checks whether the orchestrator's fault has fired.
const LOOK_EVERY: Duration = Duration::from_millis(5);
/// Duration of a pause.
const PAUSE: Duration = Duration::from_millis(100);

/// Kind of process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Who {
    /// A worker.
    Worker,
    /// The orchestrator.
    Orchestrator,
}

/// Words of `who`.
const PROCESSES: [(&str, Who); 2] = [("worker", Who::Worker), ("orchestrator", Who::Orchestrator)];

/// Words of `at`.
const STATES: [(&str, At); 11] = [
    ("claimed", At::Claimed),
    ("running", At::Running),
    ("sent", At::Sent),
    ("recorded", At::Recorded),
    ("looking", At::Looking),
    ("writing", At::Writing),
    ("growing", At::Growing),
    ("parting", At::Parting),
    ("parted", At::Parted),
    ("swapping", At::Swapping),
    ("retiring", At::Retiring),
];

/// Words of `do`.
const ACTIONS: [(&str, Do); 9] = [
    ("kill", Do::Kill),
    ("stop", Do::Stop),
    ("abort", Do::Abort),
    ("panic", Do::Panic),
    ("hang", Do::Hang),
    ("hoard", Do::Hoard),
    ("pause", Do::Pause),
    ("kill-worker", Do::KillWorker),
    ("stop-worker", Do::StopWorker),
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Do {
    Kill,
    Stop,
    Abort,
    Panic,
    Hang,
    Hoard,
    Pause,
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

/// Faults of this process, read from the environment.
#[derive(Debug, Clone, Default)]
pub struct EnvironmentFaults {
    own: Vec<Fault>,
    /// Faults of the orchestrator that a worker waits for.
    awaited: Vec<Fault>,
}

/// Invalid text in the variable. A test that asks for a fault must not run without it.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error("{FAULT_VARIABLE}: {key} is missing or has an unknown value in {text:?}; it takes {allowed}")]
pub struct FaultError {
    /// Key that is missing or has an unknown value.
    pub key: &'static str,
    /// Text of the fault.
    pub text: String,
    /// Values of the key.
    pub allowed: String,
}

impl EnvironmentFaults {
    /// Reads the faults of one kind of process.
    ///
    /// # Errors
    /// The variable has no valid list of faults.
    pub fn read(who: Who) -> Result<Self, FaultError> {
        match std::env::var(FAULT_VARIABLE) {
            Ok(text) => Self::parse(&text, who),
            Err(VarError::NotPresent) => Ok(Self::default()),
            Err(VarError::NotUnicode(text)) => {
                let (text, allowed) = (text.to_string_lossy().into_owned(), "UTF-8".to_owned());
                Err(FaultError { key: "the variable", text, allowed })
            }
        }
    }

    /// Reads the faults of this process, for its whole life.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn of_process(who: Who) -> Result<&'static dyn Faults, FaultError> {
        Ok(Box::leak(Box::new(Self::read(who)?)))
    }

    fn parse(text: &str, who: Who) -> Result<Self, FaultError> {
        let faults =
            text.split(';').filter(|text| !text.is_empty()).map(Fault::parse).collect::<Result<Vec<_>, _>>()?;
        let (own, others): (Vec<_>, Vec<_>) = faults.into_iter().partition(|fault| fault.who == who);
        let awaited = others.into_iter().filter(|fault| who == Who::Worker && fault.at == At::Running).collect();
        Ok(Self { own, awaited })
    }
}

impl Faults for EnvironmentFaults {
    fn is_empty(&self) -> bool {
        self.own.is_empty()
    }

    fn reached(&self, at: At, sample: u64, worker: Option<u32>) {
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
        let wrong = |key, allowed: &str| FaultError { key, text: text.to_owned(), allowed: allowed.to_owned() };
        let who = word(value("who"), &PROCESSES).map_err(|allowed| wrong("who", &allowed))?;
        let at = word(value("at"), &STATES).map_err(|allowed| wrong("at", &allowed))?;
        let what = word(value("do"), &ACTIONS).map_err(|allowed| wrong("do", &allowed))?;
        let sample = match value("sample") {
            Some("any") => None,
            number => {
                let number = number.and_then(|number| number.parse().ok());
                Some(number.ok_or_else(|| wrong("sample", "a number or any"))?)
            }
        };
        let times = value("times").unwrap_or("1").parse().map_err(|_| wrong("times", "a number"))?;
        let dir = match value("dir").map(PathBuf::from) {
            None if what == Do::Pause => PathBuf::new(),
            dir => dir.ok_or_else(|| wrong("dir", "a directory"))?,
        };
        Ok(Self { who, at, sample, what, times, dir })
    }

    fn concerns(&self, at: At, sample: u64) -> bool {
        self.at == at && self.sample.is_none_or(|wanted| wanted == sample)
    }

    /// Path of the file that the `n`-th firing for a sample creates.
    fn proof(&self, sample: u64, n: u32) -> PathBuf {
        let at = STATES.iter().find(|(_, at)| *at == self.at).map_or("", |(word, _)| word);
        self.dir.join(format!("fired-{at}-{sample}-{n}"))
    }

    /// Takes one of the allowed firings, if one is left, by creating its file: the count is exact for any number of processes.
    fn counts(&self, sample: u64) -> bool {
        // a pause proves nothing, and is not counted
        self.what == Do::Pause
            || (1..=self.times)
                .any(|n| OpenOptions::new().write(true).create_new(true).open(self.proof(sample, n)).is_ok())
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
            Do::Pause => std::thread::sleep(PAUSE),
            Do::KillWorker => {
                let _ = worker.is_some_and(|pid| signal(pid, Signal::KILL));
            }
            Do::StopWorker => {
                let _ = worker.is_some_and(|pid| signal(pid, Signal::STOP));
            }
        }
    }
}

/// Meaning of a word; if the word is unknown, the allowed words.
fn word<T: Copy>(given: Option<&str>, words: &[(&str, T)]) -> Result<T, String> {
    let found = words.iter().find(|(word, _)| Some(*word) == given).map(|(_, meaning)| *meaning);
    found.ok_or_else(|| words.iter().map(|(word, _)| *word).collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_read_and_wrong_ones_are_named() {
        let text =
            "who=worker,at=running,sample=7,do=panic,dir=/tmp;who=orchestrator,at=sent,sample=any,do=stop,dir=/x";
        assert_eq!(EnvironmentFaults::parse(text, Who::Worker).expect("valid").own.len(), 1);
        assert!(EnvironmentFaults::parse("", Who::Worker).expect("valid").is_empty());
        let error = EnvironmentFaults::parse("who=worker,at=nowhere", Who::Worker).expect_err("wrong");
        assert_eq!(error.key, "at");
        assert!(error.to_string().contains("claimed, running"), "{error}");
    }

    #[test]
    fn a_fault_fires_as_often_as_it_says_and_leaves_proof() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let text = format!("who=worker,at=sent,sample=7,do=panic,times=2,dir={}", dir.path().display());
        let fire = |sample| {
            let faults = EnvironmentFaults::parse(&text, Who::Worker).expect("valid");
            std::panic::catch_unwind(|| faults.reached(At::Sent, sample, None)).is_err()
        };
        assert_eq!([fire(6), fire(7), fire(7), fire(7)], [false, true, true, false]);
        assert!(dir.path().join("fired-sent-7-2").exists());
    }

    #[test]
    fn a_pause_takes_its_time_and_leaves_no_file() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let text = "who=worker,at=running,sample=any,do=pause";
        for text in [text.to_owned(), format!("{text},dir={}", dir.path().display())] {
            let faults = EnvironmentFaults::parse(&text, Who::Worker).expect("valid");
            let begun = std::time::Instant::now();
            (0..2).for_each(|sample| faults.reached(At::Running, sample, None));
            assert!(begun.elapsed() >= 2 * PAUSE);
        }
        assert!(std::fs::read_dir(dir.path()).expect("readable").next().is_none());
    }

    #[test]
    fn a_worker_waits_for_the_orchestrators_fault_in_a_running_sample() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let text = format!("who=orchestrator,at=running,sample=7,do=panic,dir={}", dir.path().display());
        let worker = EnvironmentFaults::parse(&text, Who::Worker).expect("valid");
        worker.reached(At::Running, 6, None);
        worker.reached(At::Sent, 7, None);
        let waiting = std::thread::spawn(move || worker.reached(At::Running, 7, None));
        std::thread::sleep(10 * LOOK_EVERY);
        assert!(!waiting.is_finished());
        let orchestrator = EnvironmentFaults::parse(&text, Who::Orchestrator).expect("valid");
        let fired = std::panic::catch_unwind(|| orchestrator.reached(At::Running, 7, None));
        assert!(fired.is_err() && waiting.join().is_ok());
    }
}
