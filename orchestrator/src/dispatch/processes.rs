//! The workers' processes and their open requests.

use std::collections::BTreeMap;

use bladeoff_protocol::messages::{ToWorker, WorkerId};
use bladeoff_protocol::transport::Ticket;

use super::child::Child;
use super::hub::{Command, Hub};
use crate::schedule::Death;

/// Every worker that has not ended, or whose end has not been told yet.
#[derive(Default)]
pub(super) struct Processes {
    pub children: BTreeMap<WorkerId, Child>,
    /// Ended workers whose last messages are still on their way, and how they ended.
    pub exits: BTreeMap<WorkerId, (Death, String)>,
    /// The open request of each worker.
    pub tickets: BTreeMap<WorkerId, Ticket>,
}

impl Processes {
    pub fn pid(&self, worker: WorkerId) -> Option<u32> {
        self.children.get(&worker).map(|child| child.pid)
    }

    pub fn kill(&self, worker: WorkerId) {
        self.children.get(&worker).inspect(|child| child.kill());
    }

    /// Answers the open request of a worker, if there is one.
    pub fn answer(&mut self, hub: &Hub, worker: WorkerId, message: ToWorker) {
        if let Some(ticket) = self.tickets.remove(&worker) {
            hub.send(Command::Answer(ticket, worker, message));
        }
    }
}
