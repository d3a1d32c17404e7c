//! Runs beyond the model: their reached values are lower bounds.

use super::support::made::Made;
use super::support::{ask, exceedance, less, mean, near, one, probability, quantile, ramp};
use bladeoff_answers::ask::{Answers, Known, Names, Question, QuestionDef, SCHEMA, answer};
use bladeoff_answers::gate::{Gate, Verdict};
use bladeoff_answers::stop::{Hindrance, StopRule};
use bladeoff_model::outcome::Status;

const LIMIT: &str = "ring_displacement";

/// A study with y = 0, 1, 2 ..., whose `beyond` largest runs ended at a limit of the model, each at its value.
fn ended(count: usize, beyond: usize) -> Made {
    let mut study = ramp(count);
    study.columns[0].nature = '>';
    for row in count - beyond..count {
        study.exceed(row, LIMIT, true);
        study.columns[0].held[row] = study.columns[0].cells[row];
    }
    study
}

/// Times of the first limit, in the first `beyond` rows and in no other.
fn timed(count: usize, beyond: usize) -> Made {
    let mut study = Made::new(vec![("y", (0..count).map(|row| (row < beyond).then_some(0.1)).collect())]);
    study.columns[0].nature = 'l';
    (0..beyond).for_each(|row| study.exceed(row, LIMIT, true));
    study
}

#[test]
fn a_run_beyond_the_model_decides_an_exceedance_below_what_it_had_reached() {
    // 90 .. 99 ended at their limit; 95 .. 99 had reached 95 for certain
    let study = ended(100, 10);
    let above = one(&study, probability("y > 94.5"));
    assert_eq!((above.n, above.events, above.bad, above.beyond), (100, Some(5), 10, 10));
    assert_eq!((above.estimate, above.estimate_if_bad_harmful), (Some(0.05), Some(0.1)));
    let limits = |k: u64| one(&ramp(100), probability(&format!("y < {k}")));
    assert_eq!((above.low, above.high), (limits(5).low, limits(10).high));
    assert_eq!(
        above.sentence,
        "P(y > 94.5) = 5 % to 10 % (95 %: 1.6 % to 18 %), 5 of 100, 5 runs beyond the model undecided (the interval covers all possible outcomes), \
         5 runs beyond the model counted by the values reached before a guard or limit was exceeded"
    );
    // all of them exceed lower levels
    let decided = one(&study, probability("y > 80"));
    assert_eq!((decided.estimate, decided.estimate_if_bad_harmful), (Some(0.19), Some(0.19)));
    // and none is certainly below any level
    let below = one(&study, probability("y < 1000"));
    assert_eq!((below.estimate, below.estimate_if_bad_harmful), (Some(0.9), Some(1.0)));
}

/// The time of a limit is exact in the runs that have one: it leaves the mean of these times closed.
#[test]
fn the_mean_of_the_times_of_a_limit_is_not_undecided() {
    let mut study = timed(60, 46);
    for row in 0..46 {
        study.columns[0].cells[row] = Some(0.1 + 0.37 * (row as f64).sin().abs());
        study.columns[0].held[row] = study.columns[0].cells[row];
    }
    let found = one(&study, mean());
    assert!(
        found.low.is_some() && found.high.is_some() && found.estimate == found.estimate_if_bad_harmful,
        "{found:?}"
    );
    assert!(found.beyond == 46 && !found.sentence.contains("undecided"), "{}", found.sentence);
}

#[test]
fn a_column_without_a_guarded_value_stands_where_its_run_ended_at_the_limit() {
    let mut study = ramp(10);
    study.columns[0].nature = '>';
    // 8 ended at its limit; 9 continued beyond it, so its value is not valid
    study.exceed(8, LIMIT, true);
    study.exceed(9, LIMIT, false);
    let found = one(&study, probability("y > 6.5"));
    assert_eq!((found.estimate, found.estimate_if_bad_harmful), (Some(0.2), Some(0.3)));
    // events before the end at the limit have happened; others might still have come
    study.columns[0].nature = 'o';
    let once = one(&study, probability("y > 6.5"));
    assert_eq!((once.estimate, once.estimate_if_bad_harmful), (Some(0.2), Some(0.3)));
    study.columns[0].cells[8] = None;
    let later = one(&study, probability("y > 6.5"));
    assert_eq!((later.estimate, later.estimate_if_bad_harmful), (Some(0.1), Some(0.3)));
}

#[test]
fn a_quantile_above_the_share_inside_the_model_has_a_lower_limit_only() {
    let study = ended(1000, 170);
    let high = one(&study, quantile(0.95));
    assert_eq!((high.n, high.bad, high.beyond), (1000, 170, 170));
    assert_eq!((high.estimate, high.estimate_if_bad_harmful, high.high), (Some(949.0), None, None));
    // reached values count: the lower limit is that of the whole ramp
    assert_eq!(high.low, one(&ramp(1000), quantile(0.95)).low);
    assert!(high.sentence.contains(": at least 949 in these runs (lower limit "), "{}", high.sentence);
    assert!(high.sentence.contains("no upper limit), 1000 runs, 170 runs beyond the model"), "{}", high.sentence);
    assert!(
        high.notes
            .iter()
            .any(|note| note.contains("17 % of the runs are beyond the model, so quantiles above 83 % have")),
        "{:?}",
        high.notes
    );
    // too few for any limit: the reached values are a lower bound nevertheless
    let few = one(&ended(3, 2), quantile(0.5));
    assert!(few.low.is_none() && few.sentence.contains(": at least 1 in these runs (no interval)"), "{}", few.sentence);
    // below that share both limits exist
    let middle = one(&study, quantile(0.5));
    assert_eq!((middle.estimate, middle.estimate_if_bad_harmful), (Some(499.0), Some(499.0)));
    assert!(middle.low.is_some() && middle.high.is_some());
    // if most runs are beyond, only the reached values are known
    let most = one(&ended(1000, 700), quantile(0.5));
    assert!(most.low == middle.low && most.high.is_none(), "{}", most.sentence);
}

#[test]
fn a_mean_is_that_of_the_runs_inside_the_model_and_says_so() {
    let study = ended(100, 17);
    let found = one(&study, mean());
    near(found.estimate, 41.0);
    assert_eq!((found.estimate_if_bad_harmful, found.low, found.high), (None, None, None));
    let says = "mean of y of runs inside the model (83 %) = 41 (no interval), 100 runs, 17 runs beyond the model";
    assert_eq!(found.sentence, says);
    assert!(found.notes.iter().any(|note| note.contains("a run beyond the model may have any value")));
    // inputs are known for all runs
    let mut given = ended(100, 17);
    given.columns[0].nature = 'g';
    let found = one(&given, mean());
    assert!(found.low.is_some() && !found.sentence.contains("inside"), "{}", found.sentence);
    assert!(!one(&ramp(100), mean()).sentence.contains("inside the model"));
}

#[test]
fn whether_a_limit_was_exceeded_is_known_of_runs_that_ended_and_of_those_that_had_exceeded_it() {
    let mut study = timed(200, 34);
    // failed and invalid runs within the limits, and one that exceeded a limit before
    study.fail(100, "diverged");
    study.fail(101, "energy_balance");
    study.status[101] = Status::Invalid;
    study.fail(3, "diverged");
    study.columns[0].held[3] = Some(0.1);
    let found = one(&study, probability("y > 0"));
    assert_eq!((found.events, found.estimate, found.estimate_if_bad_harmful), (Some(34), Some(0.17), Some(0.18)));
    assert_eq!((found.bad, found.beyond), (36, 33));
    let limits = |events: u64| one(&ramp(200), probability(&format!("y < {events}")));
    assert_eq!((found.low, found.high), (limits(34).low, limits(36).high));
    let by = "2 bad runs undecided (the interval covers all possible outcomes), 1 bad run and 33 runs beyond the model counted by the recorded limits";
    assert!(found.sentence.ends_with(by), "{}", found.sentence);
    // a gate is decided, too
    let names = Names { known: Known { columns: vec![("y".into(), true)], ..Known::default() }, ..Names::default() };
    let gate = |bound: &str| Gate::new(&format!("P(y > 0) < {bound}"), None, &names).expect("a gate");
    let judged = |bound: &str, made: &Made| gate(bound).judge(&made.study()).expect("a decision").remove(0);
    let passed = judged("0.25", &study);
    assert_eq!((passed.verdict, passed.events, passed.bad, passed.beyond), (Verdict::Passed, (34, 36), 36, 33));
    assert_eq!(judged("0.1", &study).verdict, Verdict::Failed);
    // a run that crashed or panicked has no record of its limit
    study.fail(102, "worker_crashed");
    study.status[102] = Status::Quarantined;
    study.fail(103, "panicked");
    let open = one(&study, probability("y > 0"));
    assert_eq!((open.estimate, open.estimate_if_bad_harmful), (Some(0.17), Some(0.19)));
}

#[test]
fn a_gate_names_the_runs_that_leave_it_open() {
    let mut study = ramp(1000);
    study.columns[0].nature = '>';
    (0..100).for_each(|row| study.exceed(row, LIMIT, true));
    let names = Names { known: Known { columns: vec![("y".into(), true)], ..Known::default() }, ..Names::default() };
    let gate = Gate::new("P(y > 1000) < 0.05", None, &names).expect("a gate");
    let found = gate.judge(&study.study()).expect("a decision").remove(0);
    assert_eq!((found.verdict, found.events, found.beyond), (Verdict::Open, (0, 100), 100));
    for part in ["100 if runs beyond the model are harmful", "the runs beyond the model prevent a decision"] {
        assert!(found.sentence.contains(part), "{part}: {}", found.sentence);
    }
}

#[test]
fn more_points_do_not_narrow_what_runs_beyond_the_model_leave_open() {
    let found = one(&ended(1000, 170), probability("y > 990"));
    assert!(
        found.notes.iter().any(|note| note.starts_with("more runs will not help: the runs beyond the model")),
        "{:?}",
        found.notes
    );
    assert!(!found.notes.iter().any(|note| note.contains("why they fail")), "{:?}", found.notes);
    let rule = StopRule { half_width: Some(0.02), ..StopRule::default() };
    let why = rule.hindrance(&found.figures[0], found.bad, 0.05);
    assert!(matches!(why, Some(Hindrance::BadRuns { is_sure: true, .. })), "{why:?}");
}

#[test]
fn answers_as_json_count_them_among_the_bad_and_apart() {
    let mut study = ended(100, 10);
    study.fail(0, "diverged");
    let answered = [probability("y > 50"), quantile(0.5), mean()].map(|def| one(&study, def));
    let answers = Answers { schema: SCHEMA, complete: true, answers: answered.to_vec() };
    let json: serde_json::Value = serde_json::from_str(&answers.json().expect("a text")).expect("JSON");
    for answer in json["answers"].as_array().expect("a list") {
        assert_eq!((&answer["bad"], &answer["beyond"]), (&11.into(), &10.into()), "{answer}");
    }
    let curve = ask(&study, exceedance());
    assert_eq!((curve.answers[0].bad, curve.answers[0].beyond), (11, 10));
    assert!(
        curve.answers[0]
            .sentence
            .ends_with("1 bad run and 10 runs beyond the model (the limits cover all possible outcomes)")
    );
}

#[test]
fn both_groups_of_a_difference_are_counted() {
    let study = ended(100, 10).varied("way", &["a", "b"]);
    let found = one(&study, less(mean()));
    assert_eq!((found.bad, found.beyond), (10, 10));
    assert!(found.sentence.contains("of runs inside the model (90 %)"), "{}", found.sentence);
}

/// Limits of an exceedance contain the probability for the complete runs, which is known here: each run beyond the model would have reached
/// a value above its limit.
#[test]
fn intervals_hold_what_the_runs_would_have_reached() {
    let repeats = 400;
    let (mut shares, mut levels) = (0, 0);
    for seed in 0..repeats {
        let mut random = bladeoff_system::random::SplitMix(seed * 7919 + 1);
        let whole: Vec<f64> = (0..200).map(|_| random.unit()).collect();
        // a limit at 0.8: larger values are cut there
        let mut study = super::support::made(&whole.iter().map(|value| value.min(0.8)).collect::<Vec<_>>());
        study.columns[0].nature = '>';
        for (row, value) in whole.iter().enumerate().filter(|(_, value)| **value > 0.8) {
            study.exceed(row, LIMIT, true);
            assert!(study.columns[0].cells[row] < Some(*value));
        }
        let share = one(&study, probability("y > 0.9"));
        shares += u64::from(share.low.expect("a limit") <= 0.1 && share.high.expect("a limit") >= 0.1);
        let level = one(&study, quantile(0.9));
        levels += u64::from(level.low.expect("a limit") <= 0.9 && level.high.is_none_or(|high| high >= 0.9));
    }
    // at least 95 %: open runs widen the intervals
    assert!(shares >= 380 && levels >= 380, "{shares} and {levels} of {repeats}");
}

#[test]
fn a_sensitivity_says_that_it_is_of_the_runs_inside_the_model() {
    let study = ended(400, 80);
    let names = Names {
        known: Known { columns: vec![("y".into(), true), ("u".into(), true)], ..Known::default() },
        uncertain: vec!["u".into()],
        ..Names::default()
    };
    let def = QuestionDef {
        name: "q".into(),
        sensitivity: Some("y".into()),
        method: Some("given-data".into()),
        ..QuestionDef::default()
    };
    let question = Question::new(&def, &names).expect("a question");
    let found = answer(&study.study(), &question).expect("an answer").answers.remove(0);
    assert_eq!((found.bad, found.beyond), (80, 80));
    assert!(found.sentence.contains("sensitivity of y of runs inside the model (80 %)"), "{}", found.sentence);
}
