//! Messages in unusual cases, found by first-time users: sensitivities of few blocks, without an ok run, or of extreme outputs; ends counted in
//! blocks; errors that name what is allowed; maps of differences with bad runs. Each case is a formula study.

use crate::support::{Folder, root, say};
use serde_json::Value;
use std::fs;

/// A study with two variables from 0 to 1.
fn study(y: &str, design: &str, more: &str) -> String {
    let variable =
        |name: &str| format!("[[uncertain]]\nname = \"{name}\"\ndistribution = \"uniform\"\nlower = 0\nupper = 1\n");
    format!(
        "schema = 1\nname = \"t\"\nmodel = \"function\"\nseed = 1\n[function]\ny = \"{y}\"\n[design]\n{design}\n{}{}{more}",
        variable("a"),
        variable("b")
    )
}

fn who(method: &str) -> String {
    format!("[[question]]\nname = \"who\"\nsensitivity = \"y\"\nmethod = \"{method}\"\n")
}

fn saltelli(samples: u64) -> String {
    format!("kind = \"saltelli\"\nsamples = {samples}")
}

fn morris(trajectories: u64) -> String {
    format!("kind = \"morris\"\ntrajectories = {trajectories}")
}

fn monte_carlo(samples: u64) -> String {
    format!("kind = \"monte-carlo\"\nsamples = {samples}")
}

/// Runs a study; returns its output.
fn told(folder: &Folder, name: &str, text: &str) -> String {
    let run =
        say(&["run", &folder.write(&format!("{name}.toml"), text), "--out", &folder.name(name), "--workers", "1"]);
    assert_eq!(run.code, 0, "{}", run.err);
    run.out
}

/// Section of a report on precision.
fn precision(folder: &Folder, name: &str) -> String {
    let page = folder.name(&format!("{name}.html"));
    let made = say(&["report", &folder.name(name), "--out", &page]);
    assert_eq!(made.code, 0, "{}", made.err);
    let text = fs::read_to_string(page).expect("a page");
    let begin = text.find("id=\"precision\"").unwrap_or_else(|| panic!("no section on precision"));
    text[begin..].split("</section>").next().expect("its end").to_owned()
}

#[test]
fn a_study_of_sensitivities_alone_shows_how_its_intervals_narrow() {
    let folder = Folder::new();
    for (name, design, method, lines) in [
        ("s", saltelli(256), "sobol", &["widest first order", "total order of b", "(first order of b)"][..]),
        ("m", morris(100), "morris", &["widest: mu* of "][..]),
        ("g", monte_carlo(1000), "given-data", &["widest first order", "first order of b"][..]),
    ] {
        told(&folder, name, &study("a*a + 2*b*b", &design, &who(method)));
        let section = precision(&folder, name);
        assert!(section.contains("<figure") && section.contains("who: half of the widest interval is "), "{section}");
        for line in lines {
            assert!(section.contains(line), "{name}: {line} is not in {section}");
        }
        assert!(section.contains("half of the interval"), "{name}: {section}");
    }
    // base points at powers of two: 16, 32, ... of 4 points
    let section = precision(&folder, "s");
    for look in [">64</td>", ">128</td>", ">512</td>", ">1024</td>"] {
        assert!(section.contains(look), "{look} is not in {section}");
    }
    // so few have no interval, which is reported
    told(&folder, "few", &study("a*a + 2*b", &morris(2), &who("morris")));
    let section = precision(&folder, "few");
    assert!(section.contains("no interval: 2 trajectories of 10 needed"), "{section}");
    assert!(!section.contains("<figure"), "{section}");
}

#[test]
fn the_forecast_is_of_the_widest_interval_and_names_it() {
    let folder = Folder::new();
    told(&folder, "m", &study("a*a + 2*b", &morris(100), &who("morris")));
    // a status file with an artificial pace
    let status = folder.path("m").join("status.json");
    let mut told_last: Value = serde_json::from_slice(&fs::read(&status).expect("status")).expect("JSON");
    told_last["elapsed_s"] = 3600.into();
    fs::write(&status, told_last.to_string()).expect("written");
    let answer = say(&["answer", &folder.name("m")]);
    let line = answer.out.lines().find(|line| line.contains("half of its widest interval (mu* of "));
    assert!(line.is_some_and(|line| line.contains(" with 1200 points")), "{}", answer.out);
    let section = precision(&folder, "m");
    assert!(section.contains("forecast of the widest"), "{section}");
    // without an interval that is reported, too
    told(&folder, "few", &study("a*a + 2*b", &morris(4), &who("morris")));
    let status = folder.path("few").join("status.json");
    let mut told_last: Value = serde_json::from_slice(&fs::read(&status).expect("status")).expect("JSON");
    told_last["elapsed_s"] = 3600.into();
    fs::write(&status, told_last.to_string()).expect("written");
    let answer = say(&["answer", &folder.name("few")]);
    assert!(answer.out.contains("who: none is forecast: no interval: 4 trajectories of 10 "), "{}", answer.out);
}

#[test]
fn where_every_run_failed_that_is_said_and_no_parameter_is_blamed() {
    let folder = Folder::new();
    for (name, design, method) in
        [("s", saltelli(16), "sobol"), ("m", morris(12), "morris"), ("g", monte_carlo(40), "given-data")]
    {
        let out = told(&folder, name, &study("sqrt(-1 - a)", &design, &who(method)));
        assert!(out.contains("sensitivity of y has no number: no run is ok, 0 "), "{out}");
        assert!(!out.contains("does not vary"), "{out}");
    }
    // one bad run is not all runs
    let out = told(&folder, "one", &study("sqrt(0.99 - a)", &saltelli(16), &who("sobol")));
    assert!(!out.contains("no run is ok"), "{out}");
}

#[test]
fn one_of_a_kind_is_counted_as_one() {
    let folder = Folder::new();
    for (name, design, method, expected) in [
        ("s", saltelli(1), "sobol", "no interval: 1 base point of 10 needed"),
        ("m", morris(1), "morris", "no interval: 1 trajectory of 10 needed"),
        ("g", monte_carlo(1), "given-data", "no interval: 1 row of 32 needed"),
    ] {
        let out = told(&folder, name, &study("a + 2*b", &design, &who(method)));
        assert!(out.contains(expected), "{out}");
        for wrong in ["1 base points", "1 trajectories", "1 rows", "1 runs", "1 cells"] {
            assert!(!out.contains(wrong), "{wrong}: {out}");
        }
    }
}

/// Squares of 1e200 overflow; shares of the variance do not depend on the unit.
#[test]
fn outputs_out_of_all_bounds_have_the_indices_of_others() {
    let folder = Folder::new();
    let indices = |name: &str, y: &str, design: &str, method: &str| {
        told(&folder, name, &study(y, design, &who(method)));
        let text = fs::read(folder.path(name).join("answers.json")).expect("answers");
        let answers: Value = serde_json::from_slice(&text).expect("JSON");
        answers["answers"][0]["indices"]["b"].clone()
    };
    let number = |value: &Value| value["estimate"].as_f64().unwrap_or_else(|| panic!("{value} has no number"));
    for (factor, name) in [("1e200", "large"), ("1e-200", "small")] {
        for (design, method, key) in [
            (saltelli(64), "sobol", "first"),
            (saltelli(64), "sobol", "total"),
            (monte_carlo(400), "given-data", "first"),
        ] {
            let plain = indices(&format!("{method}-{key}"), "a + 2*b", &design, method);
            let far = indices(&format!("{name}-{method}-{key}"), &format!("{factor}*(a + 2*b)"), &design, method);
            let (plain, far) = (number(&plain[key]), number(&far[key]));
            assert!((plain - far).abs() < 1e-9, "{method}, {key}, {factor}: {plain} and {far}");
        }
        let far = indices(&format!("{name}-morris"), &format!("{factor}*(a + 2*b*b)"), &morris(20), "morris");
        let factor: f64 = factor.parse().expect("a number");
        let plain = indices(&format!("{name}-morris-plain"), "a + 2*b*b", &morris(20), "morris");
        for key in ["mu_star", "mu", "sigma"] {
            let (plain, far) = (number(&plain[key]), number(&far[key]) / factor);
            assert!((plain - far).abs() < 1e-9 * plain.abs(), "{key}: {plain} and {far}");
        }
    }
    // overflow is reported
    let out = told(&folder, "beyond", &study("1.7e308*(2*a - 1)", &morris(20), &who("morris")));
    assert!(out.contains("effects beyond 1.8e308 have no number"), "{out}");
}

/// `samples` of `[stop]` counts blocks, and so does the message about the end.
#[test]
fn an_end_by_blocks_is_told_in_blocks_and_the_report_keeps_apart_what_the_whole_would_have() {
    let folder = Folder::new();
    for (name, design, method, expected) in [
        ("s", saltelli(64), "sobol", "ended at 20 of 64 base points (80 of 256 points) by `samples` of [stop]"),
        ("m", morris(64), "morris", "ended at 20 of 64 trajectories (60 of 192 points) by `samples` of [stop]"),
    ] {
        let out = told(&folder, name, &study("a + 2*b", &design, &(who(method) + "[stop]\nsamples = 20\n")));
        assert!(out.contains(expected), "{out}");
        let status = say(&["status", &folder.name(name)]);
        assert!(status.out.contains(expected), "{}", status.out);
        let page = folder.name(&format!("{name}.html"));
        assert_eq!(say(&["report", &folder.name(name), "--out", &page]).code, 0);
        let text = fs::read_to_string(page).expect("a page");
        assert!(text.contains(&format!("The study ended: {expected}.")), "{name}");
        assert!(text.contains("samples of the whole study") && !text.contains("<td>samples</td>"), "{name}");
    }
}

#[test]
fn a_curve_without_an_interval_promises_no_limits() {
    let folder = Folder::new();
    let asked = "[[question]]\nname = \"f\"\nfragility = \"a\"\nprobability = \"y > 1\"\n";
    let out = told(&folder, "s", &study("a + 2*b", &saltelli(64), asked));
    assert!(out.contains("no interval: saltelli points of a block depend on one another"), "{out}");
    assert!(!out.contains("the limits hold for each"), "{out}");
    let out = told(&folder, "g", &study("a + 2*b", &monte_carlo(200), asked));
    assert!(out.contains("the limits hold for each bin separately"), "{out}");
}

#[test]
fn unknown_names_are_refused_with_what_is_allowed() {
    let folder = Folder::new();
    let refused = |text: &str| {
        let check = say(&["check", &folder.write("wrong.toml", text)]);
        assert_eq!(check.code, 3, "{}{}", check.out, check.err);
        check.err
    };
    let err = refused(&study("a + b", &saltelli(16), &who("sobol").replace("\"y\"", "\"load\"")));
    assert!(err.contains("there is no column `load`") && err.contains("allowed: a column of numbers: y"), "{err}");
    let map = "[[question]]\nname = \"m\"\nmap = [\"a\", \"gap\"]\nof = \"y\"\n";
    let err = refused(&study("a + b", &monte_carlo(16), map));
    assert!(err.contains("allowed: two parameters of numbers: a, b"), "{err}");
    // of many names, those that contain the given word come first
    let rig = fs::read_to_string(root().join("studies/machines/lab_rig.toml")).expect("the rig");
    folder.write("machines/lab_rig.toml", &rig);
    let shipped = fs::read_to_string(root().join("studies/sensitivity.toml")).expect("the study");
    let err = refused(&shipped.replace("sensitivity = \"max_bearing_load_N\"", "sensitivity = \"load\""));
    assert!(err.contains("a column of numbers: max_bearing_load_N, "), "{err}");
    let err = refused(&shipped.replace("sensitivity = \"max_bearing_load_N\"", "sensitivity = \"rub_regime\""));
    assert!(err.contains("`rub_regime` is a column of words, not of numbers"), "{err}");
    assert!(err.contains("allowed: a column of numbers: "), "{err}");
    // the same on the command line
    told(&folder, "g", &study("a + b", &monte_carlo(100), ""));
    let out = folder.name("m.svg");
    let drawn = say(&["map", &folder.name("g"), "--x", "a", "--y", "gap", "--of", "load", "--out", &out]);
    assert_eq!(drawn.code, 3, "{}", drawn.err);
    assert!(drawn.err.contains("two parameters of numbers: a, b; a column of numbers: y"), "{}", drawn.err);
}

/// Labels of many parameters would overlap; intervals of sensitivities are shown although other answers have none.
#[test]
fn of_many_parameters_the_most_decisive_are_named() {
    let folder = Folder::new();
    let names: Vec<String> = (0..12).map(|at| format!("p{at}")).collect();
    let more: String = names
        .iter()
        .map(|name| format!("[[uncertain]]\nname = \"{name}\"\ndistribution = \"uniform\"\nlower = 0\nupper = 1\n"))
        .collect();
    let text = study(&format!("a + b + {}", names.join(" + ")), &morris(12), &(more + &who("morris")));
    told(&folder, "many", &text);
    let page = folder.name("many.html");
    assert_eq!(say(&["report", &folder.name("many"), "--out", &page]).code, 0);
    let text = fs::read_to_string(page).expect("a page");
    assert!(text.contains("The 10 with the largest mu* of 14 are named"));
    let check = say(&["check", &folder.write("s.toml", &study("a + b", &saltelli(64), &who("sobol")))]);
    let words = check.out.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("answers other than sensitivities have no interval"), "{words}");
}

/// A cell without limits in a smoothed map is grey, and a difference counts pairs.
#[test]
fn grey_cells_of_a_smoothed_map_are_explained() {
    let folder = Folder::new();
    let map = "[[vary]]\nname = \"k\"\nvalues = [1, 2]\n[[question]]\nname = \"m\"\nmap = [\"a\", \"b\"]\nof = \"y\"\ndifference = [2, 1]\nvary = \"k\"\n";
    let out = told(&folder, "w", &study("a + sqrt(0.8 - a - 0.1*k*b)*b", &monte_carlo(300), map));
    assert!(out.contains("pairs with a bad run (") && out.contains("bad runs ("), "{out}");
    let file = folder.name("w.svg");
    assert_eq!(say(&["map", &folder.name("w"), "--question", "m", "--out", &file]).code, 0);
    assert!(fs::read_to_string(file).expect("a picture").contains("grey: no limits"));
    let page = folder.name("w.html");
    assert_eq!(say(&["map", &folder.name("w"), "--question", "m", "--out", &page]).code, 0);
    let text = fs::read_to_string(page).expect("a page");
    assert!(text.contains("crosses: pairs with a bad run") && text.contains("grey: no limits"));
    assert!(!text.contains("boundary of the regimes"), "there are none");
    // far from failed runs all cells have limits
    told(&folder, "good", &study("a + b", &monte_carlo(3000), &map.replace("difference = [2, 1]\nvary = \"k\"\n", "")));
    let file = folder.name("good.svg");
    assert_eq!(say(&["map", &folder.name("good"), "--question", "m", "--out", &file]).code, 0);
    assert!(!fs::read_to_string(file).expect("a picture").contains("crosses:"));
}

const GRID: &str = "schema = 1\nname = \"t\"\nmodel = \"function\"\n[function]\ny = \"sqrt(a + b - k)\"\n[[vary]]\nname = \"a\"\nvalues = [1, 2, 3]\n\
                    [[vary]]\nname = \"b\"\nvalues = [1, 2, 3]\n";

#[test]
fn a_map_that_cannot_be_read_needs_no_design_and_first_stands_where_it_stands() {
    let folder = Folder::new();
    let refused = |text: &str| {
        let check = say(&["check", &folder.write("wrong.toml", text)]);
        assert_eq!(check.code, 3, "{}{}", check.out, check.err);
        check.err
    };
    let grid = GRID.replace(" - k", "");
    let err = refused(&format!("{grid}[[question]]\nname = \"m\"\nmap = [\"a\"]\nof = \"y\"\n"));
    assert!(err.contains("question[0].map = [\"a\"]: is an array, not two parameters"), "{err}");
    assert!(!err.contains("random points") && err.contains("1 problem in"), "{err}");
    let map = "[[question]]\nname = \"m\"\nmap = [\"a\", \"b\"]\nof = \"P(y > 2)\"\n";
    let text = format!("{grid}{map}[refine]\nmax_samples = 5\nfirst = [100, 3]\n");
    let line = text.lines().position(|line| line.starts_with("first")).expect("the line") + 1;
    let err = refused(&text);
    assert!(err.contains(&format!("wrong.toml:{line}:9: refine.first: 100 and 3 values come first")), "{err}");
    let err = refused(&text.replace("[100, 3]", "[3, 3]"));
    assert!(err.contains(&format!("wrong.toml:{}:15: refine.max_samples: 9 samples come first", line - 1)), "{err}");
}

#[test]
fn a_points_file_is_offered_nothing_that_is_then_refused() {
    let folder = Folder::new();
    let rig = fs::read_to_string(root().join("studies/machines/lab_rig.toml")).expect("the rig");
    folder.write("lab_rig.toml", &rig);
    let refused = |header: &str, points: &str| {
        folder.write("points.csv", &format!("{header}\n1e-3,2\n2e-3,3\n"));
        let text =
            format!("schema = 1\nname = \"t\"\nmachine = \"lab_rig.toml\"\n[points]\nfile = \"points.csv\"\n{points}");
        let check = say(&["check", &folder.write("p.toml", &text)]);
        assert_eq!(check.code, 3, "{}{}", check.out, check.err);
        check.err
    };
    // columns that the table has already, and names that no column can have
    for name in ["status", "max_bearing_load_N", "Gap [mm]"] {
        let err = refused(&format!("{name},contact.friction"), "");
        assert!(err.contains(&format!("ignore = [\"{name}\"] leaves it out")) && !err.contains("carry ="), "{err}");
    }
    let err = refused("weight,contact.friction", "");
    assert!(err.contains("carry = [\"weight\"] takes the column along"), "{err}");
    // a parameter that another column names is not suggested
    let near = "did you mean `diaphragms.seal.contact.gap`?";
    assert!(refused("contact.gapp,x", "ignore = [\"x\"]\n").contains(near));
    assert!(!refused("contact.gapp,contact.gap", "").contains("did you mean"));
}

/// Differences count pairs; grey is explained if a cell is grey; all keys of a cell are always present.
#[test]
fn a_map_of_differences_says_what_it_counts() {
    let folder = Folder::new();
    let map = "[[vary]]\nname = \"k\"\nvalues = [0, 2.5]\n[limits]\nmax_failed = \"100 %\"\n[[question]]\nname = \"m\"\nmap = [\"a\", \"b\"]\nof = \"P(y > 1)\"\ndifference = [0, 2.5]\nvary = \"k\"\n";
    let out = told(&folder, "share", &format!("{GRID}{map}"));
    let line =
        out.lines().find(|line| line.contains(" less ")).or_else(|| out.lines().find(|line| line.contains("pairs")));
    let line = line.expect("a difference");
    assert!(line.contains("9 pairs, 1 pair with a bad run in 1 cell"), "{out}");
    let draw = |name: &str| {
        let file = folder.name(&format!("{name}.svg"));
        let drawn = say(&["map", &folder.name(name), "--question", "m", "--out", &file]);
        assert_eq!(drawn.code, 0, "{}", drawn.err);
        fs::read_to_string(file).expect("a picture")
    };
    // a share has both figures with any failures
    let picture = draw("share");
    assert!(picture.contains("cross: bad runs, lower left") && picture.contains("grey: left open by bad runs"));
    assert!(picture.contains("18 runs, 1 of them bad"));
    told(&folder, "value", &format!("{GRID}{}", map.replace("P(y > 1)", "y")));
    assert!(draw("value").contains("grey: no number"), "a value has none");
    let page = folder.name("value.html");
    assert_eq!(say(&["report", &folder.name("share"), "--out", &page]).code, 0);
    let text = fs::read_to_string(page).expect("a page");
    assert!(text.contains("9 pairs of runs, 1 of them with a bad run"), "the difference's own picture");
    assert!(!text.contains("0 runs, 0 of them bad"));
    assert!(
        text.replace("&quot;", "\"").contains("\"map\":[\"a\",\"b\"]"),
        "where it comes from has the question whole"
    );
    for name in ["share", "value"] {
        let text = fs::read(folder.path(name).join("answers.json")).unwrap_or_default();
        // without a design answers are only printed
        let json = if text.is_empty() { say(&["answer", &folder.name(name), "--json"]).out.into_bytes() } else { text };
        let answers: Value = serde_json::from_slice(&json).expect("JSON");
        for answer in answers["answers"].as_array().expect("answers") {
            for cell in answer["map"]["cells"].as_array().expect("cells") {
                for key in ["upper", "upper_if_bad_harmful", "regime", "estimate_if_bad_harmful"] {
                    assert!(cell.get(key).is_some(), "{key} is not in {cell}");
                }
            }
        }
    }
}
