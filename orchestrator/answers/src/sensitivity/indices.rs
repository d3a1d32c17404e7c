//! Sensitivity indices by parameter, as written to `indices` in `answers.json`.

use serde::ser::{Serialize, SerializeMap, Serializer};

/// An estimate with its interval; null if a number is missing.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Index {
    /// Estimate.
    pub estimate: Option<f64>,
    /// Lower limit.
    pub low: Option<f64>,
    /// Upper limit.
    pub high: Option<f64>,
}

impl Index {
    /// An estimate without an interval.
    #[must_use]
    pub fn alone(estimate: Option<f64>) -> Self {
        Self { estimate, low: None, high: None }
    }

    /// Estimate for ranking; `None` if the index has no interval.
    #[must_use]
    pub fn ranking(&self) -> Option<f64> {
        self.estimate.filter(|_| self.low.is_some() && self.high.is_some())
    }
}

/// Evidence that an output depends on a parameter in any form.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Hsic {
    /// HSIC(x, y)/sqrt(HSIC(x, x) HSIC(y, y)), 0 to 1.
    pub normalised: f64,
    /// Probability of at least this value without a dependence, for each parameter separately.
    pub p_value: f64,
}

/// Indices of a parameter; indices of other methods are `None`.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct OfParameter {
    /// Mean of the magnitudes of the elementary effects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu_star: Option<Index>,
    /// Mean of the elementary effects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu: Option<Index>,
    /// Standard deviation of the elementary effects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma: Option<Index>,
    /// First-order index: share of the variance caused by the parameter alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first: Option<Index>,
    /// Total index: share of the variance including all interactions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub total: Option<Index>,
    /// Spearman's rank correlation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spearman: Option<Index>,
    /// Coefficient of the standardised rank regression.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rank_regression: Option<Index>,
    /// Dependence in any form.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hsic: Option<Hsic>,
}

/// Second-order index: share of the variance caused by the interaction of two parameters.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Pair {
    /// Names of the parameters.
    pub between: [String; 2],
    /// Second-order index.
    pub second: Index,
}

/// Result of an estimator.
#[derive(Debug, Clone, PartialEq)]
pub struct Indices {
    /// Indices of each parameter, in the order of the study.
    pub of: Vec<(String, OfParameter)>,
    /// Second-order indices, if the design allows them.
    pub pairs: Vec<Pair>,
    /// Share of the variance of the output's ranks explained by the rank regression.
    pub r2: Option<Index>,
    /// Method of the intervals: `bootstrap`, `replicates-t` or `none`.
    pub interval: &'static str,
    /// Blocks, or independent rows, that were used.
    pub n: u64,
    /// Blocks excluded because one of their runs has no number.
    pub left_out: u64,
    /// Reason why there is no number at all.
    pub without: Option<&'static str>,
    /// Reservations and remarks for the reader.
    pub notes: Vec<String>,
}

impl Indices {
    /// Indices of a parameter.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&OfParameter> {
        self.of.iter().find(|(known, _)| known == name).map(|(_, of)| of)
    }
}

/// Serialised as a map by parameter.
impl Serialize for Indices {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        let mut map = out.serialize_map(Some(self.of.len()))?;
        for (name, of) in &self.of {
            map.serialize_entry(name, of)?;
        }
        map.end()
    }
}

/// Reason why rows do not fit a design.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SensitivityError {
    /// A study without uncertain parameters.
    #[error("no parameter is uncertain")]
    Parameters,
    /// A column whose length differs from the number of rows.
    #[error("{what} has {found} entries, not {rows}")]
    Length {
        /// Name of the column.
        what: String,
        /// Number of its entries.
        found: usize,
        /// Number of rows.
        rows: usize,
    },
    /// A trajectory that does not change each parameter exactly once.
    #[error("trajectory {block} does not change each of {parameters} parameters once")]
    Moves {
        /// Index of the trajectory, from 0.
        block: usize,
        /// Number of parameters.
        parameters: usize,
    },
    /// A row with a part number that does not exist.
    #[error("row {row} is of part {found}, of {parts}")]
    Part {
        /// Row index.
        row: usize,
        /// Its part number.
        found: usize,
        /// Number of parts.
        parts: usize,
    },
}
