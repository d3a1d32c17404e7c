//! Modes for display only: faer and a reduced basis against the solver of runs, which uses all degrees of freedom.
#![expect(clippy::unreadable_literal, reason = "reference values as they were computed")]

use super::{bearing_tables, pedestals};
use crate::common::{close, machine, study_machine, table_rotor};
use bladeoff_core::modal::{CriticalSpeed, Eigensolver, Whirl, WhirlMode, Work, report_by};
use bladeoff_model::machine::Machine;

/// Number of compared modes at each speed: the default of a table.
const SHOWN: usize = 12;
/// Tolerance for the share of a whirl sense, which depends on the mode shapes; their rounding is that of the eigenvalues divided by their distances.
const SHARE: f64 = 1e-6;

fn fine(text: &str, elements: usize) -> Machine {
    machine(&text.replace("elements = 4", &format!("elements = {elements}")))
}

/// A realistic shaft line, in sections of 40 mm: two bearings, five discs, ten seals with cross-coupled stiffness.
fn many_seals() -> Machine {
    let mut text = String::from(
        "schema = 1\nname = \"many-seals\"\n[run]\nend_time = 0.01\n[rotor]\ninitial_speed = \"8600 rpm\"\n\
         [rotor.material]\nyoung_modulus = 2.07e11\npoisson_ratio = 0.25\ndensity = 7830\n",
    );
    for section in 0..40 {
        let diameter = if (8..32).contains(&section) { 0.12 } else { 0.09 };
        text.push_str(&format!("[[rotor.shaft]]\nlength = 0.04\ndiameter = {diameter}\nelements = 1\n"));
    }
    for disc in 0..5 {
        let position = f64::from(48 + 16 * disc) / 100.0;
        text.push_str(&format!(
            "[rotor.discs.w{disc}]\nposition = {position}\nmass = 7.0\ntransverse_inertia = 0.025\npolar_inertia = 0.047\n"
        ));
    }
    for (name, position, axial) in [("de", 0.2, "axial_stiffness = 1e6\n"), ("nde", 1.4, "")] {
        text.push_str(&format!(
            "[rotor.bearings.{name}]\nposition = {position}\n{axial}stiffness = [[1.2e8, -5e5], [-5e5, 1.4e8]]\n\
             damping = [[1.7e5, -300], [-300, 1.8e5]]\n"
        ));
    }
    for seal in 0..10 {
        let position = f64::from(44 + 8 * seal) / 100.0;
        text.push_str(&format!(
            "[rotor.bearings.seal{seal}]\nposition = {position}\nstiffness = [[2e5, 1e6], [-1e6, 2e5]]\ndamping = [[2e3, 50], [-50, 2e3]]\n"
        ));
    }
    machine(&text)
}

fn compare_critical(name: &str, found: &CriticalSpeed, wanted: &CriticalSpeed) {
    let what = format!("{name}, critical speed {}", wanted.speed);
    close(&what, found.speed, wanted.speed, 1e-9);
    assert!((found.damping_ratio - wanted.damping_ratio).abs() < 1e-9, "{what}: {found:?} {wanted:?}");
    assert!((found.share - wanted.share).abs() < SHARE && found.whirl == wanted.whirl, "{what}: {found:?} {wanted:?}");
}

fn compare_modes(name: &str, found: &WhirlMode, wanted: &WhirlMode) {
    let what = format!("{name}, mode {}", wanted.frequency);
    close(&what, found.frequency, wanted.frequency, 1e-9);
    assert!((found.damping_ratio - wanted.damping_ratio).abs() < 1e-9, "{what}: {found:?} {wanted:?}");
    assert!((found.share - wanted.share).abs() < SHARE && found.whirl == wanted.whirl, "{what}: {found:?} {wanted:?}");
}

/// Compares both solvers at rest and at a speed; returns the work of each, that of the solver of runs first.
fn compare(name: &str, machine: &Machine, speed: f64) -> [Work; 2] {
    let [wanted, found] = [Eigensolver::Own, Eigensolver::Display]
        .map(|solver| report_by(solver, machine, &[0.0, speed]).unwrap_or_else(|error| panic!("{name}: {error}")));
    assert_eq!(wanted.work.reduced, 0);
    assert!(!wanted.critical_speeds.is_empty(), "{name}");
    assert_eq!(found.critical_speeds.len(), wanted.critical_speeds.len(), "{name}");
    for (found, wanted) in found.critical_speeds.iter().zip(&wanted.critical_speeds) {
        compare_critical(name, found, wanted);
    }
    for (found, wanted) in found.speeds.iter().zip(&wanted.speeds) {
        assert_eq!(
            (found.whirl.len(), found.overdamped.len()),
            (wanted.whirl.len(), wanted.overdamped.len()),
            "{name}"
        );
        for ((number, found), (other, wanted)) in found.whirl.iter().zip(&wanted.whirl).take(SHOWN) {
            assert_eq!(number, other, "{name}: {found:?} {wanted:?}");
            compare_modes(name, found, wanted);
        }
        for (found, wanted) in found.overdamped.iter().zip(&wanted.overdamped).take(SHOWN) {
            close(&format!("{name}, decay"), found.decay, wanted.decay, 1e-9);
        }
    }
    [wanted.work, found.work]
}

#[test]
fn both_solvers_agree_on_every_kind_of_machine() {
    let on_pedestals = pedestals::text(pedestals::MASS, "[rotor]\ninitial_speed = 200\n[run]\nend_time = 1\n");
    let table = |interpolation: &str| table_rotor(interpolation, bearing_tables::AT_CONSTANT_SPEED);
    let ends_disagree = include_str!("../data/two_discs_soft_end.toml");
    let cases = [
        ("the lab rig", machine(&study_machine("lab_rig")), 300.0),
        ("the turbine", machine(&study_machine("lp_turbine_paper")), 150.0),
        ("ends that disagree", machine(ends_disagree), 314.0),
        ("pedestals", fine(&on_pedestals, 4), 200.0),
        ("a table", fine(&table("linear"), 4), 333.0),
    ];
    for (name, machine, speed) in &cases {
        compare(name, machine, *speed);
    }
    // enough degrees of freedom for a reduced basis
    let cases = [
        ("pedestals, finer", fine(&on_pedestals, 20), 200.0),
        ("a linear table, finer", fine(&table("linear"), 20), 333.0),
        ("a pchip table, finer", fine(&table("pchip"), 20), 333.0),
    ];
    for (name, machine, speed) in &cases {
        let [own, work] = compare(name, machine, *speed);
        assert!(work.reduced > 64 && 4 * work.full < own.full, "{name}: {work:?} {own:?}");
    }
}

/// At rest, the solver of runs does not converge on this model: undamped in one plane, damped in the other.
#[test]
fn a_model_on_which_the_solver_of_runs_fails_has_its_modes() {
    let ends_disagree = include_str!("../data/two_discs_soft_end.toml").replace("elements = 1", "elements = 4");
    let report = report_by(Eigensolver::Display, &machine(&ends_disagree), &[0.0, 314.0]).expect("solvable");
    assert!(report.critical_speeds.len() >= 3);
    for (found, rpm) in report.critical_speeds.iter().zip([1503.8, 1606.3, 1798.4]) {
        close("critical speed", found.speed * 30.0 / std::f64::consts::PI, rpm, 1e-4);
        assert!(found.whirl != Whirl::Forward && found.is_excited_by_unbalance(), "{found:?}");
    }
    assert!(report.work.reduced > 64, "{:?}", report.work);
}

/// Critical speeds \[rad/s\] and damping ratios by the solver of runs.
const MANY_SEALS: [[f64; 2]; 11] = [
    [793.2206347796016, 0.25794883854121964],
    [795.0989967269887, 0.11758466218845873],
    [2990.6194151448767, 0.049620010600174756],
    [3155.4204467613404, 0.04232877851826321],
    [5048.806481653554, 0.04075624689428718],
    [5616.995122180729, 0.05295305203923408],
    [6773.924715888405, 0.22431747042428987],
    [7632.091960248367, 0.2860962280378087],
    [9293.035052846406, 0.2913538482239909],
    [10407.690723564372, 0.33571713620144045],
    [12785.671703934224, 0.211181902922208],
];
/// Critical speeds \[rad/s\] of a shaft of 40 elements on two bearings without damping, by the solver of runs.
const PLAIN: [f64; 12] = [
    565.1019448069629,
    566.1696547479688,
    1636.4305711465736,
    1642.031100287591,
    2718.6866308959366,
    2750.0201050216706,
    4528.632361000607,
    4670.079973232266,
    7690.764975630046,
    8107.976526390663,
    11968.615470617848,
    12908.420162301953,
];

#[test]
fn a_shaft_line_as_drawn_needs_few_large_problems() {
    let report = report_by(Eigensolver::Display, &many_seals(), &[0.0]).expect("solvable");
    assert_eq!(report.critical_speeds.len(), MANY_SEALS.len());
    for (found, [speed, damping]) in report.critical_speeds.iter().zip(MANY_SEALS) {
        close("critical speed", found.speed, speed, 1e-9);
        assert!((found.damping_ratio - damping).abs() < 1e-9, "{found:?}");
    }
    assert!(report.work.full <= 5 && report.work.reduced <= 150, "{:?}", report.work);

    let text = "schema = 1\nname = \"plain\"\n[run]\nend_time = 0.02\n[rotor]\ninitial_speed = \"3000 rpm\"\n\
         [rotor.material]\nyoung_modulus = 2.1e11\npoisson_ratio = 0.3\ndensity = 7850\n\
         [[rotor.shaft]]\nlength = 1.0\ndiameter = 0.05\nelements = 40\n\
         [rotor.bearings.l]\nposition = 0.0\nstiffness = 1e7\naxial_stiffness = 1e6\n\
         [rotor.bearings.r]\nposition = 1.0\nstiffness = 1e7\n";
    let report = report_by(Eigensolver::Display, &machine(text), &[0.0]).expect("solvable");
    assert_eq!(report.critical_speeds.len(), PLAIN.len());
    for (found, speed) in report.critical_speeds.iter().zip(PLAIN) {
        close("critical speed", found.speed, speed, 1e-9);
        assert_eq!(found.damping_ratio, 0.0);
    }
    assert!(report.work.full <= 5 && report.work.reduced <= 150, "{:?}", report.work);
}

#[test]
fn two_reports_are_the_same_to_the_last_bit() {
    let machine = fine(&pedestals::text(pedestals::MASS, "[rotor]\ninitial_speed = 200\n[run]\nend_time = 1\n"), 20);
    let report = || report_by(Eigensolver::Display, &machine, &[0.0, 200.0]).expect("solvable");
    assert_eq!(report(), report());
}
