//! `bladeoff bench dispatch`: measured cost of the dispatch on this machine.

use super::super::error::CliError;
use super::super::exit::Exit;
use super::super::output::{print, remark};
use super::cost::peak_mb;
use super::figures;
use super::host::{Folder, load};
use super::lengths;
use super::stages::Stages;
use super::stand_in::{Nobody, Numbers, RecordSink, options};
use crate::dispatch::{self, Activity, Observer, Snapshot, Todo};
use crate::run::{RunError, order};
use bladeoff_record::Record;
use serde_json::json;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// Overhead per durable sample, idle CPU, memory, start-up, resume and tables, with samples that compute nothing
///
/// Worker processes answer with 40 numbers at once, and samples are assigned in the order of a run. Every result uses the
/// real messages and the real record with its syncs. If there is a python3, its ProcessPoolExecutor returns as many
/// numbers from as many processes in the same run, without a record.
///
/// Then a result directory with as many recorded results is resumed, its rows are written as parts and tables and summed
/// up, and it is taken over into a study of twice the size. Each of these is a process of its own with its peak memory.
/// At last samples that keep a core busy for 10 us to 1 s are assigned in batches, as in a run, and one by one.
///
/// The command needs about 3 kB of temporary disk per sample. Results depend on the load of the computer, which is shown
/// before and after.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Samples
    #[arg(long, value_name = "N", default_value_t = 200_000, value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    samples: u64,

    /// Worker processes
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u16).range(1..=256))]
    workers: u16,

    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Longest sample of the idle measurement.
const IDLE: Duration = Duration::from_secs(4);

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let folder = Folder::new()?;
    let load_before = load();
    remark("idle: two workers with three samples of four seconds ...");
    let idle = measure_idle(&folder.0)?;
    remark(&format!("{} samples that compute nothing, recorded durably ...", args.samples));
    let durable = measure_durable(&folder.0, args)?;
    remark("python3's ProcessPoolExecutor ...");
    let python = |samples: u64, chunk| python(samples.clamp(1, 200_000), args.workers, chunk);
    let (python_1, python_chunks) = (python(args.samples / 10, 1), python(args.samples, 256));
    let stages = Stages::new(&folder.0, args.samples)?;
    let stage = |what: &str, doing: &str| {
        remark(&format!("{} recorded results: {doing} ...", stages.samples()));
        stages.measure(what)
    };
    stage("fill", "made")?;
    let resume = stage("resume", "taken up")?;
    let parts = stage("parts", "written as parts")?;
    let tables = stage("tables", "written as tables")?;
    let summary = stage("summary", "summed up")?;
    let growth = stage("growth", "taken over into a study of twice the size")?;
    remark("samples of 10 us to 1 s, in batches and one by one ...");
    let lengths = lengths::measure(&folder.0, args.workers)?;
    let rows = [
        ("overhead per durable sample", Some(durable.micros), "us", "below 20"),
        ("python3, chunksize 1 (not durable)", python_1, "us", ""),
        ("python3, chunksize 256 (not durable)", python_chunks, "us", ""),
        ("CPU of the orchestrator while workers compute", Some(100.0 * idle.orchestrator), "%", "below 1"),
        ("CPU of a worker without work", idle.worker.map(|share| 100.0 * share), "%", "below 1"),
        ("start to the first request of a worker", Some(1e3 * durable.start_s), "ms", ""),
        ("resume: from the lock to the first missing sample", Some(resume.seconds), "s", ""),
        ("parts of all rows, as a resume writes them beside its work", Some(parts.seconds), "s", ""),
        ("tables from the record", Some(tables.seconds), "s", ""),
        ("summary from the table", Some(summary.seconds), "s", ""),
        ("record taken over into a study of twice the size", Some(growth.seconds), "s", ""),
        ("peak memory of the orchestrator: dispatch and record", durable.peak_mb, "MB", "below 300"),
        ("peak memory: resume", resume.peak_mb, "MB", "below 300"),
        ("peak memory: parts", parts.peak_mb, "MB", "below 300"),
        ("peak memory: tables", tables.peak_mb, "MB", "below 300"),
        ("peak memory: summary", summary.peak_mb, "MB", "below 300"),
        ("peak memory: taking over", growth.peak_mb, "MB", "below 300"),
    ];
    let load_after = load();
    if args.json {
        let figures = figures::json(&rows);
        let (samples, workers) = (args.samples, args.workers);
        let text =
            json!({ "samples": samples, "workers": workers, "load_before": load_before, "load_after": load_after, "figures": figures,
                "lengths": lengths::json(&lengths) })
                .to_string();
        print(&format!("{text}\n"))?;
        return Ok(Exit::Ok);
    }
    let text = figures::text(&rows);
    let (samples, workers) = (args.samples, args.workers);
    print(&format!(
        "{samples} samples, {workers} workers, load before and after: {load_before}, {load_after}\n\n{text}\n{}",
        lengths::text(&lengths)
    ))?;
    Ok(Exit::Ok)
}

/// Result for samples with four parameters, as in a study with four axes.
struct Durable {
    micros: f64,
    start_s: f64,
    peak_mb: Option<f64>,
}

fn measure_durable(folder: &Path, args: &Args) -> Result<Durable, CliError> {
    let options = options(folder, args.workers.into(), Duration::ZERO)?;
    let mut sink = RecordSink(Record::create(folder.join("ledger.redb"), &[])?);
    let todo = order::shuffled(Todo::from(args.samples));
    let report = dispatch::run(&options, &Numbers, todo, &mut sink, &mut Nobody).map_err(RunError::from)?;
    Ok(Durable {
        micros: 1e6 * (report.wall_s - report.first_ask_s) / report.done.max(1) as f64,
        start_s: report.first_ask_s,
        peak_mb: peak_mb(),
    })
}

struct Idle {
    orchestrator: f64,
    worker: Option<f64>,
}

/// CPU time of waiting processes: when they begin to wait, and at the last moment.
#[derive(Default)]
struct Watch {
    own: Option<(Duration, f64)>,
    idle: BTreeMap<u32, [(Duration, f64); 2]>,
    last: Option<(Duration, f64)>,
}

impl Observer for Watch {
    fn progress(&mut self, snapshot: &Snapshot) {
        let now = snapshot.elapsed;
        let is_steady = snapshot.workers.iter().any(|worker| matches!(worker.activity, Activity::Busy { .. }));
        if is_steady {
            let own = (now, cpu_seconds(std::process::id()));
            self.own.get_or_insert(own);
            self.last = Some(own);
        }
        for worker in snapshot.workers.iter().filter(|worker| worker.activity == Activity::Idle) {
            let Some(pid) = worker.pid else { continue };
            let point = (now, cpu_seconds(pid));
            self.idle.entry(pid).or_insert([point, point])[1] = point;
        }
    }
}

fn measure_idle(folder: &Path) -> Result<Idle, CliError> {
    let options = options(folder, 2, IDLE)?;
    let mut watch = Watch::default();
    let mut sink = RecordSink(Record::create(folder.join("idle.redb"), &[])?);
    dispatch::run(&options, &Numbers, 3, &mut sink, &mut watch).map_err(RunError::from)?;
    let share = |(from, before): (Duration, f64), (to, after): (Duration, f64)| {
        (after - before) / (to.saturating_sub(from)).as_secs_f64().max(1e-3)
    };
    let orchestrator = watch.own.zip(watch.last).map_or(f64::NAN, |(first, last)| share(first, last));
    let longest = watch.idle.into_values().max_by_key(|[first, last]| last.0.saturating_sub(first.0));
    let worker = longest.filter(|[first, last]| last.0.saturating_sub(first.0) > IDLE / 2);
    Ok(Idle { orchestrator, worker: worker.map(|[first, last]| share(first, last)) })
}

/// CPU time used by all threads of a process \[s\], with a resolution of 1 ns.
fn cpu_seconds(pid: u32) -> f64 {
    let tasks = fs::read_dir(format!("/proc/{pid}/task")).into_iter().flatten().flatten();
    let nanoseconds = |path: PathBuf| {
        let text = fs::read_to_string(path.join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    };
    tasks.filter_map(|task| nanoseconds(task.path())).sum::<f64>() * 1e-9
}

/// Microseconds per task of `concurrent.futures.ProcessPoolExecutor`; `None` without python3.
fn python(samples: u64, workers: u16, chunk: u64) -> Option<f64> {
    let script = format!(
        "import concurrent.futures as c, time\n\
         def task(p):\n    return [p[0] + i for i in range(40)]\n\
         if __name__ == '__main__':\n    \
             with c.ProcessPoolExecutor({workers}) as pool:\n        \
                 list(pool.map(task, [(0.0, 0.25, -1.5, 3.0)] * {workers}))\n        \
                 t = time.perf_counter()\n        \
                 n = sum(1 for _ in pool.map(task, ((float(i), 0.25, -1.5, 3.0) for i in range({samples})), chunksize={chunk}))\n        \
                 print((time.perf_counter() - t) / n * 1e6)\n"
    );
    let output =
        Command::new("python3").args(["-c", &script]).output().ok().filter(|output| output.status.success())?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}
