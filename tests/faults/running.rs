//! Runs that are killed and stopped at known states, through the real command line.

pub use crate::support::processes::{STUDY, WATCHDOG, lives, signal, state, wait_until};
use crate::support::{Folder, bladeoff};
use bladeoff::dispatch::Todo;
use bladeoff::run::order;
use bladeoff_dev::chaos;
pub use bladeoff_dev::chaos::{PAUSE, SAMPLES};
use std::ops::{Deref, DerefMut};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};

/// A running `bladeoff run`.
pub struct Running(chaos::Running);

impl Deref for Running {
    type Target = chaos::Running;
    fn deref(&self) -> &chaos::Running {
        &self.0
    }
}

impl DerefMut for Running {
    fn deref_mut(&mut self) -> &mut chaos::Running {
        &mut self.0
    }
}

impl Running {
    /// Starts a run with these faults, separated by `;`, without `dir`.
    pub fn start(folder: &Folder, study: &str, out: &str, faults: &str) -> Self {
        Self::start_with(folder, study, out, faults, &[])
    }

    /// Starts a run whose samples take a tenth of a second each without computing, so that samples remain when a fault fires.
    pub fn start_slow(folder: &Folder, study: &str, out: &str, faults: &str) -> Self {
        Self::start(folder, study, out, &format!("{PAUSE};{faults}"))
    }

    /// Starts a run with these faults and further options.
    pub fn start_with(folder: &Folder, study: &str, out: &str, faults: &str, more: &[&str]) -> Self {
        let scratch = tempfile::tempdir_in(folder.path("")).expect("a folder").keep();
        let run = ["run", study, "--out", out, "--workers", "2", "--json-events"];
        let direct = bladeoff(&[&run, more].concat());
        // the test process may ignore SIGHUP (nohup, CI), which children inherit; `env` is replaced by the program
        let mut command = Command::new("env");
        command.arg("--default-signal=HUP").arg(direct.get_program()).args(direct.get_args());
        command.envs(direct.get_envs().filter_map(|(key, value)| Some((key, value?))));
        if let Some(folder) = direct.get_current_dir() {
            command.current_dir(folder);
        }
        Self(chaos::Running::start(command, &scratch, faults).expect("it starts"))
    }

    /// Number of fired faults.
    pub fn fired(&self) -> usize {
        self.0.fired().len()
    }

    /// Waits for the end of the run.
    pub fn end(&mut self) -> ExitStatus {
        self.0.end(|_| {}).expect("it ends")
    }
}

/// The sample that a study of `count` samples assigns at this place, from 0.
pub fn handed_out(count: u64, place: usize) -> u64 {
    order::shuffled(Todo::from(count)).take(place + 1)[place]
}

/// Files that the runs of a result directory have left in shared memory and in /tmp, according to the log.
pub fn left_behind(out: &str) -> Vec<PathBuf> {
    chaos::left_behind(Path::new(out))
}
