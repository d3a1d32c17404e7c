//! Differences between two values of a varied parameter.

use super::support::{less, mean, one, probability, quantile, ramp};
use bladeoff_answers::estimate::figures::Method;

#[test]
fn a_difference_is_that_of_pairs() {
    // a: even rows, b: odd rows; both increase together, so that only few points differ
    let study = ramp(2000).varied("way", &["a", "b"]);
    let found = one(&study, less(probability("y > 1000")));
    assert_eq!((found.n, found.estimate), (1000, Some(-0.001)));
    assert_eq!(found.method, Method::PairedClopperPearson);
    assert!(found.notes[0].contains("only the first at 0 points, only the second at 1"), "{:?}", found.notes);
    assert!(found.low.unwrap() > -0.008 && found.high.unwrap() > 0.0, "{found:?}");
    let found = one(&study, less(mean()));
    assert_eq!((found.estimate, found.low, found.high), (Some(-1.0), Some(-1.0), Some(-1.0)));
    let found = one(&study, less(quantile(0.5)));
    assert_eq!(found.estimate, Some(-1.0));
    // no point differs: an interval about 0 with a width of its own
    let same = one(&study, less(probability("y < 0")));
    assert_eq!((same.estimate, same.low.unwrap()), (Some(0.0), -same.high.unwrap()));
    assert!(same.high.unwrap() > 0.003);
    // clearly different
    let found = one(&study, less(probability("y - 2*floor(y/2) > 0.5")));
    assert!(found.estimate == Some(-1.0) && found.low == Some(-1.0) && found.high.unwrap() < -0.98, "{found:?}");
}

#[test]
fn figures_of_a_difference_take_bad_runs_of_both_alike_and_limits_do_not() {
    // 400 of 1000 points are events in both; ten of a failed that were no events, twenty of b
    let mut study = ramp(2000).varied("way", &["a", "b"]);
    (0..10).for_each(|point| study.fail(2 * point, "diverged"));
    (10..30).for_each(|point| study.fail(2 * point + 1, "diverged"));
    let found = one(&study, less(probability("y >= 1200")));
    assert_eq!((found.estimate, found.estimate_if_bad_harmful, found.bad), (Some(0.0), Some(-0.01), 30));
    let limits = (found.low.unwrap(), found.high.unwrap());
    assert!(limits.0 < -0.02 && limits.1 > 0.01, "{found:?}");
    let says = "way = a less b = 0 % with bad runs harmless, -1 % with bad runs harmful (";
    assert!(found.sentence.contains(says), "{}", found.sentence);
}

#[test]
fn a_bad_run_widens_a_difference_both_ways() {
    let mut study = ramp(2000).varied("way", &["a", "b"]);
    // a of point 5, b of point 6
    study.fail(10, "diverged");
    study.fail(13, "diverged");
    let found = one(&study, less(probability("y > 1000")));
    let plain = one(&ramp(2000).varied("way", &["a", "b"]), less(probability("y > 1000")));
    assert_eq!((found.estimate, found.bad), (Some(-0.001), 2));
    assert!(found.low < plain.low && found.high > plain.high);
    let found = one(&study, less(mean()));
    assert_eq!((found.estimate, found.low, found.high), (Some(-1.0), None, None));
    // only a is bad, in a growing column: its reached value is not a value
    let mut study = ramp(2000).varied("way", &["a", "b"]);
    study.fail(10, "diverged");
    study.columns[0].nature = '>';
    study.columns[0].held[10] = Some(10.0);
    let found = one(&study, less(mean()));
    assert_eq!((found.estimate, found.low, found.high), (Some(-1.0), None, None), "{found:?}");
}
