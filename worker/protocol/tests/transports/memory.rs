//! Transport within one process, for tests.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use bladeoff_protocol::messages::{FromWorkerBlock, ToWorkerBlock, WorkerId};
use bladeoff_protocol::transport::{HubPort, PeerId, PortError, Request, Ticket, Waker, WorkerPort};

#[derive(Default)]
struct State {
    requests: VecDeque<(Request, Box<FromWorkerBlock>)>,
    answers: BTreeMap<Ticket, Box<ToWorkerBlock>>,
    /// Requests that the hub has received.
    open: BTreeMap<Ticket, PeerId>,
    next: u64,
    woken: bool,
    hub_is_gone: bool,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Creates connections to one [`MemoryHub`].
#[derive(Clone, Default)]
pub struct MemoryNet(Arc<Shared>);

impl MemoryNet {
    /// The orchestrator's end; one per network.
    #[must_use]
    pub fn hub(&self) -> MemoryHub {
        MemoryHub(self.0.clone())
    }

    /// The end of a new worker.
    #[must_use]
    pub fn worker(&self) -> MemoryWorker {
        let mut state = self.0.lock();
        state.next += 1;
        MemoryWorker { shared: self.0.clone(), peer: PeerId(u128::from(state.next)), open: None }
    }
}

/// The orchestrator's end in memory.
pub struct MemoryHub(Arc<Shared>);

impl Drop for MemoryHub {
    fn drop(&mut self) {
        self.0.lock().hub_is_gone = true;
        self.0.changed.notify_all();
    }
}

impl HubPort for MemoryHub {
    fn try_receive(&mut self, block: &mut FromWorkerBlock) -> Result<Option<Request>, PortError> {
        let mut state = self.0.lock();
        Ok(state.requests.pop_front().map(|(request, sent)| {
            block.copy_from(&sent);
            state.open.insert(request.ticket, request.peer);
            request
        }))
    }

    fn answer(&mut self, ticket: Ticket, _worker: WorkerId, block: &ToWorkerBlock) -> Result<(), PortError> {
        let mut state = self.0.lock();
        state.open.remove(&ticket).ok_or(PortError::UnknownTicket(ticket))?;
        state.answers.insert(ticket, Box::new(*block));
        self.0.changed.notify_all();
        Ok(())
    }

    fn forget(&mut self, ticket: Ticket) {
        self.0.lock().open.remove(&ticket);
    }

    fn wait(&mut self, timeout: Duration) -> Result<(), PortError> {
        let state = self.0.lock();
        let wait = self.0.changed.wait_timeout_while(state, timeout, |s| s.requests.is_empty() && !s.woken);
        wait.unwrap_or_else(PoisonError::into_inner).0.woken = false;
        Ok(())
    }

    fn waker(&self) -> Waker {
        let shared = self.0.clone();
        Arc::new(move || {
            shared.lock().woken = true;
            shared.changed.notify_all();
        })
    }

    fn reap(&mut self) {}
}

/// A worker's end in memory.
pub struct MemoryWorker {
    shared: Arc<Shared>,
    peer: PeerId,
    open: Option<Ticket>,
}

impl Drop for MemoryWorker {
    fn drop(&mut self) {
        // As for a dead process: sent requests stay readable, and answers to them are not delivered any more.
        let mut state = self.shared.lock();
        state.open.retain(|_, peer| *peer != self.peer);
    }
}

impl WorkerPort for MemoryWorker {
    fn send(&mut self, block: &FromWorkerBlock) -> Result<(), PortError> {
        if self.open.is_some() {
            return Err(PortError::RequestOpen);
        }
        let mut state = self.shared.lock();
        if state.hub_is_gone {
            return Err(PortError::OrchestratorGone);
        }
        state.next += 1;
        let ticket = Ticket(state.next);
        state.requests.push_back((Request { peer: self.peer, ticket }, Box::new(*block)));
        self.open = Some(ticket);
        self.shared.changed.notify_all();
        Ok(())
    }

    fn try_receive(&mut self, block: &mut ToWorkerBlock) -> Result<bool, PortError> {
        let Some(ticket) = self.open else { return Ok(false) };
        let Some(answer) = self.shared.lock().answers.remove(&ticket) else { return Ok(false) };
        block.copy_from(&answer);
        self.open = None;
        Ok(true)
    }

    fn wait(&mut self) -> Result<(), PortError> {
        let open = self.open;
        let state = self.shared.lock();
        let has_answer = |s: &State| open.is_some_and(|ticket| s.answers.contains_key(&ticket));
        let state = self
            .shared
            .changed
            .wait_while(state, |s| !has_answer(s) && !s.hub_is_gone)
            .unwrap_or_else(PoisonError::into_inner);
        if has_answer(&state) { Ok(()) } else { Err(PortError::OrchestratorGone) }
    }
}
