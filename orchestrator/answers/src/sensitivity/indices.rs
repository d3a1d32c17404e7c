//! Indices as they are written: `indices` of an answer in `answers.json`, by parameter.

use serde::ser::{Serialize, SerializeMap, Serializer};

/// A figure with its interval; null where there is no number.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Index {
    /// The figure.
    pub estimate: Option<f64>,
    /// Lower limit.
    pub low: Option<f64>,
    /// Upper limit.
    pub high: Option<f64>,
}

impl Index {
    /// Without an interval.
    #[must_use]
    pub fn alone(estimate: Option<f64>) -> Self {
        Self { estimate, low: None, high: None }
    }

    /// Estimate that ranks a parameter; `None`: the index has no interval.
    #[must_use]
    pub fn ranking(&self) -> Option<f64> {
        self.estimate.filter(|_| self.low.is_some() && self.high.is_some())
    }
}

/// How surely an output depends on a parameter in any way.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Hsic {
    /// HSIC(x, y)/sqrt(HSIC(x, x) HSIC(y, y)), 0 to 1.
    pub normalised: f64,
    /// Probability of as much without any dependence; of each parameter by itself.
    pub p_value: f64,
}

/// Figures of a parameter: those of the method are there.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct OfParameter {
    /// Mean of the magnitudes of its elementary effects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu_star: Option<Index>,
    /// Mean of its elementary effects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu: Option<Index>,
    /// Standard deviation of its elementary effects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma: Option<Index>,
    /// Part of the variance that it makes alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first: Option<Index>,
    /// Part of the variance that it has a share in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub total: Option<Index>,
    /// Rank correlation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spearman: Option<Index>,
    /// Coefficient of the standardised rank regression.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rank_regression: Option<Index>,
    /// Any dependence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hsic: Option<Hsic>,
}

/// Part of the variance that two parameters make together, beyond each alone.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Pair {
    /// Their names.
    pub between: [String; 2],
    /// The part.
    pub second: Index,
}

/// What a method found.
#[derive(Debug, Clone, PartialEq)]
pub struct Indices {
    /// By parameter, in the order of the study.
    pub of: Vec<(String, OfParameter)>,
    /// Of pairs, where the design has what they need.
    pub pairs: Vec<Pair>,
    /// Part of the variance of the ranks that a regression on them makes.
    pub r2: Option<Index>,
    /// `bootstrap`, `replicates-t` or `none`.
    pub interval: &'static str,
    /// Blocks (or rows, where they stand alone) that count.
    pub n: u64,
    /// Blocks left out because a run of theirs has no number.
    pub left_out: u64,
    /// Why there is no number at all.
    pub without: Option<&'static str>,
    /// What a reader has to know.
    pub notes: Vec<String>,
}

impl Indices {
    /// The figures of a parameter.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&OfParameter> {
        self.of.iter().find(|(known, _)| known == name).map(|(_, of)| of)
    }
}

/// As `indices`: a map by parameter.
impl Serialize for Indices {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        let mut map = out.serialize_map(Some(self.of.len()))?;
        for (name, of) in &self.of {
            map.serialize_entry(name, of)?;
        }
        map.end()
    }
}

/// Why rows are not those of a design.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SensitivityError {
    /// There is no parameter.
    #[error("no parameter is uncertain")]
    Parameters,
    /// Something of the rows has another length.
    #[error("{what} has {found} entries, not {rows}")]
    Length {
        /// What it is.
        what: String,
        /// Its entries.
        found: usize,
        /// Rows.
        rows: usize,
    },
    /// A trajectory does not move each parameter once.
    #[error("trajectory {block} does not change each of {parameters} parameters once")]
    Moves {
        /// The trajectory, from 0.
        block: usize,
        /// Parameters.
        parameters: usize,
    },
    /// A row is of a part that there is not.
    #[error("row {row} is of part {found}, of {parts}")]
    Part {
        /// The row.
        row: usize,
        /// Its part.
        found: usize,
        /// Parts.
        parts: usize,
    },
}
