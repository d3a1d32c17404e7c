//! Instructions of a step of the exponential engine, pinned loosely: what makes it slow is found here, whatever else the machine does.
//!
//! Counted by callgrind in a process of its own that runs one machine twice, and in another that runs it three times: their difference is a run whose bases and cells are there.

use crate::common::{machine_with, run, study_machine};
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::lanes::{Width, width};
use std::process::Command;

/// What the processes under callgrind run, and how often.
const WORK: &str = "BLADEOFF_TEST_WORK";
const TIMES: &str = "BLADEOFF_TEST_TIMES";

/// The lab rig in a rub, the same without its ring, or with a second ring out of reach.
fn machine(work: &str) -> Machine {
    let changes = [("run.engine", "exponential"), ("run.end_time", "0.2 s"), ("run.contact_step", "6.2 us")];
    let mut text = study_machine("lab_rig");
    if work == "two rings" {
        let ring = text[text.find("[diaphragms.seal]").expect("a ring")..].replace("seal", "far");
        text += &ring.replace("position = \"0.5 m\"", "position = \"0.15 m\"");
    }
    let mut machine = machine_with(&text, &changes);
    if work == "flight" {
        machine.diaphragms.clear();
    }
    machine
}

#[test]
#[ignore = "what a_step_takes_few_instructions runs under callgrind"]
fn work_to_count() {
    let work = std::env::var(WORK).unwrap_or_else(|_| "rub".to_owned());
    let times: usize = std::env::var(TIMES).map_or(1, |times| times.parse().expect("a number"));
    // one structure for all: the second run finds the bases of the first, the third the cells of the second
    let machine = machine(&work);
    let structure = bladeoff_core::structure::Structure::build(&machine, None).expect("buildable");
    for _ in 0..times {
        let outcome =
            bladeoff_core::engine::simulate(&machine, &structure, &mut bladeoff_core::record::NoHistory).expect("runs");
        assert!(!outcome.values.is_empty());
    }
}

/// Instructions of a process that does some work so many times; `None` without callgrind.
fn counted(work: &str, times: usize) -> Option<f64> {
    let this = std::env::current_exe().expect("a test is a file");
    let out = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(this)
        .args(["--exact", "instructions::work_to_count", "--ignored", "--test-threads=1"])
        .env(WORK, work)
        .env(TIMES, times.to_string())
        .output()
        .ok()?;
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stdout));
    let said = String::from_utf8_lossy(&out.stderr).into_owned();
    let line = said.lines().find(|line| line.contains("Collected :"))?;
    line.rsplit(' ').next()?.trim().parse().ok()
}

#[test]
fn a_step_takes_few_instructions() {
    if cfg!(debug_assertions) {
        println!("SKIPPED: INSTRUCTIONS ARE COUNTED OF RELEASE BUILDS");
        return;
    }
    let mut of_a_rub = f64::INFINITY;
    // pinned for vectors of four: 12 943, 14 229 and 13 510 were counted
    let narrow = if width() == Width::Sse2 { 2.0 } else { 1.0 };
    for (work, pinned) in [("rub", 14_500.0), ("two rings", 15_900.0), ("flight", 15_100.0)] {
        let most = narrow * pinned;
        let row = run(machine(work));
        let steps = row.value("steps");
        assert!(steps > 100.0);
        if work != "flight" {
            assert!(row.value("contact_time_s") > 1e-3, "rubs");
        }
        let (Some(before), Some(with_it)) = (counted(work, 2), counted(work, 3)) else {
            println!("SKIPPED: NO VALGRIND");
            return;
        };
        let each = (with_it - before) / steps;
        println!("{work}: {each:.0} instructions a step of {steps}");
        assert!(each > 100.0 && each < most, "{work}: {each:.0} instructions a step, pinned at {most}");
        match work {
            "rub" => of_a_rub = each,
            // steps are the same with a ring out of reach
            "two rings" => assert!(each < 1.1 * of_a_rub, "a ring out of reach: {each:.0} in place of {of_a_rub:.0}"),
            _ => {}
        }
    }
}
