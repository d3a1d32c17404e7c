//! Output can be used directly: printed commands work, help and progress fit the terminal, one word has one meaning.

use crate::support::processes::{STUDY, wait_until};
use crate::support::screen::screen;
use crate::support::{Folder, Said, bladeoff, root, said, say};
use std::ffi::OsStr;
use std::fs;
use std::io::{Read, Write};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};

const BINARY: &str = env!("CARGO_BIN_EXE_bladeoff");

/// Subcommands with help of their own.
#[rustfmt::skip]
const COMMANDS: [&str; 20] = [
    "run", "submit", "merge", "status", "why", "check", "simulate", "modes", "paths", "new", "export", "verify", "replay",
    "plot", "recover", "bench", "doctor", "schema", "completions", "man",
];

#[test]
fn help_keeps_its_lists_and_fits_at_every_width() {
    for width in [60, 80, 100, 120] {
        for command in COMMANDS {
            let help =
                said(bladeoff(&[command, "--help"]).env("COLUMNS", width.to_string()).output().expect("it starts"));
            assert_eq!(help.code, 0);
            let called = format!("Here `bladeoff` is called as: {BINARY}");
            assert!(help.out.replace('\n', " ").contains(&called), "{command}: {}", help.out);
            for line in help.out.lines().filter(|line| !line.contains(BINARY)) {
                assert!(line.chars().count() <= width.min(100), "{command} at {width}: {line:?}");
                // columns of a list within a paragraph: the list was refilled
                assert!(line.starts_with(' ') || !line.contains("   "), "{command} at {width}: {line:?}");
            }
            if command != "run" {
                continue;
            }
            for name in
                ["results.parquet", "study.toml, machine.toml", "timings.parquet", "manifest.json", "ledger.redb"]
            {
                let begins = |line: &&str| line.starts_with(&format!("  {name}"));
                assert_eq!(help.out.lines().filter(begins).count(), 1, "{name} at {width}: {}", help.out);
            }
        }
    }
}

/// Complete examples of a help; lines joined by `\\` are separated by a line feed.
fn examples(help: &str) -> Vec<String> {
    let mut examples: Vec<String> = Vec::new();
    let mut goes_on = false;
    for line in help.lines().skip_while(|line| *line != "Examples:") {
        match examples.last_mut() {
            Some(example) if goes_on => example.push_str(&format!("\n{line}")),
            _ if line.starts_with("  bladeoff ") => examples.push(line.to_owned()),
            _ => continue,
        }
        goes_on = line.ends_with('\\');
    }
    examples
}

#[test]
fn examples_of_help_can_be_pasted_at_every_width() {
    for command in COMMANDS {
        let words: Vec<&str> = command.split(' ').chain(["--help"]).collect();
        let at = |width: usize| {
            examples(&said(bladeoff(&words).env("COLUMNS", width.to_string()).output().expect("it starts")).out)
        };
        let narrow = at(60);
        assert!(!narrow.is_empty(), "{command}");
        for width in [80, 100, 120] {
            assert_eq!(at(width), narrow, "{command} at {width}");
        }
        for example in narrow {
            let checked = Command::new("sh").args(["-n", "-c", &example]).output().expect("a shell");
            assert!(checked.status.success() && !example.ends_with('\\'), "{example}");
        }
    }
}

#[test]
fn a_time_that_a_history_has_not_is_said_with_the_times_it_has() {
    let folder = Folder::reduced();
    let (rig, history, out) = (folder.name("machines/rig.toml"), folder.name("a.csv"), folder.name("a.svg"));
    assert_eq!(say(&["simulate", &rig, "--set", "run.end_time=0.02 s", "--history", &history]).code, 0);
    for (asked, told) in [
        (&["--from", "0.3"][..], "--from 0.3: "),
        (&["--from", "0.3", "--to", "0.4"], "--from 0.3: "),
        (&["--from", "-2", "--to", "-1 s"], "--to -1 s: "),
        (&["--from", "10.01 ms", "--to", "10.02 ms"], "--from 10.01 ms --to 10.02 ms: "),
    ] {
        let words = [&["plot", &history, "--out", &out], asked].concat();
        let said = say(&words);
        assert_eq!(said.code, 3, "{}", said.err);
        assert!(said.err.starts_with(&format!("error: {told}")), "{}", said.err);
        assert!(said.err.contains("has no record in this range: it covers from 0 s to 19.9"), "{}", said.err);
    }
    let backward = say(&["plot", &history, "--out", &out, "--from", "0.015", "--to", "0.01"]);
    assert_eq!(backward.err, "error: --from 0.015 --to 0.01: --to lies before --from\n");
    assert_eq!(backward.code, 3);
}

#[test]
fn what_options_say_is_not_blamed_on_the_file_alone() {
    let folder = Folder::new();
    let rig = folder.name("machines/rig.toml");
    for command in ["simulate", "modes"] {
        let said = say(&[command, &rig, "--set", "contact.rotor_radius=30 mm"]);
        assert_eq!(said.code, 3, "{}", said.err);
        assert!(
            said.err.ends_with("rig.toml, with --set 'contact.rotor_radius=30 mm' in place of its own value\n"),
            "{}",
            said.err
        );
    }
}

#[test]
fn a_study_away_from_its_machine_is_said() {
    let folder = Folder::new();
    let there = say(&["new", "study", "--out", &folder.name("there.toml")]);
    assert!(there.code == 0 && there.err.contains("machines/lab_rig.toml, does not exist"), "{}", there.err);
    fs::rename(folder.path("machines/rig.toml"), folder.path("machines/lab_rig.toml")).expect("renamed");
    let here = say(&["new", "study", "--out", &folder.name("here.toml")]);
    assert!(here.code == 0 && !here.err.contains("hint"), "{}", here.err);
}

/// Text behind a mark in a line.
fn behind<'a>(text: &'a str, mark: &str) -> &'a str {
    let line = text.lines().find(|line| line.contains(mark)).unwrap_or_else(|| panic!("no {mark:?} in\n{text}"));
    line.split_once(mark).expect("found").1.trim()
}

/// Runs a printed command in a shell.
fn pasted(command: &str, folder: &Path, path: &OsStr) -> Said {
    said(Command::new("sh").args(["-c", command]).current_dir(folder).env("PATH", path).output().expect("a shell"))
}

#[test]
fn printed_commands_work_as_they_are_printed_however_the_program_was_called() {
    let folder = Folder::new();
    let place = folder.path("");
    let (tools, elsewhere) = (folder.path("my tools"), folder.path("else where"));
    fs::create_dir(&tools).and_then(|()| fs::create_dir(&elsewhere)).expect("created");
    symlink(BINARY, tools.join("bladeoff")).and_then(|()| symlink(BINARY, folder.path("bladeoff"))).expect("linked");
    let usual = std::env::var_os("PATH").unwrap_or_default();
    let on_path =
        std::env::join_paths([tools.clone()].into_iter().chain(std::env::split_paths(&usual))).expect("a path");
    folder.write("a study's.toml", STUDY);
    let run_in = |program: &str, folder: &Path, path: &OsStr, words: &[&str]| {
        // `env` looks programs up as a shell does, and passes the name on unchanged
        let mut command = Command::new("env");
        said(command.arg(program).args(words).current_dir(folder).env("PATH", path).output().expect("it starts"))
    };
    let absolute = tools.join("bladeoff").display().to_string();
    for (program, path) in [("./bladeoff", &usual), ("bladeoff", &on_path), (absolute.as_str(), &usual)] {
        let out = format!("out of {}", program.len());
        // ended before it is complete: workers have only begun
        let first = run_in(program, &place, path, &["run", "a study's.toml", "--out", &out, "--wall", "0.05 s"]);
        assert_eq!(first.code, 5, "{}", first.err);
        let go_on = behind(&first.err, "resume with: ");
        assert!(go_on.trim_matches('\'').starts_with(program), "{go_on}");
        if program == "./bladeoff" {
            // from another folder, with another path of the program, the printed command works there
            let looked = run_in(&absolute, &elsewhere, path, &["status", &format!("../{out}")]);
            assert_eq!(looked.code, 0, "{}", looked.err);
            let there = behind(&looked.out, "resume ");
            assert!(there.contains(&absolute) && there.contains("--out '../out of 10'"), "{there}");
            let went_on = pasted(there, &elsewhere, path);
            assert_eq!(went_on.code, 0, "{there}: {}", went_on.err);
        } else {
            let went_on = pasted(go_on, &place, path);
            assert_eq!(went_on.code, 0, "{go_on}: {}", went_on.err);
        }
        let why = run_in(program, &place, path, &["why", "3", "--dir", &out]);
        assert_eq!(why.code, 0, "{}", why.err);
        let compute = behind(&why.out, "compute it ");
        let computed = pasted(compute, &place, path);
        assert!(computed.code == 0 && computed.out.contains("equal to the row"), "{compute}: {}", computed.err);
        assert!(folder.path("sample-3.mcap").is_file());
        fs::remove_file(folder.path("sample-3.mcap")).expect("removed");
    }
}

#[test]
fn of_a_sample_without_a_row_no_command_is_told_that_needs_one() {
    let folder = Folder::new();
    // samples that take much longer than the run
    let study = folder.write("s.toml", &STUDY.replace("exponential\"", "reduced\"\n\"run.step\" = \"1e-9 s\""));
    let out = folder.name("out");
    assert_eq!(say(&["run", &study, "--out", &out, "--wall", "0.1 s"]).code, 5);
    let why = say(&["why", &out, "3"]);
    assert_eq!(why.code, 0, "{}", why.err);
    assert!(why.out.contains("not finished; resume with: ") && !why.out.contains("compute it"), "{}", why.out);
    // a missing table is not mentioned, but the progress
    let replay = say(&["replay", &out, "--sample", "3"]);
    assert_eq!(replay.code, 3, "{}", replay.err);
    let told = pasted(behind(&replay.err, "how to resume: "), &folder.path(""), OsStr::new("/usr/bin:/bin"));
    assert!(told.code == 0 && told.out.contains("state      ended"), "{}", told.err);
}

#[test]
fn the_last_run_is_taken_where_none_is_named_and_replay_says_what_to_give() {
    let folder = Folder::new();
    folder.write("first.toml", STUDY);
    folder.write("second.toml", STUDY);
    let here = |words: &[&str]| said(bladeoff(words).current_dir(folder.path("")).output().expect("it starts"));
    for words in [&["status"][..], &["why", "3"], &["replay"]] {
        let nothing = here(words);
        assert_eq!(nothing.code, 3, "{words:?}: {}", nothing.err);
        assert!(nothing.err.contains("no result directory here nor below runs/"), "{}", nothing.err);
    }
    assert_eq!(here(&["run", "first.toml"]).code, 0);
    assert_eq!(here(&["run", "second.toml"]).code, 0);
    let status = here(&["status"]);
    assert!(status.code == 0 && status.out.starts_with("state      complete\nstudy      "), "{}", status.out);
    let last = behind(&status.err, "in ").trim_end_matches(':').to_owned();
    let json = here(&["status", "--json"]);
    let value: serde_json::Value = serde_json::from_str(&json.out).expect("JSON alone");
    assert!(value["directory"].as_str().is_some_and(|directory| directory.ends_with(&last)), "{last}: {}", json.out);
    let which = here(&["replay"]);
    assert_eq!(which.code, 2, "{}", which.err);
    assert!(which.err.contains("which sample of ") && which.err.contains("up to 19"), "{}", which.err);
    let examples: Vec<&str> = which.err.lines().filter(|line| line.contains(" replay ")).collect();
    assert_eq!(examples.len(), 2, "{}", which.err);
    for example in examples {
        let again = pasted(example.trim(), &folder.path(""), OsStr::new("/usr/bin:/bin"));
        assert!(again.code == 0 && again.out.contains("equal to the row"), "{example}: {}", again.err);
    }
    // the results of a sample are those of `simulate` and `replay`, in the same groups
    let (why, replay) = (here(&["why", "3"]), here(&["replay", "--sample", "3"]));
    let shown: Vec<&str> = why.out.lines().skip_while(|line| *line != "Course").collect();
    assert!(shown.len() > 30 && shown.contains(&"Bearing loads"), "{}", why.out);
    let replayed: Vec<&str> = replay.out.lines().collect();
    assert!(shown.iter().all(|line| replayed.contains(line)), "{}\n{}", why.out, replay.out);
}

#[test]
fn a_number_that_must_be_one_at_least_says_so() {
    for (words, told) in [
        (&["run", "x.toml", "--workers", "0"][..], "without --workers there is one per core"),
        (&["run", "x.toml", "--workers", "many"], "without --workers there is one per core"),
        (&["run", "x.toml", "--workers", "-1"], "without --workers there is one per core"),
        (&["run", "x.toml", "--wall", "-1s"], "is not a time above 0"),
        (&["plot", "x.mcap", "--out", "x.svg", "--top", "-5"], "must be a number above 0"),
        (&["run", "x.toml", "--limit", "0"], "must be a whole number from 1 on"),
        (&["simulate", "x.toml", "--history", "h.csv", "--decimate", "0"], "must be a whole number from 1 on"),
    ] {
        let said = say(words);
        assert_eq!(said.code, 2, "{words:?}: {}", said.err);
        assert!(said.err.contains(told), "{words:?}: {}", said.err);
    }
}

#[test]
fn a_sample_with_a_sign_is_no_option() {
    for (words, code, told) in [
        (&["why", "-1"][..], 2, "\"-1\" is not the number of a sample: samples are numbered from 0"),
        (&["why", "runs/x", "-1"], 2, "\"-1\" is not the number of a sample: samples are numbered from 0"),
        (&["why", "--1"], 2, "error: --1 is not an option; write the number without dashes: 1\n"),
        (&["replay", "runs/x", "-5"], 2, "error: -5 is not an option; write the number without dashes: 5\n"),
    ] {
        let said = say(words);
        assert_eq!(said.code, code, "{words:?}: {}", said.err);
        assert!(said.err.contains(told) && !said.err.contains("tip:"), "{words:?}: {}", said.err);
    }
}

#[test]
fn why_shows_the_twin_of_a_sample_that_has_one() {
    let folder = Folder::new();
    let study = folder
        .write("s.toml", &STUDY.replacen("schema = 1\n", "schema = 1\ntwin_share = 0.5\n", 1).replace("0.1 s", "2 ms"));
    let out = folder.name("out");
    assert_eq!(say(&["run", &study, "--out", &out]).code, 0);
    let (header, rows) = crate::support::table(&out);
    let twin = header.iter().position(|name| name == "run.twin").expect("the column");
    let mut seen = [0, 0];
    for (sample, row) in rows.iter().enumerate() {
        let why = say(&["why", &out, &sample.to_string()]);
        let has_twin = row[twin].parse::<f64>().expect("a number") > 0.0;
        let line = why.out.lines().find(|line| line.starts_with("run.twin "));
        assert_eq!(line.is_some_and(|line| line.contains(" 1e-6 (a second run starts")), has_twin, "{}", why.out);
        seen[usize::from(has_twin)] += 1;
    }
    assert!(seen[0] > 0 && seen[1] > 0, "{seen:?}");
}

#[test]
fn a_study_that_cannot_start_says_so_once_and_what_is_allowed() {
    let folder = Folder::reduced();
    let study = folder.write("s.toml", &STUDY.replace("exponential\"", "reduced\"\n\"run.step\" = \"1 ms\""));
    let said = say(&["check", &study]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert_eq!(said.err.matches("cannot start").count(), 1, "{}", said.err);
    assert!(said.err.contains("s.toml:8:1: run.step = 1 ms: the step 1 ms is too large"), "{}", said.err);
    // the printed limit is accepted
    let limit = said.err.split("largest allowed ").nth(1).and_then(|rest| rest.split(" = ").next()).expect("a limit");
    assert!(limit.ends_with(" us"), "{limit}");
    let said = say(&["simulate", &folder.name("machines/rig.toml"), "--set", "run.end_time=1 ms", "--step", limit]);
    assert!(!said.err.contains("too large"), "{limit}: {}", said.err);
}

/// Eight blades: half a turn, the step of a trajectory over the whole turn, is four times the angle between two blades.
#[test]
fn levels_of_an_angle_that_are_one_start_are_said() {
    let folder = Folder::new();
    let rig = fs::read_to_string(root().join("studies/machines/lab_rig.toml")).expect("the rig");
    folder.write("machines/lab_rig.toml", &rig);
    let text = fs::read_to_string(root().join("studies/sensitivity.toml")).expect("the study");
    let text = text.replace("\"0.3 s\"", "\"1 ms\"");
    let check = |text: &str| {
        let said = say(&["check", &folder.write("s.toml", text)]);
        assert_eq!(said.code, 0, "{}", said.err);
        said.err
    };
    assert!(!check(&text).contains("warning"), "as it is shipped");
    let whole = text.replace("upper = \"45 deg\"", "upper = \"360 deg\"");
    assert_ne!(whole, text);
    let said = check(&whole);
    assert!(said.contains("rotor.unbalances.blade_off.phase moves by 180 deg, whole periods of 45 deg"), "{said}");
    assert!(said.contains("exactly 0") && said.contains("do not differ by whole periods"), "{said}");
    let said = check(&whole.replace("\"periodic\"", "\"uniform\""));
    assert!(
        said.contains("the first and the last level of rotor.unbalances.blade_off.phase are the same start"),
        "{said}"
    );
}

#[test]
fn a_fixed_release_angle_is_said_and_the_lines_that_are_proposed_vary_it() {
    let folder = Folder::new();
    let text = fs::read_to_string(folder.small_study()).expect("the study");
    let check = |text: &str| {
        let said = say(&["check", &folder.write("s.toml", text)]);
        assert_eq!(said.code, 0, "{}", said.err);
        said
    };
    let fixed = check(&text);
    assert!(fixed.err.contains("rotor.unbalances.blade_off.phase is 0 deg in every sample"), "{}", fixed.err);
    let proposed: String =
        fixed.err.lines().filter(|line| line.starts_with("  ")).map(|line| format!("{line}\n")).collect();
    assert!(proposed.trim_start().starts_with("[[vary]]"), "{proposed}");
    let varied = check(&format!("{text}\n{proposed}"));
    assert!(!varied.err.contains("in every sample"), "{}", varied.err);
    assert!(varied.out.contains("small: 72 samples"), "{}", varied.out);
    // a varied angle elsewhere has the same effect; an axisymmetric machine needs no note
    let turned =
        check(&format!("{text}\n[[vary]]\npath = \"rotor.initial.angle\"\nvalues = [\"0 deg\", \"20 deg\"]\n"));
    assert!(!turned.err.contains("in every sample"), "{}", turned.err);
    // angles that differ by whole periods are equal
    let again = |values: &str| check(&format!("{text}\n[[vary]]\npath = \"blade_off.phase\"\nvalues = [{values}]\n"));
    let same = again("\"10 deg\", \"370 deg\", \"55 deg\"");
    assert!(same.err.contains("are the same angle: they differ by whole periods of 45 deg"), "{}", same.err);
    assert!(!again("\"0 deg\", \"50 deg\"").err.contains("the same angle"));
    let round = check(&(text + "\n[set]\n\"run.engine\" = \"reduced\"\n\"diaphragms.seal.blades.count\" = 0\n"));
    assert!(!round.err.contains("in every sample"), "{}", round.err);
}

#[test]
fn the_template_of_a_study_runs_as_it_is() {
    let folder = Folder::new();
    fs::rename(folder.path("machines/rig.toml"), folder.path("machines/lab_rig.toml")).expect("renamed");
    let study = folder.name("my.toml");
    assert_eq!(say(&["new", "study", "--out", &study]).code, 0);
    let ran = say(&["run", &study, "--out", &folder.name("out"), "--limit", "1"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let (header, rows) = crate::support::table(&folder.name("out"));
    assert!(header.iter().any(|name| name == "release_angle_rad"), "{header:?}");
    // one start in every cell
    assert_eq!(rows.len(), 9);
    let check = say(&["check", &study]);
    assert!(check.code == 0 && !check.err.contains("angle"), "{}", check.err);
}

#[test]
fn the_template_of_a_risk_study_is_checked_run_answered_and_judged() {
    let folder = Folder::new();
    fs::rename(folder.path("machines/rig.toml"), folder.path("machines/lab_rig.toml")).expect("renamed");
    let study = folder.name("risk.toml");
    assert_eq!(say(&["new", "study", "--kind", "risk", "--out", &study]).code, 0);
    let check = say(&["check", &study]);
    assert!(check.code == 0 && !check.err.contains("angle"), "{}", check.err);
    for said in [
        "256 points of 5 uncertain parameters",
        "lognormal, median 10 g",
        "= cold_gap - growth",
        "P(max_bearing_load_N > 80 N)",
    ] {
        assert!(check.out.contains(said), "{said}: {}", check.out);
    }
    let ran = say(&["run", &study, "--out", &folder.name("risk"), "--limit", "4"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert!(ran.out.contains("Answers, of 4 points"), "{}", ran.out);
    // four points decide nothing
    assert_eq!(say(&["gate", &folder.name("risk")]).code, 5);
    assert_eq!(say(&["new", "machine", "--kind", "risk"]).code, 2);
}

/// A process whose output is read while it runs.
struct Heard {
    child: Child,
    said: Arc<Mutex<Vec<u8>>>,
}

impl Heard {
    fn of(child: Child, mut output: impl Read + Send + 'static) -> Self {
        let said = Arc::new(Mutex::new(Vec::new()));
        let into = Arc::clone(&said);
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = output.read(&mut bytes) {
                into.lock().unwrap_or_else(PoisonError::into_inner).extend(&bytes[..count]);
            }
        });
        Self { child, said }
    }

    fn bytes(&self) -> Vec<u8> {
        self.said.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn text(&self) -> String {
        String::from_utf8_lossy(&self.bytes()).into_owned()
    }
}

impl Drop for Heard {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn on_a_terminal_of_60_columns_keys_leave_no_copies_of_the_bar() {
    if !Command::new("script").arg("--version").output().is_ok_and(|found| found.status.success()) {
        let _ = writeln!(std::io::stderr(), "SKIPPED, not tested: a terminal takes `script` (util-linux)");
        return;
    }
    let folder = Folder::new();
    let study = folder.write("s.toml", &STUDY.replace("0.1 s", "0.4 s").replace("count = 5", "count = 500"));
    let out = folder.name("out");
    let inside = format!("stty cols 60 rows 24 && exec {BINARY} run {study} --out {out} --workers 2");
    let mut command = Command::new("script");
    command
        .args(["-q", "-e", "-f", "-c", &inside, "/dev/null"])
        .env("TERM", "xterm")
        .current_dir(crate::support::root());
    let mut child =
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("script starts");
    let (mut keys, output) = (child.stdin.take().expect("piped"), child.stdout.take().expect("piped"));
    let mut run = Heard::of(child, output);
    let bars = |text: &str| {
        let rows = screen(text, 60);
        rows.iter().filter(|row| row.contains('░') || row.contains('█')).count()
    };
    wait_until("the bar", || run.text().contains('░'));
    assert!(run.text().contains("s and Enter: what each worker does"), "{}", run.text());
    for times in 1..=2 {
        keys.write_all(b"s\n").expect("typed");
        // both workers are listed, and the bar is drawn again after that
        let told = || run.text().matches("worker 2 (process").count() == times;
        wait_until("an answer", told);
        let behind = || run.text().rsplit("worker 2 (process").next().is_some_and(|text| text.contains('░'));
        wait_until("the bar again", behind);
        assert_eq!(bars(&run.text()), 1, "{:?}", screen(&run.text(), 60));
    }
    keys.write_all(b"x\n").expect("typed");
    wait_until("the line is taken back", || run.text().matches("\x1b[A").count() == 3);
    keys.write_all(b"\x03").expect("typed");
    wait_until("its end", || run.child.try_wait().expect("a child").is_some());
    wait_until("its last words", || run.text().contains("resume with: "));
    assert_eq!(run.child.wait().expect("ended").code(), Some(130), "{}", run.text());
    let rows = screen(&run.text(), 60);
    assert_eq!(bars(&run.text()), 0, "{rows:?}");
    assert!(rows.iter().any(|row| row.contains("interrupted: ")), "{rows:?}");
}

#[test]
fn a_run_that_takes_long_says_how_far_it_is() {
    let folder = Folder::reduced();
    let rig = folder.name("machines/rig.toml");
    let mut child = bladeoff(&["simulate", &rig, "--set", "run.end_time=400 s", "--step", "0.05 us"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let output = child.stderr.take().expect("piped");
    let run = Heard::of(child, output);
    wait_until("a line", || run.text().contains('\n'));
    let text = run.text();
    for part in [" of 400 s, ", " rpm, ", " s per second, at this pace "] {
        assert!(text.contains(part), "{part}: {text}");
    }
}
