//! Answers as they are written: `answers.json`.

use super::scale::Scale;
use crate::estimate::bad::Bad;
use crate::estimate::figures::{Figures, Method};
use crate::estimate::input::Group;
use crate::map::Map;
use crate::sensitivity::{Index, Indices, Pair};
use serde::Serialize;

/// Version of the layout of `answers.json`.
pub const SCHEMA: u32 = 1;

/// Said of each group where it is so.
pub const LEFT_WIDE: &str =
    "more runs will not help: runs that are not ok cause most of the uncertainty; see their causes (`bladeoff why`)";

/// Note of a group whose open runs are all beyond the model.
pub const LEFT_WIDE_BEYOND: &str = "more runs will not help: the runs beyond the model cause most of the uncertainty";

/// Whether a note holds for its group alone, whatever other groups have.
#[must_use]
pub fn is_of_group(note: &str) -> bool {
    [LEFT_WIDE, LEFT_WIDE_BEYOND].contains(&note)
}

/// The answer to a question in one group. Null where there is no number.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// The question's.
    pub name: String,
    /// `probability`, `quantile`, `mean`, `exceedance`, `fragility`, `difference`, `sensitivity`, `map`.
    pub kind: &'static str,
    /// Its values on the crossed axes.
    pub group: Group,
    /// Points that it is over; of a sensitivity by blocks of points, blocks.
    pub n: u64,
    /// Points where the event happened for certain; null but for a probability.
    pub events: Option<u64>,
    /// Bad runs among the group's: failed, invalid, quarantined, beyond the model.
    pub bad: u64,
    /// Runs beyond the model among them.
    pub beyond: u64,
    /// Runs beyond the model whose values do not decide the question.
    #[serde(skip)]
    pub beyond_open: u64,
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
    /// Of a map: its cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<Box<Map>>,
    /// Of a sensitivity.
    #[serde(flatten)]
    pub sensitivity: Option<Sensitivities>,
    /// For a person.
    #[serde(skip)]
    pub sentence: String,
    /// Lines below the sentence.
    #[serde(skip)]
    pub lines: Vec<String>,
    /// Every number with its interval, for who waits for intervals to become narrow; none of a curve.
    #[serde(skip)]
    pub figures: Vec<Figures>,
    /// How these numbers read.
    #[serde(skip)]
    pub scale: Scale,
}

/// What a sensitivity has beside what every answer has; keys that a method does not fill are not there.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sensitivities {
    /// The column that is decided.
    pub output: String,
    /// `morris`, `sobol`, `given-data`.
    pub estimator: &'static str,
    /// By parameter.
    pub indices: Indices,
    /// Of pairs of parameters, what they make together beyond each alone.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub second_order: Vec<Pair>,
    /// Part of the variance of the ranks that the regression makes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub r2: Option<Index>,
    /// Blocks, or rows, that are out because a run has no number.
    pub left_out: u64,
    /// Parameters of a Saltelli design whose values in A and in B are correlated; their total indices are biased.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub correlated: Vec<Correlated>,
    /// Of each regime, where there are several and the method allows it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub regimes: Vec<OfRegime>,
}

/// A parameter whose values in A and in B of a Saltelli design are correlated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Correlated {
    /// Its column.
    pub parameter: String,
    /// The correlation coefficient over the base points that count.
    pub correlation: f64,
}

/// Sensitivities of the runs of a regime.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OfRegime {
    /// Its word.
    pub regime: String,
    /// Its part of all runs with a number.
    pub share: f64,
    /// Its runs.
    pub n: u64,
    /// By parameter.
    pub indices: Indices,
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
    pub fn of(name: &str, kind: &'static str, group: Group, bad: Bad, confidence: f64, figures: Figures) -> Self {
        let mut notes = figures.notes.clone();
        // how far bad runs move the figure, and by how much they widen the interval: next to 0 and 1 its ends have no room, and in a
        // difference the figures may stand still
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
    /// What the number at this place of [`Answer::figures`] is, where there are several: "first order of gap".
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
    /// The place in [`Answer::figures`] of the index that ranks the most decisive parameter of a sensitivity; `None`: no index has an interval.
    #[must_use]
    pub fn most_decisive(&self) -> Option<usize> {
        let found = self.sensitivity.as_ref().filter(|found| !found.indices.of.is_empty())?;
        let each = (self.figures.len() / found.indices.of.len()).max(1);
        let ranking = if found.estimator == "sobol" { each - 1 } else { 0 };
        let places = (ranking..self.figures.len()).step_by(each);
        let ranking = |of: &Figures| of.estimate.filter(|_| of.low.is_some() && of.high.is_some());
        let known = places.filter_map(|at| Some((at, ranking(&self.figures[at])?)));
        // of equal ones the first, as sentences rank them
        known.reduce(|most, one| if one.1 > most.1 { one } else { most }).map(|(at, _)| at)
    }

    /// Why a sensitivity has no interval: "no interval: 5 trajectories of 10 needed".
    #[must_use]
    pub fn without_interval(&self) -> Option<String> {
        let found = self.sensitivity.as_ref()?;
        let is_why = |note: &&String| note.starts_with("no interval") || note.contains("have an interval from ");
        let told = self.notes.iter().find(is_why).cloned();
        told.or_else(|| found.indices.without.map(|why| format!("no number: {why}")))
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
