//! Typed messages over any transport: encoding, decoding, counting of what is refused, and who may speak for whom.

use std::collections::BTreeMap;
use std::time::Duration;

use crate::messages::{Body, FromWorker, FromWorkerBlock, MessageError, RunId, ToWorker, ToWorkerBlock, WorkerId};
use crate::transport::{HubPort, PeerId, PortError, Ticket, Waker, WorkerPort};

/// Why a worker could not talk to its orchestrator.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The transport.
    #[error(transparent)]
    Port(#[from] PortError),
    /// A message that may not be sent, or an answer that may not be believed.
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

    /// Sends a message, which is given back; it gets one answer, and no other may be sent before.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn send(&mut self, body: Body) -> Result<Body, LinkError> {
        let message = FromWorker { worker: self.worker, body };
        message.encode(self.run, &mut self.outgoing)?;
        self.port.send(&self.outgoing)?;
        Ok(message.body)
    }

    /// The answer if it is there.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn try_receive(&mut self) -> Result<Option<ToWorker>, LinkError> {
        if !self.port.try_receive(&mut self.incoming)? {
            return Ok(None);
        }
        Ok(Some(ToWorker::decode(&self.incoming, self.run, self.worker)?))
    }

    /// Blocks until the answer is there.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn receive(&mut self) -> Result<ToWorker, LinkError> {
        loop {
            // Look first: the wake-up may have come before the wait.
            if let Some(message) = self.try_receive()? {
                return Ok(message);
            }
            self.port.wait()?;
        }
    }
}

/// A checked message and the ticket by which it is answered.
#[derive(Debug, Clone, PartialEq)]
pub struct Incoming {
    /// Answers go by it.
    pub ticket: Ticket,
    /// The message; its worker is the one whose connection it came by.
    pub message: FromWorker,
}

/// The orchestrator's end.
pub struct HubLink<H> {
    port: H,
    run: RunId,
    incoming: Box<FromWorkerBlock>,
    outgoing: Box<ToWorkerBlock>,
    /// Which worker speaks by which connection, fixed by its first message.
    peers: BTreeMap<PeerId, WorkerId>,
    dropped: u64,
    /// The last one not asked for yet, and how many that were.
    refused: Option<(Refusal, u64)>,
}

/// Why a message was dropped.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// It does not decode.
    #[error(transparent)]
    Message(MessageError),
    /// It claims to be from another worker than its connection's, or a worker that has another connection.
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

    /// The next message that may be believed; others are counted and dropped. Never blocks.
    ///
    /// # Errors
    /// What the transport reports.
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

    /// A connection belongs to the worker whose hello came first by it, and a worker to that connection.
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
    /// [`LinkError::Port`] with [`PortError::UnknownTicket`] when nobody waits any more.
    pub fn answer(&mut self, ticket: Ticket, worker: WorkerId, message: &ToWorker) -> Result<(), LinkError> {
        message.encode(self.run, worker, &mut self.outgoing)?;
        Ok(self.port.answer(ticket, worker, &self.outgoing)?)
    }

    /// Drops a request without an answer.
    pub fn forget(&mut self, ticket: Ticket) {
        self.port.forget(ticket);
    }

    /// A worker has ended: its connection speaks no more, and what it left is released.
    pub fn reap(&mut self, worker: WorkerId) {
        self.peers.retain(|_, &mut of| of != worker);
        self.port.reap();
    }

    /// Blocks until a request may be there, the waker is called, or the time has passed.
    ///
    /// # Errors
    /// What the transport reports.
    pub fn wait(&mut self, timeout: Duration) -> Result<(), PortError> {
        self.port.wait(timeout)
    }

    /// Ends a wait from another thread.
    pub fn waker(&self) -> Waker {
        self.port.waker()
    }

    /// Messages dropped so far.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Why the last message was dropped, and how many were since this was asked before.
    pub fn take_refused(&mut self) -> Option<(Refusal, u64)> {
        self.refused.take()
    }
}
