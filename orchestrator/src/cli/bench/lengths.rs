//! Benefit of batches: samples of several durations, dispatched in batches as a run does and one by one, for comparison.

use super::super::error::CliError;
use super::stand_in::{Nobody, Numbers, RecordSink, options};
use crate::dispatch;
use crate::run::{RunError, order};
use crate::schedule::Todo;
use bladeoff_answers::summary::{Align, TextTable};
use bladeoff_record::Record;
use bladeoff_worker::process::process_cpu_time;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Duration;

/// Time for which each sample keeps a core busy.
const LENGTHS: [Duration; 4] =
    [Duration::from_micros(10), Duration::from_millis(1), Duration::from_millis(10), Duration::from_secs(1)];
/// Busy time of each worker, where this gives at least two samples for each worker and not more than [`MOST`] samples.
const SPAN: Duration = Duration::from_secs(1);
const MOST: u64 = 50_000;

/// Measurement of samples of one duration, dispatched in one way.
pub(super) struct Length {
    busy: Duration,
    is_batched: bool,
    samples: u64,
    /// Time of the workers outside samples, divided by their time in samples.
    beside: f64,
    /// CPU time of the orchestrator for each durably recorded sample \[s\].
    cpu_s: f64,
}

/// Measurements of all durations, each in batches and one by one.
pub(super) fn measure(folder: &Path, workers: u16) -> Result<Vec<Length>, CliError> {
    let ways = LENGTHS.into_iter().flat_map(|busy| [(busy, true), (busy, false)]);
    ways.enumerate()
        .map(|(n, way)| measure_one(&folder.join(format!("length-{n}.redb")), folder, workers, way))
        .collect()
}

fn measure_one(record: &Path, folder: &Path, workers: u16, way: (Duration, bool)) -> Result<Length, CliError> {
    let (busy, is_batched) = way;
    let each = u64::try_from(SPAN.as_nanos() / busy.as_nanos()).unwrap_or(MOST).max(2);
    let samples = (each * u64::from(workers)).min(MOST);
    let mut options = options(folder, workers.into(), busy)?;
    if !is_batched {
        options.schedule.max_batch = 1;
    }
    let mut sink = RecordSink(Record::create(record, &[])?);
    let begun = process_cpu_time();
    let todo = order::shuffled(Todo::from(samples));
    let report = dispatch::run(&options, &Numbers, todo, &mut sink, &mut Nobody).map_err(RunError::from)?;
    let cpu_s = (process_cpu_time() - begun).as_secs_f64() / report.done.max(1) as f64;
    let computing = busy.as_secs_f64() * report.done.max(1) as f64;
    let beside = (report.wall_s - report.first_ask_s) * f64::from(workers) / computing - 1.0;
    Ok(Length { busy, is_batched, samples, beside, cpu_s })
}

/// Table of the measurements in words.
pub(super) fn text(lengths: &[Length]) -> String {
    let mut table = TextTable::new(&[
        ("a sample takes", Align::Right),
        ("handed out", Align::Left),
        ("samples", Align::Right),
        ("workers' time beside them", Align::Right),
        ("CPU of the orchestrator a sample", Align::Right),
    ]);
    for length in lengths {
        table.row(vec![
            format!("{:?}", length.busy),
            if length.is_batched { "in batches" } else { "one by one" }.to_owned(),
            length.samples.to_string(),
            format!("{:.2} %", 100.0 * length.beside),
            format!("{:.1} us", 1e6 * length.cpu_s),
        ]);
    }
    table.render("")
}

/// The measurements as JSON.
pub(super) fn json(lengths: &[Length]) -> Value {
    let one = |length: &Length| {
        json!({
            "sample_s": length.busy.as_secs_f64(), "batches": length.is_batched, "samples": length.samples,
            "beside": length.beside, "orchestrator_cpu_s_per_sample": length.cpu_s,
        })
    };
    lengths.iter().map(one).collect()
}
