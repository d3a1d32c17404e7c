//! Sensitivity questions end to end, from the study file to the terminal, `answers.json` and error messages, with formulas whose indices are
//! known exactly.

use crate::running::{Running, wait_until};
use crate::support::{Folder, say};
use serde_json::Value;
use std::fs;

/// The Ishigami function, a = 7, b = 0.1.
const ISHIGAMI: &str = "y = \"sin(a) + 7 * sin(b)^2 + 0.1 * c^4 * sin(a)\"";

/// Its indices in closed form: first order, total.
const EXACT: [(&str, f64, f64); 3] = [
    ("a", 0.313905191147811, 0.557588855209959),
    ("b", 0.442411144790041, 0.442411144790041),
    ("c", 0.0, 0.243683664062148),
];

fn study(function: &str, design: &str, more: &str) -> String {
    let parameter = |name: &str| {
        format!(
            "\n[[uncertain]]\nname = \"{name}\"\ndistribution = \"uniform\"\nlower = -3.141592653589793\nupper = 3.141592653589793\n"
        )
    };
    let parameters: String = ["a", "b", "c"].map(parameter).concat();
    format!(
        "schema = 1\nname = \"ishigami\"\nmodel = \"function\"\n\n[function]\n{function}\n\n[design]\n{design}\n{parameters}\n{more}"
    )
}

fn question(method: &str) -> String {
    format!("[[question]]\nname = \"who\"\nsensitivity = \"y\"\nmethod = \"{method}\"\n")
}

fn json(path: &std::path::Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).expect("written")).expect("JSON")
}

/// Runs a study; returns its output and its answers.
fn answered(folder: &Folder, name: &str, text: &str) -> (String, Vec<Value>) {
    let study = folder.write(&format!("{name}.toml"), text);
    let run = say(&["run", &study, "--out", &folder.name(name), "--workers", "2"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let answers = json(&folder.path(name).join("answers.json"));
    (run.out, answers["answers"].as_array().expect("answers").clone())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn holds(index: &Value, exact: f64) -> bool {
    number(&index["low"]) <= exact && exact <= number(&index["high"])
}

/// Reference: SALib 1.6.0 on the same rows: plain Joe-Kuo points from index 0, 1024 base points, second orders included.
#[test]
fn sobol_gives_the_estimates_of_salib_to_the_digit() {
    let folder = Folder::new();
    let design = "kind = \"saltelli\"\nsamples = 1024\nscramble = false\nsecond_order = true";
    let (out, answers) = answered(&folder, "plain", &study(ISHIGAMI, design, &question("sobol")));
    let answer = &answers[0];
    for (name, first, total) in [
        ("a", 0.332955105353, 0.558179045711),
        ("b", 0.441313938544, 0.443284584030),
        ("c", 0.018578437930, 0.242149373355),
    ] {
        let of = &answer["indices"][name];
        assert!((number(&of["first"]["estimate"]) - first).abs() < 1e-11, "{of}");
        assert!((number(&of["total"]["estimate"]) - total).abs() < 1e-11, "{of}");
    }
    assert_eq!(
        (&answer["kind"], &answer["n"], &answer["method"], &answer["approximate"]),
        (&"sensitivity".into(), &1024.into(), &"bootstrap".into(), &true.into())
    );
    assert_eq!((&answer["output"], &answer["estimator"]), (&"y".into(), &"sobol".into()));
    // interaction of a and c: 0.2437 of the variance; of the other pairs 0
    let pairs = answer["second_order"].as_array().expect("pairs");
    let exact = [0.0, 0.243683664062148, 0.0];
    assert!(pairs.iter().zip(exact).all(|(pair, exact)| holds(&pair["second"], exact)), "{pairs:?}");
    assert_eq!(pairs[1]["between"], serde_json::json!(["a", "c"]));
    assert!(
        out.contains("sensitivity of y, share of the variance, interactions included: a 56 % (about 95 %: "),
        "{out}"
    );
    assert!(out.contains("a with c") && out.contains("1024 base points"), "{out}");
}

/// Errors against exact values, and coverage of the intervals, for scrambled base points as in studies.
#[test]
fn errors_of_sobol_indices_fall_with_the_base_points() {
    let folder = Folder::new();
    let mut worst = Vec::new();
    for samples in [256, 4096] {
        let design = format!("kind = \"saltelli\"\nsamples = {samples}");
        let (_, answers) = answered(&folder, &format!("s{samples}"), &study(ISHIGAMI, &design, &question("sobol")));
        let mut errors = [0.0f64; 2];
        for (name, first, total) in EXACT {
            let of = &answers[0]["indices"][name];
            assert!(holds(&of["first"], first) && holds(&of["total"], total), "{samples}, {name}: {of}");
            errors[0] = errors[0].max((number(&of["first"]["estimate"]) - first).abs());
            errors[1] = errors[1].max((number(&of["total"]["estimate"]) - total).abs());
        }
        println!(
            "{samples} base points: largest error of first order {:.4}, of total order {:.4}",
            errors[0], errors[1]
        );
        worst.push(errors);
    }
    // 256 base points: 0.063 and 0.084; 4096: 0.0079 and 0.0024
    assert!(worst[0].iter().all(|error| *error < 0.1), "{worst:?}");
    assert!(worst[1][0] < 0.012 && worst[1][1] < 0.004, "{worst:?}");
}

/// Exact values over all elementary effects of four levels: mu* 7.704, 7.875, 6.249; sigma 6.249, 7.875, 8.837.
#[test]
fn morris_gives_the_effects_of_the_whole_grid_within_its_intervals() {
    let folder = Folder::new();
    let text = study(ISHIGAMI, "kind = \"morris\"\ntrajectories = 400", &question("morris"));
    let (out, answers) = answered(&folder, "morris", &text);
    for (name, star, sigma) in
        [("a", 7.7040541116, 6.2487961033), ("b", 7.875, 7.875), ("c", 6.2487961033, 8.8371321978)]
    {
        let of = &answers[0]["indices"][name];
        // every effect of b has the same size: an interval of zero width, apart from rounding
        let is_near = |index: &Value, exact: f64| {
            holds(index, exact) || (number(&index["estimate"]) - exact).abs() < 0.01 * exact
        };
        assert!(is_near(&of["mu_star"], star) && is_near(&of["sigma"], sigma), "{name}: {of}");
        assert!((number(&of["mu_star"]["estimate"]) - star).abs() < 0.07 * star, "{name}: {of}");
    }
    assert_eq!((&answers[0]["n"], &answers[0]["indices"]["a"]["first"]), (&400.into(), &Value::Null));
    assert!(out.contains("mean size of elementary effects") && out.contains("400 trajectories"), "{out}");
}

#[test]
fn any_sample_tells_of_first_orders_ranks_and_dependence() {
    let folder = Folder::new();
    let text = study(ISHIGAMI, "kind = \"monte-carlo\"\nsamples = 6000", &question("given-data"));
    let (out, answers) = answered(&folder, "given", &text);
    let answer = &answers[0];
    for (name, first, _) in EXACT {
        let of = &answer["indices"][name];
        assert!((number(&of["first"]["estimate"]) - first).abs() < 0.05 && holds(&of["first"], first), "{name}: {of}");
        assert!(of["total"].is_null(), "no sample of this kind tells of it");
    }
    // y is monotonic in a but not in b and c, whose effects only the dependence shows
    let of = |name: &str, key: &str| number(&answer["indices"][name][key]["estimate"]);
    assert!(of("a", "spearman") > 0.35 && of("b", "spearman").abs() < 0.05, "{answer}");
    assert!(number(&answer["indices"]["c"]["hsic"]["p_value"]) < 1e-6, "{answer}");
    assert!(number(&answer["r2"]["estimate"]) < 0.3 && answer["method"] == "replicates-t", "{answer}");
    assert!(out.contains("HSIC of the first 2000 rows") && out.contains("R2 of the rank regression"), "{out}");
}

/// A single sequence gave 0.23 and -0.22 for a and c, because neighbours in a column depend on each other.
#[test]
fn replicates_of_sequences_give_first_orders_and_a_single_sequence_is_rejected() {
    let folder = Folder::new();
    for kind in ["sobol", "halton", "latin-hypercube"] {
        let design = format!("kind = \"{kind}\"\nsamples = 256\nreplicates = 16");
        let (_, answers) = answered(&folder, kind, &study(ISHIGAMI, &design, &question("given-data")));
        for (name, first, _) in EXACT {
            let of = &answers[0]["indices"][name]["first"];
            assert!((number(&of["estimate"]) - first).abs() < 0.05 && holds(of, first), "{kind}, {name}: {of}");
        }
    }
    let single = study(ISHIGAMI, "kind = \"sobol\"\nsamples = 4096", &question("given-data"));
    let check = say(&["check", &folder.write("single.toml", &single)]);
    for part in ["first orders from 1 replicate of kind \"sobol\" are biased", "allowed: kind = \"monte-carlo\" or"] {
        assert!(check.code == 3 && check.err.contains(part), "{part}\nin\n{}", check.err);
    }
}

#[test]
fn a_bad_run_takes_its_block_out_and_the_share_is_said() {
    let folder = Folder::new();
    // no number where a > 3: one point in 44
    let function = ISHIGAMI.replace("sin(a) + 7", "0 * sqrt(3 - a) + sin(a) + 7");
    let (out, answers) =
        answered(&folder, "bad", &study(&function, "kind = \"saltelli\"\nsamples = 512", &question("sobol")));
    let answer = &answers[0];
    let (n, out_of_it) = (number(&answer["n"]), number(&answer["left_out"]));
    assert!(n + out_of_it == 512.0 && out_of_it > 10.0 && number(&answer["bad"]) > out_of_it, "{answer}");
    let note = format!("{out_of_it} of 512 base points left out");
    assert!(answer["notes"].to_string().contains(&note) && out.contains(&note), "{out}");
}

#[test]
fn half_way_whole_blocks_count_and_the_end_is_that_of_an_undisturbed_run() {
    let folder = Folder::new();
    let text = study(ISHIGAMI, "kind = \"saltelli\"\nsamples = 2048", &question("sobol"));
    let (_, whole) = answered(&folder, "calm", &text);
    let study = folder.write("killed.toml", &text);
    let out = folder.name("killed");
    let mut run = Running::start_with(
        &folder,
        &study,
        &out,
        "who=orchestrator,at=recorded,sample=6002,do=kill",
        &["--refresh", "0.05"],
    );
    run.end();
    assert_eq!(run.fired(), 1, "the kill happened");
    let partly = say(&["answer", &out]);
    assert_eq!(partly.code, 0, "{}", partly.err);
    assert!(partly.out.contains("Answers"), "{}", partly.out);
    let again = say(&["run", &study, "--out", &out]);
    assert_eq!(again.code, 0, "{}", again.err);
    assert_eq!(json(&folder.path("killed").join("answers.json"))["answers"], Value::from(whole));
    // the same rows, other questions
    let other = folder.write(
        "other.toml",
        &text.replace("\"who\"", "\"else\"").replace("\"y\"\nmethod", "\"y\"\nconfidence = 0.9\nmethod"),
    );
    let asked = say(&["answer", &out, "--study", &other]);
    assert!(asked.code == 0 && asked.out.contains("(about 90 %: "), "{}{}", asked.out, asked.err);
    wait_until("nothing is left", || fs::read_dir(folder.path("killed")).is_ok());
}

#[test]
fn what_cannot_be_asked_is_refused_at_its_place() {
    let folder = Folder::new();
    let saltelli = "kind = \"saltelli\"\nsamples = 64";
    let refused = |design: &str, more: &str| {
        let check = say(&["check", &folder.write("wrong.toml", &study(ISHIGAMI, design, more))]);
        assert_eq!(check.code, 3, "{}{}", check.out, check.err);
        check.err
    };
    let err = refused(saltelli, &question("morris"));
    assert!(
        err.contains("question[0].method = \"morris\": method \"morris\" needs points of kind \"morris\""),
        "{err}"
    );
    assert!(err.contains("allowed: method = \"sobol\" with this [design]"), "{err}");
    for (design, method) in [
        (saltelli, "given-data"),
        ("kind = \"morris\"\ntrajectories = 10", "given-data"),
        ("kind = \"one-at-a-time\"", "given-data"),
        ("kind = \"sobol\"\nsamples = 4096", "given-data"),
        ("kind = \"halton\"\nsamples = 4096", "given-data"),
        ("kind = \"sobol\"\nsamples = 256\nreplicates = 8", "given-data"),
        ("kind = \"monte-carlo\"\nsamples = 100", "sobol"),
    ] {
        let err = refused(design, &question(method));
        assert!(err.contains("question[0].method") && err.contains("needs"), "{design}, {method}: {err}");
    }
    let more = format!(
        "{}\n{}\n{}\n[[question]]\nname = \"w4\"\nmean = \"y\"\nmethod = \"sobol\"\n",
        question("sobl"),
        "[[question]]\nname = \"w2\"\nsensitivity = \"y\"\n",
        "[[question]]\nname = \"w3\"\nsensitivity = \"yy\"\nmethod = \"sobol\"\nfragility = \"a\"\n"
    );
    let err = refused(saltelli, &more);
    for part in [
        "\"sobl\" is not one of \"morris\", \"sobol\", \"given-data\"; did you mean `sobol`?",
        "question[1].method: `sensitivity` needs `method`",
        "there is no column `yy`",
        "a sensitivity has no fragility",
        "`method` belongs to `sensitivity`",
        "5 problems",
    ] {
        assert!(err.contains(part), "{part}\nin\n{err}");
    }
    let err = refused(saltelli, &question("sobol").replace("\"y\"", "\"a\""));
    assert!(err.contains("`a` is an uncertain input itself"), "{err}");
    let correlated = "[[correlation]]\nbetween = [\"a\", \"b\"]\nrank = 0.5\n";
    let err = refused(saltelli, &format!("{correlated}\n{}", question("sobol")));
    assert!(err.contains("changes one parameter at a time"), "{err}");
    let asked = say(&["check", &folder.write("right.toml", &study(ISHIGAMI, saltelli, &question("sobol")))]);
    assert!(asked.code == 0 && asked.out.contains("who: sensitivity of y by sobol (confidence 95 %)"), "{}", asked.out);
}

/// With many parameters and few base points, two dimensions of Sobol's sequence are correlated, which the bootstrap does not show: a note
/// names the parameter.
#[test]
fn a_parameter_that_follows_itself_in_a_and_b_is_named() {
    let folder = Folder::new();
    let of = |count: usize, samples: u64| {
        let names: Vec<String> = (0..count).map(|k| format!("x{k}")).collect();
        let parameter = |name: &String| {
            format!("\n[[uncertain]]\nname = \"{name}\"\ndistribution = \"uniform\"\nlower = 0\nupper = 1\n")
        };
        let parameters: String = names.iter().map(parameter).collect();
        let sum = names.join(" + ");
        format!(
            "schema = 1\nname = \"sum\"\nmodel = \"function\"\n\n[function]\ny = \"{sum}\"\n\n[design]\nkind = \"saltelli\"\nsamples = {samples}\n{parameters}\n{}",
            question("sobol")
        )
    };
    let text = of(40, 64);
    let check = say(&["check", &folder.write("many.toml", &text)]).out.split_whitespace().collect::<Vec<_>>().join(" ");
    let (_, named) = check.split_once("64 base points are few for 40 parameters: ").expect("a note");
    let (_, named) = named.split_once("are correlated, ").expect("names");
    let name = named.split_whitespace().next().expect("a name").to_owned();
    let (_, answers) = answered(&folder, "many", &text);
    let notes = answers[0]["notes"].to_string();
    assert!(notes.contains(&format!("values of the same parameter in A and in B are correlated, {name} ")), "{notes}");
    // every exact index is 1/40: the error of the named one exceeds its interval
    let total = &answers[0]["indices"][&name]["total"];
    assert!(!holds(total, 1.0 / 40.0) && (number(&total["estimate"]) * 40.0 - 1.0).abs() > 0.4, "{total}");
    let (_, answers) = answered(&folder, "few", &of(4, 1024));
    assert!(!answers[0]["notes"].to_string().contains("are correlated"), "{}", answers[0]["notes"]);
    assert!(answers[0].get("correlated").is_none(), "{}", answers[0]);
}

/// Totals of x20, x4, x21 were 1.5 to 1.9 times and of x42, x36, x58 0.2 to 0.7 times their exact value, and only x58 was named.
#[test]
fn every_correlated_parameter_is_named() {
    let folder = Folder::new();
    let weight = |k: usize| if k < 3 { "1.0" } else { "0.01" };
    let sum = (0..105).map(|k| format!("{}*x{k}", weight(k))).collect::<Vec<_>>().join(" + ");
    let mut text = format!(
        "schema = 1\nname = \"s105\"\nmodel = \"function\"\nseed = 1\n[function]\ny = \"{sum}\"\n[design]\nkind = \"saltelli\"\nsamples = 64\n"
    );
    for k in 0..105 {
        text += &format!("[[uncertain]]\nname = \"x{k}\"\ndistribution = \"uniform\"\nlower = 0\nupper = 1\n");
    }
    let (_, answers) = answered(&folder, "s105", &(text + &question("sobol")));
    let notes = answers[0]["notes"].to_string();
    let (_, named) = notes.split_once("are correlated, ").expect("a note");
    let (named, _) = named.split_once(". A total index").expect("its end");
    let mut named: Vec<&str> = named.split(", ").collect();
    named[2..5].sort_unstable();
    assert_eq!(named[..6], ["x58 0.79", "x20 -0.75", "x21 -0.38", "x36 0.38", "x4 -0.38", "x42 0.37"]);
    let correlated = answers[0]["correlated"].as_array().expect("a list of parameters");
    for (parameter, value) in
        [("x58", 0.79), ("x20", -0.75), ("x36", 0.38), ("x21", -0.38), ("x4", -0.38), ("x42", 0.37)]
    {
        let found = correlated.iter().find(|one| one["parameter"] == parameter).expect("its correlation");
        assert!((number(&found["correlation"]) - value).abs() < 0.006, "{found}");
    }
    assert_eq!(named.len(), correlated.len(), "{notes}");
    assert!(correlated.iter().all(|one| number(&one["correlation"]).abs() >= 0.1), "{correlated:?}");
}

/// Two of 30 parameters had a correlation of 0.99 in a replicate of 64 points of Halton's sequence.
#[test]
fn check_warns_of_replicates_with_too_few_points_for_their_parameters() {
    let folder = Folder::new();
    let notes = |count: usize, design: &str| {
        let names: Vec<String> = (0..count).map(|k| format!("x{k}")).collect();
        let mut text = format!(
            "schema = 1\nmodel = \"function\"\n[function]\ny = \"{}\"\n[design]\n{design}\nreplicates = 16\n",
            names.join(" + ")
        );
        for name in &names {
            text += &format!("[[uncertain]]\nname = \"{name}\"\ndistribution = \"uniform\"\nlower = 0\nupper = 1\n");
        }
        let check = say(&["check", &folder.write("s.toml", &text)]);
        assert_eq!(check.code, 0, "{}", check.err);
        check.out.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    for kind in ["sobol", "halton"] {
        let said = notes(30, &format!("kind = \"{kind}\"\nsamples = 64"));
        let begin = "Note: 64 points of a replicate are few for 30 parameters. The values of x";
        assert!(said.contains(begin) && said.contains(" of 435 pairs have one above 0.1 or below -0.1"), "{said}");
        let said = notes(3, &format!("kind = \"{kind}\"\nsamples = 64"));
        assert!(!said.contains(" are few for "), "{said}");
    }
}
