//! Error messages: file names stay within their line, and an error has its place, its unit and a remedy.

use crate::support::processes::{state, wait_until};
use crate::support::{Folder, bladeoff, root, said, say};
use std::fs;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A file name of two lines, the second of which looks like a message of the program.
const TWO: &str = "a\nINJECTED";

/// Runs a command; asserts that no line of its output begins within a name.
fn in_its_line(args: &[&str]) -> crate::support::Said {
    let said = say(args);
    let lines = || said.out.lines().chain(said.err.lines());
    assert!(!lines().any(|line| line.trim_start().starts_with("INJECTED")), "{args:?}: {}{}", said.out, said.err);
    assert!(!said.err.contains("internal error"), "{args:?}: {}", said.err);
    said
}

/// Runs a command that names the file; asserts its exit code.
fn shown(code: i32, args: &[&str]) -> crate::support::Said {
    let said = in_its_line(args);
    let both = format!("{}{}", said.out, said.err);
    assert!(both.contains("a\\u{a}INJECTED") || both.contains("a\\nINJECTED"), "{args:?}: {both}");
    assert_eq!(said.code, code, "{args:?}: {both}");
    said
}

#[test]
fn a_name_with_a_line_feed_adds_no_line() {
    let folder = Folder::new();
    let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    let short = rig.replace("\"0.17 s\"", "\"0.01 s\"");
    let named = |end: &str| folder.name(&format!("{TWO}{end}"));
    let machine = folder.write("m.toml", &short);
    // missing, not a file, invalid, of the other kind
    for command in ["simulate", "modes", "paths", "run", "check"] {
        shown(3, &[command, &named("gone")]);
    }
    fs::create_dir(folder.path(TWO)).expect("created");
    shown(3, &["simulate", &named("")]);
    let wrong = folder.write(&format!("{TWO}.toml"), &short.replace("diameter", "diamter"));
    shown(3, &["simulate", &wrong]);
    shown(3, &["check", &wrong]);
    let study =
        folder.write(&format!("{TWO}-study.toml"), &crate::support::SMALL_STUDY.replace("rig.toml", "gone.toml"));
    shown(3, &["simulate", &study]);
    shown(3, &["run", &study]);
    // not result directories
    for command in [&["status"][..], &["export", "--csv"], &["replay", "--sample", "3"], &["why", "3", "--dir"]] {
        let directory = named("");
        let mut args = command.to_vec();
        args.insert(if args[0] == "why" { args.len() } else { 1 }, &directory);
        shown(3, &args);
    }
    folder.write(&format!("foreign/{TWO}"), "");
    shown(3, &["run", &folder.small_study(), "--out", &folder.name("foreign")]);
    // histories and figures
    shown(3, &["plot", &named(".mcap"), "--out", &folder.name("x.svg")]);
    shown(3, &["recover", &named(".mcap.tmp")]);
    shown(3, &["simulate", &machine, "--history", &named(".txt")]);
    let history = named(".csv");
    shown(0, &["simulate", &machine, "--history", &history]);
    shown(3, &["plot", &history, "--from", "9", "--out", &folder.name("x.svg")]);
    shown(3, &["plot", &history, &history, "--out", &folder.name("x.svg")]);
    shown(3, &["plot", &history, "--out", &named(".pdf")]);
    shown(0, &["plot", &history, "--out", &named("-figures")]);
    shown(0, &["plot", &history, "--kind", "orbit", "--out", &named(".svg")]);
    let replaced = shown(0, &["plot", &history, "--out", &named(".svg")]);
    assert!(replaced.err.contains("is replaced"), "{}", replaced.err);
    shown(0, &["new", "machine", "--out", &named("-new.toml")]);
    shown(3, &["new", "machine", "--out", &named("-new.toml")]);
    shown(3, &["simulate", &machine, "--set", &format!("{TWO}=1")]);
}

#[test]
fn a_result_directory_with_a_line_feed_is_named_in_one_line_and_its_commands_work() {
    let folder = Folder::new();
    folder.small_study();
    let study = folder.name(&format!("{TWO}.toml"));
    fs::rename(folder.path("small.toml"), &study).expect("renamed");
    // a command substitution removes a line feed at the end of a name
    let out = folder.name("out\nINJECTED\n");
    let begun = in_its_line(&["run", &study, "--out", &out, "--wall", "1 ms", "--limit", "4"]);
    assert!(begun.err.contains("results in ") && begun.err.contains("out\\u{a}INJECTED\\u{a}"), "{}", begun.err);
    assert_eq!(begun.code, 5, "{}", begun.err);
    // the printed command to resume can be pasted
    let pasted = |text: &str, before: &str| {
        let line = text.lines().find_map(|line| line.split_once(before)).expect("a command").1.to_owned();
        let mut shell = Command::new("bash");
        shell
            .args(["-c", line.trim()])
            .current_dir(root())
            .env(crate::support::RUNTIME_VARIABLE, crate::support::runtime());
        said(shell.output().expect("bash"))
    };
    let status = in_its_line(&["status", &out]);
    assert_eq!(pasted(&status.out, "resume ").code, 0, "{}", status.out);
    let done = in_its_line(&["run", &study, "--out", &out, "--limit", "4"]);
    assert!(done.code == 0 && done.out.contains("Table: "), "{}{}", done.out, done.err);
    let why = in_its_line(&["why", "0", "--dir", &out]);
    assert_eq!(why.code, 0, "{}", why.err);
    let which = in_its_line(&["replay", &out]);
    assert_eq!(which.code, 2, "{}", which.err);
    let replayed = pasted(&which.err, "  ");
    assert!(replayed.code == 0 && replayed.out.contains("bit for bit"), "{}{}", replayed.out, replayed.err);
    assert_eq!(in_its_line(&["export", &out, "--csv", "--out", &folder.name("t\nINJECTED.csv")]).code, 0);
    assert_eq!(in_its_line(&["status", &out, "--verify"]).code, 0);
    let table = Path::new(&out).join("results.parquet");
    flip(&table);
    for args in [&["why", "0", "--dir", &out][..], &["export", &out, "--csv"], &["replay", &out, "--sample", "0"]] {
        assert_eq!(in_its_line(args).code, 6, "{args:?}");
    }
}

/// Changes a byte in the middle of a file.
fn flip(path: &Path) {
    let mut file = fs::File::options().read(true).write(true).open(path).expect("there");
    let middle = file.metadata().expect("there").len() / 2;
    let mut byte = [0];
    file.seek(SeekFrom::Start(middle)).and_then(|_| file.read_exact(&mut byte)).expect("read");
    file.seek(SeekFrom::Start(middle)).and_then(|_| file.write_all(&[byte[0] ^ 1])).expect("written");
}

/// Source files of the program, without its tests.
fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("readable").flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        if path.is_dir() && !["target", "tests", "examples"].contains(&name.to_str().unwrap_or_default()) {
            sources(&path, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.push(path);
        }
    }
}

#[test]
fn paths_are_shown_and_not_displayed() {
    // not for the user: an environment variable, a file that is read back, an instruction for cargo
    const OTHERWISE: [&str; 3] =
        ["orchestrator/dev/src/chaos/disturbed.rs", "worker/protocol/src/owner.rs", "orchestrator/build.rs"];
    let mut all = Vec::new();
    ["system", "core", "worker", "orchestrator"].iter().for_each(|package| sources(&root().join(package), &mut all));
    assert!(all.len() > 200, "{} files", all.len());
    let mut seen = 0;
    for path in all {
        let text = fs::read_to_string(&path).expect("text");
        let program = text.split("#[cfg(test)]").next().unwrap_or_default();
        let name = path.strip_prefix(root()).expect("inside").to_str().expect("UTF-8").to_owned();
        let displays = program.contains(".display()");
        seen += usize::from(displays);
        assert!(!displays || OTHERWISE.contains(&name.as_str()), "{name}: `shown(path)` instead of `.display()`");
        assert!(!program.contains("to_string_lossy()\")"), "{name}");
    }
    assert_eq!(seen, OTHERWISE.len(), "what is no longer needed");
}

#[test]
fn a_file_of_the_other_kind_is_told_with_the_command_for_it() {
    let folder = Folder::new();
    let (machine, study) = (folder.name("machines/rig.toml"), folder.small_study());
    for command in ["simulate", "modes", "paths"] {
        let said = say(&[command, &study]);
        assert_eq!(said.code, 3, "{}", said.err);
        assert!(said.err.contains("is a study file, not a machine"), "{}", said.err);
        assert!(said.err.contains(&format!(" run {study}")), "{}", said.err);
        assert!(said.err.contains(&format!(" simulate {}", folder.name("machines/rig.toml"))), "{}", said.err);
        assert!(!said.err.contains("unknown key"), "{}", said.err);
    }
    // `check` accepts a machine, too, unless samples are requested
    for command in [&["run"][..], &["check", "--list"]] {
        let said = say(&[command, &[machine.as_str()]].concat());
        assert_eq!(said.code, 3, "{}", said.err);
        assert!(said.err.contains("is a machine file, not a study"), "{}", said.err);
        assert!(said.err.contains(&format!(" simulate {machine}")), "{}", said.err);
    }
    let twice = folder.write("s.toml", "schema = 1\nmachine = \"small.toml\"\n");
    let said = say(&["check", &twice]);
    assert!(
        said.code == 3 && said.err.contains("s.toml:2:11: machine = \"small.toml\": is a study file"),
        "{}",
        said.err
    );
    // errors of a machine file are reported first
    let text = fs::read_to_string(&machine).expect("the rig").replace("friction =", "frction =");
    let said = say(&["simulate", &folder.write("m.toml", &text)]);
    assert!(said.code == 3 && said.err.contains("did you mean `friction`"), "{}", said.err);
}

#[test]
fn a_start_beside_the_ring_has_its_place_and_what_is_allowed() {
    let folder = Folder::new();
    let rig = folder.name("machines/rig.toml");
    let line = |path: &str, key: &str| {
        let text = fs::read_to_string(path).expect("text");
        1 + text.lines().position(|line| line.starts_with(key)).unwrap_or_else(|| panic!("{key}"))
    };
    let tells = |said: &crate::support::Said, parts: &[&str]| {
        assert_eq!(said.code, 3, "{}", said.err);
        parts.iter().for_each(|part| assert!(said.err.contains(part), "{part}: {}", said.err));
    };
    let inside = ["diaphragms.seal.contact.offset[0] = 2 mm", "gap -1.5 mm", "the gap of 0.5 mm", "2 mm apart"];
    let said = say(&["simulate", &rig, "--set", "contact.offset[0]=2 mm"]);
    tells(&said, &inside);
    tells(&said, &[&format!("rig.toml:{}:", line(&rig, "offset = ")), "with --set 'contact.offset[0]=2 mm' in place"]);
    tells(
        &say(&["simulate", &rig, "--set", "rotor.initial.displacement[1]=3 mm"]),
        &["rotor.initial.displacement[1] = 3 mm"],
    );
    // gravity bends the shaft by more than this tiny gap
    let gap = ["--set", "contact.gap=1e-8", "--set", "rotor.gravity[1]=-9.81"];
    let said = say(&[&["simulate", &rig][..], &gap].concat());
    tells(&said, &[&format!("rig.toml:{}:", line(&rig, "gap = ")), "contact.gap = 1e-8 m"]);
    let said = say(&["simulate", &rig, "--set", "contact.offset[0]=40 mm", "--set", "rotor.gravity[1]=-9.81"]);
    tells(&said, &["contact.offset[0] = 40 mm"]);
    // in a study: at the varied value, otherwise in the machine
    let text = "schema = 1\nmachine = \"machines/rig.toml\"\n[[vary]]\npath = \"contact.offset[0]\"\nvalues = [\"0 mm\", \"2 mm\"]\n";
    let study = folder.write("s.toml", text);
    for command in ["check", "run"] {
        let said = say(&[command, &study, "--limit", "2"]);
        tells(&said, &inside);
        tells(&said, &["s.toml:4:8: ", "the run with diaphragms.seal.contact.offset[0] = 2 mm cannot start"]);
    }
    let text = "schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"contact.offset[0]\" = \"2 mm\"\n";
    let said = say(&["check", &folder.write("s.toml", text)]);
    tells(&said, &inside);
}

#[test]
fn a_key_of_set_is_shown_with_its_value_and_a_text_with_its_place() {
    let folder = Folder::new();
    let study =
        |set: &str| folder.write("s.toml", &format!("schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n{set}\n"));
    let said = say(&["check", &study("\"contact.gapp\" = \"1 mm\"")]);
    assert!(said.err.contains("set.contact.gapp = \"1 mm\": this machine has no such parameter"), "{}", said.err);
    let where_to = "write `disc = \"...\"` in [rotor.unbalances.blade_off] of the machine file";
    let said = say(&["check", &study("\"blade_off.disc\" = \"d\"")]);
    assert!(said.err.contains("set.blade_off.disc = \"d\": rotor.unbalances.blade_off.disc is text"), "{}", said.err);
    assert!(said.err.contains(where_to) && !said.err.contains("did you mean"), "{}", said.err);
    let rig = folder.name("machines/rig.toml");
    let said = say(&["simulate", &rig, "--set", "blade_off.disc=d"]);
    assert!(said.code == 3 && said.err.contains(where_to), "{}", said.err);
    let said = say(&["simulate", &rig, "--set", "name=d"]);
    assert!(said.code == 3 && said.err.contains("at the top of the machine file"), "{}", said.err);
    // a column of points may have this name
    folder.write("p.csv", "name,contact.gap\nx,0.0005\n");
    let points = folder.write("s.toml", "schema = 1\nmachine = \"machines/rig.toml\"\n[points]\nfile = \"p.csv\"\n");
    let said = say(&["check", &points]);
    assert!(said.err.contains("carry = [\"name\"]"), "{}", said.err);
}

#[test]
fn a_unit_as_people_write_it_is_answered_with_ours() {
    let folder = Folder::new();
    let rig = folder.name("machines/rig.toml");
    for (set, meant) in [
        ("contact.gap=3 inch", "`in`"),
        ("initial_speed=1500 RPM", "`rpm`"),
        ("blade_off.mass=1 lbs", "`lb`"),
        ("braking.constant=3 NM", "`Nm`"),
        ("bearings.left.stiffness=1 lb/in", "`lbf/in`"),
    ] {
        let said = say(&["simulate", &rig, "--set", set]);
        assert!(said.code == 3 && said.err.contains(&format!("did you mean {meant}?")), "{set}: {}", said.err);
        assert!(said.err.contains("  allowed: "), "{set}: {}", said.err);
    }
}

#[test]
fn the_largest_step_as_it_is_printed_is_allowed() {
    let folder = Folder::reduced();
    let rig = folder.name("machines/rig.toml");
    let simulate = |more: &[&str]| {
        let said = say(&[&["simulate", &rig, "--set", "run.end_time=1 ms"][..], more].concat());
        assert_eq!(said.code, 0, "{}", said.err);
        said.out
    };
    let told = simulate(&[]);
    let largest = told.split("(largest allowed ").nth(1).and_then(|rest| rest.split(')').next()).expect("a step");
    assert!(simulate(&["--step", largest]).contains(&format!(" {largest} (largest allowed")), "{told}");
}

#[test]
fn check_says_what_samples_share_and_which_are_computed_twice() {
    let folder = Folder::new();
    let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    folder.write("machines/rig.toml", &rig.replace("\"0.17 s\"", "\"1 ms\""));
    let check = |more: &str| {
        let study = folder.write("s.toml", &format!("schema = 1\nmachine = \"machines/rig.toml\"\n{more}"));
        let said = say(&["check", &study]);
        assert_eq!(said.code, 0, "{}", said.err);
        said.out
    };
    let vary = |path: &str, values: &str| format!("[[vary]]\npath = \"{path}\"\nvalues = [{values}]\n");
    let gap = vary("contact.gap", "0.4e-3, 0.5e-3, 0.6e-3");
    let told = check(&gap);
    assert!(told.contains("Structure: all samples share one;") && !told.contains("Twins"), "{told}");
    assert!(!told.contains("its own matrices"), "{told}");
    let stiff = vary("bearings.left.stiffness", "2e6, 3e6");
    let told = check(&format!("twin_share = \"50 %\"\n{gap}{stiff}"));
    assert!(
        told.contains("Structure: rotor.bearings.left.stiffness changes it; matrices and modes are computed"),
        "{told}"
    );
    assert!(told.contains("Each sample's time holds that of its own matrices and modes."), "{told}");
    assert!(told.contains("Twins: 4 of 6 samples (twin_share 50 %) are computed twice"), "{told}");
    assert!(told.contains("larger by 1e-6 of it"), "{told}");
    let told = check(&format!("[set]\n\"run.twin\" = 2e-6\n{gap}"));
    assert!(told.contains("Twins: every sample is computed twice (run.twin)") && told.contains("by 2e-6"), "{told}");
    // a value that few samples have, none of which is the first, the second, the middle or the last
    let rare = "[set]\n\"run.engine\" = \"reduced\"\n[design]\nkind = \"monte-carlo\"\nsamples = 400\n[[uncertain]]\n\
        path = \"bearings.left.damping\"\ndistribution = \"discrete\"\nvalues = [600, 700]\nweights = [0.99, 0.01]\n";
    let told = check(rare);
    assert!(told.contains("Structure: rotor.bearings.left.damping changes it;"), "{told}");
    let told = check(&vary("run.twin", "0, 1e-6"));
    assert!(told.contains("Twins: a sample whose run.twin is above 0 is computed twice."), "{told}");
    assert!(told.contains("A run with status failed or beyond has no twin."), "{told}");
}

#[test]
fn a_small_stack_is_enough() {
    let folder = Folder::new();
    let out = folder.name("out");
    let study = folder.small_study();
    let rig = folder.name("machines/rig.toml");
    for args in
        [&["paths", &rig][..], &["simulate", &rig], &["run", &study, "--out", &out, "--limit", "2"], &["status", &out]]
    {
        let mut shell = Command::new("sh");
        shell.args(["-c", "ulimit -s 64; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_bladeoff")]).args(args);
        shell.current_dir(root()).env(crate::support::RUNTIME_VARIABLE, crate::support::runtime());
        let said = said(shell.output().expect("a shell"));
        assert_eq!(said.code, 0, "{args:?}: {}", said.err);
    }
}

#[test]
fn on_a_terminal_of_60_columns_lines_are_broken_between_words() {
    if !Command::new("script").arg("--version").output().is_ok_and(|found| found.status.success()) {
        let _ = writeln!(std::io::stderr(), "SKIPPED, not tested: a terminal takes `script` (util-linux)");
        return;
    }
    let folder = Folder::new();
    folder.small_study();
    let wrong =
        "schema = 1\nmachine = \"machines/rig.toml\"\n[set]\n\"contact.gapp\" = \"1 mm\"\n\"contact.friction\" = -1\n";
    folder.write("w.toml", wrong);
    // text on the terminal, without the escape sequences of colours
    let on_terminal = |args: &str| {
        let inside = format!("stty cols 60 rows 24 && exec ./bladeoff {args}");
        let mut command = Command::new("script");
        command.args(["-q", "-e", "-f", "-c", &inside, "/dev/null"]).env("TERM", "xterm").env("NO_COLOR", "1");
        command
            .current_dir(folder.path(""))
            .env(crate::support::RUNTIME_VARIABLE, crate::support::runtime())
            .stdin(Stdio::null());
        String::from_utf8(command.output().expect("script starts").stdout).expect("UTF-8").replace('\r', "\n")
    };
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_bladeoff"), folder.path("bladeoff")).expect("linked");
    for (args, parts) in [
        ("check w.toml", &["set.contact.gapp", "did you mean", "error: 2 problems in w.toml"][..]),
        ("check small.toml", &["Structure: all samples share one;", "the whole study: about"]),
        ("run small.toml --out out --limit 4", &["largest bearing load", "  hyp1: ", "Table: out/results.parquet"]),
        ("simulate w.toml", &["is a study file"]),
        ("why 0 --dir out", &["max_bearing_load"]),
    ] {
        let text = on_terminal(args);
        for part in parts {
            assert!(text.contains(part), "{args}: {part}: {text}");
        }
        // a command stays in one line; the progress bar limits its own length
        let long = |line: &&str| line.chars().count() > 60 && !line.contains("./bladeoff") && !line.contains('\u{1b}');
        assert_eq!(text.lines().find(long), None, "{args}: {text}");
    }
    // lines to a pipe are not broken
    let piped = said(bladeoff(&["check", &folder.name("small.toml")]).output().expect("it starts"));
    assert!(piped.out.lines().any(|line| line.chars().count() > 60), "{}", piped.out);
}

#[test]
fn a_structure_that_takes_long_is_told_of() {
    let folder = Folder::new();
    let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    let elements = rig.lines().find(|line| line.starts_with("elements = 16")).map(str::to_owned);
    let large =
        rig.replace(&elements.expect("the ring of the rig"), "elements = 240").replace("\"0.17 s\"", "\"20 us\"");
    let machine = folder.write("m.toml", &large);
    let mut command = bladeoff(&["simulate", &machine]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    wait_until("it has ended and waits to be asked", || state(child.id()) == Some('Z'));
    // nearly all of its CPU time is for the structure, about four seconds, and not less on any busy machine
    let stat = fs::read_to_string(format!("/proc/{}/stat", child.id())).expect("not asked yet");
    let words: Vec<&str> = stat.rsplit_once(") ").expect("a name in parentheses").1.split(' ').collect();
    let ticks: u64 = words[11..13].iter().map(|ticks| ticks.parse::<u64>().expect("a number")).sum();
    let told = said(child.wait_with_output().expect("it has ended"));
    assert_eq!(told.code, 0, "{}", told.err);
    let has_word = told.err.contains("computing the matrices and modes of lab_rig, its ring of 240 elements: ");
    assert!(has_word || ticks < 3 * 100, "{ticks} ticks: {}", told.err);
}

#[test]
fn exit_codes_are_those_of_the_table() {
    let folder = Folder::new();
    let gone = |name: &str| folder.name(&format!("gone{name}"));
    folder.write("cut.mcap", "not a history");
    folder.write("cut.parquet", "not a history");
    // a missing file, or one of another kind, is invalid input for every command
    for args in [
        &["plot", &gone(".mcap"), "--out", &gone(".svg")][..],
        &["plot", &gone(".csv"), "--out", &gone(".svg")],
        &["plot", &gone(".parquet"), "--out", &gone(".svg")],
        &["recover", &gone(".mcap.tmp")],
        &["simulate", &gone(".toml")],
    ] {
        let said = say(args);
        assert!(said.code == 3 && said.err.contains("there is no file"), "{args:?}: {} {}", said.code, said.err);
    }
    for args in [
        &["plot", &folder.name("cut.mcap"), "--out", &gone(".svg")][..],
        &["plot", &folder.name("cut.parquet"), "--out", &gone(".svg")],
        &["replay", &gone(""), "--sample", "3"],
        &["status", &gone("")],
    ] {
        assert_eq!(say(args).code, 3, "{args:?}");
    }
    // invalid command lines
    for args in
        [&["simulate"][..], &["run", "x.toml", "--workers", "0"], &["plot", "x.mcap", "--kind", "x", "--out", "x"]]
    {
        assert_eq!(say(args).code, 2, "{args:?}");
    }
    // the help has every code; the reference page is generated from them
    let help = say(&["--help"]).out;
    for exit in bladeoff::cli::Exit::ALL {
        let code = (exit as u8).to_string();
        assert!(
            help.lines()
                .any(|line| line.trim_start().starts_with(&format!("{code} ")) || line.contains(&format!("; {code} "))),
            "{code}"
        );
    }
}
