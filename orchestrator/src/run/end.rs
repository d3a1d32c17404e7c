//! Where a table ends that ends before its design does, or of which less was asked at several looks: `[stop]`; or that has what `[refine]`
//! has chosen.
//!
//! The end is recorded in the table's own metadata: a reader of the rows finds there how many rows belong to the table, and the error that
//! a gate may spend. The manifest and the status repeat the record.

use bladeoff_answers::summary::counted;
use bladeoff_answers::tables::{TableError, read_metadata};
use bladeoff_study::{Samples, block};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Duration;

/// Key of the metadata, without the prefix of all.
pub const STOP: &str = "stop";

/// Why a table ends where it does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndWhy {
    /// Every interval that was asked for is narrow enough.
    Precision,
    /// `samples` of `[stop]`.
    Samples,
    /// `wall` of `[stop]`.
    Wall,
    /// The design has no more points; the intervals are not narrow enough.
    Design,
    /// `[refine]` has added what lies between unlike combinations of a map.
    Refined,
    /// The map of `[refine]` changes nowhere between the first combinations.
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

/// The end of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableEnd {
    /// Points.
    pub points: u64,
    /// Samples: rows.
    pub samples: u64,
    /// Part of 1 - confidence that a gate may spend; below 1: one of several interim analyses.
    pub share: f64,
    /// Why here.
    pub why: EndWhy,
}

impl TableEnd {
    /// As it stands in metadata, manifest and status.
    #[must_use]
    pub fn json(&self) -> Value {
        json!({ "points": self.points, "samples": self.samples, "share": self.share, "why": self.why.word() })
    }

    /// From its JSON; `None`: it is none.
    #[must_use]
    pub fn of_json(said: &Value) -> Option<Self> {
        let why = EndWhy::ALL.iter().find(|(word, _)| said["why"] == *word).map(|(_, why)| *why)?;
        let (points, samples) = (said["points"].as_u64()?, said["samples"].as_u64()?);
        let share = said["share"].as_f64().filter(|share| *share > 0.0 && *share <= 1.0)?;
        Some(Self { points, samples, share, why })
    }

    /// The same where the points of the design are not known: "512 points, precise enough".
    #[must_use]
    pub fn brief(&self) -> String {
        let why = match self.why {
            EndWhy::Refined => return format!("{} samples, as fine as its values", self.samples),
            EndWhy::Unchanged => return format!("{} samples, the map changes nowhere", self.samples),
            EndWhy::MaxSamples => return format!("{} samples, by `max_samples`", self.samples),
            EndWhy::Precision => "precise enough",
            EndWhy::Samples => "by `samples`",
            EndWhy::Wall => "by `wall`",
            EndWhy::Design => "all of the design, not as precise as asked",
        };
        format!("{} points, {why}", self.points)
    }

    /// In words: "precise enough at 512 of 4096 points (`[stop]`)".
    #[must_use]
    pub fn words(&self, samples: &Samples) -> String {
        self.words_of(samples.points(), samples.layout().and_then(block))
    }

    /// The same of so many points; `block`: points of a block, and what blocks are called, where these are counted.
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
                format!("{}; there it is as fine as its values ([refine])", self.chosen())
            }
            EndWhy::Unchanged => {
                let first = counted(self.samples, "sample");
                format!("{first}: the map changes nowhere between its first combinations, so none is added ([refine])")
            }
            EndWhy::MaxSamples => {
                format!("{}: no more by `max_samples` of [refine], which wanted others", self.chosen())
            }
            EndWhy::Design => format!("all {of} points are done, and not every interval is as narrow as [stop] asks"),
        }
    }

    fn chosen(&self) -> String {
        format!("{}, chosen where the map changes", counted(self.samples, "sample"))
    }

    /// Whether the table has what `[refine]` has chosen.
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

/// The end that a table tells of; `None` of one that ends with its design and was looked at once.
///
/// # Errors
/// The table cannot be read.
pub fn end_of_table(table: &Path) -> Result<Option<TableEnd>, TableError> {
    let key = format!("bladeoff.{STOP}");
    let found = read_metadata(table)?.into_iter().find(|(name, _)| *name == key);
    Ok(found.and_then(|(_, text)| TableEnd::of_json(&serde_json::from_str(&text).ok()?)))
}

/// A beginning of a study's samples at which it is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    /// Points.
    pub points: u64,
    /// Samples: points in all groups.
    pub samples: u64,
    /// Part of 1 - confidence that a gate may spend; below 1: one of several interim analyses.
    pub share: f64,
}

/// Who says at its stages whether a study is precise enough: by its questions, which a run knows nothing of.
pub trait Looking: std::fmt::Debug {
    /// The stages, in order; the last is where the study ends at the latest.
    fn stages(&self) -> &[Stage];

    /// Whether intervals are looked at; if not, only the end matters.
    fn looks(&self) -> bool;

    /// Time of a run at most.
    fn wall(&self) -> Option<Duration>;

    /// What the rows of a stage, in this table, come to.
    ///
    /// # Errors
    /// The table cannot be read, or does not hold what is asked for.
    fn look(&self, stage: &Stage, table: &Path) -> Result<Looked, LookingError>;
}

/// What a look found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Looked {
    /// The rows are precise enough.
    pub is_enough: bool,
    /// What is asked for and no further sample makes precise enough: a name of it, the same at every look, and why.
    pub hindered: Vec<(String, String)>,
}

/// Why nothing can be said of a stage.
#[derive(Debug, thiserror::Error)]
#[error("whether the study is precise enough cannot be found out")]
pub struct LookingError(#[source] pub Box<dyn std::error::Error + Send + Sync>);
