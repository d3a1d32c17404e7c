//! Hub: thread that owns the iceoryx2 ports.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use bladeoff_protocol::domain::{Address, foreign_files};
use bladeoff_protocol::ipc::{BACKSTOP, IpcHub};
use bladeoff_protocol::link::{HubLink, LinkError};
use bladeoff_protocol::messages::{RunId, ToWorker, WorkerId};
use bladeoff_protocol::transport::{HubPort, PortError, Ticket, Waker};
use tokio::sync::mpsc::UnboundedSender;

use super::error::DispatchError;
use super::event::{Event, HubEvent};

/// Time limit for creating and dropping the ports. Creation takes milliseconds and dropping about ten, but iceoryx2 waits for a
/// file with one of our names that another process has created and never fills.
const PATIENCE: Duration = Duration::from_secs(60);

/// Command to the hub.
pub(super) enum Command {
    Answer(Ticket, WorkerId, ToWorker),
    Forget(Ticket),
    /// The worker's process has ended: pass its messages on, report that, then release its resources.
    Drain(WorkerId),
    /// Answer, as proof that the thread runs.
    Ping,
}

/// Handle of the loop to the hub thread; dropping it ends the thread and releases the ports.
pub(super) struct Hub {
    commands: Option<Sender<Command>>,
    waker: Waker,
    thread: Option<JoinHandle<()>>,
    /// Closed with the thread.
    ended: Receiver<()>,
}

impl Hub {
    /// Starts the thread and creates the ports on it.
    pub fn start(
        address: &Address,
        run: RunId,
        workers: usize,
        events: UnboundedSender<Event>,
    ) -> Result<Self, DispatchError> {
        let (commands, received) = channel();
        let (ready, is_ready) = channel::<Result<Waker, PortError>>();
        let (alive, ended) = channel();
        let (prefix, address) = (address.prefix.clone(), address.clone());
        let body = move || {
            let _alive: Sender<()> = alive;
            make_and_serve(&address, workers, run, &ready, &received, &events);
        };
        let thread = std::thread::Builder::new()
            .name("hub".into())
            .spawn(body)
            .map_err(|source| DispatchError::System { doing: "starting the thread for messages", source })?;
        let waker = match is_ready.recv_timeout(PATIENCE) {
            Ok(waker) => waker.map_err(LinkError::Port)?,
            // The thread panicked; the reason is on standard error.
            Err(RecvTimeoutError::Disconnected) => return Err(LinkError::Port(PortError::OrchestratorGone).into()),
            Err(RecvTimeoutError::Timeout) => {
                return Err(DispatchError::MemoryStuck {
                    seconds: PATIENCE.as_secs(),
                    foreign: foreign_files(&prefix),
                });
            }
        };
        Ok(Self { commands: Some(commands), waker, thread: Some(thread), ended })
    }

    /// Sends a command; commands are executed in order.
    pub fn send(&self, command: Command) {
        // An ended hub has sent its error, which the loop will read.
        let _ = self.commands.as_ref().map(|commands| commands.send(command));
        (self.waker)();
    }

    /// Abandons a stuck thread.
    pub fn abandon(&mut self) {
        self.thread = None;
    }
}

impl Drop for Hub {
    fn drop(&mut self) {
        self.commands = None;
        (self.waker)();
        let Some(thread) = self.thread.take() else { return };
        // A thread that does not end is ended with the process; the results are recorded.
        if !matches!(self.ended.recv_timeout(PATIENCE), Err(RecvTimeoutError::Timeout)) {
            let _ = thread.join();
        }
    }
}

fn make_and_serve(
    address: &Address,
    workers: usize,
    run: RunId,
    ready: &Sender<Result<Waker, PortError>>,
    received: &Receiver<Command>,
    events: &UnboundedSender<Event>,
) {
    let port = match IpcHub::create(address, workers) {
        Ok(port) => port,
        Err(error) => {
            let _ = ready.send(Err(error));
            return;
        }
    };
    let link = HubLink::new(port, run);
    let _ = ready.send(Ok(link.waker()));
    let served = catch_unwind(AssertUnwindSafe(|| serve(link, received, events)));
    if served.is_err() {
        // iceoryx2 panics in states that it considers impossible; its message is on standard error.
        let _ = events.send(Event::Hub(HubEvent::Failed(LinkError::Port(PortError::OrchestratorGone))));
    }
}

fn serve(mut link: HubLink<IpcHub>, commands: &Receiver<Command>, events: &UnboundedSender<Event>) {
    let tell = |event| {
        let _ = events.send(Event::Hub(event));
    };
    loop {
        match exchange(&mut link, commands, &tell).and_then(|go_on| {
            if go_on {
                link.wait(BACKSTOP)?;
            }
            Ok(go_on)
        }) {
            Ok(true) => {}
            Ok(false) => return,
            Err(error) => return tell(HubEvent::Failed(error)),
        }
    }
}

/// Executes all commands and takes all messages; returns false when the loop has dropped the hub.
fn exchange(
    link: &mut HubLink<IpcHub>,
    commands: &Receiver<Command>,
    tell: &dyn Fn(HubEvent),
) -> Result<bool, LinkError> {
    loop {
        match commands.try_recv() {
            Ok(Command::Answer(ticket, worker, message)) => match link.answer(ticket, worker, &message) {
                // Its process has just ended; the loop will receive this event.
                Ok(()) | Err(LinkError::Port(PortError::UnknownTicket(_))) => {}
                Err(error) => return Err(error),
            },
            Ok(Command::Forget(ticket)) => link.forget(ticket),
            Ok(Command::Ping) => tell(HubEvent::Pong),
            Ok(Command::Drain(worker)) => {
                take(link, tell)?;
                tell(HubEvent::Drained(worker));
                link.reap(worker);
            }
            Err(TryRecvError::Empty) => break,
            Err(TryRecvError::Disconnected) => return Ok(false),
        }
    }
    take(link, tell)?;
    Ok(true)
}

fn take(link: &mut HubLink<impl HubPort>, tell: &dyn Fn(HubEvent)) -> Result<(), LinkError> {
    while let Some(incoming) = link.try_receive()? {
        tell(HubEvent::Message(incoming));
    }
    if let Some((refusal, count)) = link.take_refused() {
        tell(HubEvent::Refused(refusal, count));
    }
    Ok(())
}

#[cfg(test)]
#[path = "../../../worker/protocol/tests/transports/mod.rs"]
mod transports;

#[cfg(test)]
mod tests {
    use super::transports::MemoryNet;
    use super::*;
    use bladeoff_protocol::messages::{Body, FromWorker, FromWorkerBlock, Hello};
    use bladeoff_protocol::transport::WorkerPort;
    use std::cell::RefCell;

    /// Damaged messages before, between and after valid ones.
    #[test]
    fn every_message_that_is_dropped_is_counted() {
        let (run, net) = (RunId(7), MemoryNet::default());
        let send = |worker: u32, is_sound: bool| {
            let message = FromWorker { worker: WorkerId(worker), body: Body::Hello(Hello { pid: 1, build: 2 }) };
            let mut block = FromWorkerBlock::empty();
            message.encode(run, &mut block).expect("it fits");
            if !is_sound {
                block.words[3] ^= 1;
            }
            net.worker().send(&block).expect("memory has room");
        };
        for (worker, is_sound) in [(1, false), (2, false), (3, true), (4, false), (5, true), (6, false), (7, false)] {
            send(worker, is_sound);
        }
        let mut link = HubLink::new(net.hub(), run);
        let told = RefCell::new(Vec::new());
        take(&mut link, &|event| told.borrow_mut().push(event)).expect("memory does not fail");
        let count = |event: &HubEvent| match event {
            HubEvent::Refused(_, count) => *count,
            _ => 0,
        };
        let messages = told.borrow().iter().filter(|event| matches!(event, HubEvent::Message(_))).count();
        assert_eq!((messages, told.borrow().iter().map(count).sum::<u64>(), link.dropped()), (2, 5, 5));
    }
}
