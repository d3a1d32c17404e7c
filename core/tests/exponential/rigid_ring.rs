//! Rigid rings on the exponential engine: the reference engines, convergence over the step, and two rings at once.

use crate::common::{Row, close, machine, machine_with, run, study_machine};
use bladeoff_model::outcome::{Cause, Status};

/// The lab rig with rigid rings of these names, positions and gaps, and a blade-off that rubs from the first hundredth of a second on.
fn rig(of_run: &str, contact: &str, rings: &[(&str, f64, f64)]) -> Row {
    let text = study_machine("lab_rig");
    let (shaft, _) = text.split_once("[diaphragms.seal]").expect("a diaphragm");
    let rings = rings.iter().map(|(name, position, gap)| {
        format!(
            "[diaphragms.{name}]\nkind = \"rigid\"\n[diaphragms.{name}.contact]\nposition = {position:?}\nrotor_radius = 0.05\n\
             gap = {gap:?}\n{contact}\n"
        )
    });
    let changed = shaft.replace("end_time = \"0.6 s\"", of_run).replace("mass = \"10 g\"", "mass = \"25 g\"");
    assert!(changed.contains("mass = \"25 g\""), "{changed}");
    let row = run(machine(&(changed + &rings.collect::<String>())));
    assert!(row.value("contact_impulse_Ns") > 1.0 && row.value("impacts") >= 1.0, "contact happened");
    assert_eq!(row.outcome.status, Status::Ok, "{:?}", row.outcome.causes.words());
    row
}

const MIDDLE: [(&str, f64, f64); 1] = [("seal", 0.5, 5e-4)];
const EXPONENTIAL: &str = "end_time = 0.1\nengine = \"exponential\"";
/// Columns with their tolerances. An impact on a rigid ring excites the highest mode of the shaft, so load peaks converge only when the step resolves
/// that mode.
const COLUMNS: [(&str, f64); 5] = [
    ("end_speed_rad_s", 5e-5),
    ("contact_impulse_Ns", 5e-4),
    ("friction_energy_J", 5e-4),
    ("max_bearing_load_N", 5e-3),
    ("max_filtered_contact_force_N", 5e-3),
];

/// The reference engines are of first order here, so their values are extrapolated from two steps.
#[test]
fn rubs_in_a_rigid_ring_are_those_of_the_reference_engines() {
    for (engine, contact) in [
        ("reduced", "friction = 0.15"),
        ("reduced", "friction = 0.3\nfriction_law = \"slip\""),
        ("reduced", "friction = 0.15\ndetection = \"hyp1\""),
        ("reduced", "friction = 0.15\ndetection = \"hyp2-frozen\""),
        ("full", "friction = 0.15"),
    ] {
        let ours = rig(EXPONENTIAL, contact, &MIDDLE);
        let steps = if engine == "full" { [7.8e-7, 3.9e-7] } else { [4e-6, 2e-6] };
        let [coarse, fine] =
            steps.map(|step| rig(&format!("end_time = 0.1\nengine = \"{engine}\"\nstep = {step:?}"), contact, &MIDDLE));
        for (column, tolerance) in COLUMNS {
            let extrapolated = 2.0 * fine.value(column) - coarse.value(column);
            let error = close(column, ours.value(column), extrapolated, tolerance);
            println!("{engine}, {contact}, {column}: {error:.1e}");
        }
        assert!(ours.value("energy_error") < 5e-6, "{}", ours.value("energy_error"));
        assert!(ours.value("normal_work_J").abs() < 1e-3 * ours.value("friction_energy_J"));
    }
}

#[test]
fn rubs_in_a_rigid_ring_converge() {
    let of = |step: f64| rig(&format!("{EXPONENTIAL}\ncontact_step = {step:?}"), "friction = 0.15", &MIDDLE);
    let (rows, fine) = ([6e-6, 3e-6, 1.5e-6].map(of), of(7.5e-7));
    for (column, tolerance) in COLUMNS {
        let errors = rows.each_ref().map(|row| (row.value(column) / fine.value(column) - 1.0).abs());
        println!("{column}: {errors:?}");
        assert!(errors.iter().all(|error| *error < tolerance), "{column}: {errors:?}");
    }
    let energy = rows.each_ref().map(|row| row.value("energy_error"));
    println!("energy errors {energy:?}, {:e}", fine.value("energy_error"));
    assert!(fine.value("energy_error") < 0.1 * energy[0], "{energy:?}");
}

/// Two rigid rings are coupled through the shaft alone. Their shares of an impact converge when the step resolves the shaft's highest mode, on both
/// engines.
#[test]
fn two_rigid_rings_touch_at_once() {
    let rings = [("a", 0.4, 4e-4), ("b", 0.6, 4.02e-4)];
    let [ours, reduced] = ["exponential\"\ncontact_step = 2.5e-6", "reduced\"\nstep = 1e-6"]
        .map(|engine| rig(&format!("end_time = 0.05\nengine = \"{engine}"), "friction = 0.1", &rings));
    for (column, tolerance) in
        [("contact_impulse_a_Ns", 1e-2), ("contact_impulse_b_Ns", 1e-2), ("contact_impulse_Ns", 2e-3)]
    {
        assert!(ours.value(column) > 0.1, "both touch: {column}");
        let error = close(column, ours.value(column), reduced.value(column), tolerance);
        println!("{column}: {error:.1e}");
    }
}

/// A rigid ring beside a flexible one, with impacts on both. With truncated rotor modes the impulse of the rigid ring is too large, and the run
/// invalid; with all modes it agrees with `full`.
#[test]
fn a_rigid_ring_beside_a_flexible_one_is_computed_with_all_modes_alone() {
    let text = study_machine("lab_rig").replace("mass = \"10 g\"", "mass = \"25 g\"");
    let rigid = "\n[diaphragms.far]\nkind = \"rigid\"\n[diaphragms.far.contact]\nposition = 0.4\nrotor_radius = 0.05\n\
                 gap = 2e-4\nfriction = 0.3\n";
    let row = |engine: &str, modes: &str| {
        let changes = [
            ("run.engine", engine),
            ("run.end_time", "0.05 s"),
            ("seal.contact.gap", "0.2 mm"),
            ("run.rotor_modes", modes),
            ("run.static_residual", "on"),
        ];
        let row = run(machine_with(&(text.clone() + rigid), &changes));
        for ring in ["far", "seal"] {
            assert!(row.value(&format!("contact_impulse_{ring}_Ns")) > 0.05, "{engine}: {ring} was hit");
        }
        row
    };
    let full = row("full", "24");
    assert_eq!(full.outcome.status, Status::Ok, "{:?}", full.outcome.causes.words());
    for engine in ["exponential", "reduced"] {
        let few = row(engine, "24");
        assert_eq!(few.outcome.cause, Some(Cause::ModalBasis), "{engine}: {:?}", few.outcome.causes.words());
        let all = row(engine, "80");
        assert!(!all.outcome.causes.contains(Cause::ModalBasis), "{engine}: {:?}", all.outcome.causes.words());
        // at any step, the impulses of `exponential` share an impact between the rings slightly differently
        let far = if engine == "reduced" { 0.01 } else { 0.1 };
        for (column, tolerance) in
            [("contact_impulse_far_Ns", far), ("contact_impulse_seal_Ns", 0.01), ("max_bearing_load_N", 0.02)]
        {
            let error = close(column, all.value(column), full.value(column), tolerance);
            println!("{engine}, {column}: {error:.1e}");
        }
    }
}
