//! Provenance of a table, in the table itself and in the record. Equal runs have equal values.

use bladeoff_answers::tables::{SCHEMA_VERSION, TableError, read_metadata};
use bladeoff_core::engine::exponential::EXPONENTIAL_REVISION;
use bladeoff_model::machine::{ENGINE, Engine};
use bladeoff_record::RECORD_VERSION;
use bladeoff_study::{Samples, Subject};
use std::path::Path;

/// Metadata key for a study without a machine.
const MODEL: &str = "model";
/// Its value for formulas.
const FUNCTION: &str = "function";

/// Whether a table file belongs to a study of formulas.
///
/// # Errors
/// The table cannot be read.
pub fn is_of_formulas(table: &Path) -> Result<bool, TableError> {
    let key = format!("bladeoff.{MODEL}");
    Ok(read_metadata(table)?.iter().any(|(name, value)| *name == key && value == FUNCTION))
}

/// Key of the revision of the exponential engine, in studies that it computes.
pub(super) const EXPONENTIAL: &str = "exponential_revision";

/// Whether the exponential engine computes samples of this study.
fn is_exponential(samples: &Samples) -> bool {
    let study = samples.study();
    study.engine().is_some_and(|choice| choice.engine == Engine::Exponential)
        || study.parameters().iter().any(|varied| varied.info.path == ENGINE)
}

/// Lists key-value pairs in fixed order.
pub(super) fn provenance(samples: &Samples, plan_hash: &str, basis: Option<&[u8]>) -> Vec<(String, String)> {
    let study = samples.study();
    let hash = |text: &str| blake3::hash(text.as_bytes()).to_hex().to_string();
    let mut pairs = vec![
        ("program", format!("bladeoff {}", env!("CARGO_PKG_VERSION"))),
        ("numerics_version", bladeoff_core::NUMERICS_VERSION.to_string()),
        ("table_schema", SCHEMA_VERSION.to_string()),
        ("ledger_version", RECORD_VERSION.to_string()),
        ("study", study.name.clone()),
        ("study_blake3", hash(&study.text)),
    ];
    match &study.subject {
        Subject::Machine(machine) => {
            if is_exponential(samples) {
                pairs.push((EXPONENTIAL, EXPONENTIAL_REVISION.to_string()));
            }
            pairs.push(("machine", machine.file.clone()));
            pairs.push(("machine_blake3", hash(&machine.text)));
        }
        Subject::Function(_) => pairs.push((MODEL, FUNCTION.to_owned())),
    }
    pairs.push(("plan_blake3", plan_hash.to_owned()));
    pairs.push(("seed", study.seed.to_string()));
    pairs.push(("samples", samples.count().to_string()));
    if let Some(basis) = basis {
        pairs.push(("basis_blake3", blake3::hash(basis).to_hex().to_string()));
    }
    if let Some(points) = &study.points_text {
        pairs.push(("points_blake3", hash(points)));
    }
    if let Some(scale) = samples.scale() {
        pairs.push(("scale", format!("{scale:?}")));
    }
    if let Some(limit) = samples.limit() {
        pairs.push(("limit", limit.to_string()));
    }
    let mut pairs: Vec<(String, String)> = pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
    pairs.extend(study.empirical_texts.iter().enumerate().map(|(file, text)| (empirical_key(file), hash(text))));
    pairs
}

/// Key of the hash of the n-th empirical law's file, from 0.
pub(super) fn empirical_key(file: usize) -> String {
    format!("empirical_{}_blake3", file + 1)
}
