//! `replay`: a sample of a study is computed again, bit for bit.

use crate::support::{Folder, say};
use bladeoff::history::read;
use std::fs;

/// Both engines; runs without contact, with contact, invalid, failed: every column of every row, bit for bit.
#[test]
fn a_replayed_sample_is_equal_to_its_row() {
    let folder = Folder::new();
    let study = folder.write(
        "study.toml",
        "schema = 1\nname = \"small\"\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"0.03 s\"\n\
         \"blade_off.mass\" = \"13 g\"\n\"contact.friction_law\" = \"slip\"\n\
         [[vary]]\npath = \"run.engine\"\nvalues = [\"reduced\", \"full\", \"exponential\"]\n\
         [[vary]]\npath = \"contact.gap\"\nvalues = [\"0.1 mm\", \"0.1 mm\", \"1 mm\"]\nzip = \"case\"\n\
         [[vary]]\npath = \"contact.friction\"\nvalues = [0.15, 0.9, 0.15]\nzip = \"case\"\n\
         [limits]\nmax_failed = \"100 %\"\n",
    );
    let out = folder.name("run");
    let said = say(&["run", &study, "--out", &out, "--workers", "2"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let (header, rows) = crate::support::table(&out);
    let column = |name: &str| header.iter().position(|found| found == name).unwrap_or_else(|| panic!("no {name}"));
    let status: Vec<&str> = rows.iter().map(|row| row[column("status")].as_str()).collect();
    assert_eq!(status.iter().filter(|word| **word == "ok").count(), 6, "{status:?}");
    assert!(status.iter().all(|word| ["ok", "invalid", "failed"].contains(word)), "{status:?}");
    let touched = |row: usize| !rows[row][column("first_contact_s")].is_empty();
    assert_eq!((0..9).map(touched).collect::<Vec<_>>(), [true, true, false].repeat(3));
    // all columns except the sample number, the parameters and the detection, which are inputs
    let compared = header.len() - header.iter().position(|name| name == "status").expect("there");
    for sample in 0..9 {
        let said = say(&["replay", &out, "--sample", &sample.to_string()]);
        assert_eq!(said.code, 0, "{}{}", said.out, said.err);
        assert!(said.out.contains(&format!("equal to the row in all {compared} columns")), "{}", said.out);
    }
    // the worst ok row is sample 0, 3 or 6, although 1, 4 and 7 rub harder; rows without a value are skipped
    let number = |row: usize, name: &str| rows[row][column(name)].parse::<f64>().expect("a number");
    for name in ["max_filtered_contact_force_N", "first_contact_s"] {
        let worst = [0, 3, 6]
            .into_iter()
            .fold(0, |worst, row| if number(row, name) > number(worst, name) { row } else { worst });
        let history = folder.name("worst.csv");
        let said = say(&["replay", &out, "--worst", name, "--history", &history]);
        assert_eq!(said.code, 0, "{}", said.err);
        assert!(said.out.starts_with(&format!("{:<32} {worst} of", "sample")), "{name}: {}", said.out);
        assert!(said.out.contains("equal to the row"), "watched: {}", said.out);
        assert!(read(&folder.path("worst.csv")).expect("readable").time.len() > 100);
    }
    for (asked, told) in [
        (["--sample", "9"], "has no sample 9; its samples are 0 to 8"),
        (["--worst", "max_bearing_lod_N"], "did you mean max_bearing_load_N?"),
        (["--worst", "rub_regime"], "`rub_regime` is a column of words, not of numbers"),
        (["--worst", "model_work_J"], "no row of"),
    ] {
        let said = say(&["replay", &out, asked[0], asked[1]]);
        assert_eq!(said.code, 3, "{asked:?}: {}", said.err);
        assert!(said.err.contains(told), "{asked:?}: {}", said.err);
    }
    // the advice for a failed run is a command: it prints both rows, and writes no file
    let table = fs::read(folder.path("run/results.parquet")).expect("the table");
    let mut tried = 0;
    for sample in (0..9).filter(|sample| status[*sample] != "ok") {
        let why = say(&["why", &out, &sample.to_string()]);
        let Some(line) = why.out.lines().find(|line| line.starts_with("  try it")) else { continue };
        let (_, command) = line.split_once(" replay ").expect("a command");
        let (_, set) = command.split_once(&format!("--sample {sample} --set ")).expect("the sample and its change");
        let said = say(&["replay", &out, "--sample", &sample.to_string(), "--set", set.trim_matches('\'')]);
        assert_eq!(said.code, 0, "{line}: {}{}", said.out, said.err);
        let (path, value) = set.trim_matches('\'').split_once('=').expect("a path and its value");
        assert!(
            said.out.contains(&format!("{path} = ")) && said.out.contains("nothing is written"),
            "{value}: {}",
            said.out
        );
        tried += 1;
    }
    assert!(tried > 0, "{status:?}");
    assert!(table == fs::read(folder.path("run/results.parquet")).expect("the table"));
    // the suggested names do not include columns that have words
    let said = say(&["replay", &out, "--worst", "rub_regim"]);
    assert!(said.code == 3 && said.err.contains("has no column") && !said.err.contains("rub_regime"), "{}", said.err);
    // a plan that does not belong to the table is a damaged file
    let plan = folder.path("run/plan.json");
    let changed = fs::read_to_string(&plan).expect("the plan").replace("0.03", "0.07");
    fs::write(&plan, changed).expect("write");
    assert_eq!(say(&["replay", &out, "--sample", "0"]).code, 6);
}

/// Columns with short names (`as`), columns of numbers and of words, and a parameter given by a formula.
#[test]
fn a_replayed_sample_of_a_design_is_equal_to_its_row() {
    let folder = Folder::new();
    let study = folder.write(
        "study.toml",
        "schema = 1\nname = \"small\"\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"0.06 s\"\n\
         [design]\nkind = \"monte-carlo\"\nsamples = 4\n\
         [[uncertain]]\npath = \"blade_off.mass\"\nas = \"lost\"\ndistribution = \"uniform\"\nlower = \"12 g\"\nupper = \"14 g\"\n\
         [[uncertain]]\npath = \"contact.friction_law\"\nas = \"law\"\ndistribution = \"discrete\"\nvalues = [\"slip\", \"stick-slip\"]\n\
         [[derived]]\npath = \"contact.gap\"\nas = \"gap\"\nformula = \"0.4 mm + 1 mm * (lost - 12 g) / 100 g\"\n",
    );
    let out = folder.name("run");
    let said = say(&["run", &study, "--out", &out, "--workers", "2"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let (header, rows) = crate::support::table(&out);
    for name in ["lost_kg", "law", "gap_m"] {
        assert!(header.iter().any(|found| found == name), "{name} of {header:?}");
    }
    let law = header.iter().position(|name| name == "law").expect("the words");
    assert!(rows.iter().any(|row| row[law] != rows[0][law]), "both laws are among them");
    let touched = header.iter().position(|name| name == "first_contact_s").expect("there");
    assert!(rows.iter().all(|row| !row[touched].is_empty()), "contact happened");
    for sample in 0..rows.len() {
        let said = say(&["replay", &out, "--sample", &sample.to_string()]);
        assert_eq!(said.code, 0, "{}{}", said.out, said.err);
        assert!(said.out.contains("equal to the row in all"), "{}", said.out);
    }
}
