//! User input: points files of every dialect, errors in several files at once, extreme numbers, inconsistent radii.

use crate::support::{Folder, Said, say, table};
use std::fs;
use std::time::{Duration, Instant};

const POINTS_STUDY: &str = "schema = 1\nname = \"p\"\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"2 ms\"\n[points]\nfile = \"points.csv\"\n";

/// `check --list` of a study with these points and these lines of its `[points]`.
fn listed(folder: &Folder, points: &[u8], more: &str) -> Said {
    fs::write(folder.path("points.csv"), points).expect("written");
    say(&["check", &folder.write("s.toml", &format!("{POINTS_STUDY}{more}")), "--list"])
}

/// Lines of the samples for valid points.
fn rows(folder: &Folder, points: &[u8], more: &str) -> Vec<String> {
    let said = listed(folder, points, more);
    assert_eq!(said.code, 0, "{}{}", String::from_utf8_lossy(points), said.err);
    said.out.lines().skip(1).map(str::to_owned).collect()
}

#[test]
fn points_of_every_dialect_say_the_same() {
    let folder = Folder::new();
    let expected = ["0\t0.0004\t0.1", "1\t0.0007\t0.25"];
    let semicolons = "contact.gap;contact.friction\r\n0,4 mm;0,1\r\n\"0,7 mm\";0,25\r\n;\r\n";
    for text in [
        "contact.gap,contact.friction\n0.4 mm,0.1\n7e-4,0.25\n",
        "contact.gap;contact.friction\n0.4 mm;0.1\n0.7 mm;0.25\n",
        semicolons,
        "contact.gap\tcontact.friction\n0,4 mm\t0,1\n0,7 mm\t0,25\n",
        "sep=;\ncontact.gap;contact.friction\n0,4 mm;0,1\n7e-4;0,25\n",
        "contact.gap_m,contact.friction\n4e-4,0.1\n7e-4,0.25\n",
        "diaphragms.seal.contact.gap_m;friction\n0,0004;0,1\n0,0007;0,25\n",
    ] {
        assert_eq!(rows(&folder, text.as_bytes(), ""), expected, "{text}");
    }
    let utf_16 = |mark: [u8; 2], to: fn(u16) -> [u8; 2]| -> Vec<u8> {
        mark.into_iter().chain(semicolons.encode_utf16().flat_map(to)).collect()
    };
    assert_eq!(rows(&folder, &utf_16([0xff, 0xfe], u16::to_le_bytes), ""), expected);
    assert_eq!(rows(&folder, &utf_16([0xfe, 0xff], u16::to_be_bytes), ""), expected);
    let without = listed(&folder, &utf_16([0xff, 0xfe], u16::to_le_bytes)[2..], "");
    assert!(without.code == 3 && without.err.contains("neither UTF-8 text (byte 1) nor UTF-16"), "{}", without.err);
}

#[test]
fn points_that_may_be_read_in_two_ways_are_refused_with_their_line() {
    let folder = Folder::new();
    for (text, parts) in [
        ("contact.gap;contact.friction,x\n1;2\n", &["points.csv:1:1", "the header contains `;` and `,`", "sep=;"][..]),
        (
            "contact.gap,contact.friction\n0,4,0,1\n",
            &["points.csv:2:1", "has 4 cells, the header has 2", "decimal commas only where"],
        ),
        (
            "contact.gap,contact.friction\n0,4;0,1\n",
            &["points.csv:2:1", "has 3 cells, the header has 2", "one separator in the whole file"],
        ),
        (
            "contact.gap,contact.friction\n\"0,4 mm\",0.1\n",
            &["points.csv:2:1", "has a comma; the decimal sign is a point"],
        ),
        (
            "contact.gap;contact.friction\n0,4 mm;0.1\n",
            &["points.csv:2:8", "a decimal point here, a decimal comma in line 2"],
        ),
        (
            "contact.gap;contact.friction\n0.4 mm;1\n\n0,5 mm;1\n",
            &["points.csv:4:1", "a decimal comma here, a decimal point in line 2"],
        ),
        (
            "contact.gap;blade_off.mass\n1.000,5;0,001\n",
            &["points.csv:2:1", "`1.000,5` has more than one decimal sign", "thousands unmarked"],
        ),
    ] {
        let said = listed(&folder, text.as_bytes(), "");
        assert_eq!(said.code, 3, "{text}");
        for part in parts {
            assert!(said.err.contains(part), "{text}: {part} is not in\n{}", said.err);
        }
    }
}

#[test]
fn other_columns_are_carried_along_left_out_or_named() {
    let folder = Folder::new();
    let points =
        "id;weight;note;contact.gap;serial\nrun-001;0,25;12.3.2026, 1,2,3;0,4 mm;007\nrun-002;;1.5;0,9 mm;008\n";
    let refused = listed(&folder, points.as_bytes(), "");
    assert_eq!(refused.code, 3);
    for part in [
        "points.csv:1:1: id: this machine has no such parameter",
        "points.csv:1:4: weight:",
        "points.csv:1:11: note:",
        "in the study's [points] carry = [\"id\"] takes the column along into the table, ignore = [\"id\"] leaves it out",
    ] {
        assert!(refused.err.contains(part), "{part} is not in\n{}", refused.err);
    }
    let others = "carry = [\"weight\", \"id\", \"serial\"]\nignore = [\"note\"]\n[[vary]]\npath = \"contact.friction\"\nvalues = [0.1, 0.2]\n";
    assert_eq!(rows(&folder, points.as_bytes(), others).len(), 4);
    let (study, out) = (folder.name("s.toml"), folder.name("out"));
    let ran = say(&["run", &study, "--out", &out]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let (header, cells) = table(&out);
    let wanted = [
        "sample",
        "diaphragms.seal.contact.gap_m",
        "diaphragms.seal.contact.friction",
        "id",
        "weight",
        "serial",
        "detection",
    ];
    assert_eq!(header[..wanted.len()], wanted);
    let carried: Vec<&[String]> = cells.iter().map(|row| &row[3..6]).collect();
    assert_eq!(carried[0], ["run-001", "0.25", "007"]);
    assert_eq!(carried[1], carried[0]);
    assert_eq!(carried[3], ["run-002", "", "008"]);
    let why = say(&["why", &out, "2"]);
    assert!(why.out.lines().any(|line| line.starts_with("id ") && line.ends_with("run-002")), "{}", why.out);
    assert!(
        why.out.lines().any(|line| line.starts_with("weight ") && line.ends_with(" -")),
        "an empty cell: {}",
        why.out
    );
    // an additional column: another table, nothing is computed again
    let more = fs::read_to_string(&study)
        .expect("readable")
        .replace("\"serial\"]", "\"serial\", \"note\"]")
        .replace("ignore = [\"note\"]\n", "");
    fs::write(&study, more).expect("written");
    let again = say(&["run", &study, "--out", &out]);
    assert_eq!(again.code, 0, "{}", again.err);
    let (header, cells) = table(&out);
    assert!(header.iter().any(|name| name == "note") && cells.len() == 4, "{header:?}");
    let manifest = fs::read(format!("{out}/manifest.json")).expect("the manifest");
    let manifest: serde_json::Value = serde_json::from_slice(&manifest).expect("JSON");
    assert_eq!((&manifest["reused"], &manifest["done"]), (&4.into(), &4.into()), "{manifest}");
}

#[test]
fn wrong_names_of_other_columns_are_told_in_the_study() {
    let folder = Folder::new();
    let points = "id,contact.gap,status\na,1e-3,x\nb,2e-4,y\n";
    for (more, parts) in [
        (
            "carry = [\"ID\", \"status\"]\n",
            &["s.toml:8:10: points.carry = \"ID\": the points file has no such column", "did you mean `id`?"][..],
        ),
        ("carry = [\"id\", \"status\"]\n", &["s.toml:8:16: points.carry", "the table already has a column `status`"]),
        ("carry = [\"id\"]\nignore = [\"id\", \"status\"]\n", &["points.ignore: `id` is carried along already"]),
        ("carry = \"id\"\n", &["is a string, not an array of column names"]),
        ("carry = [\"id\", \"contact.gap\"]\nignore = [\"status\"]\n", &["no column names a parameter"]),
        ("carry = [\"i d\"]\n", &["cannot be the name of a column of the table"]),
        ("carri = [\"id\"]\n", &["points.carri: unknown key", "did you mean `carry`?"]),
    ] {
        let said = listed(&folder, points.as_bytes(), more);
        assert_eq!(said.code, 3, "{more}");
        for part in parts {
            assert!(said.err.contains(part), "{more}: {part} is not in\n{}", said.err);
        }
    }
    let unnamed = ",contact.gap\n0,1e-3\n1,2e-3\n";
    let said = listed(&folder, unnamed.as_bytes(), "");
    assert!(
        said.code == 3 && said.err.contains("a column without a name") && said.err.contains("ignore = [\"\"]"),
        "{}",
        said.err
    );
    assert_eq!(rows(&folder, unnamed.as_bytes(), "ignore = [\"\"]\n").len(), 2);
}

const TEN_MISTAKES: &str = "schema = 1\nmachine = \"machines/rig.toml\"\nsed = 3\n[set]\n\"run.end_tme\" = \"0.1 s\"\n\"run.step\" = \"1 kg\"\n\
    [points]\nfile = \"points.csv\"\n[[vary]]\npath = \"contact.gap\"\nvalues = [\"0 mm\"]\n[[vary]]\npath = \"contact.detection\"\nvalues = [\"hyp7\"]\n";

#[test]
fn mistakes_of_machine_study_and_points_are_told_at_once() {
    let folder = Folder::new();
    folder.write("points.csv", "contact.frictoin,blade_off.mass\n0.1,-1 g\n0.2\n");
    let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    let rig = rig
        .replace("width = \"10 mm\"\nelements = 16", "width = \"10 kg\"\nelements = 17")
        .replace("friction = 0.15", "friction = -1");
    folder.write("machines/rig.toml", &rig);
    let study = folder.write("s.toml", TEN_MISTAKES);
    let said = say(&["check", &study]);
    assert_eq!(said.code, 3);
    for part in [
        "s.toml:3:1: sed: unknown key",
        "s.toml:5:1: set.run.end_tme = \"0.1 s\": this machine, as far as it can be read, has no such parameter",
        "did you mean `run.end_time`?",
        "s.toml:6:14: set.run.step = \"1 kg\"",
        "s.toml:11:11: vary[0].values[0] = \"0 mm\": out of range",
        "s.toml:14:11: vary[1].values[0] = \"hyp7\"",
        "diaphragms.seal.ring.width = \"10 kg\"",
        "diaphragms.seal.ring.elements = 17",
        "diaphragms.seal.contact.friction = -1",
        "points.csv:1:1: contact.frictoin",
        "points.csv:2:5: rotor.unbalances.blade_off.mass = -1 g: out of range",
        "points.csv:3:1: has 1 cells",
    ] {
        assert!(said.err.contains(part), "{part} is not in\n{}", said.err);
    }
    // a header without its bracket hides no other error
    folder.write("machines/rig.toml", &rig.replace("[run]", "[run"));
    let said = say(&["check", &study]);
    for part in ["unclosed table", "elements = 17", "did you mean `run.end_time`?", "friction = -1", "sed: unknown key"]
    {
        assert!(said.err.contains(part), "{part} is not in\n{}", said.err);
    }
    // an array without its end hides none either
    folder.write("machines/rig.toml", &rig.replace("schema = 1", "schema = [1"));
    let said = say(&["check", &study]);
    for part in [
        "not valid TOML: an array with an error or without its end",
        "elements = 17",
        "did you mean `run.end_time`?",
        "contact.frictoin",
        "sed: unknown key",
    ] {
        assert!(said.err.contains(part), "{part} is not in\n{}", said.err);
    }
}

#[test]
fn extreme_numbers_are_refused_with_what_is_allowed() {
    let folder = Folder::reduced();
    let rig = folder.name("machines/rig.toml");
    for (path, value, part) in [
        ("rotor.initial_speed", "1e300", "allowed: 0 to 1e6 rad/s"),
        ("blade_off.mass", "1e300", "allowed: 0 to 1e9 kg"),
        ("run.step", "1e-300", "allowed: 1e-10 to 1e6 s"),
        ("run.step", "1e-30", "allowed: 1e-10 to 1e6 s"),
        ("run.end_time", "1e-300", "allowed: 1e-10 to 1e6 s"),
        ("run.end_time", "1e15", "allowed: 1e-10 to 1e6 s"),
    ] {
        let said = say(&["simulate", &rig, "--set", &format!("{path}={value}")]);
        assert!(said.code == 2 || said.code == 3, "{path} = {value}: {} {}", said.code, said.err);
        assert!(said.err.contains(part), "{path} = {value}: {}", said.err);
        let study = format!("schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"{path}\" = {value}\n");
        let said = say(&["check", &folder.write("s.toml", &study)]);
        assert!(said.code == 3 && said.err.contains(part), "{path} = {value}: {} {}", said.code, said.err);
    }
    let endless = "schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"run.step\" = 1e-10\n\"run.end_time\" = 1e6\n";
    let said = say(&["check", &folder.write("s.toml", endless)]);
    assert_eq!(said.code, 3, "{}", said.err);
    for part in
        ["the run may take 1e16 steps of 1e-10 s up to run.end_time = 1e6 s", "at most 1e10 steps", "which ends at 1 s"]
    {
        assert!(said.err.contains(part), "{part} is not in\n{}", said.err);
    }
}

/// `check` of runs that would take days returns within its time limit, prints what was measured and how the rest was extrapolated.
#[test]
fn check_comes_back_from_runs_without_end() {
    let folder = Folder::reduced();
    let text = "schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"run.step\" = 1e-10\n\"run.end_time\" = 0.5\n";
    let begun = Instant::now();
    let said = say(&["check", &folder.write("s.toml", text)]);
    let took = begun.elapsed();
    assert_eq!(said.code, 0, "{}", said.err);
    for part in [
        "timed 1 of 1 sample:",
        "of 5.00e9 steps",
        "Its whole time is extrapolated from its steps",
        "the whole study: about ",
        " of CPU time; ",
    ] {
        assert!(said.out.contains(part), "{part} is not in\n{}", said.out);
    }
    assert!(said.err.contains("timing 1 of 1 sample, at most"), "{}", said.err);
    // an upper bound for busy machines, not a measurement
    assert!(took < Duration::from_secs(300), "{took:?}");
}

#[test]
fn a_rotor_that_does_not_fit_its_ring_is_refused_where_it_varies() {
    let folder = Folder::new();
    let study = |values: &str| {
        format!("schema = 1\nmachine = \"machines/rig.toml\"\n[[vary]]\npath = \"contact.gap\"\nvalues = [{values}]\n")
    };
    let said = say(&["check", &folder.write("s.toml", &study("\"0.4 mm\", \"1 mm\", \"1.9 mm\", \"2 mm\"")), "--list"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let said = say(&["check", &folder.write("s.toml", &study("\"1 mm\", \"2.1 mm\", \"3 mm\"")), "--list"]);
    assert_eq!(said.code, 3);
    for part in [
        "s.toml:4:8",
        "2 of 3 combinations give a machine that cannot be built",
        "rotor_radius + gap = 52.1 mm does not fit the ring",
    ] {
        assert!(said.err.contains(part), "{part} is not in\n{}", said.err);
    }
    let rig = folder.name("machines/rig.toml");
    let said = say(&["simulate", &rig, "--set", "contact.rotor_radius=30 mm"]);
    assert!(said.code != 0 && said.err.contains("there are 20.5 mm"), "{}", said.err);
}

/// The lines printed in the note, at the place named there, give a study without the note; with the phase in `[set]` they were rejected.
#[test]
fn the_lines_that_vary_a_fixed_angle_go_in_place_of_the_line_that_fixes_it() {
    let folder = Folder::new();
    let head = "schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"2 ms\"\n";
    let fixed = folder.write("s.toml", &format!("{head}\"blade_off.phase\" = \"10 deg\"\n"));
    let said = say(&["check", &fixed]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.err.contains("phase is 10 deg in every sample"), "{}", said.err);
    assert!(said.err.contains("instead of its line in [set]:"), "{}", said.err);
    let lines: Vec<&str> = said.err.lines().skip_while(|line| line.trim() != "[[vary]]").take(5).collect();
    let varied = folder.write("s.toml", &format!("{head}{}\n", lines.join("\n")));
    let said = say(&["check", &varied]);
    assert!(said.code == 0 && !said.err.contains("in every sample"), "{}", said.err);
}
