//! The scheduler against random histories: workers that are slow, die, stop, fall silent, lose and double messages, report
//! late, and lie. After every step the books must balance; at the end every sample has ended exactly once.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::Duration;

use bladeoff_model::outcome::{Cause, CauseSet, EndCause, Outcome, Status};
use bladeoff_protocol::beat::Beat;
use bladeoff_protocol::messages::{BatchId, Report, SampleReport, WorkerId};
use bladeoff_study::SampleLimits;

use super::slot::State;
use super::{Death, Effect, KillReason, Scheduler, Settings, Todo};

/// splitmix64.
struct Random(u64);

impl Random {
    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    fn below(&mut self, n: u64) -> u64 {
        self.word() % n.max(1)
    }
    fn happens(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }
}

/// A worker process as the world has it.
struct Process {
    batch: Option<(BatchId, u32)>,
    work: VecDeque<u64>,
    /// Waits for an answer to its request.
    waits: bool,
    greeted: bool,
    silent: bool,
}

/// How bad the world is, in percent per step.
#[derive(Clone, Copy)]
struct World {
    death: u64,
    silence: u64,
    lies: u64,
    doubles: u64,
    losses: u64,
    poison: u64,
    /// Samples that bring somebody to kill the worker, as one that takes all memory does.
    doom: u64,
}

struct Simulation {
    random: Random,
    world: World,
    scheduler: Scheduler,
    now: Duration,
    processes: BTreeMap<WorkerId, Process>,
    /// Reports on their way, some of them late or doubled.
    under_way: VecDeque<(WorkerId, Report)>,
    poisoned: BTreeSet<u64>,
    doomed: BTreeSet<u64>,
    /// Doomed ones that are so in the eyes of an earlier run.
    suspects: BTreeSet<u64>,
    recorded: BTreeMap<u64, u64>,
    quarantined: BTreeSet<u64>,
    /// Crashes and kills of workers that had just this sample.
    deaths_alone: BTreeMap<u64, [u32; 2]>,
    total: u64,
    crash_limit: u32,
    kill_limit: u32,
    gave_up: bool,
    /// Told to stop or killed, still there for a moment.
    dying: Vec<WorkerId>,
}

impl Simulation {
    fn new(seed: u64, world: World) -> Self {
        let mut random = Random(seed);
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
            ..Settings::new(0)
        };
        let poisoned: BTreeSet<u64> = (0..total).filter(|_| random.happens(world.poison)).collect();
        let is_doomed = |sample: &u64, random: &mut Random| random.happens(world.doom) && !poisoned.contains(sample);
        let doomed: BTreeSet<u64> = (0..total).filter(|sample| is_doomed(sample, &mut random)).collect();
        // The last samples are what an earlier run gave up, some of it without need.
        let known = if world.doom > 0 { total - random.below(total.min(6) + 1) } else { total };
        let suspects: BTreeSet<u64> = (known..total).collect();
        let cut = random.below(known + 1);
        let todo = Todo::from_iter([cut..known, 0..cut]).with_suspects(suspects.iter().copied().collect());
        Self {
            random,
            world,
            scheduler: Scheduler::new(settings, todo),
            now: Duration::ZERO,
            processes: BTreeMap::new(),
            under_way: VecDeque::new(),
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
            dying: Vec::new(),
        }
    }

    fn carry_out(&mut self, effects: Vec<Effect>, report: Option<&Report>) {
        for effect in effects {
            match effect {
                Effect::Spawn(worker) => {
                    let process =
                        Process { batch: None, work: VecDeque::new(), waits: false, greeted: false, silent: false };
                    assert!(self.processes.insert(worker, process).is_none(), "{worker} started twice");
                    self.scheduler.on_spawned(self.now, worker, worker.0 + 1000);
                }
                Effect::Assign { worker, batch, attempt, samples } => {
                    assert!(!samples.is_empty() && !self.dying.contains(&worker), "work for a worker on its way out");
                    for sample in &samples {
                        assert!(!self.recorded.contains_key(sample) && !self.quarantined.contains(sample));
                        assert!(samples.len() == 1 || !self.suspects.contains(sample), "a suspect is alone");
                    }
                    let is_lost = self.random.happens(self.world.losses);
                    if let Some(process) = self.processes.get_mut(&worker).filter(|_| !is_lost) {
                        assert!(process.waits || self.world.lies > 0, "work for a worker that did not ask");
                        // One that asked in a lie does not expect an answer.
                        if process.waits {
                            process.waits = false;
                            process.batch = Some((batch, attempt));
                            process.work = samples.into();
                        }
                    }
                }
                Effect::Continue(worker) => {
                    if let Some(process) = self.processes.get_mut(&worker) {
                        process.waits = false;
                        process.greeted = true;
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
                Effect::GiveUp { .. } => self.gave_up = true,
            }
        }
        self.check();
    }

    /// A process ends, in order: its messages that arrive at all arrive before the news.
    fn exit(&mut self, worker: WorkerId, death: Death) {
        if self.processes.remove(&worker).is_none() {
            return;
        }
        let (mine, others) = std::mem::take(&mut self.under_way).into_iter().partition(|(from, _)| *from == worker);
        self.under_way = others;
        let mine: VecDeque<_> = mine;
        for (from, report) in mine {
            // Some only after the news, so late.
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

    /// One thing happens.
    fn step(&mut self) {
        let pause = self.random.below(400);
        // Now and then we sleep for an hour ourselves.
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
                self.under_way.push_back((worker, report.clone()));
            }
            if !self.random.happens(self.world.losses) {
                self.deliver(worker, &report);
            }
        }
        let mut effects = Vec::new();
        self.scheduler.on_tick(self.now, &mut effects);
        self.carry_out(effects, None);
    }

    /// A worker does something.
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

    /// A worker computes up to two samples and reports.
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

    /// Anything a confused worker could say.
    fn lie(&mut self) -> Report {
        let batch =
            self.random.happens(70).then(|| (BatchId(1 + self.random.below(20)), 1 + self.random.below(3) as u32));
        let samples = (0..self.random.below(4)).map(|_| result(self.random.below(self.total + 5))).collect();
        // Without results of its own batch it would ask for work it has not finished: covered by asks = false here and by
        // lost messages elsewhere.
        Report { batch: batch.filter(|(batch, _)| !self.is_current(*batch)), samples, asks: self.random.happens(50) }
    }

    fn is_current(&self, batch: BatchId) -> bool {
        self.scheduler.slots.iter().any(|slot| slot.work().is_some_and(|work| work.batch == batch))
    }

    /// Every sample is in exactly one place, and no batch is with two workers.
    fn check(&self) {
        let scheduler = &self.scheduler;
        let in_work: Vec<u64> = scheduler.slots.iter().filter_map(|p| p.work()).flat_map(|w| w.left.clone()).collect();
        let waiting = scheduler.retry.iter().chain(&scheduler.suspects).copied();
        let mut places: Vec<u64> = waiting.chain(in_work).collect();
        places.extend(self.recorded.keys().copied().chain(self.quarantined.iter().copied()));
        let known = places.len() as u64;
        assert_eq!(known + scheduler.todo.left(), self.total, "a sample is lost or in two places");
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len() as u64, known, "a sample is in two places");
        assert_eq!(scheduler.done, (self.recorded.len() + self.quarantined.len()) as u64);
        let living: BTreeSet<_> = scheduler.slots.iter().filter(|p| p.lives()).map(|p| p.worker).collect();
        assert_eq!(living.len(), scheduler.slots.iter().filter(|p| p.lives()).count(), "one worker, two slots");
        let idle_despite_work = scheduler.slots.iter().any(|slot| {
            matches!(slot.state, State::Idle)
                && slot.killed.is_none()
                && scheduler.todo.left() + scheduler.suspects.len() as u64 > 0
        });
        assert!(!idle_despite_work || scheduler.ending.is_some(), "a worker waits although there is work");
    }

    /// Plays until everything is over; panics when it never is.
    fn play(&mut self) {
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

fn result(sample: u64) -> SampleReport {
    let (status, causes) = (Status::Ok, CauseSet::default());
    let outcome = Outcome { status, cause: None, causes, end_cause: EndCause::Stopped, values: vec![Some(1.0)] };
    SampleReport { sample, cpu_s: 0.0, outcome }
}

const KIND: World = World { death: 0, silence: 0, lies: 0, doubles: 0, losses: 0, poison: 0, doom: 0 };

fn play_all(seeds: std::ops::Range<u64>, world: World) -> (u64, u64, u64) {
    let (mut recorded, mut quarantined, mut dropped) = (0, 0, 0);
    for seed in seeds {
        let mut simulation = Simulation::new(seed, world);
        simulation.play();
        if !simulation.gave_up {
            assert!(simulation.scheduler.is_complete(), "seed {seed}");
        }
        recorded += simulation.recorded.len() as u64;
        quarantined += simulation.quarantined.len() as u64;
        dropped += simulation.scheduler.dropped;
    }
    (recorded, quarantined, dropped)
}

#[test]
fn in_a_kind_world_every_sample_is_recorded_and_nothing_dropped() {
    let (recorded, quarantined, dropped) = play_all(0..500, KIND);
    assert!(recorded > 10_000);
    assert_eq!((quarantined, dropped), (0, 0));
}

#[test]
fn doubled_late_and_lying_reports_change_no_record() {
    let (recorded, quarantined, dropped) = play_all(1000..2500, World { doubles: 20, lies: 10, ..KIND });
    assert_eq!(quarantined, 0);
    assert!(recorded > 30_000 && dropped > 10_000, "{recorded} {dropped}");
}

#[test]
fn dying_and_silent_workers_cost_no_sample_its_end() {
    let (recorded, quarantined, _) = play_all(3000..4500, World { death: 3, silence: 1, ..KIND });
    assert!(recorded > 20_000 && quarantined > 0, "{recorded} {quarantined}");
}

#[test]
fn poisoned_samples_and_no_others_are_quarantined() {
    for seed in 5000..6000 {
        let mut simulation = Simulation::new(seed, World { poison: 10, doubles: 5, ..KIND });
        simulation.play();
        assert!(simulation.scheduler.is_complete());
        assert_eq!(simulation.quarantined, simulation.poisoned, "seed {seed}");
    }
}

/// Kills count apart from crashes, a suspect has one, and what an earlier run gave up without need is computed.
#[test]
fn samples_whose_workers_are_killed_and_no_others_are_quarantined() {
    let (mut tried_once, mut computed) = (0, 0);
    for seed in 7000..8000 {
        let mut simulation = Simulation::new(seed, World { doom: 10, poison: 5, doubles: 5, ..KIND });
        simulation.play();
        assert!(simulation.scheduler.is_complete());
        let given_up: BTreeSet<u64> = simulation.poisoned.union(&simulation.doomed).copied().collect();
        assert_eq!(simulation.quarantined, given_up, "seed {seed}");
        tried_once += simulation.suspects.intersection(&simulation.doomed).count();
        computed += simulation.suspects.difference(&given_up).count();
    }
    assert!(tried_once > 100 && computed > 1000, "{tried_once} {computed}");
}

#[test]
fn in_a_world_with_every_fault_every_sample_ends_once() {
    let world = World { death: 2, silence: 1, lies: 5, doubles: 10, losses: 3, poison: 5, doom: 5 };
    let (recorded, quarantined, dropped) = play_all(10_000..14_000, world);
    assert!(recorded > 50_000 && quarantined > 1000 && dropped > 10_000, "{recorded} {quarantined} {dropped}");
}

#[test]
fn workers_that_never_start_make_the_run_give_up() {
    let mut simulation = Simulation::new(1, World { death: 100, ..KIND });
    simulation.play();
    assert!(simulation.gave_up && simulation.recorded.is_empty() && simulation.quarantined.is_empty());
}

#[test]
fn a_stopped_run_ends_whatever_the_workers_do() {
    for seed in 0..1000 {
        let world = World { death: 1, silence: 3, lies: 5, doubles: 5, losses: 3, poison: 3, doom: 3 };
        let mut simulation = Simulation::new(seed, world);
        let mut effects = Vec::new();
        simulation.scheduler.start(simulation.now, &mut effects);
        simulation.carry_out(effects, None);
        for _ in 0..simulation.random.below(200) {
            simulation.step();
        }
        let mut effects = Vec::new();
        simulation.scheduler.on_stop(simulation.now, &mut effects);
        simulation.carry_out(effects, None);
        for _ in 0..2000 {
            if !simulation.scheduler.is_over() {
                simulation.step();
            }
        }
        assert!(simulation.scheduler.is_over(), "seed {seed}: {:?}", simulation.scheduler.snapshot(simulation.now));
    }
}
