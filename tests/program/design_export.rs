//! `design export`: points for SALib and Dakota, from a study file and from results.

use crate::support::{Folder, json, say, table};
use std::fs;

const STUDY: &str = r#"schema = 1
model = "function"
seed = 5

[function]
g = "sqrt(a) + b + c + d + t + f"

[[uncertain]]
name = "a"
distribution = "uniform"
lower = -1
upper = 3

[[uncertain]]
name = "b"
distribution = "normal"
mean = 2
sd = 0.5

[[uncertain]]
name = "c"
distribution = "normal"
mean = 0
sd = 1
lower = -1
upper = 4

[[uncertain]]
name = "d"
distribution = "lognormal"
median = 2
cv = 0.3

[[uncertain]]
name = "t"
distribution = "triangular"
lower = 1
mode = 2
upper = 5

[[uncertain]]
name = "f"
distribution = "gumbel"
location = 2
scale = 0.1

[[uncertain]]
name = "r"
distribution = "weibull"
shape = 2
scale = 3

[[uncertain]]
name = "s"
distribution = "exponential"
mean = 4

[[uncertain]]
name = "l"
distribution = "log-uniform"
lower = 0.1
upper = 10

[[vary]]
name = "w"
values = [1, 2]

[design]
kind = "monte-carlo"
samples = 8

[limits]
max_failed = "100 %"
"#;

#[test]
fn a_design_is_written_as_salib_and_dakota_have_it() {
    let folder = Folder::new();
    let (study, out) = (folder.write("s.toml", STUDY), folder.name("design"));
    let said = say(&["design", "export", &study, "--out", &out]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.err.contains("left out of the SALib problem: f: SALib has no such distribution"), "{}", said.err);
    let text = fs::read_to_string(folder.path("design/salib-problem.json")).expect("written");
    let problem = json(&text);
    assert_eq!(problem["num_vars"], 8);
    assert_eq!(problem["names"], serde_json::json!(["a", "b", "c", "d", "t", "r", "s", "l"]));
    assert_eq!(
        problem["dists"],
        serde_json::json!(["unif", "norm", "truncnorm", "lognorm", "triang", "weibull", "weibull", "logunif"])
    );
    let bounds = |at: usize| -> Vec<f64> {
        problem["bounds"][at]
            .as_array()
            .expect("a list")
            .iter()
            .map(|bound| bound.as_f64().expect("a number"))
            .collect()
    };
    assert_eq!((bounds(0), bounds(1), bounds(2)), (vec![-1.0, 3.0], vec![2.0, 0.5], vec![-1.0, 4.0, 0.0, 1.0]));
    // median 2: the mean of ln x is ln 2; coefficient of variation 0.3: the variance of ln x is ln 1.09
    let log = bounds(3);
    assert!((log[0] - 2f64.ln()).abs() < 1e-15 && (log[1] - 1.09f64.ln().sqrt()).abs() < 1e-15, "{log:?}");
    // the peak as a fraction of the width
    assert_eq!(bounds(4), [1.0, 5.0, 0.25]);
    // shape and scale; for the exponential distribution 1 and its mean
    assert_eq!((bounds(5), bounds(6), bounds(7)), (vec![2.0, 3.0], vec![1.0, 4.0], vec![0.1, 10.0]));
    let csv = fs::read_to_string(folder.path("design/salib-points.csv")).expect("written");
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!((lines[0], lines.len()), ("a,b,c,d,t,r,s,l", 9));
    let dakota = fs::read_to_string(folder.path("design/dakota.dat")).expect("written");
    let rows: Vec<&str> = dakota.lines().collect();
    assert_eq!((rows[0], rows.len()), ("%eval_id interface a b c d t f r s l w", 17));
    assert!(
        rows[1].starts_with(&format!("1 NO_ID {} ", lines[1].split(',').take(5).collect::<Vec<_>>().join(" ")))
            && rows[1].ends_with(&format!(" {} 1.0", lines[1].split(',').skip(5).collect::<Vec<_>>().join(" "))),
        "{}",
        rows[1]
    );
    // no file is overwritten, and a study without points is rejected
    let again = say(&["design", "export", &study, "--out", &out]);
    assert!(again.code == 3 && again.err.contains("already exists"), "{} {}", again.code, again.err);
    let grid = folder.small_study();
    let none = say(&["design", "export", &grid, "--out", &folder.name("none")]);
    assert!(none.code == 3 && none.err.contains("no [design]") && !folder.path("none").exists(), "{}", none.err);
    let early = say(&["design", "export", &study, "--out", &folder.name("early"), "--response", "g"]);
    assert!(early.code == 3 && early.err.contains("a study file has no results"), "{}", early.err);
}

#[test]
fn responses_are_those_of_the_table_and_nan_where_a_run_failed() {
    let folder = Folder::new();
    let (study, run, out) = (folder.write("s.toml", STUDY), folder.name("run"), folder.name("design"));
    assert_eq!(say(&["run", &study, "--out", &run]).code, 0);
    let said = say(&["design", "export", &run, "--out", &out, "--response", "g"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let (header, rows) = table(&run);
    let place = |name: &str| header.iter().position(|column| column == name).expect("a column");
    assert!(rows.iter().any(|row| row[place("status")] == "failed"), "the root of a negative number");
    let dakota = fs::read_to_string(folder.path("design/dakota.dat")).expect("written");
    for (line, row) in dakota.lines().skip(1).zip(&rows) {
        let cells: Vec<&str> = line.split(' ').collect();
        let wanted = if row[place("status")] == "ok" { row[place("g")].as_str() } else { "nan" };
        assert_eq!((cells[2], cells[cells.len() - 1]), (row[place("a")].as_str(), wanted), "{line}");
    }
    assert_eq!(dakota.lines().count(), 1 + rows.len());
    let wrong = say(&["design", "export", &run, "--out", &folder.name("other"), "--response", "status"]);
    assert!(wrong.code == 3 && wrong.err.contains("no column of numbers"), "{}", wrong.err);
}
