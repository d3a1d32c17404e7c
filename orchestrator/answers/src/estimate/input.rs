//! Input of an estimate: the columns of a study in sample order, and the design of its points.
//!
//! The design is the slowest axis: row = point x groups + group, where a group is one combination of values of the crossed axes.

use super::bad::Bad;
use crate::sensitivity::{Moved, SensitivityError};
use bladeoff_model::outcome::{CauseSet, Status};
use serde::ser::{Serialize, SerializeMap, Serializer};
use std::fmt;

/// Bound that a bad run gives for the true value in a column of numbers.
#[derive(Debug, Clone, Copy)]
pub enum Nature<'a> {
    /// The value itself: an input of the run (parameter, variable, carried-along column). An empty cell could not be derived.
    Given,
    /// Time of a first event. The cells hold the time of events that happened while all guards and limits held; otherwise no bound.
    Once(Option<&'a [Option<f64>]>),
    /// A column that only grows during a run (peaks, impulses, energies). The cells hold the value reached while all guards held, a lower
    /// bound; `None` if nothing was reached. Without cells there is no bound.
    Grows(Option<&'a [Option<f64>]>),
    /// Time of the first exceeded limit of the model: the value itself in a beyond row, otherwise as [`Nature::Once`].
    Limit(Option<&'a [Option<f64>]>),
    /// No bound.
    Free,
}

impl<'a> Nature<'a> {
    /// The cells with values reached while all guards and limits held.
    #[must_use]
    pub fn held(self) -> Option<&'a [Option<f64>]> {
        match self {
            Self::Once(held) | Self::Limit(held) | Self::Grows(held) => held,
            Self::Given | Self::Free => None,
        }
    }

    /// Replaces the cells of [`Nature::held`], for a subset of the rows.
    #[must_use]
    pub fn with(self, held: impl Fn(&'a [Option<f64>]) -> &'a [Option<f64>]) -> Self {
        match self {
            Self::Once(cells) => Self::Once(cells.map(held)),
            Self::Limit(cells) => Self::Limit(cells.map(held)),
            Self::Grows(cells) => Self::Grows(cells.map(held)),
            Self::Given | Self::Free => self,
        }
    }
}

/// Reason why a run ended, as far as it matters for what the row leaves open.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Ended {
    /// Limit of the model.
    Limit,
    /// End of the simulated time \[s\]: later events are unknown.
    Time(f64),
    /// Any other reason.
    #[default]
    Other,
}

/// Cells of a column.
#[derive(Debug, Clone, Copy)]
pub enum Cells<'a> {
    /// Numbers; `None` if the event or quantity did not occur.
    Numbers(&'a [Option<f64>], Nature<'a>),
    /// Words, and the possible words in their order.
    Words(&'a [Option<String>], &'a [String]),
}

impl Cells<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Numbers(values, _) => values.len(),
            Self::Words(words, _) => words.len(),
        }
    }
}

/// A column of a study.
#[derive(Debug, Clone)]
pub struct Column<'a> {
    /// Column name.
    pub name: String,
    /// SI unit, "" for a pure number.
    pub unit: String,
    /// Column content.
    pub cells: Cells<'a>,
    /// Whether an empty cell of an ok row leaves a condition open, because the run has no such quantity.
    pub unjudged: bool,
}

/// Name of a column or channel as a person reads it: `bearing.front.load_N` -> "bearing front load".
#[must_use]
pub fn plain_name(channel: &str, unit: &str) -> String {
    let suffix = format!("_{}", unit.replace(' ', "").replace('/', "_"));
    let words = channel.strip_suffix(&suffix).unwrap_or(channel).replace(['.', '_'], " ");
    // the term of the field for the quantity of `max_filtered_contact_force_N` and `contact.filtered_force_N`
    words.replace("filtered contact force", "contact force, 1 ms mean").replace("filtered force", "force, 1 ms mean")
}

/// A value of a varied parameter.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Label {
    /// Number in SI units.
    Number(f64),
    /// A word.
    Word(String),
}

impl fmt::Display for Label {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(out, "{number}"),
            Self::Word(word) => out.write_str(word),
        }
    }
}

/// One combination of values of the crossed axes: path and value in the order of the axes; empty if nothing is varied.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Group(pub Vec<(String, Label)>);

impl Group {
    /// Value of the group on an axis.
    #[must_use]
    pub fn label(&self, path: &str) -> Option<&Label> {
        self.0.iter().find(|(axis, _)| axis == path).map(|(_, label)| label)
    }

    /// The group without one of its axes.
    #[must_use]
    pub fn without(&self, path: &str) -> Self {
        Self(self.0.iter().filter(|(axis, _)| axis != path).cloned().collect())
    }
}

impl Serialize for Group {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        let mut map = out.serialize_map(Some(self.0.len()))?;
        for (path, label) in &self.0 {
            map.serialize_entry(path, label)?;
        }
        map.end()
    }
}

/// Kind of a design of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DesignKind {
    /// Independent random points.
    MonteCarlo,
    /// One point in each slice of every dimension.
    LatinHypercube,
    /// Sobol's sequence.
    Sobol,
    /// Halton's sequence.
    Halton,
    /// Points that differ from a base point in one parameter; not a random sample.
    OneAtATime,
    /// Combinations of chosen values, or lines of a points file. Each row is a point of its own.
    Chosen,
    /// Morris trajectories, changing one parameter at a time; not a random sample.
    Morris,
    /// Pairs of points with parameters exchanged between them: points of a block are dependent.
    Saltelli,
}

impl DesignKind {
    /// Name of the kind in study files.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::MonteCarlo => "monte-carlo",
            Self::LatinHypercube => "latin-hypercube",
            Self::Sobol => "sobol",
            Self::Halton => "halton",
            Self::OneAtATime => "one-at-a-time",
            Self::Chosen => "chosen",
            Self::Morris => "morris",
            Self::Saltelli => "saltelli",
        }
    }
}

/// A design, and how much of it has been computed.
#[derive(Debug, Clone)]
pub struct Design<'a> {
    /// Kind of the design.
    pub kind: DesignKind,
    /// Whether a low-discrepancy sequence is scrambled (randomised).
    pub scrambled: bool,
    /// Number of replicates of the whole design.
    pub replicates: usize,
    /// Replicate of each point.
    pub replicate: &'a [u32],
    /// Whether all points have been computed, not only the first ones.
    pub complete: bool,
    /// Dependence of the points of a block.
    pub layout: Layout<'a>,
    /// Share of 1 - confidence available to a gate: 1 if the points are analysed once, below 1 in one of several interim analyses of
    /// `[stop]`, so that all analyses together use 1 - confidence.
    pub share: f64,
    /// Whether the combinations were chosen by their results (`[refine]`), so that together they are not a random sample.
    pub refined: bool,
}

/// Dependence of the points of a block.
#[derive(Debug, Clone, Copy)]
pub enum Layout<'a> {
    /// No dependence that an estimator uses.
    Points,
    /// Trajectories: the parameter step that leads to each point, and the step size.
    Trajectories(&'a [Option<Moved>], f64),
    /// Saltelli blocks: A, AB_1 .. AB_d, BA_1 .. BA_d if `second_order`, B.
    Saltelli {
        /// Whether the blocks contain BA_1 .. BA_d.
        second_order: bool,
    },
}

impl Design<'_> {
    /// Whether these points are those of one of several interim analyses of `[stop]`. Their intervals are approximate, because the
    /// number of points depends on the width of an interval.
    #[must_use]
    pub fn is_interim(&self) -> bool {
        self.share < 1.0
    }

    /// Whether the points are a random sample of the inputs, so that they represent points not computed.
    #[must_use]
    pub fn is_random(&self) -> bool {
        match self.kind {
            DesignKind::OneAtATime | DesignKind::Morris | DesignKind::Saltelli | DesignKind::Chosen => false,
            DesignKind::Sobol | DesignKind::Halton => self.scrambled,
            DesignKind::MonteCarlo | DesignKind::LatinHypercube => true,
        }
    }
}

/// Rows and design of a study.
#[derive(Debug, Clone)]
pub struct Study<'a> {
    /// Columns that the questions use; other columns may be missing.
    pub columns: Vec<Column<'a>>,
    /// Status of each row.
    pub status: &'a [Status],
    /// Causes of each row; empty for an ok row.
    pub causes: &'a [CauseSet],
    /// Reason why the run of each row ended.
    pub ends: &'a [Ended],
    /// Combinations of values of the crossed axes, at least one.
    pub groups: Vec<Group>,
    /// Design of the points.
    pub design: Design<'a>,
}

/// Reason why no question can be answered from these rows.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum InputError {
    /// A column whose length differs from the number of rows.
    #[error("column {name} has {found} cells, not {rows}")]
    Length {
        /// Name of the column.
        name: String,
        /// Number of its cells.
        found: usize,
        /// Number of rows of the study.
        rows: usize,
    },
    /// A number of rows that is not points times groups.
    #[error("{rows} rows are not whole points of {groups} groups and {points} points")]
    Points {
        /// Number of rows.
        rows: usize,
        /// Number of groups.
        groups: usize,
        /// Number of points with a replicate.
        points: usize,
    },
    /// A replicate number outside the design.
    #[error("point {point} is of replicate {found}, of {replicates}")]
    Replicate {
        /// Index of the point.
        point: usize,
        /// Its replicate number.
        found: u32,
        /// Number of replicates of the design.
        replicates: usize,
    },
    /// A column that a question needs and that the table does not have.
    #[error("the table has no column {0}")]
    Missing(String),
    /// A column of words where a question needs numbers.
    #[error("column {0} has words, not numbers")]
    Words(String),
    /// An estimator that is not valid for this design.
    #[error("{0}")]
    Method(String),
    /// Rows that do not fit the design.
    #[error(transparent)]
    Sensitivity(#[from] SensitivityError),
}

impl<'a> Study<'a> {
    /// Number of points of each group.
    #[must_use]
    pub fn points(&self) -> usize {
        self.design.replicate.len()
    }

    /// Row of a point in a group.
    #[must_use]
    pub fn row(&self, point: usize, group: usize) -> usize {
        point * self.groups.len() + group
    }

    /// # Errors
    /// Columns, groups and points do not fit together.
    pub fn check(&self) -> Result<(), InputError> {
        let rows = self.status.len();
        let length = |name: &str, found: usize| {
            if found == rows { Ok(()) } else { Err(InputError::Length { name: name.to_owned(), found, rows }) }
        };
        length("causes", self.causes.len())?;
        length("end_cause", self.ends.len())?;
        for column in &self.columns {
            length(&column.name, column.cells.len())?;
            if let Cells::Numbers(_, nature) = column.cells
                && let Some(held) = nature.held()
            {
                length(&column.name, held.len())?;
            }
        }
        if self.groups.is_empty() || rows != self.points() * self.groups.len() {
            return Err(InputError::Points { rows, groups: self.groups.len(), points: self.points() });
        }
        let replicates = self.design.replicates;
        match self.design.replicate.iter().position(|&replicate| replicate as usize >= replicates) {
            Some(point) => Err(InputError::Replicate { point, found: self.design.replicate[point], replicates }),
            None => Ok(()),
        }
    }

    /// Column of this name.
    ///
    /// # Errors
    /// The study has no column of this name.
    pub fn column(&self, name: &str) -> Result<&Column<'a>, InputError> {
        self.columns.iter().find(|column| column.name == name).ok_or_else(|| InputError::Missing(name.to_owned()))
    }

    /// Column of numbers of this name.
    ///
    /// # Errors
    /// The study has no column of this name, or the column has words.
    pub fn numbers(&self, name: &str) -> Result<(&'a [Option<f64>], Nature<'a>), InputError> {
        match self.column(name)?.cells {
            Cells::Numbers(values, nature) => Ok((values, nature)),
            Cells::Words(..) => Err(InputError::Words(name.to_owned())),
        }
    }

    /// Counts of the rows of a group that are not ok.
    #[must_use]
    pub fn bad(&self, group: usize) -> Bad {
        let mut found = Bad::default();
        (0..self.points()).for_each(|point| found.see(self.status[self.row(point, group)], false));
        found
    }
}
