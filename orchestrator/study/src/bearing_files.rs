//! CSV files that a machine file names for its bearing tables: the names are replaced by the lists in these files.
//!
//! ```text
//! [rotor.bearings.front]                      [rotor.bearings.front]
//! kind = "table"                              kind = "table"
//! table = "front.csv"              ->         (blank)
//! ...                                         ...
//!                                             [rotor.bearings.front.coefficients]      at the end of the file
//!                                             speeds = [...]
//! ```
//! So the lines of the file keep their numbers, and later code knows one form of a table. Results, workers and a replay need no further file, and
//! the identity of the machine includes the content of the CSV file.

use crate::csv::{Cell, Csv};
use crate::input::read_input;
use crate::kind::{FileKind, kind_of};
use bladeoff_text::document::units::{format_digits, parse_quantity};
use bladeoff_text::document::{Collector, Entry, Problems, Value, cut, parse_toml};
use std::fmt::Write;
use std::ops::Range;
use std::path::{Component, Path};

/// Largest file of a table.
const MOST_BYTES: u64 = 1 << 20;
/// Most rows, as for the lists in a machine file.
const MOST_ROWS: usize = 10_000;
/// Names of the column of speeds, and key of the list.
const SPEEDS: ([&str; 2], &str) = (["speed", "frequency"], "speeds");
/// Columns of coefficients, whose lists have the same names.
const COEFFICIENTS: [&str; 8] = ["kxx", "kxy", "kyx", "kyy", "cxx", "cxy", "cyx", "cyy"];

/// The text of a machine file with the lists of its tables. `path`: the machine file; paths of tables are relative to it.
///
/// # Errors
/// A file that is missing, too large, or not a table.
pub fn with_tables(path: &Path, text: String) -> Result<String, Problems> {
    let shown = path.to_string_lossy();
    // the reader of machine files reports mistakes of the file itself, together with all others
    let Ok((document, mut problems)) = parse_toml(&shown, &text) else { return Ok(text) };
    if !problems.is_empty() {
        return Ok(text);
    }
    let (mut lists, mut in_table) = (Vec::new(), None);
    for bearing in named(document.value.as_table().unwrap_or_default(), &["rotor", "bearings"]) {
        let entries = bearing.node.value.as_table().unwrap_or_default();
        let Some(entry) = entries.iter().find(|entry| entry.name == "table") else { continue };
        let Value::Text(name) = &entry.node.value else { continue };
        let key = format!("rotor.bearings.{}.table", cut(&bearing.name, 80));
        if text[bearing.node.span.clone()].starts_with('{') {
            let problem =
                problems.add(entry.node.span.clone(), key, "a bearing with a table in a file is a table with a header");
            problem.allowed = Some("[rotor.bearings.NAME]".to_owned());
            continue;
        }
        if entries.iter().any(|entry| entry.name == "coefficients") {
            let problem = problems.add(entry.node.span.clone(), key, "the bearing has a table of its own");
            problem.allowed = Some("table = \"FILE.csv\", or [rotor.bearings.NAME.coefficients]".to_owned());
        } else {
            match read_table(path, name, entry, &key, &mut problems) {
                Some(Ok(block)) => {
                    lists.push((entry.name_span.start..entry.node.span.end, bearing.name.clone(), block));
                }
                Some(Err(problems)) => in_table = in_table.or(Some(problems)),
                None => {}
            }
        }
    }
    problems.finish()?;
    match in_table {
        Some(problems) => Err(problems),
        None => Ok(replaced(text, lists)),
    }
}

/// The entries of a table within tables.
fn named<'a>(mut entries: &'a [Entry], path: &[&str]) -> &'a [Entry] {
    for step in path {
        let found = entries.iter().find(|entry| entry.name == *step);
        entries = found.and_then(|entry| entry.node.value.as_table()).unwrap_or_default();
    }
    entries
}

/// Replaces the names by blanks and appends the lists.
fn replaced(mut text: String, lists: Vec<(Range<usize>, String, String)>) -> String {
    for (span, bearing, block) in lists {
        let blank = " ".repeat(span.len());
        text.replace_range(span, &blank);
        write!(text, "\n[rotor.bearings.{bearing}.coefficients]\n{block}").expect("writing to a string cannot fail");
    }
    text
}

/// The lists of one file, or the problems in it; `None`: a problem of its name was added.
fn read_table(
    machine: &Path,
    name: &str,
    entry: &Entry,
    key: &str,
    problems: &mut Collector<'_>,
) -> Option<Result<String, Problems>> {
    let span = entry.node.span.clone();
    let mut fail = |message: String, allowed: &str| {
        let problem = problems.add(span.clone(), key, message);
        problem.value = Some(format!("{:?}", cut(name, 120)));
        problem.allowed = Some(allowed.to_owned());
    };
    let is_below = Path::new(name).components().all(|step| matches!(step, Component::Normal(_)));
    if name.is_empty() || !is_below {
        fail(
            "leads out of the directory of the machine file".to_owned(),
            "a name relative to the machine file, without `..`",
        );
        return None;
    }
    let file = machine.parent().unwrap_or(Path::new("")).join(name);
    let text = match read_input(&file, MOST_BYTES) {
        Ok(text) => text,
        Err(error) => {
            fail(error.to_string(), "a CSV file beside the machine file");
            return None;
        }
    };
    if kind_of(&text) == Some(FileKind::Ross) {
        fail(
            "is a file saved by ROSS; write the arrays frequency, kxx, kyy, cxx, ... of its bearing as columns of a CSV file".to_owned(),
            ALLOWED,
        );
        return None;
    }
    let named_by = format!("table of {}", key.trim_end_matches(".table"));
    Some(lists(&file.to_string_lossy(), &text, &named_by))
}

/// Contents of the file of a table, in words.
const ALLOWED: &str = "a CSV file with the columns speed, kxx, kyy and further coefficients, a row for each speed";

/// One column that is read: key, position in a row, unit, numbers.
struct Column {
    key: &'static str,
    place: usize,
    unit: Option<String>,
    numbers: Vec<f64>,
}

/// Problems of a table, each at its cell.
struct TableProblems<'a> {
    found: Collector<'a>,
    named_by: &'a str,
}

impl TableProblems<'_> {
    fn add(&mut self, span: Range<usize>, key: &str, message: &str, allowed: impl Into<String>) {
        let value = self.found.excerpt(span.clone());
        let problem = self.found.add(span, key, format!("{message} ({})", self.named_by));
        problem.value = Some(value).filter(|value| !key.is_empty() && !value.is_empty());
        problem.allowed = Some(allowed.into());
    }
}

/// The lists of a file as TOML; all problems at once.
fn lists(file: &str, text: &str, named_by: &str) -> Result<String, Problems> {
    let mut problems = TableProblems { found: Collector::new(file, text), named_by };
    let columns = columns(text, &mut problems);
    problems.found.finish()?;
    let mut block = String::new();
    for Column { key, numbers, .. } in columns {
        let numbers: Vec<String> = numbers.iter().map(|number| format!("{number:?}")).collect();
        writeln!(block, "{key} = [{}]", numbers.join(", ")).expect("writing to a string cannot fail");
    }
    Ok(block)
}

/// The columns of a file with their numbers; incomplete if a problem was added.
fn columns(text: &str, problems: &mut TableProblems<'_>) -> Vec<Column> {
    let Some(csv) = Csv::new(text, &mut problems.found) else { return Vec::new() };
    let mut columns: Vec<Column> = Vec::new();
    let (mut rows, mut width, mut end) = (0, 0, 0..0);
    for line in csv.lines() {
        end = line.clone();
        let cells = csv.header(line.clone());
        if columns.is_empty() {
            columns = header(&line, &cells, problems);
            width = cells.len();
            if !problems.found.is_empty() {
                return columns;
            }
            continue;
        }
        // a decimal comma in a file separated by commas splits a number into two cells
        if cells.len() > width {
            problems.add(line, "", &format!("{} cells, the header has {width}", cells.len()), format!("{width} cells"));
            continue;
        }
        if rows == 0 && is_units(&columns, &cells) {
            take_units(&mut columns, &cells, problems);
            continue;
        }
        rows += 1;
        for column in &mut columns {
            let at = cells.get(column.place).map_or(line.end..line.end, |cell| cell.span.clone());
            let cell = cells.get(column.place).map_or("", |cell| cell.text.trim());
            match value(column, cell) {
                Ok(value) => {
                    let before = column.numbers.last().filter(|before| column.key == SPEEDS.1 && value <= **before);
                    if before.is_some() {
                        problems.add(at, column.key, "not above the speed of the row before", "ascending speeds");
                    }
                    column.numbers.push(value);
                }
                Err((message, allowed)) => problems.add(at, column.key, &message, allowed),
            }
        }
    }
    if columns.is_empty() {
        problems.add(0..text.len().min(1), "", "no header with the column kxx", ALLOWED);
    } else if !(2..=MOST_ROWS).contains(&rows) {
        let message = format!("the table has {}", counted(rows));
        problems.add(end, "", &message, format!("2 to {MOST_ROWS} rows of numbers below the header"));
    }
    columns
}

fn counted(rows: usize) -> String {
    if rows == 1 { "1 row of numbers".to_owned() } else { format!("{rows} rows of numbers") }
}

/// The units of a row below the header.
fn take_units(columns: &mut [Column], cells: &[Cell<'_>], problems: &mut TableProblems<'_>) {
    for column in columns {
        let Some(cell) = cells.get(column.place) else { continue };
        let unit = Some(cell.text.trim().to_owned()).filter(|unit| !unit.is_empty());
        if let (Some(in_header), Some(unit)) = (&column.unit, &unit)
            && in_header != unit
        {
            let message = format!("is in {in_header} by the header and in {unit} here");
            problems.add(cell.span.clone(), column.key, &message, "one unit");
        }
        column.unit = unit.or(column.unit.take());
    }
}

/// The columns to be read, from the header line; none if the header is missing.
fn header(line: &Range<usize>, cells: &[Cell<'_>], problems: &mut TableProblems<'_>) -> Vec<Column> {
    let parts: Vec<(String, Option<String>)> = cells
        .iter()
        .map(|cell| match cell.text.trim().split_once('[') {
            Some((name, unit)) => (name.trim().to_lowercase(), Some(unit.trim_end_matches(']').trim().to_owned())),
            None => (cell.text.trim().to_lowercase(), None),
        })
        .collect();
    let mut columns: Vec<Column> = Vec::new();
    if !parts.iter().any(|(name, _)| name == "kxx") {
        return columns;
    }
    for (place, (name, unit)) in parts.into_iter().enumerate() {
        let span = cells[place].span.clone();
        let key = if SPEEDS.0.contains(&name.as_str()) {
            SPEEDS.1
        } else if let Some(key) = COEFFICIENTS.into_iter().find(|key| *key == name) {
            key
        } else if is_like_a_coefficient(&name) {
            let allowed = format!("{}; write the unit in square brackets", COEFFICIENTS.join(", "));
            problems.add(span, "header", "not the name of a coefficient", allowed);
            continue;
        } else {
            continue;
        };
        if columns.iter().any(|column| column.key == key) {
            problems.add(span, "header", &format!("a second column for {key}"), "one column");
            continue;
        }
        let column = Column { key, place, unit, numbers: Vec::new() };
        if let Err((message, allowed)) = value(&column, "0") {
            problems.add(span, "header", &message, allowed);
        }
        columns.push(column);
    }
    for (key, name) in [(SPEEDS.1, "speed or frequency"), ("kyy", "kyy")] {
        if columns.iter().all(|column| column.key != key) {
            problems.add(line.clone(), "", &format!("no column {name}"), ALLOWED);
        }
    }
    // a cross coefficient without its partner is more likely a misspelled header than a real bearing
    for (key, partner) in [("kxy", "kyx"), ("kyx", "kxy"), ("cxy", "cyx"), ("cyx", "cxy")] {
        let has = |key: &str| columns.iter().any(|column| column.key == key);
        if has(key) && !has(partner) {
            problems.add(
                line.clone(),
                "",
                &format!("a column {key} without {partner}"),
                "both, with zeros if necessary",
            );
        }
    }
    columns
}

/// Whether a column name looks like a misspelled coefficient: `c_xx`, `cxxx`, `kxz`, `cxx(n s/m)`. `kzz` and `czz` are axial.
fn is_like_a_coefficient(name: &str) -> bool {
    let plain: String = name.split('(').next().unwrap_or_default().chars().filter(|c| c.is_alphanumeric()).collect();
    let indices = plain.strip_prefix(['k', 'c']).unwrap_or_default();
    !indices.is_empty() && indices != "zz" && indices.chars().all(|c| matches!(c, 'x' | 'y' | 'z'))
}

/// Whether a row has units instead of numbers.
fn is_units(columns: &[Column], cells: &[Cell<'_>]) -> bool {
    let is_number = |cell: &str| cell.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    columns.iter().all(|column| cells.get(column.place).is_some_and(|cell| !is_number(cell.text.trim())))
        && columns.iter().any(|column| cells.get(column.place).is_some_and(|cell| !cell.text.trim().is_empty()))
}

/// A number of a column in SI; or the mistake and the allowed values.
fn value(column: &Column, cell: &str) -> Result<f64, (String, String)> {
    let (unit, [least, most]) = match column.key.as_bytes()[0] {
        b's' => ("rad/s", [0.0, 1e6]),
        b'k' => ("N/m", [-1e18, 1e18]),
        _ => ("N s/m", [-1e18, 1e18]),
    };
    let allowed = || format!("a number, {} to {} {unit}", format_digits(least, "", 3), format_digits(most, "", 3));
    let number: f64 = match cell.replace(',', ".").parse() {
        Ok(number) if f64::is_finite(number) => number,
        _ if cell.is_empty() => return Err(("no value".to_owned(), allowed())),
        _ => return Err(("not a number".to_owned(), allowed())),
    };
    let number = match &column.unit {
        None => number,
        Some(given) => {
            // in tables of bearings, lb is a force
            let given = if unit == "rad/s" { given.clone() } else { given.replace("lb", "lbf").replace("lbff", "lbf") };
            let found = parse_quantity(&format!("{number:e} {given}"), unit);
            found.map_err(|error| (error.to_string(), format!("{unit}, or a unit of the same kind")))?
        }
    };
    if (least..=most).contains(&number) { Ok(number) } else { Err(("out of range".to_owned(), allowed())) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    const MACHINE: &str = "schema = 1\nname = \"m\"\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 1\n\
        initial_speed = 10\n[rotor.bearings.one]\nkind = \"table\"\ntable = \"tables/one.csv\"\ninterpolation = \"pchip\"\n[braking]\nlinear = 1\n";

    #[test]
    fn lists_stand_in_the_place_of_the_name() {
        let directory = tempfile::tempdir().expect("a directory");
        std::fs::create_dir(directory.path().join("tables")).expect("made");
        let (machine, file) = (directory.path().join("m.toml"), directory.path().join("tables/one.csv"));
        std::fs::write(&file, "# by a film\nSpeed,Kxx,Kyy,Cxx,Mxx,Cyy\nrpm,lb/in,N/m,N-s/m,kg,lb-s/in\n0,10,1e3,5,7,1\n300,20,3e3,6,7,2\n").expect("written");
        let text = with_tables(&machine, MACHINE.to_owned()).expect("a table");
        assert_eq!(text.lines().count(), MACHINE.lines().count() + 7);
        let lines = |text: &str| text.lines().position(|line| line == "[braking]");
        assert_eq!(lines(&text), lines(MACHINE));
        let built = MachineDef::parse("m.toml", &text)
            .unwrap_or_else(|problems| panic!("{problems}\n{text}"))
            .build()
            .expect("valid");
        let table = built.rotor.bearings[0].table.as_ref().expect("a table");
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
        close(table.range()[1], 300.0 * std::f64::consts::PI / 30.0);
        let at = table.at(table.range()[1]);
        // 1 lbf/in = 175.12683524647636 N/m
        close(at.stiffness[0][0], 20.0 * 175.12683524647636);
        close(at.stiffness[1][1], 3e3);
        close(at.damping[0][0], 6.0);
        close(at.damping[1][1], 2.0 * 175.12683524647636);
        // other content gives another machine; the same content in a file with another name gives the same machine
        let identity = |text: &str| MachineDef::parse("m.toml", text).expect("valid").identity(0);
        std::fs::write(directory.path().join("tables/two.csv"), std::fs::read(&file).expect("read")).expect("written");
        let two = with_tables(&machine, MACHINE.replace("one.csv", "two.csv")).expect("a table");
        assert_eq!(identity(&text), identity(&two));
        // lines that begin with # are comments anywhere, without effect on the machine
        let (commented, rows) =
            (directory.path().join("tables/two.csv"), std::fs::read_to_string(&file).expect("read"));
        std::fs::write(
            &commented,
            format!("# source: film 3; kxx, kyy\n{}# end, of it\n", rows.replace("\n300", "\n # 5,6\n300")),
        )
        .expect("written");
        let two = with_tables(&machine, MACHINE.replace("one.csv", "two.csv")).expect("a table");
        assert_eq!(identity(&text), identity(&two));
        std::fs::write(&file, "speed [rpm];kxx;kyy\n0;1;2\n300;1,5;2\n").expect("written");
        let other = with_tables(&machine, MACHINE.to_owned()).expect("a table");
        assert!(other.contains("kxx = [1.0, 1.5]"), "{other}");
        assert_ne!(identity(&text), identity(&other));
    }

    #[test]
    fn files_that_are_no_tables_are_reported_where_they_are_named() {
        let directory = tempfile::tempdir().expect("a directory");
        let machine = directory.path().join("m.toml");
        std::fs::create_dir(directory.path().join("tables")).expect("made");
        let problem = |text: &str| with_tables(&machine, text.to_owned()).expect_err("a problem").to_string();
        assert!(
            problem(MACHINE).contains("m.toml:12:9: rotor.bearings.one.table = \"tables/one.csv\": there is no file"),
            "{}",
            problem(MACHINE)
        );
        for name in ["../one.csv", "/one.csv", ""] {
            let found = problem(&MACHINE.replace("tables/one.csv", name));
            assert!(found.contains("leads out of the directory"), "{found}");
        }
        for (content, message) in [
            ("speed,kxx,kxz,kyy\n1,2,3,4\n2,3,4,5\n", "not the name of a coefficient"),
            ("speed,kxx,kyx,kyy\n1,2,3,4\n2,3,4,5\n", "a column kyx without kxy"),
            ("a,b\n1,2\n", "one.csv:1:1: no header with the column kxx (table of rotor.bearings.one)"),
            ("kxx,kyy\n1,2\n", "one.csv:1:1: no column speed or frequency"),
            ("speed,kxx\n1,2\n", "one.csv:1:1: no column kyy"),
            ("speed,frequency,kxx,kyy\n1,2,3\n", "one.csv:1:7: header = frequency: a second column for speeds"),
            (
                "speed,kxx,kyy\n1,2,3\n\n3,x,3\n",
                "one.csv:4:3: kxx = x: not a number (table of rotor.bearings.one); allowed: a number, -1e18 to 1e18 N/m",
            ),
            ("speed,kxx,kyy\n1,2,3\n2,3,\n", "one.csv:3:5: kyy: no value"),
            ("speed,kxx,kyy\n1,2,3\n2,3\n", "one.csv:3:4: kyy: no value"),
            ("speed,kxx,kyy\n1,2,1e300\n2,3,4\n", "one.csv:2:5: kyy = 1e300: out of range"),
            ("speed,kxx,kyy\n2,2,3\n1,3,4\n", "one.csv:3:1: speeds = 1: not above the speed of the row before"),
            ("speed,kxx [kg],kyy\n1,2,3\n", "one.csv:1:7: header = kxx [kg]: "),
            ("speed,kxx,kyy\n", "one.csv:1:1: the table has 0 rows of numbers"),
            ("speed,kxx,kyy\n1,2,3\n", "one.csv:2:1: the table has 1 row of numbers"),
        ] {
            std::fs::write(directory.path().join("tables/one.csv"), content).expect("written");
            assert!(problem(MACHINE).contains(message), "{content}: {}", problem(MACHINE));
        }
        // all problems of a file at once
        std::fs::write(directory.path().join("tables/one.csv"), "speed,kxx,kyy\n1,x,3\n0,3,y\n").expect("written");
        assert_eq!(problem(MACHINE).lines().count(), 3, "{}", problem(MACHINE));
        for ross in [
            "[\"BearingElement_Bearing 0\"]\nn = 0\nkxx = [1e6, 2e6]\nfrequency = [0, 300]\n",
            "{\"BearingElement_Bearing 0\": {\"n\": 0, \"kxx\": [1e6, 2e6], \"frequency\": [0, 300]}}",
        ] {
            std::fs::write(directory.path().join("tables/one.csv"), ross).expect("written");
            let found = problem(MACHINE);
            assert!(
                found.contains("m.toml:12:9") && found.contains("is a file saved by ROSS; write the arrays"),
                "{found}"
            );
        }
        // a bearing in braces, two sources, and no table at all
        let braces = "[rotor.bearings]\none = { kind = \"table\", table = \"tables/one.csv\" }\n";
        assert!(problem(braces).contains("is a table with a header"), "{}", problem(braces));
        let both = format!("{MACHINE}[rotor.bearings.one.coefficients]\nspeeds = [0, 20]\n");
        assert!(problem(&both).contains("the bearing has a table of its own"));
        let plain = MACHINE.replace("table = \"tables/one.csv\"\n", "");
        assert_eq!(with_tables(&machine, plain.clone()).expect("untouched"), plain);
        assert_eq!(with_tables(&machine, "not toml [".to_owned()).expect("untouched"), "not toml [");
    }

    #[test]
    fn what_reads_like_a_coefficient_is_never_left_out_in_silence() {
        let message = |text: &str| lists("t.csv", text, "table of b").expect_err(text).to_string();
        let wide = message("speed,kxx,kyy\n0,2,5e6,2,1e6\n400,2,5e6,2,1e6\n");
        assert!(wide.starts_with("t.csv:2:1: 5 cells, the header has 3"), "{wide}");
        for name in ["c_xx", "cxxx", "Cxx(N s/m)", "K-xy"] {
            let found = message(&format!("speed,kxx,kyy,{name}\n0,1,1,1\n1,1,1,1\n"));
            assert!(found.contains("not the name of a coefficient"), "{name}: {found}");
        }
        let twice = message("speed [rpm],kxx,kyy\nrad/s,N/m,N/m\n0,1,1\n1,1,1\n");
        assert!(twice.contains("is in rpm by the header and in rad/s here"), "{twice}");
        let whole = lists("t.csv", "speed,kxx,kyy,mxx,critical\n0,1,1,1,1\n1,1,1,1,1\n", "table of b");
        assert!(whole.is_ok());
    }
}
