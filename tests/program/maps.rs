//! Maps of studies, end to end: requested in a file or on the command line, drawn, rejected.

use crate::support::{Folder, json, say};
use std::fs;

/// A step along x, a plane along y, on a grid without a design; the points with the largest x have no value.
const GRID: &str = r#"schema = 1
model = "function"
name = "step"

[function]
z = "if_step + 0.25*y"
root = "sqrt(2.9 - x)"

[[vary]]
name = "x"
values = [0, 1, 2, 3]

[[vary]]
name = "y"
values = [0, 1, 2]

[[derived]]
name = "if_step"
formula = "max(0, min(1, 1e6*(x - 1.5)))"

[limits]
max_failed = "100 %"
"#;

/// 600 scattered points.
const POINTS: &str = r#"schema = 1
model = "function"
seed = 5

[design]
kind = "monte-carlo"
samples = 600

[function]
z = "2*x + y"

[[uncertain]]
name = "x"
distribution = "uniform"
lower = 0
upper = 1

[[uncertain]]
name = "y"
distribution = "uniform"
lower = 0
upper = 1

[[question]]
name = "plane"
map = ["x", "y"]
of = "z"

[[question]]
name = "over"
map = ["x", "y"]
of = "P(z > 1.5)"
"#;

#[test]
fn a_grid_is_drawn_as_it_is() {
    let folder = Folder::new();
    let question = "\n[[question]]\nname = \"steps\"\nmap = [\"x\", \"y\"]\nof = \"z\"\n";
    let study = folder.write("s.toml", &format!("{GRID}{question}"));
    let out = folder.name("out");
    let ran = say(&["run", &study, "--out", &out, "--workers", "2"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert!(ran.out.contains("Answers, of 12 samples:"), "{}", ran.out);
    assert!(ran.out.contains("12 cells, 12 runs, 3 bad runs in 3 cells"), "{}", ran.out);
    assert!(ran.out.contains("; open, because of bad runs, in 25 % of the cells;"), "{}", ran.out);
    let answers = json(&fs::read_to_string(folder.path("out/answers.json")).expect("written"));
    let cells = answers["answers"][0]["map"]["cells"].as_array().expect("cells").clone();
    assert_eq!(cells.len(), 12);
    for cell in &cells {
        let (x, y) = (cell["x"].as_f64().expect("a number"), cell["y"].as_f64().expect("a number"));
        let expected = if x > 2.5 { None } else { Some(if x > 1.5 { 1.0 } else { 0.0 } + 0.25 * y) };
        assert_eq!((cell["estimate"].as_f64(), cell["bad"].as_u64()), (expected, Some(u64::from(x > 2.5))), "{cell}");
    }
    for extension in ["svg", "png"] {
        let file = folder.name(&format!("m.{extension}"));
        let drawn = say(&["map", &out, "--out", &file]);
        assert!(drawn.code == 0 && drawn.out.contains(&format!("m.{extension}")), "{}", drawn.err);
    }
    let svg = fs::read_to_string(folder.path("m.svg")).expect("written");
    assert!(svg.contains("step: steps") && svg.contains("12 runs, 3 of them bad"), "{svg}");
    assert!(fs::read(folder.path("m.png")).expect("written").starts_with(b"\x89PNG"));
}

#[test]
fn scattered_points_are_smoothed_and_the_same_on_any_workers() {
    let folder = Folder::new();
    let study = folder.write("s.toml", POINTS);
    let (one, three) = (folder.name("one"), folder.name("three"));
    assert_eq!(say(&["run", &study, "--out", &one, "--workers", "1"]).code, 0);
    assert_eq!(say(&["run", &study, "--out", &three, "--workers", "3"]).code, 0);
    let read = |name: &str| fs::read(folder.path(name)).expect("written");
    assert_eq!(read("one/answers.json"), read("three/answers.json"));
    let answers = json(&String::from_utf8(read("one/answers.json")).expect("text"));
    let cells = answers["answers"][0]["map"]["cells"].as_array().expect("cells").clone();
    assert!(cells.len() > 1000, "{}", cells.len());
    for cell in &cells {
        let number = |key: &str| cell[key].as_f64().expect("a number");
        assert!((number("estimate") - 2.0 * number("x") - number("y")).abs() < 1e-9, "{cell}");
    }
    let drawn = |name: &str, of: &[&str]| {
        let file = folder.name(name);
        let words = [&["map", &one, "--out", &file], of].concat();
        let said = say(&words);
        assert_eq!(said.code, 0, "{}", said.err);
        fs::read_to_string(folder.path(name)).expect("written")
    };
    let asked = drawn("a.svg", &["--question", "over"]);
    let worded = drawn("b.svg", &["--x", "x", "--y", "y", "--of", "P(z > 1.5)"]);
    // everything but the text, because the titles differ
    let body = |svg: &str| svg.lines().filter(|line| line.starts_with("<rect") || line.starts_with("<poly")).count();
    assert!(asked.contains("half width of its limits"));
    assert_eq!(
        worded.matches("P(z &gt; 1.5)").count(),
        3,
        "the title, shown and as name of the picture, and what the colours are: {worded}"
    );
    assert!(body(&asked) > 1000 && body(&asked) == body(&worded));
}

#[test]
fn what_is_wrong_with_a_map_is_told() {
    let folder = Folder::new();
    let study = folder.write("s.toml", POINTS);
    let out = folder.name("out");
    assert_eq!(say(&["run", &study, "--out", &out, "--workers", "1"]).code, 0);
    let file = folder.name("m.svg");
    let pdf = folder.name("m.pdf");
    for (words, part) in [
        (vec!["--x", "xx", "--y", "y", "--of", "z"], "`xx` is not a varied parameter or variable of this study"),
        (vec!["--x", "x", "--y", "y", "--of", "zz"], "there is no column `zz`"),
        (vec!["--x", "x", "--y", "y", "--of", "P(z > )"], "--of P(z > )"),
        (vec!["--x", "x", "--y", "y", "--of", "P(z > 2"], "--of P(z > 2: its bracket is not closed: P(CONDITION)"),
        (vec!["--x", "x", "--y", "y", "--of", "P(z > 2) - 1"], "`- 1` follows P(CONDITION)"),
        (vec!["--x", "x", "--y", "y", "--of", "z", "--confidence", "95"], "95 is not between 0 and 1"),
        (vec!["--question", "oper"], "asks for no map of this name"),
        (vec![], "asks for 2 maps"),
        (vec!["--x", "x"], "--y"),
        (vec!["--out", pdf.as_str()], ".svg, .png or .html"),
    ] {
        let mut all = vec!["map", out.as_str()];
        if !words.contains(&"--out") {
            all.extend(["--out", file.as_str()]);
        }
        all.extend(words);
        let said = say(&all);
        // an invalid option has exit code 2; a request that does not fit the study has exit code 3
        let code = if part == "--y" { 2 } else { 3 };
        assert!(said.code == code && said.err.contains(part), "{part}\n{} {}", said.code, said.err);
    }
    assert!(!folder.path("m.svg").exists());
    // in a file, each error is reported at its place
    let wrong = POINTS.replace("P(z > 1.5)", "P(q > 1.5)").replace("of = \"z\"", "of = \"zz\"");
    let told = say(&["check", &folder.write("w.toml", &wrong)]);
    assert_eq!(told.code, 3, "{}", told.err);
    for part in ["question[0].of", "there is no column `zz`", "question[1].of", "`q`"] {
        assert!(told.err.contains(part), "{part}\n{}", told.err);
    }
    let other = format!("{GRID}\n[[question]]\nname = \"a\"\nmean = \"z\"\n");
    let told = say(&["check", &folder.write("g.toml", &other)]);
    assert!(told.code == 3 && told.err.contains("questions and gates need random points"), "{}", told.err);
}

#[test]
fn a_hostile_name_stays_text() {
    let folder = Folder::new();
    let hostile = "</svg><script>alert(1)</script>";
    let text = format!(
        "{GRID}\n[[question]]\nname = \"a\"\nmap = [\"x\", \"y\"]\nof = \"z\"\n\n[[vary]]\nname = \"w\"\nvalues = [1, 2]\n"
    );
    let study = folder.write("s.toml", &text);
    let out = folder.name("out");
    assert_eq!(say(&["run", &study, "--out", &out, "--workers", "1"]).code, 0);
    // a condition is displayed as it is written
    let file = folder.name("m.svg");
    let of = format!("P(z > 0.5 and `{hostile}` > 1)");
    let refused = say(&["map", &out, "--x", "x", "--y", "y", "--of", &of, "--out", &file]);
    assert!(refused.code == 3 && !folder.path("m.svg").exists(), "{}", refused.err);
    let of = "P(z > 0.5 and 1 < 2)";
    let drawn = say(&["map", &out, "--x", "x", "--y", "y", "--of", of, "--out", &file]);
    assert_eq!(drawn.code, 0, "{}", drawn.err);
    let page = folder.name("m.html");
    let drawn = say(&["map", &out, "--x", "x", "--y", "y", "--of", of, "--out", &page]);
    assert_eq!(drawn.code, 0, "{}", drawn.err);
    let html = fs::read_to_string(&page).expect("written");
    assert!(html.contains("\"heatmap\"") && html.contains("P(z &gt; 0.5 and 1 &lt; 2)") && !html.contains("1 < 2"));
    let svg = fs::read_to_string(&file).expect("written");
    assert!(svg.contains("1 &lt; 2") && !svg.contains("1 < 2") && svg.contains("w = 1: share"), "{svg}");
}
