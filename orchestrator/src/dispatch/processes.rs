//! Worker processes and their open requests.

use std::collections::BTreeMap;

use bladeoff_protocol::messages::{ToWorker, WorkerId};
use bladeoff_protocol::transport::Ticket;

use super::child::Child;
use super::hub::{Command, Hub};
use crate::schedule::Death;

/// Workers that have not ended, or whose end has not been reported.
#[derive(Default)]
pub(super) struct Processes {
    pub children: BTreeMap<WorkerId, Child>,
    /// Ended workers with messages in transit, and their ends.
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
