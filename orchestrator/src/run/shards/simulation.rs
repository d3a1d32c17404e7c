//! Simulation of shards on slow and failing nodes and a slow file system, with the state machine that chooses chunks and without
//! I/O. Regenerate the table of docs/cluster-methods.md with

use super::attempt::{heartbeat_interval, stale_after};
use super::choose::{Choice, ChunkChooser, ChunkState, Lookup};
use super::layout::{PER_FOLDER, Shard};
use bladeoff_system::random::SplitMix;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::convert::Infallible;

/// Parameters of a simulated cluster.
#[derive(Debug, Clone, Copy)]
struct World {
    tasks: u64,
    /// Chunks per task.
    each: u64,
    /// Work of a chunk \[s\] on a node of speed 1; individual chunks take between half and twice as long.
    chunk: f64,
    /// Mean time between failures of a node \[h\].
    failure: f64,
    /// Share of the nodes that are four times slower.
    slow: f64,
    /// Time to publish a chunk \[s\].
    publishing: f64,
}

/// Result of a simulation.
#[derive(Debug, Clone, Copy)]
struct Played {
    /// Time until the end, relative to all work divided by the sum of the speeds.
    against_ideal: f64,
    /// Upper bound of `against_ideal` for the simulated faults: [`latest`].
    at_most: f64,
    attempts: u64,
    lost: u64,
    /// File system operations per chunk.
    operations: f64,
    /// File system operations of all tasks per second, including heartbeats.
    a_second: f64,
}

/// Time within which all tasks begin \[s\].
const BEGIN: f64 = 30.0;
/// A chunk takes up to this factor longer or shorter than the usual one.
const SPREAD: f64 = 2.0;
/// Time after which a dead task is started again \[s\].
const AGAIN: f64 = 120.0;
/// File system operations to publish a chunk: create and remove a hint, create a file, link it, remove its own name, sync the folder.
const PUBLISHING: u64 = 6;
/// File system operations of a heartbeat: create a file, rename it, look up both folders.
const BEATING: u64 = 4;
/// Time between two checks of a waiting task \[s\].
const LOOK: f64 = 5.0;

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Event {
    Begins { task: usize },
    Done { task: usize, attempt: u64, chunk: u64 },
    Looks { task: usize, attempt: u64 },
    Dies { task: usize, attempt: u64 },
}

struct Task {
    chooser: ChunkChooser,
    shard: Shard,
    attempt: u64,
    speed: f64,
    /// Chunk in progress.
    at: Option<u64>,
    is_over: bool,
}

/// Faults of the nodes, independent of the choice of chunks.
struct Happened {
    /// All work \[s\].
    work: f64,
    /// Speeds of all nodes: sum, smallest, largest.
    speed: (f64, f64, f64),
    /// Number of tasks that died during a chunk.
    deaths: u64,
    /// Number of tasks that died during a chunk of the shard whose chunk was published last.
    at_last: u64,
}

/// Upper bound of the end \[s\], if no node waits while a missing chunk is in progress on no node.
///
/// Let c be the last chunk, and suppose that no task dies during a chunk of its shard. Until c is taken, every task sees a missing chunk, so all
/// nodes compute from their begin on: the work of all chunks, the lost work of dead tasks, and what those could have computed until their
/// restart; in addition they publish.
///
/// ```text
/// V t <= V BEGIN + W + D (w + v (p + AGAIN)) + N v p
/// ```
/// V: sum of the speeds, v the largest, u the smallest; W: all work, w of the longest chunk; D: deaths; N: chunks; p: time to publish one.
/// Then c itself takes as long as the longest chunk on the slowest node, L = w / u + p. A death during a chunk of that shard costs another L,
/// the time until its hint is stale and was checked again, or until the task is restarted; and the owner may then be computing a chunk of
/// another shard: L again.
fn latest(world: &World, happened: &Happened) -> f64 {
    let World { tasks, each, chunk, publishing, .. } = *world;
    let Happened { work, speed: (all, least, most), deaths, at_last } = *happened;
    let longest = SPREAD * chunk;
    let by_death = longest + most * (publishing + AGAIN);
    let all_compute = (work + deaths as f64 * by_death + (tasks * each) as f64 * most * publishing) / all;
    let last = longest / least + publishing;
    let found_again = AGAIN.max(stale_after(tasks).as_secs_f64() + LOOK);
    BEGIN + all_compute + last + at_last as f64 * (2.0 * last + found_again)
}

fn play(world: World, seed: u64) -> Played {
    let mut random = SplitMix(seed);
    let chunks = world.tasks * world.each;
    let work: Vec<f64> = (0..chunks).map(|_| world.chunk * SPREAD.powf(2.0 * random.unit() - 1.0)).collect();
    let mut there = vec![false; chunks as usize];
    // task and attempt of the hint on each chunk; time of the last heartbeat of a dead attempt
    let mut hints: Vec<Option<(usize, u64)>> = vec![None; chunks as usize];
    let mut tasks: Vec<Task> = (0..world.tasks)
        .map(|number| {
            let shard = Shard { number, of: world.tasks };
            let speed = if random.unit() < world.slow { 0.25 } else { 0.9 + 0.2 * random.unit() };
            Task { chooser: ChunkChooser::new(shard, chunks), shard, attempt: 0, speed, at: None, is_over: false }
        })
        .collect();
    let speeds = || tasks.iter().map(|task| task.speed);
    let speed = (speeds().sum(), speeds().fold(f64::INFINITY, f64::min), speeds().fold(0.0, f64::max));
    // number of tasks that died during a chunk, by shard; the last chunk
    let (mut died, mut last) = (vec![0; tasks.len()], 0);
    let mut deaths: Vec<Option<f64>> = vec![None; world.tasks as usize];
    let mut queue = BinaryHeap::new();
    let at = |time: f64| (time * 1e6) as u64;
    // the tasks begin at different times
    (0..tasks.len()).for_each(|task| queue.push(Reverse((at(BEGIN * random.unit()), Event::Begins { task }))));
    let (mut attempts, mut lost, mut operations, mut left, mut end) = (0, 0, 0u64, chunks, 0.0);
    while let Some(Reverse((now, event))) = queue.pop() {
        let now = now as f64 / 1e6;
        let (number, attempt) = match event {
            Event::Begins { task } => {
                tasks[task].attempt += 1;
                attempts += 1;
                deaths[task] = None;
                tasks[task].chooser = ChunkChooser::new(tasks[task].shard, chunks);
                let dies = now - 3600.0 * world.failure * (1.0 - random.unit()).ln();
                queue.push(Reverse((at(dies), Event::Dies { task, attempt: tasks[task].attempt })));
                (task, tasks[task].attempt)
            }
            Event::Dies { task, attempt } => {
                if tasks[task].attempt == attempt && !tasks[task].is_over && left > 0 {
                    deaths[task] = Some(now);
                    tasks[task].at.take().iter().for_each(|chunk| died[(chunk % world.tasks) as usize] += 1);
                    tasks[task].attempt += 1;
                    queue.push(Reverse((at(now + AGAIN), Event::Begins { task })));
                }
                continue;
            }
            Event::Done { task, attempt, chunk } => {
                if tasks[task].attempt != attempt {
                    continue;
                }
                operations += PUBLISHING;
                tasks[task].at = None;
                let there = &mut there[chunk as usize];
                if *there {
                    lost += 1;
                } else {
                    (*there, left, end, last) = (true, left - 1, now, chunk);
                }
                hints[chunk as usize] = None;
                (task, attempt)
            }
            Event::Looks { task, attempt } => (task, attempt),
        };
        if tasks[number].attempt != attempt {
            continue;
        }
        let mut listed = u64::MAX;
        let mut chooser = tasks[number].chooser.clone();
        let choice = chooser.choose(|chunk, lookup| {
            let folder = chunk / PER_FOLDER;
            if lookup == Lookup::Folder && listed != folder {
                // chunks and hints: one folder in a folder each
                (listed, operations) = (folder, operations + 4);
            }
            if there[chunk as usize] {
                operations += u64::from(lookup == Lookup::Single);
                return Ok::<_, Infallible>(ChunkState::Published);
            }
            if lookup == Lookup::Folder && hints[chunk as usize].is_some() {
                return Ok(ChunkState::InProgress);
            }
            operations += 3;
            let fresh = |(task, of): (usize, u64)| {
                let lives = tasks[task].attempt == of && deaths[task].is_none();
                task != number
                    && (lives || deaths[task].is_some_and(|death| now - death < stale_after(world.tasks).as_secs_f64()))
            };
            Ok(if hints[chunk as usize].is_some_and(fresh) { ChunkState::InProgress } else { ChunkState::Missing })
        });
        tasks[number].chooser = chooser;
        match choice.expect("no error") {
            Choice::Compute(chunk) => {
                hints[chunk as usize] = Some((number, attempt));
                tasks[number].at = Some(chunk);
                let takes = work[chunk as usize] / tasks[number].speed + world.publishing;
                queue.push(Reverse((at(now + takes), Event::Done { task: number, attempt, chunk })));
            }
            Choice::Wait => queue.push(Reverse((at(now + LOOK), Event::Looks { task: number, attempt }))),
            Choice::Done => tasks[number].is_over = true,
        }
    }
    assert_eq!(left, 0, "{world:?}: every chunk is there");
    let beats = end / heartbeat_interval(world.tasks).as_secs_f64() * (world.tasks * BEATING) as f64;
    let a_second = (operations as f64 + beats) / end;
    let work = work.iter().sum();
    let at_last = died[(last % world.tasks) as usize];
    let happened = Happened { work, speed, deaths: died.iter().sum(), at_last };
    let ideal = work / speed.0;
    Played {
        against_ideal: end / ideal,
        at_most: latest(&world, &happened) / ideal,
        attempts,
        lost,
        operations: operations as f64 / chunks as f64,
        a_second,
    }
}

#[test]
fn shards_on_failing_slow_and_many_nodes_end_near_the_ideal() {
    let usual = World { tasks: 16, each: 480, chunk: 60.0, failure: 1e9, slow: 0.0, publishing: 0.05 };
    let failing = |tasks, each| World { tasks, each, slow: 0.1, failure: 24.0, ..usual };
    let worlds = [
        ("16 nodes, a night", usual),
        ("a quarter of them four times as slow", World { slow: 0.25, ..usual }),
        ("each dies once in 24 h", World { failure: 24.0, ..usual }),
        ("publishing takes 5 s", World { publishing: 5.0, ..usual }),
        ("1 000 nodes, an hour", World { tasks: 1000, each: 60, ..usual }),
        ("  a tenth slow, each dies once in 24 h", failing(1000, 60)),
        ("10 000 nodes, five minutes", World { tasks: 10_000, each: 5, ..usual }),
        ("  a tenth slow, each dies once in 24 h", failing(10_000, 5)),
    ];
    println!(
        "| | chunks | attempts | time / ideal | at most | operations on names a chunk | of all a second |\n\
         |---|---|---|---|---|---|---|"
    );
    for (name, world) in worlds {
        let played = play(world, 7);
        let Played { against_ideal, at_most, attempts, lost, operations, a_second } = played;
        let chunks = world.tasks * world.each;
        println!(
            "| {name} | {chunks} | {attempts} | {against_ideal:.3} | {at_most:.3} | {operations:.1} | {a_second:.0} |"
        );
        assert!(against_ideal >= 1.0 && against_ideal <= at_most, "{name}: {played:?}");
        // no other task takes a chunk while the attempt that owns its hint lives
        assert_eq!(lost, 0, "{name}: computed twice: {played:?}");
        assert!(attempts >= world.tasks && (world.failure > 1e6 || attempts > world.tasks), "{name}: {played:?}");
    }
}
