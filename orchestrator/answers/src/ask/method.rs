//! Estimators of sensitivity, and the designs that each of them needs.

use crate::estimate::input::DesignKind;
use crate::estimate::scheme::FEWEST_REPLICATES;

/// Estimator of a sensitivity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensitivityMethod {
    /// Elementary effects from Morris trajectories.
    Morris,
    /// Variance shares from a Saltelli design.
    Sobol,
    /// Variance shares from any random sample, without a special design.
    GivenData,
}

impl SensitivityMethod {
    /// All estimators with their words in a study file.
    pub const ALL: [(&'static str, Self); 3] =
        [("morris", Self::Morris), ("sobol", Self::Sobol), ("given-data", Self::GivenData)];

    /// Word of the estimator in a study file.
    #[must_use]
    pub fn word(self) -> &'static str {
        Self::ALL.iter().find(|(_, known)| *known == self).map_or("", |(word, _)| *word)
    }

    /// Checks that the method is valid for points of this kind, in so many replicates.
    ///
    /// `given-data` compares a row with its neighbour in a column. Within one low-discrepancy sequence the other coordinates of
    /// neighbours depend on each other, so first orders are biased. With at least [`FEWEST_REPLICATES`] replicates nearly every
    /// neighbour belongs to another, independent replicate.
    ///
    /// # Errors
    /// The method is not valid; the message names the designs that it needs.
    pub fn check(self, kind: DesignKind, replicates: usize) -> Result<(), String> {
        let needs = |word: &str| Err(format!("method {:?} needs points of kind {word:?}", self.word()));
        match (self, kind) {
            (Self::Morris, DesignKind::Morris) | (Self::Sobol, DesignKind::Saltelli) => Ok(()),
            (Self::Morris, _) => needs(DesignKind::Morris.word()),
            (Self::Sobol, _) => needs(DesignKind::Saltelli.word()),
            (Self::GivenData, DesignKind::Morris | DesignKind::OneAtATime | DesignKind::Saltelli) => {
                Err(format!("method {:?} needs a sample of the distributions, such as \"monte-carlo\"", self.word()))
            }
            (Self::GivenData, DesignKind::Sobol | DesignKind::Halton) if replicates < FEWEST_REPLICATES => {
                return Err(format!(
                    "method {:?} needs independent points: first orders from {replicates} replicate{} of kind {:?} are biased; \
                     use kind \"monte-carlo\" or \"latin-hypercube\", or at least {FEWEST_REPLICATES} replicates",
                    self.word(),
                    if replicates == 1 { "" } else { "s" },
                    kind.word()
                ));
            }
            (Self::GivenData, _) => Ok(()),
        }
        .map_err(|why| format!("{why}, and those of this study are of kind {:?}", kind.word()))
    }
}

/// Definition of a sensitivity question.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// Output: a column of numbers.
    pub output: String,
    /// Estimator.
    pub method: SensitivityMethod,
    /// Columns of the uncertain parameters, in the order of the study.
    pub parameters: Vec<String>,
    /// Text column that assigns runs to regimes, if the table has one.
    pub regime: Option<String>,
}
