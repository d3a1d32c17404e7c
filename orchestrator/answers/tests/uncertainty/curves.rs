//! Exceedance and fragility curves.

use super::support::{ask, exceedance, near, probability, ramp};
use bladeoff_answers::ask::{Ask, Figure, Question, QuestionDef, answer_all};
use bladeoff_answers::estimate::figures::Method;
use bladeoff_answers::estimate::limits::upper_limit;

#[test]
fn an_exceedance_counts_values_above_each_level() {
    let mut study = ramp(100);
    study.fail(0, "diverged");
    let answered = ask(&study, exceedance());
    let curve = answered.curve.expect("a curve");
    let [level, estimate, harmful, low, high] = ["level", "estimate", "estimate_if_bad_harmful", "low", "high"]
        .map(|name| curve.numbers(name).unwrap().to_vec());
    assert_eq!((level.len(), level[0], level[98]), (99, Some(1.0), Some(99.0)));
    assert_eq!((estimate[0], harmful[0]), (Some(0.98), Some(0.99)));
    assert_eq!((estimate[98], harmful[98]), (Some(0.0), Some(0.01)));
    // one value above; two below, with the limit for three
    near(high[98], upper_limit(1, 100, 0.05 / 32.0));
    near(low[0], 1.0 - upper_limit(3, 100, 0.05 / 64.0));
    near(high[49], 0.5 + (80.0f64.ln() / 200.0).sqrt());
    assert_eq!(answered.answers[0].method, Method::Band);
    // thinned, with the largest values kept
    let curve = ask(&ramp(5000), exceedance()).curve.unwrap();
    let level = curve.numbers("level").unwrap();
    assert_eq!((level.len(), level[0], level[999], level[800]), (1000, Some(0.0), Some(4999.0), Some(4800.0)));
    assert_eq!(curve.numbers("estimate").unwrap()[800], Some(199.0 / 5000.0));
}

#[test]
fn a_fragility_has_bins_of_equal_count_or_each_value() {
    let study = ramp(1000);
    let def = |path: &str| QuestionDef { fragility: Some(path.into()), ..probability("y > 500") };
    let answered = ask(&study, def("u"));
    let curve = answered.curve.unwrap();
    assert_eq!(curve.numbers("from").unwrap()[..3], [Some(0.0), Some(50.0), Some(100.0)]);
    assert!(curve.numbers("n").unwrap().iter().all(|n| *n == Some(50.0)));
    assert_eq!(curve.numbers("events").unwrap()[9..12], [Some(0.0), Some(49.0), Some(50.0)]);
    assert!(curve.numbers("high").unwrap()[0].unwrap() > 0.05, "no event bounds");
    assert!(answered.answers[0].notes[0].contains("20 bins of equal count"));
    let one = ask(&ramp(60), def("u"));
    assert_eq!(one.answers[0].notes[0], "one bin contains all points: a bin has at least 50");
    // few points do not mean few values
    let few = ask(&ramp(15), def("u"));
    assert_eq!(few.answers[0].notes[0], "one bin contains all points: a bin has at least 50");
    assert_eq!(few.curve.unwrap().numbers("n").unwrap(), [Some(15.0)]);
    // few values
    let mut study = ramp(1000);
    study.columns[1].cells = (0..1000).map(|row| Some((row % 4) as f64)).collect();
    study.fail(3, "diverged");
    let curve = ask(&study, def("u")).curve.unwrap();
    assert_eq!(curve.numbers("from").unwrap(), [0.0, 1.0, 2.0, 3.0].map(Some));
    assert_eq!(curve.numbers("bad").unwrap(), [0.0, 0.0, 0.0, 1.0].map(Some));
    // varied
    let study = ramp(1000).varied("way", &["a", "b"]);
    let answered = ask(&study, def("way"));
    assert_eq!((answered.answers.len(), answered.answers[0].n), (1, 1000));
    assert_eq!(answered.curve.unwrap().numbers("events").unwrap(), [Some(249.0), Some(250.0)]);
}

#[test]
fn a_question_without_its_column_loses_no_other() {
    let study = ramp(100);
    let missing = Question { name: "missing".into(), ask: Ask::One(Figure::Mean("gone".into())), confidence: 0.95 };
    let there = Question { name: "there".into(), ask: Ask::One(Figure::Mean("y".into())), confidence: 0.95 };
    let study = study.study();
    let (answers, _) = answer_all(&study, &[missing, there]).expect("columns fit together");
    let [gone, there] = &answers.answers[..] else { panic!("{answers:?}") };
    assert_eq!((gone.estimate, gone.low, gone.kind), (None, None, "mean"));
    assert_eq!(gone.notes, ["not answered: the table has no column gone"]);
    near(there.estimate, 49.5);
}
