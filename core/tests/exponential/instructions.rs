//! Instructions per step of the exponential engine, with a loose upper limit: finds slowdowns independently of the load on the machine.
//!
//! A process runs a machine three times, and callgrind counts the third run, whose bases and cells of the speed grid exist already. The other two
//! run without instrumentation, which takes most of the time.

use crate::common::{machine_with, run, study_machine};
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::lanes::{Width, width};
use std::process::Command;

/// Work of the processes under callgrind.
const WORK: &str = "BLADEOFF_TEST_WORK";

/// The lab rig in a rub, the same without its ring, with a second ring out of reach, with bearing tables, or on pedestals. Tables and
/// pedestals have nearly the stiffness of the bearings of the rig, so the motion and the contact steps are nearly the same.
fn machine(work: &str) -> Machine {
    let changes = [("run.engine", "exponential"), ("run.end_time", "0.2 s"), ("run.contact_step", "6.2 us")];
    let mut text = study_machine("lab_rig");
    if work == "two rings" {
        let ring = text[text.find("[diaphragms.seal]").expect("a ring")..].replace("seal", "far");
        text += &ring.replace("position = \"0.5 m\"", "position = \"0.15 m\"");
    }
    if work.contains("tables") {
        text = text.replace(
            "stiffness = \"2e6 N/m\"\ndamping = \"600 N s/m\"",
            "kind = \"table\"\ncoefficients.speeds = [0, 200, 400]\ncoefficients.kxx = [2e6, 2.01e6, 2.02e6]\n\
             coefficients.kyy = [2e6, 2.01e6, 2.02e6]\ncoefficients.cxx = [606, 603, 600]\ncoefficients.cyy = [606, 603, 600]",
        );
        assert_eq!(text.matches("kind = \"table\"").count(), 2);
    }
    if work.contains("pedestals") {
        for name in ["left", "right"] {
            text += &format!("\n[rotor.bearings.{name}.pedestal]\nmass = 20\nstiffness = 2e9\ndamping = 1e4\n");
        }
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
    // one structure for all runs: the second finds the bases of the first, the third the cells of the second
    let machine = machine(&work);
    let structure = bladeoff_core::structure::Structure::build(&machine, None).expect("buildable");
    for nth in 1..=3 {
        if nth == 3 {
            ask_callgrind(START_INSTRUMENTATION);
        }
        let outcome =
            bladeoff_core::engine::simulate(&machine, &structure, &mut bladeoff_core::record::NoHistory).expect("runs");
        ask_callgrind(STOP_INSTRUMENTATION);
        assert!(!outcome.values.is_empty());
    }
}

/// Requests to callgrind: `'C' << 24 | 'T' << 16` and a number.
const START_INSTRUMENTATION: u64 = 0x4354_0004;
const STOP_INSTRUMENTATION: u64 = 0x4354_0005;

/// Sends a request to callgrind by instructions that change nothing on a processor: a rotation by 128 bits in all, and an exchange of a register
/// with itself. Valgrind finds the address of the request and its arguments in rax, and puts its answer in rdx.
fn ask_callgrind(request: u64) {
    let block = [request, 0, 0, 0, 0, 0];
    #[expect(unsafe_code, reason = "valgrind has no other interface")]
    // SAFETY: no register changes but rdx, which is named, and the block outlives the request
    unsafe {
        std::arch::asm!(
            "rol rdi, 3", "rol rdi, 13", "rol rdi, 61", "rol rdi, 51", "xchg rbx, rbx",
            in("rax") block.as_ptr(), inout("rdx") 0_u64 => _, options(nostack)
        );
    }
}

/// Instructions of some work; `None` without callgrind.
fn counted(work: &str) -> Option<f64> {
    let this = std::env::current_exe().expect("a test is a file");
    let out = Command::new("valgrind")
        .args(["--tool=callgrind", "--instr-atstart=no", "--callgrind-out-file=/dev/null"])
        .arg(this)
        .args(["--exact", "instructions::work_to_count", "--ignored", "--test-threads=1"])
        .env(WORK, work)
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
    // limits for vectors of four; the counts were 12 490, 13 715, 13 850, 13 050, 14 570 and 13 400
    let narrow = if width() == Width::Sse2 { 2.0 } else { 1.0 };
    for (work, pinned) in [
        ("rub", 13_900.0),
        ("two rings", 15_200.0),
        ("tables", 15_300.0),
        ("pedestals", 14_500.0),
        ("tables and pedestals", 16_200.0),
        ("flight", 14_800.0),
    ] {
        let most = narrow * pinned;
        let row = run(machine(work));
        let steps = row.value("steps");
        assert!(steps > 100.0);
        if work != "flight" {
            assert!(row.value("contact_time_s") > 1e-3, "rubs");
        }
        let Some(counted) = counted(work) else {
            println!("SKIPPED: NO VALGRIND");
            return;
        };
        let each = counted / steps;
        let contact = if work == "flight" { 0.0 } else { row.value("contact_time_s") };
        println!("{work}: {each:.0} instructions a step of {steps}; {contact:.4} s of contact");
        assert!(each > 100.0 && each < most, "{work}: {each:.0} instructions a step, pinned at {most}");
        // a ring out of reach costs less than 10 %, tables and pedestals less than 20 %
        let most = match work {
            "rub" => {
                of_a_rub = each;
                continue;
            }
            "two rings" => 1.1,
            "flight" => continue,
            _ => 1.2,
        };
        println!("{work}: {:.3} of the rub", each / of_a_rub);
        assert!(each < most * of_a_rub, "{work}: {each:.0} in place of {of_a_rub:.0}");
    }
}
