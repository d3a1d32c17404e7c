//! Limits on the resources that small files can use: memory for every cell, a search for every error. Error messages name place and reason.

use crate::cap::{self, case};
use crate::support::{Folder, said, say};
use bladeoff::run::own_columns;
use bladeoff_model::machine::{MachineDef, ParamValue};
use bladeoff_study::{Samples, StudyError, load};
use bladeoff_text::document::{MOST_PROBLEMS, Problems};
use std::process::Command;

const HEAD: &str = "schema = 1\nmachine = \"machines/rig.toml\"\n";
const POINTS: &str = "[points]\nfile = \"points.csv\"\n";

/// Problems of a study that is rejected within this memory.
fn refused(most: usize, folder: &Folder, text: &str) -> Vec<Problems> {
    let study = folder.write("s.toml", text);
    match case(most, || load(study.as_ref(), own_columns)) {
        Err(StudyError::Problems(files)) => files,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_points_file_costs_its_bytes_and_eight_per_cell() {
    let folder = Folder::new();
    let rows = 200_000_usize;
    let points: String =
        (0..rows).map(|i| format!("0.{} mm,0.{},hyp{}\n", 300_000 + i, 100 + i % 200, 1 + i % 2)).collect();
    let points = format!("contact.gap,contact.friction,contact.detection\n{points}");
    folder.write("points.csv", &points);
    let study = folder.write("s.toml", &format!("{HEAD}{POINTS}"));
    let most = points.len() + rows * (8 + 8 + 1) + (1 << 20);
    let samples = case(most, || {
        Samples::new(load(study.as_ref(), own_columns).expect("valid"), None, None).expect("not too many")
    });
    assert_eq!(samples.count(), rows as u64);
    let word = ParamValue::Choice("hyp2".to_owned());
    assert_eq!(samples.values(199_999), [ParamValue::Number(0.000_499_999), ParamValue::Number(0.299), word]);
}

/// Complete check of a study with many points, in a process with little memory: one machine per point used to be kept in memory.
#[test]
fn checking_many_points_takes_no_memory_for_each() {
    let folder = Folder::new();
    folder.write("points.csv", &format!("contact.gap\n{}", "0.5 mm\n".repeat(200_000)));
    let study = folder.write("s.toml", &format!("{HEAD}[set]\n\"run.end_time\" = \"1 ms\"\n{POINTS}"));
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -v 600000; exec \"$0\" check \"$1\" --list", env!("CARGO_BIN_EXE_bladeoff"), &study]);
    let said = said(command.env("RAYON_NUM_THREADS", "2").output().expect("it starts"));
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(said.out.lines().last(), Some("199999\t0.0005"));
}

#[test]
fn too_many_points_are_refused_before_any_is_read() {
    let folder = Folder::new();
    let points = format!("contact.gap\n# a remark\n{}", "x\n".repeat(1_000_001));
    folder.write("points.csv", &points);
    let files = refused(points.len() + (4 << 20), &folder, &format!("{HEAD}{POINTS}"));
    let [problem] = &files[0].list[..] else { panic!("{}", files[0]) };
    assert!(problem.file.ends_with("points.csv"), "{problem}");
    assert_eq!((problem.line, problem.message.as_str()), (1_000_003, "1000001 points"));
    assert_eq!(problem.allowed.as_deref(), Some("at most 1000000"));
}

#[test]
fn a_header_of_a_hundred_thousand_columns_is_one_problem() {
    let folder = Folder::new();
    folder.write("points.csv", &format!("{}\n0.5 mm\n", "a,".repeat(100_000)));
    let files = refused(8 << 20, &folder, &format!("{HEAD}{POINTS}"));
    let [problem] = &files[0].list[..] else { panic!("{}", files[0]) };
    assert_eq!((problem.line, problem.message.as_str()), (1, "the header has 100001 columns"));
    assert_eq!(problem.allowed.as_deref(), Some("at most 128 parameters"));
    let said = say(&["check", &folder.name("s.toml")]);
    assert!(said.code == 3 && said.err.len() < 2_000, "a long line is not shown whole: {}", said.err);
}

#[test]
fn a_row_of_millions_of_cells_is_counted() {
    let folder = Folder::new();
    let points = format!("contact.gap\n0.5 mm\nx{}\n", ",".repeat(5_000_000));
    folder.write("points.csv", &points);
    // the text, and once more in the report
    let files = refused(2 * points.len() + (4 << 20), &folder, &format!("{HEAD}{POINTS}"));
    assert_eq!(files[0].list[0].message, "has 5000001 cells, the header has 1 (separated by `,`)");
}

#[test]
fn every_cell_of_a_large_file_is_checked_and_the_first_mistakes_shown() {
    let folder = Folder::new();
    folder.write("points.csv", &format!("contact.gap\n{}", "0.5 mm\n-1 mm\n0.5 m m\n0.5 min\n".repeat(20_000)));
    let files = refused(32 << 20, &folder, &format!("{HEAD}{POINTS}"));
    assert_eq!((files[0].list.len(), files[0].left_out), (MOST_PROBLEMS, 60_000 - MOST_PROBLEMS));
    let first = &files[0].list[0];
    assert_eq!((first.line, first.column, first.value.as_deref()), (3, 1, Some("-1 mm")));
    assert_eq!(first.allowed.as_deref(), Some("1e-9 to 1e6 m"));
    let said = say(&["check", &folder.name("s.toml")]);
    assert!(said.err.ends_with("points.csv, 59950 of them not shown\n"), "{}", said.err);
    assert!(said.err.contains("error: 60000 problems in"), "{}", said.err);
}

#[test]
fn a_study_of_mistakes_is_refused_quickly() {
    let folder = Folder::new();
    let lines = |count: usize, line: &dyn Fn(usize) -> String| (0..count).map(line).collect::<String>();
    let list = |path: &str, value: &str, count: usize| {
        format!("[[vary]]\npath = \"{path}\"\nvalues = [{}]\n", format!("{value},").repeat(count))
    };
    for (text, count) in [
        (format!("[set]\n{}", lines(40_000, &|i| format!("\"contact.gp{i}\" = 1\n"))), 40_000),
        (lines(40_000, &|i| format!("key{i} = 1\n")), 40_000),
        (format!("[set.{}]\n{}", "a".repeat(500_000), lines(40_000, &|i| format!("k{i} = 1\n"))), 1),
        (format!("[set.run.{}]\nb = 1\n", "c".repeat(100_000)), 1),
        (lines(20_000, &|i| format!("[[vary]]\npath=\"a\"\nvalues=[1]\nzip=\"{i}\"\n")), 1),
        (list("contact.friction", "-1", 250_000), 250_000),
        (list("contact.detection", "\"hyp3\"", 120_000), 120_000),
        (list("contact.friction", "{}", 250_000), 250_000),
        (format!("[set]\n\"contact.gap\" = \"{} mm\"\n", "9".repeat(900_000)), 1),
        (format!("[set]\n\"contact.gap\" = \"1 {}\"\n", "q".repeat(900_000)), 1),
        (format!("[set]\n\"contact.gap\" = {}1{}\n", "[".repeat(10_000), "]".repeat(10_000)), 1),
        (format!("[points]\nfile = \"{}\"\n", "p".repeat(900_000)), 1),
    ] {
        let files = refused(256 << 20, &folder, &format!("{HEAD}{text}"));
        let file = &files[0];
        let found = file.list.len() + file.left_out;
        assert!(file.list.len() <= MOST_PROBLEMS && found == count, "{found} of {count}: {}", &file.list[0]);
        let longest = file.list.iter().map(|problem| problem.to_string().len()).max();
        assert!(longest < Some(2_000), "{longest:?} bytes for {}", &text[..60]);
    }
    println!("{}", cap::figures());
}

#[test]
fn a_machine_of_mistakes_is_refused_quickly() {
    let folder = Folder::new();
    let rig = std::fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    let lines = |count: usize, line: &dyn Fn(usize) -> String| (0..count).map(line).collect::<String>();
    for (text, least) in [
        (lines(90_000, &|i| format!("k{i}=1\n")), 90_000),
        (lines(30_000, &|i| format!("[rotor.bearings.b{i}]\nx=1\n")), 50),
        (lines(20_000, &|i| format!("[rotor.unbalances.b{i}]\nx=1\ny=2\nz=3\n")), 3_000),
        (lines(30_000, &|i| format!("[diaphragms.b{i}]\nx=1\n")), 1_000),
        (format!("[rotor.discs]\n{}", lines(40_000, &|i| format!("\"1{i}\"={{x=1}}\n"))), 1_000),
        ("[[rotor.shaft]]\nx=1\n".repeat(990), 990),
    ] {
        // keys come before the first table
        let text = if text.starts_with('k') { format!("{text}{rig}") } else { format!("{rig}\n{text}") };
        let text = if text.contains("[rotor.discs]") {
            text.replacen("[rotor.discs.left]", "[x]", 1).replacen("[rotor.discs.right]", "[y]", 1)
        } else {
            text
        };
        let problems = case(256 << 20, || MachineDef::parse("m.toml", &text)).expect_err("mistakes");
        let found = problems.list.len() + problems.left_out;
        assert!(problems.list.len() <= MOST_PROBLEMS && found >= least, "{found}: {}", &problems.list[0]);
    }
    println!("{}", cap::figures());
}

#[test]
fn a_byte_order_mark_is_skipped() {
    let folder = Folder::new();
    let mark = |name: &str, text: &str| folder.write(name, &format!("\u{feff}{text}"));
    mark("points.csv", "contact.gap,contact.friction\r\n0.5 mm,0.1\r\n");
    let rig = std::fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
    mark("machines/rig.toml", &rig);
    let study = mark("s.toml", &format!("{HEAD}{POINTS}"));
    let said = say(&["check", &study, "--list"]);
    assert_eq!((said.code, said.out.lines().last()), (0, Some("0\t0.0005\t0.1")), "{}", said.err);
    // not a column either
    mark("points.csv", "contact.gpa\n0.5 mm\n");
    mark("machines/rig.toml", &format!("schem = 1\n{rig}"));
    mark("s.toml", &format!("sed = 1\n{HEAD}{POINTS}"));
    let said = say(&["check", &study]);
    assert!(
        said.err.contains("s.toml:1:1: sed: unknown key") && said.err.contains("rig.toml:1:1: schem"),
        "{}",
        said.err
    );
    assert!(!said.err.contains('\u{feff}'), "{}", said.err);
}

#[test]
fn a_link_in_the_folder_of_a_study_is_followed() {
    let (folder, elsewhere) = (Folder::new(), Folder::new());
    std::os::unix::fs::symlink(elsewhere.path("machines/rig.toml"), folder.path("linked.toml")).expect("linked");
    let study = folder.write("s.toml", "schema = 1\nmachine = \"linked.toml\"\n");
    let said = say(&["check", &study, "--list"]);
    assert_eq!(said.code, 0, "{}", said.err);
}

/// Threads that could not start for lack of address space were reported as a limit on processes, and a smaller limit ended the command by
/// SIGABRT.
#[test]
fn a_limit_of_the_address_space_is_named_with_the_value_that_is_needed() {
    let folder = Folder::new();
    let study = folder.write("s.toml", &format!("{HEAD}[set]\n\"run.end_time\" = \"1 ms\"\n"));
    for (limit, threads, message) in [
        (
            600_000,
            "2000",
            "error: the address space is limited to 614 MB (ulimit -v 600000), and 16400 MB are needed for 2000 threads; raise the limit with \
             `ulimit -v 16015625`, or remove it with `ulimit -v unlimited`\n",
        ),
        (
            200_000,
            "2",
            "error: the address space is limited to 204 MB (ulimit -v 200000), and 416 MB are needed for 2 threads; raise the limit with \
             `ulimit -v 406250`, or remove it with `ulimit -v unlimited`\n",
        ),
    ] {
        for command in ["check", "run", "simulate"] {
            let mut shell = Command::new("sh");
            let line = format!("ulimit -v {limit}; exec \"$0\" {command} \"$1\"");
            shell.args(["-c", &line, env!("CARGO_BIN_EXE_bladeoff"), &study]);
            let said = said(shell.env("RAYON_NUM_THREADS", threads).output().expect("it starts"));
            assert_eq!((said.code, said.err.as_str()), (6, message), "{command}");
        }
    }
}
