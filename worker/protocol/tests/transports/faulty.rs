//! A transport that loses, doubles, delays and damages blocks, for tests; everything follows from its seed.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use bladeoff_protocol::messages::{Block, FromWorkerBlock, ToWorkerBlock, WorkerId};
use bladeoff_protocol::transport::{HubPort, PortError, Request, Ticket, Waker};
use bladeoff_system::random::SplitMix;

/// Probability of each fault per block, from 0 to 1.
#[derive(Debug, Clone, Copy, Default)]
pub struct FaultRates {
    /// Requests and answers that never arrive.
    pub lose: f64,
    /// Requests that arrive twice.
    pub double: f64,
    /// Requests that are overtaken by later ones.
    pub delay: f64,
    /// Requests and answers with one bit flipped.
    pub damage: f64,
}

/// Number of faults so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FaultCounts {
    /// Blocks lost.
    pub lost: u64,
    /// Blocks doubled.
    pub doubled: u64,
    /// Blocks delayed.
    pub delayed: u64,
    /// Blocks damaged.
    pub damaged: u64,
}

/// Wraps a hub's end with faults.
pub struct FaultyHub<H> {
    inner: H,
    rates: FaultRates,
    counts: FaultCounts,
    random: SplitMix,
    /// Delayed requests, with the number of receives until each is delivered.
    held: VecDeque<(u32, Request, Box<FromWorkerBlock>)>,
    /// Additional tickets of doubled requests: an answer goes to the original, once.
    doubles: BTreeMap<Ticket, Ticket>,
    next: u64,
}

impl<H: HubPort> FaultyHub<H> {
    /// A faulty hub around a correct one.
    pub fn new(inner: H, rates: FaultRates, seed: u64) -> Self {
        let (held, doubles) = (VecDeque::new(), BTreeMap::new());
        Self { inner, rates, counts: FaultCounts::default(), random: SplitMix(seed), held, doubles, next: 1 << 63 }
    }

    /// Number of faults so far.
    pub fn counts(&self) -> FaultCounts {
        self.counts
    }

    fn happens(&mut self, rate: f64) -> bool {
        self.random.unit() < rate
    }

    fn damage<const N: usize>(&mut self, block: &mut Block<N>) {
        let bit = self.random.word() as usize % (block.used() * 64).max(1);
        block.words[bit / 64] ^= 1 << (bit % 64);
        self.counts.damaged += 1;
    }
}

impl<H: HubPort> HubPort for FaultyHub<H> {
    fn try_receive(&mut self, block: &mut FromWorkerBlock) -> Result<Option<Request>, PortError> {
        self.held.iter_mut().for_each(|(wait, ..)| *wait = wait.saturating_sub(1));
        if let Some(at) = self.held.iter().position(|(wait, ..)| *wait == 0)
            && let Some((_, request, held)) = self.held.remove(at)
        {
            block.copy_from(&held);
            return Ok(Some(request));
        }
        while let Some(request) = self.inner.try_receive(block)? {
            if self.happens(self.rates.lose) {
                self.inner.forget(request.ticket);
                self.counts.lost += 1;
                continue;
            }
            if self.happens(self.rates.double) {
                self.next += 1;
                self.doubles.insert(Ticket(self.next), request.ticket);
                let double = Request { ticket: Ticket(self.next), ..request };
                let wait = 1 + (self.random.word() % 4) as u32;
                self.held.push_back((wait, double, Box::new(*block)));
                self.counts.doubled += 1;
            }
            if self.happens(self.rates.damage) {
                self.damage(block);
            }
            if self.happens(self.rates.delay) {
                let wait = 1 + (self.random.word() % 8) as u32;
                self.held.push_back((wait, request, Box::new(*block)));
                self.counts.delayed += 1;
                continue;
            }
            return Ok(Some(request));
        }
        Ok(None)
    }

    fn answer(&mut self, ticket: Ticket, worker: WorkerId, block: &ToWorkerBlock) -> Result<(), PortError> {
        let ticket = self.doubles.remove(&ticket).unwrap_or(ticket);
        if self.happens(self.rates.lose) {
            self.inner.forget(ticket);
            self.counts.lost += 1;
            return Ok(());
        }
        let mut block = Box::new(*block);
        if self.happens(self.rates.damage) {
            self.damage(&mut block);
        }
        self.inner.answer(ticket, worker, &block)
    }

    fn forget(&mut self, ticket: Ticket) {
        // Dropping a double leaves the original request open.
        if self.doubles.remove(&ticket).is_none() {
            self.inner.forget(ticket);
        }
    }

    fn wait(&mut self, timeout: Duration) -> Result<(), PortError> {
        if self.held.is_empty() { self.inner.wait(timeout) } else { Ok(()) }
    }

    fn waker(&self) -> Waker {
        self.inner.waker()
    }

    fn reap(&mut self) {
        self.inner.reap();
    }
}
