//! The released binary has no fault hook.

use crate::support::{self, hooks, say};

#[test]
fn the_released_binary_contains_no_fault_hook() {
    assert_eq!(hooks::found_in(support::BINARY), [""; 0]);
}

#[test]
fn commands_of_the_developers_tools_are_unknown() {
    for (args, word) in [(&["table1"][..], "table1"), (&["bench", "chaos"], "chaos"), (&["chaos"], "chaos")] {
        let said = say(args);
        assert_eq!(said.code, 2, "{args:?}: {}", said.err);
        assert!(said.err.contains(&format!("unrecognized subcommand '{word}'")), "{}", said.err);
    }
}
