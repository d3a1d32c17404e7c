//! Time of a study of short and long samples with batches, compared with free assignment of single samples. Time may be lost at
//! the end, when one worker has several long samples and others have none.
//!
//! Workers behave as `bladeoff_worker::serve` does. They report when a batch is over or [`REPORT_EVERY`] has passed since the
//! last report, and wait for the answer after a long sample. A heartbeat comes every half second; a message takes 50 us. Without
//! heartbeats no long sample is known and no work is taken back: that is the reference.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, VecDeque};
use std::time::Duration;

use bladeoff_protocol::beat::Beat;
use bladeoff_protocol::messages::{BatchId, Report, WorkerId};

use super::simulation::result;
use super::{Effect, Moment, Scheduler, Settings, Todo};

const MESSAGE: Duration = Duration::from_micros(50);
const TICK: Duration = Duration::from_millis(200);
const BEAT_EVERY: Duration = Duration::from_millis(500);
const REPORT_EVERY: Duration = Duration::from_millis(100);
const WAIT_FROM: Duration = Duration::from_millis(400);

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Event {
    Tick,
    Beat(WorkerId),
    Finished(WorkerId),
    Received(WorkerId, ToWorker),
    Says(WorkerId, Vec<u64>, Option<(u64, u32)>, bool),
}

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum ToWorker {
    Work(u64, u32, Vec<u64>),
    GoOn,
    Leave,
}

#[derive(Default)]
struct Worker {
    batch: Option<(u64, u32)>,
    /// Samples of the batch; the first one is in progress unless the worker waits for an answer.
    queue: VecDeque<u64>,
    finished: Vec<u64>,
    sent: Duration,
    waits: bool,
    leaves: bool,
}

struct Play<'a> {
    costs: &'a [Duration],
    now: Duration,
    scheduler: Scheduler,
    workers: BTreeMap<WorkerId, Worker>,
    events: BinaryHeap<Reverse<(Duration, u64, Event)>>,
    next: u64,
    has_heartbeats: bool,
    messages: u64,
    relieved: u64,
}

impl Play<'_> {
    fn after(&mut self, pause: Duration, event: Event) {
        self.next += 1;
        self.events.push(Reverse((self.now + pause, self.next, event)));
    }

    fn carry_out(&mut self, effects: Vec<Effect>) {
        for effect in effects {
            match effect {
                Effect::Spawn(worker) => {
                    self.workers.insert(worker, Worker::default());
                    self.scheduler.on_spawned(self.now, worker, worker.0);
                    let mut effects = Vec::new();
                    assert!(self.scheduler.on_hello(self.now, worker, worker.0, &mut effects));
                    self.after(Duration::ZERO, Event::Says(worker, Vec::new(), None, true));
                    // Workers start at different times.
                    if self.has_heartbeats {
                        self.after(BEAT_EVERY * (worker.0 % 7) / 7, Event::Beat(worker));
                    }
                }
                Effect::Assign { worker, batch, attempt, samples } => {
                    self.after(MESSAGE, Event::Received(worker, ToWorker::Work(batch.0, attempt, samples)));
                }
                Effect::Continue(worker) => self.after(MESSAGE, Event::Received(worker, ToWorker::GoOn)),
                Effect::Leave(worker) => {
                    self.relieved += 1;
                    self.after(MESSAGE, Event::Received(worker, ToWorker::Leave));
                }
                Effect::Record { .. } | Effect::Stop(_) => {}
                other => panic!("nothing goes wrong here: {other:?}"),
            }
        }
    }

    fn say(&mut self, worker: WorkerId, asks: bool) {
        let state = self.workers.get_mut(&worker).expect("a worker");
        let (finished, batch) = (std::mem::take(&mut state.finished), state.batch);
        (state.sent, state.leaves) = (self.now, false);
        self.messages += 1;
        self.after(MESSAGE, Event::Says(worker, finished, batch, asks));
    }

    /// Begins the first sample of the queue.
    fn begin(&mut self, worker: WorkerId) {
        let cost = self.costs[self.workers[&worker].queue[0] as usize];
        self.after(cost, Event::Finished(worker));
    }

    fn finished(&mut self, worker: WorkerId) {
        let now = self.now;
        let state = self.workers.get_mut(&worker).expect("a worker");
        let sample = state.queue.pop_front().expect("in work");
        state.finished.push(sample);
        let since = now - state.sent;
        if state.queue.is_empty() || state.leaves {
            state.queue.clear();
            return self.say(worker, true);
        }
        state.waits = since >= WAIT_FROM;
        let waits = state.waits;
        if since >= REPORT_EVERY {
            self.say(worker, false);
        }
        if !waits {
            self.begin(worker);
        }
    }

    fn receive(&mut self, worker: WorkerId, message: ToWorker) {
        let state = self.workers.get_mut(&worker).expect("a worker");
        let waited = std::mem::take(&mut state.waits);
        match message {
            ToWorker::Work(batch, attempt, samples) => {
                (state.batch, state.queue, state.sent) = (Some((batch, attempt)), samples.into(), self.now);
                self.begin(worker);
            }
            ToWorker::GoOn if waited => self.begin(worker),
            ToWorker::GoOn => {}
            ToWorker::Leave if waited => {
                state.queue.clear();
                self.say(worker, true);
            }
            ToWorker::Leave => state.leaves = true,
        }
    }

    fn happen(&mut self, event: Event) {
        let mut effects = Vec::new();
        match event {
            Event::Tick => {
                self.scheduler.on_tick(self.now, Moment { boot: 0, wall: 0 }, &mut effects);
                self.after(TICK, Event::Tick);
            }
            Event::Beat(worker) => {
                let state = &self.workers[&worker];
                let sample = state.queue.front().copied().filter(|_| !state.waits);
                let batch = state.batch.filter(|_| sample.is_some()).map_or(0, |(batch, _)| batch);
                self.scheduler.on_beat(self.now, worker, Beat { batch: BatchId(batch), sample });
                self.after(BEAT_EVERY, Event::Beat(worker));
            }
            Event::Finished(worker) => self.finished(worker),
            Event::Received(worker, message) => self.receive(worker, message),
            Event::Says(worker, finished, batch, asks) => {
                let batch = batch.map(|(batch, attempt)| (BatchId(batch), attempt));
                let samples = finished.into_iter().map(result).collect();
                self.scheduler.on_report(self.now, worker, &Report { batch, samples, asks }, &mut effects);
            }
        }
        self.carry_out(effects);
    }
}

/// Returns the time of the last result, the messages, and the workers that had to leave their batch.
fn play(costs: &[Duration], workers: usize, has_heartbeats: bool) -> (Duration, u64, u64) {
    // No worker is replaced: some runs have no heartbeats.
    let settings = Settings { replace_after: Duration::from_secs(3600), ..Settings::new(workers) };
    let scheduler = Scheduler::new(settings, Todo::from(costs.len() as u64));
    let (now, events) = (Duration::ZERO, BinaryHeap::new());
    let mut play = Play {
        costs,
        now,
        scheduler,
        workers: BTreeMap::new(),
        events,
        next: 0,
        has_heartbeats,
        messages: 0,
        relieved: 0,
    };
    let mut effects = Vec::new();
    play.scheduler.start(now, &mut effects);
    play.carry_out(effects);
    play.after(TICK, Event::Tick);
    while !play.scheduler.is_complete() {
        let Reverse((at, _, event)) = play.events.pop().expect("something is always to come");
        play.now = at;
        play.happen(event);
    }
    assert_eq!((play.scheduler.dropped(), play.scheduler.worker_deaths()), (0, 0));
    (play.now, play.messages, play.relieved)
}

/// Time with samples assigned singly without cost.
fn one_by_one(costs: &[Duration], workers: usize) -> Duration {
    let mut free: BinaryHeap<_> = (0..workers).map(|_| Reverse(Duration::ZERO)).collect();
    for &cost in costs {
        let Reverse(at) = free.pop().expect("a worker");
        free.push(Reverse(at + cost));
    }
    free.into_iter().map(|Reverse(at)| at).max().unwrap_or_default()
}

/// Creates samples of which so many of ten thousand are long; costs differ by 15 % to both sides.
fn study(samples: u64, long_of_10000: u64, short: Duration, long: Duration, seed: u64) -> Vec<Duration> {
    let random = |index: u64| blake3::hash(&[seed.to_le_bytes(), index.to_le_bytes()].concat());
    let word = |index| u64::from_le_bytes(random(index).as_bytes()[..8].try_into().expect("eight bytes"));
    (0..samples)
        .map(|sample| {
            let cost = if word(2 * sample) % 10_000 < long_of_10000 { long } else { short };
            cost * (850 + (word(2 * sample + 1) % 301) as u32) / 1000
        })
        .collect()
}

#[test]
fn a_study_of_short_and_long_samples_takes_hardly_longer_than_one_by_one() {
    let (us, ms, s) = (Duration::from_micros, Duration::from_millis, Duration::from_secs);
    let mut worst_without = 0.0_f64;
    println!(
        "samples  long     short   long   workers  over one by one: mean, worst (nothing taken back)  messages  asked \
         to leave"
    );
    for (samples, share, short, long) in [
        (1000, 500, ms(10), s(10)),
        (1000, 500, ms(1), s(10)),
        (1000, 50, ms(1), s(10)),
        (1000, 3000, ms(10), s(10)),
        (10_000, 500, ms(1), s(10)),
        (10_000, 10, us(10), s(10)),
    ] {
        for workers in [2, 8, 32, 64] {
            let (mut sum, mut worst, mut messages, mut relieved) = (0.0, 0.0_f64, 0, 0);
            let (mut sum_without, mut most_without) = (0.0, 0.0_f64);
            let seeds = 8;
            for seed in 0..seeds {
                let costs = study(samples, share, short, long, seed);
                let ideal = one_by_one(&costs, workers).as_secs_f64();
                let (time, said, left) = play(&costs, workers, true);
                let ratio = time.as_secs_f64() / ideal;
                let without = play(&costs, workers, false).0.as_secs_f64() / ideal;
                (sum_without, most_without) = (sum_without + without, most_without.max(without));
                (sum, worst, messages, relieved) = (sum + ratio, worst.max(ratio), messages + said, relieved + left);
            }
            let (mean, without) = (sum / seeds as f64, sum_without / seeds as f64);
            worst_without = worst_without.max(without);
            let (messages, percent) = (messages / seeds, share as f64 / 100.0);
            println!(
                "{samples:7}  {percent:4} %  {short:6?}  {long:4?}  {workers:7}  {mean:13.3} {worst:7.3} ({without:.3} {most_without:.3})  {messages:8}  {relieved:8}"
            );
            assert!(mean < 1.05, "{samples} samples of {short:?}, {percent} % of {long:?}, {workers} workers: {mean}");
        }
    }
    assert!(worst_without > 1.3, "there is something to be lost: {worst_without}");
}
