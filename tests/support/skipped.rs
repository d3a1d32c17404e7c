//! Tests that cannot be made here say so below the summary of their program: what a test writes by itself, the harness shows of failing ones only, and
//! among a hundred lines nobody sees it.

use std::io::Write;
use std::sync::{Mutex, PoisonError};

static SKIPPED: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// This was not tested, and why.
#[expect(unsafe_code, reason = "the standard library knows no end of the program")]
pub fn skipped(what: &str, why: &str) {
    let mut all = SKIPPED.lock().unwrap_or_else(PoisonError::into_inner);
    if all.is_empty() {
        // SAFETY: the function is there as long as the program, allocates and locks like any other, and is called once at its end.
        unsafe { libc::atexit(tell) };
    }
    let line = format!("SKIPPED, not tested: {what} ({why})");
    if !all.contains(&line) {
        all.push(line);
    }
}

extern "C" fn tell() {
    let all = SKIPPED.lock().unwrap_or_else(PoisonError::into_inner);
    let mut out = std::io::stdout().lock();
    for line in all.iter() {
        // Nobody is left to be told of an error.
        let _ = writeln!(out, "{line}");
    }
    let _ = writeln!(out);
    let _ = out.flush();
}
