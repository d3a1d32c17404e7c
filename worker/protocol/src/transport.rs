//! Carrying blocks between one orchestrator (the hub) and its workers.
//!
//! The rules every transport keeps, tested by `tests/conformance.rs`:
//! a worker sends a request and gets at most one answer to it; a second request before the answer is refused; the hub
//! receives requests of one worker in their order and answers when it likes, each by its ticket; waiting blocks and costs
//! no CPU; a peer that is gone makes an error or nothing, never a hang of the other side.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use crate::messages::{FromWorkerBlock, ToWorkerBlock, WorkerId};
use bladeoff_system::shown;

/// A connection, as the transport knows it; never taken from a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PeerId(pub u128);

/// A request that waits for its answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Ticket(pub u64);

/// A request as it arrives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Request {
    /// Who sent it.
    pub peer: PeerId,
    /// By which it is answered.
    pub ticket: Ticket,
}

/// Ends a [`HubPort::wait`] from another thread.
pub type Waker = Arc<dyn Fn() + Send + Sync>;

/// Why a transport did not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// The orchestrator's process has ended.
    #[error("the orchestrator is gone")]
    OrchestratorGone,
    /// The last request has no answer yet.
    #[error("the last request has not been answered yet")]
    RequestOpen,
    /// No such request, or its worker is gone.
    #[error("request {} is unknown, answered, or its worker is gone", .0.0)]
    UnknownTicket(Ticket),
    /// The directory of the run is not there.
    #[error("{} is gone: the run has ended, or another program cleaned that folder", shown(root))]
    RootGone {
        /// Where it was.
        root: PathBuf,
    },
    /// There is no shared memory for what was to be made.
    #[error(
        "/dev/shm is full ({free} bytes are free): something else fills it, or it is too small; make room or enlarge it (Docker: --shm-size)"
    )]
    MemoryFull {
        /// Bytes free afterwards.
        free: u64,
    },
    /// A file of ours that others may open, and that is none of those which are known to be so.
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
        /// What was being done.
        doing: &'static str,
        /// Why it failed.
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
    /// [`PortError::RequestOpen`] before the last one was answered; otherwise what the transport reports.
    fn send(&mut self, block: &FromWorkerBlock) -> Result<(), PortError>;

    /// Takes the answer if it is there; never blocks.
    ///
    /// # Errors
    /// What the transport reports.
    fn try_receive(&mut self, block: &mut ToWorkerBlock) -> Result<bool, PortError>;

    /// Blocks until an answer may be there.
    ///
    /// # Errors
    /// [`PortError::OrchestratorGone`] when none will ever come.
    fn wait(&mut self) -> Result<(), PortError>;
}

/// The orchestrator's end.
pub trait HubPort {
    /// Takes the next request if there is one; never blocks.
    ///
    /// # Errors
    /// What the transport reports.
    fn try_receive(&mut self, block: &mut FromWorkerBlock) -> Result<Option<Request>, PortError>;

    /// Answers a request and wakes that worker.
    ///
    /// # Errors
    /// [`PortError::UnknownTicket`] when nobody waits for the answer; otherwise what the transport reports.
    fn answer(&mut self, ticket: Ticket, worker: WorkerId, block: &ToWorkerBlock) -> Result<(), PortError>;

    /// Drops a request without an answer.
    fn forget(&mut self, ticket: Ticket);

    /// Blocks until a request may be there, the waker is called, or the time has passed.
    ///
    /// # Errors
    /// What the transport reports.
    fn wait(&mut self, timeout: Duration) -> Result<(), PortError>;

    /// Ends a wait from another thread.
    fn waker(&self) -> Waker;

    /// Releases what dead workers left behind; may take some ten milliseconds.
    fn reap(&mut self);
}
