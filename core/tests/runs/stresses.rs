//! Moments, stresses, whirl direction and rub regime of whole runs: hand formulas, and reduced against full engine.

use crate::common::{Every, Row, close, machine, machine_with, run, run_seen, study_machine};
use bladeoff_core::record::columns;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::{Column, ColumnKind, MAX_COLUMNS, Part, Status};

/// A heavy disc in the middle of a simply supported light shaft under gravity, not spinning.
const SAGGING: &str = r#"
schema = 1
name = "sagging"
[run]
end_time = "5 ms"
engine = "full"
[rotor]
initial_speed = "0 rpm"
gravity = [3.0, -4.0]
[rotor.material]
young_modulus = "210 GPa"
poisson_ratio = 0.3
density = "0.01 kg/m3"
shear_coefficient = 0.9
[[rotor.shaft]]
length = "1 m"
diameter = "50 mm"
inner_diameter = "20 mm"
elements = 2
[[rotor.shaft]]
length = "1 m"
diameter = "50 mm"
inner_diameter = "20 mm"
elements = 2
[rotor.discs.mid]
position = "1 m"
mass = "100 kg"
transverse_inertia = "1 kg m2"
polar_inertia = "2 kg m2"
[rotor.bearings.left]
position = "0 m"
stiffness = "1e8 N/m"
damping = "0 N s/m"
axial_stiffness = "1e6 N/m"
[rotor.bearings.right]
position = "2 m"
stiffness = "1e8 N/m"
damping = "0 N s/m"
"#;

/// P L/4 over the section modulus. The sag is static, so changes are rounding only.
#[test]
fn a_sagging_shaft_has_the_moment_of_statics() {
    let row = run(machine(SAGGING));
    let modulus = std::f64::consts::PI * (0.05f64.powi(4) - 0.02f64.powi(4)) / (32.0 * 0.05);
    let expected = 100.0 * 5.0 * 2.0 / 4.0 / modulus;
    close("bending stress", row.value("max_bending_stress_Pa"), expected, 1e-6);
    close("first section", row.value("max_bending_stress_section0_Pa"), expected, 1e-6);
    close("second section", row.value("max_bending_stress_section1_Pa"), expected, 1e-6);
    assert!(row.value("max_torsional_moment_Nm") < 1e-9);
    assert_eq!(row.get("max_blade_bending_stress_Pa"), None, "there is no diaphragm");
    assert_eq!(row.get("rub_regime"), None);
}

/// A free two-disc rotor driven at one end by a prescribed speed would need a position of the drive; friction replaces the drive here. A full annular
/// rub brakes the node of contact, and the torque that slows the disc beyond passes through the shaft.
#[test]
fn a_rubbing_shaft_passes_the_torque_that_slows_the_inertia_beyond() {
    let text = study_machine("lab_rig");
    let row = run(machine_with(&text, &[("end_time", "0.17 s"), ("contact.detection", "hyp1")]));
    assert!(row.get("first_contact_s").is_some());
    // the friction torque enters at the middle of section 1: half of it passes to either side, at most doubled by the torsional response to a suddenly
    // applied torque
    let torque = 0.15 * row.value("max_contact_force_N") * 0.05;
    let moment = row.value("max_torsional_moment_Nm");
    assert!(moment > 0.1 * torque && moment < 2.0 * torque, "{moment} of {torque}");
    close(
        "moment and stress",
        row.value("max_shear_stress_Pa"),
        16.0 * moment / (std::f64::consts::PI * 0.025f64.powi(3)),
        1e-9,
    );
}

/// Two heavy discs on a light shaft, the first pressed against a spring: friction brakes it from t = 0 on.
const GRABBED: &str = r#"
schema = 1
name = "grabbed"
[run]
end_time = "6 ms"
engine = "full"
[rotor]
initial_speed = 100.0
[rotor.initial]
displacement = [11e-3, 0.0]
[rotor.material]
young_modulus = "210 GPa"
poisson_ratio = 0.3
density = "0.01 kg/m3"
shear_coefficient = 0.9
[[rotor.shaft]]
length = "1 m"
diameter = "100 mm"
inner_diameter = "40 mm"
elements = 2
[rotor.discs.near]
position = "0 m"
mass = "5000 kg"
transverse_inertia = "500 kg m2"
polar_inertia = "1 kg m2"
[rotor.discs.far]
position = "1 m"
mass = "5000 kg"
transverse_inertia = "500 kg m2"
polar_inertia = "4 kg m2"
[rotor.bearings.left]
position = "0 m"
stiffness = "1e3 N/m"
axial_stiffness = "1e6 N/m"
[rotor.bearings.right]
position = "1 m"
stiffness = "1e3 N/m"
[diaphragms.stop]
kind = "radial-spring"
stiffness = "1e7 N/m"
[diaphragms.stop.contact]
position = "0 m"
rotor_radius = "100 mm"
gap = "10 mm"
friction = 0.2
detection = "hyp1"
"#;

/// A suddenly applied torque loads an undamped shaft with twice the moment that slows the disc beyond:
/// `T = 2 mu F R J2/(J1 + J2)`, first at half a period of `omega^2 = G I_p/L (1/J1 + 1/J2)`.
#[test]
fn a_suddenly_grabbed_shaft_is_twisted_to_twice_the_static_moment() {
    let row = run(machine(GRABBED));
    assert!(row.value("contact_time_s") > 5.9e-3, "it rubs all the time");
    let pi = std::f64::consts::PI;
    let polar = pi / 32.0 * (0.1f64.powi(4) - 0.04f64.powi(4));
    let force = row.value("max_contact_force_N");
    close("force", force, 1e4, 1e-3);
    let moment = 2.0 * 0.2 * force * 0.1 * 4.0 / 5.0;
    close("moment", row.value("max_torsional_moment_Nm"), moment, 0.01);
    close("stress", row.value("max_shear_stress_Pa"), row.value("max_torsional_moment_Nm") * 0.05 / polar, 1e-9);
    let omega = (210e9 / 2.6 * polar * (1.0 + 0.25)).sqrt();
    close("time", row.value("max_torsional_moment_at_s"), pi / omega, 0.01);
    close("speed", row.value("max_torsional_moment_at_rad_s"), 100.0 - 200.0 / 5.0 * pi / omega, 1e-4);
}

/// Torsional damping in proportion to stiffness gives the first mode the damping ratio `b omega/2`. So the same torque overshoots its static moment by
/// `exp(-pi zeta/sqrt(1 - zeta^2))`, and half a period later undershoots by the square of that factor.
#[test]
fn torsion_decays_with_half_b_omega() {
    let pi = std::f64::consts::PI;
    let polar = pi / 32.0 * (0.1f64.powi(4) - 0.04f64.powi(4));
    let stiffness = 210e9 / 2.6 * polar;
    let omega = (stiffness * (1.0 + 0.25)).sqrt();
    let (zeta, torque) = (0.1_f64, 0.2 * 1e4 * 0.1);
    let root = (1.0 - zeta * zeta).sqrt();
    let left = (-pi * zeta / root).exp();
    let b = format!("{:e}", 2.0 * zeta / omega);
    // so heavy that the force of the spring stays constant; the shaft has enough inertia not to be governed by its damping: the iteration of the loaded
    // start contracts by x/(1 + x), with x = c dt/(2 m) of the node between the discs, about 40 here
    let heavy = GRABBED.replace("5000 kg", "5e6 kg").replace("500 kg m2", "5e5 kg m2").replace("\"0.01 kg", "\"10 kg");
    let text =
        heavy.replace("[rotor.bearings.left]", &format!("[rotor.damping]\ntorsional = {b}\n[rotor.bearings.left]"));
    for engine in ["full", "reduced"] {
        let mut torsion_angles = Vec::new();
        let changes = [("run.engine", engine), ("run.end_time", "16 ms")];
        let row = run_seen(
            machine_with(&text, &changes),
            &mut Every(|frame| {
                torsion_angles.push(stiffness * (frame.torsion_angles[2] - frame.torsion_angles[0]).abs())
            }),
        );
        assert!(row.value("contact_time_s") > 15.9e-3, "it rubs all the time: {} s", row.value("contact_time_s"));
        let static_moment = torque * 4.0 / 5.0;
        close("first peak", row.value("max_torsional_moment_Nm"), static_moment * (1.0 + left), 5e-3);
        close("its time", row.value("max_torsional_moment_at_s"), pi / (omega * root), 5e-3);
        let extremes: Vec<f64> = torsion_angles
            .windows(3)
            .filter(|w| (w[1] - w[0]) * (w[2] - w[1]) < 0.0)
            .map(|w| w[1] / static_moment - 1.0)
            .collect();
        assert!(extremes.len() >= 4, "{extremes:?}");
        println!("{engine}: extremes {:.4?}, decay of each {left:.4}", &extremes[..4]);
        for pair in extremes.windows(2).take(3) {
            close("decay of half a period", -pair[1] / pair[0], left, 0.02);
        }
        assert!(row.value("energy_error") < 1e-8, "{}", row.value("energy_error"));
    }
}

/// The node between the discs has almost no inertia, so that its damping governs: x = c dt/(2 m) is 40 in the test above and 4e4 here. The iteration
/// contracts by x/(1 + x); with an error reduction of one half assumed per iteration, the start once ended `diverged`. Sliding, and sticking from the
/// first step on.
#[test]
fn a_light_damped_node_starts_with_the_velocity_asked_for() {
    for (law, friction, speed) in [("slip", "0.2", 100.0), ("stick-slip", "0.2", 100.0), ("stick-slip", "100", 0.001)] {
        let text = GRABBED
            .replace("friction = 0.2", &format!("friction = {friction}\nfriction_law = \"{law}\""))
            .replace("initial_speed = 100.0", &format!("initial_speed = {speed:?}"))
            .replace("[rotor.bearings.left]", "[rotor.damping]\ntorsional = 2.8e-4\n[rotor.bearings.left]");
        for engine in ["full", "reduced"] {
            let mut frames = Vec::new();
            let changes = [("run.engine", engine), ("run.end_time", "2 ms")];
            let row = run_seen(
                machine_with(&text, &changes),
                &mut Every(|frame| frames.push((frame.time, frame.speed, frame.torsion_angles.to_vec()))),
            );
            println!(
                "{law} {friction}, {engine}: {:?}, stick {:e} s",
                row.outcome.causes.words(),
                row.value("stick_time_s")
            );
            assert_eq!(row.value("first_contact_s"), 0.0, "contact happened, from the start on");
            assert_eq!(row.outcome.status, Status::Ok, "{:?}", row.outcome);
            assert_eq!(row.value("stick_time_s") > 0.0, friction == "100");
            assert!((frames[0].1 / speed - 1.0).abs() < 1e-9, "{}", frames[0].1);
            // the torsion starts from zero with a rate of zero and grows as t^2; at a sticking node, as t
            let expected = if friction == "100" { 1.0 } else { 2.0 };
            let twisted = |n: usize| (frames[n].2[2] - frames[n].2[0]).abs();
            let order = (twisted(8) / twisted(4)).log2();
            assert!(twisted(0) == 0.0 && (order - expected).abs() < 0.1, "{order}");
        }
    }
}

/// Two other solvers with torsional damping like that of bending give 45 to 49 kN m. Without damping, the vibration of the first rub persists through
/// all later impacts, and the result is a random value of 75 to 122 kN m.
#[test]
fn the_turbine_s_torsion_rings_down_between_impacts() {
    let row = run(machine_with(&study_machine("lp_turbine_paper"), &[]));
    assert!(row.value("impacts") > 10.0, "contact happened");
    let moment = row.value("max_torsional_moment_Nm");
    println!(
        "largest torsional moment of the turbine: {moment:.0} N m, energy error {:.1e}",
        row.value("energy_error")
    );
    assert!((0.9 * 45e3..1.1 * 49e3).contains(&moment), "{moment}");
}

/// Each engine at its own default step. Quantities that depend on the raw contact force (torsion beside the contact) agree as well as that force agrees
/// between steps.
const RING_OF_FULL: f64 = 0.02;

#[test]
fn both_engines_agree_on_stresses() {
    let text = study_machine("lab_rig");
    let run_with = |engine| run(machine_with(&text, &[("end_time", "0.18 s"), ("run.engine", engine)]));
    let (full, reduced): (Row, Row) = (run_with("full"), run_with("reduced"));
    for row in [&full, &reduced] {
        assert!(row.get("first_contact_s").is_some(), "there is contact");
        assert_eq!(word(row, "rub_regime"), Some("heavy"));
        assert_eq!(word(row, "whirl_in_rub"), Some("forward"));
    }
    for (column, tolerance) in [
        ("max_ring_stress_Pa", RING_OF_FULL),
        ("max_blade_stress_Pa", 0.02),
        ("max_shaft_von_mises_Pa", 0.02),
        ("max_friction_power_W", 0.02),
        ("friction_energy_per_width_J_m", 0.02),
        ("max_bending_stress_Pa", 0.02),
        ("max_bending_stress_section0_Pa", 0.02),
        ("max_bending_stress_section1_Pa", 0.02),
        ("max_bending_stress_section2_Pa", 0.02),
        ("max_blade_bending_stress_Pa", 0.02),
        ("max_torsional_moment_section0_Nm", 0.03),
        ("max_torsional_moment_section2_Nm", 0.03),
        ("max_torsional_moment_Nm", 0.15),
    ] {
        close(column, reduced.value(column), full.value(column), tolerance);
    }
}

/// The word in a choice column.
fn word(row: &Row, name: &str) -> Option<&'static str> {
    let column = columns(&row.machine).into_iter().find(|column| column.name == name).expect("the column");
    let ColumnKind::Choice(words) = column.kind else { panic!("{name} is no choice") };
    row.get(name).map(|index| words[index as usize])
}

/// Dry backward whirl (docs/verification.md) is recognised as its regime. All values in units of the Jeffcott rotor.
#[test]
fn dry_whip_is_backward_whirl() {
    let text = r#"
schema = 1
name = "dry whip"
[run]
end_time = 60.0
step = 2e-3
[rotor]
kind = "point-mass"
mass = 1.0
polar_inertia = 1.0
initial_speed = 200.0
[rotor.initial]
displacement = [1.22, 0.0]
velocity = [0.0, -1.5625]
[rotor.bearings.support]
stiffness = 1.0
damping = 0.1
[diaphragms.stop]
kind = "radial-spring"
stiffness = 4.0
[diaphragms.stop.contact]
rotor_radius = 10.0
gap = 1.0
friction = 0.2
detection = "hyp1"
"#;
    let row = run(machine(text));
    assert!(row.get("first_contact_s").is_some(), "there is contact");
    assert_eq!(word(&row, "rub_regime"), Some("backward-whirl"));
    assert_eq!(word(&row, "whirl_in_rub"), Some("backward"));
    assert!(row.value("backward_whirl_time_s") > 10.0);
}

/// A shaft of 30 sections on this number of bearings.
fn long_shaft(bearings: u32) -> Machine {
    let section = "[[rotor.shaft]]\nlength = \"0.1 m\"\ndiameter = \"50 mm\"\nelements = 1\n";
    let mut text = format!(
        "schema = 1\nname = \"long\"\n[rotor]\ninitial_speed = 1.0\n[rotor.material]\nyoung_modulus = 2.1e11\n\
         poisson_ratio = 0.3\ndensity = 7850.0\nshear_coefficient = 0.9\n{}[run]\nend_time = 0.001\n",
        section.repeat(30)
    );
    for k in 0..bearings {
        text.push_str(&format!(
            "[rotor.bearings.b{k}]\nposition = {}\nstiffness = 1e8\ndamping = 10.0\naxial_stiffness = 1e6\n",
            f64::from(k) / 10.0
        ));
    }
    machine(&text)
}

#[test]
fn a_shaft_of_many_sections_keeps_its_columns_within_a_message() {
    let machine = long_shaft(30);
    let columns = columns(&machine);
    assert!(columns.len() <= MAX_COLUMNS, "{}", columns.len());
    let named = |name: &str| columns.iter().any(|column| column.name == name);
    assert!(named("max_bending_stress_Pa") && named("max_bending_stress_section0_Pa"));
    assert!(!named("max_bending_stress_section12_Pa"), "the first twelve at most");
    let row = run(machine);
    assert_eq!(row.outcome.values.len(), columns.len());
}

/// A row has guarded columns for the whole machine, each bearing and each reported section.
#[test]
fn no_guarded_column_is_left_out() {
    let mut found = Vec::new();
    for bearings in [2, 12, 24, 30] {
        let columns = columns(&long_shaft(bearings));
        assert!(columns.len() <= MAX_COLUMNS, "{bearings}: {}", columns.len());
        let peaks = || columns.iter().filter(|column| column.part == Part::Peak || column.name == "contact_impulse_Ns");
        let is_section = |column: &Column| column.name.contains("_section");
        let is_bearing = |column: &Column| column.name.starts_with("max_bearing_load_b");
        let is_force = |column: &Column| column.name.contains("bearing_force_");
        let count = |of: &dyn Fn(&Column) -> bool| {
            let (with, all): (Vec<_>, Vec<_>) =
                peaks().filter(|column| of(column)).partition(|c| c.guarded().is_some());
            assert!(all.is_empty(), "{bearings}: {all:?}");
            [with.len(), with.len() + all.len()]
        };
        found.push([
            count(&|c| !is_section(c) && !is_bearing(c) && !is_force(c)),
            count(&is_bearing),
            count(&is_section),
            count(&is_force),
        ]);
    }
    // kept of all guarded columns: whole machine, bearings, sections, three forces of each bearing
    let expected = [2, 12, 24, 30].map(|bearings| [[14, 14], [bearings, bearings], [48, 48], [3 * bearings; 2]]);
    assert_eq!(found, expected);
}

/// The widest machine that the input allows: 25 bearings on pedestals, 12 diaphragms, 20 monitors and 12 sections with their own columns.
#[test]
fn the_row_of_the_widest_machine_fits_a_message() {
    let rig = study_machine("lab_rig");
    let (head, diaphragm) = rig.split_at(rig.find("[diaphragms.seal]").expect("a diaphragm"));
    let section = "[[rotor.shaft]]\nlength = \"50 mm\"\ndiameter = \"25 mm\"\nelements = 1\n\n";
    let mut text = head.replacen("[rotor.discs.left]", &format!("{}[rotor.discs.left]", section.repeat(12)), 1);
    let (bearings, diaphragms, monitors) = (23, 12, 20);
    for k in 0..bearings {
        let position = 0.05 + 0.9 * f64::from(k) / f64::from(bearings);
        text.push_str(&format!(
            "\n[rotor.bearings.bearing_{k}]\nposition = {position}\nstiffness = 1e6\n[rotor.bearings.bearing_{k}.pedestal]\n\
             mass = 5.0\nstiffness = 1e7\n"
        ));
    }
    (0..diaphragms).for_each(|k| {
        text.push_str(&format!("\n{}", diaphragm.replace("diaphragms.seal", &format!("diaphragms.seal_{k}"))))
    });
    (0..monitors).for_each(|k| text.push_str(&format!("\n[monitors.monitor_{k}]\nposition = 0.5\ngap = 1e-3\n")));
    let columns = columns(&machine(&text));
    println!("{} columns", columns.len());
    assert!((1600..=MAX_COLUMNS).contains(&columns.len()), "{}", columns.len());
    let named = |name: &str| columns.iter().any(|column| column.name == name);
    assert!(named("max_pedestal_force_y_bearing_22_N") && named("guarded_max_pedestal_force_y_bearing_22_N"));
    assert!(named("guarded_max_bending_stress_section11_Pa") && named("guarded_max_filtered_contact_force_seal_11_N"));
    assert!(named("guarded_max_displacement_monitor_19_m"));
}
