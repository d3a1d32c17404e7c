//! Other processes: whether they are alive, signals, and waiting for a state.

use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Longest wait for a state.
pub const WATCHDOG: Duration = Duration::from_secs(240);

/// 20 samples of `machines/rig.toml`, without contact; each takes some milliseconds.
pub const STUDY: &str = include_str!("../../orchestrator/dev/src/chaos/study.toml");

/// State letter of a process; `None` if the process does not exist.
pub fn state(pid: u32) -> Option<char> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    stat.rsplit(')').next()?.trim().chars().next()
}

/// Whether a process still holds files and locks: it is not a zombie, or one of its threads has not ended.
pub fn lives(pid: u32) -> bool {
    let threads = || fs::read_dir(format!("/proc/{pid}/task")).into_iter().flatten().flatten().count();
    state(pid).is_some_and(|state| state != 'Z' || threads() > 1)
}

/// Waits until a condition holds.
pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < WATCHDOG, "{what}: not within {WATCHDOG:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Sends a signal by name; returns whether the process existed.
pub fn signal(pid: u32, name: &str) -> bool {
    let sent = Command::new("kill").args([&format!("-{name}"), &pid.to_string()]).stderr(Stdio::null()).status();
    sent.expect("kill runs").success()
}

/// The children of a process.
pub fn children(pid: u32) -> Vec<u32> {
    let mut found: Vec<u32> = Vec::new();
    // Workers are children of the thread that dispatches: that of the command, or of the test.
    for task in fs::read_dir(format!("/proc/{pid}/task")).into_iter().flatten().flatten() {
        let text = fs::read_to_string(task.path().join("children")).unwrap_or_default();
        found.extend(text.split_whitespace().filter_map(|p| p.parse::<u32>().ok()));
    }
    found.sort_unstable();
    found.dedup();
    found
}
