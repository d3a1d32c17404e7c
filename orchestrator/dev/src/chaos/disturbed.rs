//! A `bladeoff run` process, disturbed by faults at known states and by signals, and the files that it leaves.

use super::error::ChaosError;
use crate::faults::FAULT_VARIABLE;
use bladeoff_system::files::FileError;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// Longest duration of a disturbed run; a run that takes longer counts as hanging.
pub const WATCHDOG: Duration = Duration::from_secs(240);

/// Fault that makes each sample take a tenth of a second without computing, so that results are durable before the last sample begins.
pub const PAUSE: &str = "who=worker,at=running,sample=any,do=pause";

/// A running `bladeoff run`, with its events and messages in files.
#[derive(Debug)]
pub struct Running {
    /// Process of the orchestrator.
    pub child: Child,
    /// Folder in which fired faults leave a file.
    pub fired: PathBuf,
    events: PathBuf,
    log: PathBuf,
}

impl Running {
    /// Starts `command`, a `bladeoff run ... --json-events`, with these faults, separated by `;`, without `dir`. `scratch`: an empty folder for
    /// this run.
    ///
    /// # Errors
    /// The folder cannot be written, or the program does not start.
    pub fn start(mut command: Command, scratch: &Path, faults: &str) -> Result<Self, ChaosError> {
        let (fired, events, log) = (scratch.join("fired"), scratch.join("events"), scratch.join("log"));
        fs::create_dir(&fired).map_err(FileError::at("create", &fired))?;
        let create = |path: &Path| File::create(path).map_err(FileError::at("create", path));
        command.stdin(Stdio::null()).stdout(create(&events)?).stderr(create(&log)?).env_remove(FAULT_VARIABLE);
        let faults = faults.split(';').filter(|fault| !fault.is_empty());
        let faults: Vec<String> = faults.map(|fault| format!("{fault},dir={}", fired.display())).collect();
        if !faults.is_empty() {
            command.env(FAULT_VARIABLE, faults.join(";"));
        }
        let program = PathBuf::from(command.get_program());
        let child = command.spawn().map_err(FileError::at("start", &program))?;
        Ok(Self { child, fired, events, log })
    }

    /// Faults that have fired so far, by state and sample.
    #[must_use]
    pub fn fired(&self) -> Vec<(String, String)> {
        let names = fs::read_dir(&self.fired).into_iter().flatten().flatten().map(|entry| entry.file_name());
        let parts = |name: String| {
            let mut parts = name.split('-').skip(1).map(str::to_owned);
            Some((parts.next()?, parts.next()?))
        };
        names.filter_map(|name| parts(name.to_string_lossy().into_owned())).collect()
    }

    /// Events so far; an incomplete last line is skipped.
    #[must_use]
    pub fn events(&self) -> Vec<Value> {
        let text = fs::read_to_string(&self.events).unwrap_or_default();
        text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
    }

    /// Number of events with this name so far.
    #[must_use]
    pub fn count(&self, name: &str) -> usize {
        self.events().iter().filter(|event| event["event"] == name).count()
    }

    /// Text on standard error so far.
    #[must_use]
    pub fn said(&self) -> String {
        fs::read_to_string(&self.log).unwrap_or_default()
    }

    /// Process ids of the workers so far, from the events.
    #[must_use]
    pub fn workers(&self) -> BTreeSet<u32> {
        let pids = self.events();
        pids.iter().filter_map(|event| event["pid"].as_u64()).filter_map(|pid| u32::try_from(pid).ok()).collect()
    }

    /// Waits for the end of the run, calling `meanwhile` repeatedly.
    ///
    /// # Errors
    /// The run does not end.
    pub fn end(&mut self, mut meanwhile: impl FnMut(&Self)) -> Result<ExitStatus, ChaosError> {
        let start = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().map_err(FileError::at("wait for", Path::new("bladeoff")))? {
                return Ok(status);
            }
            if start.elapsed() > WATCHDOG {
                let _ = self.child.kill();
                return Err(ChaosError::Hangs { what: "a run", said: self.said() });
            }
            meanwhile(self);
            thread::sleep(Duration::from_millis(10));
        }
    }
}

/// State letter of a process from /proc; `None` if the process does not exist.
#[must_use]
pub fn state(pid: u32) -> Option<char> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    stat.rsplit(')').next()?.trim().chars().next()
}

/// Whether a process exists and holds resources: it is no zombie, or a zombie with a thread that has not ended. The first thread of a killed
/// process can be a zombie before the other threads have released files and locks.
#[must_use]
pub fn lives(pid: u32) -> bool {
    let threads = || fs::read_dir(format!("/proc/{pid}/task")).into_iter().flatten().flatten().count();
    state(pid).is_some_and(|state| state != 'Z' || threads() > 1)
}

/// Files that the runs of a result directory have left in shared memory and in the temporary folder, according to the log.
#[must_use]
pub fn left_behind(out: &Path) -> Vec<PathBuf> {
    let log = fs::read_to_string(out.join("workers.log")).unwrap_or_default();
    let roots =
        log.lines().filter_map(|line| line.split_once("shared memory in ")).map(|(_, root)| PathBuf::from(root));
    let mut left = Vec::new();
    for root in roots {
        // if another user occupies the name in /tmp, a longer one is used, with the id at its end
        let name = root.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let id = name.rsplit('-').next().unwrap_or_default();
        let shm = fs::read_dir("/dev/shm").into_iter().flatten().flatten().map(|entry| entry.path());
        left.extend(shm.filter(|path| path.to_string_lossy().contains(&format!("bladeoff_{id}_"))));
        if root.exists() {
            left.push(root);
        }
    }
    left
}
