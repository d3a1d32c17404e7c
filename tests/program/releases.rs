//! Releases of unbalances in studies, `check`, histories and comparisons with twins.

use crate::support::{Folder, json, say, table};
use std::fs;

fn with_release(folder: &Folder, release: &str) -> String {
    let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    let rig = rig.replace("phase = \"0 deg\"\n", &format!("phase = \"0 deg\"\n{release}\n"));
    folder.write("machines/released.toml", &rig)
}

#[test]
fn a_study_varies_the_time_and_the_speed_of_a_release() {
    let folder = Folder::new();
    for (key, release, values, told) in [
        (
            "release_time",
            "release_time = \"20 ms\"",
            "[\"0 s\", \"10 ms\", \"30 ms\", \"1 s\"]",
            ["0.0", "0.01", "0.03", ""],
        ),
        ("release_speed", "release_speed = \"2999 rpm\"", "[\"3000 rpm\", \"4000 rpm\"]", ["0.0", "", "", ""]),
    ] {
        with_release(&folder, release);
        let study = folder.write(
            "study.toml",
            &format!(
                "schema = 1\nname = \"releases\"\nmachine = \"machines/released.toml\"\n[set]\n\"run.end_time\" = \"0.04 s\"\n\
                 [[vary]]\npath = \"blade_off.{key}\"\nvalues = {values}\n"
            ),
        );
        let out = folder.name(key);
        let said = say(&["run", &study, "--out", &out, "--workers", "2"]);
        assert_eq!(said.code, 0, "{}", said.err);
        let (header, rows) = table(&out);
        let column = |name: &str| header.iter().position(|found| found == name).expect("the column");
        for (row, told) in rows.iter().zip(told) {
            assert_eq!(row[column("release_blade_off_at_s")], told, "{key}");
            assert_eq!(row[column("status")], "ok");
        }
        let replayed = say(&["replay", &out, "--sample", "1"]);
        assert!(replayed.code == 0 && replayed.out.contains("equal to the row"), "{}{}", replayed.out, replayed.err);
    }
    // a release in only some of the samples would need columns that the other samples do not have
    let study = folder.write(
        "none.toml",
        "schema = 1\nname = \"none\"\nmachine = \"machines/rig.toml\"\n\
         [[vary]]\npath = \"blade_off.release_time\"\nvalues = [\"0 s\", \"10 ms\"]\n",
    );
    let said = say(&["run", &study, "--out", &folder.name("none"), "--workers", "1"]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("has no release of this unbalance") && said.err.contains("none.toml"), "{}", said.err);
}

#[test]
fn check_notes_a_release_that_is_not_expected() {
    let folder = Folder::new();
    for (release, noted) in [
        ("release_speed = \"3300 rpm\"", Some("release_speed = ")),
        ("release_time = \"1 s\"", Some("release_time = 1 s is not expected within the run")),
        ("release_time = \"10 ms\"", None),
    ] {
        let machine = with_release(&folder, release);
        let said = say(&["check", &machine]);
        assert_eq!(said.code, 0, "{}", said.err);
        assert_eq!(said.err.contains("this mass is never released"), noted.is_some(), "{release}: {}", said.err);
        assert!(noted.is_none_or(|noted| said.err.contains(noted)), "{}", said.err);
        if noted.is_some() {
            assert!(said.out.contains("no contact expected"), "without the mass nothing rubs: {}", said.out);
        } else {
            assert!(!said.out.contains("no contact expected"), "{}", said.out);
        }
    }
}

#[test]
fn a_history_has_the_energy_of_the_released_mass_and_a_twin_the_same_release() {
    let folder = Folder::new();
    let machine = with_release(&folder, "release_time = \"10 ms\"\nkind = \"lost\"\ndisc = \"right\"");
    let set = ["--set", "run.end_time=0.03 s", "--set", "run.twin=1e-6", "--json"];
    for engine in ["exponential", "reduced"] {
        let history = folder.name("history.csv");
        let own = ["simulate", &machine, "--engine", engine, "--history", &history];
        let said = say(&[&own[..], &set].concat());
        assert_eq!(said.code, 0, "{}", said.err);
        let row = json(&said.out);
        assert!(row["released_energy_J"].as_f64() < Some(-0.5), "{row}");
        assert!(row["twin_bearing_load_change"].as_f64().expect("a twin").abs() < 1e-3, "{row}");
        let text = fs::read_to_string(folder.path("history.csv")).expect("written");
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let place = lines.next().expect("a head").split(',').position(|name| name.contains("released_J"));
        let last = lines
            .next_back()
            .expect("instants")
            .split(',')
            .nth(place.expect("the channel"))
            .expect("a cell")
            .to_owned();
        let energy: f64 = last.parse().expect("a number");
        assert!((energy / row["released_energy_J"].as_f64().expect("there") - 1.0).abs() < 1e-9, "{energy} {row}");
    }
}
