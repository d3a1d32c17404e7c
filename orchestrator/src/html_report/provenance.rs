//! Provenance of the results, and limits of the model.

use super::Subject;
use crate::run::directory::{MACHINE, MANIFEST, RESULTS};
use crate::run::shards::row_files;
use crate::run::{STOP, TableEnd};
use bladeoff_answers::page::{Block, Table};
use bladeoff_answers::tables::read_metadata;
use bladeoff_study::Samples;
use bladeoff_system::call;
use bladeoff_system::place::Place;
use serde_json::Value;

/// Largest manifest and machine file that is shown \[bytes\].
const MOST: u64 = 1 << 20;

/// Limits of the model, as in the README.
pub const LIMITS: [&str; 5] = [
    "Bearings are linear about their static point, with constant coefficients or a table over the speed; there is no \
     oil film. Shaft and rings are linear. A displacement beyond a few per cent of the ring's radius, or a stress \
     beyond yield, shows that the value is too large, not how large it would be.",
    "Diaphragms that touch are planar (no axial or tilting motion of the ring) and coupled by the shaft alone, with a rigid rotor section. Friction is dry with one coefficient; heat, wear and breaking blades are not modelled.",
    "The lost blade leaves at once; its impact on neighbours and casing is not covered.",
    "Heavy rubs are sensitive: valid discretisations differ by some tenths of a per cent over many impacts, single \
     runs by more. `run.twin` measures this sensitivity for a run.",
    "Intervals cover the number of points only. They do not cover a wrong distribution or a missing correlation.",
];

/// Table of study, hashes, versions and times.
pub(super) fn provenance(subject: Subject<'_>) -> Vec<Block> {
    let Subject { directory, samples, .. } = subject;
    let text = |name: &str| Place::from(&directory.join(name)).read(MOST).ok();
    let manifest: Value = text(MANIFEST).and_then(|text| serde_json::from_slice(&text).ok()).unwrap_or_default();
    let mut rows: Vec<Vec<String>> = Vec::new();
    let mut put = |name: &str, value: String| {
        if !value.is_empty() {
            rows.push(vec![name.to_owned(), value]);
        }
    };
    let word = |value: &Value| match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    put("program", {
        let program = &manifest["program"];
        let parts = [&program["name"], &program["version"], &program["commit"], &program["build"]["target"]].map(word);
        parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
    });
    if let Some(words) = manifest["command"].as_array() {
        let words: Vec<String> = words.iter().filter_map(Value::as_str).map(call::word).collect();
        put("command", words.join(" "));
    }
    for (name, key) in [
        ("begun", "started"),
        ("ended", "finished"),
        ("state", "state"),
        ("workers", "workers"),
        ("deaths of workers", "worker_deaths"),
    ] {
        put(name, word(&manifest[key]));
    }
    put("processor", word(&manifest["host"]["cpu"]));
    let study = samples.study();
    if let Some(Ok(machine)) = study.machine().map(|machine| machine.def.build()) {
        put("engine", machine.run.engine.word().to_owned());
    }
    let metadata = row_files(directory).first().and_then(|file| read_metadata(file).ok()).unwrap_or_default();
    for (key, value) in &metadata {
        if let Some(name) = key.strip_prefix("bladeoff.").filter(|name| *name != "schema_version") {
            match serde_json::from_str(value).ok().and_then(|value| TableEnd::of_json(&value)).filter(|_| name == STOP)
            {
                Some(end) => put("end of the table", end.words(samples)),
                // in a table that [stop] ended early, `samples` could be read as its number of rows
                None if name == "samples" && metadata.iter().any(|(key, _)| key.ends_with(STOP)) => {
                    put("samples of the whole study", value.clone());
                }
                None => put(&name.replace("_blake3", " (BLAKE3)").replace('_', " "), value.clone()),
            }
        }
    }
    put("table (BLAKE3)", word(&manifest["tables"][RESULTS]["blake3"]));
    let table = Table { head: vec!["what".to_owned(), String::new()], rows, verbatim: Vec::new() };
    let mut blocks = vec![Block::Table(table)];
    blocks.push(Block::Details("The study as it was run".to_owned(), vec![Block::Verbatim(study.text.clone())]));
    if let Some(text) = text(MACHINE) {
        let text = String::from_utf8_lossy(&text).into_owned();
        blocks.push(Block::Details("Its machine".to_owned(), vec![Block::Verbatim(text)]));
    }
    blocks
}

/// Effects that the model does not cover.
pub(super) fn limits(samples: &Samples) -> Vec<Block> {
    let [.., intervals] = LIMITS;
    let (function, layout) = (samples.study().function().is_some(), samples.layout().is_some());
    let mut lines: Vec<String> = Vec::new();
    if function {
        lines.push("Formulas were evaluated, no machine was simulated.".to_owned());
    } else {
        lines.extend(LIMITS[..LIMITS.len() - 1].iter().map(|limit| (*limit).to_owned()));
    }
    if layout {
        lines.push(intervals.to_owned());
    }
    vec![Block::List(lines)]
}
