//! Watch of the hub: removes unfinished memory of dead workers, and ends a run whose hub does not answer.

use std::time::Duration;

use bladeoff_protocol::domain::Domain;
use bladeoff_protocol::unfinished::Unfinished;

use super::error::DispatchError;
use super::hub::{Command, Hub};
use super::log::Log;

/// Ticks between two checks of unfinished memory and of the hub, about a second.
const TICKS_PER_CHECK: u32 = 5;
/// Ticks after which a silent hub is given up, about a minute. Ticks do not pass while this process is stopped.
const STUCK_TICKS: u32 = 300;

/// Watch of the hub.
pub(super) struct HubWatch {
    unfinished: Unfinished,
    ticks: u32,
    /// Tick of a request that the hub has not answered.
    pinged: Option<u32>,
}

impl HubWatch {
    pub fn new(domain: &Domain) -> Self {
        Self { unfinished: Unfinished::new(domain.address()), ticks: 0, pinged: None }
    }

    /// Takes an answer of the hub.
    pub fn pong(&mut self) {
        self.pinged = None;
    }

    /// Takes a tick of the loop.
    ///
    /// # Errors
    /// [`DispatchError::Stuck`]; the log cannot be written.
    pub fn tick(&mut self, now: Duration, hub: &Hub, log: &mut Log) -> Result<(), DispatchError> {
        self.ticks += 1;
        if self.ticks.is_multiple_of(TICKS_PER_CHECK) {
            let removed = self.unfinished.sweep(now);
            if removed > 0 {
                log.line(None, &format!("removed {removed} unfinished shared-memory segments of dead workers"))?;
            }
            if self.pinged.is_none() {
                self.pinged = Some(self.ticks);
                hub.send(Command::Ping);
            }
        }
        match self.pinged {
            Some(since) if self.ticks - since > STUCK_TICKS => {
                Err(DispatchError::Stuck { seconds: u64::from(STUCK_TICKS / TICKS_PER_CHECK) })
            }
            _ => Ok(()),
        }
    }
}
