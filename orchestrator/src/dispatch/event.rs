//! What the loop waits for.

use std::process::ExitStatus;

use bladeoff_protocol::beat::Beat;
use bladeoff_protocol::link::{Incoming, LinkError, Refusal};
use bladeoff_protocol::messages::WorkerId;

use crate::schedule::{Death, Signal};

/// What happens to the loop.
pub(super) enum Event {
    Hub(HubEvent),
    Child(WorkerId, ChildEvent),
    Signal(Signal),
    /// The user asks what the workers do.
    Asked,
    /// The user has ended a line: the terminal has shown it.
    Typed,
}

/// What a child does, as events.
pub(super) enum ChildEvent {
    Beat(Beat),
    Line(String),
    /// It has ended, and everything it wrote has been handed over.
    Exited(ExitStatus, Death),
}

/// What the hub tells the loop.
pub(super) enum HubEvent {
    Message(Incoming),
    /// So many messages were dropped; why the last of them was.
    Refused(Refusal, u64),
    /// Everything this ended worker sent has been handed over.
    Drained(WorkerId),
    /// The answer to a ping.
    Pong,
    /// Nothing can be exchanged any more.
    Failed(LinkError),
}
