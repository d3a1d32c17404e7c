//! Simulation of the scheduler with random histories: workers that are slow, die, stop, fall silent, lose and duplicate messages,
//! report late, and send invalid reports. After every step each sample is in exactly one place; at the end each has ended exactly
//! once (tests in `histories`).

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::Duration;

use bladeoff_model::outcome::{Cause, CauseSet, EndCause, Outcome, Status};
use bladeoff_protocol::beat::Beat;
use bladeoff_protocol::messages::{BatchId, Report, SampleReport, WorkerId};
use bladeoff_study::SampleLimits;
use bladeoff_system::random::SplitMix;

use super::slot::State;
use super::{Death, Effect, Ended, KillReason, Moment, RunLimits, Scheduler, Settings, Todo};

pub(super) struct Random(SplitMix);

impl Random {
    pub(super) fn below(&mut self, n: u64) -> u64 {
        self.0.below(n)
    }
    fn happens(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }
}

/// State of a simulated worker process.
#[derive(Default)]
struct Process {
    batch: Option<(BatchId, u32)>,
    work: VecDeque<u64>,
    /// Whether it waits for an answer to its request.
    waits: bool,
    greeted: bool,
    silent: bool,
    /// Time until which it is in a long sample.
    inside: Option<Duration>,
}

/// Rates of faults, in percent per step.
#[derive(Clone, Copy)]
pub(super) struct World {
    pub(super) death: u64,
    pub(super) silence: u64,
    pub(super) lies: u64,
    pub(super) doubles: u64,
    pub(super) losses: u64,
    pub(super) poison: u64,
    /// Samples that cause a kill of their worker, for example by using all memory.
    pub(super) doom: u64,
}

pub(super) struct Simulation {
    pub(super) random: Random,
    world: World,
    pub(super) scheduler: Scheduler,
    pub(super) now: Duration,
    processes: BTreeMap<WorkerId, Process>,
    /// Reports in transit, some of them late or duplicates.
    under_way: VecDeque<(WorkerId, Report)>,
    copies: VecDeque<(WorkerId, Report)>,
    /// Workers whose request is open.
    is_copy: bool,
    /// Whether events follow so quickly that batches have several samples.
    is_quick: bool,
    /// Samples that take a second.
    long: BTreeSet<u64>,
    pub(super) poisoned: BTreeSet<u64>,
    pub(super) doomed: BTreeSet<u64>,
    /// Samples that an earlier run has quarantined.
    pub(super) suspects: BTreeSet<u64>,
    pub(super) recorded: BTreeMap<u64, u64>,
    pub(super) quarantined: BTreeSet<u64>,
    /// Crashes and kills of workers that had only this sample.
    deaths_alone: BTreeMap<u64, [u32; 2]>,
    total: u64,
    crash_limit: u32,
    kill_limit: u32,
    pub(super) gave_up: bool,
    /// Reason and time of the end of assignments, and the tick before.
    pub(super) stopped: Option<(Ended, Duration, Duration)>,
    /// Wall clock at the beginning \[ms\].
    pub(super) wall_clock: i64,
    last_tick: Duration,
    /// Workers that must leave samples that were taken back.
    pub(super) relieved: u64,
    /// Workers with the order to stop or killed, still alive for a moment.
    dying: Vec<WorkerId>,
}

impl Simulation {
    pub(super) fn new(seed: u64, world: World) -> Self {
        Self::limited(seed, world, RunLimits::default())
    }

    /// Creates a run with limits.
    pub(super) fn limited(seed: u64, world: World, run: RunLimits) -> Self {
        let mut random = Random(SplitMix(seed));
        let total = random.below(60);
        let (crash_limit, kill_limit) = (1 + random.below(3) as u32, 1 + random.below(6) as u32);
        let settings = Settings {
            workers: 1 + random.below(5) as usize,
            max_batch: 1 + random.below(9) as usize,
            sample: SampleLimits {
                time: random.happens(30).then_some(Duration::from_secs(20)),
                memory: None,
                crashes: crash_limit,
                kills: kill_limit,
            },
            run,
            ..Settings::new(0)
        };
        let poisoned: BTreeSet<u64> = (0..total).filter(|_| random.happens(world.poison)).collect();
        let is_doomed = |sample: &u64, random: &mut Random| random.happens(world.doom) && !poisoned.contains(sample);
        let doomed: BTreeSet<u64> = (0..total).filter(|sample| is_doomed(sample, &mut random)).collect();
        // The last samples are those that an earlier run gave up, some of them without need.
        let known = if world.doom > 0 { total - random.below(total.min(6) + 1) } else { total };
        let suspects: BTreeSet<u64> = (known..total).collect();
        let cut = random.below(known + 1);
        let long = (0..total).filter(|_| random.happens(5)).collect();
        let is_quick = random.happens(50);
        let todo = Todo::from_iter([cut..known, 0..cut]).with_suspects(suspects.iter().copied().collect());
        Self {
            random,
            world,
            scheduler: Scheduler::new(settings, todo),
            now: Duration::ZERO,
            processes: BTreeMap::new(),
            under_way: VecDeque::new(),
            copies: VecDeque::new(),
            is_copy: false,
            is_quick,
            long,
            poisoned,
            doomed,
            suspects,
            recorded: BTreeMap::new(),
            quarantined: BTreeSet::new(),
            deaths_alone: BTreeMap::new(),
            total,
            crash_limit,
            kill_limit,
            gave_up: false,
            stopped: None,
            wall_clock: 0,
            last_tick: Duration::ZERO,
            relieved: 0,
            dying: Vec::new(),
        }
    }

    pub(super) fn carry_out(&mut self, effects: Vec<Effect>, report: Option<&Report>) {
        for effect in effects {
            match effect {
                Effect::Spawn(worker) => {
                    let before = self.processes.insert(worker, Process::default());
                    assert!(before.is_none(), "{worker} started twice");
                    self.scheduler.on_spawned(self.now, worker, worker.0 + 1000);
                }
                Effect::Assign { worker, batch, attempt, samples } => {
                    assert!(self.stopped.is_none(), "work after the end: {:?}", self.stopped);
                    assert!(!samples.is_empty() && !self.dying.contains(&worker), "work for a worker on its way out");
                    for sample in &samples {
                        assert!(!self.recorded.contains_key(sample) && !self.quarantined.contains(sample));
                        assert!(samples.len() == 1 || !self.suspects.contains(sample), "a suspect is alone");
                    }
                    let is_lost = self.random.happens(self.world.losses);
                    if let Some(process) = self.processes.get_mut(&worker).filter(|_| !is_lost) {
                        assert!(process.waits || self.world.lies > 0, "work for a worker that did not ask");
                        // A worker with an invalid request does not expect an answer.
                        if process.waits {
                            (process.waits, process.inside) = (false, None);
                            process.batch = Some((batch, attempt));
                            process.work = samples.into();
                        }
                    }
                }
                Effect::Continue(_) | Effect::Leave(_) if self.is_copy => {}
                Effect::Continue(worker) => {
                    if let Some(process) = self.processes.get_mut(&worker) {
                        process.waits = false;
                        process.greeted = true;
                    }
                }
                Effect::Leave(worker) => {
                    self.relieved += 1;
                    if let Some(process) = self.processes.get_mut(&worker) {
                        (process.waits, process.inside) = (false, None);
                        process.work.clear();
                    }
                }
                Effect::Stop(worker) => self.dying.push(worker),
                Effect::Kill { worker, why } => {
                    if why == KillReason::Silent {
                        assert!(self.processes.get(&worker).is_none_or(|p| p.silent || !p.greeted), "{worker} spoke");
                    }
                    self.dying.push(worker);
                }
                Effect::Record { index, .. } => {
                    let sample = report.expect("a record belongs to a report").samples[index].sample;
                    *self.recorded.entry(sample).or_default() += 1;
                    assert_eq!(self.recorded[&sample], 1, "sample {sample} recorded twice");
                    assert!(!self.quarantined.contains(&sample));
                }
                Effect::Quarantine { sample, cause, .. } => {
                    assert!(self.quarantined.insert(sample), "sample {sample} quarantined twice");
                    assert!(!self.recorded.contains_key(&sample));
                    let [crashes, kills] = self.deaths_alone[&sample];
                    let kill_limit = if self.suspects.contains(&sample) { 1 } else { self.kill_limit };
                    let (deaths, limit) =
                        if cause == Cause::WorkerKilled { (kills, kill_limit) } else { (crashes, self.crash_limit) };
                    assert_eq!(deaths, limit, "blamed for {} too early or too late", cause.word());
                }
                Effect::Stopping(why) => {
                    assert!(self.stopped.is_none(), "stopping twice: {:?}, {why:?}", self.stopped);
                    assert!(!self.scheduler.is_complete(), "nothing is left to be stopped");
                    self.stopped = Some((why, self.now, self.last_tick));
                }
                Effect::GiveUp { .. } => self.gave_up = true,
            }
        }
        self.check();
    }

    /// Ends a process: its messages arrive before the news of its end, if they arrive at all.
    fn exit(&mut self, worker: WorkerId, death: Death) {
        if self.processes.remove(&worker).is_none() {
            return;
        }
        let (mine, others) = std::mem::take(&mut self.under_way).into_iter().partition(|(from, _)| *from == worker);
        self.under_way = others;
        let mine: VecDeque<_> = mine;
        for (from, report) in mine {
            // Some arrive late, after the news.
            if self.random.happens(50) { self.deliver(from, &report) } else { self.under_way.push_back((from, report)) }
        }
        let slot = self.scheduler.slots.iter().find(|slot| slot.worker == worker && slot.lives());
        if let Some(work) = slot.and_then(|slot| slot.work()).filter(|work| work.size == 1 && work.left.len() == 1) {
            let killed = slot.and_then(|slot| slot.killed);
            let is_kill = match killed {
                Some(KillReason::TimeLimit) => false,
                Some(KillReason::Silent) => true,
                _ => death.from_outside && !death.out_of_memory,
            };
            let was_told = matches!(slot.map(|slot| &slot.state), Some(State::Leaving { .. }));
            if !was_told && !matches!(killed, Some(KillReason::Ending | KillReason::Lost)) {
                self.deaths_alone.entry(work.left[0]).or_default()[usize::from(is_kill)] += 1;
            }
        }
        let mut effects = Vec::new();
        self.scheduler.on_exit(self.now, worker, death, &mut effects);
        self.carry_out(effects, None);
    }

    fn deliver(&mut self, worker: WorkerId, report: &Report) {
        let mut effects = Vec::new();
        self.scheduler.on_report(self.now, worker, report, &mut effects);
        self.carry_out(effects, Some(report));
    }

    /// Simulates one event.
    pub(super) fn step(&mut self) {
        let is_short = self.is_quick && self.random.happens(95);
        let pause = self.random.below(if is_short { 8 } else { 400 });
        // Sometimes the orchestrator sleeps for an hour.
        self.now += if self.random.happens(1) { Duration::from_secs(3600) } else { Duration::from_millis(pause) };
        for worker in std::mem::take(&mut self.dying) {
            if self.random.happens(50) { self.exit(worker, Death::default()) } else { self.dying.push(worker) }
        }
        let workers: Vec<WorkerId> = self.processes.keys().copied().collect();
        for worker in workers {
            if !self.processes.get(&worker).is_some_and(|process| process.silent) {
                self.live(worker);
            }
        }
        if self.random.happens(70)
            && let Some((worker, report)) = self.under_way.pop_front()
        {
            if self.random.happens(self.world.doubles) {
                self.copies.push_back((worker, report.clone()));
            }
            if !self.random.happens(self.world.losses) {
                self.deliver(worker, &report);
            }
        }
        if self.random.happens(50)
            && let Some((worker, report)) = self.copies.pop_front()
        {
            self.is_copy = true;
            self.deliver(worker, &report);
            self.is_copy = false;
        }
        let mut effects = Vec::new();
        let boot = self.now.as_millis() as i64;
        self.scheduler.on_tick(self.now, Moment { boot, wall: self.wall_clock + boot }, &mut effects);
        self.carry_out(effects, None);
        self.last_tick = self.now;
    }

    /// Simulates one action of a worker.
    fn live(&mut self, worker: WorkerId) {
        if self.random.happens(self.world.death) {
            let death = Death { out_of_memory: self.random.happens(10), from_outside: self.random.happens(50) };
            return self.exit(worker, death);
        }
        if self.random.happens(self.world.silence)
            && let Some(process) = self.processes.get_mut(&worker)
        {
            process.silent = true;
            return;
        }
        let Some(process) = self.processes.get(&worker) else { return };
        let beat = match (process.batch, process.work.front()) {
            (Some((batch, _)), Some(&sample)) => Beat { batch, sample: Some(sample) },
            _ => Beat { batch: BatchId(0), sample: None },
        };
        let (greeted, waits) = (process.greeted, process.waits);
        self.scheduler.on_beat(self.now, worker, beat);
        if !greeted {
            let mut effects = Vec::new();
            self.scheduler.on_hello(self.now, worker, worker.0 + 1000, &mut effects);
            return self.carry_out(effects, None);
        }
        if self.random.happens(self.world.lies) {
            let lie = self.lie();
            return self.under_way.push_back((worker, lie));
        }
        if waits || self.random.happens(30) {
            return;
        }
        self.work(worker);
    }

    /// Simulates a worker that computes up to two samples and reports.
    fn work(&mut self, worker: WorkerId) {
        let is_long = self.random.happens(50);
        let Some(process) = self.processes.get_mut(&worker) else { return };
        let batch = process.batch;
        let mut samples = Vec::new();
        for _ in 0..if is_long { 1 } else { 2 } {
            let Some(&sample) = process.work.front() else { break };
            if self.poisoned.contains(&sample) || self.doomed.contains(&sample) {
                if !samples.is_empty() {
                    break;
                }
                let from_outside = self.doomed.contains(&sample);
                return self.exit(worker, Death { out_of_memory: false, from_outside });
            }
            if self.long.contains(&sample) {
                let until = *process.inside.get_or_insert(self.now + Duration::from_secs(1));
                if self.now < until {
                    if samples.is_empty() {
                        return;
                    }
                    break;
                }
                process.inside = None;
            }
            process.work.pop_front();
            samples.push(result(sample));
        }
        process.waits = true;
        let asks = process.work.is_empty();
        if asks {
            process.batch = None;
        }
        self.under_way.push_back((worker, Report { batch, samples, asks }));
    }

    /// Simulates an invalid report.
    fn lie(&mut self) -> Report {
        let batch =
            self.random.happens(70).then(|| (BatchId(1 + self.random.below(20)), 1 + self.random.below(3) as u32));
        let samples = (0..self.random.below(4)).map(|_| result(self.random.below(self.total + 5))).collect();
        // Without results of its own batch it would request work before the end of the batch: covered by asks = false here and by
        // lost messages elsewhere.
        Report { batch: batch.filter(|(batch, _)| !self.is_current(*batch)), samples, asks: self.random.happens(50) }
    }

    fn is_current(&self, batch: BatchId) -> bool {
        self.scheduler.slots.iter().any(|slot| slot.work().is_some_and(|work| work.batch == batch))
    }

    /// Checks that every sample is in exactly one place and no batch has two workers.
    fn check(&self) {
        let scheduler = &self.scheduler;
        let in_work: Vec<u64> = scheduler.slots.iter().filter_map(|p| p.work()).flat_map(|w| w.left.clone()).collect();
        let waiting = scheduler.queue.retry.iter().chain(&scheduler.queue.suspects).copied();
        let mut places: Vec<u64> = waiting.chain(in_work).collect();
        places.extend(self.recorded.keys().copied().chain(self.quarantined.iter().copied()));
        let known = places.len() as u64;
        assert_eq!(known + scheduler.queue.todo.left(), self.total, "a sample is lost or in two places");
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len() as u64, known, "a sample is in two places");
        assert_eq!(scheduler.counts.done, (self.recorded.len() + self.quarantined.len()) as u64);
        let living: BTreeSet<_> = scheduler.slots.iter().filter(|p| p.lives()).map(|p| p.worker).collect();
        assert_eq!(living.len(), scheduler.slots.iter().filter(|p| p.lives()).count(), "one worker, two slots");
        let idle_despite_work = scheduler.slots.iter().any(|slot| {
            matches!(slot.state, State::Idle)
                && slot.killed.is_none()
                && scheduler.queue.todo.left() + scheduler.queue.suspects.len() as u64 > 0
        });
        assert!(!idle_despite_work || scheduler.ending.has_begun(), "a worker waits although there is work");
    }

    /// Simulates until the run is over; panics if it does not end.
    pub(super) fn play(&mut self) {
        let mut effects = Vec::new();
        self.scheduler.start(self.now, &mut effects);
        self.carry_out(effects, None);
        for _ in 0..200_000 {
            if self.scheduler.is_over() {
                return;
            }
            self.step();
        }
        panic!("no end: {:?}", self.scheduler.snapshot(self.now));
    }
}

pub(super) fn result(sample: u64) -> SampleReport {
    let (status, causes) = (Status::Ok, CauseSet::default());
    let outcome = Outcome {
        status,
        cause: None,
        causes,
        notes: CauseSet::default(),
        end_cause: EndCause::Stopped,
        values: vec![Some(1.0)],
    };
    SampleReport { sample, cpu_s: 0.0, outcome }
}
