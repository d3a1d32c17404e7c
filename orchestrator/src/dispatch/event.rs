//! Events of the dispatch loop.

use std::process::ExitStatus;

use bladeoff_protocol::beat::Beat;
use bladeoff_protocol::link::{Incoming, LinkError, Refusal};
use bladeoff_protocol::messages::WorkerId;

use crate::schedule::{Death, Signal};

/// Event of the dispatch loop.
pub(super) enum Event {
    Hub(HubEvent),
    Child(WorkerId, ChildEvent),
    Signal(Signal),
    /// The user requests the activities of the workers.
    Asked,
    /// The user has ended a line: the terminal has shown it.
    Typed,
}

/// Event of a child process.
pub(super) enum ChildEvent {
    Beat(Beat),
    Line(String),
    /// End of the process, after all its output has been read.
    Exited(ExitStatus, Death),
}

/// Event of the hub.
pub(super) enum HubEvent {
    Message(Incoming),
    /// Number of discarded messages, and the reason of the last one.
    Refused(Refusal, u64),
    /// All messages of this ended worker have been passed on.
    Drained(WorkerId),
    /// The answer to a ping.
    Pong,
    /// The connection to the workers has failed.
    Failed(LinkError),
}
