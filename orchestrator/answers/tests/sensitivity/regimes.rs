//! Outputs of several regimes.

use super::support::{figure, names, near, points};
use bladeoff_answers::sensitivity::{Given, Input, Parts, SensitivityError, by_regime, given_data, regimes, warning};

/// The first parameter determines whether there is a rub, the second its severity, the third the output without a rub.
fn made() -> (Vec<Vec<f64>>, Vec<Option<f64>>, Vec<Option<String>>) {
    let base = points(21, 2000, 3);
    let columns = (0..3).map(|i| base.iter().map(|u| u[i]).collect()).collect();
    let rubs = |u: &[f64]| u[0] > 0.6;
    let output = base.iter().map(|u| Some(if rubs(u) { 10.0 + u[1] } else { u[2] })).collect();
    let word = |(row, u): (usize, &Vec<f64>)| {
        let word = if row % 500 == 0 {
            "rare"
        } else if rubs(u) {
            "heavy"
        } else {
            "none"
        };
        Some(word.to_owned())
    };
    (columns, output, base.iter().enumerate().map(word).collect())
}

fn given<'a>(columns: &'a [Vec<f64>], output: &'a [Option<f64>]) -> Given<'a> {
    let input = |(name, values)| Input { name, values, has_words: false };
    let inputs = names(3).into_iter().zip(columns.iter().map(Vec::as_slice)).map(input).collect();
    Given { inputs, output, parts: Parts::Independent }
}

#[test]
fn what_decides_the_regime_is_not_what_decides_within_one() {
    let (columns, output, words) = made();
    let table = given(&columns, &output);
    let all = given_data(&table, 0.05).expect("figures");
    near(figure(&all, 0, |of| of.first), 1.0, 0.05);
    let found = by_regime(&table, &words, 0.05).expect("figures");
    let told: Vec<&str> = found.iter().map(|(regime, _)| regime.word.as_str()).collect();
    assert_eq!(told, ["none", "heavy"], "four rows of a word are no regime");
    near(figure(&found[0].1, 2, |of| of.first), 1.0, 0.05);
    near(figure(&found[1].1, 1, |of| of.first), 1.0, 0.05);
    near(figure(&found[1].1, 0, |of| of.first), 0.0, 0.15);
    assert!((found[0].0.share - 0.6).abs() < 0.04 && found[0].0.rows.len() as u64 == found[0].1.n);
    assert!(found[0].1.notes.iter().any(|note| note.contains("not independent")));
    let said = warning(&regimes(&words, &output)).expect("a warning");
    assert!(said.starts_with("runs belong to 2 regimes (none 6") && said.contains("heavy"), "{said}");
}

#[test]
fn one_regime_needs_no_warning_and_bad_runs_are_in_none() {
    let (columns, mut output, words) = made();
    for (value, word) in output.iter_mut().zip(&words) {
        if word.as_deref() == Some("heavy") {
            *value = None;
        }
    }
    let found = regimes(&words, &output);
    assert_eq!((found.len(), warning(&found)), (1, None));
    let short = by_regime(&given(&columns, &output), &words[1..], 0.05);
    assert!(matches!(short, Err(SensitivityError::Length { found: 1999, rows: 2000, .. })), "{short:?}");
}
