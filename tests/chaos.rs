//! A seeded storm over a study: orchestrator and workers killed and stopped at random states and random moments, continued and started again
//! until the study is complete; then its table must be the undisturbed one. The long run behind one command, with its figures:
//!
//! ```sh
//! BLADEOFF_CHAOS_SEED=1 BLADEOFF_CHAOS_MINUTES=5 cargo test --release --test chaos -- --ignored --nocapture
//! ```

mod support;

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::time::{Duration, Instant};
use support::Folder;
use support::faults::{Running, SAMPLES, STUDY, left_behind, lives, signal, state, wait_until};

/// splitmix64.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % n
    }
    fn of<'a>(&mut self, words: &[&'a str]) -> &'a str {
        words[self.below(words.len() as u64) as usize]
    }
}

/// What a storm did.
#[derive(Default)]
struct Figures {
    studies: u64,
    runs: u64,
    resumed: u64,
    /// Fired faults by target, action and state; by time, for those at a random moment.
    faults: BTreeMap<String, u64>,
    events: BTreeMap<String, u64>,
    computed: u64,
    dropped: u64,
}

/// One run with up to three faults at states and one at a moment; whether the study is complete.
fn disturbed_run(random: &mut Random, folder: &Folder, study: &str, out: &str, figures: &mut Figures) -> bool {
    let mut planned = Vec::new();
    for _ in 0..random.below(3) {
        let at = random.of(&["claimed", "running", "sent", "recorded"]);
        let (who, what) = match random.below(4) {
            0 => ("orchestrator", random.of(&["kill", "stop"])),
            1 => ("orchestrator", random.of(&["kill-worker", "stop-worker"])),
            _ if at == "recorded" => ("orchestrator", random.of(&["kill-worker", "stop-worker"])),
            _ => ("worker", random.of(&["kill", "stop"])),
        };
        planned.push((who, what, at, random.below(SAMPLES)));
    }
    let faults: Vec<_> = planned.iter().map(|(w, d, a, s)| format!("who={w},at={a},sample={s},do={d}")).collect();
    let mut run = Running::start(folder, study, out, &faults.join(";"));
    figures.runs += 1;
    let kill_after = (random.below(3) == 0).then(|| Duration::from_millis(random.below(1500)));
    let kill_what = random.of(&["orchestrator", "worker"]);
    let start = Instant::now();
    let mut is_due = kill_after.is_some();
    let status = loop {
        if let Some(status) = run.child.try_wait().expect("a child") {
            break status;
        }
        assert!(start.elapsed() < Duration::from_secs(240), "it hangs: {}", run.said());
        if is_due && kill_after.is_some_and(|after| start.elapsed() >= after) {
            is_due = false;
            let workers: Vec<u32> = run.workers().into_iter().filter(|&pid| lives(pid)).collect();
            let target = match kill_what {
                "orchestrator" => Some(run.child.id()),
                _ if workers.is_empty() => None,
                _ => Some(workers[random.below(workers.len() as u64) as usize]),
            };
            if target.is_some_and(|pid| signal(pid, "KILL")) {
                *figures.faults.entry(format!("{kill_what} kill, at a random moment")).or_default() += 1;
            }
        }
        // Whoever is stopped goes on a moment later; workers in half of the cases only when they are called stale.
        let stopped = |pid: &u32| state(*pid) == Some('T');
        if stopped(&run.child.id()) {
            signal(run.child.id(), "CONT");
        }
        let is_patient = planned.len() % 2 == 0;
        for pid in run.workers().iter().filter(|pid| stopped(pid)) {
            if is_patient || run.count("worker_stale") > 0 {
                signal(*pid, "CONT");
            }
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    for entry in fs::read_dir(&run.fired).expect("readable").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let mut parts = name.split('-').skip(1);
        let (at, sample) = (parts.next().expect("a state"), parts.next().expect("a sample"));
        let fired = planned.iter().find(|(_, _, a, s)| *a == at && s.to_string() == sample).expect("planned");
        *figures.faults.entry(format!("{} {}, at {}", fired.0, fired.1, fired.2)).or_default() += 1;
    }
    let events = run.events();
    for event in &events {
        *figures.events.entry(event["event"].as_str().unwrap_or("?").to_owned()).or_default() += 1;
    }
    figures.resumed += u64::from(events.first().is_some_and(|event| event["recorded"].as_u64() > Some(0)));
    figures.computed += run.count("sample") as u64;
    figures.dropped += events.iter().rev().find_map(|event| event["dropped_messages"].as_u64()).unwrap_or(0);
    let workers = run.workers();
    wait_until("its workers leave", || workers.iter().all(|&pid| !lives(pid)));
    let is_killed = status.signal() == Some(9);
    assert!(is_killed || status.success(), "{status}: {}", run.said());
    status.success()
}

fn storm(seed: u64, time: Duration) -> Figures {
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let mut calm = Running::start(&folder, &study, &folder.name("calm"), "");
    assert!(calm.end().success(), "{}", calm.said());
    let calm = fs::read(folder.path("calm/results.parquet")).expect("the table");
    let mut random = Random(seed);
    let mut figures = Figures::default();
    let start = Instant::now();
    while figures.studies == 0 || start.elapsed() < time {
        let out = folder.name(&format!("storm-{}", figures.studies));
        while !disturbed_run(&mut random, &folder, &study, &out, &mut figures) {}
        figures.studies += 1;
        let table = fs::read(format!("{out}/results.parquet")).expect("the table");
        assert!(table == calm, "seed {seed}, study {}: another table than the undisturbed one", figures.studies);
        assert!(left_behind(&out).is_empty(), "{:?} are left", left_behind(&out));
        fs::remove_dir_all(&out).expect("removed");
    }
    figures
}

#[test]
fn a_study_in_a_storm_equals_the_undisturbed_one() {
    let figures = storm(5, Duration::ZERO);
    assert_eq!(figures.studies, 1);
}

#[test]
#[ignore = "minutes; the command is in the first lines of this file"]
fn long_storm() {
    let number = |name: &str, default| std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default);
    let (seed, minutes) = (number("BLADEOFF_CHAOS_SEED", 1), number("BLADEOFF_CHAOS_MINUTES", 5));
    let figures = storm(seed, Duration::from_secs(60 * minutes));
    println!("seed {seed}, {minutes} minutes: {} studies of {SAMPLES} samples, every table equal", figures.studies);
    println!("runs {}, of which continued a record {}", figures.runs, figures.resumed);
    println!("results recorded {} of {} needed", figures.computed, figures.studies * SAMPLES);
    println!("messages dropped {}, left in shared memory 0", figures.dropped);
    figures.faults.iter().for_each(|(fault, count)| println!("  {count:5}  {fault}"));
    figures.events.iter().for_each(|(event, count)| println!("  {count:5}  event {event}"));
}

#[test]
fn short_runs_leave_nothing_behind() {
    short_runs(5);
}

#[test]
#[ignore = "minutes: 1000 runs; cargo test --release --test chaos -- --ignored --nocapture thousand"]
fn a_thousand_short_runs_leave_nothing_behind() {
    let start = Instant::now();
    short_runs(1000);
    println!("1000 runs in {:.0} s, nothing left", start.elapsed().as_secs_f64());
}

fn short_runs(count: u32) {
    let folder = Folder::new();
    let text = "schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"0.001 s\"\n";
    let study = folder.write("s.toml", text);
    for _ in 0..count {
        let out = folder.name("out");
        let mut run = Running::start(&folder, &study, &out, "");
        assert!(run.end().success(), "{}", run.said());
        assert!(!fs::read_to_string(format!("{out}/workers.log")).expect("a log").is_empty());
        assert!(left_behind(&out).is_empty(), "{:?}", left_behind(&out));
        fs::remove_dir_all(&out).expect("removed");
    }
}
