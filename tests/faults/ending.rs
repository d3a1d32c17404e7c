//! `[stop]`: studies that end by precision, by a number of points or by time, with any number of workers and interruptions.

use crate::running::{Running, left_behind};
use crate::support::shared_studies::slow_outputs;
use crate::support::{Folder, say};
use bladeoff_answers::tables::count_sound_rows;
use serde_json::Value;
use std::fs;

/// Study in which a tenth of the points are events.
const STUDY: &str = r#"schema = 1
name = "stopping"
model = "function"
seed = 11

[function]
g = "x * k"

[[uncertain]]
name = "x"
distribution = "uniform"
lower = 0
upper = 1

[[vary]]
name = "k"
values = [1, 1.25]

[design]
kind = "monte-carlo"
samples = 20000

[[question]]
name = "high"
probability = "g > 0.9"
"#;

const TENTH: &str = "\n[stop]\nrelative = \"25 %\"\n";

fn with(stop: &str) -> String {
    format!("{STUDY}{stop}")
}

fn json(folder: &Folder, out: &str, name: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.path(out).join(name)).expect("written")).expect("JSON")
}

fn table(folder: &Folder, out: &str) -> Vec<u8> {
    fs::read(folder.path(out).join("results.parquet")).expect("the table")
}

fn run(folder: &Folder, study: &str, out: &str, more: &[&str]) -> crate::support::Said {
    let out = folder.name(out);
    say(&[&["run", study, "--out", &out], more].concat())
}

/// Points, samples and reason of the end, from the manifest.
fn end(folder: &Folder, out: &str) -> (u64, String, String) {
    let manifest = json(folder, out, "manifest.json");
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    assert_eq!(manifest["state"], "complete");
    assert_eq!(manifest["stop"], json(folder, out, "status.json")["stop"]);
    (manifest["stop"]["points"].as_u64().unwrap_or(0), text(&manifest["stop"]["why"]), text(&manifest["ended"]))
}

#[test]
fn a_study_that_is_precise_enough_has_the_same_table_on_one_and_three_workers_and_after_kills() {
    let folder = Folder::new();
    let study = folder.write("s.toml", &with(TENTH));
    let one = run(&folder, &study, "one", &["--workers", "1"]);
    assert_eq!(one.code, 0, "{}", one.err);
    let (points, why, ended) = end(&folder, "one");
    assert!((512..20000).contains(&points) && points.is_power_of_two(), "{points}");
    assert_eq!((why.as_str(), ended.as_str()), ("precision", "stop"));
    assert!(one.out.contains(&format!("precise enough at {points} of 20000 points ([stop])")), "{}", one.out);
    assert_eq!(run(&folder, &study, "three", &["--workers", "3"]).code, 0);
    assert!(table(&folder, "one") == table(&folder, "three"), "another table on three workers");
    // killed while computing samples, while collecting rows for an interim analysis, and at the end of the last stage; then the same command again
    for (at, sample) in [("recorded", 700), ("looking", 512), ("looking", 2 * points), ("writing", 0)] {
        let out = format!("killed-{at}-{sample}");
        let fault = format!("who=orchestrator,at={at},sample={sample},do=kill");
        let mut killed = Running::start(&folder, &study, &folder.name(&out), &fault);
        assert!(!killed.end().success());
        assert_eq!(killed.fired(), 1, "{at} {sample}: the kill happened");
        assert!(!folder.path(&out).join("results.parquet").exists());
        let again = run(&folder, &study, &out, &[]);
        assert_eq!(again.code, 0, "{}", again.err);
        assert!(table(&folder, "one") == table(&folder, &out), "{at} {sample}: another table");
        assert_eq!(left_behind(&folder.name(&out)), Vec::<std::path::PathBuf>::new(), "{at} {sample}");
        assert!(!folder.path(&out).join("look.parquet").exists());
    }
    // a worker dies
    let fault = "who=worker,at=running,sample=300,do=kill";
    let mut killed = Running::start(&folder, &study, &folder.name("worker"), fault);
    assert!(killed.end().success(), "{}", killed.said());
    assert_eq!(killed.fired(), 1, "the kill happened");
    assert!(table(&folder, "one") == table(&folder, "worker"));
}

#[test]
fn answers_have_plain_limits_gates_spend_the_error_and_commands_know_where_the_table_ends() {
    let folder = Folder::new();
    let study = folder.write("s.toml", &(with(TENTH) + "\n[[gate]]\nrequire = \"P(g > 0.9) < 0.5\"\n"));
    let first = run(&folder, &study, "out", &[]);
    assert_eq!(first.code, 0, "{}", first.err);
    let (points, ..) = end(&folder, "out");
    let answers = fs::read(folder.path("out/answers.json")).expect("written");
    let answer = &json(&folder, "out", "answers.json")["answers"][0];
    let (estimate, low, high) = (&answer["estimate"], &answer["low"], &answer["high"]);
    let [estimate, low, high] = [estimate, low, high].map(|value| value.as_f64().expect("a number"));
    assert!(0.5 * (high - low) <= 0.25 * estimate && low < 0.1 && 0.1 < high, "{answer}");
    // limits of a study planned with as many points, reported as approximate
    let events = answer["events"].as_u64().expect("a number");
    let limits = [
        bladeoff_answers::estimate::limits::lower_limit(events, points, 0.5 * (1.0 - 0.95)),
        bladeoff_answers::estimate::limits::upper_limit(events, points, 0.5 * (1.0 - 0.95)),
    ];
    assert_eq!(
        (&answer["approximate"], &answer["method"]),
        (&Value::Bool(true), &"clopper-pearson".into()),
        "{answer}"
    );
    assert!((low - limits[0]).abs() < 1e-15 && (high - limits[1]).abs() < 1e-15, "{low} to {high}, not {limits:?}");
    assert_eq!(
        (&answer["n"], json(&folder, "out", "answers.json")["complete"].as_bool()),
        (&points.into(), Some(true))
    );
    let out = folder.name("out");
    // second call: same answer, nothing is written
    let again = say(&["answer", &out]);
    let note = "one of several interim analyses of [stop]: the limits are those of this analysis alone, about 95 %";
    assert!(again.code == 0 && again.out.contains(note) && again.out.contains(" (about 95 %: "), "{}", again.out);
    assert!(first.out.contains(" (about 95 %: ") && !first.out.contains(" (95 %: "), "the same in the summary");
    let page = folder.name("interim.html");
    assert_eq!(say(&["report", &out, "--out", &page]).code, 0);
    let page = fs::read_to_string(page).expect("written");
    assert!(
        page.contains(" (about 95 %: ") && !page.contains(" (95 %: ") && page.contains(note),
        "the same in the report"
    );
    assert_eq!(fs::read(folder.path("out/answers.json")).expect("there"), answers);
    let gate = say(&["gate", &out]);
    assert!(gate.code == 0 && gate.out.contains("passed, at most"), "{}{}", gate.out, gate.err);
    assert!(gate.out.contains(&format!("Gates, of {points} points")), "{}", gate.out);
    // error level of analysis k: alpha/2^(k+1)
    let alpha = 0.05 / (points / 256 * 2) as f64;
    let limit = bladeoff_answers::estimate::limits::upper_limit(events, points, alpha);
    let (_, at_most) = gate.out.split_once("passed, at most ").expect("a limit");
    let (found, behind) = at_most.split_once(" % (").expect("per cent");
    let found: f64 = found.parse().expect("a number");
    assert!((found - 100.0 * limit).abs() < 0.5 && behind.contains(&format!("{events} of {points}")), "{}", gate.out);
    let (sure, _) = behind.split_once(" %)").expect("per cent");
    let sure: f64 = sure.parse().expect("a number");
    assert!((sure - 100.0 * (1.0 - alpha)).abs() < 0.051 && sure > 98.0, "{}", gate.out);
    let status = say(&["status", &out]);
    assert!(status.out.contains(&format!("complete: precise enough at {points} of 20000 points")), "{}", status.out);
    let export = say(&["export", &out, "--csv"]);
    assert_eq!(export.out.lines().count() as u64, 1 + 2 * points);
    let why = say(&["why", &out, "3"]);
    assert!(why.code == 0 && why.out.contains("status"), "{}{}", why.out, why.err);
    let beyond = say(&["why", &out, &(2 * points).to_string()]);
    assert!(beyond.code == 0 && beyond.out.contains("beyond the end of the table"), "{}{}", beyond.out, beyond.err);
    // same command: nothing to compute, nothing changed
    let before = table(&folder, "out");
    let nothing = run(&folder, &study, "out", &[]);
    assert!(
        nothing.code == 0 && nothing.err.contains("up to the end by [stop] is already finished"),
        "{}",
        nothing.err
    );
    assert!(before == table(&folder, "out") && nothing.out.contains("precise enough"), "{}", nothing.out);
    // a lost file is restored with the same content
    fs::remove_file(folder.path("out/manifest.json")).expect("removed");
    assert_eq!(run(&folder, &study, "out", &[]).code, 0);
    assert!(before == table(&folder, "out"));
    assert_eq!(end(&folder, "out").0, points);
}

#[test]
fn another_rule_ends_the_table_elsewhere_and_computes_what_is_missing_alone() {
    let folder = Folder::new();
    let study = folder.write("s.toml", &with("\n[stop]\nsamples = 3000\n"));
    let run_with = |stop: &str| {
        folder.write("s.toml", &with(stop));
        let said = run(&folder, &study, "out", &[]);
        assert_eq!(said.code, 0, "{}", said.err);
        (said, end(&folder, "out"))
    };
    let (_, found) = run_with("\n[stop]\nsamples = 3000\n");
    assert_eq!(found, (3000, "samples".to_owned(), "stop".to_owned()));
    // an easier rule: surplus samples stay in the record
    let (said, (points, ..)) = run_with(TENTH);
    assert!(points < 3000 && said.err.contains("6000 of 40000 samples are already finished"), "{}", said.err);
    let fresh = folder.write("fresh.toml", &with(TENTH));
    assert_eq!(run(&folder, &fresh, "fresh", &[]).code, 0);
    let rows = |out: &str| crate::support::table(&folder.name(out));
    assert_eq!(rows("out"), rows("fresh"));
    // surplus samples are counted separately, also without the last report
    let table_has = 2 * points;
    let counted = |value: &Value| {
        let number = |key: &str| value[key].as_u64().expect("a number");
        assert_eq!((number("done"), number("surplus"), number("left")), (table_has, 6000 - table_has, 0), "{value}");
        assert_eq!(value["by_status"]["ok"].as_u64(), Some(table_has), "{value}");
    };
    let told = || serde_json::from_str::<Value>(&say(&["status", &folder.name("out"), "--json"]).out).expect("JSON");
    counted(&told());
    assert_eq!(json(&folder, "out", "manifest.json")["done"].as_u64(), Some(table_has));
    fs::remove_file(folder.path("out/status.json")).expect("there");
    counted(&told());
    let status = say(&["status", &folder.name("out")]).out;
    let more = format!("{} more in the record, beyond the end of the table", 6000 - table_has);
    assert!(status.contains(&format!("done       {table_has} of 40000")) && status.contains(&more), "{status}");
    assert_eq!(run(&folder, &study, "out", &[]).code, 0);
    counted(&json(&folder, "out", "status.json"));
    // the difference of the ends is reported as text, also in the page
    folder.write("s.toml", &with("\n[stop]\nsamples = 3000\n"));
    assert_eq!(run(&folder, &study, "longer", &[]).code, 0);
    let compared = say(&["compare", &folder.name("longer"), &folder.name("out")]);
    let ends = format!("end by [stop]: 3000 points, by `samples` in A, {points} points, precise enough in B");
    assert!(compared.code == 0 && compared.out.contains(&ends), "{}{}", compared.out, compared.err);
    let page = folder.name("page.html");
    assert_eq!(say(&["report", &folder.name("out"), "--out", &page]).code, 0);
    let page = fs::read_to_string(page).expect("written");
    let ended = format!("precise enough at {points} of 20000 points ([stop])");
    assert!(page.contains(&format!("<p>The study ended: {ended}.</p>")), "in the lead");
    assert!(
        page.contains(&format!("<td>end of the table</td><td>{ended}</td>")) && !page.contains("&quot;share&quot;")
    );
    // an earlier end, then the whole design
    let (said, found) = run_with("\n[stop]\nsamples = 3000\n");
    assert!(found.0 == 3000 && said.err.contains("6000 of 40000 samples are already finished"), "{}", said.err);
    folder.write("s.toml", STUDY);
    let whole = run(&folder, &study, "out", &[]);
    assert!(whole.code == 0 && whole.err.contains("6000 of 40000 samples are already finished"), "{}", whole.err);
    assert_eq!((rows("out").1.len(), &json(&folder, "out", "manifest.json")["stop"]), (40_000, &Value::Null));
}

/// More points than a machine can compute within this test, at some hundred microseconds each.
const ENDLESS: u64 = 200_000;

/// The study with so many points.
fn endless() -> String {
    let text = STUDY.replace("[function]\n", &format!("[function]\n{}", slow_outputs(40, "x")));
    text.replace("samples = 20000", &format!("samples = {ENDLESS}"))
}

#[test]
fn a_time_ends_a_study_at_its_last_look_and_wall_of_the_command_leaves_it_open() {
    let folder = Folder::new();
    let endless = endless();
    let study = folder.write("s.toml", &format!("{endless}\n[stop]\nrelative = 1e-9\nwall = \"1 s\"\n"));
    let said = run(&folder, &study, "out", &[]);
    assert_eq!(said.code, 0, "{}", said.err);
    let (points, why, ended) = end(&folder, "out");
    assert!(points >= 256 && points.is_power_of_two(), "{points}");
    assert_eq!((why.as_str(), ended.as_str()), ("wall", "stop"));
    let rows = count_sound_rows(&folder.path("out/results.parquet")).expect("a table");
    assert_eq!(rows as u64, 2 * points);
    let study = folder.write("s.toml", &format!("{endless}\n[stop]\nrelative = 1e-9\nwall = \"1 h\"\n"));
    // long enough for answers and a measured pace: --wall begins with the program
    let answers = [1, 2, 4, 8, 16, 32].into_iter().find_map(|seconds| {
        let open = run(&folder, &study, "open", &["--wall", &format!("{seconds} s")]);
        assert_eq!(open.code, 5, "{}{}", open.out, open.err);
        let answer = Some(say(&["answer", &folder.name("open")]).out).filter(|answer| answer.contains("(95 %: "));
        answer.filter(|_| say(&["status", &folder.name("open")]).out.contains("forecast"))
    });
    let answer = answers.expect("an interim analysis in a minute");
    assert!(!folder.path("open/results.parquet").exists());
    assert_eq!(json(&folder, "open", "manifest.json")["state"], "wall");
    assert!(!answer.contains("about 95 %"), "so far no interval ended it: {answer}");
    // incomplete: the forecast for another hour is printed
    let status = say(&["status", &folder.name("open")]);
    assert!(status.out.contains("forecast") && status.out.contains(": half of its interval is "), "{}", status.out);
    let told: Value = serde_json::from_str(&say(&["status", &folder.name("open"), "--json"]).out).expect("JSON");
    let of = &told["forecast"]["of"][0];
    let list = |value: &Value| value.as_array().expect("a list").clone();
    let (later, halves) = (list(&told["forecast"]["later"]), list(&of["later"]));
    let (now, end) =
        (of["half_width"].as_f64().expect("a number"), halves[later.len() - 1].as_f64().expect("a number"));
    // no forecast exceeds the design, at any speed of the machine
    assert!(later.iter().all(|later| later["points"].as_u64() <= Some(ENDLESS)), "{told}");
    assert!(end < 0.5 * now && told["forecast"]["points_per_hour"].as_f64() > Some(1e4), "{told}");
}

#[test]
fn a_design_that_ends_first_is_complete_and_says_so() {
    let folder = Folder::new();
    let study = folder.write("s.toml", &with("\n[stop]\nhalf_width = 1e-6\n").replace("20000", "600"));
    let said = run(&folder, &study, "out", &[]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.out.contains("all 600 points are done, and not every interval is as narrow as [stop] requires"),
        "{}",
        said.out
    );
    assert_eq!(end(&folder, "out"), (600, "design".to_owned(), "complete".to_owned()));
}

#[test]
fn what_no_further_point_makes_precise_is_named_at_the_first_look_and_at_the_end() {
    let folder = Folder::new();
    // about one run in thirty fails
    let text = STUDY
        .replace("g = \"x * k\"", "g = \"x * k + 0*ln(x - 0.03)\"\nflat = \"0*x\"")
        .replace("samples = 20000", "samples = 1200")
        + "\n[[question]]\nname = \"unlimited\"\nmean = \"g\"\n"
        + "\n[[question]]\nname = \"nothing\"\nsensitivity = \"flat\"\nmethod = \"given-data\"\n"
        + "\n[stop]\nrelative = \"10 %\"\n";
    let study = folder.write("s.toml", &text);
    let said = run(&folder, &study, "out", &[]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(end(&folder, "out").1, "design");
    let bad = json(&folder, "out", "status.json")["by_cause"]["non_finite"].as_u64().expect("some fail");
    assert!((40..140).contains(&bad), "{bad}");
    let first = |name: &str| {
        let line = format!("[stop] after 256 points: {name}: ");
        let told: Vec<&str> = said.err.lines().filter(|line| line.contains(&format!(" points: {name}: "))).collect();
        assert!(told.len() == 1 && told[0].starts_with(&line), "once, at the first look: {told:?}\n{}", said.err);
        told[0][line.len()..].to_owned()
    };
    let unlimited = first("unlimited (k = 1)");
    assert!(unlimited.contains("bad runs leave it without a limit: more points do not narrow that"), "{unlimited}");
    let nothing = first("nothing (k = 1), first order of x");
    assert_eq!(nothing, "it has no number: the output does not vary");
    assert!(said.out.contains("sensitivity of flat has no number: the output does not vary"), "{}", said.out);
    let (_, short) = said.out.split_once("Not as precise as [stop] asks:\n").expect("a list");
    for part in ["unlimited (k = 1): ", "nothing (k = 1.25), first order of x: it has no number", "high (k = 1): "] {
        assert!(short.contains(part), "{part}: {short}");
    }
    assert!(say(&["answer", &folder.name("out")]).out.contains("Not as precise as [stop] asks:\n"));
    let page = folder.name("page.html");
    assert_eq!(say(&["report", &folder.name("out"), "--out", &page]).code, 0);
    assert!(fs::read_to_string(page).expect("written").contains("<h3>Not as precise as [stop] asks</h3>"));
    // the estimate is 0: a relative width cannot be reached
    let never = folder
        .write("never.toml", &(STUDY.replace("g > 0.9", "g > 2").replace("samples = 20000", "samples = 600") + TENTH));
    let said = run(&folder, &never, "never", &[]);
    let zero = "high (k = 1): its estimate is 0 so far, so `relative` allows no width: set `half_width`";
    assert!(said.err.contains(&format!("[stop] after 256 points: {zero}")), "{}", said.err);
    assert!(said.out.contains(zero), "{}", said.out);
}

#[test]
fn sensitivities_stop_a_study_of_blocks() {
    let folder = Folder::new();
    let saltelli = STUDY.replace("kind = \"monte-carlo\"\nsamples = 20000", "kind = \"saltelli\"\nsamples = 8192");
    let saltelli = saltelli
        .replace("g = \"x * k\"", "g = \"x * k + z * z\"")
        .replace("[[vary]]", "[[uncertain]]\nname = \"z\"\ndistribution = \"normal\"\nmean = 0\nsd = 0.4\n\n[[vary]]");
    let asked = "\n[[question]]\nname = \"who\"\nsensitivity = \"g\"\nmethod = \"sobol\"\n\n[stop]\nhalf_width = 0.1\n";
    let study = folder.write("s.toml", &(saltelli + asked));
    let said = run(&folder, &study, "out", &[]);
    assert_eq!(said.code, 0, "{}", said.err);
    let (points, why, _) = end(&folder, "out");
    // base points consist of A, AB_x, AB_z, B
    assert!(points.is_multiple_of(4) && (points / 4).is_power_of_two() && why == "precision", "{points} {why}");
    let answers = json(&folder, "out", "answers.json");
    for answer in
        answers["answers"].as_array().expect("answers").iter().filter(|answer| answer["kind"] == "sensitivity")
    {
        for name in ["x", "z"] {
            for of in ["first", "total"] {
                let index = &answer["indices"][name][of];
                let half = 0.5 * (index["high"].as_f64().expect("high") - index["low"].as_f64().expect("low"));
                assert!(half <= 0.1, "{index}");
            }
        }
    }
}

#[test]
fn what_cannot_stop_a_study_is_refused() {
    let folder = Folder::new();
    let refused = |text: &str| {
        let check = say(&["check", &folder.write("wrong.toml", text)]);
        assert_eq!(check.code, 3, "{}{}", check.out, check.err);
        check.err
    };
    for (stop, part) in [
        ("", "stop: has no rule to stop at"),
        ("relative = \"a\"", "stop.relative = \"a\": is no width"),
        ("relative = 5", "stop.relative = 5: is no width"),
        ("relative = \"150 %\"", "allowed: a share of the answer above 0 and below 1, such as 0.05 or \"5 %\""),
        ("half_width = -1", "stop.half_width = -1: is no width"),
        ("half_width = true", "stop.half_width = true: is a boolean"),
        ("samples = 0", "stop.samples = 0"),
        ("wall = \"x\"", "stop.wall = \"x\""),
        ("sampels = 3", "did you mean `samples`?"),
    ] {
        let err = refused(&with(&format!("\n[stop]\n{stop}\n")));
        assert!(err.contains(part), "{stop}: {err}");
    }
    let curve = STUDY.replace("probability = \"g > 0.9\"", "exceedance = \"g\"") + TENTH;
    assert!(refused(&curve).contains("no question of the study has an answer with an interval"), "{}", refused(&curve));
    let sequence = |replicates: u32| {
        STUDY.replace(
            "\"monte-carlo\"\nsamples = 20000",
            &format!("\"sobol\"\nsamples = 256\nreplicates = {replicates}"),
        )
    };
    assert!(refused(&(sequence(20) + TENTH)).contains("would split 20 replicates"));
    assert!(refused(&(sequence(8) + TENTH)).contains("fewer than 16 replicates"));
    assert!(refused(&(sequence(16) + "\n[stop]\nsamples = 100\n")).contains("are not a complete design"));
    let grid = STUDY.replace("[design]\nkind = \"monte-carlo\"\nsamples = 20000\n", "") + "\n[stop]\nsamples = 10\n";
    assert!(refused(&grid).contains("stop: needs the points of a [design]"), "{}", refused(&grid));
    let asked = say(&["check", &folder.write("right.toml", &with(TENTH))]);
    assert!(asked.code == 0 && asked.out.contains("interim analyses after 256, 512, 1024"), "{}", asked.out);
}

/// The printed time is that of the samples that may be computed, not of the whole design.
#[test]
fn check_prints_the_time_to_the_first_interim_analysis_and_to_the_end_by_stop() {
    let folder = Folder::new();
    let of = |stop: &str| {
        let check = say(&["check", &folder.write("s.toml", &with(stop))]);
        assert_eq!(check.code, 0, "{}", check.err);
        check.out
    };
    for (stop, lines) in [
        ("", &["the whole study: about "][..]),
        (
            TENTH,
            &[
                "to the first interim analysis of [stop], 512 samples: about ",
                "the whole study, where no interim analysis ends it: about ",
            ],
        ),
        ("\n[stop]\nsamples = 3000\n", &["the whole study, 6000 samples by [stop]: about "]),
        // more samples than the study has
        ("\n[stop]\nsamples = 30000\n", &["the whole study: about "]),
        (
            "\n[stop]\nrelative = 0.1\nsamples = 1000\nwall = \"8 h\"\n",
            &[
                "to the first interim analysis of [stop], 512 samples: about ",
                "the whole study, 2000 samples by [stop], where no interim analysis ends it: about ",
                "[stop] ends a run after 8 h 00 min",
            ],
        ),
    ] {
        let out = of(stop);
        let (_, told) = out.split_once(" us each\n").expect("samples were evaluated");
        assert_eq!(told.lines().count(), lines.len(), "{stop}: {told}");
        for (line, begin) in told.lines().zip(lines) {
            assert!(line.starts_with(begin), "{stop}: {line}");
        }
    }
}
