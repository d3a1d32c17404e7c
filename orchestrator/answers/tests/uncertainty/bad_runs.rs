//! Bad runs and empty cells: none of them is dropped.

use super::support::made::caused;
use super::support::{ask, exceedance, less, made, mean, one, probability, quantile, ramp};
use bladeoff_answers::ask::Answer;

#[test]
fn bad_runs_are_counted_both_ways_but_for_what_they_had_reached() {
    let mut study = ramp(100);
    study.columns[0].nature = '>';
    // 90 .. 99 are events; of the first eight, which failed
    (0..8).for_each(|row| study.fail(row, "diverged"));
    study.columns[0].held[0] = Some(95.0);
    study.columns[0].held[1] = Some(20.0);
    // values of a failed row beyond the held one do not count, unless only a step limit ended the run
    study.columns[0].cells[2] = Some(99.0);
    study.columns[0].cells[3] = Some(99.0);
    study.causes[3] = caused("step_limit");
    study.columns[0].cells[4] = Some(99.0);
    study.causes[4] = caused("step_limit,energy_balance");
    let found = one(&study, probability("y >= 90"));
    assert_eq!((found.n, found.events, found.bad), (100, Some(12), 8));
    assert_eq!((found.estimate, found.estimate_if_bad_harmful), (Some(0.12), Some(0.18)));
    let limits = |k: u64| one(&ramp(100), probability(&format!("y < {k}")));
    assert_eq!((found.low, found.high), (limits(12).low, limits(18).high));
    assert_eq!(
        found.sentence,
        "P(y >= 90) = 12 % to 18 % (95 %: 6.4 % to 27 %), 12 of 100, 6 bad runs undecided (the interval covers all possible outcomes), \
         2 bad runs counted by the values reached before a guard or limit was exceeded"
    );
    // the reverse: a value that has grown beyond a bound is not below it
    let below = one(&study, probability("y < 50"));
    assert_eq!((below.estimate, below.estimate_if_bad_harmful), (Some(0.42), Some(0.48)));
    // parameters of bad runs are known
    let given = one(&study, probability("u < 4"));
    assert_eq!((given.estimate, given.estimate_if_bad_harmful), (Some(0.04), Some(0.04)));
    let both = one(&study, probability("u < 4 and y > 1000"));
    assert_eq!((both.estimate, both.estimate_if_bad_harmful), (Some(0.0), Some(0.04)));
}

#[test]
fn a_span_of_bad_runs_wider_than_the_statistical_one_is_said() {
    let mut study = ramp(1000);
    (0..10).for_each(|row| study.fail(row, "diverged"));
    let said = |answer: &Answer| answer.notes.iter().any(|note| note.contains("cause most of the uncertainty"));
    assert!(!said(&one(&study, probability("y > 500"))));
    (0..100).for_each(|row| study.fail(row, "diverged"));
    assert!(said(&one(&study, probability("y > 500"))));
    // the same in a difference, where bad runs of both values may cancel in the figures
    let found = one(&study.varied("way", &["a", "b"]), less(probability("y > 500")));
    assert!(said(&found) && found.estimate == found.estimate_if_bad_harmful, "{found:?}");
}

#[test]
fn a_value_that_does_not_exist_counts_both_ways_in_bad_runs_too() {
    // u is -2 .. 7 and known; where u is negative its logarithm y, a derived input, does not exist, and the run failed
    let mut study = ramp(10);
    (0..10).for_each(|row| study.columns[1].cells[row] = Some(row as f64 - 2.0));
    study.columns[0].nature = 'g';
    (0..10).for_each(|row| study.columns[0].cells[row] = (row > 2).then(|| (row as f64 - 2.0).ln()));
    (0..3).for_each(|row| study.fail(row, "non_finite"));
    for text in ["ln(u - 0.5) > 0", "not (ln(u - 0.5) <= 0)", "y > -1", "not (y <= -1)", "y != 3", "not (y == 3)"] {
        let found = one(&study, probability(text));
        let (low, high) = (found.estimate.unwrap(), found.estimate_if_bad_harmful.unwrap());
        assert!((high - low - 0.3).abs() < 1e-12 && found.bad == 3, "{text}: {}", found.sentence);
        assert!(
            found.sentence.contains("3 bad runs undecided (the interval covers all possible outcomes)"),
            "{text}: {}",
            found.sentence
        );
    }
    // the other term determines the condition
    let either = one(&study, probability("u < 0 or y > 100"));
    assert_eq!((either.estimate, either.estimate_if_bad_harmful), (Some(0.2), Some(0.3)));
    let (mean, level) = (one(&study, mean()), one(&study, quantile(0.5)));
    assert_eq!((mean.estimate_if_bad_harmful, mean.low, mean.high), (None, None, None), "{}", mean.sentence);
    assert_eq!((level.n, level.bad), (10, 3), "{}", level.sentence);
    let curve = ask(&study, exceedance()).curve.unwrap();
    // the largest level, which no ok run exceeds
    assert_eq!(curve.numbers("estimate_if_bad_harmful").unwrap().last(), Some(&Some(0.3)));
    for answer in [mean, level, ask(&study, exceedance()).answers.remove(0)] {
        assert!(!answer.notes.iter().any(|note| note.contains("a column has no value")), "{:?}", answer.notes);
    }
}

#[test]
fn a_formula_that_may_lose_its_value_is_not_certain() {
    // reached 3: the complete run might exceed 5, where the root has no value
    let mut study = ramp(4);
    study.columns[0].nature = '>';
    study.fail(3, "diverged");
    study.columns[0].held[3] = Some(3.0);
    let found = one(&study, probability("sqrt(5 - y) > 2"));
    assert_eq!((found.estimate, found.estimate_if_bad_harmful), (Some(0.25), Some(0.5)));
}

#[test]
fn a_span_that_moves_the_figure_further_than_the_interval_is_said() {
    // near 1 the limits have little room, but the figure changes: 17 of 32, or all
    let mut study = ramp(32);
    (0..15).for_each(|row| study.fail(row, "diverged"));
    for text in ["y >= 15", "y < -1 or y >= 15"] {
        let found = one(&study, probability(text));
        let span = found.estimate_if_bad_harmful.unwrap() - found.estimate.unwrap();
        assert!(
            span > 0.46 && found.notes.iter().any(|note| note.contains("cause most of the uncertainty")),
            "{text}: {found:?}"
        );
    }
}

#[test]
fn empty_cells_compare_with_nothing_and_are_counted() {
    let study = made(&[1.0, f64::NAN, 3.0, f64::NAN]);
    let found = one(&study, probability("y > 0"));
    assert_eq!((found.n, found.events), (4, Some(2)));
    assert!(found.notes[0].contains("in 2 runs a column has no value"), "{:?}", found.notes);
    assert_eq!(one(&study, probability("not y > 0")).events, Some(2));
    let found = one(&study, mean());
    assert_eq!((found.n, found.estimate), (2, Some(2.0)));
    assert!(found.notes.iter().any(|note| note.contains("in 2 runs") && note.contains("not included")));
    assert_eq!(one(&study, quantile(0.5)).n, 2);
    // share of all runs
    let curve = ask(&study, exceedance()).curve.unwrap();
    assert_eq!(curve.numbers("estimate").unwrap(), [Some(0.25), Some(0.0)]);
}

#[test]
fn bad_runs_stand_at_both_ends_of_a_quantile() {
    let mut study = ramp(1000);
    (0..20).for_each(|row| study.fail(row, "diverged"));
    let found = one(&study, quantile(0.95));
    assert_eq!((found.n, found.bad), (1000, 20));
    // 20 at the lower end: unchanged; at the upper end the other values shift down by 20 ranks
    assert_eq!((found.estimate, found.estimate_if_bad_harmful), (Some(949.0), Some(969.0)));
    assert!(found.low.unwrap() < 949.0 && found.high.unwrap() > 969.0);
    (0..60).for_each(|row| study.fail(row, "diverged"));
    let found = one(&study, quantile(0.95));
    assert_eq!((found.estimate_if_bad_harmful, found.high), (None, None));
    assert!(found.estimate.is_some() && found.low.is_some());
    assert!(found.notes.iter().any(|note| note.contains("failed or invalid runs may have any value")));
    assert_eq!(found.bad, 60);
    // reached values are lower bounds, not values
    study.columns[0].nature = '>';
    (0..60).for_each(|row| study.columns[0].held[row] = Some(2000.0));
    assert_eq!(one(&study, quantile(0.95)), found);
}
