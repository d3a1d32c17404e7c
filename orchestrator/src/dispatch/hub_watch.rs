//! Keeps the hub from waiting for the dead, and ends a run whose hub hangs all the same.

use std::time::Duration;

use bladeoff_protocol::domain::Domain;
use bladeoff_protocol::unfinished::Unfinished;

use super::error::DispatchError;
use super::hub::{Command, Hub};
use super::log::Log;

/// Ticks between two looks at unfinished memory and at the hub, about a second.
const TICKS_PER_CHECK: u32 = 5;
/// Ticks after which a hub that does not answer is given up, about a minute. Ticks do not pass while we are stopped.
const STUCK_TICKS: u32 = 300;

/// Looks after the hub, tick by tick.
pub(super) struct HubWatch {
    unfinished: Unfinished,
    ticks: u32,
    /// Tick at which the hub was asked for an answer that has not come yet.
    pinged: Option<u32>,
}

impl HubWatch {
    pub fn new(domain: &Domain) -> Self {
        Self { unfinished: Unfinished::new(domain.address()), ticks: 0, pinged: None }
    }

    /// The hub has answered.
    pub fn pong(&mut self) {
        self.pinged = None;
    }

    /// A tick of the loop.
    ///
    /// # Errors
    /// [`DispatchError::Stuck`]; the log cannot be written.
    pub fn tick(&mut self, now: Duration, hub: &Hub, log: &mut Log) -> Result<(), DispatchError> {
        self.ticks += 1;
        if self.ticks.is_multiple_of(TICKS_PER_CHECK) {
            let removed = self.unfinished.sweep(now);
            if removed > 0 {
                log.line(None, &format!("removed {removed} unfinished pieces of memory of dead workers"))?;
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
