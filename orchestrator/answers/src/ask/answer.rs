//! Answers as they are written: `answers.json`.

use crate::estimate::figures::{Figures, Method};
use crate::estimate::input::Group;
use serde::Serialize;

/// Version of the layout of `answers.json`.
pub const SCHEMA: u32 = 1;

/// Said of each group where it is so.
pub const LEFT_WIDE: &str =
    "what the bad runs leave open is wider than what the number of points does: find out why they fail";

/// The answer to a question in one group. Null where there is no number.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// The question's.
    pub name: String,
    /// `probability`, `quantile`, `mean`, `exceedance`, `fragility`, `difference`.
    pub kind: &'static str,
    /// Its values on the crossed axes.
    pub group: Group,
    /// Points that it is over.
    pub n: u64,
    /// Points where the event happened for certain; null but for a probability.
    pub events: Option<u64>,
    /// Bad runs among the group's.
    pub bad: u64,
    /// With bad runs harmless.
    pub estimate: Option<f64>,
    /// With bad runs harmful.
    pub estimate_if_bad_harmful: Option<f64>,
    /// Limits that cover both.
    pub low: Option<f64>,
    /// As `low`.
    pub high: Option<f64>,
    /// Of the limits.
    pub confidence: f64,
    /// How the limits were made.
    pub method: Method,
    /// They hold in the limit of many points, not exactly.
    pub approximate: bool,
    /// What a reader has to know.
    pub notes: Vec<String>,
    /// For a person.
    #[serde(skip)]
    pub sentence: String,
}

/// `answers.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answers {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Whether all points of the study are in.
    pub complete: bool,
    /// In the order of questions and groups.
    pub answers: Vec<Answer>,
}

impl Answer {
    /// From its figures, without a sentence.
    #[must_use]
    pub fn of(name: &str, kind: &'static str, group: Group, bad: u64, confidence: f64, figures: Figures) -> Self {
        let mut notes = figures.notes.clone();
        // by how much bad runs widen the interval; where it has no ends, by how much they move the figure
        let widened =
            figures.high.zip(figures.low).zip(figures.statistical).map(|((high, low), width)| high - low - width);
        if let (Some(open), Some(width)) = (widened.or(figures.left_open()), figures.statistical)
            && open.abs() > width
        {
            notes.push(LEFT_WIDE.to_owned());
        }
        Self {
            name: name.to_owned(),
            kind,
            group,
            n: figures.n,
            events: figures.events,
            bad,
            estimate: figures.estimate,
            estimate_if_bad_harmful: figures.harmful,
            low: figures.low,
            high: figures.high,
            confidence,
            method: figures.method,
            approximate: figures.approximate,
            notes,
            sentence: String::new(),
        }
    }
}

impl Answers {
    /// The text of the file.
    ///
    /// # Errors
    /// None that is known: numbers are finite or null.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }
}
