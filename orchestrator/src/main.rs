//! The only released binary: the tool, and its worker processes as `bladeoff worker`.

use bladeoff_worker::fault::NoFaults;
use std::process::ExitCode;

fn main() -> ExitCode {
    bladeoff::cli::main(&NoFaults)
}
