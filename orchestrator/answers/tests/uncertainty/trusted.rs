//! Events that a row may leave open: not judged, not reached before a failure, or after the end of the run.

use super::support::made::Made;
use super::support::{ask, exceedance, names, one, probability, quantile};
use bladeoff_answers::ask::{Answer, Given, Names, Question, QuestionDef, answer};
use bladeoff_answers::estimate::formula::Known;
use bladeoff_answers::estimate::input::{DesignKind, Ended};
use bladeoff_answers::gate::{Gate, Verdict};
use bladeoff_model::outcome::Status;

/// Both figures of an estimate.
fn ends(answer: &Answer) -> (f64, f64) {
    (answer.estimate.expect("a number"), answer.estimate_if_bad_harmful.expect("a number"))
}

/// Ok rows without an event, in a column of this nature.
fn without(rows: usize, nature: char) -> Made {
    let mut study = Made::new(vec![("y", vec![None; rows])]);
    study.columns[0].nature = nature;
    study
}

fn verdict(study: &Made, require: &str) -> (Verdict, String) {
    let gate = Gate::new(require, None, &names()).expect("a gate");
    let decision = gate.judge(&study.study()).expect("a decision").remove(0);
    (decision.verdict, decision.sentence)
}

#[test]
fn a_failed_run_decides_no_event_that_it_had_not_reached() {
    for nature in ['l', 'o'] {
        for status in [Status::Failed, Status::Invalid, Status::Quarantined] {
            let mut study = without(24, nature);
            for row in 0..24 {
                study.fail(row, "step_limit");
                study.status[row] = status;
            }
            for text in ["y > 0", "y < 10", "not (y > 0)", "y != 3"] {
                assert_eq!(ends(&one(&study, probability(text))), (0.0, 1.0), "{nature} {status:?} {text}");
            }
            let (verdict, said) = verdict(&study, "P(y > 0) < 0.15");
            assert!(verdict == Verdict::Open && said.contains("24 if bad runs are harmful"), "{said}");
        }
        // an event while all guards held has happened; other values of an invalid run are not trusted
        let mut study = without(10, nature);
        for row in 0..2 {
            study.columns[0].cells[row] = Some(0.1);
            study.fail(row, "energy_balance");
            study.status[row] = Status::Invalid;
        }
        study.columns[0].held[0] = Some(0.1);
        assert_eq!(ends(&one(&study, probability("y > 0"))), (0.1, 0.2), "{nature}");
    }
    // an ok row that did not end by time has no later event
    assert_eq!(ends(&one(&without(8, 'l'), probability("y > 0"))), (0.0, 0.0));
}

#[test]
fn what_a_failed_run_had_not_reached_may_be_empty_in_the_end() {
    let mut study = without(4, '>');
    study.fail(0, "diverged");
    study.columns[0].held[0] = Some(0.0);
    // a run without contact has no force: no comparison with it holds
    assert_eq!(ends(&one(&study, probability("y >= 0"))), (0.0, 0.25));
    study.columns[0].held[0] = Some(1.0);
    assert_eq!(ends(&one(&study, probability("y >= 0"))), (0.25, 0.25));
}

#[test]
fn a_cell_that_nothing_judged_decides_nothing() {
    let mut study = without(24, '>');
    study.columns[0].unjudged = true;
    for text in ["y > 1", "not (y > 1)", "y != 1", "y < 1 or y >= 1"] {
        assert_eq!(ends(&one(&study, probability(text))), (0.0, 1.0), "{text}");
    }
    let (open, said) = verdict(&study, "P(y > 1) < 0.2");
    assert!(open == Verdict::Open, "{said}");
    assert!(said.contains("24 if runs in which a quantity of the condition was not judged are harmful"), "{said}");
    assert!(!said.contains("bad runs"), "{said}");
    let found = one(&study, probability("y > 1"));
    let note = "in 24 runs a quantity of the condition was not judged: undecided";
    assert!(found.notes.iter().any(|said| said == note), "{:?}", found.notes);
    assert!(!found.notes.iter().any(|note| note.contains("nothing of the kind")), "{:?}", found.notes);
    // the other term may determine the condition
    study.columns[0].cells[0] = Some(2.0);
    study.columns[0].cells[1] = Some(0.5);
    assert_eq!(ends(&one(&study, probability("y > 1"))), (1.0 / 24.0, 23.0 / 24.0));
    // a curve counts them both ways; a quantile is that of the runs with a value
    let curve = ask(&study, exceedance()).curve.expect("a curve");
    assert_eq!(curve.numbers("estimate").expect("cells").last(), Some(&Some(0.0)));
    assert_eq!(curve.numbers("estimate_if_bad_harmful").expect("cells").last(), Some(&Some(22.0 / 24.0)));
    assert_eq!(one(&study, quantile(0.5)).n, 2);
}

#[test]
fn an_event_after_the_end_of_a_run_is_not_known() {
    for nature in ['l', 'o'] {
        let mut study = without(100, nature);
        study.ends = vec![Ended::Time(6.0); 100];
        study.columns[0].cells[0] = Some(2.0);
        // events within the simulated time
        for text in ["y > 0", "y > 5.9", "y < 6", "y <= 5.9 and y > 1"] {
            assert!(ends(&one(&study, probability(text))).1 <= 0.01, "{text}");
        }
        // later times
        for (text, least) in [("y > 6", 0.0), ("y > 6.5", 0.0), ("y < 6.5", 0.01), ("not (y > 10)", 0.01)] {
            assert_eq!(ends(&one(&study, probability(text))), (least, least + 0.99), "{text}");
        }
        let found = one(&study, probability("y > 6.5"));
        let note = "99 runs ended without the event before the time in the condition: undecided";
        assert!(found.notes.iter().any(|said| said == note), "{:?}", found.notes);
        assert!(!found.notes.iter().any(|said| said.contains("bad runs")), "no run is bad: {:?}", found.notes);
        let (open, said) = verdict(&study, "P(y > 6.5) < 0.05");
        assert!(open == Verdict::Open && said.contains("runs that ended before the time in the condition"), "{said}");
        assert_eq!(verdict(&study, "P(y > 0) < 0.1").0, Verdict::Passed);
        // runs that stopped have no later event
        study.ends = vec![Ended::Other; 100];
        assert_eq!(ends(&one(&study, probability("y > 6.5"))), (0.0, 0.0));
    }
}

#[test]
fn a_column_that_the_machine_lacks_is_refused_with_the_key_that_is_missing() {
    let known = Known {
        columns: vec![("y".into(), true), ("z".into(), true)],
        lacking: vec![("y".into(), "every run: the machine needs rotor.material.yield_strength".into())],
        ..Known::default()
    };
    let names = Names { known, ..Names::default() };
    let says = "`y` is empty in every run: the machine needs rotor.material.yield_strength";
    let gate = Gate::new("P(z > 0 and y > 1) < 0.2", None, &names).expect_err("refused");
    assert!(gate.iter().any(|problem| problem.message == says), "{gate:?}");
    for def in [probability("y > 1"), exceedance(), quantile(0.5)] {
        let def = QuestionDef { name: "q".into(), ..def };
        let found = Question::new(&def, &names).expect_err("refused");
        assert!(found.iter().any(|problem| problem.message == says), "{found:?}");
    }
    assert!(Gate::new("P(z > 0) < 0.2", None, &names).is_ok());
}

/// Four cells with two starts; both runs of the last cell ended at a limit of the model.
#[test]
fn a_map_cell_that_is_a_lower_bound_is_never_at_most() {
    let cells = |of: fn(usize) -> f64| (0..8).map(|row| Some(of(row))).collect::<Vec<_>>();
    let mut study = Made::new(vec![
        ("a", cells(|row| (row / 2 / 2) as f64)),
        ("b", cells(|row| (row / 2 % 2) as f64)),
        ("start", cells(|row| (row % 2) as f64)),
        ("y", cells(|row| row as f64)),
    ]);
    study.kind = DesignKind::Chosen;
    (0..3).for_each(|at| study.columns[at].nature = 'g');
    study.columns[3].nature = '>';
    let given = |column: &str, axis: usize| Given {
        column: column.into(),
        axis: Some(axis),
        is_angle: column == "start",
        is_detection: false,
    };
    let names = Names {
        known: Known {
            columns: ["a", "b", "start", "y"].map(|name| (name.to_owned(), true)).to_vec(),
            ..Known::default()
        },
        varied: ["a", "b", "start"].map(|name| (name.to_owned(), Vec::new())).to_vec(),
        given: vec![given("a", 0), given("b", 1), given("start", 2)],
        ..Names::default()
    };
    let def = QuestionDef {
        name: "q".into(),
        map: Some(["a".into(), "b".into()]),
        of: Some("y".into()),
        ..QuestionDef::default()
    };
    let question = Question::new(&def, &names).expect("a question");
    let map = |study: &Made| answer(&study.study(), &question).expect("an answer").answers.remove(0);
    assert!(map(&study).sentence.contains("at most 6, at 1 and 1; at least 0"), "{}", map(&study).sentence);
    for row in 6..8 {
        study.exceed(row, "ring_displacement", true);
    }
    let found = map(&study);
    assert!(found.sentence.contains("the largest at least 6, at 1 and 1; at least 0"), "{}", found.sentence);
    assert!(!found.sentence.contains("at most"), "{}", found.sentence);
    let mut lost = Made::new(study.columns.iter().map(|column| (column.name, column.cells.clone())).collect());
    lost.kind = DesignKind::Chosen;
    (0..3).for_each(|at| lost.columns[at].nature = 'g');
    (6..8).for_each(|row| lost.fail(row, "diverged"));
    let lost = map(&lost).sentence;
    assert!(lost.contains("the largest at least 4, at 1 and 0; the least at most 0; open, because of bad"), "{lost}");
    // colours and lines do not use the bound as a value: the scale ends at the largest actual value
    let drawn = |answer: &Answer| {
        let map = answer.map.as_deref().expect("a map").clone();
        bladeoff_answers::figures::maps("", &[map]).svg().to_owned()
    };
    assert!(drawn(&found).contains("only a lower bound"), "the grey is explained");
    study.columns[3].cells[6] = Some(5.0e6);
    study.columns[3].cells[7] = Some(6.0e6);
    let far = drawn(&map(&study));
    assert_eq!(far, drawn(&found), "a bound changes no colour and no line");
}
