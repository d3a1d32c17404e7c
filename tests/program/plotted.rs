//! Figures of histories: they show values of the history, and damaged histories are rejected or drawn without the damaged values.

use crate::support::pictures::text;
use crate::support::{Folder, json, say};
use bladeoff::history::read;
use std::fs;
use std::path::Path;

/// A history of the lab rig with contact and the channels of the ring.
fn rig(folder: &Folder) -> String {
    let (machine, history) = (text(&folder.path("machines/rig.toml")), folder.name("rig.mcap"));
    let words = ["simulate", &machine, "--set", "run.end_time=0.3 s", "--history", &history, "--every", "0.1 ms"];
    let said = say(&[&words[..], &["--channels", "rotor,bearing.*,contact,ring"]].concat());
    assert_eq!(said.code, 0, "{}", said.err);
    history
}

#[test]
fn contact_waterfall_and_animation_show_what_the_history_has() {
    let folder = Folder::new();
    let path = rig(&folder);
    let history = read(Path::new(&path)).expect("the history");
    let force = &history.channel("contact.filtered_force_N").expect("recorded").values;
    let touching = force.iter().filter(|force| **force > 0.0).count();
    assert!(touching > 20, "the rotor touches the ring: {touching} instants");
    let plot = |kind: &str, out: &str| {
        let said = say(&["plot", &path, "--kind", kind, "--json", "--out", out]);
        assert_eq!(said.code, 0, "{kind}: {}", said.err);
        let listed = json(&said.out);
        assert_eq!((listed["kind"].as_str(), listed["files"][0].as_str()), (Some(kind), Some(out)));
        fs::read_to_string(out).expect("written")
    };
    let contact = plot("contact", &folder.name("contact.svg"));
    assert!(contact.contains("contact force, 1 ms mean [") && contact.contains("angle of the closest place"));
    // tiles of contact in addition to the steps of the colour scale
    assert!(contact.matches("<rect").count() > 60, "{}", contact.matches("<rect").count());
    let waterfall = plot("waterfall", &folder.name("waterfall.svg"));
    assert!(waterfall.contains("spin speed [rpm]") && waterfall.contains("1×"));
    assert!(waterfall.matches("<polyline").count() > 20);

    let page = plot("animation", &folder.name("orbit.html"));
    assert!(page.contains("<input id=\"slider\"") && !page.contains("src=\"http") && !page.contains("NaN"));
    let peak = &history.channel("contact.peak_force_N").expect("recorded").values;
    let first = history.time[peak.iter().position(|force| *force > 0.0).expect("contact")];
    let button = page.split("first contact, ").nth(1).and_then(|rest| rest.split(" s<").next()).expect("a mark");
    let marked: f64 = button.parse().expect("a number");
    assert!((marked - first).abs() < 1e-3 * first, "{marked} {first}");
    // only critical speeds within the speed range of the run are marked
    let speed = &history.channel("rotor.speed_rad_s").expect("recorded").values;
    let known = history.about.get("critical_speeds_rad_s").expect("recorded");
    let critical: Vec<f64> = known.split(' ').map(|text| text.parse().expect("a number")).collect();
    let (from, to) = (speed[0], speed[speed.len() - 1]);
    let passed = critical.iter().filter(|critical| (to..from).contains(*critical)).count();
    assert_eq!(page.matches(">critical speed ").count(), passed, "{critical:?} from {from} to {to}");
    // an animation cannot be written as an image, nor a figure as a page
    let said = say(&["plot", &path, "--kind", "animation", "--out", &folder.name("a.svg")]);
    assert!(said.code == 3 && said.err.contains("animations are not written as .svg"), "{}", said.err);
    let said = say(&["plot", &path, "--kind", "orbit", "--out", &folder.name("a.html")]);
    assert!(said.code == 3 && said.err.contains("figures are not written as .html"), "{}", said.err);
    // a figure without data is not drawn
    let said = say(&["plot", &path, "--kind", "contact", "--to", "0.005", "--out", &folder.name("none.svg")]);
    assert!(said.code == 3 && said.err.contains("there is no contact"), "{}", said.err);
    assert!(!folder.path("none.svg").exists());
}

#[test]
fn broken_histories_are_refused_or_drawn_without_the_broken_values() {
    let folder = Folder::new();
    let csv = |name: &str, row: &dyn Fn(usize) -> [f64; 3]| {
        let rows = (0..400).map(row).map(|[time, speed, y]| format!("{time},{speed},{y}\n"));
        folder.write(name, &format!("time_s,rotor.speed_rad_s,bearing.a.y_m\n{}", rows.collect::<String>()))
    };
    let time = |k: usize| 1e-3 * k as f64;
    let wave = |k: usize| 1e-5 * (0.6 * k as f64).sin();
    let speed = |k: usize| 300.0 - 0.1 * k as f64;
    let broken = csv("broken.csv", &|k| {
        let y = [wave(k), f64::NAN, 1e300, f64::INFINITY][if k > 390 { k % 4 } else { 0 }];
        [time(k), speed(k), y]
    });
    let out = folder.name("f.svg");
    let plot =
        |file: &str, kind: &str| say(&["plot", file, "--kind", kind, "--channels", "bearing.a.y", "--out", &out]);
    let drawn = plot(&broken, "time");
    assert!(drawn.code == 0 && drawn.err.contains("of bearing.a.y_m are not drawn"), "{}", drawn.err);
    let svg = fs::read_to_string(&out).expect("written");
    assert!(svg.matches("<polyline").count() > 0 && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    fs::remove_file(&out).expect("there");
    for kind in ["spectrogram", "waterfall", "response-spectrum"] {
        let said = plot(&broken, kind);
        assert!(said.code == 3 && said.err.contains("is not a finite number at 0.39"), "{kind}: {}", said.err);
    }
    let constant = csv("constant.csv", &|k| [time(k), speed(k), 2.5]);
    let gap = csv("gap.csv", &|k| [time(k) + if k > 200 { 0.5 } else { 0.0 }, speed(k), wave(k)]);
    let back = csv("back.csv", &|k| [-time(k), speed(k), wave(k)]);
    let steady = csv("steady.csv", &|k| [time(k), 300.0, wave(k)]);
    for (file, kind, part) in [
        (&constant, "spectrogram", "is constant"),
        (&gap, "spectrogram", "another interval"),
        (&back, "time", "times are not ascending"),
        (&steady, "waterfall", "the speed changes from"),
        (&steady, "order", "rotor.angle_rad"),
        (&steady, "contact", "contact.filtered_force_N"),
        (&steady, "animation", "contact.rotor_x_m"),
    ] {
        let out = folder.name(if kind == "animation" { "f.html" } else { "f.svg" });
        let channels: &[&str] =
            if matches!(kind, "contact" | "animation") { &[] } else { &["--channels", "bearing.a.y"] };
        let said = say(&[&["plot", file, "--kind", kind, "--out", &out], channels].concat());
        assert!(said.code == 3 && said.err.contains(part), "{kind}: {} {}", said.code, said.err);
        assert!(!Path::new(&out).exists(), "{kind}");
    }
}

/// Quantities of different units have scales of their own, and by default the contact with each of several diaphragms is drawn.
#[test]
fn panels_have_one_unit_and_contacts_of_all_diaphragms() {
    let folder = Folder::new();
    let head = "time_s,rotor.speed_rad_s,bearing.a.x_m,bearing.a.load_N,contact.one.gap_m,contact.two.gap_m";
    let rows = (0..400).map(|k| {
        let (time, wave) = (1e-3 * f64::from(k), (0.6 * f64::from(k)).sin());
        format!("{time},{},{},{},{},{}\n", 300.0 - time, 1e-5 * wave, 1e4 * wave, 1e-3 + 1e-4 * wave, 2e-3)
    });
    let path = folder.write("two.csv", &format!("{head}\n{}", rows.collect::<String>()));
    let out = folder.name("f.svg");
    let drawn = say(&["plot", &path, "--out", &out]);
    assert_eq!(drawn.code, 0, "{}", drawn.err);
    let svg = fs::read_to_string(&out).expect("written");
    assert!(svg.contains(">contact one<") && svg.contains(">contact two<"), "no contact");
    fs::remove_file(&out).expect("there");
    let channels = "bearing.a.x_m,bearing.a.load_N";
    let drawn = say(&["plot", &path, "--kind", "response-spectrum", "--channels", channels, "--out", &out]);
    assert_eq!(drawn.code, 0, "{}", drawn.err);
    let svg = fs::read_to_string(&out).expect("written");
    for axis in [">equivalent static force [kN]<", ">equivalent static value ["] {
        assert!(svg.contains(axis), "no axis {axis}");
    }
}
