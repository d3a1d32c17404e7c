//! Answers to the questions of a study, in the layout of `answers.json`.

use super::scale::Scale;
use crate::estimate::bad::Bad;
use crate::estimate::figures::{Figures, Method};
use crate::estimate::input::Group;
use crate::map::Map;
use crate::sensitivity::{Index, Indices, Pair};
use serde::Serialize;

/// Version of the layout of `answers.json`.
pub const SCHEMA: u32 = 1;

/// Note of a group in which runs that are not ok cause more uncertainty than the number of runs.
pub const LEFT_WIDE: &str =
    "more runs will not help: runs that are not ok cause most of the uncertainty; see their causes (`bladeoff why`)";

/// Note of a group in which all runs that leave the answer open are beyond the model.
pub const LEFT_WIDE_BEYOND: &str = "more runs will not help: the runs beyond the model cause most of the uncertainty";

/// Whether a note applies to one group only, independent of the other groups.
#[must_use]
pub fn is_of_group(note: &str) -> bool {
    [LEFT_WIDE, LEFT_WIDE_BEYOND].contains(&note)
}

/// The answer to a question in one group. A missing number is null.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// Name of the question.
    pub name: String,
    /// `probability`, `quantile`, `mean`, `exceedance`, `fragility`, `difference`, `sensitivity`, `map`.
    pub kind: &'static str,
    /// Values of the group on the crossed axes.
    pub group: Group,
    /// Number of points; for a sensitivity by blocks, number of blocks.
    pub n: u64,
    /// Points where the event certainly happened; null unless the answer is a probability.
    pub events: Option<u64>,
    /// Bad runs of the group: failed, invalid, quarantined, beyond the model.
    pub bad: u64,
    /// Runs beyond the model, included in `bad`.
    pub beyond: u64,
    /// Runs beyond the model whose recorded values do not determine the answer.
    #[serde(skip)]
    pub beyond_open: u64,
    /// Estimate with bad runs counted as harmless.
    pub estimate: Option<f64>,
    /// Estimate with bad runs counted as harmful.
    pub estimate_if_bad_harmful: Option<f64>,
    /// Lower confidence limit; the interval covers bad runs counted either way.
    pub low: Option<f64>,
    /// Upper confidence limit, likewise.
    pub high: Option<f64>,
    /// Confidence level of `low` and `high`.
    pub confidence: f64,
    /// Method of the interval.
    pub method: Method,
    /// Whether the interval holds asymptotically (many points) instead of exactly.
    pub approximate: bool,
    /// Reservations and remarks for the reader.
    pub notes: Vec<String>,
    /// Cells of a map; `None` for other questions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<Box<Map>>,
    /// Indices of a sensitivity; `None` for other questions.
    #[serde(flatten)]
    pub sensitivity: Option<Sensitivities>,
    /// The answer as a sentence.
    #[serde(skip)]
    pub sentence: String,
    /// Lines of text below the sentence.
    #[serde(skip)]
    pub lines: Vec<String>,
    /// Every number with its interval, for stopping rules on interval widths; empty for a curve.
    #[serde(skip)]
    pub figures: Vec<Figures>,
    /// Unit and format of `figures`.
    #[serde(skip)]
    pub scale: Scale,
}

/// Additional keys of a sensitivity answer; keys that the method does not fill are omitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sensitivities {
    /// Output column whose sensitivity was asked for.
    pub output: String,
    /// `morris`, `sobol`, `given-data`.
    pub estimator: &'static str,
    /// Indices by parameter.
    pub indices: Indices,
    /// Second-order (interaction) indices of pairs of parameters.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub second_order: Vec<Pair>,
    /// Share of the variance of the ranks that the rank regression explains (R²).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub r2: Option<Index>,
    /// Blocks or rows excluded because a run has no number.
    pub left_out: u64,
    /// Parameters of a Saltelli design whose values in A and in B are correlated; their total indices are biased.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub correlated: Vec<Correlated>,
    /// Indices within each regime, where there are several and the method allows it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub regimes: Vec<OfRegime>,
}

/// A parameter whose values in A and in B of a Saltelli design are correlated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Correlated {
    /// Column of the parameter.
    pub parameter: String,
    /// The correlation coefficient over the base points that count.
    pub correlation: f64,
}

/// Sensitivities over the runs of one regime.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OfRegime {
    /// Name of the regime.
    pub regime: String,
    /// Share of this regime among all runs with a number.
    pub share: f64,
    /// Number of runs in the regime.
    pub n: u64,
    /// Indices by parameter.
    pub indices: Indices,
}

/// Content of `answers.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answers {
    /// Layout version, [`SCHEMA`].
    pub schema: u32,
    /// Whether every point of the study has been computed.
    pub complete: bool,
    /// Answers in the order of questions, then groups.
    pub answers: Vec<Answer>,
}

impl Answer {
    /// Builds an answer from its figures; the sentence stays empty.
    #[must_use]
    pub fn of(name: &str, kind: &'static str, group: Group, bad: Bad, confidence: f64, figures: Figures) -> Self {
        let mut notes = figures.notes.clone();
        // Compare the shift of the figure by bad runs, and their widening of the interval, with its statistical width. Both are needed: near 0
        // and 1 the interval cannot widen, and in a difference the two shifts can cancel.
        if let Some(width) = figures.statistical {
            let widened = figures.high.zip(figures.low).map(|(high, low)| high - low - width);
            if bad.all > 0 && [widened, figures.left_open()].iter().flatten().any(|open| open.abs() > width) {
                let note = if bad.open().failing() == 0 && bad.beyond > 0 { LEFT_WIDE_BEYOND } else { LEFT_WIDE };
                notes.push(note.to_owned());
            }
        }
        Self {
            name: name.to_owned(),
            kind,
            group,
            n: figures.n,
            events: figures.events,
            bad: bad.all,
            beyond: bad.beyond,
            beyond_open: bad.open().beyond,
            estimate: figures.estimate,
            estimate_if_bad_harmful: figures.harmful,
            low: figures.low,
            high: figures.high,
            confidence,
            method: figures.method,
            approximate: figures.approximate,
            notes,
            map: None,
            sensitivity: None,
            sentence: String::new(),
            lines: Vec::new(),
            figures: Vec::new(),
            scale: Scale::Share,
        }
    }
}

impl Answer {
    /// Name of the number at this index of [`Answer::figures`], where there are several: "first order of gap".
    #[must_use]
    pub fn figure_name(&self, at: usize) -> String {
        let Some(found) = self.sensitivity.as_ref().filter(|found| !found.indices.of.is_empty()) else {
            return String::new();
        };
        let each = (self.figures.len() / found.indices.of.len()).max(1);
        let what = match (found.estimator, at % each) {
            ("morris", _) => "mu*",
            ("sobol", 1) => "total order",
            _ => "first order",
        };
        found.indices.of.get(at / each).map_or(String::new(), |(name, _)| format!("{what} of {name}"))
    }
}

impl Answer {
    /// Index in [`Answer::figures`] of the ranking index of the most important parameter; `None` if no index has an interval.
    #[must_use]
    pub fn most_decisive(&self) -> Option<usize> {
        let found = self.sensitivity.as_ref().filter(|found| !found.indices.of.is_empty())?;
        let each = (self.figures.len() / found.indices.of.len()).max(1);
        let ranking = if found.estimator == "sobol" { each - 1 } else { 0 };
        let places = (ranking..self.figures.len()).step_by(each);
        let ranking = |of: &Figures| of.estimate.filter(|_| of.low.is_some() && of.high.is_some());
        let known = places.filter_map(|at| Some((at, ranking(&self.figures[at])?)));
        // the first of equal ones, as sentences rank them
        known.reduce(|most, one| if one.1 > most.1 { one } else { most }).map(|(at, _)| at)
    }

    /// The reason why a sensitivity has no interval: "no interval: 5 trajectories of 10 needed".
    #[must_use]
    pub fn without_interval(&self) -> Option<String> {
        let found = self.sensitivity.as_ref()?;
        let is_why = |note: &&String| note.starts_with("no interval") || note.contains("have an interval from ");
        let told = self.notes.iter().find(is_why).cloned();
        told.or_else(|| found.indices.without.map(|why| format!("no number: {why}")))
    }
}

impl Answers {
    /// Text of the file.
    ///
    /// # Errors
    /// No known case: numbers are finite or null.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }
}
