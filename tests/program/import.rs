//! `bladeoff import`: a rotor of another program, from its file to its modes.

use crate::support::{Folder, say};
use std::fs;

const ROTOR: &str = include_str!("../../core/tests/data/ross_rotor.toml");

#[test]
fn a_rotor_of_ross_is_a_machine_at_once() {
    let folder = Folder::new();
    let (rotor, machine) = (folder.write("rotor.toml", ROTOR), folder.name("machine.toml"));
    let said = say(&["import", "ross", &rotor, "--out", &machine]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.is_empty() && said.err.contains("wrote ") && said.err.contains("machine.toml"), "{}", said.err);
    // each note is on standard error and in the file
    let text = fs::read_to_string(&machine).expect("written");
    let notes = text.lines().filter(|line| line.starts_with("# - ")).count();
    assert!(notes == 2 && said.err.matches("not converted, or not as in ROSS: ").count() == notes, "{}", said.err);
    assert_eq!(say(&["check", &machine]).code, 0);
    // values of ROSS 2.3.0: frequency in rad/s divided by 2 pi, logarithmic decrement
    let modes = say(&["modes", &machine, "--speed", "0", "--speed", "500 rad/s"]).out;
    for found in ["113.01", "0.7410", "118.13", "0.45207"] {
        assert!(modes.contains(found), "{found}: {modes}");
    }
    // standard output is the same file, and an existing file is kept
    assert_eq!(say(&["import", "ross", &rotor]).out, text);
    let again = say(&["import", "ross", &rotor, "--out", &machine]);
    assert!(again.code == 3 && again.err.contains("is not overwritten"), "{} {}", again.code, again.err);
}

#[test]
fn a_file_that_is_no_rotor_is_refused_with_every_mistake() {
    let folder = Folder::new();
    let machine = folder.name("machine.toml");
    let broken = ROTOR.replace("m = 25.0", "m = -25.0").replace("G_s = 6894.75", "G_s = \"soft\"");
    for (name, text, expected) in [
        ("broken.toml", broken.as_str(), vec!["DiskElement_Disk A.m = -25.0", "G_s = \"soft\"", "2 problems"]),
        ("rig.toml", "schema = 1\nname = \"rig\"\n", vec!["no shaft elements", "a rotor saved by ROSS"]),
        ("half.json", "{\"ShaftElement_0\": {\"L\": 1", vec!["not valid JSON: `,` or `}` is expected"]),
        ("empty.toml", "", vec!["no shaft elements"]),
    ] {
        let said = say(&["import", "ross", &folder.write(name, text), "--out", &machine]);
        assert_eq!(said.code, 3, "{name}: {}", said.err);
        assert!(expected.iter().all(|part| said.err.contains(part)), "{name}: {}", said.err);
        assert!(!folder.path("machine.toml").exists(), "{name}");
    }
    let large = folder.write("large.toml", &" ".repeat((1 << 20) + 1));
    for (name, expected) in [(large.as_str(), "at most 1048576 are read"), ("/dev/null", "is not a regular file")] {
        let said = say(&["import", "ross", name]);
        assert!(said.code == 3 && said.err.contains(expected), "{name}: {} {}", said.code, said.err);
    }
    assert_eq!(say(&["import", "other", "x.toml"]).code, 2);
}
