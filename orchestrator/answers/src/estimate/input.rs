//! Input of an estimate: a study's columns in sample order, and the design that its points come from.
//!
//! The design is the slowest axis: row = point x groups + group, where a group is one combination of values of the crossed axes.

use super::bad::Bad;
use crate::sensitivity::{Moved, SensitivityError};
use bladeoff_model::outcome::{CauseSet, Status};
use serde::ser::{Serialize, SerializeMap, Serializer};
use std::fmt;

/// What a bad run says about a column of numbers.
#[derive(Debug, Clone, Copy)]
pub enum Nature<'a> {
    /// All: it went into the run (parameters, variables, what was carried along). Where there is none, it could not be derived.
    Given,
    /// Time of a first event, where it happened while all guards and limits held: these cells. Else nothing.
    Once(Option<&'a [Option<f64>]>),
    /// At least what was reached while all guards held, `None` where nothing was: the column only grows during a run (peaks,
    /// impulses, energies). No cells at all: nothing is known.
    Grows(Option<&'a [Option<f64>]>),
    /// Time of the first exceeded limit of the model: known of a beyond row, else as [`Nature::Once`].
    Limit(Option<&'a [Option<f64>]>),
    /// Nothing.
    Free,
}

impl<'a> Nature<'a> {
    /// Further cells with what was reached while all guards and limits held.
    #[must_use]
    pub fn held(self) -> Option<&'a [Option<f64>]> {
        match self {
            Self::Once(held) | Self::Limit(held) | Self::Grows(held) => held,
            Self::Given | Self::Free => None,
        }
    }

    /// Nature with the further cells of some of the rows.
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

/// End of a run, as far as it bears on what the row leaves open.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Ended {
    /// At a limit of the model.
    Limit,
    /// At the end of the simulated time \[s\]: later events are unknown.
    Time(f64),
    /// Elsewhere.
    #[default]
    Other,
}

/// Cells of a column.
#[derive(Debug, Clone, Copy)]
pub enum Cells<'a> {
    /// Numbers; `None` where nothing of the kind happened.
    Numbers(&'a [Option<f64>], Nature<'a>),
    /// Words, and which there may be, in their order.
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

/// A column.
#[derive(Debug, Clone)]
pub struct Column<'a> {
    /// Its name.
    pub name: String,
    /// SI unit, "" for a pure number.
    pub unit: String,
    /// Its cells.
    pub cells: Cells<'a>,
    /// Whether an empty cell of an ok row decides nothing, because the run has no such quantity.
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
    /// In SI.
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

/// One combination of values of the crossed axes: path and value, in the axes' order; empty where nothing is varied.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Group(pub Vec<(String, Label)>);

impl Group {
    /// Its value on an axis.
    #[must_use]
    pub fn label(&self, path: &str) -> Option<&Label> {
        self.0.iter().find(|(axis, _)| axis == path).map(|(_, label)| label)
    }

    /// Without an axis.
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

/// How points are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DesignKind {
    /// Independent.
    MonteCarlo,
    /// One in each slice of every dimension.
    LatinHypercube,
    /// Sobol's sequence.
    Sobol,
    /// Halton's sequence.
    Halton,
    /// One parameter moved at a time: no sample of anything.
    OneAtATime,
    /// No design at all: combinations of chosen values, or the lines of a points file. Each row is a point of its own.
    Chosen,
    /// Trajectories of one parameter at a time: no sample of anything.
    Morris,
    /// Pairs of points with parameters exchanged between them: points of a block depend on one another.
    Saltelli,
}

impl DesignKind {
    /// Its word in study files.
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

/// A design and how much of it is there.
#[derive(Debug, Clone)]
pub struct Design<'a> {
    /// Its kind.
    pub kind: DesignKind,
    /// Whether its points are random where the kind has a plain form.
    pub scrambled: bool,
    /// Replicates of the whole design.
    pub replicates: usize,
    /// Replicate of each point.
    pub replicate: &'a [u32],
    /// Whether all its points are there, and not only the first ones.
    pub complete: bool,
    /// What points of a block are to one another.
    pub layout: Layout<'a>,
    /// Part of 1 - confidence that a gate may spend: 1 where these points are analysed once; below 1 where they are those of one of
    /// several interim analyses of `[stop]`, so that all of them together spend the whole.
    pub share: f64,
    /// Whether the combinations that are there were chosen by their results (`[refine]`), so that together they are no sample of all.
    pub refined: bool,
}

/// What points of a block are to one another.
#[derive(Debug, Clone, Copy)]
pub enum Layout<'a> {
    /// Nothing that an estimator uses.
    Points,
    /// Trajectories: the move that leads to each point, and how far it goes.
    Trajectories(&'a [Option<Moved>], f64),
    /// A, AB_1 .. AB_d, BA_1 .. BA_d where `second_order`, B.
    Saltelli {
        /// Whether every BA_i is there.
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

    /// Whether its points are drawn one for one, so that they tell of others.
    #[must_use]
    pub fn is_random(&self) -> bool {
        match self.kind {
            DesignKind::OneAtATime | DesignKind::Morris | DesignKind::Saltelli | DesignKind::Chosen => false,
            DesignKind::Sobol | DesignKind::Halton => self.scrambled,
            DesignKind::MonteCarlo | DesignKind::LatinHypercube => true,
        }
    }
}

/// A study's rows.
#[derive(Debug, Clone)]
pub struct Study<'a> {
    /// Columns that are asked for; others may be missing.
    pub columns: Vec<Column<'a>>,
    /// Of each row.
    pub status: &'a [Status],
    /// Every cause of each row, none of an ok one.
    pub causes: &'a [CauseSet],
    /// End of each row's run.
    pub ends: &'a [Ended],
    /// Groups, at least one.
    pub groups: Vec<Group>,
    /// Where the points come from.
    pub design: Design<'a>,
}

/// Why no question can be put to these rows.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum InputError {
    /// A column has another length.
    #[error("column {name} has {found} cells, not {rows}")]
    Length {
        /// The column.
        name: String,
        /// Its cells.
        found: usize,
        /// Rows of the study.
        rows: usize,
    },
    /// Rows are no whole number of points.
    #[error("{rows} rows are not whole points of {groups} groups and {points} points")]
    Points {
        /// Rows.
        rows: usize,
        /// Groups.
        groups: usize,
        /// Points whose replicate is given.
        points: usize,
    },
    /// A point's replicate is none of the design's.
    #[error("point {point} is of replicate {found}, of {replicates}")]
    Replicate {
        /// The point.
        point: usize,
        /// Its replicate.
        found: u32,
        /// Replicates of the design.
        replicates: usize,
    },
    /// A question needs a column that is not there.
    #[error("the table has no column {0}")]
    Missing(String),
    /// A question needs numbers.
    #[error("column {0} has words, not numbers")]
    Words(String),
    /// A method that makes nothing of these points.
    #[error("{0}")]
    Method(String),
    /// Rows are not those of the design.
    #[error(transparent)]
    Sensitivity(#[from] SensitivityError),
}

impl<'a> Study<'a> {
    /// Points in all groups.
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

    /// A column.
    ///
    /// # Errors
    /// There is none of this name.
    pub fn column(&self, name: &str) -> Result<&Column<'a>, InputError> {
        self.columns.iter().find(|column| column.name == name).ok_or_else(|| InputError::Missing(name.to_owned()))
    }

    /// A column of numbers.
    ///
    /// # Errors
    /// There is none of this name, or it has words.
    pub fn numbers(&self, name: &str) -> Result<(&'a [Option<f64>], Nature<'a>), InputError> {
        match self.column(name)?.cells {
            Cells::Numbers(values, nature) => Ok((values, nature)),
            Cells::Words(..) => Err(InputError::Words(name.to_owned())),
        }
    }

    /// Rows of a group that are not ok.
    #[must_use]
    pub fn bad(&self, group: usize) -> Bad {
        let mut found = Bad::default();
        (0..self.points()).for_each(|point| found.see(self.status[self.row(point, group)], false));
        found
    }
}
