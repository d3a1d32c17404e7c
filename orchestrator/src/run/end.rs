//! End of a table that `[stop]` or `[refine]` determines, or that had interim analyses.
//!
//! The end is recorded in the table's own metadata: a reader of the rows finds there how many rows belong to the table, and the error that
//! a gate may spend. The manifest and the status repeat the record.

use bladeoff_answers::summary::counted;
use bladeoff_answers::tables::{TableError, read_metadata};
use bladeoff_study::{Samples, block};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Duration;

/// Metadata key, without the common prefix.
pub const STOP: &str = "stop";

/// Reason of the end of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndWhy {
    /// All requested intervals are narrow enough.
    Precision,
    /// `samples` of `[stop]`.
    Samples,
    /// `wall` of `[stop]`.
    Wall,
    /// The design has no more points, and an interval is not narrow enough.
    Design,
    /// `[refine]` has added all combinations between unlike ones.
    Refined,
    /// The map of `[refine]` does not change between the first combinations.
    Unchanged,
    /// `max_samples` of `[refine]`.
    MaxSamples,
}

impl EndWhy {
    const ALL: [(&'static str, Self); 7] = [
        ("precision", Self::Precision),
        ("samples", Self::Samples),
        ("wall", Self::Wall),
        ("design", Self::Design),
        ("refined", Self::Refined),
        ("unchanged", Self::Unchanged),
        ("max_samples", Self::MaxSamples),
    ];

    fn word(self) -> &'static str {
        Self::ALL.iter().find(|(_, why)| *why == self).map_or("", |(word, _)| *word)
    }
}

/// End of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableEnd {
    /// Points.
    pub points: u64,
    /// Samples: rows.
    pub samples: u64,
    /// Part of 1 - confidence that a gate may spend; below 1: one of several interim analyses.
    pub share: f64,
    /// Reason.
    pub why: EndWhy,
}

impl TableEnd {
    /// Value for metadata, manifest and status.
    #[must_use]
    pub fn json(&self) -> Value {
        json!({ "points": self.points, "samples": self.samples, "share": self.share, "why": self.why.word() })
    }

    /// Reads the value; `None`: invalid.
    #[must_use]
    pub fn of_json(said: &Value) -> Option<Self> {
        let why = EndWhy::ALL.iter().find(|(word, _)| said["why"] == *word).map(|(_, why)| *why)?;
        let (points, samples) = (said["points"].as_u64()?, said["samples"].as_u64()?);
        let share = said["share"].as_f64().filter(|share| *share > 0.0 && *share <= 1.0)?;
        Some(Self { points, samples, share, why })
    }

    /// Describes the end when the points of the design are unknown: "512 points, precise enough".
    #[must_use]
    pub fn brief(&self) -> String {
        let why = match self.why {
            EndWhy::Refined => return format!("{} samples, as fine as its values", self.samples),
            EndWhy::Unchanged => return format!("{} samples, the map changes nowhere", self.samples),
            EndWhy::MaxSamples => return format!("{} samples, by `max_samples`", self.samples),
            EndWhy::Precision => "precise enough",
            EndWhy::Samples => "by `samples`",
            EndWhy::Wall => "by `wall`",
            EndWhy::Design => "the whole design, less precise than required",
        };
        format!("{} points, {why}", self.points)
    }

    /// Describes the end: "precise enough at 512 of 4096 points (`[stop]`)".
    #[must_use]
    pub fn words(&self, samples: &Samples) -> String {
        self.words_of(samples.points(), samples.layout().and_then(block))
    }

    /// Describes the end of a design of so many points; `block`: points of a block and the word for blocks, if these are counted.
    #[must_use]
    pub fn words_of(&self, of: u64, block: Option<(u64, &str)>) -> String {
        let points = self.points;
        // `samples` of [stop] counts them
        let at = match block {
            Some((each, name)) => {
                format!("{} of {} {name} ({points} of {of} points)", points / each.max(1), of / each.max(1))
            }
            None => format!("{points} of {of} points"),
        };
        match self.why {
            EndWhy::Precision => format!("precise enough at {at} ([stop])"),
            EndWhy::Samples => format!("ended at {at} by `samples` of [stop]"),
            EndWhy::Wall => format!("ended at {at} by `wall` of [stop]"),
            EndWhy::Refined => {
                format!("{}; as fine as its values ([refine])", self.chosen())
            }
            EndWhy::Unchanged => {
                let first = counted(self.samples, "sample");
                format!(
                    "{first}: the map changes nowhere between its first combinations, so no combination is added ([refine])"
                )
            }
            EndWhy::MaxSamples => {
                format!("{}: ended by `max_samples` of [refine], before the map was complete", self.chosen())
            }
            EndWhy::Design => {
                format!("all {of} points are done, and not every interval is as narrow as [stop] requires")
            }
        }
    }

    fn chosen(&self) -> String {
        format!("{}, chosen where the map changes", counted(self.samples, "sample"))
    }

    /// Whether `[refine]` chose the combinations of the table.
    #[must_use]
    pub fn is_chosen(&self) -> bool {
        matches!(self.why, EndWhy::Refined | EndWhy::Unchanged | EndWhy::MaxSamples)
    }

    /// Whether the study ended before its design did.
    #[must_use]
    pub fn is_early(&self) -> bool {
        self.why != EndWhy::Design
    }
}

/// Reads the end of a table; `None`: the end of its design, without interim analyses.
///
/// # Errors
/// The table cannot be read.
pub fn end_of_table(table: &Path) -> Result<Option<TableEnd>, TableError> {
    let key = format!("bladeoff.{STOP}");
    let found = read_metadata(table)?.into_iter().find(|(name, _)| *name == key);
    Ok(found.and_then(|(_, text)| TableEnd::of_json(&serde_json::from_str(&text).ok()?)))
}

/// Interim analysis of the first samples of a study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    /// Points.
    pub points: u64,
    /// Samples: points in all groups.
    pub samples: u64,
    /// Part of 1 - confidence that a gate may spend; below 1: one of several interim analyses.
    pub share: f64,
}

/// Decision at each interim analysis whether a study is precise enough, by its questions; the run does not know them.
pub trait PrecisionCheck: std::fmt::Debug {
    /// Stages in ascending order; the last one is the latest end of the study.
    fn stages(&self) -> &[Stage];

    /// Whether intervals are computed; if not, only the end matters.
    fn looks(&self) -> bool;

    /// Largest time of a run.
    fn wall(&self) -> Option<Duration>;

    /// Analyses the rows of a stage in this table.
    ///
    /// # Errors
    /// The table cannot be read, or lacks a requested quantity.
    fn look(&self, stage: &Stage, table: &Path) -> Result<PrecisionResult, PrecisionError>;
}

/// Result of an interim analysis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PrecisionResult {
    /// The rows are precise enough.
    pub is_enough: bool,
    /// Requests that no further sample makes precise enough: a name that is the same at every analysis, and the reason.
    pub hindered: Vec<(String, String)>,
}

/// Error of an interim analysis.
#[derive(Debug, thiserror::Error)]
#[error("cannot determine whether the study is precise enough")]
pub struct PrecisionError(#[source] pub Box<dyn std::error::Error + Send + Sync>);
