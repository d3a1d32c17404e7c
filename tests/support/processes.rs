//! Other processes: whether they live, signals, and waiting for a state.

pub use bladeoff::chaos::{STUDY, WATCHDOG, lives, state};
use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Waits for a state of the world.
pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < WATCHDOG, "{what}: not within {WATCHDOG:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Sends a signal by name; says whether the process was there.
pub fn signal(pid: u32, name: &str) -> bool {
    let sent = Command::new("kill").args([&format!("-{name}"), &pid.to_string()]).stderr(Stdio::null()).status();
    sent.expect("kill runs").success()
}

/// The children of a process.
pub fn children(pid: u32) -> Vec<u32> {
    let mut found: Vec<u32> = Vec::new();
    // Workers are started by the thread that works: that of the command, or of the test.
    for task in fs::read_dir(format!("/proc/{pid}/task")).into_iter().flatten().flatten() {
        let text = fs::read_to_string(task.path().join("children")).unwrap_or_default();
        found.extend(text.split_whitespace().filter_map(|p| p.parse::<u32>().ok()));
    }
    found.sort_unstable();
    found.dedup();
    found
}
