//! `manifest.json`: facts about a run that may differ between equal runs.

use super::directory::{RESULTS, TIMINGS};
use super::end::TableEnd;
use super::request::Request;
use super::stamp::{host, timestamp};
use bladeoff_answers::tables::Checksum;
use bladeoff_core::engine::exponential::EXPONENTIAL_REVISION;
use bladeoff_study::Samples;
use bladeoff_system::place::Place;
use blake3::Hash;
use serde_json::{Map, Value, json};
use std::time::SystemTime;

/// Largest manifest that is read \[bytes\].
const MOST_MANIFEST: u64 = 16 << 20;

/// Course of a run for the manifest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Course {
    pub state: &'static str,
    /// Reason of the end; `None`: in progress.
    pub ended: Option<&'static str>,
    /// End of the table, if `[stop]` determines it.
    pub end: Option<TableEnd>,
    pub started: SystemTime,
    pub finished: Option<SystemTime>,
    pub done: u64,
    /// Samples of earlier runs.
    pub reused: u64,
    pub worker_deaths: u64,
    pub dropped_messages: u64,
    /// Checksums of the tables; empty before these are written.
    pub tables: Checksums,
}

impl Course {
    /// Course of a run that begins now with so many finished samples.
    pub fn begun(reused: u64) -> Self {
        Self {
            state: "running",
            ended: None,
            end: None,
            started: SystemTime::now(),
            finished: None,
            done: reused,
            reused,
            worker_deaths: 0,
            dropped_messages: 0,
            tables: Checksums::default(),
        }
    }
}

/// Checksums of the tables of a directory.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Checksums {
    pub results: Option<Checksum>,
    pub timings: Option<Checksum>,
}

impl Checksums {
    /// Reads the checksums of a manifest; empty for a missing or damaged one.
    pub fn recorded(manifest: &Place) -> Self {
        let recorded = read(manifest);
        let checksum = |name: &str| {
            let said = &recorded.as_ref()?[KEY][name];
            Some(Checksum { hash: Hash::from_hex(said["blake3"].as_str()?).ok()?, bytes: said["bytes"].as_u64()? })
        };
        Self { results: checksum(RESULTS), timings: checksum(TIMINGS) }
    }

    fn json(self) -> Value {
        let entries = [(RESULTS, self.results), (TIMINGS, self.timings)];
        let entry = |(name, checksum): (&str, Option<Checksum>)| {
            let Checksum { hash, bytes } = checksum?;
            Some((name.to_owned(), json!({ "blake3": hash.to_hex().as_str(), "bytes": bytes })))
        };
        Value::Object(entries.into_iter().filter_map(entry).collect())
    }
}

/// Reads the provenance of a manifest, which contains the hashes of the inputs.
pub(super) fn provenance(path: &Place) -> Option<Value> {
    read(path).map(|mut recorded| recorded["provenance"].take())
}

/// Values of a manifest that the metadata of the table has too: the provenance, and what is given beside it.
pub(super) fn values(path: &Place) -> Vec<(String, String)> {
    let Some(recorded) = read(path) else { return Vec::new() };
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let beside = TWICE.into_iter().filter_map(|key| Some((key.to_owned(), text(recorded.get(key)?))));
    let provenance = recorded["provenance"].as_object().into_iter().flatten();
    let mut values: Vec<(String, String)> = provenance.map(|(key, value)| (key.clone(), text(value))).collect();
    values.extend(beside);
    values.sort();
    values.dedup();
    values
}

/// Keys of the manifest that its provenance repeats.
const TWICE: [&str; 2] = ["samples", "study"];

/// Key of the checksums.
const KEY: &str = "tables";

/// Reads a manifest; `None` if the file is not a JSON object.
fn read(path: &Place) -> Option<Value> {
    serde_json::from_slice(&path.read(MOST_MANIFEST).ok()?).ok().filter(Value::is_object)
}

/// Whether the manifest of a directory exists and describes a complete study.
pub(super) fn tells_complete(path: &Place) -> bool {
    read(path).is_some_and(|recorded| recorded["state"] == "complete")
}

/// Replaces checksums and inputs of an existing manifest; `None`: they are equal, or the manifest is invalid.
pub(super) fn mended(path: &Place, tables: Checksums, provenance: &[(String, String)]) -> Option<String> {
    let recorded = read(path)?;
    let mut manifest = recorded.clone();
    manifest[KEY] = tables.json();
    manifest["provenance"] = inputs(provenance);
    for (key, value) in provenance.iter().filter(|(key, _)| TWICE.contains(&key.as_str())) {
        manifest[key] =
            value.parse::<u64>().ok().filter(|_| key == "samples").map_or_else(|| json!(value), Value::from);
    }
    (manifest != recorded).then(|| as_text(&manifest))
}

/// Creates a manifest of the tables alone.
pub(super) fn of_tables(tables: Checksums) -> String {
    as_text(&json!({ "state": "complete", KEY: tables.json() }))
}

/// Creates the text of a manifest.
pub(super) fn manifest(
    request: &Request,
    samples: &Samples,
    provenance: &[(String, String)],
    course: &Course,
) -> String {
    let study = samples.study();
    let value = json!({
        "program": {
            "name": env!("CARGO_PKG_NAME"),
            "version": env!("CARGO_PKG_VERSION"),
            "commit": crate::version::COMMIT,
            "numerics_version": bladeoff_core::NUMERICS_VERSION,
            "exponential_revision": EXPONENTIAL_REVISION,
            "build": build(),
        },
        "command": std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>(),
        "study": study.name,
        "study_file": study.file,
        "machine_file": study.machine().map(|machine| &machine.file),
        "samples": samples.count(),
        "scale": samples.scale(),
        "limit": samples.limit(),
        "workers": request.workers,
        "state": course.state,
        "ended": course.ended,
        "stop": course.end.map(|end| end.json()),
        "done": course.done,
        "reused": course.reused,
        "worker_deaths": course.worker_deaths,
        "dropped_messages": course.dropped_messages,
        "started": timestamp(course.started),
        "finished": course.finished.map(timestamp),
        "host": { "name": host(), "cores": std::thread::available_parallelism().map(|n| n.get()).ok(), "cpu": cpu() },
        "provenance": inputs(provenance),
        KEY: course.tables.json(),
    });
    as_text(&value)
}

fn inputs(provenance: &[(String, String)]) -> Value {
    let pairs = provenance.iter().map(|(key, value)| (key.clone(), Value::String(value.clone())));
    Value::Object(pairs.collect::<Map<String, Value>>())
}

fn as_text(value: &Value) -> String {
    let mut text = serde_json::to_string_pretty(value).expect("strings and numbers always have a JSON form");
    text.push('\n');
    text
}

fn build() -> Value {
    json!({
        "target": format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS),
        "optimised": !cfg!(debug_assertions),
    })
}

fn cpu() -> Option<String> {
    let info = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = info.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
