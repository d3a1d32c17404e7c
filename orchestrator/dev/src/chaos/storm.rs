//! Chaos test: random faults, counts of what happened, and checks of the results.

use super::disturbed::{PAUSE, Running, WATCHDOG, left_behind, lives, state};
use super::error::ChaosError;
use super::subject::{LAB_RIG, SAMPLES, STUDY};
use bladeoff_system::files::FileError;
use bladeoff_system::random::SplitMix;
use bladeoff_worker::process::signal;
use rustix::process::Signal;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

const STATES: [&str; 4] = ["claimed", "running", "sent", "recorded"];

/// A chaos test in progress.
#[derive(Debug)]
pub struct Storm {
    program: PathBuf,
    folder: PathBuf,
    random: SplitMix,
    calm: Vec<u8>,
    figures: Figures,
}

/// Counts of a chaos test.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Figures {
    /// Completed studies, each with the undisturbed table and without remaining files.
    pub studies: u64,
    /// Runs of these studies.
    pub runs: u64,
    /// Runs that resumed a record with results.
    pub resumed: u64,
    /// Fired faults by target, action and state, and faults at random times.
    pub faults: BTreeMap<String, u64>,
    /// Events of the runs, by name.
    pub events: BTreeMap<String, u64>,
    /// Results reported in events.
    pub told: u64,
    /// Discarded messages.
    pub dropped: u64,
}

impl Storm {
    /// Prepares a chaos test in an empty folder: study, and undisturbed table. `program`: the `bladeoff-dev` under test.
    ///
    /// # Errors
    /// The undisturbed run fails.
    pub fn new(program: &Path, folder: &Path, seed: u64) -> Result<Self, ChaosError> {
        let machines = folder.join("machines");
        fs::create_dir(&machines).map_err(FileError::at("create", &machines))?;
        for (name, text) in [("machines/rig.toml", LAB_RIG), ("s.toml", STUDY)] {
            let path = folder.join(name);
            fs::write(&path, text).map_err(FileError::at("write", &path))?;
        }
        let mut storm = Self {
            program: program.to_path_buf(),
            folder: folder.to_path_buf(),
            random: SplitMix(seed),
            calm: Vec::new(),
            figures: Figures::default(),
        };
        let out = folder.join("calm");
        let mut run = storm.start(&out, "calm-run", "")?;
        let status = run.end(|_| {})?;
        if !status.success() {
            return Err(ChaosError::Failed { status: status.to_string(), said: run.said() });
        }
        storm.calm = table(&out)?;
        Ok(storm)
    }

    /// Runs one study with random faults until it is complete.
    ///
    /// # Errors
    /// The error that was found.
    pub fn study(&mut self) -> Result<(), ChaosError> {
        let study = self.figures.studies + 1;
        let out = self.folder.join(format!("storm-{study}"));
        while !self.disturbed_run(&out)? {}
        if table(&out)? != self.calm {
            // outside of the temporary folder, which is removed
            let kept = std::env::temp_dir().join(format!("bladeoff-chaos-{}-{study}", std::process::id()));
            fs::rename(&out, &kept).map_err(FileError::at("rename to", &kept))?;
            return Err(ChaosError::Differs { study, directory: kept });
        }
        let left = left_behind(&out);
        if !left.is_empty() {
            return Err(ChaosError::Left { study, left });
        }
        fs::remove_dir_all(&out).map_err(FileError::at("remove", &out))?;
        self.figures.studies = study;
        Ok(())
    }

    /// Counts so far.
    #[must_use]
    pub fn figures(&self) -> &Figures {
        &self.figures
    }

    fn start(&self, out: &Path, scratch: &str, faults: &str) -> Result<Running, ChaosError> {
        let scratch = self.folder.join(scratch);
        fs::create_dir(&scratch).map_err(FileError::at("create", &scratch))?;
        let mut command = Command::new(&self.program);
        command.arg("run").arg(self.folder.join("s.toml")).arg("--out").arg(out);
        command.args(["--workers", "2", "--refresh", "0.2", "--json-events"]);
        Running::start(command, &scratch, faults)
    }

    /// One run with up to two faults at states and one at a random time; returns whether the study is complete.
    fn disturbed_run(&mut self, out: &Path) -> Result<bool, ChaosError> {
        let random = &mut self.random;
        let mut planned = Vec::new();
        for _ in 0..random.below(3) {
            let at = one_of(random, &STATES);
            let (who, what) = match random.below(4) {
                0 => ("orchestrator", one_of(random, &["kill", "stop"])),
                1 => ("orchestrator", one_of(random, &["kill-worker", "stop-worker"])),
                _ if at == "recorded" => ("orchestrator", one_of(random, &["kill-worker", "stop-worker"])),
                _ => ("worker", one_of(random, &["kill", "stop"])),
            };
            planned.push((who, what, at, random.below(SAMPLES).to_string()));
        }
        let kill_after = (random.below(3) == 0).then(|| Duration::from_millis(random.below(1500)));
        let kill_what = one_of(random, &["orchestrator", "worker"]);
        let which = random.below(u64::MAX);
        let faults: Vec<_> = planned.iter().map(|(w, d, a, s)| format!("who={w},at={a},sample={s},do={d}")).collect();
        let faults = format!("{PAUSE};{}", faults.join(";"));
        let mut run = self.start(out, &format!("run-{}", self.figures.runs), &faults)?;
        self.figures.runs += 1;
        let (start, orchestrator) = (Instant::now(), run.child.id());
        let mut is_due = kill_after.is_some();
        let mut killed = None;
        let status = run.end(|run| {
            if is_due && kill_after.is_some_and(|after| start.elapsed() >= after) {
                is_due = false;
                let workers: Vec<u32> = run.workers().into_iter().filter(|&pid| lives(pid)).collect();
                let target = match kill_what {
                    "orchestrator" => Some(orchestrator),
                    _ => workers.get((which % workers.len().max(1) as u64) as usize).copied(),
                };
                killed = killed.or(target.filter(|&pid| signal(pid, Signal::KILL)));
            }
            // stopped processes continue after a moment; workers in half of the cases only after they are reported as stale
            let is_stopped = |pid: u32| state(pid) == Some('T');
            if is_stopped(orchestrator) {
                let _ = signal(orchestrator, Signal::CONT);
            }
            let is_patient = planned.len() % 2 == 0;
            for pid in run.workers().into_iter().filter(|&pid| is_stopped(pid)) {
                if is_patient || run.count("worker_stale") > 0 {
                    let _ = signal(pid, Signal::CONT);
                }
            }
        })?;
        let figures = &mut self.figures;
        let mut count = |fault: String| *figures.faults.entry(fault).or_default() += 1;
        if killed.is_some() {
            count(format!("{kill_what} kill, at a random moment"));
        }
        for (at, sample) in run.fired() {
            let fired = planned.iter().find(|(_, _, a, s)| *a == at && *s == sample);
            let (who, what, _, _) = fired.expect("only what is planned fires");
            count(format!("{who} {what}, at {at}"));
        }
        let events = run.events();
        for event in &events {
            *figures.events.entry(event["event"].as_str().unwrap_or("?").to_owned()).or_default() += 1;
        }
        figures.resumed += u64::from(events.first().is_some_and(|event| event["recorded"].as_u64() > Some(0)));
        figures.told += run.count("sample") as u64;
        figures.dropped += events.iter().rev().find_map(|event| event["dropped_messages"].as_u64()).unwrap_or(0);
        let workers = run.workers();
        let ended = Instant::now();
        while workers.iter().any(|&pid| lives(pid)) {
            if ended.elapsed() > WATCHDOG {
                return Err(ChaosError::Hangs { what: "a worker whose run has ended", said: run.said() });
            }
            thread::sleep(Duration::from_millis(10));
        }
        if status.signal() == Some(9) || status.success() {
            return Ok(status.success());
        }
        Err(ChaosError::Failed { status: status.to_string(), said: run.said() })
    }
}

impl Figures {
    /// Counts as text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = format!(
            "{} studies of {SAMPLES} samples, every table equal to the undisturbed one, nothing left in shared memory\n\
             {} runs, of which {} continued a record with results\n\
             {} results told of {} recorded (the others were durable, but not told before a kill)\n\
             {} messages dropped\n",
            self.studies,
            self.runs,
            self.resumed,
            self.told,
            self.studies * SAMPLES,
            self.dropped,
        );
        let mut line = |count: &u64, what: &str| writeln!(text, "  {count:6}  {what}").expect("writing to a String");
        self.faults.iter().for_each(|(fault, count)| line(count, fault));
        self.events.iter().for_each(|(event, count)| line(count, &format!("event {event}")));
        text
    }
}

fn table(out: &Path) -> Result<Vec<u8>, FileError> {
    let path = out.join("results.parquet");
    fs::read(&path).map_err(FileError::at("read", &path))
}

fn one_of<'a>(random: &mut SplitMix, words: &[&'a str]) -> &'a str {
    words[random.below(words.len() as u64) as usize]
}
