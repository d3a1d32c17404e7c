//! The loop itself: events in, effects out. What it needs is made in `start`.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use bladeoff_protocol::domain::Domain;
use bladeoff_protocol::link::{Incoming, LinkError};
use bladeoff_protocol::messages::{Batch, BatchId, Body, SampleReport, ToWorker, WorkerId};
use bladeoff_protocol::transport::Ticket;
use bladeoff_protocol::unfinished::Unfinished;
use bladeoff_worker::WorkerArgs;
use bladeoff_worker::fault::{At, Faults};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender};

use super::api::{DispatchOptions, DispatchReport, Ended, Notice, Observer, Parameters, Sink};
use super::child::Child;
use super::clock;
use super::entries::entries;
use super::error::DispatchError;
use super::event::{ChildEvent, Event, HubEvent};
use super::hub::{Command, Hub};
use super::log::Log;
use crate::schedule::{Death, Effect, KillReason, Scheduler, Until};

/// Time between looks at timers, progress and the sink.
const TICK: Duration = Duration::from_millis(200);
/// Events handled between two looks at the clock.
const EVENTS_AT_ONCE: usize = 64;

/// Ticks between two looks at unfinished memory and at the hub, about a second.
const TICKS_PER_CHECK: u32 = 5;
/// Ticks after which a hub that does not answer is given up, about a minute. Ticks do not pass while we are stopped.
const STUCK_TICKS: u32 = 300;

pub(super) struct Driver<'a> {
    options: &'a DispatchOptions,
    parameters: &'a dyn Parameters,
    sink: &'a mut dyn Sink,
    observer: &'a mut dyn Observer,
    scheduler: Scheduler,
    domain: &'a Domain,
    hub: &'a Hub,
    log: Log,
    faults: Faults,
    n_params: usize,
    children: BTreeMap<WorkerId, Child>,
    /// Ended workers whose last messages are still on their way, and how they ended.
    exits: BTreeMap<WorkerId, (Death, String)>,
    /// The open request of each worker.
    tickets: BTreeMap<WorkerId, Ticket>,
    begun: Instant,
    flushed: Instant,
    unflushed: u64,
    /// Samples recorded since the last flush and their workers' processes, kept for fault hooks only.
    not_durable: Vec<(u64, Option<u32>)>,
    refused: u64,
    first_ask: Option<Duration>,
    until: Option<Until>,
    ended: Option<Ended>,
    /// How many workers in a row did not start, and what the last of them said.
    gave_up: Option<(u32, String)>,
    /// Workers last shown as stale.
    stale: BTreeSet<u32>,
    unfinished: Unfinished,
    ticks: u32,
    /// Tick at which the hub was asked for an answer that has not come yet.
    pinged: Option<u32>,
    send: UnboundedSender<Event>,
}

/// What a run is made of.
pub(super) struct Parts<'a> {
    pub options: &'a DispatchOptions,
    pub parameters: &'a dyn Parameters,
    pub sink: &'a mut dyn Sink,
    pub observer: &'a mut dyn Observer,
    pub domain: &'a Domain,
    pub hub: &'a Hub,
    pub log: Log,
    pub faults: Faults,
    pub n_params: usize,
    pub send: UnboundedSender<Event>,
}

impl<'a> Driver<'a> {
    pub fn new(parts: Parts<'a>, scheduler: Scheduler) -> Self {
        let Parts { options, parameters, sink, observer, domain, hub, log, faults, n_params, send } = parts;
        Self {
            options,
            parameters,
            sink,
            observer,
            scheduler,
            domain,
            hub,
            log,
            faults,
            n_params,
            children: BTreeMap::new(),
            exits: BTreeMap::new(),
            tickets: BTreeMap::new(),
            begun: Instant::now(),
            flushed: Instant::now(),
            unflushed: 0,
            not_durable: Vec::new(),
            refused: 0,
            first_ask: None,
            until: options.schedule.run.until,
            ended: None,
            gave_up: None,
            stale: BTreeSet::new(),
            unfinished: Unfinished::new(domain.address()),
            ticks: 0,
            pinged: None,
            send,
        }
    }

    pub async fn run(&mut self, mut events: UnboundedReceiver<Event>) -> Result<DispatchReport, DispatchError> {
        let mut effects = Vec::new();
        self.scheduler.start(self.now(), &mut effects);
        self.carry_out(&mut effects, Vec::new())?;
        let mut tick = tokio::time::interval(TICK);
        tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        while !self.scheduler.is_over() {
            tokio::select! {
                event = events.recv() => {
                    // We hold a sender, so there is always another event to come.
                    let mut next = event;
                    for _ in 0..EVENTS_AT_ONCE {
                        let Some(event) = next else { break };
                        self.on_event(event)?;
                        next = events.try_recv().ok();
                    }
                    if let Some(event) = next {
                        self.on_event(event)?;
                    }
                }
                _ = tick.tick() => self.on_tick()?,
            }
        }
        self.flush()?;
        self.show();
        match self.gave_up.take() {
            Some((deaths, last_words)) => Err(DispatchError::WorkersDoNotStart { deaths, last_words }),
            None => Ok(self.report()),
        }
    }

    fn now(&self) -> Duration {
        self.begun.elapsed()
    }

    fn on_event(&mut self, event: Event) -> Result<(), DispatchError> {
        let now = self.now();
        let mut effects = Vec::new();
        let mut results = Vec::new();
        let heard = match &event {
            Event::Hub(HubEvent::Message(incoming)) => Some(incoming.message.worker),
            Event::Child(worker, ChildEvent::Beat(_)) => Some(*worker),
            _ => None,
        };
        match event {
            Event::Hub(HubEvent::Message(incoming)) => results = self.on_message(incoming, &mut effects)?,
            Event::Hub(HubEvent::Pong) => self.pinged = None,
            Event::Hub(HubEvent::Refused(refusal, count)) => {
                self.refused += count;
                self.log.dropped(count, &refusal)?;
            }
            Event::Hub(HubEvent::Drained(worker)) => {
                if let Some((death, how)) = self.exits.remove(&worker) {
                    self.tickets.remove(&worker);
                    let before = self.scheduler.worker_deaths();
                    self.scheduler.on_exit(now, worker, death, &mut effects);
                    let died = self.scheduler.worker_deaths() > before;
                    let said = self.log.last_words(worker).unwrap_or_else(|| how.clone());
                    if let Some(Effect::GiveUp { deaths }) = effects.iter().find(|e| matches!(e, Effect::GiveUp { .. }))
                    {
                        self.gave_up = Some((*deaths, said));
                    }
                    self.observer.noticed(&Notice::WorkerEnded { worker: worker.0, how, died });
                }
            }
            Event::Hub(HubEvent::Failed(error)) => return Err(LinkError::into(error)),
            Event::Child(worker, ChildEvent::Beat(beat)) => {
                self.scheduler.on_beat(now, worker, beat);
                if let Some(sample) = beat.sample {
                    self.faults.reached(At::Running, sample, self.pid(worker));
                }
            }
            Event::Child(worker, ChildEvent::Line(text)) => self.log.line(Some(worker), &text)?,
            Event::Child(worker, ChildEvent::Exited(status, death)) => {
                self.children.remove(&worker);
                if !status.success() {
                    let sample = self.scheduler.sample_of(worker);
                    let inside = sample.map(|sample| format!(" in sample {sample}")).unwrap_or_default();
                    self.log.ended(worker, &format!("ended{inside}: {status}"))?;
                }
                self.exits.insert(worker, (death, status.to_string()));
                self.hub.send(Command::Drain(worker));
            }
            Event::Signal(signal) => {
                self.stop(Ended::Signalled(signal), &mut effects);
            }
            Event::Asked => self.observer.asked(&self.snapshot()),
            Event::Typed => self.observer.typed(),
        }
        self.carry_out(&mut effects, results)?;
        // Shown at once: what it says may be the last sample of all, and by the next tick it has left.
        if heard.is_some_and(|worker| self.stale.contains(&worker.0)) {
            self.show();
        }
        Ok(())
    }

    /// Tells the scheduler what a worker said; returns the results in it.
    fn on_message(
        &mut self,
        incoming: Incoming,
        effects: &mut Vec<Effect>,
    ) -> Result<Vec<SampleReport>, DispatchError> {
        let now = self.now();
        let (worker, ticket) = (incoming.message.worker, incoming.ticket);
        let mut results = Vec::new();
        let is_answered = match incoming.message.body {
            Body::Hello(hello) if self.options.build.is_some_and(|build| build != hello.build) => {
                // It dies before it asked, which ends the run when it happens again and again.
                self.log.line(Some(worker), "refused: it is another build of the program")?;
                self.children.get(&worker).inspect(|child| child.kill());
                false
            }
            Body::Hello(hello) => self.scheduler.on_hello(now, worker, hello.pid, effects),
            Body::Report(report) => {
                if report.asks {
                    self.first_ask.get_or_insert(now);
                }
                if !self.faults.is_empty() {
                    let pid = self.pid(worker);
                    report.samples.iter().for_each(|done| self.faults.reached(At::Sent, done.sample, pid));
                }
                let is_answered = self.scheduler.on_report(now, worker, &report, effects);
                results = report.samples;
                is_answered
            }
        };
        if is_answered {
            self.tickets.insert(worker, ticket);
        } else {
            self.hub.send(Command::Forget(ticket));
        }
        Ok(results)
    }

    fn on_tick(&mut self) -> Result<(), DispatchError> {
        let now = self.now();
        let mut effects = Vec::new();
        let is_past_wall = self.options.schedule.run.wall.is_some_and(|wall| now >= wall);
        let is_past_until = self.until.as_mut().is_some_and(|until| until.is_reached(clock::now()));
        if (is_past_wall || is_past_until) && self.ended.is_none() && !self.scheduler.is_complete() {
            self.stop(if is_past_wall { Ended::Wall } else { Ended::Until }, &mut effects);
        }
        self.check_hub(now)?;
        self.sink.check()?;
        self.scheduler.on_tick(now, &mut effects);
        self.carry_out(&mut effects, Vec::new())?;
        if self.unflushed > 0 && self.flushed.elapsed() >= self.options.flush_every {
            self.flush()?;
        }
        self.show();
        Ok(())
    }

    fn show(&mut self) {
        let snapshot = self.snapshot();
        self.stale = snapshot.workers.iter().filter(|worker| worker.stale).map(|worker| worker.worker).collect();
        self.observer.progress(&snapshot);
    }

    /// Stops the run in order; at once, if it is stopping already.
    fn stop(&mut self, why: Ended, effects: &mut Vec<Effect>) {
        self.scheduler.on_stop(self.now(), effects);
        if self.ended.is_none() && !self.scheduler.is_complete() {
            self.observer.noticed(&Notice::Stopping(why));
        }
        self.ended.get_or_insert(why);
    }

    /// Keeps the hub from waiting for the dead, and ends a run whose hub hangs all the same.
    fn check_hub(&mut self, now: Duration) -> Result<(), DispatchError> {
        self.ticks += 1;
        if self.ticks.is_multiple_of(TICKS_PER_CHECK) {
            let removed = self.unfinished.sweep(now);
            if removed > 0 {
                self.log.line(None, &format!("removed {removed} unfinished pieces of memory of dead workers"))?;
            }
            if self.pinged.is_none() {
                self.pinged = Some(self.ticks);
                self.hub.send(Command::Ping);
            }
        }
        match self.pinged {
            Some(since) if self.ticks - since > STUCK_TICKS => {
                Err(DispatchError::Stuck { seconds: u64::from(STUCK_TICKS / TICKS_PER_CHECK) })
            }
            _ => Ok(()),
        }
    }

    /// Does what the scheduler says: first what workers wait for, then the records, so that they compute meanwhile.
    fn carry_out(&mut self, effects: &mut Vec<Effect>, results: Vec<SampleReport>) -> Result<(), DispatchError> {
        let mut spawned = Vec::new();
        for effect in effects.iter_mut() {
            match effect {
                Effect::Assign { worker, batch, attempt, samples } => {
                    let samples = std::mem::take(samples);
                    self.assign(*worker, *batch, *attempt, samples)?;
                }
                Effect::Continue(worker) => self.answer(*worker, ToWorker::Continue),
                Effect::Leave(worker) => self.answer(*worker, ToWorker::Leave),
                Effect::Stop(worker) => self.answer(*worker, ToWorker::Stop),
                Effect::Spawn(worker) => spawned.push(*worker),
                Effect::Kill { worker, why } => self.kill(*worker, *why)?,
                // Taken where the worker's end was told.
                Effect::GiveUp { .. } | Effect::Record { .. } | Effect::Quarantine { .. } => {}
            }
        }
        self.record(effects, results)?;
        effects.clear();
        if self.scheduler.has_too_many_failures() && self.ended.is_none() && !self.scheduler.is_complete() {
            self.ended = Some(Ended::TooManyFailures);
            self.observer.noticed(&Notice::Stopping(Ended::TooManyFailures));
        }
        spawned.into_iter().try_for_each(|worker| self.spawn(worker))
    }

    fn answer(&mut self, worker: WorkerId, message: ToWorker) {
        if let Some(ticket) = self.tickets.remove(&worker) {
            self.hub.send(Command::Answer(ticket, worker, message));
        }
    }

    fn assign(
        &mut self,
        worker: WorkerId,
        batch: BatchId,
        attempt: u32,
        samples: Vec<u64>,
    ) -> Result<(), DispatchError> {
        let expected = self.n_params;
        let mut params = Vec::with_capacity(samples.len() * expected);
        for &sample in &samples {
            let before = params.len();
            self.parameters.params(sample, &mut params);
            let found = params.len() - before;
            if found != expected {
                return Err(DispatchError::Parameters { sample, found, expected });
            }
        }
        let claimed = if self.faults.is_empty() { Vec::new() } else { samples.clone() };
        self.answer(worker, ToWorker::Batch(Batch { batch, attempt, n_params: expected, samples, params }));
        let pid = self.pid(worker);
        claimed.into_iter().for_each(|sample| self.faults.reached(At::Claimed, sample, pid));
        Ok(())
    }

    /// Hands accepted results and quarantined samples to the sink.
    fn record(&mut self, effects: &[Effect], results: Vec<SampleReport>) -> Result<(), DispatchError> {
        for effect in effects {
            if let Effect::Quarantine { sample, cause, worker, .. } = effect {
                self.log.line(Some(*worker), &format!("sample {sample} is quarantined: {}", cause.word()))?;
            }
        }
        let entries = entries(effects, results);
        if entries.is_empty() {
            return Ok(());
        }
        if !self.faults.is_empty() {
            let done: Vec<_> =
                entries.iter().map(|(sample, entry)| (*sample, self.pid(WorkerId(entry.worker)))).collect();
            self.not_durable.extend(done);
        }
        self.unflushed += entries.len() as u64;
        Ok(self.sink.record_all(entries)?)
    }

    fn flush(&mut self) -> Result<(), DispatchError> {
        self.sink.flush()?;
        self.unflushed = 0;
        self.flushed = Instant::now();
        for (sample, pid) in std::mem::take(&mut self.not_durable) {
            self.faults.reached(At::Recorded, sample, pid);
        }
        Ok(())
    }

    fn spawn(&mut self, worker: WorkerId) -> Result<(), DispatchError> {
        let args = WorkerArgs {
            address: self.domain.address().clone(),
            run: self.domain.run(),
            worker,
            parent: Some(std::process::id()),
            run_dir: self.options.run_dir.clone(),
            plan_hash: self.options.plan_hash.clone(),
            memory_limit: self.options.schedule.sample.memory,
            noop: self.options.noop,
        };
        let child = Child::start(self.options, &args, &self.send)?;
        self.scheduler.on_spawned(self.now(), worker, child.pid);
        self.observer.noticed(&Notice::WorkerStarted { worker: worker.0, pid: child.pid });
        self.children.insert(worker, child);
        Ok(())
    }

    fn kill(&mut self, worker: WorkerId, why: KillReason) -> Result<(), DispatchError> {
        self.observer.noticed(&Notice::WorkerKilled { worker: worker.0, why });
        self.log.killed(worker, why)?;
        self.children.get(&worker).inspect(|child| child.kill());
        Ok(())
    }

    fn pid(&self, worker: WorkerId) -> Option<u32> {
        self.children.get(&worker).map(|child| child.pid)
    }

    fn snapshot(&self) -> crate::schedule::Snapshot {
        let mut snapshot = self.scheduler.snapshot(self.now());
        snapshot.dropped_messages += self.refused;
        snapshot
    }

    fn report(&self) -> DispatchReport {
        let ended =
            if self.scheduler.is_complete() { Ended::Complete } else { self.ended.unwrap_or(Ended::TooManyFailures) };
        DispatchReport {
            done: self.scheduler.done(),
            ended,
            worker_deaths: self.scheduler.worker_deaths(),
            dropped_messages: self.scheduler.dropped() + self.refused,
            wall_s: self.now().as_secs_f64(),
            first_ask_s: self.first_ask.unwrap_or_default().as_secs_f64(),
            memory: None,
        }
    }
}
