//! Studies with runs beyond the model: their exit codes, and every output of the status.

use crate::support::{Folder, json, root, say};
use bladeoff_model::outcome::Status;
use std::fs;

/// A study of the lab rig; in some of its runs the ring exceeds a limit that is set low.
fn study(folder: &Folder, limits: &str) -> String {
    let text = format!(
        "schema = 1\nname = \"s\"\nmachine = \"machines/rig.toml\"\nseed = 1\n\
         [set]\n\"run.limit.ring_displacement.value\" = 1e-6\n\
         [[vary]]\npath = \"blade_off.mass\"\nvalues = [\"0.01 g\", \"0.02 g\", \"10 g\", \"12 g\"]\n\
         [design]\nkind = \"monte-carlo\"\nsamples = 2\n\
         [[uncertain]]\npath = \"contact.friction\"\ndistribution = \"uniform\"\nlower = 0.05\nupper = 0.15\n\
         [[question]]\nname = \"beyond\"\nprobability = \"beyond_s > 0\"\n{limits}"
    );
    folder.write("s.toml", &text)
}

#[test]
fn runs_beyond_the_model_are_counted_printed_and_limited() {
    let folder = Folder::reduced();
    let out = folder.name("out");
    let run = |limits: &str, out: &str| say(&["run", &study(&folder, limits), "--out", out, "--workers", "1"]);
    let within = run("[limits]\nmax_failed = 0\nmax_invalid = 0\n", &out);
    assert_eq!(within.code, 0, "{}\n{}", within.out, within.err);
    let status = json(&fs::read_to_string(folder.path("out/status.json")).expect("written"));
    for status_of_all in Status::ALL {
        assert!(status["by_status"][status_of_all.word()].is_u64(), "{}: {status}", status_of_all.word());
    }
    let beyond = status["by_status"]["beyond"].as_u64().expect("a count");
    assert_eq!((beyond, status["by_status"]["ok"].as_u64()), (4, Some(4)), "{status}");
    assert_eq!(status["by_cause"]["ring_displacement"], 4);
    assert!(within.err.contains("beyond 4 (4 ring_displacement)"), "{}", within.err);
    let head = within.out.lines().find(|line| line.starts_with("detection")).expect("a table");
    assert!(head.find(" ok").zip(head.find("beyond")).is_some_and(|(ok, beyond)| ok < beyond), "{head}");
    // whether the limit was exceeded is known for every run
    let answers = json(&fs::read_to_string(folder.path("out/answers.json")).expect("written"));
    let shares: Vec<_> = answers["answers"].as_array().expect("a list").iter().collect();
    for (at, answer) in shares.iter().enumerate() {
        let share = if at < 2 { 0.0 } else { 1.0 };
        assert_eq!(
            (&answer["estimate"], &answer["estimate_if_bad_harmful"]),
            (&share.into(), &share.into()),
            "{answer}"
        );
        assert_eq!((&answer["bad"], &answer["beyond"]), (&(2 * share as u64).into(), &(2 * share as u64).into()));
    }
    let why = say(&["why", &out, "7"]);
    for part in [
        "beyond the model: it exceeded",
        "ring_displacement",
        "ratio 1.04 ",
        "to `run.limit.ring_displacement.value`",
        "limit exceeded                   at 31.",
        "what to do",
    ] {
        assert!(why.out.contains(part), "{part}: {}", why.out);
    }
    // the study allows fewer runs beyond the model than the same results contain
    let above = run("[limits]\nmax_beyond = 3\n", &out);
    assert_eq!(above.code, 4, "{}", above.err);
    assert!(
        above.err.contains("4 of 8 samples beyond the model; the study allows 3 ([limits] max_beyond)"),
        "{}",
        above.err
    );
    let allowed = "4 of 8 samples beyond the model; the study allows 3 ([limits] max_beyond)";
    assert!(say(&["status", &out]).out.contains(&format!("warning    {allowed}")), "{}", say(&["status", &out]).out);
    assert_eq!(json(&say(&["status", &out, "--json"]).out)["above_max_beyond"], allowed);
    let (xml, page) = (folder.name("gate.xml"), folder.name("page.html"));
    say(&["gate", &out, "--require", "P(beyond_s > 0) < 0.5", "--junit", &xml]);
    assert!(fs::read_to_string(xml).expect("written").contains(&format!("<system-err>{allowed}</system-err>")));
    say(&["report", &out, "--out", &page]);
    assert!(fs::read_to_string(page).expect("written").contains(allowed));
    for word in ["answer", "gate"] {
        let gate = ["--require", "P(limit_ratio_ring_displacement > 1) < 0.9"];
        let said = say(&[&[word, &out][..], if word == "gate" { &gate[..] } else { &[] }].concat());
        assert!(said.err.contains("the study allows 3 ([limits] max_beyond)"), "{word}: {}", said.err);
    }
    assert_eq!(run("[limits]\nmax_beyond = \"50 %\"\n", &out).code, 0);
    // a replay with another limit does not end at it; both results are printed, and no file is written
    let before = fs::read(folder.path("out/results.parquet")).expect("the table");
    let said = say(&["replay", &out, "--sample", "7", "--set", "run.limit.ring_displacement.value=0.05"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let shown = said.out.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "run.limit.ring_displacement.value = 0.05, in the row 1e-6",
        "* status beyond ok",
        " engine reduced reduced ",
        "columns differ (*); nothing is written",
    ] {
        assert!(shown.contains(part), "{part} is not in\n{}", said.out);
    }
    assert_eq!(before, fs::read(folder.path("out/results.parquet")).expect("the table"));
    let wrong = say(&["replay", &out, "--sample", "7", "--set", "contct.gap=1"]);
    assert!(wrong.code == 3 && wrong.err.contains("did you mean `diaphragms.seal.contact.gap`?"), "{}", wrong.err);
}

#[test]
fn every_status_is_explained_on_the_pages_that_list_them() {
    for page in ["result-columns", "result-directory", "causes", "failed-runs", "events"] {
        let text = fs::read_to_string(root().join(format!("docs/{page}.md"))).expect("a page");
        let is_there = |word: &str| text.split(|c: char| !c.is_alphanumeric() && c != '_').any(|part| part == word);
        for status in Status::ALL {
            assert!(is_there(status.word()), "docs/{page}.md does not name {}", status.word());
        }
    }
}

/// The heaviest runs end at a limit; a comparison uses the values that they reached, and counts the pairs that cannot be compared.
#[test]
fn runs_beyond_the_model_are_compared_by_what_they_reached() {
    let folder = Folder::reduced();
    let run = |name: &str, limit: &str| {
        let path = study(&folder, "");
        let text = fs::read_to_string(&path).expect("written").replace("value\" = 1e-6", &format!("value\" = {limit}"));
        fs::write(&path, text).expect("written");
        let out = folder.name(name);
        let said = say(&["run", &path, "--out", &out, "--workers", "1"]);
        assert_eq!(said.code, 0, "{}", said.err);
        out
    };
    let (early, late, never) = (run("early", "1e-6"), run("late", "2e-6"), run("never", "1"));
    let compare = |b: &str, tolerances: &[&str]| {
        let tolerances = tolerances.iter().flat_map(|tolerance| ["--tolerance", tolerance]);
        say(&["compare", &early, b].into_iter().chain(tolerances).collect::<Vec<_>>())
    };
    let reached = compare(&late, &["guarded_max_bearing_load_N 0", "beyond_s 0"]);
    assert_eq!(reached.code, 4, "{}", reached.out);
    for part in [
        "guarded_max_bearing_load_N 0: out of tolerance in 2 of 4 pairs; farthest ",
        "beyond_s 0: out of tolerance in 4 of 4 pairs; farthest ",
        "; not compared: 4 pairs without a value in either (first sample 0)",
        "4 not ok in both for the same cause (only guarded_ columns and beyond_s are compared)",
    ] {
        assert!(reached.out.contains(part), "{part}: {}", reached.out);
    }
    let ok = compare(&late, &["max_bearing_load_N 0"]);
    assert_eq!(ok.code, 0, "{}", ok.out);
    let partly = "max_bearing_load_N 0: within in 4 pairs; not compared: 4 pairs not ok in both (see guarded_max_bearing_load_N)";
    assert!(ok.out.contains(partly), "{}", ok.out);
    assert!(ok.out.contains("Within the tolerances, in the pairs that could be compared."), "{}", ok.out);
    let nothing = compare(&early, &["twin_bearing_load_change 0"]);
    assert_eq!(nothing.code, 4, "{}", nothing.out);
    assert!(nothing.out.contains("nothing could be compared, which counts as out of tolerance"), "{}", nothing.out);
    let changed = compare(&never, &["end_time_s 1 %"]);
    assert_eq!(changed.code, 4, "{}", changed.out);
    assert!(changed.out.contains("beyond: ring_displacement in A, ok in B: 4 pairs"), "{}", changed.out);
}

#[test]
fn a_single_run_beyond_the_model_is_a_warning() {
    let set = ["--set", "run.limit.ring_displacement.value=1e-6", "--set", "run.end_time=0.17 s"];
    let said = say(&[&["simulate", "studies/machines/lab_rig.toml"], &set[..]].concat());
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.err.contains("warning: beyond the model"), "{}", said.err);
    assert!(said.out.contains("a limit of the model was exceeded"), "{}", said.out);
}

/// A gate, a question and a map of a quantity that is empty in every run of the machine are rejected, and no sample is computed.
#[test]
fn a_quantity_that_nothing_judges_is_refused_by_name() {
    let folder = Folder::reduced();
    let out = folder.name("out");
    let limit =
        "`limit_ratio_ring_yield` is empty in every run: the machine needs diaphragms.NAME.material.yield_strength";
    let twin = "`twin_bearing_load_change` is empty in every run: the machine needs `run.twin` above 0";
    let work =
        "`model_work_J` is empty in every run: the machine needs a diaphragm with `contact.detection = \"hyp1\"`";
    let question = |of: &str| format!("[[question]]\nname = \"q\"\n{of}\n");
    for (added, why) in [
        ("[[gate]]\nrequire = \"P(limit_ratio_ring_yield > 1) < 0.2\"\n".to_owned(), limit),
        (question("probability = \"twin_bearing_load_change > 0.05\""), twin),
        (question("exceedance = \"limit_ratio_ring_yield\""), limit),
        (question("quantile = 0.9\nof = \"model_work_J\""), work),
        (question("map = [\"blade_off.mass\", \"contact.friction\"]\nof = \"P(limit_ratio_ring_yield > 1)\""), limit),
    ] {
        let said = say(&["run", &study(&folder, &added), "--out", &out, "--workers", "1"]);
        assert!(said.code == 3 && said.err.contains(why), "{added}: {}\n{}", said.code, said.err);
        assert!(!folder.path("out").exists(), "{added}: nothing is computed");
    }
    // a study that varies the missing key and has a mistake there: only this mistake is reported
    let given = "[[question]]\nname = \"q\"\nprobability = \"limit_ratio_ring_yield > 1\"\n\
                 [[uncertain]]\npath = \"diaphragms.seal.material.yield_strength\"\ndistribution = \"uniform\"\n\
                 lower = \"-1 MPa\"\nupper = \"300 MPa\"\n";
    let said = say(&["check", &study(&folder, given)]);
    assert!(said.code == 3 && said.err.contains("values that are not allowed"), "{}", said.err);
    assert!(said.err.contains("error: 1 problem in"), "{}", said.err);
    // with twins of only some of the samples the condition is accepted; samples without a twin do not count for it
    let some = "[[gate]]\nrequire = \"P(twin_bearing_load_change > 0.05) < 0.9\"\n";
    let text = fs::read_to_string(study(&folder, some)).expect("written");
    let shared = folder.write("shared.toml", &text.replace("seed = 1\n", "seed = 1\ntwin_share = 0.5\n"));
    let said = say(&["check", &shared]);
    assert_eq!(said.code, 0, "{}", said.err);
    // for a result directory the same rule holds
    assert_eq!(say(&["run", &study(&folder, ""), "--out", &out, "--workers", "1"]).code, 0);
    let gate = say(&["gate", &out, "--require", "P(limit_ratio_ring_yield > 1) < 0.2"]);
    assert!(gate.code != 0 && gate.err.contains(limit), "{}: {}", gate.code, gate.err);
    // ok runs have no guarded value: the message suggests the quantity itself
    let gate = say(&["gate", &out, "--require", "P(guarded_max_bearing_load_N > 1 N) < 0.2"]);
    let own = "`guarded_max_bearing_load_N` is empty in ok runs: use `max_bearing_load_N`";
    assert!(gate.code == 3 && gate.err.contains(own), "{}: {}", gate.code, gate.err);
    // stresses that the runs have can be used with or without a yield strength
    let gate = say(&["gate", &out, "--require", "P(max_ring_stress_Pa > 1 Pa) < 0.2"]);
    assert_eq!(gate.code, 4, "{}: {}", gate.out, gate.err);
}

/// Failed runs decide nothing about a gate; runs that end at their end time decide nothing about later times.
#[test]
fn runs_that_fail_and_times_after_the_end_leave_a_gate_open() {
    let folder = Folder::reduced();
    let out = folder.name("out");
    let run = |set: &str, out: &str| {
        let text = fs::read_to_string(study(&folder, "")).expect("written");
        let of = text.replace("[set]\n", &format!("[set]\n{set}\n"));
        say(&["run", &folder.write("t.toml", &of), "--out", out, "--workers", "1"])
    };
    let failed = run("\"run.step_limit\" = 200", &out);
    assert!(failed.out.contains("8 (8 step_limit)"), "{}", failed.out);
    assert!(failed.out.contains("0 of 8 runs; 8 undecided"), "{}", failed.out);
    let gate = say(&["gate", &out, "--require", "P(beyond_s > 0) < 0.95"]);
    assert_eq!(gate.code, 5, "{}{}", gate.out, gate.err);
    assert!(gate.out.contains("2 if bad runs are harmful"), "{}", gate.out);
    let whole = folder.name("whole");
    let said = run("\"run.end_time\" = \"0.1 s\"", &whole);
    let horizon = "6 of 6 ok runs ended at their end time, 0.1 s; later events are unknown";
    assert!(said.out.contains(horizon), "{}", said.out);
    assert!(said.out.contains("0 of 8 runs; 2 undecided"), "{}", said.out);
    let gate = say(&["gate", &whole, "--require", "P(beyond_s > 0.2) < 0.95"]);
    assert!(gate.out.contains("2 if runs that ended before the time in the condition are harmful"), "{}", gate.out);
    let page = folder.name("page.html");
    assert_eq!(say(&["report", &whole, "--out", &page]).code, 0);
    assert!(fs::read_to_string(&page).expect("written").contains(horizon));
}
