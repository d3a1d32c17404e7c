//! The orchestrator's end of the transport between processes.

use std::collections::BTreeMap;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::Arc;
use std::time::Duration;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::{ListenerKey, Notifier};
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;
use rustix::event::EventfdFlags;

use crate::bus::guarded;
use crate::ipc_services::{FromWorkerShm, Ipc, Services, Side, ToWorkerShm, create_listener, port_name, wait};
use crate::messages::{FromWorkerBlock, ToWorkerBlock, WorkerId};
use crate::names::Address;
use crate::shm;
use crate::transport::{HubPort, PeerId, PortError, Request, Ticket, Waker};

type Active = ActiveRequest<Ipc, FromWorkerShm, (), ToWorkerShm, ()>;

/// Most simultaneous connections of a run: replacements of dead workers connect before the connections of these are released.
fn peers(workers: usize) -> usize {
    2 * workers + 2
}

/// Number of answers for which memory is allocated. A worker has one open request and takes its answer before the next request. So one answer may be
/// in transit and another one not yet released. iceoryx2 would allocate four times as many.
fn answers(peers: usize) -> usize {
    2 * peers + 2
}

/// Size of the largest file of a run in /dev/shm \[bytes\], rounded up.
pub(crate) fn largest_file(workers: usize) -> u64 {
    (answers(peers(workers)) * size_of::<ToWorkerShm>() + (16 << 10)) as u64
}

/// The orchestrator's end over shared memory, bound to the thread that created it.
pub struct IpcHub {
    // Dropped in this order: requests, ports, services, node.
    open: BTreeMap<Ticket, Active>,
    listeners: BTreeMap<WorkerId, ListenerKey>,
    server: Server<Ipc, FromWorkerShm, (), ToWorkerShm, ()>,
    listener: Listener<Ipc>,
    notifier: Notifier<Ipc>,
    services: Services,
    wake: Arc<OwnedFd>,
    next: u64,
}

impl IpcHub {
    /// Creates the services of a run for this many workers and allocates all memory for messages.
    ///
    /// # Errors
    /// [`PortError::MemoryFull`], or another error of iceoryx2 or of the system.
    pub fn create(address: &Address, workers: usize) -> Result<Self, PortError> {
        guarded(|| {
            shm::prepare(&address.prefix)?;
            let hub = Self::make(address, peers(workers))?;
            shm::close(address)?;
            shm::back(&address.prefix)?;
            Ok(hub)
        })
    }

    fn make(address: &Address, peers: usize) -> Result<Self, PortError> {
        let services = Services::new(address, Side::Hub(peers))?;
        let server = services
            .samples
            .server_builder()
            .override_response_preallocation(move |_| answers(peers))
            .create()
            .map_err(PortError::failed("creating the server"))?;
        let listener = create_listener(&services.up, None)?;
        let notifier = services.down.notifier_builder().create().map_err(PortError::failed("creating the notifier"))?;
        let wake = rustix::event::eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)
            .map_err(PortError::failed("creating an eventfd"))?;
        let (open, listeners) = (BTreeMap::new(), BTreeMap::new());
        Ok(Self { open, listeners, server, listener, notifier, services, wake: Arc::new(wake), next: 0 })
    }

    fn take(&mut self, block: &mut FromWorkerBlock) -> Result<Option<Request>, PortError> {
        let Some(active) = self.server.receive().map_err(PortError::failed("receiving a request"))? else {
            return Ok(None);
        };
        // Copied once from memory that other processes can write; all checks use the copy.
        block.words = active.payload().words;
        let peer = PeerId(active.origin().value());
        self.next += 1;
        let ticket = Ticket(self.next);
        self.open.insert(ticket, active);
        Ok(Some(Request { peer, ticket }))
    }

    fn send(&mut self, active: Active, worker: WorkerId, block: &ToWorkerBlock) -> Result<(), PortError> {
        let response = active.loan_uninit().map_err(PortError::failed("taking memory for an answer"))?;
        response
            .write_payload(ToWorkerShm { words: block.words })
            .send()
            .map_err(PortError::failed("sending an answer"))?;
        drop(active);
        self.wake_worker(worker)
    }

    /// Wakes one worker. A worker that cannot be woken has just died, or checks its queue after [`BACKSTOP`](crate::ipc_services::BACKSTOP).
    fn wake_worker(&mut self, worker: WorkerId) -> Result<(), PortError> {
        if let Some(key) = self.listeners.get(&worker)
            && self.notifier.notify_single_listener(key).is_ok()
        {
            return Ok(());
        }
        let name = port_name(worker)?;
        let mut found = None;
        self.notifier.for_each_listener(|one, details| {
            if details.listener_name == name && one.notify().is_ok() {
                found = Some(one.listener_key());
                return CallbackProgression::Stop;
            }
            CallbackProgression::Continue
        });
        match found {
            Some(key) => self.listeners.insert(worker, key),
            None => self.listeners.remove(&worker),
        };
        Ok(())
    }
}

impl HubPort for IpcHub {
    fn try_receive(&mut self, block: &mut FromWorkerBlock) -> Result<Option<Request>, PortError> {
        guarded(|| self.take(block))
    }

    fn answer(&mut self, ticket: Ticket, worker: WorkerId, block: &ToWorkerBlock) -> Result<(), PortError> {
        let active = self.open.remove(&ticket).ok_or(PortError::UnknownTicket(ticket))?;
        if !active.is_connected() {
            return Err(PortError::UnknownTicket(ticket));
        }
        guarded(|| self.send(active, worker, block))
    }

    fn forget(&mut self, ticket: Ticket) {
        self.open.remove(&ticket);
    }

    fn wait(&mut self, timeout: Duration) -> Result<(), PortError> {
        if wait(&self.listener, Some(self.wake.as_fd()), timeout)? {
            // Reading resets the counter; the only possible error means that it is zero already.
            let _ = rustix::io::read(&self.wake, &mut [0; 8]);
        }
        Ok(())
    }

    fn waker(&self) -> Waker {
        let wake = self.wake.clone();
        Arc::new(move || {
            // Fails only if the counter is full, and then the hub is being woken already.
            let _ = rustix::io::write(&wake, &1_u64.to_ne_bytes());
        })
    }

    fn reap(&mut self) {
        self.open.retain(|_, active| active.is_connected());
        // Missing memory is reported by the next call.
        let _ = guarded(|| {
            self.services.node.try_cleanup_dead_nodes();
            Ok(())
        });
    }
}
