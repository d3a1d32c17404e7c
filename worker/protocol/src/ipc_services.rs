//! The iceoryx2 services of a run, and waiting for events: the common part of both ends of the transport between processes.
//!
//! Request-response carries the blocks in shared memory: the hub is the only server, every worker a client. Request-response has no
//! wake-up, so two event services are added: `up` wakes the hub; `down` wakes one worker, whose listener is named by the worker's number.
//! Both sides block in `poll` on the event's file descriptor; the worker also polls its parent's. After every wake-up the queue is read
//! until it is empty. Every wait ends after [`BACKSTOP`] at the latest, so that a lost wake-up delays a run but does not stop it.
//!
//! The configuration is iceoryx2's default with this domain's root and prefix; configuration files of the machine are not read.

use std::os::fd::BorrowedFd;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::event::PortFactory as EventFactory;
use iceoryx2::service::port_factory::request_response::PortFactory as RequestFactory;
use iceoryx2_bb_posix::file_descriptor::FileDescriptorBased;
use rustix::event::{PollFd, PollFlags, Timespec};

use crate::bus::guarded;
use crate::messages::{FromWorkerBlock, ToWorkerBlock, WorkerId};
use crate::names::Address;
use crate::transport::PortError;

/// Longest wait before the queue is checked again.
pub const BACKSTOP: Duration = Duration::from_secs(1);

pub(crate) type Ipc = iceoryx2::service::ipc::Service;

/// [`FromWorkerBlock`] as iceoryx2 carries it. Another format has another type name, so opening its service fails.
#[derive(Debug, Clone, Copy, ZeroCopySend)]
#[repr(C)]
#[type_name("bladeoff.FromWorker.v1")]
pub(crate) struct FromWorkerShm {
    pub words: [u64; size_of::<FromWorkerBlock>() / 8],
}

/// [`ToWorkerBlock`] as iceoryx2 carries it.
#[derive(Debug, Clone, Copy, ZeroCopySend)]
#[repr(C)]
#[type_name("bladeoff.ToWorker.v1")]
pub(crate) struct ToWorkerShm {
    pub words: [u64; size_of::<ToWorkerBlock>() / 8],
}

/// A node and the three services of a run.
#[derive(Debug)]
pub(crate) struct Services {
    pub samples: RequestFactory<Ipc, FromWorkerShm, (), ToWorkerShm, ()>,
    pub up: EventFactory<Ipc>,
    pub down: EventFactory<Ipc>,
    // Last: services go before their node.
    pub node: Node<Ipc>,
}

/// The side that opens the services.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Side {
    /// Creates the services for this many simultaneous connections.
    Hub(usize),
    /// Opens the existing services.
    Worker,
}

impl Services {
    pub fn new(address: &Address, side: Side) -> Result<Self, PortError> {
        set_log_level(LogLevel::Fatal);
        let config = config(address)?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(PortError::failed("creating the iceoryx2 node"))?;
        let name = |text: &str| ServiceName::new(text).map_err(PortError::failed("naming a service"));
        let requests = node.service_builder(&name("samples")?).request_response::<FromWorkerShm, ToWorkerShm>();
        let (up, down) = (node.service_builder(&name("up")?).event(), node.service_builder(&name("down")?).event());
        let (samples, up, down) = match side {
            Side::Hub(peers) => (
                requests
                    .max_servers(1)
                    .max_clients(peers)
                    .max_nodes(peers + 1)
                    .max_active_requests_per_client(1)
                    .max_loaned_requests(1)
                    .max_response_buffer_size(1)
                    .max_borrowed_responses_per_pending_response(1)
                    .enable_safe_overflow_for_requests(false)
                    .enable_safe_overflow_for_responses(false)
                    .enable_fire_and_forget_requests(false)
                    .create()
                    .map_err(PortError::failed("creating the service samples"))?,
                up.max_notifiers(peers)
                    .max_listeners(1)
                    .max_nodes(peers + 1)
                    .create()
                    .map_err(PortError::failed("creating the service up"))?,
                down.max_notifiers(1)
                    .max_listeners(peers)
                    .max_nodes(peers + 1)
                    .create()
                    .map_err(PortError::failed("creating the service down"))?,
            ),
            Side::Worker => (
                requests.open().map_err(PortError::failed("opening the service samples"))?,
                up.open().map_err(PortError::failed("opening the service up"))?,
                down.open().map_err(PortError::failed("opening the service down"))?,
            ),
        };
        Ok(Self { samples, up, down, node })
    }
}

/// iceoryx2's default configuration with the root and prefix of this domain.
pub(crate) fn config(address: &Address) -> Result<Config, PortError> {
    let mut config = Config::default();
    let root = address.root.as_os_str().as_encoded_bytes();
    config.global.set_root_path(&Path::new(root).map_err(PortError::failed("setting the root of the domain"))?);
    config.global.prefix =
        FileName::new(address.prefix.as_bytes()).map_err(PortError::failed("setting the prefix of the domain"))?;
    // Only the hub releases resources of dead workers, after reading their last messages; all else is removed by name.
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    Ok(config)
}

/// Creates the listener of an event service, one at a time in this process.
///
/// iceoryx2 sets the umask of the process while it binds the socket of a listener and restores it afterwards. Two threads that bind at once
/// can restore each other's umask, and the process keeps one with which it cannot open its own files. Test:
/// `listeners_created_at_once_leave_the_umask` (tests/conformance.rs).
pub(crate) fn create_listener(
    service: &EventFactory<Ipc>,
    name: Option<&PortName>,
) -> Result<Listener<Ipc>, PortError> {
    static BINDING: Mutex<()> = Mutex::new(());
    let _one = BINDING.lock().unwrap_or_else(PoisonError::into_inner);
    let builder = service.listener_builder();
    let builder = if let Some(name) = name { builder.name(name) } else { builder };
    builder.create().map_err(PortError::failed("creating the listener"))
}

/// Name of a worker's listener.
pub(crate) fn port_name(worker: WorkerId) -> Result<PortName, PortError> {
    PortName::new(&worker.to_string()).map_err(PortError::failed("naming a port"))
}

/// The file descriptor that becomes readable when an event arrives.
#[expect(unsafe_code, reason = "iceoryx2 hands out its descriptor as a number only")]
fn event_fd(listener: &Listener<Ipc>) -> BorrowedFd<'_> {
    // SAFETY: the listener owns the descriptor and closes it when dropped; the result borrows the listener.
    unsafe { BorrowedFd::borrow_raw(listener.file_descriptor().native_handle()) }
}

/// Blocks until a listener has an event, the other descriptor is readable, or the time has passed; returns whether `other` is readable.
///
/// iceoryx2 0.10 does not wake a listener that it holds for woken. A notifier that comes between the reset of that flag and the emptying of
/// the socket leaves a listener that is flagged as woken but has nothing to read. No notifier wakes that listener any more, and every
/// message of the run waits for [`BACKSTOP`]. So the listener is reset before each wait and after it, whatever has ended the wait.
/// Verified by `workers_that_ask_together_are_heard_at_once` (`tests/conformance.rs`).
pub(crate) fn wait(
    listener: &Listener<Ipc>,
    other: Option<BorrowedFd<'_>>,
    timeout: Duration,
) -> Result<bool, PortError> {
    // events since the queue was last empty: the caller has to read the queue
    if guarded(|| drain(listener))? > 0 {
        return Ok(false);
    }
    let [_, readable] = wait_readable(event_fd(listener), other, timeout.min(BACKSTOP))?;
    guarded(|| drain(listener))?;
    Ok(readable)
}

/// Empties a listener, so that the next poll waits for new events; returns the number of events.
fn drain(listener: &Listener<Ipc>) -> Result<u64, PortError> {
    listener.try_wait(|_| ()).map_err(PortError::failed("reading events"))
}

/// Blocks until one of two descriptors is readable or the time has passed; returns which are readable.
fn wait_readable(
    first: BorrowedFd<'_>,
    second: Option<BorrowedFd<'_>>,
    timeout: Duration,
) -> Result<[bool; 2], PortError> {
    let mut fds = [PollFd::from_borrowed_fd(first, PollFlags::IN), PollFd::from_borrowed_fd(first, PollFlags::IN)];
    let n = match second {
        Some(second) => {
            fds[1] = PollFd::from_borrowed_fd(second, PollFlags::IN);
            2
        }
        None => 1,
    };
    let timeout = Timespec { tv_sec: timeout.as_secs() as i64, tv_nsec: i64::from(timeout.subsec_nanos()) };
    match rustix::event::poll(&mut fds[..n], Some(&timeout)) {
        Ok(_) => Ok([!fds[0].revents().is_empty(), n == 2 && !fds[1].revents().is_empty()]),
        Err(rustix::io::Errno::INTR) => Ok([true, false]),
        Err(error) => Err(PortError::failed("waiting for events")(error)),
    }
}
