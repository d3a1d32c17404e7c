//! Rules that every transport keeps: in memory, over iceoryx2 (here between threads, which iceoryx2 treats like processes), and the faulty
//! transport with no fault enabled.

mod transports;

use std::path::Path;
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use bladeoff_protocol::domain::Domain;
use bladeoff_protocol::ipc::{IpcHub, IpcWorker};
use bladeoff_protocol::link::{HubLink, Incoming, LinkError, WorkerLink};
use bladeoff_protocol::messages::{Batch, BatchId, Body, Hello, Report, RunId, ToWorker, WorkerId};
use bladeoff_protocol::transport::{HubPort, PortError, Ticket, WorkerPort};
use transports::{FaultRates, FaultyHub, MemoryHub, MemoryNet, MemoryWorker};

const RUN: RunId = RunId(0xc0ffee);
/// Limit on each step of a test, ample even on a slow machine; a hang becomes a failure.
const WATCHDOG: Duration = Duration::from_secs(60);

/// Creates the two ends of one kind of transport.
trait Kind {
    type Hub: HubPort;
    type Worker: WorkerPort + 'static;
    /// Messages of each worker in `workers_that_ask_together_are_heard_at_once`: transports in memory have no rare losses to wait for.
    const ROUNDS: u64 = 10_000;
    fn hub(&mut self) -> Self::Hub;
    /// The result is called on the worker's thread.
    fn connector(&self) -> Box<dyn Fn(WorkerId) -> Self::Worker + Send>;
}

struct Memory(MemoryNet);

impl Kind for Memory {
    type Hub = MemoryHub;
    type Worker = MemoryWorker;
    fn hub(&mut self) -> MemoryHub {
        self.0.hub()
    }
    fn connector(&self) -> Box<dyn Fn(WorkerId) -> MemoryWorker + Send> {
        let net = self.0.clone();
        Box::new(move |_| net.worker())
    }
}

struct SoundFaulty(MemoryNet);

impl Kind for SoundFaulty {
    type Hub = FaultyHub<MemoryHub>;
    type Worker = MemoryWorker;
    fn hub(&mut self) -> Self::Hub {
        FaultyHub::new(self.0.hub(), FaultRates::default(), 1)
    }
    fn connector(&self) -> Box<dyn Fn(WorkerId) -> MemoryWorker + Send> {
        let net = self.0.clone();
        Box::new(move |_| net.worker())
    }
}

/// A domain in its own directory, so that tests do not interfere.
struct Ipc {
    domain: Domain,
    _base: tempfile::TempDir,
}

impl Ipc {
    fn new() -> Self {
        let base = tempfile::Builder::new().prefix("bo").tempdir_in("/tmp").expect("temporary directory");
        Self { domain: Domain::create_below(&base.path().join("b"), 4).expect("a domain"), _base: base }
    }
}

impl Kind for Ipc {
    type Hub = IpcHub;
    type Worker = IpcWorker;
    const ROUNDS: u64 = 150_000;
    fn hub(&mut self) -> IpcHub {
        IpcHub::create(self.domain.address(), 4).expect("a hub")
    }
    fn connector(&self) -> Box<dyn Fn(WorkerId) -> IpcWorker + Send> {
        let address = self.domain.address().clone();
        Box::new(move |worker| IpcWorker::connect(&address, worker, None).expect("connected"))
    }
}

fn receive<H: HubPort>(hub: &mut HubLink<H>) -> Incoming {
    let start = Instant::now();
    while start.elapsed() < WATCHDOG {
        if let Some(incoming) = hub.try_receive().expect("a sound transport") {
            return incoming;
        }
        hub.wait(WATCHDOG).expect("a sound transport");
    }
    panic!("no message within {WATCHDOG:?}");
}

fn hello() -> Body {
    Body::Hello(Hello { pid: 1, build: 2 })
}

fn ask() -> Body {
    Body::Report(Report { batch: None, samples: Vec::new(), asks: true })
}

fn batch(number: u64) -> ToWorker {
    let samples: Vec<u64> = (0..64).map(|i| number * 64 + i).collect();
    let params = samples.iter().map(|&sample| sample as f64 / 3.0).collect();
    ToWorker::Batch(Batch { batch: BatchId(number), attempt: 1, n_params: 1, samples, params })
}

/// Many batches to several workers: each worker gets exactly its own batches, in order.
fn answers_reach_the_worker_that_asked<K: Kind>(mut kind: K) {
    const WORKERS: u32 = 3;
    const BATCHES: u64 = 300;
    let mut hub = HubLink::new(kind.hub(), RUN);
    let threads: Vec<_> = (1..=WORKERS)
        .map(|n| {
            let connect = kind.connector();
            thread::spawn(move || {
                let worker = WorkerId(n);
                let mut link = WorkerLink::new(connect(worker), RUN, worker);
                link.send(hello()).expect("sent");
                assert_eq!(link.receive().expect("an answer"), ToWorker::Continue);
                let mut seen = Vec::new();
                loop {
                    link.send(ask()).expect("sent");
                    match link.receive().expect("an answer") {
                        ToWorker::Batch(batch) => seen.push(batch),
                        ToWorker::Stop => return seen,
                        other => panic!("{other:?} is no answer to a request for work"),
                    }
                }
            })
        })
        .collect();
    let (mut next, mut stopped) = (0, 0);
    let mut given = vec![Vec::new(); WORKERS as usize];
    while stopped < WORKERS {
        let Incoming { ticket, message } = receive(&mut hub);
        let answer = match message.body {
            Body::Hello(_) => ToWorker::Continue,
            Body::Report(_) if next < BATCHES => {
                next += 1;
                given[message.worker.0 as usize - 1].push(next);
                batch(next)
            }
            Body::Report(_) => {
                stopped += 1;
                ToWorker::Stop
            }
        };
        hub.answer(ticket, message.worker, &answer).expect("answered");
    }
    for (thread, given) in threads.into_iter().zip(given) {
        let seen = thread.join().expect("the worker is content");
        assert_eq!(seen.len(), given.len());
        assert!(seen.into_iter().zip(given).all(|(seen, number)| ToWorker::Batch(seen) == batch(number)));
    }
    assert_eq!(hub.dropped(), 0);
}

fn a_second_request_before_the_answer_is_refused<K: Kind>(mut kind: K) {
    let mut hub = HubLink::new(kind.hub(), RUN);
    let mut link = WorkerLink::new(kind.connector()(WorkerId(1)), RUN, WorkerId(1));
    link.send(hello()).expect("sent");
    assert!(matches!(link.send(ask()), Err(LinkError::Port(PortError::RequestOpen))));
    assert!(link.try_receive().expect("nothing wrong").is_none());
    let Incoming { ticket, message } = receive(&mut hub);
    assert_eq!(message.body, hello());
    hub.answer(ticket, WorkerId(1), &ToWorker::Continue).expect("answered");
    assert_eq!(link.receive().expect("an answer"), ToWorker::Continue);
    link.send(ask()).expect("now it may");
    assert!(matches!(
        hub.answer(ticket, WorkerId(1), &ToWorker::Stop),
        Err(LinkError::Port(PortError::UnknownTicket(Ticket(_))))
    ));
}

fn a_worker_that_left_can_not_be_answered<K: Kind>(mut kind: K) {
    let mut hub = HubLink::new(kind.hub(), RUN);
    let connect = kind.connector();
    let mut link = WorkerLink::new(connect(WorkerId(1)), RUN, WorkerId(1));
    link.send(hello()).expect("sent");
    let Incoming { ticket, .. } = receive(&mut hub);
    drop(link);
    let answer = hub.answer(ticket, WorkerId(1), &ToWorker::Continue);
    assert!(matches!(answer, Err(LinkError::Port(PortError::UnknownTicket(_)))), "{answer:?}");
    hub.reap(WorkerId(1));
    // A worker with the same number may connect again after that, not before.
    let mut again = WorkerLink::new(connect(WorkerId(1)), RUN, WorkerId(1));
    again.send(hello()).expect("sent");
    assert_eq!(receive(&mut hub).message.worker, WorkerId(1));
}

fn nobody_speaks_for_another<K: Kind>(mut kind: K) {
    let mut hub = HubLink::new(kind.hub(), RUN);
    let connect = kind.connector();
    let mut honest = WorkerLink::new(connect(WorkerId(1)), RUN, WorkerId(1));
    let mut impostor = WorkerLink::new(connect(WorkerId(2)), RUN, WorkerId(1));
    let mut stranger = WorkerLink::new(connect(WorkerId(3)), RunId(1), WorkerId(3));
    honest.send(hello()).expect("sent");
    assert_eq!(receive(&mut hub).message.worker, WorkerId(1));
    impostor.send(hello()).expect("sent");
    stranger.send(hello()).expect("sent");
    let start = Instant::now();
    while hub.dropped() < 2 && start.elapsed() < WATCHDOG {
        assert_eq!(hub.try_receive().expect("a sound transport"), None);
        hub.wait(Duration::from_millis(100)).expect("a sound transport");
    }
    assert_eq!(hub.dropped(), 2);
    assert!(matches!(hub.take_refused(), Some((_, 2))), "both are said");
    assert_eq!(hub.take_refused(), None);
}

fn the_waker_ends_a_wait<K: Kind>(mut kind: K) {
    let mut hub = kind.hub();
    let waker = hub.waker();
    let (begin, begun) = mpsc::channel();
    let thread = thread::spawn(move || {
        begun.recv().expect("the test goes on");
        waker();
    });
    begin.send(()).expect("the thread waits");
    let start = Instant::now();
    hub.wait(WATCHDOG).expect("a sound transport");
    assert!(start.elapsed() < WATCHDOG / 2);
    thread.join().expect("woken");
}

/// Workers that ask at once and without pause: each wait ends with a message. (Without the countermeasure in `ipc_services::wait`,
/// iceoryx2 withholds a wake-up once in some 100 000 messages, and every later wait then lasts until the backstop.)
fn workers_that_ask_together_are_heard_at_once<K: Kind>(mut kind: K) {
    const WORKERS: u32 = 3;
    // A withheld wake-up delays every later message; a busy machine delays single ones.
    const SLOW: Duration = Duration::from_millis(900);
    const MOST_SLOW: u32 = 20;
    let mut hub = HubLink::new(kind.hub(), RUN);
    let threads: Vec<_> = (1..=WORKERS)
        .map(|number| {
            let connect = kind.connector();
            thread::spawn(move || {
                let worker = WorkerId(number);
                let mut link = WorkerLink::new(connect(worker), RUN, worker);
                let mut slow = 0;
                for round in 0..K::ROUNDS {
                    let start = Instant::now();
                    link.send(if round == 0 { hello() } else { ask() }).expect("sent");
                    link.receive().expect("answered");
                    slow += u32::from(start.elapsed() > SLOW);
                    assert!(slow <= MOST_SLOW, "{slow} of {round} messages waited for the backstop");
                }
            })
        })
        .collect();
    for _ in 0..u64::from(WORKERS) * K::ROUNDS {
        let incoming = receive(&mut hub);
        hub.answer(incoming.ticket, incoming.message.worker, &ToWorker::Continue).expect("answered");
    }
    threads.into_iter().for_each(|thread| thread.join().expect("no panic"));
}

macro_rules! conformance {
    ($($name:ident),+) => {
        mod memory { $( #[test] fn $name() { super::$name(super::Memory(super::MemoryNet::default())); } )+ }
        mod sound_faulty { $( #[test] fn $name() { super::$name(super::SoundFaulty(super::MemoryNet::default())); } )+ }
        mod ipc { $( #[test] fn $name() { super::$name(super::Ipc::new()); } )+ }
    };
}

conformance!(
    answers_reach_the_worker_that_asked,
    a_second_request_before_the_answer_is_refused,
    a_worker_that_left_can_not_be_answered,
    nobody_speaks_for_another,
    workers_that_ask_together_are_heard_at_once,
    the_waker_ends_a_wait
);

#[test]
fn the_faulty_transport_does_what_it_says_and_damage_is_always_seen() {
    let net = MemoryNet::default();
    let rates = FaultRates { lose: 0.1, double: 0.1, delay: 0.1, damage: 0.2 };
    let mut hub = HubLink::new(FaultyHub::new(net.hub(), rates, 42), RUN);
    let mut greeted = 0;
    for n in 1..=2000 {
        let mut link = WorkerLink::new(net.worker(), RUN, WorkerId(n));
        link.send(hello()).expect("sent");
        while let Some(incoming) = hub.try_receive().expect("memory does not fail") {
            assert_eq!(incoming.message.body, hello(), "a damaged message was believed");
            greeted += 1;
        }
    }
    assert!((1000..2000).contains(&greeted), "{greeted}");
    assert!((100..1200).contains(&hub.dropped()), "{}", hub.dropped());
}

#[test]
fn nothing_is_left_of_a_domain_that_was_used() {
    let mut kind = Ipc::new();
    let address = kind.domain.address().clone();
    let (hub, worker) = (kind.hub(), kind.connector()(WorkerId(1)));
    assert!(left_in_shm(&address.prefix) > 0, "iceoryx2 keeps its memory elsewhere: the check below proves nothing");
    drop((worker, hub));
    assert!(kind.domain.close().is_empty());
    assert_eq!(left_in_shm(&address.prefix), 0);
    assert!(!address.root.exists());
}

/// The umask of this process; the most frequent value counts, because other tests here create listeners too.
fn umask() -> String {
    let mut looks = std::collections::BTreeMap::new();
    for _ in 0..100 {
        let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
        let line = status.lines().find(|line| line.starts_with("Umask:")).expect("since Linux 4.7");
        *looks.entry(line.to_owned()).or_insert(0) += 1;
        thread::sleep(Duration::from_millis(1));
    }
    looks.into_iter().max_by_key(|(_, count)| *count).expect("looked").0
}

#[test]
fn listeners_created_at_once_leave_the_umask() {
    let before = umask();
    let kinds: Vec<Ipc> = (0..4).map(|_| Ipc::new()).collect();
    thread::scope(|scope| {
        for mut kind in kinds {
            scope.spawn(move || (0..40).for_each(|_| drop(kind.hub())));
        }
    });
    assert_eq!(umask(), before);
}

fn left_in_shm(prefix: &str) -> usize {
    let names = std::fs::read_dir(Path::new("/dev/shm")).expect("readable").flatten();
    names.filter(|entry| entry.file_name().to_string_lossy().starts_with(prefix)).count()
}

#[test]
fn a_worker_without_an_orchestrator_is_refused_at_once() {
    let kind = Ipc::new();
    let refused = IpcWorker::connect(kind.domain.address(), WorkerId(1), None);
    assert!(matches!(refused, Err(PortError::Failed { .. })));
    let address = kind.domain.address().clone();
    std::fs::remove_dir_all(&address.root).expect("removed");
    let refused = IpcWorker::connect(&address, WorkerId(1), None);
    assert!(matches!(refused, Err(PortError::RootGone { .. })) && !address.root.exists());
}
