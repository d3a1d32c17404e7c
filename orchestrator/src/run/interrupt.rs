//! Signals while the tables are written: the run is over, so they are neither needed nor forgotten.

use super::lock::give_back;
use crate::dispatch::{Ended, Signal, watch_afterwards};
use bladeoff_protocol::domain::{Address, discard};
use bladeoff_worker::fault::{At, Faults};
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

/// From now on the first signal says what is going on and the second one ends the program at once; `already`: the first has come.
/// Nothing is lost by it: results are in the record, tables are written aside and renamed. `memory`: shared memory to be removed then.
pub(super) fn end_at_once_when_told(already: bool, faults: &dyn Faults, memory: Option<Address>) {
    let told = AtomicBool::new(already);
    watch_afterwards(move |signal| {
        if told.swap(true, Ordering::Relaxed) {
            // What is left is for the next run, and no matter now.
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
        let _ = writeln!(std::io::stderr(), "the tables are being written; a second signal ends that, too");
    });
    // A hook for tests, as there are for the states of a sample.
    faults.reached(At::Writing, 0, None);
}
