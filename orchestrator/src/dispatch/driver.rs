//! Dispatch loop: takes events, executes effects. `start` creates its parts.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use bladeoff_protocol::domain::Domain;
use bladeoff_protocol::link::{Incoming, LinkError};
use bladeoff_protocol::messages::{Batch, BatchId, Body, SampleReport, ToWorker, WorkerId};
use bladeoff_worker::WorkerArgs;
use bladeoff_worker::fault::At;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender};

use super::api::{DispatchOptions, DispatchReport, More, Notice, Observer, Parameters, Sink};
use super::child::Child;
use super::clock;
use super::entries::entries;
use super::error::DispatchError;
use super::event::{ChildEvent, Event, HubEvent};
use super::flushing::Flushing;
use super::hub::{Command, Hub};
use super::hub_watch::HubWatch;
use super::log::Log;
use super::processes::Processes;
use crate::schedule::{Effect, Ended, KillReason, Scheduler};

/// Interval of timers, progress and checks of the sink.
const TICK: Duration = Duration::from_millis(200);
/// Largest number of events between two readings of the clock.
const EVENTS_AT_ONCE: usize = 64;

/// Parts of a run.
pub(super) struct Parts<'a> {
    pub options: &'a DispatchOptions,
    pub parameters: &'a dyn Parameters,
    pub sink: &'a mut dyn Sink,
    pub observer: &'a mut dyn Observer,
    pub domain: &'a Domain,
    pub hub: &'a Hub,
    pub log: Log,
    pub n_params: usize,
    pub send: UnboundedSender<Event>,
}

/// Passes events to the scheduler and executes its effects.
pub(super) struct Driver<'a> {
    parts: Parts<'a>,
    scheduler: Scheduler,
    processes: Processes,
    flushing: Flushing,
    hub_watch: HubWatch,
    begun: Instant,
    first_ask: Option<Duration>,
    /// Messages that the hub refused.
    refused: u64,
    /// Number of workers in a row that did not start, and the last message of the last one.
    gave_up: Option<(u32, String)>,
    /// Workers last shown as stale.
    stale: BTreeSet<u32>,
}

impl<'a> Driver<'a> {
    pub fn new(parts: Parts<'a>, scheduler: Scheduler) -> Self {
        Self {
            scheduler,
            processes: Processes::default(),
            flushing: Flushing::new(),
            hub_watch: HubWatch::new(parts.domain),
            begun: Instant::now(),
            first_ask: None,
            refused: 0,
            gave_up: None,
            stale: BTreeSet::new(),
            parts,
        }
    }

    pub async fn run(&mut self, mut events: UnboundedReceiver<Event>) -> Result<DispatchReport, DispatchError> {
        let mut effects = Vec::new();
        self.scheduler.start(self.now(), &mut effects);
        self.carry_out(&mut effects, Vec::new())?;
        self.feed()?;
        let mut tick = tokio::time::interval(TICK);
        tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        while !self.scheduler.is_over() {
            tokio::select! {
                event = events.recv() => {
                    // The driver holds a sender, so the channel stays open.
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
            None => {
                let ended = self.scheduler.ended();
                Ok(self.report(ended.expect("a run whose workers start is over when it is complete or was stopped")))
            }
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
            Event::Hub(HubEvent::Pong) => self.hub_watch.pong(),
            Event::Hub(HubEvent::Refused(refusal, count)) => {
                self.refused += count;
                self.parts.log.dropped(count, &refusal)?;
            }
            Event::Hub(HubEvent::Drained(worker)) => {
                if let Some((death, how)) = self.processes.exits.remove(&worker) {
                    self.processes.tickets.remove(&worker);
                    let before = self.scheduler.worker_deaths();
                    self.scheduler.on_exit(now, worker, death, &mut effects);
                    let died = self.scheduler.worker_deaths() > before;
                    let said = self.parts.log.last_words(worker).unwrap_or_else(|| how.clone());
                    if let Some(Effect::GiveUp { deaths }) = effects.iter().find(|e| matches!(e, Effect::GiveUp { .. }))
                    {
                        self.gave_up = Some((*deaths, said));
                    }
                    self.parts.observer.noticed(&Notice::WorkerEnded { worker: worker.0, how, died });
                }
            }
            Event::Hub(HubEvent::Failed(error)) => return Err(LinkError::into(error)),
            Event::Child(worker, ChildEvent::Beat(beat)) => {
                self.scheduler.on_beat(now, worker, beat);
                if let Some(sample) = beat.sample {
                    self.parts.options.faults.reached(At::Running, sample, self.processes.pid(worker));
                }
            }
            Event::Child(worker, ChildEvent::Line(text)) => self.parts.log.line(Some(worker), &text)?,
            Event::Child(worker, ChildEvent::Exited(status, death)) => {
                self.processes.children.remove(&worker);
                if !status.success() {
                    let sample = self.scheduler.sample_of(worker);
                    let inside = sample.map(|sample| format!(" in sample {sample}")).unwrap_or_default();
                    self.parts.log.ended(worker, &format!("ended{inside}: {status}"))?;
                }
                self.processes.exits.insert(worker, (death, status.to_string()));
                self.parts.hub.send(Command::Drain(worker));
            }
            Event::Signal(signal) => self.scheduler.on_stop(now, signal, &mut effects),
            Event::Asked => self.parts.observer.asked(&self.snapshot()),
            Event::Typed => self.parts.observer.typed(),
        }
        self.carry_out(&mut effects, results)?;
        self.feed()?;
        // Shown at once: the message may contain the worker's last results, and the worker may have ended by the next tick.
        if heard.is_some_and(|worker| self.stale.contains(&worker.0)) {
            self.show();
        }
        Ok(())
    }

    /// Passes a worker's message to the scheduler; returns its accepted results.
    fn on_message(
        &mut self,
        incoming: Incoming,
        effects: &mut Vec<Effect>,
    ) -> Result<Vec<SampleReport>, DispatchError> {
        let now = self.now();
        let (worker, ticket) = (incoming.message.worker, incoming.ticket);
        let mut results = Vec::new();
        let is_answered = match incoming.message.body {
            Body::Hello(hello) if self.parts.options.build.is_some_and(|build| build != hello.build) => {
                // The worker ends before it requests work; if this happens repeatedly, the run ends.
                self.parts.log.line(Some(worker), "rejected: it is another build of the program")?;
                self.processes.kill(worker);
                false
            }
            Body::Hello(hello) => self.scheduler.on_hello(now, worker, hello.pid, effects),
            Body::Report(report) => {
                if report.asks {
                    self.first_ask.get_or_insert(now);
                }
                if !self.parts.options.faults.is_empty() {
                    let pid = self.processes.pid(worker);
                    report
                        .samples
                        .iter()
                        .for_each(|done| self.parts.options.faults.reached(At::Sent, done.sample, pid));
                }
                let is_answered = self.scheduler.on_report(now, worker, &report, effects);
                results = report.samples;
                is_answered
            }
        };
        if is_answered {
            self.processes.tickets.insert(worker, ticket);
        } else {
            self.parts.hub.send(Command::Forget(ticket));
        }
        Ok(results)
    }

    fn on_tick(&mut self) -> Result<(), DispatchError> {
        let now = self.now();
        let mut effects = Vec::new();
        self.hub_watch.tick(now, self.parts.hub, &mut self.parts.log)?;
        self.parts.sink.check()?;
        self.scheduler.on_tick(now, clock::now(), &mut effects);
        self.carry_out(&mut effects, Vec::new())?;
        self.feed()?;
        if self.flushing.is_due(self.parts.options.flush_every) {
            self.flush()?;
        }
        self.show();
        Ok(())
    }

    /// Requests further samples if needed.
    fn feed(&mut self) -> Result<(), DispatchError> {
        while self.scheduler.wants_more() {
            let (now, mut effects) = (self.now(), Vec::new());
            let more = self.parts.sink.more()?;
            let is_over = !matches!(more, More::Samples(_));
            match more {
                More::Samples(more) => self.scheduler.on_more(now, more, &mut effects),
                More::Nothing => self.scheduler.on_no_more(now, &mut effects),
                More::Later => {}
            }
            self.carry_out(&mut effects, Vec::new())?;
            if is_over {
                break;
            }
        }
        Ok(())
    }

    fn show(&mut self) {
        let snapshot = self.snapshot();
        self.stale = snapshot.workers.iter().filter(|worker| worker.stale).map(|worker| worker.worker).collect();
        self.parts.observer.progress(&snapshot);
    }

    /// Executes the effects of the scheduler: first answers to workers, then records, so that workers compute meanwhile, then the
    /// notices about these samples.
    fn carry_out(&mut self, effects: &mut Vec<Effect>, results: Vec<SampleReport>) -> Result<(), DispatchError> {
        let (mut spawned, mut stopping) = (Vec::new(), None);
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
                Effect::Stopping(why) => stopping = Some(*why),
                // Handled where the end of the worker was reported.
                Effect::GiveUp { .. } | Effect::Record { .. } | Effect::Quarantine { .. } => {}
            }
        }
        self.record(effects, results)?;
        effects.clear();
        if let Some(why) = stopping {
            self.parts.observer.noticed(&Notice::Stopping(why));
        }
        spawned.into_iter().try_for_each(|worker| self.spawn(worker))
    }

    fn answer(&mut self, worker: WorkerId, message: ToWorker) {
        self.processes.answer(self.parts.hub, worker, message);
    }

    fn assign(
        &mut self,
        worker: WorkerId,
        batch: BatchId,
        attempt: u32,
        samples: Vec<u64>,
    ) -> Result<(), DispatchError> {
        let expected = self.parts.n_params;
        let mut params = Vec::with_capacity(samples.len() * expected);
        for &sample in &samples {
            let before = params.len();
            self.parts.parameters.params(sample, &mut params);
            let found = params.len() - before;
            if found != expected {
                return Err(DispatchError::Parameters { sample, found, expected });
            }
        }
        let claimed = if self.parts.options.faults.is_empty() { Vec::new() } else { samples.clone() };
        self.answer(worker, ToWorker::Batch(Batch { batch, attempt, n_params: expected, samples, params }));
        let pid = self.processes.pid(worker);
        claimed.into_iter().for_each(|sample| self.parts.options.faults.reached(At::Claimed, sample, pid));
        Ok(())
    }

    /// Hands accepted results and quarantined samples to the sink.
    fn record(&mut self, effects: &[Effect], results: Vec<SampleReport>) -> Result<(), DispatchError> {
        for effect in effects {
            if let Effect::Quarantine { sample, cause, worker, .. } = effect {
                self.parts.log.line(Some(*worker), &format!("sample {sample} is quarantined: {}", cause.word()))?;
            }
        }
        let entries = entries(effects, results);
        if entries.is_empty() {
            return Ok(());
        }
        let pid = |worker| self.processes.pid(WorkerId(worker));
        let samples = entries.iter().filter(|_| !self.parts.options.faults.is_empty());
        self.flushing.recorded(entries.len(), samples.map(|(sample, entry)| (*sample, pid(entry.worker))));
        Ok(self.parts.sink.record_all(entries)?)
    }

    fn flush(&mut self) -> Result<(), DispatchError> {
        self.parts.sink.flush()?;
        self.flushing.flushed(self.parts.options.faults);
        Ok(())
    }

    fn spawn(&mut self, worker: WorkerId) -> Result<(), DispatchError> {
        let args = WorkerArgs {
            address: self.parts.domain.address().clone(),
            run: self.parts.domain.run(),
            worker,
            parent: Some(std::process::id()),
            run_dir: self.parts.options.run_dir.clone(),
            plan_hash: self.parts.options.plan_hash.clone(),
            memory_limit: self.parts.options.schedule.sample.memory,
            noop: self.parts.options.noop,
        };
        let child = Child::start(self.parts.options, &args, &self.parts.send)?;
        self.scheduler.on_spawned(self.now(), worker, child.pid);
        self.parts.observer.noticed(&Notice::WorkerStarted { worker: worker.0, pid: child.pid });
        self.processes.children.insert(worker, child);
        Ok(())
    }

    fn kill(&mut self, worker: WorkerId, why: KillReason) -> Result<(), DispatchError> {
        self.parts.observer.noticed(&Notice::WorkerKilled { worker: worker.0, why });
        self.parts.log.killed(worker, why)?;
        self.processes.kill(worker);
        Ok(())
    }

    fn snapshot(&self) -> crate::schedule::Snapshot {
        let mut snapshot = self.scheduler.snapshot(self.now());
        snapshot.dropped_messages += self.refused;
        snapshot
    }

    fn report(&self, ended: Ended) -> DispatchReport {
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
