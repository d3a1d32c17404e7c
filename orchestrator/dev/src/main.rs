//! The binary of the developers' tools.

use std::process::ExitCode;

fn main() -> ExitCode {
    bladeoff_dev::cli::main()
}
