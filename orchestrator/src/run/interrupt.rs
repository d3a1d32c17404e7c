//! Signals while the tables are written.

use super::lock::give_back;
use crate::dispatch::{Ended, Signal, watch_afterwards};
use bladeoff_protocol::domain::{Address, discard};
use bladeoff_worker::fault::{At, Faults};
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

/// Handles signals from now on: the first one prints what is in progress, the second one ends the program at once; `already`: the
/// first one has come. No result is lost: results are in the record, and tables are written under temporary names. `memory`:
/// shared memory that is removed then.
pub(super) fn end_at_once_when_told(already: bool, faults: &dyn Faults, memory: Option<Address>) {
    let is_signalled = AtomicBool::new(already);
    watch_afterwards(move |signal| {
        if is_signalled.swap(true, Ordering::Relaxed) {
            // Errors do not matter here: the next run removes the remains.
            memory.iter().for_each(|address| drop(discard(address)));
            give_back(Ended::Signalled(signal));
            let _ = writeln!(
                std::io::stderr(),
                "ended; every finished sample is recorded; rerun the same command to resume"
            );
            std::process::exit(match signal {
                Signal::Interrupt => 130,
                Signal::Terminate => 143,
            });
        }
        let _ = writeln!(std::io::stderr(), "the tables are being written; a second signal interrupts this, too");
    });
    // Fault hook, as for the states of a sample.
    faults.reached(At::Writing, 0, None);
}
