//! The worker's end of the transport between processes.

use std::os::fd::{AsFd, OwnedFd};

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;

use crate::bus::guarded;
use crate::ipc_services::{
    BACKSTOP, FromWorkerShm, Ipc, Services, Side, ToWorkerShm, create_listener, port_name, wait,
};
use crate::messages::{FromWorkerBlock, ToWorkerBlock, WorkerId};
use crate::names::Address;
use crate::shm;
use crate::transport::{PortError, WorkerPort};

type Pending = PendingResponse<Ipc, FromWorkerShm, (), ToWorkerShm, ()>;

/// The worker's end over shared memory, bound to the thread that created it.
pub struct IpcWorker {
    // Dropped in this order: request, ports, services, node.
    pending: Option<Pending>,
    client: Client<Ipc, FromWorkerShm, (), ToWorkerShm, ()>,
    listener: Listener<Ipc>,
    notifier: Notifier<Ipc>,
    _services: Services,
    parent: Option<OwnedFd>,
}

impl IpcWorker {
    /// Connects to the orchestrator of a domain and allocates all memory for messages; `parent` is the orchestrator's pidfd, which is monitored while
    /// the worker waits.
    ///
    /// # Errors
    /// [`PortError::RootGone`], [`PortError::MemoryFull`], or another error of iceoryx2 or of the system, in particular if there is no orchestrator.
    pub fn connect(address: &Address, worker: WorkerId, parent: Option<OwnedFd>) -> Result<Self, PortError> {
        // iceoryx2 would create a missing root, and then find no orchestrator in it.
        if !address.root.is_dir() {
            return Err(PortError::RootGone { root: address.root.clone() });
        }
        guarded(|| {
            let port = Self::make(address, worker, parent)?;
            shm::close_directories(&address.root)?;
            shm::back(&address.prefix)?;
            Ok(port)
        })
    }

    fn make(address: &Address, worker: WorkerId, parent: Option<OwnedFd>) -> Result<Self, PortError> {
        let services = Services::new(address, Side::Worker)?;
        let listener = create_listener(&services.down, Some(&port_name(worker)?))?;
        let notifier = services.up.notifier_builder().create().map_err(PortError::failed("creating the notifier"))?;
        let client = services.samples.client_builder().create().map_err(PortError::failed("creating the client"))?;
        Ok(Self { pending: None, client, listener, notifier, _services: services, parent })
    }

    fn request(&mut self, block: &FromWorkerBlock) -> Result<(), PortError> {
        if self.pending.is_some() {
            return Err(PortError::RequestOpen);
        }
        let request = self.client.loan_uninit().map_err(PortError::failed("taking memory for a request"))?;
        let pending = request
            .write_payload(FromWorkerShm { words: block.words })
            .send()
            .map_err(PortError::failed("sending a request"))?;
        self.pending = Some(pending);
        self.notifier.notify().map(drop).map_err(PortError::failed("waking the orchestrator"))
    }

    fn take(&mut self, block: &mut ToWorkerBlock) -> Result<bool, PortError> {
        let Some(pending) = &self.pending else { return Ok(false) };
        let Some(response) = pending.receive().map_err(PortError::failed("receiving an answer"))? else {
            return Ok(false);
        };
        block.words = response.payload().words;
        drop(response);
        self.pending = None;
        Ok(true)
    }
}

impl WorkerPort for IpcWorker {
    fn send(&mut self, block: &FromWorkerBlock) -> Result<(), PortError> {
        guarded(|| self.request(block))
    }

    fn try_receive(&mut self, block: &mut ToWorkerBlock) -> Result<bool, PortError> {
        guarded(|| self.take(block))
    }

    fn wait(&mut self) -> Result<(), PortError> {
        let parent = self.parent.as_ref();
        let parent_ended = wait(&self.listener, parent.map(AsFd::as_fd), BACKSTOP)?;
        // An answer sent just before the end is still valid.
        if parent_ended && !self.pending.as_ref().is_some_and(PendingResponse::has_response) {
            return Err(PortError::OrchestratorGone);
        }
        Ok(())
    }
}
