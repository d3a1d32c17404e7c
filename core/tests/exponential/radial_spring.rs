//! Radial springs on the exponential engine: an independent integration, bouncing rubs, and the reference engine.

use crate::common::{Every, Row, close, machine, run, run_seen, study_machine, vertex};
use bladeoff_model::outcome::Status;

/// A flexible rotor with a heavy disc and a free spin, in a spring at a quarter of its length.
fn rotor(engine: &str, step: Option<f64>, law: &str) -> String {
    let key = if engine == "exponential" { "contact_step" } else { "step" };
    let step = step.map_or(String::new(), |step| format!("{key} = {step:?}\n"));
    format!(
        "schema = 1\nname = \"sprung\"\n[run]\nend_time = 0.25\nengine = \"{engine}\"\n{step}\
         [rotor]\ninitial_speed = 250\n\
         [rotor.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7800\n\
         [[rotor.shaft]]\nlength = 1.0\ndiameter = 0.05\nelements = 4\n\
         [rotor.damping]\nstiffness_proportional = 2e-5\n\
         [rotor.discs.wheel]\nposition = 0.5\nmass = 20.0\ntransverse_inertia = 0.1\npolar_inertia = 0.2\n\
         [rotor.bearings.left]\nposition = 0.0\naxial_stiffness = 1e6\nstiffness = 1e7\ndamping = 2000\n\
         [rotor.bearings.right]\nposition = 1.0\nstiffness = 1e7\ndamping = 2000\n\
         [rotor.unbalances.blade]\nposition = 0.5\nmass = 0.1\nradius = 0.1\n\
         [braking]\nconstant = 20.0\nlinear = 0.05\nquadratic = 2e-4\n\
         [diaphragms.seal]\nkind = \"radial-spring\"\nstiffness = 2e6\n\
         [diaphragms.seal.contact]\nposition = 0.25\nrotor_radius = 0.04\ngap = 4e-4\nfriction = 0.15\nfriction_law = \"{law}\"\n"
    )
}

/// A run, and the largest contact force between its instants.
fn largest_force(text: &str) -> (Row, f64) {
    let mut forces = Vec::new();
    let row = run_seen(machine(text), &mut Every(|frame| forces.push(frame.contacts[0].normal_force)));
    let top = (1..forces.len() - 1).max_by(|a, b| forces[*a].total_cmp(&forces[*b])).expect("a run");
    assert!(forces[top] > 0.0, "contact happened");
    (row, vertex(forces[top - 1], forces[top], forces[top + 1]).1)
}

/// Force and end speed against an independent integration (Radau IIA of order 5, separate Timoshenko elements).
#[test]
fn a_spring_has_the_force_and_the_end_speed_of_an_independent_integration() {
    let [force, speed] = [629.282_513_8, 199.147_831_06];
    for (step, tolerances) in [(None, [1e-3, 1e-3]), (Some(2e-5), [1e-5, 1e-7]), (Some(1e-5), [1e-5, 1e-7])] {
        let (row, largest) = largest_force(&rotor("exponential", step, "slip"));
        assert_eq!(row.outcome.status, Status::Ok);
        let of_force = close("largest force", largest, force, tolerances[0]);
        let of_speed = close("end speed", row.value("end_speed_rad_s"), speed, tolerances[1]);
        println!("{} us: force {of_force:.1e}, end speed {of_speed:.1e}", 1e6 * row.value("step_s"));
        assert!(row.value("normal_work_J").abs() < 1e-3 * row.value("friction_energy_J"));
        assert!(row.value("energy_error") < 1e-7);
    }
}

/// Columns in which both engines agree within the errors of their steps.
const ROBUST: [&str; 8] = [
    "end_speed_rad_s",
    "first_contact_s",
    "max_bearing_load_N",
    "max_filtered_contact_force_N",
    "contact_impulse_Ns",
    "friction_energy_J",
    "max_eccentricity_m",
    "contact_time_s",
];

/// The rig on skew bearings, under gravity, in a spring with an offset.
fn rig(engine: &str, law: &str, stiffness: f64, end: f64) -> String {
    let text = study_machine("lab_rig");
    let (head, tail) = text.split_once("[diaphragms.seal]").expect("a diaphragm");
    let contact = tail.split_once("[diaphragms.seal.contact]").expect("a contact").1;
    format!(
        "{head}[diaphragms.seal]\nkind = \"radial-spring\"\nstiffness = {stiffness:?}\nangle = \"30 deg\"\n\
         [diaphragms.seal.contact]{contact}"
    )
    .replace("end_time = \"0.6 s\"", &format!("end_time = {end:?}\nengine = \"{engine}\""))
    .replace("detection = \"hyp2\"", &format!("friction_law = \"{law}\""))
    .replace("gravity = [0.0, 0.0]", "gravity = [2.0, -9.0]")
    .replace("stiffness = \"2e6 N/m\"", "stiffness = [[2e6, 3e5], [-2e5, 1.6e6]]")
    .replace("offset = [\"0 mm\", \"0 mm\"]", "offset = [\"0.05 mm\", \"-0.02 mm\"]")
}

/// A stiff spring is compared with the full model: the reduced engine has no residual flexibility of truncated modes at springs.
#[test]
fn rubs_on_springs_are_those_of_the_reference_engines() {
    for (law, stiffness, reference, tolerance) in
        [("slip", 1e6, "reduced", 5e-4), ("stick-slip", 1e6, "reduced", 5e-4), ("stick-slip", 1e8, "full", 5e-3)]
    {
        let of = |engine| run(machine(&rig(engine, law, stiffness, 0.25)));
        let [ours, reference] = ["exponential", reference].map(of);
        for row in [&ours, &reference] {
            assert!(row.value("impacts") >= 10.0 && row.value("contact_impulse_Ns") > 0.0, "contact happened");
            assert_eq!(row.outcome.status, Status::Ok, "{:?}", row.outcome.causes.words());
        }
        for name in ROBUST {
            // begin and end of a contact are resolved to one step
            let tolerance = if name == "contact_time_s" { 5e-3 } else { tolerance };
            let error = close(name, ours.value(name), reference.value(name), tolerance);
            println!("{law}, {stiffness:e} N/m, {name}: {error:.1e}");
        }
    }
}

/// Fourth order inside the spring, second order where a contact begins or ends. With three torsional modes: the higher ones of the default (16) are
/// resolved only with steps of 10 us and less.
#[test]
fn rubs_on_springs_converge_with_order_two() {
    let of = |step: f64| {
        let text = rig("exponential", "slip", 1e6, 0.2)
            .replace("engine", &format!("contact_step = {step:?}\ntorsional_modes = 3\nengine"));
        let row = run(machine(&text));
        assert!(row.value("contact_impulse_Ns") > 0.0, "contact happened");
        ROBUST.map(|name| row.value(name))
    };
    let steps = [6.25e-5, 4e-5, 2e-5, 1e-5, 1.25e-6];
    let rows = steps.map(of);
    let apart = |row: usize, column: usize| (rows[row][column] / rows[4][column] - 1.0).abs();
    for (row, step) in steps.iter().enumerate() {
        let [speed, load, impulse, friction, reach] = [0, 2, 4, 5, 6].map(|column| apart(row, column));
        println!("{step:e}: {load:.1e}, {impulse:.1e}, {friction:.1e}, {reach:.1e}, {speed:.1e}");
    }
    for column in [0, 4, 5, 6] {
        let [coarse, fine] = [apart(1, column), apart(2, column)];
        assert!(coarse < 5e-4 && fine > 1e-8, "{}: {coarse:e} {fine:e}", ROBUST[column]);
        assert!(coarse > 3.0 * fine, "{}: {coarse:e} {fine:e}", ROBUST[column]);
    }
}

/// The friction torque of a spring acts at one node of the shaft: without the higher torsional modes its largest moment was a thirteenth.
#[test]
fn the_torque_of_a_rub_on_a_spring_reaches_the_shaft() {
    let rig = study_machine("lab_rig");
    let (shaft, _) = rig.split_once("[diaphragms.seal]").expect("has a ring");
    let spring = "[diaphragms.s]\nkind = \"radial-spring\"\nstiffness = 1e6\n[diaphragms.s.contact]\nposition = 0.5\nrotor_radius = 0.05\ngap = 3e-4\nfriction = 0.15\n";
    let of_engine = |engine: &str| {
        let text = shaft.replace("end_time = \"0.6 s\"", &format!("end_time = 0.05\nengine = \"{engine}\""));
        let row = run(machine(&(text + spring)));
        assert!(row.value("contact_impulse_Ns") > 0.0, "contact happened");
        row.value("max_torsional_moment_Nm")
    };
    let full = of_engine("full");
    assert!(full > 0.5, "{full} N m");
    for engine in ["reduced", "exponential"] {
        let found = of_engine(engine);
        assert!((found - full).abs() < 0.02 * full, "{engine}: {found} N m, full {full} N m");
    }
}
