//! The binary of the developers' tools has every fault hook, and rejects faults that it does not know.

use crate::support::{self, bladeoff, hooks, said, say};

/// The counterpart of the test in `tests/program/released.rs`, which could not fail if the words were not found here.
#[test]
fn the_tools_contain_every_fault_hook() {
    assert_eq!(hooks::found_in(support::BINARY), hooks::HOOKS);
}

#[test]
fn a_fault_that_is_not_known_is_an_error_of_run_and_worker() {
    for command in ["run", "worker"] {
        let mut command = bladeoff(&[command, "study.toml"]);
        let said = said(command.env("BLADEOFF_FAULT", "who=worker,at=nowhere").output().expect("it starts"));
        assert_eq!(said.code, 2, "{}", said.err);
        assert!(said.err.contains("BLADEOFF_FAULT: at ") && said.err.contains("claimed, running"), "{}", said.err);
    }
}

#[test]
fn the_help_lists_the_tools_and_every_command_of_bladeoff_runs() {
    let help = say(&["--help"]);
    assert!(help.code == 0 && help.out.contains("  chaos ") && help.out.contains("  table1 "), "{}", help.out);
    for command in ["chaos", "table1", "run", "check"] {
        let help = say(&[command, "--help"]);
        assert!(help.code == 0 && help.out.contains("Examples:\n  bladeoff"), "{command}: {}", help.out);
    }
    assert_eq!(say(&["frobnicate"]).code, 2);
}
