//! Combinations of a map in the table: `[refine]` computes some combinations of a study, and more where the map changes.
//!
//! Samples keep their numbers in the whole study, so record, keys and plan are those of the study without `[refine]` and adding
//! combinations renumbers nothing. The table's metadata list the combinations for every reader of the rows.

use super::end::PrecisionError;
use bladeoff_answers::tables::{TableError, read_metadata};
use bladeoff_study::Samples;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::Path;

/// Metadata key, without the common prefix.
pub(super) const REFINED: &str = "refined";

/// Chosen combinations of positions on two axes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chosen {
    /// Axes, by their places in the study.
    pub axes: [usize; 2],
    /// Chosen positions on both axes, numbered as in the study file.
    pub cells: BTreeSet<[u64; 2]>,
}

impl Chosen {
    /// Whether a sample belongs to a chosen combination.
    #[must_use]
    pub fn contains(&self, samples: &Samples, sample: u64) -> bool {
        let positions = samples.positions(sample);
        self.cells.contains(&self.axes.map(|axis| positions[axis]))
    }

    /// Whether all combinations of these samples are chosen.
    #[must_use]
    pub fn is_all(&self, samples: &Samples) -> bool {
        let kept = samples.kept();
        self.cells.len() as u64 == kept[self.axes[0]] * kept[self.axes[1]]
    }

    /// Samples of the chosen combinations, in ascending order.
    pub fn samples<'a>(&'a self, samples: &'a Samples) -> impl Iterator<Item = u64> + 'a {
        (0..samples.count()).filter(|sample| self.contains(samples, *sample))
    }

    /// Value for the metadata.
    #[must_use]
    pub fn json(&self) -> Value {
        json!({ "axes": self.axes, "cells": self.cells })
    }

    /// Reads the metadata value for a study with so many axes; `None`: invalid.
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

/// Reads the combinations of a table; `None`: it has all.
///
/// # Errors
/// The table cannot be read.
pub fn chosen_of_table(table: &Path, samples: &Samples) -> Result<Option<Chosen>, TableError> {
    let key = format!("bladeoff.{REFINED}");
    let found = read_metadata(table)?.into_iter().find(|(name, _)| *name == key);
    let chosen = found.and_then(|(_, text)| Chosen::of_json(&serde_json::from_str(&text).ok()?));
    Ok(chosen.filter(|chosen| chosen.axes.iter().all(|axis| *axis < samples.study().axes.len())))
}

/// Choice of the next combinations by the map; the run does not know maps.
pub trait Refining: std::fmt::Debug {
    /// First combinations.
    fn first(&self) -> Chosen;

    /// Next combinations, by the rows of all chosen ones in this table, and whether further ones may follow.
    ///
    /// # Errors
    /// The table cannot be read, or lacks the quantity of the map.
    fn next(&self, chosen: &Chosen, table: &Path) -> Result<(Vec<[u64; 2]>, bool), PrecisionError>;
}
