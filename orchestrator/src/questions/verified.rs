//! Known probabilities computed through a study of formulas, from its text to its answers, for `bladeoff verify`: distributions, their dependence,
//! formulas and estimates. `tests/program/probabilities.rs` does the same through workers, record and table.
//!
//! An estimate from n independent points has the standard error sqrt(p (1 - p)/n); it deviates by more than four standard errors once in 16 000 cases.
//! The points are always the same.

use super::vocabulary::Vocabulary;
use super::{Meant, Source, meant};
use crate::run::own_columns;
use bladeoff_answers::ask::answer;
use bladeoff_answers::estimate::input::{Cells, Column, Design, DesignKind, Ended, Layout, Nature, Study};
use bladeoff_core::verification::{Check, NO_RUN};
use bladeoff_model::outcome::{CauseSet, Status};
use bladeoff_study::{Samples, load_text};

const STUDY: &str = r#"schema = 1
model = "function"
seed = 22

[design]
kind = "monte-carlo"
samples = 131072

[function]
rp22 = "2.5 - (x1 + x2)/sqrt(2) + 0.1*(x1 - x2)^2"
branches = "min(3 + 0.1*(x1 - x2)^2 - abs(x1 + x2)/sqrt(2), 7/sqrt(2) - abs(x1 - x2))"
margin = "r - s"
product = "a*b"
largest = "max(g1, g2, g3)"

[[uncertain]]
name = "x1"
distribution = "normal"
mean = 0
sd = 1
[[uncertain]]
name = "x2"
distribution = "normal"
mean = 0
sd = 1
[[uncertain]]
name = "r"
distribution = "normal"
mean = 4
sd = 1
[[uncertain]]
name = "s"
distribution = "normal"
mean = 2
sd = 1
[[uncertain]]
name = "a"
distribution = "lognormal"
median = 1
cv = 0.3
[[uncertain]]
name = "b"
distribution = "lognormal"
median = 2
cv = 0.5
[[uncertain]]
name = "g1"
distribution = "gumbel"
location = 10
scale = 2
[[uncertain]]
name = "g2"
distribution = "gumbel"
location = 10
scale = 2
[[uncertain]]
name = "g3"
distribution = "gumbel"
location = 10
scale = 2

[[correlation]]
between = ["r", "s"]
linear = 0.5
[[correlation]]
between = ["a", "b"]
linear = 0.4

[[question]]
name = "rp22"
probability = "rp22 < 0"
[[question]]
name = "branches"
probability = "branches < 0"
[[question]]
name = "margin"
probability = "margin < 0"
[[question]]
name = "product"
probability = "product > 10"
[[question]]
name = "largest"
probability = "largest > 22"
"#;

/// Case, event, probability, and origin of the probability; in the order of the questions.
const REFERENCES: [(&str, &str, f64, &str); 5] = [
    ("RP22, two normal variables", "P(g < 0)", 4.207_305_511_300e-3, "TNO reliability challenge 2019, integrated"),
    ("four branches, 7/sqrt 2", "P(g < 0)", 2.222_795_066_194e-3, "Waarts 2000, integrated"),
    ("R - S, correlation 0.5", "P(g < 0)", 2.275_013_194_818e-2, "closed form: normal"),
    // the logarithm has the mean ln 2 and the variance ln 1.09 + ln 1.25 + 2 ln 1.06
    ("product of dependent lognormals", "P(a b > 10)", 6.826_347_478_649e-3, "closed form: lognormal"),
    // 1 - exp(-3 e^-6)
    ("largest of three Gumbel variables", "P(max > 22)", 7.408_675_982_096e-3, "closed form: Gumbel"),
];

/// Every reference with the estimate of this study; without an estimate if the study gives none.
#[must_use]
pub fn known_probabilities() -> Vec<Check> {
    let estimates = estimates();
    let check = |(at, (case, quantity, reference, source)): (usize, (&'static str, &str, f64, &'static str))| {
        let (n, ours) = estimates.as_ref().and_then(|found| found.get(at).copied()).unwrap_or((1, None));
        let tolerance = 4.0 * ((1.0 - reference) / (reference * n as f64)).sqrt();
        Check { case, engine: NO_RUN, quantity: quantity.to_owned(), ours, reference, tolerance, unit: "", source }
    };
    REFERENCES.into_iter().enumerate().map(check).collect()
}

/// Number of points and estimate of each question.
fn estimates() -> Option<Vec<(u64, Option<f64>)>> {
    let study = load_text("verify.toml", STUDY, own_columns).ok()?;
    let samples = Samples::new(study, None, None).ok()?;
    let source = Source { file: "verify.toml", text: STUDY, asked: &samples.study().asked };
    let Meant { questions, .. } = meant(&samples, source).ok()?;
    let outputs = &samples.study().function()?.outputs;
    let points = usize::try_from(samples.points()).ok()?;
    let mut cells = vec![vec![None; points]; outputs.len()];
    let (mut params, mut stack) = (Vec::new(), Vec::new());
    for point in 0..points {
        params.clear();
        samples.params(point as u64, &mut params);
        for (output, cells) in outputs.iter().zip(&mut cells) {
            cells[point] = Some(output.program.value(|number| params[number], &mut stack));
        }
    }
    let columns = outputs.iter().zip(&cells).map(|(output, cells)| Column {
        name: output.name.clone(),
        unit: String::new(),
        cells: Cells::Numbers(cells, Nature::Free),
        unjudged: false,
    });
    let (status, causes, replicate) = (vec![Status::Ok; points], vec![CauseSet::default(); points], vec![0; points]);
    let ends = vec![Ended::Other; points];
    let study = Study {
        columns: columns.collect(),
        status: &status,
        causes: &causes,
        ends: &ends,
        groups: Vocabulary::of(&samples)?.groups,
        design: Design {
            kind: DesignKind::MonteCarlo,
            scrambled: true,
            replicates: 1,
            replicate: &replicate,
            complete: true,
            layout: Layout::Points,
            share: 1.0,
            refined: false,
        },
    };
    study.check().ok()?;
    let one = |question| {
        let found = answer(&study, question).ok()?.answers.into_iter().next()?;
        Some((found.n, found.estimate))
    };
    questions.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_probabilities_are_found_within_four_standard_errors() {
        let checks = known_probabilities();
        assert_eq!(checks.len(), 5);
        for mut check in checks {
            println!("{check:?}: {:?}", check.error());
            assert!(check.holds() && check.tolerance < 0.25, "{check:?}");
            // a reference that is 50 % too large is detected
            check.reference *= 1.5;
            assert!(!check.holds(), "{check:?}");
        }
    }
}
