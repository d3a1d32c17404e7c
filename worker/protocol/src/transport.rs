//! Transport of blocks between one orchestrator (the hub) and its workers.
//!
//! Rules for every transport, tested by `tests/conformance.rs`:
//! a worker sends a request and gets at most one answer to it; a second request before the answer is rejected; the hub
//! receives the requests of one worker in order and answers at any time, each by its ticket; waiting blocks and costs
//! no CPU; a peer that has ended causes an error or nothing, never a hang of the other side.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use crate::messages::{FromWorkerBlock, ToWorkerBlock, WorkerId};
use bladeoff_system::shown;

/// Identifier of a connection, assigned by the transport and never taken from a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PeerId(pub u128);

/// Identifier of a request, needed to answer it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Ticket(pub u64);

/// A received request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Request {
    /// Connection of the sender.
    pub peer: PeerId,
    /// Ticket for the answer.
    pub ticket: Ticket,
}

/// Ends a [`HubPort::wait`] from another thread.
pub type Waker = Arc<dyn Fn() + Send + Sync>;

/// Error of a transport.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// The orchestrator's process has ended.
    #[error("the orchestrator is gone")]
    OrchestratorGone,
    /// The last request has no answer yet.
    #[error("the last request has not been answered yet")]
    RequestOpen,
    /// The request does not exist, has been answered, or its worker is gone.
    #[error("request {} is unknown, answered, or its worker is gone", .0.0)]
    UnknownTicket(Ticket),
    /// The directory of the run is gone.
    #[error("{} is gone: the run has ended, or another program cleaned that folder", shown(root))]
    RootGone {
        /// Path of the directory.
        root: PathBuf,
    },
    /// Shared memory is full.
    #[error(
        "/dev/shm is full ({free} bytes are free): something else fills it, or it is too small; make room or enlarge it (Docker: --shm-size)"
    )]
    MemoryFull {
        /// Free bytes after the failure.
        free: u64,
    },
    /// A file of the run that other users may open, except for the known one, which is replaced.
    #[error("other users can access {}, which must be private", shown(path))]
    OpenToOthers {
        /// The file.
        path: PathBuf,
    },
    /// No more files can be opened.
    #[error(
        "no more files can be opened: this process may have {limit} open (ulimit -n), and has {open}; raise the limit or use fewer workers"
    )]
    NoDescriptors {
        /// The limit.
        limit: u64,
        /// Open files.
        open: u64,
    },
    /// The system or iceoryx2 refused an operation.
    #[error("{doing} failed")]
    Failed {
        /// Operation that failed.
        doing: &'static str,
        /// Error of the system or of iceoryx2.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl PortError {
    /// Wraps an error of a lower layer.
    pub fn failed<E: std::error::Error + Send + Sync + 'static>(doing: &'static str) -> impl FnOnce(E) -> Self {
        move |source| PortError::Failed { doing, source: Box::new(source) }
    }
}

/// The worker's end.
pub trait WorkerPort {
    /// Sends a request.
    ///
    /// # Errors
    /// [`PortError::RequestOpen`] before the last request was answered; otherwise errors of the transport.
    fn send(&mut self, block: &FromWorkerBlock) -> Result<(), PortError>;

    /// Takes the answer if it has arrived; never blocks.
    ///
    /// # Errors
    /// Errors of the transport.
    fn try_receive(&mut self, block: &mut ToWorkerBlock) -> Result<bool, PortError>;

    /// Blocks until an answer may have arrived.
    ///
    /// # Errors
    /// [`PortError::OrchestratorGone`] when no answer can come any more.
    fn wait(&mut self) -> Result<(), PortError>;
}

/// The orchestrator's end.
pub trait HubPort {
    /// Takes the next request if there is one; never blocks.
    ///
    /// # Errors
    /// Errors of the transport.
    fn try_receive(&mut self, block: &mut FromWorkerBlock) -> Result<Option<Request>, PortError>;

    /// Answers a request and wakes that worker.
    ///
    /// # Errors
    /// [`PortError::UnknownTicket`] when no worker waits for the answer; otherwise errors of the transport.
    fn answer(&mut self, ticket: Ticket, worker: WorkerId, block: &ToWorkerBlock) -> Result<(), PortError>;

    /// Drops a request without an answer.
    fn forget(&mut self, ticket: Ticket);

    /// Blocks until a request may be there, the waker is called, or the time has passed.
    ///
    /// # Errors
    /// Errors of the transport.
    fn wait(&mut self, timeout: Duration) -> Result<(), PortError>;

    /// A handle that ends a wait from another thread.
    fn waker(&self) -> Waker;

    /// Releases resources of dead workers; may take some ten milliseconds.
    fn reap(&mut self);
}
