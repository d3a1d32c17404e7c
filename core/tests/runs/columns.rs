//! The columns of a row: their order, and that each has the value that its name indicates.

use crate::common::{Every, machine, machine_with, run, run_seen, study_machine};
use bladeoff_core::record::{Frame, columns};
use bladeoff_core::stress::ShaftStresses;
use bladeoff_model::machine::{Machine, RotorKind};
use bladeoff_model::outcome::ColumnKind;
use std::collections::BTreeSet;

/// A mass point on one bearing, inside a given stator.
fn point(stator: &str) -> Machine {
    machine(&format!(
        "schema = 1\nname = \"point\"\n[rotor]\nkind = \"point-mass\"\nmass = 10.0\npolar_inertia = 0.1\n\
         initial_speed = 50.0\n[rotor.bearings.support]\nstiffness = 1e5\ndamping = 20.0\n\
         [rotor.unbalances.blade]\nmass = 0.3\nradius = 0.02\n[run]\nend_time = 0.5\nstep = 4e-5\n{stator}"
    ))
}

const SPRING: &str = "[diaphragms.stop]\nkind = \"radial-spring\"\nstiffness = 1e6\n[diaphragms.stop.contact]\n\
    rotor_radius = 0.05\ngap = 3e-4\nfriction = 0.6\n";

#[test]
fn every_machine_has_a_value_for_each_of_its_columns() {
    let short = [("run.end_time", "1 ms")];
    let machines = [
        machine_with(&study_machine("lab_rig"), &short),
        machine_with(&study_machine("lab_rig"), &[short[0], ("contact.detection", "hyp1")]),
        machine_with(&study_machine("lp_turbine_paper"), &short),
        point(""),
        point(SPRING),
    ];
    let mut sizes = BTreeSet::new();
    for machine in machines {
        let columns = columns(&machine);
        let names: BTreeSet<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names.len(), columns.len(), "no name stands twice");
        for column in &columns {
            let unit = column.unit.replace(' ', "").replace('/', "_");
            assert!(column.name.ends_with(&unit) && !column.meaning.is_empty(), "{column:?}");
            assert!(column.kind == ColumnKind::Real || column.unit.is_empty(), "{column:?}");
        }
        sizes.insert(columns.len());
        assert_eq!(run(machine).outcome.values.len(), columns.len());
    }
    assert!(sizes.len() > 2, "the machines have different tables: {sizes:?}");
}

/// Largest values over all steps of a run, collected by a follower.
#[derive(Default)]
struct Followed {
    loads: Vec<f64>,
    eccentricity: f64,
    force: f64,
    torsion: Vec<f64>,
    bending: Vec<f64>,
    friction: f64,
    frames: f64,
}

impl Followed {
    fn see(&mut self, frame: &Frame<'_>, shaft: Option<&ShaftStresses>) {
        let norm = |[x, y]: [f64; 2]| (x * x + y * y).sqrt();
        self.loads.resize(frame.bearing_loads.len(), 0.0);
        for (largest, load) in self.loads.iter_mut().zip(frame.bearing_loads) {
            *largest = largest.max(norm(*load));
        }
        for contact in frame.contacts {
            self.eccentricity = self.eccentricity.max(norm(contact.rotor));
            self.force = self.force.max(contact.normal_force);
        }
        let sections = shaft.map_or(0, ShaftStresses::sections);
        self.torsion.resize(sections, 0.0);
        self.bending.resize(sections, 0.0);
        for section in 0..sections {
            let largest = shaft.expect("sections").largest(section, frame.displacement, frame.torsion_angles);
            self.torsion[section] = self.torsion[section].max(largest.torsion);
            self.bending[section] = self.bending[section].max(largest.bending_square.sqrt());
        }
        self.friction = frame.energies.friction;
        self.frames += 1.0;
    }
}

#[test]
fn each_value_stands_under_the_name_of_what_it_is() {
    let rig = study_machine("lab_rig");
    for machine in [machine_with(&rig, &[("run.end_time", "0.2 s")]), point(""), point(SPRING)] {
        let shaft = match &machine.rotor.kind {
            RotorKind::Shaft(shaft) => Some(ShaftStresses::new(shaft)),
            RotorKind::PointMass(_) => None,
        };
        let rubs = !machine.diaphragms.is_empty();
        let mut found = Followed::default();
        let row = run_seen(machine, &mut Every(|frame| found.see(frame, shaft.as_ref())));
        let largest = found.loads.iter().copied().fold(0.0, f64::max);
        assert!(largest > 0.0);
        assert_eq!(row.get("max_bearing_load_N"), Some(largest));
        for (bearing, load) in row.machine.rotor.bearings.iter().zip(&found.loads) {
            assert_eq!(row.get(&format!("max_bearing_load_{}_N", bearing.name)), Some(*load), "{}", bearing.name);
        }
        assert_eq!(row.get("steps"), Some(found.frames));
        let rub = |value: f64| rubs.then_some(value);
        assert_eq!(rubs, found.force > 0.0, "it touches where there is something");
        assert_eq!(row.get("first_contact_s").is_some(), rubs);
        assert_eq!(row.get("max_contact_force_N"), rub(found.force));
        assert_eq!(row.get("max_eccentricity_m"), rub(found.eccentricity));
        assert_eq!(row.get("friction_energy_J"), rub(found.friction));
        assert!(!rubs || found.friction > 0.0);
        let Some(shaft) = &shaft else {
            assert_eq!(row.get("max_torsional_moment_Nm"), None);
            continue;
        };
        assert!(shaft.sections() > 1);
        for section in 0..shaft.sections() {
            let (of, moduli) =
                (|name: &str, unit: &str| format!("{name}_section{section}_{unit}"), shaft.moduli(section));
            let (torsion, bending) = (found.torsion[section], found.bending[section]);
            assert_eq!(row.get(&of("max_torsional_moment", "Nm")), Some(torsion));
            assert_eq!(row.get(&of("max_shear_stress", "Pa")), Some(torsion / moduli.torsion));
            assert_eq!(row.get(&of("max_bending_stress", "Pa")), Some(bending / moduli.bending));
        }
    }
}

/// A quantity of an event that did not occur is null; a quantity whose absence means zero is zero.
#[test]
fn a_run_without_contact_has_no_force_and_no_time_of_contact() {
    let row = run(machine_with(&study_machine("lab_rig"), &[("run.end_time", "0.02 s")]));
    for name in ["first_contact_s", "max_contact_force_N", "max_contact_force_at_s", "max_filtered_contact_force_N"] {
        assert_eq!(row.get(name), None, "{name}");
    }
    for name in ["max_ring_stress_angle_rad", "max_blade_stress_blade", "max_friction_power_W"] {
        assert_eq!(row.get(name), None, "{name}");
    }
    for name in ["whirl_in_rub", "residual_penetration_m", "model_work_J", "stop_time_s"] {
        assert_eq!(row.get(name), None, "{name}");
    }
    for name in ["contact_impulse_Ns", "contact_time_s", "impacts", "friction_energy_J", "max_blade_bending_stress_Pa"]
        .into_iter()
        .chain(["max_ring_stress_Pa", "max_blade_stress_Pa", "friction_energy_per_width_J_m"])
    {
        assert_eq!(row.get(name), Some(0.0), "{name}");
    }
    assert!(row.value("max_eccentricity_m") > 0.0);
}

/// Old and new tables have the same order of columns.
#[test]
fn the_order_of_the_columns_stays() {
    let peak =
        |name: &str, unit: &str| vec![format!("{name}_{unit}"), format!("{name}_at_s"), format!("{name}_at_rad_s")];
    let plain = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<String>>();
    let mut expected = plain(&["end_time_s", "end_speed_rad_s", "first_contact_s", "beyond_s"]);
    for name in ["max_bearing_load", "max_bearing_load_left", "max_bearing_load_right", "max_contact_force"] {
        expected.extend(peak(name, "N"));
    }
    expected.extend(peak("max_filtered_contact_force", "N"));
    expected.extend(plain(&["contact_impulse_Ns", "contact_time_s", "stick_time_s", "impacts"]));
    expected.extend(plain(&["rub_regime", "whirl_in_rub", "backward_whirl_time_s"]));
    expected.extend(peak("residual_penetration", "m"));
    expected.extend(peak("max_eccentricity", "m"));
    expected.extend(plain(&["friction_energy_J", "normal_work_J", "model_work_J", "energy_error"]));
    expected.extend(peak("max_friction_power", "W"));
    expected.push("friction_energy_per_width_J_m".to_owned());
    expected.extend(plain(&["no_fixed_point_steps", "several_points_steps", "several_minima_steps"]));
    expected.extend(plain(&["slip_reversal_steps", "steps", "step_s", "iterations", "stop_time_s"]));
    expected.extend(plain(&[
        "twin_bearing_load_change",
        "twin_filtered_contact_force_change",
        "twin_contact_impulse_change",
    ]));
    expected.extend(plain(&[
        "twin_friction_energy_change",
        "twin_eccentricity_change",
        "twin_torsional_moment_change",
    ]));
    expected.extend(plain(&["twin_status", "sensitive"]));
    expected.extend(plain(&["least_damping_ratio", "least_damping_at_rad_s"]));
    expected.extend(peak("max_blade_bending_stress", "Pa"));
    expected.extend(peak("max_ring_stress", "Pa"));
    expected.push("max_ring_stress_angle_rad".to_owned());
    expected.extend(peak("max_blade_stress", "Pa"));
    expected.push("max_blade_stress_blade".to_owned());
    for place in ["", "_section0", "_section1", "_section2"] {
        for (name, unit) in [("max_torsional_moment", "Nm"), ("max_shear_stress", "Pa"), ("max_bending_stress", "Pa")] {
            expected.extend(peak(&format!("{name}{place}"), unit));
        }
        expected.extend(peak(&format!("max_shaft_von_mises{place}"), "Pa"));
        if place.is_empty() {
            expected.push("max_shaft_von_mises_position_m".to_owned());
        }
    }
    for name in ["ring_displacement", "ring_yield", "blade_yield", "shaft_yield", "journal_clearance", "unstable_rotor"]
    {
        expected.push(format!("limit_ratio_{name}"));
    }
    expected.push("steps_per_impact".to_owned());
    let forces = ["left", "right"].iter().flat_map(|bearing| {
        ["bearing_force_x", "bearing_force_y", "upward_bearing_force"].map(|name| format!("max_{name}_{bearing}"))
    });
    let forces: Vec<String> = forces.collect();
    expected.extend(forces.iter().flat_map(|name| ["N", "at_s", "at_rad_s"].map(|unit| format!("{name}_{unit}"))));
    // after all others, in the same order
    let guarded = "first_contact_s beyond_s max_bearing_load_N max_bearing_load_left_N max_bearing_load_right_N \
        max_contact_force_N max_filtered_contact_force_N contact_impulse_Ns contact_time_s stick_time_s impacts \
        residual_penetration_m max_eccentricity_m friction_energy_J max_friction_power_W \
        friction_energy_per_width_J_m stop_time_s max_blade_bending_stress_Pa max_ring_stress_Pa max_blade_stress_Pa";
    expected.extend(guarded.split_whitespace().map(|name| format!("guarded_{name}")));
    for place in ["", "_section0", "_section1", "_section2"] {
        for (name, unit) in [("torsional_moment", "Nm"), ("shear_stress", "Pa"), ("bending_stress", "Pa")] {
            expected.push(format!("guarded_max_{name}{place}_{unit}"));
        }
        expected.push(format!("guarded_max_shaft_von_mises{place}_Pa"));
    }
    for name in ["ring_displacement", "ring_yield", "blade_yield", "shaft_yield", "journal_clearance", "unstable_rotor"]
    {
        expected.push(format!("guarded_limit_ratio_{name}"));
    }
    expected.extend(forces.iter().map(|name| format!("guarded_{name}_N")));
    let rig = machine_with(&study_machine("lab_rig"), &[]);
    let found: Vec<String> = columns(&rig).into_iter().map(|column| column.name).collect();
    assert_eq!(found, expected);
}

/// The columns of a machine can be listed without its matrices. A column that a run fills never has `lacks`.
#[test]
fn no_column_that_a_run_fills_lacks_a_part() {
    for name in ["lab_rig", "lp_turbine_paper"] {
        for engine in ["reduced", "exponential"] {
            let machine = machine_with(&study_machine(name), &[("run.end_time", "30 ms"), ("run.engine", engine)]);
            let row = run(machine);
            let mut filled = 0;
            for column in columns(&row.machine) {
                if row.get(&column.name).is_some() {
                    assert_eq!(column.lacks, None, "{name}, {engine}: {}", column.name);
                    filled += 1;
                }
            }
            assert!(filled > 60, "{filled} columns have values");
            for column in ["max_ring_stress_Pa", "max_blade_stress_Pa", "friction_energy_per_width_J_m"] {
                let has_blades = name == "lp_turbine_paper" || !column.contains("blade");
                let found = columns(&row.machine).into_iter().find(|found| found.name == column).expect("a column");
                assert!(found.lacks.is_none() || !has_blades, "{name}: {column} lacks {:?}", found.lacks);
            }
        }
    }
}
