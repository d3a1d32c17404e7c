//! Histories, figures and the paper's table from the command line; the commands of the documentation page.

use crate::support::pictures::{assert_figure, text};
use crate::support::{Folder, say};
use bladeoff::history::read;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::Stdio;

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
    assert_figure(&figures, "rig-time", &["time [s]", "speed [rpm]", "gap [µm]", "bearing left"]);
    assert_figure(&figures, "rig-orbit", &["x [µm]", "clearance at t", "gap at rest", "orbit of the last turn"]);
    assert_figure(&figures, "rig-spectrogram-bearing-left-y", &["frequency [Hz]", "dB re"]);
    // 8 turns are too few for order tracking: this is reported instead of drawn
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
    assert_figure(
        &figures,
        "campbell",
        &["frequency [Hz]", "spin speed [rpm]", "forward whirl", "critical, forward", "running speed"],
    );
    assert_figure(&figures, "machine", &["Z [m]", "radius [m]", "diaphragm seal"]);
    assert_figure(&figures, "mode-shapes", &["position [m]", "torsion"]);
    assert_figure(&figures, "ring-modes", &["mode 1", "n = 0", "nodal diameters"]);
    assert_figure(
        &figures,
        "unbalance-response",
        &["bearing load, 0 to peak", "spin speed [rpm]", "without contact</text>"],
    );
    // without damping the peaks would be infinite: they are cut off, and the rest of the response is visible
    let rig = std::fs::read_to_string(folder.path("machines/rig.toml")).expect("there");
    let rig = ["600 N s/m", "5 1/s", "2e-5 s"].iter().fold(rig, |rig, value| rig.replace(&format!("\"{value}\""), "0"));
    let figures = folder.path("undamped");
    let said = say(&["modes", &folder.write("undamped.toml", &rig), "--figures", &text(&figures)]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert_figure(&figures, "unbalance-response", &["; undamped peaks cut off</text>", "amplitude, 0 to peak [mm]"]);
}

/// Two discs on a bearing that is softer along Y: the modes of the first critical speeds are neither forward nor backward.
#[test]
fn mixed_and_planar_modes_are_named_listed_and_drawn() {
    let folder = Folder::new();
    let (machine, figures) = (folder.path("two-discs.toml"), folder.path("figures"));
    let file = include_str!("../../core/tests/data/two_discs_soft_end.toml");
    std::fs::write(&machine, file).expect("written");
    let said = say(&["modes", &text(&machine), "--figures", &text(&figures)]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("do not filter by `forward` alone"), "{}", said.out);
    assert!(!said.err.contains("unstable"), "{}", said.err);
    let words = ["mixed whirl", "planar whirl", "critical, mixed", "critical, planar", "critical, backward"];
    assert_figure(&figures, "campbell", &words);
    let said = say(&["modes", &text(&machine), "--json"]);
    let report: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    let critical = report["critical_speeds"].as_array().expect("a list");
    for (critical, word) in critical.iter().zip(["mixed", "planar", "backward"]) {
        assert_eq!((critical["whirl"].as_str(), critical["excited_by_unbalance"].as_bool()), (Some(word), Some(true)));
        assert!(critical["whirl_share"].as_f64().is_some_and(|share| share.abs() < 0.7), "{critical}");
    }
    assert_eq!(report["unstable"].as_array().map(Vec::len), Some(0));
}

/// The modes of the machine at a speed between its critical speeds.
#[test]
fn critical_speeds_near_the_running_speed_are_named_and_marked() {
    let folder = Folder::new();
    let (machine, figures) = (folder.path("two-discs.toml"), folder.path("figures"));
    let file = include_str!("../../core/tests/data/two_discs_soft_end.toml")
        .replace("initial_speed = 0.001", "initial_speed = \"1600 rpm\"");
    std::fs::write(&machine, file).expect("written");
    let said = say(&["modes", &text(&machine), "--figures", &text(&figures)]);
    assert_eq!(said.code, 0, "{}", said.err);
    let near = "Below the required separation margin: 1503.8, 1606.3, 1798.4 rpm.";
    assert!(said.out.contains(near), "{}", said.out);
    assert_figure(&figures, "campbell", &["separation margin too small"]);
    let said = say(&["modes", &text(&machine), "--json"]);
    let report: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    let first = &report["critical_speeds"][0];
    let number = |key: &str| first[key].as_f64().unwrap_or_else(|| panic!("no {key}: {first}"));
    assert!((number("amplification_factor") * 2.0 * number("damping_ratio") - 1.0).abs() < 1e-12, "{first}");
    assert!((number("separation_margin") - (1.0 - 1503.8 / 1600.0)).abs() < 1e-4, "{first}");
    assert!((number("required_separation_margin") - 0.16).abs() < 1e-12, "{first}");
}

/// Cross-coupled stiffness at this bearing makes a mode unstable above 281 rad/s.
#[test]
fn unstable_speeds_are_said_by_every_command() {
    let folder = Folder::new();
    let machine = folder.path("coupled.toml");
    let file = include_str!("../../core/tests/data/two_discs_soft_end.toml")
        .replace("initial_speed = 0.001", "initial_speed = \"3000 rpm\"");
    let file = file.replace("stiffness = [[1000000.0, 0.0], [0.0, 800000.0]]", "stiffness = [[1e6, 2e4], [-2e4, 8e5]]");
    std::fs::write(&machine, file.replace("0.1 s", "0.02 s")).expect("written");
    let machine = text(&machine);
    for words in [&["modes", &machine][..], &["check", &machine], &["simulate", &machine]] {
        let said = say(words);
        assert_eq!(said.code, 0, "{}", said.err);
        assert!(said.err.contains("warning: unstable ") && said.err.contains("Hz grows"), "{words:?}: {}", said.err);
    }
    let said = say(&["modes", &machine, "--json"]);
    let report: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    let range = &report["unstable"][0];
    // the finite-element model has the stability limit at 281 rad/s
    assert!(range["from_rad_s"].as_f64().is_some_and(|from| (from - 281.2).abs() < 0.5), "{range}");
    assert!(range["damping_ratio"].as_f64().is_some_and(|ratio| (-7e-4..-4e-4).contains(&ratio)), "{range}");
    let said = say(&["simulate", &machine, "--json"]);
    let row: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    assert!(row["least_damping_ratio"].as_f64().is_some_and(|ratio| (ratio + 5.1e-4).abs() < 2e-5), "{row}");
    assert!(row["least_damping_at_rad_s"].as_f64().is_some_and(|speed| (speed - 314.16).abs() < 0.1), "{row}");
}

/// Dampers of half the bearings' stiffness at the running speed: the modes of the dampers themselves are neither listed nor drawn as whirl modes.
#[test]
fn overdamped_motions_are_listed_apart_and_not_drawn() {
    let folder = Folder::new();
    let (machine, figures) = (text(&folder.path("machines/rig.toml")), folder.path("figures"));
    let damped = ["left", "right"].map(|name| format!("rotor.bearings.{name}.damping=3183 N s/m"));
    let words = ["modes", &machine, "--set", &damped[0], "--set", &damped[1]];
    let said = say(&[&words[..], &["--figures", &text(&figures)]].concat());
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("overdamped at 3000 rpm: no whirl (damping ratio from 0.9)"), "{}", said.out);
    assert!(said.out.contains("log decrement"), "{}", said.out);
    assert_figure(&figures, "campbell", &["overdamped motions are not drawn", "forward whirl", "critical, forward"]);
    let said = say(&[&words[..], &["--json"]].concat());
    let report: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    for speed in report["whirl"].as_array().expect("speeds") {
        let list = |key: &str| speed[key].as_array().unwrap_or_else(|| panic!("no {key}")).clone();
        let number = |of: &serde_json::Value, key: &str| of[key].as_f64().unwrap_or_else(|| panic!("no {key}: {of}"));
        let first = &list("modes")[0];
        assert_eq!(first["mode"], 1, "the first bending mode is the first of the list");
        assert!((number(first, "frequency_Hz") - 35.36).abs() < 0.1, "{first}");
        let ratio = number(first, "damping_ratio");
        let decrement = 2.0 * std::f64::consts::PI * ratio / (1.0 - ratio * ratio).sqrt();
        assert!((number(first, "log_decrement") / decrement - 1.0).abs() < 1e-9, "{first}");
        assert!(list("modes").iter().all(|mode| number(mode, "damping_ratio") < 0.9));
        let overdamped = list("overdamped");
        assert!(overdamped.len() >= 4 && overdamped.iter().all(|mode| number(mode, "damping_ratio") >= 0.9));
    }
    assert!(report["critical_speeds"][0]["log_decrement"].is_number());
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

/// A full disk (a small file system made for the test) or the limit on file sizes, reached in the middle of a run after part of the history was
/// written.
#[test]
fn a_full_disk_fails_the_history_alone() {
    let folder = Folder::new();
    let machine = text(&folder.path("machines/rig.toml"));
    let alone = say(&["simulate", &machine, "--json"]);
    assert_eq!(alone.code, 0, "{}", alone.err);
    fs::create_dir_all(folder.path("small")).expect("created");
    for name in ["full.mcap", "full.csv", "full.parquet"] {
        let history = folder.path("small").join(name);
        let script = "mount -t tmpfs -o size=100k tmpfs \"$3\" && exec \"$0\" simulate \"$1\" --json --decimate 1 --history \"$2\"";
        let words = ["--mount", "sh", "-c", script, env!("CARGO_BIN_EXE_bladeoff"), &machine, &text(&history)];
        let output = std::process::Command::new("unshare").args(words).arg(folder.path("small")).output();
        let Some(output) = output.ok().filter(|output| output.status.success()) else {
            crate::support::skipped::skipped("histories on a full disk", "takes root and `unshare --mount`");
            break;
        };
        let said = crate::support::said(output);
        assert!(said.err.contains("warning: there is no history"), "{name}: {}", said.err);
        assert!(said.err.contains("No space left on device"), "{name}: {}", said.err);
        assert_eq!(said.out, alone.out, "{name}: the run is the same run");
    }
    let limited = |name: &str| {
        let history = text(&folder.path(name));
        let script = "ulimit -f 100; exec \"$0\" simulate \"$1\" --json --decimate 1 --history \"$2\"";
        let binary = env!("CARGO_BIN_EXE_bladeoff");
        let output = std::process::Command::new("sh").args(["-c", script, binary, &machine, &history]).output();
        crate::support::said(output.expect("a shell"))
    };
    for name in ["limited.mcap", "limited.csv"] {
        let said = limited(name);
        assert_eq!(said.code, 0, "{name}: {}", said.err);
        assert!(said.err.contains("warning: there is no history"), "{name}: {}", said.err);
        assert_eq!(said.out, alone.out, "{name}: the run is the same run");
        assert!(!folder.path(name).exists(), "{name}");
        let left = fs::metadata(folder.path(&format!("{name}.tmp"))).expect("what was written").len();
        assert!(left > 10_000 && left <= 102_400, "{name}: {left} bytes: the limit was reached in the middle");
        assert!(said.err.contains("the part written until then"), "{name}: {}", said.err);
    }
    let said = say(&["recover", &text(&folder.path("limited.mcap.tmp"))]);
    assert_eq!(said.code, 0, "{}", said.err);
    // The table library has its own message for a full disk; the message of the operating system is printed.
    let said = limited("limited.parquet");
    assert!(said.code == 0 && said.out == alone.out, "{}", said.err);
    assert!(said.err.contains("limited.parquet\n  because: File too large"), "{}", said.err);
}

#[test]
fn energies_that_are_zero_all_the_time_are_not_drawn() {
    let folder = Folder::new();
    let (history, figure) = (text(&folder.path("h.csv")), text(&folder.path("f.svg")));
    let machine = text(&folder.path("machines/rig.toml"));
    let said =
        say(&["simulate", &machine, "--set", "run.end_time=0.02", "--channels", "energy", "--history", &history]);
    assert_eq!(said.code, 0, "{}", said.err);
    let recorded = read(history.as_ref()).expect("the history");
    let is_zero = |name: &str| recorded.channel(name).expect(name).values.iter().all(|value| *value == 0.0);
    let (zero, some): (Vec<&str>, Vec<&str>) =
        recorded.channels.iter().map(|channel| channel.name.as_str()).partition(|name| is_zero(name));
    assert!(!zero.is_empty() && !some.is_empty(), "no contact yet: {zero:?}, {some:?}");
    let panels = |channels: &str| {
        let said = say(&["plot", &history, "--channels", channels, "--out", &figure]);
        assert_eq!(said.code, 0, "{}", said.err);
        let svg = fs::read_to_string(&figure).expect("the figure");
        (svg.matches("J]").count(), said.err)
    };
    let (drawn, said) = panels("energy");
    assert_eq!(drawn, some.len());
    assert!(said.contains("not drawn") && zero.iter().all(|name| said.contains(name)), "{said}");
    assert_eq!(
        panels(zero[0]),
        (1, String::from("f.svg is replaced\n").replace("f.svg", &figure)),
        "asked for by name"
    );
}

/// From the file that a killed writer leaves, everything up to its last complete part is recovered, and is equal to the history of an undisturbed
/// run.
#[test]
fn a_history_whose_writer_is_killed_is_recovered() {
    const LEAST: u64 = 200_000;
    let folder = Folder::new();
    let machine = text(&folder.path("machines/rig.toml"));
    let record = |history: &Path, end: &str| {
        let history = text(history);
        let set = format!("run.end_time={end}");
        let words = [
            "simulate",
            &machine,
            "--set",
            &set,
            "--history",
            &history,
            "--channels",
            "rotor,contact",
            "--decimate",
            "1",
        ];
        crate::support::bladeoff(&words)
    };
    let (killed, temporary) = (folder.path("killed.mcap"), folder.path("killed.mcap.tmp"));
    // long enough for the test to kill the process while it writes
    let mut child = record(&killed, "5 s").stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("starts");
    while fs::metadata(&temporary).map_or(0, |about| about.len()) < LEAST {
        assert_eq!(child.try_wait().expect("its state"), None, "it ended before it was killed");
        std::thread::yield_now();
    }
    child.kill().expect("killed");
    let ended = child.wait().expect("ended");
    assert_eq!(ended.signal(), Some(9), "it was killed, in the middle of its history");
    assert!(!killed.exists() && fs::metadata(&temporary).expect("left behind").len() >= LEAST);

    let said = say(&["recover", &text(&temporary)]);
    assert_eq!(said.code, 0, "{}", said.err);
    let recovered = read(&killed).expect("a whole file");
    let undisturbed = folder.path("undisturbed.mcap");
    // up to shortly after the last recovered record
    let end = format!("{} s", recovered.time.last().expect("messages") + 1e-3);
    assert_eq!(say_of(record(&undisturbed, &end)).code, 0);
    let undisturbed = read(&undisturbed).expect("a whole file");
    let count = recovered.time.len();
    assert!(count > 1000 && count < undisturbed.time.len(), "{count} of {}", undisturbed.time.len());
    assert_eq!(recovered.time[..], undisturbed.time[..count]);
    assert_eq!(recovered.channels.len(), undisturbed.channels.len());
    for (ours, theirs) in recovered.channels.iter().zip(&undisturbed.channels) {
        assert_eq!((&ours.name, &ours.unit), (&theirs.name, &theirs.unit));
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&ours.values), bits(&theirs.values[..count]), "{}", ours.name);
    }
    assert_eq!(recovered.about, undisturbed.about);
    assert!(recovered.outcome.is_empty(), "the run did not end");
}

fn say_of(mut command: std::process::Command) -> crate::support::Said {
    crate::support::said(command.output().expect("the binary starts"))
}

#[test]
fn figures_of_several_files_have_names_of_their_own() {
    let folder = Folder::new();
    let machine = text(&folder.path("machines/rig.toml"));
    fs::create_dir_all(folder.path("a")).expect("created");
    fs::create_dir_all(folder.path("b")).expect("created");
    let [a, b, csv] = ["a/run.mcap", "b/run.mcap", "other.csv"].map(|name| text(&folder.path(name)));
    for (file, detection) in [(&a, "hyp1"), (&b, "hyp2"), (&csv, "hyp2")] {
        let said = say(&["simulate", &machine, "--detection", detection, "--history", file]);
        assert_eq!(said.code, 0, "{}", said.err);
    }
    let out = text(&folder.path("figures"));
    let plot = |words: &[&str]| {
        let said = say(&[&["plot", "--out", &out], words].concat());
        assert_eq!(said.code, 0, "{}", said.err);
        said
    };
    let named = |said: &crate::support::Said| {
        said.out
            .lines()
            .filter_map(|line| Some(line.strip_suffix(".svg")?.rsplit('/').next()?.to_owned()))
            .collect::<Vec<_>>()
    };
    assert_eq!(named(&plot(&[&a])), ["run-time"]);
    let again = plot(&[&b]);
    assert!(again.err.contains("run-time.svg is replaced"), "{}", again.err);
    assert_eq!(named(&plot(&[&a, &b])), ["a-run-b-run-time"], "one figure, the files over one another");
    assert_figure(&folder.path("figures"), "a-run-b-run-time", &["a-run", "b-run"]);
    let orbits = plot(&[&a, &b, &csv, "--kind", "orbit"]);
    assert_eq!(named(&orbits), ["a-run-orbit", "b-run-orbit", "other-orbit"]);
    assert!(orbits.err.contains("a-run: the history has no motion of the ring"), "{}", orbits.err);
    assert!(orbits.err.contains("other: a CSV carries no geometry"), "{}", orbits.err);
    let svg = |name: &str| fs::read_to_string(folder.path(&format!("figures/{name}.svg"))).expect("drawn");
    assert!(svg("a-run-orbit").contains("gap at rest") && !svg("a-run-orbit").contains("clearance at t"));
    assert!(!svg("other-orbit").contains("gap at rest"));
    assert_eq!(say(&["plot", &a, &a, "--out", &out]).code, 3, "twice the same");
    let said = say(&["plot", &a, "--kind", "orbit", "--at", "9 s", "--out", &out]);
    assert_eq!(said.code, 3);
    assert!(said.err.contains("has no instant there"), "{}", said.err);
    let said = say(&["plot", &a, "--channels", "contact.gapp", "--out", &out]);
    assert!(said.err.contains("did you mean \"contact.gap_m\""), "{}", said.err);
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
    assert!(said.out.contains("ends in the middle"), "{}", said.out);
    let figures = text(&folder.path("figures"));
    assert_eq!(say(&["plot", &text(&folder.path("cut.mcap")), "--out", &figures]).code, 0);
    assert_eq!(say(&["recover", &text(&cut)]).code, 3, "nothing is overwritten");
}
