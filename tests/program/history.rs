//! Histories: they contain what happened, recording does not change the run, and truncated files can be recovered.

use crate::support::pictures::text;
use crate::support::processes::{signal, wait_until};
use crate::support::{Folder, bladeoff, said, say};
use bladeoff::history::{Decimation, HistoryError, Recorder, Settings, catalogue, read, recover, select};
use bladeoff_answers::tables::CsvStyle;
use bladeoff_core::engine::{TimeStep, simulate};
use bladeoff_core::record::{NoHistory, columns};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Engine, Machine, MachineDef};
use bladeoff_model::outcome::Outcome;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// The lab rig through its first impacts.
fn machine() -> Machine {
    machine_with(&[])
}

/// The lab rig with changed values.
fn machine_with(changes: &[(&str, &str)]) -> Machine {
    let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("the machine file");
    let mut def = MachineDef::parse("lab_rig.toml", &text).expect("valid");
    for (path, value) in [("run.end_time", "0.16 s")].iter().chain(changes) {
        let info = def.resolve(path).expect("the path");
        let value = def.parse_value(&info, value).expect("a value");
        def.set(&info, &value).expect("in range");
    }
    // the reference engine, unless a change names one
    if def.engine().is_some_and(|choice| choice.is_auto()) {
        def.settle(Engine::Reduced);
    }
    def.build().expect("valid")
}

fn value(machine: &Machine, outcome: &Outcome, name: &str) -> f64 {
    let at = columns(machine).iter().position(|column| column.name == name).expect("the column");
    outcome.values[at].expect("not null")
}

fn record(path: &Path, channels: &[&str], decimation: Decimation) -> (Machine, Outcome) {
    let machine = machine();
    let outcome = record_of(&machine, path, channels, decimation);
    (machine, outcome)
}

fn record_of(machine: &Machine, path: &Path, channels: &[&str], decimation: Decimation) -> Outcome {
    let structure = Structure::build(machine, None).expect("a model");
    let time_step = TimeStep::new(machine, &structure).expect("a step");
    let channels = channels.iter().map(|name| (*name).to_owned()).collect();
    let settings = Settings { path: path.to_path_buf(), channels, decimation, csv: CsvStyle::Point };
    let mut recorder = Recorder::new(&settings, machine, &structure, &time_step).expect("known channels");
    let outcome = simulate(machine, &structure, &mut recorder).expect("starts");
    let written = recorder.finish(machine, &outcome).expect("written");
    assert_eq!(written.path, path);
    outcome
}

#[test]
fn a_watched_run_is_the_same_run() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let (machine, watched) = record(&directory.path().join("a.mcap"), &["all"], Decimation::Steps(3));
    let structure = Structure::build(&machine, None).expect("a model");
    let alone = simulate(&machine, &structure, &mut NoHistory).expect("starts");
    assert!(value(&machine, &alone, "first_contact_s") > 0.0, "there is contact");
    assert_eq!(alone, watched);
}

#[test]
fn what_is_read_back_is_what_the_run_reports() {
    let directory = tempfile::tempdir().expect("temporary directory");
    for name in ["a.mcap", "a.csv", "a.parquet"] {
        let path = directory.path().join(name);
        let (machine, outcome) =
            record(&path, &["rotor", "contact", "bearing.*.load", "section1"], Decimation::Steps(1));
        let left: Vec<_> =
            std::fs::read_dir(directory.path()).expect("list").map(|entry| entry.expect("entry").file_name()).collect();
        assert!(!left.iter().any(|name| name.to_string_lossy().ends_with(".tmp")), "{left:?}");
        let history = read(&path).expect("readable");
        // every step begins at an instant, and the last step ends at one more
        assert_eq!(history.time.len() as f64, value(&machine, &outcome, "steps") + 1.0, "{name}");
        let largest = |channel: &str| {
            let series = history.channel(channel).unwrap_or_else(|| panic!("no {channel}"));
            series.values.iter().copied().fold(f64::MIN, f64::max)
        };
        let close = |channel: &str, column: &str| {
            let (ours, reference) = (largest(channel), value(&machine, &outcome, column));
            assert!((ours / reference - 1.0).abs() < 1e-12, "{name} {channel}: {ours} {column}: {reference}");
        };
        close("bearing.left.load_N", "max_bearing_load_left_N");
        close("contact.normal_force_N", "max_contact_force_N");
        close("contact.peak_force_N", "max_contact_force_N");
        close("contact.eccentricity_m", "max_eccentricity_m");
        close("section1.torsional_moment_Nm", "max_torsional_moment_section1_Nm");
        let filtered = (largest("contact.filtered_force_N"), value(&machine, &outcome, "max_filtered_contact_force_N"));
        assert!((filtered.0 / filtered.1 - 1.0).abs() < 1e-9, "{filtered:?}");
        let at = history.channel("contact.normal_force_N").expect("there").values.iter().position(|&force| force > 0.0);
        let first = history.time[at.expect("contact")];
        assert!((first - value(&machine, &outcome, "first_contact_s")).abs() < 1e-9, "{name} {first}");
        assert_eq!(history.channel("contact.gap_m").expect("there").unit, "m");
        assert!(history.channel("energy.kinetic_J").is_none(), "was not asked for");
    }
}

#[test]
fn a_history_with_decimal_commas_reads_back_the_same() {
    let folder = Folder::new();
    let rig = folder.name("machines/rig.toml");
    let written = |name: &str, more: &[&str]| {
        let path = folder.name(name);
        let arguments = [&["simulate", &rig, "--history", &path, "--channels", "rotor,contact"], more].concat();
        (say(&arguments), path)
    };
    let [(points, with_points), (commas, with_commas)] =
        [written("points.csv", &[]), written("commas.csv", &["--decimal-comma"])];
    assert!(points.code == 0 && commas.code == 0, "{} {}", points.err, commas.err);
    let text = fs::read_to_string(&with_commas).expect("written");
    assert!(text.starts_with("time_s;"), "{}", &text[..80]);
    let first = text.lines().nth(1).expect("an instant");
    assert!(first.contains("0,0;") && !first.contains('.'), "{first}");
    let [points, commas] = [&with_points, &with_commas].map(|path| read(Path::new(path)).expect("readable"));
    assert!(commas.time.len() > 10 && commas.time == points.time);
    assert_eq!(commas.channels, points.channels);
    let (refused, _) = written("a.parquet", &["--decimal-comma"]);
    assert!(refused.code != 0 && refused.err.contains("decimal commas are for histories in CSV"), "{}", refused.err);
}

/// For every end of a run and every interval, the last instant is the end of the row: time, speed, energies.
#[test]
fn the_last_instant_is_the_end_of_the_row() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let ends: [(&[(&str, &str)], &str); 6] = [
        (&[("run.end_time", "20.0012 ms")], "end_time"),
        (&[("run.end_speed", "2990 rpm")], "end_speed"),
        (&[("braking.constant", "40 N m")], "stopped"),
        (&[("run.step_limit", "4321")], "failure"),
        // strong negative damping, set below: the state diverges
        (&[("run.end_time", "5 s"), ("run.step", "3.4 us")], "failure"),
        (&[("contact.gap", "0.1 mm")], "end_time"),
    ];
    for (changes, end) in ends {
        let mut machine = machine_with(&[&[("run.end_time", "40 ms")], changes].concat());
        let mut channels = vec!["rotor.speed_rad_s", "energy"];
        if end == "failure" && changes.len() > 1 {
            // the format does not allow such a bearing; without a diaphragm the motion is unlimited
            machine.diaphragms.clear();
            for bearing in &mut machine.rotor.bearings {
                bearing.damping = [[-3000.0, 0.0], [0.0, -3000.0]];
            }
        } else {
            channels.push("contact");
        }
        let structure = Structure::build(&machine, None).expect("a model");
        let alone = simulate(&machine, &structure, &mut NoHistory).expect("starts");
        let rubs = !machine.diaphragms.is_empty() && value(&machine, &alone, "friction_energy_J") > 0.0;
        assert_eq!(rubs, changes[0].0 == "contact.gap", "{changes:?}");
        for (format, decimation) in [
            ("csv", Decimation::Every(1e-3)),
            ("mcap", Decimation::Steps(1000)),
            ("parquet", Decimation::Default),
            ("csv", Decimation::Default),
        ] {
            let path = directory.path().join(format!("a.{format}"));
            let outcome = record_of(&machine, &path, &channels, decimation);
            assert_eq!(outcome.end_cause.word(), end, "{changes:?}");
            let history = read(&path).expect("readable");
            let last = |name: &str| *history.channel(name).expect("there").values.last().expect("instants");
            let time = *history.time.last().expect("instants");
            let end_time = value(&machine, &outcome, "end_time_s");
            // an MCAP stores whole nanoseconds
            let apart = if format == "mcap" { 1e-9 } else { 0.0 };
            assert!((time - end_time).abs() <= apart, "{changes:?} {format}: {time} {end_time}");
            assert_eq!(last("rotor.speed_rad_s"), value(&machine, &outcome, "end_speed_rad_s"), "{changes:?} {format}");
            if !machine.diaphragms.is_empty() {
                assert_eq!(last("energy.friction_J"), value(&machine, &outcome, "friction_energy_J"), "{changes:?}");
            }
            assert!(history.time.windows(2).all(|pair| pair[0] < pair[1]), "no instant twice");
            assert!(history.channels.iter().all(|channel| channel.values.iter().all(|value| value.is_finite())));
            assert_eq!(alone, outcome, "as if nobody looked");
        }
    }
}

/// During free motion, instants lie within steps; recording does not change the run, intervals are equal, and the last instant is the end of the row.
#[test]
fn a_history_of_the_exponential_engine_is_that_of_its_run() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let engine = ("run.engine", "exponential");
    let ends: [(&[(&str, &str)], &str); 4] = [
        (&[engine], "end_time"),
        (&[engine, ("run.end_speed", "2990 rpm")], "end_speed"),
        (&[engine, ("braking.constant", "40 N m")], "stopped"),
        (&[engine, ("run.step_limit", "1234")], "failure"),
    ];
    for (changes, end) in ends {
        let machine = machine_with(changes);
        let structure = Structure::build(&machine, None).expect("a model");
        let alone = simulate(&machine, &structure, &mut NoHistory).expect("starts");
        assert_eq!(alone.end_cause.word(), end, "{changes:?}");
        let path = directory.path().join("a.csv");
        let outcome = record_of(&machine, &path, &["all"], Decimation::Steps(5));
        assert_eq!(outcome, alone, "as if nobody looked");
        let step = value(&machine, &outcome, "step_s");
        let history = read(&path).expect("readable");
        let even = history.time.len() - 1;
        assert!(history.time[..even].windows(2).all(|pair| ((pair[1] - pair[0]) / (5.0 * step) - 1.0).abs() < 1e-6));
        assert!(5.0 * even as f64 > value(&machine, &outcome, "steps"), "instants within steps of flight");
        let series = |name: &str| &history.channel(name).unwrap_or_else(|| panic!("no {name}")).values;
        let last = |name: &str| *series(name).last().expect("instants");
        assert_eq!(*history.time.last().expect("instants"), value(&machine, &outcome, "end_time_s"), "{changes:?}");
        assert_eq!(last("rotor.speed_rad_s"), value(&machine, &outcome, "end_speed_rad_s"), "{changes:?}");
        assert_eq!(last("energy.friction_J"), value(&machine, &outcome, "friction_energy_J"), "{changes:?}");
        assert!(history.channels.iter().all(|channel| channel.values.iter().all(|value| value.is_finite())));
        if end != "end_time" {
            continue;
        }
        // there is contact, the gap is closed where there is, and the ring is displaced
        let (force, gap, ring) =
            (series("contact.normal_force_N"), series("contact.gap_m"), series("contact.eccentricity_m"));
        let pressed: Vec<usize> = (1..force.len()).filter(|&i| force[i] > 0.0 && force[i - 1] > 0.0).collect();
        assert!(pressed.len() > 20, "there is contact: {}", pressed.len());
        for &i in &pressed {
            assert!(gap[i].abs() < 0.02 * machine.diaphragms[0].contact.gap, "{}: gap {}", history.time[i], gap[i]);
            assert!(ring[i] > 0.0);
        }
        assert!(gap.iter().zip(force).all(|(gap, force)| *force > 0.0 || *gap > -1e-6), "nothing overlaps in flight");
    }
}

#[test]
fn an_interval_is_rounded_to_whole_steps() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let path = directory.path().join("a.csv");
    record(&path, &["speed", "rotor.speed_rad_s"][1..], Decimation::Every(1e-3));
    let history = read(&path).expect("readable");
    let step = history.time[1] - history.time[0];
    assert!((step - 294.0 * 3.4e-6).abs() < 1e-12, "{step}");
    assert_eq!(history.channels.len(), 1);
}

#[test]
fn a_cut_file_is_recovered_up_to_the_cut() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let whole = directory.path().join("whole.mcap");
    record(&whole, &["rotor", "contact"], Decimation::Steps(2));
    let bytes = std::fs::read(&whole).expect("whole");
    let reference = read(&whole).expect("readable");
    let mut shorter = 0;
    for share in [0.02, 0.3, 0.5, 0.77, 0.999, 1.0] {
        // a killed writer leaves `NAME.mcap.tmp`, recovered in the same folder
        let cut = directory.path().join("run.mcap.tmp");
        let to = directory.path().join("run.mcap");
        let length = (bytes.len() as f64 * share) as usize;
        std::fs::write(&cut, &bytes[..length]).expect("write");
        match recover(&cut, &to) {
            Ok(saved) => {
                let history = read(&to).expect("whole again");
                assert!(saved.messages >= 2 * history.time.len() as u64);
                assert!(
                    history.time.len() as f64 > (share - 0.05) * reference.time.len() as f64 * 0.9,
                    "{share}: {}",
                    history.time.len()
                );
                for (ours, theirs) in history.channels.iter().zip(&reference.channels) {
                    assert_eq!(ours.values[..], theirs.values[..history.time.len()], "{}", ours.name);
                    assert_eq!(ours.unit, theirs.unit);
                }
                assert_eq!(history.about, reference.about);
                shorter += usize::from(history.time.len() < reference.time.len());
                assert!(cut.exists(), "the input is kept");
                let again = recover(&cut, &to).expect_err("it is there").to_string();
                assert!(again.contains("run.mcap"), "{again}");
                std::fs::remove_file(&to).expect("there");
            }
            Err(HistoryError::NothingToRecover { .. }) => assert!(share < 0.1, "{share}"),
            Err(error) => panic!("{share}: {error}"),
        }
    }
    assert!(shorter >= 3);
}

#[test]
fn a_directory_that_cannot_be_written_fails_the_history_alone() {
    let machine = machine();
    let structure = Structure::build(&machine, None).expect("a model");
    let time_step = TimeStep::new(&machine, &structure).expect("a step");
    for name in ["/nowhere/at/all/a.mcap", "/nowhere/at/all/a.csv", "/nowhere/at/all/a.parquet"] {
        let settings =
            Settings { path: name.into(), channels: Vec::new(), decimation: Decimation::Default, csv: CsvStyle::Point };
        let mut recorder =
            Recorder::new(&settings, &machine, &structure, &time_step).expect("what is asked for is right");
        let outcome = simulate(&machine, &structure, &mut recorder).expect("starts");
        assert_eq!(outcome, simulate(&machine, &structure, &mut NoHistory).expect("starts"));
        assert!(recorder.finish(&machine, &outcome).is_err());
    }
}

#[test]
fn unknown_channels_are_refused_with_the_nearest_name() {
    let machine = machine();
    let structure = Structure::build(&machine, None).expect("a model");
    let all = catalogue(&machine, &structure);
    let error = select(all.clone(), &["contact.gapp".to_owned()]).expect_err("no such channel");
    assert!(error.to_string().contains("contact.gap_m"), "{error}");
    assert_eq!(select(all.clone(), &["contact.gap".to_owned()]).expect("without unit").len(), 1);
    assert!(select(all, &[]).expect("defaults").len() > 20);
}

/// Whether a process catches a signal, from the mask in /proc.
fn catches(pid: u32, number: u32) -> bool {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask >> (number - 1) & 1 == 1)
}

/// A run ended by Ctrl-C or a signal prints the path of its history and how to complete it; all recorded instants are there.
#[test]
fn a_run_that_is_ended_by_a_signal_says_what_is_left_of_its_history() {
    let folder = Folder::reduced();
    let rig = folder.name("machines/rig.toml");
    for (name, by, number, code) in
        [("a.mcap", "INT", 2, 130), ("a.csv", "TERM", 15, 143), ("a.parquet", "INT", 2, 130)]
    {
        let (history, temporary) = (folder.path(name), folder.path(&format!("{name}.tmp")));
        let words =
            ["simulate", &rig, "--set", "run.end_time=400 s", "--step", "0.05 us", "--decimate", "1", "--history"];
        let mut child = bladeoff(&[&words[..], &[&folder.name(name)]].concat())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        wait_until("it listens", || catches(child.id(), number));
        // more than the head of the file
        let is_written = || fs::metadata(&temporary).is_ok_and(|found| found.len() > 100_000);
        wait_until("instants are written", || name.ends_with("parquet") || is_written());
        assert!(signal(child.id(), by), "it was under way");
        wait_until("its end", || child.try_wait().expect("a child").is_some());
        let ended = said(child.wait_with_output().expect("ended"));
        assert_eq!(ended.code, code, "{name}: {}", ended.err);
        assert!(ended.out.is_empty() && !history.exists(), "{name}: {}", ended.out);
        assert!(ended.err.contains("error: the run was ended by "), "{name}: {}", ended.err);
        let told = ended.err.contains(&format!("the part written until then is in {}", temporary.display()));
        assert_eq!(told, temporary.exists(), "{name}: {}", ended.err);
        match name {
            "a.mcap" => {
                let command = ended.err.split("a complete file of it: ").nth(1).expect("a command").trim();
                let recovered = said(Command::new("sh").args(["-c", command]).output().expect("a shell"));
                assert_eq!(recovered.code, 0, "{command}: {}", recovered.err);
                assert!(recovered.out.contains("nothing was cut"), "{}", recovered.out);
                assert!(read(&history).expect("readable").time.len() > 100);
            }
            "a.csv" => {
                let text = fs::read_to_string(&temporary).expect("readable");
                let cells: Vec<usize> = text.lines().map(|line| line.split(',').count()).collect();
                assert!(text.ends_with('\n') && cells.len() > 10 && cells.iter().all(|count| *count == cells[0]));
            }
            _ => assert!(!temporary.exists() && ended.err.contains("nothing of its history is kept"), "{}", ended.err),
        }
    }
}

#[test]
fn an_interval_that_the_run_does_not_have_is_refused_with_the_longest_it_has() {
    let folder = Folder::new();
    let (rig, history) = (folder.name("machines/rig.toml"), folder.name("a.csv"));
    let simulate = |option: &str, value: &str| {
        say(&["simulate", &rig, "--set", "run.end_time=2 ms", "--history", &history, option, value])
    };
    for (option, value, allowed) in [
        ("--every", "1e300", "run.end_time = 2 ms"),
        ("--every", "2.001 ms", "run.end_time = 2 ms"),
        ("--every", "0 s", "run.end_time = 2 ms"),
        ("--every", "-1 ms", "run.end_time = 2 ms"),
        ("--decimate", "18446744073709551615", "the steps that the run may take"),
    ] {
        let said = simulate(option, value);
        assert_eq!(said.code, 3, "{option} {value}: {}", said.err);
        assert!(said.err.contains(&format!("error: {option} {value}: out of range\n  allowed: ")), "{}", said.err);
        assert!(said.err.contains(allowed) && !Path::new(&history).exists(), "{}", said.err);
    }
    assert_eq!(simulate("--every", "2 ms").code, 0);
    assert_eq!(read(Path::new(&history)).expect("readable").time.len(), 2, "the first and the last instant");
}

/// `plot` waited forever for a named pipe, and `recover` read an endless file into memory.
#[test]
fn what_is_no_regular_file_or_too_large_is_not_read() {
    let folder = Folder::new();
    let pipe = folder.path("pipe.mcap");
    rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, 0o600.into(), 0).expect("a FIFO");
    let huge = folder.path("huge.csv");
    fs::File::create(&huge).and_then(|file| file.set_len(1 << 40)).expect("sparse");
    let (done, is_done) = std::sync::mpsc::channel();
    let out = folder.path("whole.mcap");
    std::thread::spawn(move || {
        let recovered = |from: &Path| recover(from, &out).map(|_| ());
        let results =
            [read(&pipe).map(|_| ()), read(&huge).map(|_| ()), recovered(&pipe), recovered(Path::new("/dev/zero"))];
        let _ = done.send(results.map(|result| result.expect_err("not read").to_string()));
    });
    let errors = is_done.recv_timeout(std::time::Duration::from_secs(120)).expect("nothing is waited for");
    assert!(errors.iter().all(|error| error.contains("read")), "{errors:?}");
}

/// The shipped layouts of Foxglove and PlotJuggler name channels of a history of the shipped turbine, each in the spelling of its program.
#[test]
fn layouts_name_channels_of_a_history() {
    let folder = Folder::new();
    let path = text(&folder.path("turbine.mcap"));
    let machine = concat!(env!("CARGO_MANIFEST_DIR"), "/../studies/machines/lp_turbine_paper.toml");
    let said = say(&["simulate", machine, "--set", "run.end_time=0.01 s", "--history", &path]);
    assert_eq!(said.code, 0, "{}", said.err);
    let history = read(path.as_ref()).expect("the history");
    let docs = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/layouts");
    let read = |name: &str| std::fs::read_to_string(format!("{docs}/{name}")).expect("a layout");
    let foxglove: serde_json::Value = serde_json::from_str(&read("foxglove.json")).expect("JSON");
    let panels = foxglove["configById"].as_object().expect("panels");
    let mut named: Vec<String> = Vec::new();
    for (key, panel) in panels {
        let paths = panel["paths"].as_array().expect("paths").iter().chain(panel.get("xAxisPath"));
        named.extend(paths.map(|path| path["value"].as_str().expect("a path").to_owned()));
        assert!(foxglove["layout"].to_string().contains(key.as_str()), "{key} is placed");
        assert!(panel["foxglovePanelTitle"].is_string(), "the key that Foxglove reads a title from: {key}");
    }
    // /bearing/front.load_N
    let of_foxglove = named.iter().map(|path| path.trim_start_matches('/').replace('/', ".")).collect::<Vec<_>>();
    let juggler = read("plotjuggler.xml");
    // PlotJuggler requires this window, and reads as many sizes of a splitter as its count
    assert!(juggler.contains("<tabbed_widget name=\"Main Window\""), "{juggler}");
    let splitters: Vec<&str> = juggler.split("<DockSplitter ").skip(1).collect();
    let attribute = |text: &str, name: &str| {
        let rest = text.split(&format!("{name}=\"")).nth(1).expect("an attribute");
        rest.split('"').next().unwrap_or_default().to_owned()
    };
    assert!(splitters.len() >= 3);
    for splitter in splitters {
        assert_eq!(attribute(splitter, "count"), attribute(splitter, "sizes").split(';').count().to_string());
    }
    // /bearing/front/load_N
    let of_juggler: Vec<String> = ["name=\"/", "curve_x=\"/", "curve_y=\"/"]
        .iter()
        .flat_map(|key| juggler.split(key).skip(1))
        .map(|rest| rest.split('"').next().unwrap_or_default().replace('/', "."))
        .collect();
    assert!(of_foxglove.len() >= 13 && of_foxglove.len() == of_juggler.len(), "{of_foxglove:?}\n{of_juggler:?}");
    for channel in of_foxglove.iter().chain(&of_juggler) {
        assert!(history.channel(channel).is_some(), "{channel} is no channel of a history");
    }
    // as described in docs/histories.md for another machine: its bearings instead of the turbine's
    let machine = text(&folder.path("machines/rig.toml"));
    let said = say(&["simulate", &machine, "--set", "run.end_time=0.01 s", "--history", &path]);
    assert_eq!(said.code, 0, "{}", said.err);
    let rig = bladeoff::history::read(path.as_ref()).expect("the history");
    for channel in &of_foxglove {
        let own = channel.replace("front", "left").replace("rear", "right");
        assert!(rig.channel(&own).is_some(), "{own} is no channel of a history");
    }
}

/// A default step that does not resolve the impacts is refined, with or without a history; a given step stays.
#[test]
fn a_history_has_the_finer_step_of_its_run() {
    let folder = Folder::new();
    // the rotor just reaches its ring, in one contact of 65 default steps
    let machine = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
    let touch = ["simulate", &machine, "--set", "contact.gap=1.3056 mm", "--set", "run.guard.impact_steps=150"];
    let run = |more: &[&str]| say(&[&touch, more].concat());
    let (alone, watched) = (run(&["--json"]), run(&["--json", "--history", &folder.name("h.csv"), "--decimate", "1"]));
    assert_eq!(alone.out, watched.out);
    let row: serde_json::Value = serde_json::from_str(&alone.out).expect("JSON");
    let step = row["step_s"].as_f64().expect("a step");
    assert!(step < 6.2e-6 && row["contact_impulse_Ns"].as_f64().is_some_and(|impulse| impulse > 0.0), "{row}");
    let history = fs::read_to_string(folder.path("h.csv")).expect("the history");
    let times: Vec<f64> = history.lines().filter_map(|line| line.split(',').next()?.parse().ok()).take(3).collect();
    assert_eq!(times.len(), 3, "{}", &history[..200]);
    assert!((times[2] - times[1] - step).abs() < 1e-12, "{times:?} {step}");
    let shown = run(&[]).out;
    assert!(shown.contains("6.2 us by default, refined for short impacts"), "{shown}");
    let given = run(&["--set", "run.contact_step=6.2 us"]).out;
    assert!(!given.contains("refined") && given.contains("under_resolved"), "{given}");
}
