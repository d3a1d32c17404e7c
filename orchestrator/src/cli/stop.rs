//! Signals while a history is written: the run ends between two steps, the recorded part is written, and the name of its file is printed.

use super::exit::Exit;
use super::output::remark;
use crate::dispatch::{Signal, watch_afterwards};
use crate::history::{Format, Recorder};
use bladeoff_core::record::{Follower, Frame};
use bladeoff_system::call;
use bladeoff_system::shown;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// State of a run with a history that a signal may end.
#[derive(Default)]
pub(super) struct Stop {
    pub is_told: AtomicBool,
    signal: OnceLock<Signal>,
    /// Temporary path of the history.
    temporary: OnceLock<PathBuf>,
}

impl Stop {
    /// Starts to listen for signals. If the run does not end between two steps within [`PATIENCE`] (its file is being written), the program ends.
    pub fn listen() -> Arc<Self> {
        let stop = Arc::new(Self::default());
        let told = Arc::clone(&stop);
        watch_afterwards(move |signal| {
            let _ = told.signal.set(signal);
            told.is_told.store(true, Ordering::Relaxed);
            std::thread::sleep(PATIENCE);
            remark(&format!("error: {}", stopped(signal, told.temporary.get().map(PathBuf::as_path))));
            std::process::exit(Exit::from(signal) as i32);
        });
        stop
    }

    /// Sets the temporary path of the history.
    pub fn writes(&self, temporary: &Path) {
        let _ = self.temporary.set(temporary.to_path_buf());
    }

    /// The received signal, if any.
    pub fn signal(&self) -> Option<Signal> {
        self.signal.get().copied()
    }
}

/// Time for a run to end between two steps.
const PATIENCE: Duration = Duration::from_secs(2);

/// Message about a stopped run, and about the incomplete history in `temporary`.
pub(super) fn stopped(signal: Signal, temporary: Option<&Path>) -> String {
    let by = match signal {
        Signal::Interrupt => "Ctrl-C",
        Signal::Terminate => "a signal",
    };
    let left = temporary.and_then(what_is_left).unwrap_or_else(|| "nothing of its history is kept".to_owned());
    format!("the run was ended by {by} before it was complete\n  {left}")
}

/// Message about the part of an incomplete history, if there is one.
pub(super) fn what_is_left(temporary: &Path) -> Option<String> {
    if !temporary.symlink_metadata().is_ok_and(|found| found.is_file() && found.len() > 0) {
        return None;
    }
    let whole =
        recovering(temporary).map(|command| format!("; to make a complete file of it: {command}")).unwrap_or_default();
    Some(format!("the part written until then is in {}{whole}", shown(temporary)))
}

/// The command that recovers an incomplete history, if its format allows that.
pub(super) fn recovering(left: &Path) -> Option<String> {
    let is_mcap = matches!(Format::of(&left.with_extension("")), Ok(Format::Mcap));
    is_mcap.then(|| call::command([OsStr::new("recover"), call::path_word(left).as_os_str()]))
}

/// A recorder that ends its run on a signal.
pub(super) struct Stoppable<'a> {
    pub recorder: &'a mut Recorder,
    pub stop: &'a AtomicBool,
}

impl Follower for Stoppable<'_> {
    fn contact_force(&mut self, diaphragm: usize, time: f64, force: f64) {
        self.recorder.contact_force(diaphragm, time, force);
    }

    fn goes_on(&mut self, step: u64) -> bool {
        !self.stop.load(Ordering::Relaxed) && self.recorder.goes_on(step)
    }

    fn wants(&mut self, step: u64, time: f64) -> bool {
        self.recorder.wants(step, time)
    }

    fn wants_end(&mut self) -> bool {
        self.recorder.wants_end()
    }

    fn see(&mut self, frame: &Frame<'_>) {
        self.recorder.see(frame);
    }
}
