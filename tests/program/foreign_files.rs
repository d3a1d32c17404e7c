//! Files and units of other programs: spreadsheets, Dakota, SALib, ROSS, tables of bearing coefficients; and numbers in a wrong unit.

use crate::support::{Folder, say};
use std::fs;

const STUDY: &str = "schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"1 ms\"\n[points]\nfile = \"points.csv\"\n";
const TWO_SAMPLES: [&str; 2] = ["0\t0.0004\t0.1", "1\t0.0007\t0.25"];

/// `check --list` of points, with additional lines in `[points]`: exit code, lines of the samples, messages.
fn listed(folder: &Folder, points: &str, more: &str) -> (i32, Vec<String>, String) {
    folder.write("points.csv", points);
    let said = say(&["check", &folder.write("s.toml", &format!("{STUDY}{more}")), "--list"]);
    (said.code, said.out.lines().skip(1).map(str::to_owned).collect(), said.err)
}

#[test]
fn a_spreadsheet_has_line_breaks_in_cells_and_units_in_its_header() {
    let folder = Folder::new();
    let newline = "contact.gap;contact.friction;note\r\n0,4 mm;0,1;\"a;b\"\r\n0,7 mm;0,25;\"two\r\nlines\"\r\n";
    let (code, rows, err) = listed(&folder, newline, "carry = [\"note\"]\n");
    assert_eq!((code, rows.as_slice()), (0, &TWO_SAMPLES.map(str::to_owned)[..]), "{err}");
    let out = folder.name("out");
    assert_eq!(say(&["run", &folder.name("s.toml"), "--out", &out]).code, 0);
    let csv = say(&["export", &out, "--csv", "--decimal-comma"]).out;
    assert!(csv.starts_with("sample;diaphragms.seal.contact.gap_m;"), "{csv}");
    assert!(csv.contains("\n0;0,0004;0,1;\"a;b\";") && csv.contains("\n1;0,0007;0,25;\"two\nlines\";"), "{csv}");
    // A file that was exported with decimal commas can be read again.
    let parameters: Vec<String> = csv
        .lines()
        .filter(|line| line.starts_with(|c: char| c == 's' || c.is_ascii_digit()))
        .map(|line| line.split(';').take(3).collect::<Vec<_>>().join(";"))
        .collect();
    assert_eq!(parameters.len(), 3, "{csv}");
    let (code, rows, err) = listed(&folder, &parameters.join("\n"), "ignore = [\"sample\"]\n");
    assert_eq!((code, rows.as_slice()), (0, &TWO_SAMPLES.map(str::to_owned)[..]), "{err}");
    for header in ["contact.gap [mm],contact.friction [-]", "contact.gap (mm),contact.friction", "gap[mm],friction [1]"]
    {
        let (code, rows, err) = listed(&folder, &format!("{header}\n0.4,0.1\n7e-4 m,0.25\n"), "");
        assert_eq!((code, rows.as_slice()), (0, &TWO_SAMPLES.map(str::to_owned)[..]), "{header}: {err}");
    }
    for (header, part) in [
        ("contact.gap [kg],contact.friction", "points.csv:1:1: contact.gap [kg]: the unit `kg` does not fit"),
        ("contact.gap [inch],contact.friction", "did you mean `in`?"),
        ("contact.gap_m [mm],contact.friction", "this machine has no such parameter"),
    ] {
        let (code, _, err) = listed(&folder, &format!("{header}\n0.4,0.1\n"), "");
        assert!(code == 3 && err.contains(part), "{header}: {err}");
    }
}

#[test]
fn points_as_dakota_writes_them_are_read() {
    let folder = Folder::new();
    let points = "%eval_id interface contact.gap contact.friction obj_fn \n1        NO_ID      0.0004   0.1    12.5 \n2        NO_ID      0.0007   0.25   nan \n";
    for more in [
        "ignore = [\"%eval_id\", \"interface\", \"obj_fn\"]\n",
        "ignore = [\"obj_fn\"]\n",
        "carry = [\"eval_id\", \"obj_fn\"]\n",
    ] {
        let (code, rows, err) = listed(&folder, points, more);
        assert_eq!((code, rows.as_slice()), (0, &TWO_SAMPLES.map(str::to_owned)[..]), "{more}: {err}");
    }
    // a text file of numpy has no header
    let (code, _, err) = listed(&folder, "4e-4 1e-1\n7e-4 2.5e-1\n", "");
    assert!(code == 3 && err.contains("a header line with the name of each column is missing"), "{err}");
    let (code, _, err) = listed(&folder, "contact.gap contact.friction\n0.4 mm 0.1\n0.7 mm 0.25\n", "");
    assert!(code == 3 && err.contains("has 3 cells, the header has 2 (separated by blanks)"), "{err}");
}

#[test]
fn an_exported_design_is_read_back() {
    let folder = Folder::new();
    let design = "schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"1 ms\"\n\
        [[uncertain]]\npath = \"contact.gap\"\nas = \"cold\"\ndistribution = \"uniform\"\nlower = \"0.4 mm\"\nupper = \"0.7 mm\"\n\
        [[uncertain]]\npath = \"bearings.left.stiffness\"\ndistribution = \"uniform\"\nlower = \"1e6 N/m\"\nupper = \"3e6 N/m\"\n\
        [[vary]]\npath = \"contact.detection\"\nvalues = [\"hyp1\", \"hyp2\"]\n[design]\nkind = \"monte-carlo\"\nsamples = 4\n";
    let study = folder.write("design.toml", design);
    let listed_first = say(&["check", &study, "--list"]);
    assert_eq!(say(&["design", "export", &study, "--out", &folder.name("design")]).code, 0);
    let dakota = fs::read_to_string(folder.path("design/dakota.dat")).expect("written");
    let (code, rows, err) = listed(&folder, &dakota, "");
    let wanted: Vec<String> = listed_first.out.lines().skip(1).map(str::to_owned).collect();
    assert_eq!((code, rows.len()), (0, 8), "{err}");
    assert_eq!(rows, wanted, "{dakota}");
    let salib = fs::read_to_string(folder.path("design/salib-points.csv")).expect("written");
    let (code, rows, err) = listed(&folder, &salib, "");
    assert_eq!((code, rows.len()), (0, 4), "{err}");
}

#[test]
fn units_are_read_as_tables_of_bearings_have_them() {
    let folder = Folder::new();
    let rig = folder.name("machines/rig.toml");
    let of = |set: &[&str]| {
        let mut words = vec!["paths", &rig];
        words.extend(set.iter().flat_map(|set| ["--set", set]));
        say(&words)
    };
    for set in [
        "rotor.bearings.left.damping=600 N-s/m",
        "rotor.bearings.left.damping=3.426 lbf-s/in",
        "braking.constant=0.1 N-m",
        "rotor.material.density=7.85 kg/dm3",
        "rotor.initial_speed=3 krpm",
    ] {
        let said = of(&[set]);
        assert_eq!(said.code, 0, "{set}: {}", said.err);
    }
    let pounds = of(&["rotor.bearings.left.damping=3.4 lb-s/in"]);
    assert!(pounds.code == 3 && pounds.err.contains("did you mean `lbf-s/in`?"), "{}", pounds.err);
    let hertz = of(&["rotor.initial_speed=50 Hz"]);
    assert!(hertz.code == 3 && hertz.err.contains("write the value in rpm or rad/s or rev/s"), "{}", hertz.err);
    for unit in ["rpm", "rad/s", "rev/s"] {
        assert_eq!(of(&[&format!("rotor.initial_speed=50 {unit}")]).code, 0, "{unit}");
    }
}

#[test]
fn a_rotor_of_ross_is_named_in_one_sentence() {
    let folder = Folder::new();
    for (name, text) in [
        (
            "rotor.toml",
            "ross_version = \"2.0.0\"\n[parameters]\n[\"ShaftElement_Shaft Element 0\"]\nL = 0.25\nidl = 0.0\nodl = 0.05\nn = 0\n",
        ),
        (
            "rotor.json",
            "{\"parameters\": {}, \"ShaftElement_Shaft Element 0\": {\"L\": 0.25, \"odl\": 0.05, \"n\": 0}}",
        ),
    ] {
        let file = folder.write(name, text);
        for command in ["check", "run", "simulate", "modes"] {
            let said = say(&[command, &file]);
            assert_eq!(said.code, 3, "{command} {name}: {}", said.err);
            assert!(
                said.err.contains("is a rotor saved by ROSS") && said.err.trim().lines().count() == 1,
                "{}",
                said.err
            );
        }
        let study = folder.write("of.toml", &format!("schema = 1\nmachine = {name:?}\n"));
        let said = say(&["check", &study]);
        assert!(said.code == 3 && said.err.contains("is a rotor saved by ROSS"), "{}", said.err);
    }
}

#[test]
fn a_number_in_a_wrong_unit_is_a_warning_and_changes_no_exit_code() {
    let folder = Folder::new();
    let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    let slip = rig
        .replace("density = \"7850 kg/m3\"", "density = 7.85")
        .replace("end_time = \"0.17 s\"", "end_time = \"1 ms\"");
    assert!(slip.contains("density = 7.85") && slip.contains("end_time = \"1 ms\""), "{slip}");
    folder.write("machines/slip.toml", &slip);
    let expected =
        "warning: rotor.shaft[0]: density 7.85 kg/m3, plausible is 500 kg/m3 to 25000 kg/m3; is its unit right?";
    let study = folder.write("slip.toml", "schema = 1\nmachine = \"machines/slip.toml\"\n");
    let (machine, out) = (folder.name("machines/slip.toml"), folder.name("slip"));
    for words in
        [&["check", &machine][..], &["check", &study], &["simulate", &machine], &["run", &study, "--out", &out]]
    {
        let said = say(words);
        assert_eq!(said.code, 0, "{words:?}: {}", said.err);
        assert!(said.err.contains(expected), "{words:?}: {}", said.err);
    }
    let varied = "schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"1 ms\"\n[[vary]]\npath = \"rotor.material.density\"\nvalues = [7850, 7.85]\n";
    let said = say(&["check", &folder.write("varied.toml", varied)]);
    assert!(
        said.code == 0 && said.err.contains("density 7.85 kg/m3") && said.err.contains("warning: with "),
        "{}",
        said.err
    );
    let short = rig.replace("end_time = \"0.17 s\"", "end_time = \"1 ms\"");
    let clean = say(&["check", &folder.write("machines/short.toml", &short)]);
    assert!(clean.code == 0 && !clean.err.contains("plausible"), "{}", clean.err);
}

/// A drop without spin onto a rigid ring: the message says why no time step helps. The start position includes the static sag, because the ring may be
/// centred around it.
#[test]
fn a_drop_onto_a_rigid_ring_says_why_it_is_invalid() {
    let folder = Folder::new();
    let drop = "schema = 1\nname = \"drop\"\n[run]\nend_time = \"0.1 s\"\n[rotor]\nkind = \"point-mass\"\nmass = \"1 kg\"\npolar_inertia = \"1e-3 kg m2\"\n\
        initial_speed = 0\ngravity = [0.0, \"-9.81 m/s2\"]\n[rotor.initial]\ndisplacement = [\"0 mm\", \"0.3 mm\"]\n\
        [rotor.bearings.spring]\nstiffness = \"1e2 N/m\"\n[diaphragms.ring]\nkind = \"rigid\"\n\
        [diaphragms.ring.contact]\nrotor_radius = \"50 mm\"\ngap = \"0.5 mm\"\nfriction = 0.1\noffset = [\"0 mm\", \"-97.6 mm\"]\n";
    // the sag is 98.1 mm: the rotor starts 0.2 mm off the centre of its ring and falls to its other side
    let said = say(&["simulate", &folder.write("drop.toml", drop)]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(!said.err.contains("outside"), "{}", said.err);
    let outside = say(&["simulate", &folder.write("far.toml", &drop.replace("-97.6 mm", "-40 mm"))]);
    assert!(outside.code == 3 && outside.err.contains("what gravity and unbalances bend"), "{}", outside.err);
    let fast = drop.replace("[rotor.initial]\n", "[rotor.initial]\nvelocity = [0.0, \"-0.1 m/s\"]\n");
    let said = say(&["simulate", &folder.write("fast.toml", &fast)]);
    assert!(
        said.out.contains("invalid") && said.out.contains("a rigid ring takes an impact without rebound"),
        "{}{}",
        said.out,
        said.err
    );
}
