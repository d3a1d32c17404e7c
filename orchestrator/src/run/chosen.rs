//! The combinations of a map that a table has: `[refine]` takes some of those that a study has, and more where the map changes.
//!
//! Samples keep their numbers in the whole study, so record, keys and plan are those of the study without `[refine]`, and nothing is
//! numbered anew when combinations are added. Which they are stands in the table's own metadata, for whoever reads the rows.

use super::end::LookingError;
use bladeoff_answers::tables::{TableError, read_metadata};
use bladeoff_study::Samples;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::Path;

/// Key of the metadata, without the prefix of all.
pub(super) const REFINED: &str = "refined";

/// Combinations of the positions on two axes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chosen {
    /// The axes, by their places in the study.
    pub axes: [usize; 2],
    /// Positions on both, in the numbering of the study file.
    pub cells: BTreeSet<[u64; 2]>,
}

impl Chosen {
    /// Whether a sample is in a chosen combination.
    #[must_use]
    pub fn has(&self, samples: &Samples, sample: u64) -> bool {
        let positions = samples.positions(sample);
        self.cells.contains(&self.axes.map(|axis| positions[axis]))
    }

    /// Whether every combination of these samples is chosen.
    #[must_use]
    pub fn is_all(&self, samples: &Samples) -> bool {
        let kept = samples.kept();
        self.cells.len() as u64 == kept[self.axes[0]] * kept[self.axes[1]]
    }

    /// All samples in chosen combinations, in ascending order.
    pub fn samples<'a>(&'a self, samples: &'a Samples) -> impl Iterator<Item = u64> + 'a {
        (0..samples.count()).filter(|sample| self.has(samples, *sample))
    }

    /// As it stands in metadata.
    #[must_use]
    pub fn json(&self) -> Value {
        json!({ "axes": self.axes, "cells": self.cells })
    }

    /// From its JSON, for a study with so many axes; `None`: it is none.
    fn of_json(said: &Value) -> Option<Self> {
        let pair = |value: &Value| {
            let [first, second] = value.as_array()?.as_slice() else { return None };
            Some([first.as_u64()?, second.as_u64()?])
        };
        let axes = pair(&said["axes"])?.map(|axis| axis as usize);
        let cells = said["cells"].as_array()?.iter().map(pair).collect::<Option<_>>()?;
        Some(Self { axes, cells })
    }
}

/// The combinations that a table has of these samples; `None` of one that has all.
///
/// # Errors
/// The table cannot be read.
pub fn chosen_of_table(table: &Path, samples: &Samples) -> Result<Option<Chosen>, TableError> {
    let key = format!("bladeoff.{REFINED}");
    let found = read_metadata(table)?.into_iter().find(|(name, _)| *name == key);
    let chosen = found.and_then(|(_, text)| Chosen::of_json(&serde_json::from_str(&text).ok()?));
    Ok(chosen.filter(|chosen| chosen.axes.iter().all(|axis| *axis < samples.study().axes.len())))
}

/// Who says which combinations come next: by the map, which a run knows nothing of.
pub trait Refining: std::fmt::Debug {
    /// Those that come first.
    fn first(&self) -> Chosen;

    /// Those that come next, by the rows of all that are chosen so far, in this table; and whether others may come after them.
    ///
    /// # Errors
    /// The table cannot be read, or does not hold what the map is of.
    fn next(&self, chosen: &Chosen, table: &Path) -> Result<(Vec<[u64; 2]>, bool), LookingError>;
}
