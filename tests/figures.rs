//! Histories, figures, replay and the paper's table from the command line; the commands of the documentation page.

mod support;

use std::fs;
use std::path::Path;
use support::{Folder, root, say};

/// A figure is there in both formats, with its labels.
fn looked_at(directory: &Path, name: &str, labels: &[&str]) {
    let svg =
        fs::read_to_string(directory.join(format!("{name}.svg"))).unwrap_or_else(|error| panic!("{name}: {error}"));
    for label in labels {
        assert!(svg.contains(label), "{name} has no {label:?}");
    }
    let png = fs::read(directory.join(format!("{name}.png"))).expect("the PNG beside it");
    assert!(png.starts_with(b"\x89PNG") && png.len() > 10_000, "{name}: {} bytes", png.len());
}

fn text(path: &Path) -> String {
    path.display().to_string()
}

#[test]
fn a_run_its_history_and_its_pictures_from_one_command_each() {
    let folder = Folder::new();
    let machine = text(&folder.path("machines/rig.toml"));
    let (history, figures) = (text(&folder.path("rig.mcap")), folder.path("figures"));
    let said = say(&[
        "simulate",
        &machine,
        "--history",
        &history,
        "--channels",
        "rotor,bearing.*,contact,ring",
        "--every",
        "20 us",
    ]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.err.contains("rig.mcap"), "{}", said.err);
    let out = text(&figures);
    for kind in ["time", "orbit", "spectrogram"] {
        let said = say(&["plot", &history, "--kind", kind, "--out", &out]);
        assert_eq!(said.code, 0, "{kind}: {}", said.err);
    }
    looked_at(&figures, "rig-time", &["time [s]", "speed [rpm]", "gap [µm]", "bearing left"]);
    looked_at(&figures, "rig-orbit", &["x [µm]", "clearance", "orbit"]);
    looked_at(&figures, "rig-spectrogram-bearing-left-y", &["frequency [Hz]", "dB re"]);
    // 8 turns are too few for order tracking: said, not drawn
    let said = say(&["plot", &history, "--kind", "order", "--out", &out]);
    assert_eq!(said.code, 3);
    assert!(said.err.contains("turns"), "{}", said.err);
    let one = text(&folder.path("one.svg"));
    assert_eq!(say(&["plot", &history, "--channels", "contact.gap", "--out", &one]).code, 0);
    assert!(folder.path("one.svg").is_file() && !folder.path("one.png").exists());
    let said = say(&["plot", &history, "--channels", "contact.gapp", "--out", &one]);
    assert_eq!(said.code, 3, "{}", said.err);
}

#[test]
fn a_machine_is_drawn() {
    let folder = Folder::new();
    let figures = folder.path("figures");
    let said = say(&["modes", &text(&folder.path("machines/rig.toml")), "--figures", &text(&figures)]);
    assert_eq!(said.code, 0, "{}", said.err);
    looked_at(&figures, "campbell", &["frequency [Hz]", "spin speed [rpm]", "forward whirl"]);
    looked_at(&figures, "machine", &["Z [m]", "radius [m]", "diaphragm seal"]);
    looked_at(&figures, "mode-shapes", &["position [m]", "twist"]);
    looked_at(&figures, "ring-modes", &["mode 1"]);
    looked_at(&figures, "unbalance-response", &["bearing load", "spin speed [rpm]"]);
}

#[test]
fn a_history_that_cannot_be_written_is_a_warning() {
    let folder = Folder::new();
    let machine = text(&folder.path("machines/rig.toml"));
    let said = say(&["simulate", &machine, "--json", "--history", "/nowhere/at/all.mcap"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.err.contains("warning: there is no history"), "{}", said.err);
    assert!(said.out.contains("\"status\": \"ok\""), "{}", said.out);
    assert!(said.out.contains("\"rub_regime\": "), "words of the choice columns");
    let said = say(&["simulate", &machine, "--history", "history.txt"]);
    assert_eq!(said.code, 3, "{}", said.err);
}

#[test]
fn a_replayed_sample_is_equal_to_its_row() {
    let folder = Folder::new();
    let study = folder.write(
        "study.toml",
        "schema = 1\nname = \"small\"\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"0.15 s\"\n\
         [[vary]]\npath = \"contact.gap\"\nvalues = [\"0.45 mm\", \"0.5 mm\"]\n\
         [[vary]]\npath = \"contact.detection\"\nvalues = [\"hyp1\", \"hyp2\"]\n",
    );
    let out = text(&folder.path("run"));
    let said = say(&["run", &study, "--out", &out, "--workers", "2"]);
    assert_eq!(said.code, 0, "{}", said.err);
    for sample in ["0", "1", "2", "3"] {
        let said = say(&["replay", &out, "--sample", sample]);
        assert_eq!(said.code, 0, "{}{}", said.out, said.err);
        assert!(said.out.contains("equal to the row in all"), "{}", said.out);
    }
    let history = text(&folder.path("worst.csv"));
    let said = say(&["replay", &out, "--worst", "max_contact_force_N", "--history", &history]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(folder.path("worst.csv").is_file(), "{}", said.err);
    assert_eq!(say(&["replay", &out, "--sample", "4"]).code, 3);
    assert_eq!(say(&["replay", &out, "--worst", "no_such"]).code, 3);
    // a plan that is not the one of the table is refused
    let plan = folder.path("run/plan.json");
    let changed = fs::read_to_string(&plan).expect("the plan").replace("0.15", "0.16");
    fs::write(&plan, changed).expect("write");
    assert_eq!(say(&["replay", &out, "--sample", "0"]).code, 3);
}

#[test]
fn a_cut_history_is_recovered() {
    let folder = Folder::new();
    let machine = text(&folder.path("machines/rig.toml"));
    let whole = folder.path("whole.mcap");
    assert_eq!(say(&["simulate", &machine, "--history", &text(&whole)]).code, 0);
    let bytes = fs::read(&whole).expect("the history");
    let cut = folder.path("cut.mcap.tmp");
    fs::write(&cut, &bytes[..bytes.len() / 2]).expect("write");
    let said = say(&["recover", &text(&cut)]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("cut in the middle"), "{}", said.out);
    let figures = text(&folder.path("figures"));
    assert_eq!(say(&["plot", &text(&folder.path("cut.mcap")), "--out", &figures]).code, 0);
    assert_eq!(say(&["recover", &text(&cut)]).code, 3, "nothing is overwritten");
}

#[test]
fn the_paper_s_table_is_computed_and_claims_nothing_without_a_range() {
    let folder = Folder::new();
    let out = folder.path("table1");
    let said = say(&["table1", "--engine", "reduced", "--scatter", "1", "--end-time", "0.05 s", "--out", &text(&out)]);
    assert_eq!(said.code, 0, "{}", said.err);
    for part in [
        "The machine is ours",
        "| CPU time [s] | paper | 7742 | 24743 | 6845 |",
        "hyp2-frozen",
        "one start: not decided",
    ] {
        assert!(said.out.contains(part), "{part:?} in\n{}", said.out);
    }
    looked_at(&out, "fig07-speed", &["hyp1", "hyp2-frozen", "speed [rpm]"]);
    let runs = fs::read_to_string(out.join("runs.csv")).expect("the runs");
    assert_eq!(runs.lines().count(), 4);
}

/// Every command of the page, as written but for its length: in the page's order, in one folder.
#[test]
fn the_commands_of_the_walk_through_run() {
    let page = fs::read_to_string(root().join("docs/from-blade-off-to-answer.md")).expect("the page");
    let folder = Folder::new();
    std::os::unix::fs::symlink(root().join("studies"), folder.path("studies")).expect("link");
    let mut commands = 0;
    for line in page.lines().filter(|line| line.starts_with("bladeoff ")) {
        let mut words = split(line);
        let scaled: &[&str] = match words[1].as_str() {
            // the rub begins at 3.05 s
            "simulate" => &["--set", "run.end_time=3.2 s"],
            "table1" => &["--end-time", "0.1 s"],
            _ => &[],
        };
        words.extend(scaled.iter().map(|word| (*word).to_owned()));
        let words: Vec<&str> = words[1..].iter().map(String::as_str).collect();
        let output = support::bladeoff(&words).current_dir(folder.path(".")).output().expect("the binary starts");
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        commands += 1;
    }
    assert!(commands >= 8, "{commands}");
}

/// Words of a line of the shell; quotes as the page uses them.
fn split(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quoted) = (Vec::new(), String::new(), false);
    for letter in line.chars() {
        match letter {
            '"' => quoted = !quoted,
            ' ' if !quoted => {
                if !word.is_empty() {
                    words.push(std::mem::take(&mut word));
                }
            }
            letter => word.push(letter),
        }
    }
    words.push(word);
    words
}
