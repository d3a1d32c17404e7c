//! Rotors on pedestals and on bearings with tables, and two diaphragms on one shaft, compared with an independent program.

use std::collections::BTreeMap;

use super::case::{Case, Check, NO_RUN};
use super::machine::{machine, stepping};
use crate::engine::simulate;
use crate::modal::report;
use crate::record::{NoHistory, columns};
use crate::structure::Structure;
use bladeoff_model::machine::Engine;

const ELEMENTS: &str = "independent finite elements";
const INTEGRATION: &str = "independent finite elements and Radau IIA integration";
const EXPONENTIAL: &str = "independent finite elements, matrix exponential in steps of 1 us";

pub(super) fn add(checks: &mut Vec<Check>) {
    pedestals(checks);
    tables(checks);
    two_diaphragms(checks);
}

fn pedestals(checks: &mut Vec<Check>) {
    let at_rest = on_pedestals("[rotor]\ninitial_speed = 0\n[run]\nend_time = 1\n");
    let critical = [
        [277.739_242_640_913_06, -6.411_304_163_234_179],
        [303.265_557_533_256_5, -3.331_760_922_794_566],
        [732.853_437_101_291_4, -49.222_149_848_734_08],
        [913.862_795_525_883_4, -56.821_026_781_364_99],
    ];
    criticals(checks, "skew bearings on pedestals", &at_rest, &critical);
    for (engine, step, tolerance) in [(Engine::Reduced, Some(2e-6), 1e-6), (Engine::Exponential, None, 1e-5)] {
        let step = step.map_or(format!("engine = \"{}\"\n", engine.word()), |step| stepping(engine, step));
        let text = on_pedestals(&format!(
            "[rotor]\ninitial_speed = 350\n[rotor.speed_law]\nacceleration = 0\n[run]\nend_time = 0.3\n{step}"
        ));
        let case =
            Case { name: "blade-off on pedestals", engine: engine.word(), unit: "N", source: EXPONENTIAL, tolerance };
        let row = row(&text);
        for (column, reference) in [
            ("max_bearing_force_x_left_N", 923.320_918_689),
            ("max_bearing_force_y_right_N", 2_081.631_651_807),
            ("max_pedestal_force_x_right_N", 1_300.789_182_765),
            ("max_pedestal_force_y_left_N", 1_944.670_978_216),
        ] {
            case.check(checks, column, value(&row, column), reference);
        }
    }
}

fn tables(checks: &mut Vec<Check>) {
    for (name, interpolation, critical) in [
        (
            "bearing table, linear",
            "linear",
            [[314.935_330_807_023_7, -8.308_138_880_993_809], [320.498_728_193_198_76, -7.011_672_315_516_616]],
        ),
        (
            "bearing table, pchip",
            "pchip",
            [[314.846_295_812_810_3, -8.264_855_559_036_76], [320.424_108_897_223_4, -7.048_803_444_264_763]],
        ),
    ] {
        criticals(checks, name, &on_table(interpolation), &critical);
    }
}

/// Damped critical speeds, and the real parts of their eigenvalues.
fn criticals(checks: &mut Vec<Check>, name: &'static str, text: &str, critical: &[[f64; 2]]) {
    let case = Case { name, engine: NO_RUN, unit: "rad/s", source: ELEMENTS, tolerance: 1e-9 };
    let found = machine(text).and_then(|machine| report(&machine, &[]).ok()).map(|report| report.critical_speeds);
    let from = critical.first().map_or(0.0, |[speed, _]| 0.99 * speed);
    let ours = |k: usize| found.as_ref().and_then(|all| all.iter().filter(|one| one.speed > from).nth(k));
    for (k, [speed, decay]) in critical.iter().enumerate() {
        case.check(checks, format!("critical speed {}", k + 1), ours(k).map(|one| one.speed), *speed);
        let damping = Case { unit: "", ..case };
        let reference = -decay / libm::hypot(*decay, *speed);
        damping.check(checks, format!("damping ratio {}", k + 1), ours(k).map(|one| one.damping_ratio), reference);
    }
}

fn two_diaphragms(checks: &mut Vec<Check>) {
    for (name, gaps, references) in [
        ("two diaphragms, equal gaps", [4e-4, 4e-4], [493.309_672_326, 493.309_672_326, 199.038_054_749_7]),
        ("two diaphragms, unequal gaps", [4e-4, 5.2e-4], [567.880_148_5, 356.835_520_4, 199.109_275_321_7]),
    ] {
        let engine = Engine::Full;
        let case = Case { name, engine: engine.word(), unit: "N", source: INTEGRATION, tolerance: 1e-5 };
        let row = row(&between(&stepping(engine, 4e-6), gaps));
        for (column, reference) in ["max_contact_force_a_N", "max_contact_force_b_N"].into_iter().zip(references) {
            case.check(checks, column, value(&row, column), reference);
        }
        let speed = Case { unit: "rad/s", ..case };
        speed.check(checks, "end_speed_rad_s", value(&row, "end_speed_rad_s"), references[2]);
    }
}

/// Values of a run by column; `None` if the machine cannot be run.
fn row(text: &str) -> Option<BTreeMap<String, f64>> {
    let machine = machine(text)?;
    let structure = Structure::build(&machine, None).ok()?;
    let outcome = simulate(&machine, &structure, &mut NoHistory).ok()?;
    let named = columns(&machine).into_iter().zip(outcome.values);
    Some(named.filter_map(|(column, value)| Some((column.name, value?))).collect())
}

fn value(row: &Option<BTreeMap<String, f64>>, column: &str) -> Option<f64> {
    row.as_ref()?.get(column).copied()
}

/// Shaft of 1 m with two discs; a closure writes the supports at both ends.
fn two_discs(support: impl Fn(&str) -> String, tail: &str) -> String {
    let end = |name: &str, position: f64, axial: &str| {
        format!("[rotor.bearings.{name}]\nposition = {position:?}\n{axial}{}", support(name))
    };
    format!(
        "schema = 1\nname = \"two discs\"\n\
         [rotor.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7800\n\
         [[rotor.shaft]]\nlength = 1.0\nelements = 4\ndiameter = 0.07\n\
         [rotor.discs.middle]\nposition = 0.5\nmass = 80\ntransverse_inertia = 0.8\npolar_inertia = 1.5\n\
         [rotor.discs.right]\nposition = 0.75\nmass = 20\ntransverse_inertia = 0.1\npolar_inertia = 0.2\n\
         [rotor.unbalances.blade]\nposition = 0.5\nmass = 0.05\nradius = 0.1\n{}{}{tail}",
        end("left", 0.0, "axial_stiffness = 1e6\n"),
        end("right", 1.0, "")
    )
}

fn on_pedestals(tail: &str) -> String {
    let support = |name: &str| {
        format!(
            "stiffness = [[4e7, 1e7], [-2e7, 8e7]]\ndamping = [[6e4, 0.0], [0.0, 9e4]]\n\
             [rotor.bearings.{name}.pedestal]\nmass = [40.0, 60.0]\nstiffness = [3e7, 8e7]\ndamping = [5e3, 8e3]\n"
        )
    };
    two_discs(support, tail)
}

fn on_table(interpolation: &str) -> String {
    let support = |name: &str| {
        format!(
            "kind = \"table\"\ninterpolation = \"{interpolation}\"\n[rotor.bearings.{name}.coefficients]\n\
             speeds = [100, 200, 300, 450, 700]\nkxx = [9e7, 7e7, 6e7, 5e7, 4.4e7]\nkxy = [3e7, 2.5e7, 2e7, 1.6e7, 1.2e7]\n\
             kyx = [-6e7, -5e7, -4.6e7, -4.2e7, -4e7]\nkyy = [5e7, 5.5e7, 6e7, 6.6e7, 7.5e7]\n\
             cxx = [6e5, 3.4e5, 2.4e5, 1.7e5, 1.2e5]\ncxy = [-5e4, -4e4, -3e4, -2e4, -1.5e4]\n\
             cyx = [-5e4, -4e4, -3e4, -2e4, -1.5e4]\ncyy = [4e5, 2.6e5, 2e5, 1.5e5, 1.1e5]\n"
        )
    };
    two_discs(support, "[rotor]\ninitial_speed = 350\n[run]\nend_time = 1\nend_speed = 100\n")
}

/// Shaft of 1 m with a disc of 20 kg between radial springs at a quarter and three quarters.
fn between(stepping: &str, gaps: [f64; 2]) -> String {
    let spring = |name: &str, position: f64, gap: f64| {
        format!(
            "[diaphragms.{name}]\nkind = \"radial-spring\"\nstiffness = 2e6\n[diaphragms.{name}.contact]\nposition = {position:?}\n\
             rotor_radius = 0.04\ngap = {gap:?}\nfriction = 0.15\nfriction_law = \"slip\"\n"
        )
    };
    let rotor = include_str!("two_diaphragms.toml");
    let springs = spring("a", 0.25, gaps[0]) + &spring("b", 0.75, gaps[1]);
    format!(
        "schema = 1\nname = \"two diaphragms\"\n[run]\nend_time = 0.25\nend_beyond = \"off\"\n{stepping}{rotor}{springs}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_holds() {
        let mut checks = Vec::new();
        add(&mut checks);
        assert_eq!(checks.len(), 8 + 8 + 8 + 6);
        for check in &checks {
            assert!(check.holds(), "{check:?}: {:?}", check.error());
        }
    }
}
