//! Runs that are killed and stopped at known states, through the real command line.

#![allow(dead_code, reason = "each test program uses its part")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::{Folder, bladeoff};

/// Nothing here takes as long; what hangs fails.
pub const WATCHDOG: Duration = Duration::from_secs(240);

/// 4 gaps x 5 masses; a sample takes a tenth of a second, so that there are results on disk before the last begins.
pub const STUDY: &str = r#"schema = 1
name = "faults"
machine = "machines/rig.toml"

[set]
"run.end_time" = "0.1 s"

[[vary]]
path = "contact.gap"
from = "0.5 mm"
to = "0.9 mm"
count = 4

[[vary]]
path = "blade_off.mass"
from = "3 g"
to = "10 g"
count = 5
"#;

/// Samples of it.
pub const SAMPLES: u64 = 20;

/// One `bladeoff run` under way, its events in a file.
pub struct Running {
    /// The orchestrator.
    pub child: Child,
    /// Where faults leave their proof.
    pub fired: PathBuf,
    events: PathBuf,
    log: PathBuf,
}

impl Running {
    /// Starts a run with these faults, separated by `;`, without `dir`.
    pub fn start(folder: &Folder, study: &str, out: &str, faults: &str) -> Self {
        Self::start_with(folder, study, out, faults, &[])
    }

    /// The same with more options.
    pub fn start_with(folder: &Folder, study: &str, out: &str, faults: &str, more: &[&str]) -> Self {
        let scratch = tempfile::tempdir_in(folder.path("")).expect("a folder").keep();
        let (fired, events, log) = (scratch.join("fired"), scratch.join("events"), scratch.join("log"));
        fs::create_dir(&fired).expect("created");
        let faults: Vec<String> = faults
            .split(';')
            .filter(|fault| !fault.is_empty())
            .map(|fault| format!("{fault},dir={}", fired.display()))
            .collect();
        let run = ["run", study, "--out", out, "--workers", "2", "--json-events"];
        let direct = bladeoff(&[&run, more].concat());
        // Whoever runs the tests may ignore SIGHUP (nohup, CI), and children inherit that; `env` becomes the program.
        let mut command = Command::new("env");
        command.arg("--default-signal=HUP").arg(direct.get_program()).args(direct.get_args());
        if let Some(folder) = direct.get_current_dir() {
            command.current_dir(folder);
        }
        for (name, value) in direct.get_envs() {
            match value {
                Some(value) => command.env(name, value),
                None => command.env_remove(name),
            };
        }
        command.stdin(Stdio::null());
        command.stdout(fs::File::create(&events).expect("created"));
        command.stderr(fs::File::create(&log).expect("created"));
        if !faults.is_empty() {
            command.env("BLADEOFF_FAULT", faults.join(";"));
        }
        Self { child: command.spawn().expect("it starts"), fired, events, log }
    }

    /// How many faults have fired.
    pub fn fired(&self) -> usize {
        fs::read_dir(&self.fired).expect("readable").count()
    }

    /// The events so far; a last line that is cut is left out.
    pub fn events(&self) -> Vec<serde_json::Value> {
        let text = fs::read_to_string(&self.events).unwrap_or_default();
        text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
    }

    /// How many events of this name there are so far.
    pub fn count(&self, name: &str) -> usize {
        self.events().iter().filter(|event| event["event"] == name).count()
    }

    /// What was said to people.
    pub fn said(&self) -> String {
        fs::read_to_string(&self.log).unwrap_or_default()
    }

    /// Its workers so far, by its events.
    pub fn workers(&self) -> BTreeSet<u32> {
        let pids = self.events();
        pids.iter().filter_map(|event| event["pid"].as_u64()).filter_map(|pid| u32::try_from(pid).ok()).collect()
    }

    /// Waits for its end.
    pub fn end(&mut self) -> std::process::ExitStatus {
        let start = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("a child") {
                return status;
            }
            assert!(start.elapsed() < WATCHDOG, "it hangs: {}", self.said());
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Waits for a state of the world.
pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < WATCHDOG, "{what}: not within {WATCHDOG:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// State letter of a process; `None` when there is none.
pub fn state(pid: u32) -> Option<char> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    stat.rsplit(')').next()?.trim().chars().next()
}

/// Whether a process is there and no zombie.
pub fn lives(pid: u32) -> bool {
    state(pid).is_some_and(|state| state != 'Z')
}

/// Sends a signal by name; says whether the process was there.
pub fn signal(pid: u32, name: &str) -> bool {
    let sent = Command::new("kill").args([&format!("-{name}"), &pid.to_string()]).stderr(Stdio::null()).status();
    sent.expect("kill runs").success()
}

/// What the runs of a result directory have left in shared memory and in /tmp, by its log.
pub fn left_behind(out: &str) -> Vec<PathBuf> {
    let log = fs::read_to_string(Path::new(out).join("workers.log")).unwrap_or_default();
    let roots =
        log.lines().filter_map(|line| line.split_once("shared memory in ")).map(|(_, root)| PathBuf::from(root));
    let mut left = Vec::new();
    for root in roots {
        let id = root.file_name().expect("an id").to_string_lossy().into_owned();
        let shm = fs::read_dir("/dev/shm").expect("readable").flatten().map(|entry| entry.path());
        left.extend(shm.filter(|path| path.to_string_lossy().contains(&format!("bladeoff_{id}_"))));
        if root.exists() {
            left.push(root);
        }
    }
    left
}
