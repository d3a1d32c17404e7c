//! Decisions of gates.

use super::support::made::Made;
use super::support::names;
use bladeoff_answers::estimate::input::DesignKind;
use bladeoff_answers::gate::{Decision, Gate, GateError, Verdict, junit, last_look, verdict};

/// A study with this number of points, the first `events` of them events.
fn study(events: usize, points: usize) -> Made {
    Made::new(vec![("y", (0..points).map(|point| Some(f64::from(u8::from(point < events)))).collect())])
}

fn gate(bound: &str) -> Gate {
    Gate::new(&format!("P(y > 0.5) < {bound}"), None, &names()).expect("a gate")
}

fn judged(gate: &Gate, made: &Made) -> Decision {
    gate.judge(&made.study()).expect("a decision").remove(0)
}

#[test]
fn limits_are_one_sided_and_exact() {
    // no event: 1 - 0.05^(1/n) < 0.01 from n = 299 on
    let (less, enough) = (judged(&gate("0.01"), &study(0, 298)), judged(&gate("0.01"), &study(0, 299)));
    assert_eq!((less.verdict, less.more), (Verdict::Open, Some(1)));
    assert_eq!(
        less.sentence,
        "P(y > 0.5) < 0.01: open, 0 % to 1 % (one-sided 95 % limits), 0 of 298; at this rate 1 point more would decide"
    );
    assert_eq!((enough.verdict, enough.verdict.code()), (Verdict::Passed, 0));
    assert_eq!(enough.sentence, "P(y > 0.5) < 0.01: passed, at most 1 % (95 %), 0 of 299");
    let failed = judged(&gate("0.01"), &study(30, 1000));
    assert_eq!((failed.verdict.code(), failed.limits.0 >= 0.01), (4, true));
}

#[test]
fn more_points_are_as_many_as_decide() {
    let gate = gate("0.01");
    let open = judged(&gate, &study(8, 1000));
    let more = open.more.expect("a number") as usize;
    assert_eq!(open.verdict, Verdict::Open);
    let at = |points: usize| judged(&gate, &study((0.008 * points as f64).round() as usize, points)).verdict;
    assert_eq!(at(1000 + more), Verdict::Passed);
    assert_eq!(at(1000 + more / 2), Verdict::Open);
    let above = judged(&gate, &study(13, 1000));
    assert!(above.verdict == Verdict::Open && above.more.is_some());
    let never = judged(&gate, &study(10, 1000));
    assert!(never.more.is_none() && never.sentence.contains("the rate is at the bound"), "{}", never.sentence);
}

#[test]
fn more_points_than_a_study_has_are_said_to_be() {
    for (bound, points) in [("1e-300", 1000), ("1e-12", 1000), ("2.9e-8", 2000)] {
        for complete in [true, false] {
            let found = judged(&gate(bound), &Made { complete, ..study(0, points) });
            assert_eq!((found.verdict, found.more), (Verdict::Open, None), "{}", found.sentence);
            let says = "at this rate more points would be needed than a study may have (100000000)";
            assert!(found.sentence.contains(says), "{bound}: {}", found.sentence);
        }
    }
    assert_eq!(judged(&gate("3e-8"), &study(0, 1000)).more, Some(99_856_741));
}

#[test]
fn bad_runs_and_not_points_prevent_it() {
    let mut made = study(0, 10_000);
    (0..200).for_each(|row| made.fail(row, "diverged"));
    let found = judged(&gate("0.01"), &made);
    assert_eq!((found.verdict, found.events, found.bad, found.more), (Verdict::Open, (0, 200), 200, None));
    assert!(found.sentence.contains("the bad runs prevent a decision"), "{}", found.sentence);
    // fewer bad runs leave the probability below the bound either way
    let mut made = study(0, 10_000);
    (0..20).for_each(|row| made.fail(row, "diverged"));
    assert_eq!(judged(&gate("0.01"), &made).verdict, Verdict::Passed);
    // reached values that are events fail the gate with certainty
    let mut made = study(0, 10_000);
    made.columns[0].nature = '>';
    (0..200).for_each(|row| made.fail(row, "diverged"));
    (0..200).for_each(|row| made.columns[0].held[row] = Some(0.7));
    assert_eq!(judged(&gate("0.01"), &made).verdict, Verdict::Failed);
}

#[test]
fn half_way_the_last_look_counts() {
    assert_eq!(last_look(255, 0.05), None);
    assert_eq!(last_look(256, 0.05), Some((256, 0.025)));
    assert_eq!(last_look(511, 0.05), Some((256, 0.025)));
    assert_eq!(last_look(512, 0.05), Some((512, 0.0125)));
    assert_eq!(last_look(5000, 0.05), Some((4096, 0.05 / 32.0)));
    let half_way = |events, points| Made { complete: false, ..study(events, points) };
    let early = judged(&gate("0.05"), &half_way(0, 100));
    assert_eq!((early.verdict, early.n), (Verdict::Open, 0));
    assert!(early.sentence.contains("the first interim analysis is at 256 points"));
    let found = judged(&gate("0.05"), &half_way(0, 300));
    assert_eq!((found.verdict, found.n), (Verdict::Passed, 256));
    assert!((found.level - 0.025).abs() < 1e-15);
    // points after the interim analysis are ignored
    let mut late = half_way(0, 500);
    (256..500).for_each(|row| late.columns[0].cells[row] = Some(1.0));
    assert_eq!(judged(&gate("0.05"), &late).events, (0, 0));
    let open = judged(&gate("0.01"), &half_way(0, 300));
    assert_eq!((open.verdict, open.more), (Verdict::Open, Some(512 - 300)));
    assert_eq!(judged(&gate("0.01"), &half_way(0, 512)).verdict, Verdict::Passed);
}

#[test]
fn every_group_has_to_hold_and_failed_goes_before_open() {
    let mut made = study(0, 2000).varied("way", &["a", "b"]);
    assert_eq!(verdict(&gate("0.01").judge(&made.study()).unwrap()), Verdict::Passed);
    // events in group b only
    (0..100).for_each(|point| made.columns[0].cells[2 * point + 1] = Some(1.0));
    let found = gate("0.01").judge(&made.study()).unwrap();
    assert_eq!((found[0].verdict, found[1].verdict), (Verdict::Passed, Verdict::Failed));
    assert_eq!(verdict(&found), Verdict::Failed);
    let open = judged(&gate("0.01"), &study(8, 1000));
    assert_eq!(verdict(&[open.clone(), found[0].clone()]), Verdict::Open);
    assert_eq!(verdict(&[open, found[1].clone()]).code(), 4);
}

#[test]
fn other_designs_have_no_gate() {
    let made = Made { kind: DesignKind::Sobol, ..study(0, 1000) };
    let found = gate("0.01").judge(&made.study());
    assert_eq!(found, Err(GateError::Design("sobol")));
    assert!(found.unwrap_err().to_string().contains("monte-carlo"));
}

#[test]
fn junit_has_a_testcase_for_each_and_escapes_what_it_says() {
    let mut made = study(0, 2000).varied("way", &["a\"<\u{1}", "b"]);
    (0..100).for_each(|point| made.columns[0].cells[2 * point + 1] = Some(1.0));
    let mut all = gate("0.01").judge(&made.study()).unwrap();
    all.push(judged(&gate("0.01"), &study(8, 1000)));
    let text = junit("night & day", &all, Some("4 of 8 < 9"));
    let expected = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>
<testsuites name=\"bladeoff gate\" tests=\"3\" failures=\"1\" errors=\"1\">
  <testsuite name=\"night &amp; day\" tests=\"3\" failures=\"1\" errors=\"1\">
    <testcase classname=\"night &amp; day\" name=\"way = a&quot;&lt;\u{2401}: P(y &gt; 0.5) &lt; 0.01\">
      <system-out>";
    assert!(text.starts_with(expected), "{text}");
    assert_eq!(text.matches("<failure message=").count(), 1);
    assert_eq!(text.matches("<error message=").count(), 1);
    assert_eq!(text.matches("</testcase>").count(), 3);
    assert!(text.contains("    <system-err>4 of 8 &lt; 9</system-err>\n  </testsuite>"), "{text}");
}
