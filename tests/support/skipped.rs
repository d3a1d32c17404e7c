//! Report of skipped tests below the summary of their program: the harness shows output of failing tests only, and a line among a hundred others
//! would be overlooked.

use std::io::Write;
use std::sync::{Mutex, PoisonError};

static SKIPPED: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Reports a skipped test and the reason.
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
        // errors at the end of the program are ignored
        let _ = writeln!(out, "{line}");
    }
    let _ = writeln!(out);
    let _ = out.flush();
}
