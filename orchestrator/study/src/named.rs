//! Files that a study names: relative to the study file, or the copies in a result directory.

use super::frozen::FrozenFiles;
use super::input::{InputError, beside, read_frozen, read_input};
use bladeoff_text::document::{Collector, Entry, cut};
use std::path::Path;

/// File of a study.
#[derive(Debug, Clone, Copy)]
pub(super) enum Which {
    /// The machine.
    Machine,
    /// The points.
    Points,
    /// File of an empirical distribution, by its index.
    Empirical(usize),
}

/// Locations of the files of a study.
#[derive(Debug)]
pub(super) struct NamedFiles<'a> {
    /// The study file.
    pub study: &'a Path,
    /// The copies in a result directory, used whatever names the study has for them; `None`: files relative to the study.
    pub frozen: Option<FrozenFiles>,
}

impl NamedFiles<'_> {
    /// Path and text of a file with at most `limit` bytes, named by an entry with this key and name. `None`: problems were added.
    pub fn read(
        &self,
        entry: &Entry,
        (key, named): (&str, &str),
        (which, limit): (Which, u64),
        problems: &mut Collector<'_>,
    ) -> Option<(String, String)> {
        let read = || -> Result<_, InputError> {
            let found = match (&self.frozen, which) {
                (None, _) => beside(self.study, named)?,
                (Some(files), Which::Machine) => files.machine(),
                (Some(files), Which::Points) => files.points(),
                (Some(files), Which::Empirical(number)) => files.empirical(number),
            };
            let text = if self.frozen.is_some() { read_frozen } else { read_input }(&found, limit)?;
            Ok((found.to_string_lossy().into_owned(), text))
        };
        match read() {
            Ok(found) => Some(found),
            Err(error) => {
                let message = match std::error::Error::source(&error) {
                    Some(source) => format!("{error}: {source}"),
                    None => error.to_string(),
                };
                problems.add(entry.node.span.clone(), key, message).value = Some(format!("{:?}", cut(named, 120)));
                None
            }
        }
    }
}
