//! Sensitivities within regimes: the drivers of the regime may differ from the drivers of the output within a regime.
//!
//! Rows are split by a column of words (such as the rub regime), and each sufficiently large part has its own indices. Within a regime the
//! parameters are no longer independent, because the regime is a result. Only estimators that need no design are applied, and they describe
//! the rows of the regime. Trajectories and base points are not split: the remaining blocks would not be a random sample of effects.

use super::blocks::percent;
use super::given::{Given, Input, Parts, given_data};
use super::indices::{Indices, SensitivityError};
use std::collections::BTreeMap;

/// Smallest number of rows, and smallest share of rows, of a regime with its own indices.
const FEWEST: usize = 32;
const LEAST: f64 = 0.05;

/// The rows of one regime.
#[derive(Debug, Clone, PartialEq)]
pub struct Regime {
    /// Name of the regime.
    pub word: String,
    /// Row indices.
    pub rows: Vec<usize>,
    /// Share among all rows with a number and a regime.
    pub share: f64,
}

/// Sufficiently large regimes in descending order of size, then by name; rows without a number or a regime are ignored.
#[must_use]
pub fn regimes(words: &[Option<String>], output: &[Option<f64>]) -> Vec<Regime> {
    let mut found: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    let mut all = 0usize;
    for (row, (word, value)) in words.iter().zip(output).enumerate() {
        let (Some(word), Some(_)) = (word, super::blocks::number(*value)) else { continue };
        all += 1;
        found.entry(word).or_default().push(row);
    }
    let regime = |(word, rows): (&str, Vec<usize>)| Regime {
        word: word.to_owned(),
        share: rows.len() as f64 / all as f64,
        rows,
    };
    let counts = |regime: &Regime| regime.rows.len() >= FEWEST && regime.share >= LEAST;
    let mut found: Vec<Regime> = found.into_iter().map(regime).filter(counts).collect();
    found.sort_by(|a, b| b.rows.len().cmp(&a.rows.len()).then_with(|| a.word.cmp(&b.word)));
    found
}

/// Note on indices over all rows, if there are several regimes.
#[must_use]
pub fn warning(regimes: &[Regime]) -> Option<String> {
    let told: Vec<String> = regimes.iter().map(|regime| format!("{} {}", regime.word, percent(regime.share))).collect();
    (regimes.len() > 1).then(|| {
        format!(
            "runs belong to {} regimes ({}): indices over all runs mainly describe what determines the regime, and \
             little of the output within one regime",
            regimes.len(),
            told.join(", ")
        )
    })
}

/// Indices within each regime.
///
/// # Errors
/// Columns have different lengths.
pub fn by_regime(
    given: &Given<'_>,
    words: &[Option<String>],
    alpha: f64,
) -> Result<Vec<(Regime, Indices)>, SensitivityError> {
    let rows = given.output.len();
    if words.len() != rows {
        return Err(SensitivityError::Length { what: "regimes".to_owned(), found: words.len(), rows });
    }
    super::given::check(given)?;
    let one = |regime: Regime| {
        let picked: Vec<Vec<f64>> =
            given.inputs.iter().map(|input| regime.rows.iter().map(|row| input.values[*row]).collect()).collect();
        let output: Vec<Option<f64>> = regime.rows.iter().map(|row| given.output[*row]).collect();
        let parts: Vec<u32> = match &given.parts {
            Parts::Replicates(of, _) => regime.rows.iter().map(|row| of[*row]).collect(),
            _ => Vec::new(),
        };
        let inputs = given.inputs.iter().zip(&picked);
        let part = Given {
            inputs: inputs
                .map(|(input, values)| Input { name: input.name.clone(), values, has_words: input.has_words })
                .collect(),
            output: &output,
            parts: match &given.parts {
                Parts::Replicates(_, count) => Parts::Replicates(&parts, *count),
                other => other.clone(),
            },
        };
        let mut found = given_data(&part, alpha)?;
        found
            .notes
            .push("within a regime the parameters are not independent: the indices describe its runs alone".to_owned());
        Ok((regime, found))
    };
    regimes(words, given.output).into_iter().map(one).collect()
}
