//! Provenance of two tables, compared.

use super::found::Differs;
use crate::tables::{TableError, read_metadata};
use std::collections::BTreeMap;
use std::path::Path;

/// Prefix of the metadata that this program writes into a table.
const PREFIX: &str = "bladeoff.";

/// Metadata entries that differ.
pub(super) fn differing(a: &Path, b: &Path) -> Result<Vec<Differs>, TableError> {
    let told = |path: &Path| -> Result<BTreeMap<String, String>, TableError> {
        let own = |(key, value): (String, String)| Some((key.strip_prefix(PREFIX)?.to_owned(), value));
        Ok(read_metadata(path)?.into_iter().filter_map(own).collect())
    };
    let (a, b) = (told(a)?, told(b)?);
    let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
    let apart = keys.filter(|key| a.get(*key) != b.get(*key));
    Ok(apart.map(|key| Differs { what: key.clone(), a: a.get(key).cloned(), b: b.get(key).cloned() }).collect())
}
