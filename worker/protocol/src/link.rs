//! Typed messages over any transport: encoding, decoding, counting of rejected messages, and checks of the sender.

use std::collections::BTreeMap;
use std::time::Duration;

use crate::messages::{Body, FromWorker, FromWorkerBlock, MessageError, RunId, ToWorker, ToWorkerBlock, WorkerId};
use crate::transport::{HubPort, PeerId, PortError, Ticket, Waker, WorkerPort};

/// Error of a worker's communication with the orchestrator.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// Error of the transport.
    #[error(transparent)]
    Port(#[from] PortError),
    /// A message that must not be sent, or an answer that does not decode.
    #[error("bad message: {0}")]
    Message(#[from] MessageError),
}

/// The worker's end.
pub struct WorkerLink<P> {
    port: P,
    run: RunId,
    worker: WorkerId,
    outgoing: Box<FromWorkerBlock>,
    incoming: Box<ToWorkerBlock>,
}

impl<P: WorkerPort> WorkerLink<P> {
    /// A link of one worker in one run.
    pub fn new(port: P, run: RunId, worker: WorkerId) -> Self {
        Self { port, run, worker, outgoing: FromWorkerBlock::empty(), incoming: ToWorkerBlock::empty() }
    }

    /// Sends a message and returns it. Each message gets one answer, and no other message may be sent before that answer.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn send(&mut self, body: Body) -> Result<Body, LinkError> {
        let message = FromWorker { worker: self.worker, body };
        message.encode(self.run, &mut self.outgoing)?;
        self.port.send(&self.outgoing)?;
        Ok(message.body)
    }

    /// The answer, if it has arrived.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn try_receive(&mut self) -> Result<Option<ToWorker>, LinkError> {
        if !self.port.try_receive(&mut self.incoming)? {
            return Ok(None);
        }
        Ok(Some(ToWorker::decode(&self.incoming, self.run, self.worker)?))
    }

    /// Blocks until the answer arrives.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn receive(&mut self) -> Result<ToWorker, LinkError> {
        loop {
            // Checked before waiting, because the wake-up may have come already.
            if let Some(message) = self.try_receive()? {
                return Ok(message);
            }
            self.port.wait()?;
        }
    }
}

/// A checked message and the ticket for its answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Incoming {
    /// Ticket for [`HubLink::answer`].
    pub ticket: Ticket,
    /// The message; its worker number is the one that its connection belongs to.
    pub message: FromWorker,
}

/// The orchestrator's end.
pub struct HubLink<H> {
    port: H,
    run: RunId,
    incoming: Box<FromWorkerBlock>,
    outgoing: Box<ToWorkerBlock>,
    /// Worker number of each connection, fixed by the first message of the connection.
    peers: BTreeMap<PeerId, WorkerId>,
    dropped: u64,
    /// The last refusal since [`HubLink::take_refused`], and the number of refusals since then.
    refused: Option<(Refusal, u64)>,
}

/// Reason for dropping a message.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The message does not decode.
    #[error(transparent)]
    Message(MessageError),
    /// The message names a worker that its connection does not belong to, or a worker that has another connection.
    #[error("a connection spoke for worker {claimed}, which is not its own")]
    Impostor {
        /// The worker it claims to be.
        claimed: WorkerId,
    },
}

impl<H: HubPort> HubLink<H> {
    /// A link for one run.
    pub fn new(port: H, run: RunId) -> Self {
        Self {
            port,
            run,
            incoming: FromWorkerBlock::empty(),
            outgoing: ToWorkerBlock::empty(),
            peers: BTreeMap::new(),
            dropped: 0,
            refused: None,
        }
    }

    /// The next valid message; invalid ones are counted and dropped. Never blocks.
    ///
    /// # Errors
    /// Errors of the transport.
    pub fn try_receive(&mut self) -> Result<Option<Incoming>, PortError> {
        while let Some(request) = self.port.try_receive(&mut self.incoming)? {
            let checked = FromWorker::decode(&self.incoming, self.run).map_err(Refusal::Message);
            match checked.and_then(|message| self.check_speaker(request.peer, message)) {
                Ok(message) => return Ok(Some(Incoming { ticket: request.ticket, message })),
                Err(refusal) => {
                    self.port.forget(request.ticket);
                    self.dropped += 1;
                    let before = self.refused.map_or(0, |(_, count)| count);
                    self.refused = Some((refusal, before + 1));
                }
            }
        }
        Ok(None)
    }

    /// The first hello on a connection ties the connection and its worker to each other.
    fn check_speaker(&mut self, peer: PeerId, message: FromWorker) -> Result<FromWorker, Refusal> {
        let claimed = message.worker;
        let is_known = self.peers.get(&peer) == Some(&claimed);
        let is_new = matches!(message.body, Body::Hello(_))
            && !self.peers.contains_key(&peer)
            && !self.peers.values().any(|&worker| worker == claimed);
        if is_new {
            self.peers.insert(peer, claimed);
        }
        if is_known || is_new { Ok(message) } else { Err(Refusal::Impostor { claimed }) }
    }

    /// Answers a request.
    ///
    /// # Errors
    /// [`LinkError::Port`] with [`PortError::UnknownTicket`] when no worker waits for this answer any more.
    pub fn answer(&mut self, ticket: Ticket, worker: WorkerId, message: &ToWorker) -> Result<(), LinkError> {
        message.encode(self.run, worker, &mut self.outgoing)?;
        Ok(self.port.answer(ticket, worker, &self.outgoing)?)
    }

    /// Drops a request without an answer.
    pub fn forget(&mut self, ticket: Ticket) {
        self.port.forget(ticket);
    }

    /// Ends the connection of a worker that has ended, and releases the resources that the worker held.
    pub fn reap(&mut self, worker: WorkerId) {
        self.peers.retain(|_, &mut of| of != worker);
        self.port.reap();
    }

    /// Blocks until a request may be there, the waker is called, or the time has passed.
    ///
    /// # Errors
    /// Errors of the transport.
    pub fn wait(&mut self, timeout: Duration) -> Result<(), PortError> {
        self.port.wait(timeout)
    }

    /// A handle that ends a wait from another thread.
    pub fn waker(&self) -> Waker {
        self.port.waker()
    }

    /// Messages dropped so far.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// The reason for the last dropped message, and the number of messages dropped since the previous call.
    pub fn take_refused(&mut self) -> Option<(Refusal, u64)> {
        self.refused.take()
    }
}
