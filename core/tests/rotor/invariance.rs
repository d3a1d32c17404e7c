//! Frame invariance: the lab rig with anisotropic, cross-coupled bearings, gravity, offset and a disturbed start, rotated as a whole by an angle,
//! has the same scalar results.
#![expect(clippy::print_stdout, reason = "the measured errors are part of the result")]

use crate::common::{Row, machine_with, run, study_machine};
use bladeoff_core::engine::TimeStep;
use bladeoff_core::modal::DEFAULT_ROTOR_MODES;
use bladeoff_core::record::columns;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{DiaphragmKind, Machine};
use std::sync::OnceLock;

fn turn_vector([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (s, c) = angle.sin_cos();
    [c * x - s * y, s * x + c * y]
}

/// R A R^T.
fn turn_matrix(a: [[f64; 2]; 2], angle: f64) -> [[f64; 2]; 2] {
    let (s, c) = angle.sin_cos();
    let r = [[c, -s], [s, c]];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let mut sum = 0.0;
            for k in 0..2 {
                for l in 0..2 {
                    sum += r[i][k] * a[k][l] * r[j][l];
                }
            }
            sum
        })
    })
}

fn turned(machine: &Machine, angle: f64) -> Machine {
    let mut m = machine.clone();
    for bearing in &mut m.rotor.bearings {
        bearing.stiffness = turn_matrix(bearing.stiffness, angle);
        bearing.damping = turn_matrix(bearing.damping, angle);
    }
    m.rotor.unbalances.iter_mut().for_each(|u| u.phase += angle);
    m.rotor.gravity = turn_vector(m.rotor.gravity, angle);
    m.rotor.initial.displacement = turn_vector(m.rotor.initial.displacement, angle);
    m.rotor.initial.velocity = turn_vector(m.rotor.initial.velocity, angle);
    for diaphragm in &mut m.diaphragms {
        diaphragm.angle += angle;
        diaphragm.contact.offset = turn_vector(diaphragm.contact.offset, angle);
    }
    m
}

fn rig(engine: &str, detection: &str, law: &str, end: f64) -> Machine {
    let text = study_machine("lab_rig")
        .replace("gravity = [0.0, 0.0]", "gravity = [2.0, -9.0]")
        .replace("stiffness = \"2e6 N/m\"", "stiffness = [[2e6, 3e5], [-2e5, 1.6e6]]")
        .replace("damping = \"600 N s/m\"", "damping = [[600.0, 50.0], [20.0, 500.0]]")
        .replace("offset = [\"0 mm\", \"0 mm\"]", "offset = [\"0.05 mm\", \"-0.02 mm\"]");
    let text = text.replace(
        "[rotor.damping]",
        "[rotor.initial]\ndisplacement = [1e-5, -2e-5]\nvelocity = [0.01, 0.02]\n[rotor.damping]",
    );
    machine_with(
        &text,
        &[
            ("run.end_time", &format!("{end:e}")),
            ("run.engine", engine),
            ("contact.detection", detection),
            ("contact.friction_law", law),
        ],
    )
}

/// Largest relative difference over the columns (absolute for rounding-sized values), and where.
fn difference(a: &Row, b: &Row, names: &[&str]) -> (f64, String) {
    let mut worst = (0.0, String::new());
    for (k, column) in columns(&a.machine).iter().enumerate() {
        // solver work, and the time of a penetration of rounding size, depend on rounding
        let idle = column.name == "iterations" || column.name.starts_with("residual_penetration_at");
        // a component along an axis of the machine is not a scalar
        let component = column.name.contains("_force_x_") || column.name.contains("_force_y_");
        if idle || component || !(names.is_empty() || names.contains(&column.name.as_str())) {
            continue;
        }
        let (x, y) = match (a.outcome.values[k], b.outcome.values[k]) {
            (Some(x), Some(y)) => (x, y),
            (x, y) => {
                assert_eq!(x, y, "{}", column.name);
                continue;
            }
        };
        let error = (x - y).abs() / x.abs().max(y.abs()).max(floor(&column.name));
        if error > worst.0 {
            worst = (error, column.name.clone());
        }
    }
    worst
}

/// Value below which a column is rounding: penetration (of a 0.5 mm gap), works (of a 300 J spin), the balance error itself.
fn floor(name: &str) -> f64 {
    match name {
        "energy_error" => 1.0,
        "normal_work_J" | "model_work_J" => 100.0,
        name if name.starts_with("residual_penetration") => 5e-4,
        _ => f64::MIN_POSITIVE,
    }
}

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

/// Time of the first contact of the rig \[s\], by the reduced engine; computed once for all tests.
fn first_contact() -> f64 {
    static FIRST: OnceLock<f64> = OnceLock::new();
    *FIRST.get_or_init(|| run(rig("reduced", "hyp2", "stick-slip", 0.3)).value("first_contact_s"))
}

/// Runs a rig and copies rotated by `angles` \[rad\] until `after` \[s\] after the first contact; returns the largest relative difference of all
/// columns.
fn turned_difference(engine: &str, detection: &str, law: &str, after: f64, angles: &[f64]) -> f64 {
    let base = rig(engine, detection, law, first_contact() + after);
    let a = run(base.clone());
    assert!(a.value("contact_impulse_Ns") > 0.0 && a.value("impacts") >= 1.0, "contact happened");
    let mut largest = 0.0_f64;
    for &angle in angles {
        let b = run(turned(&base, angle));
        let (all, at) = difference(&a, &b, &[]);
        let (robust, robust_at) = difference(&a, &b, &ROBUST);
        println!(
            "{engine} {detection} {law}, {after} s after contact, turned by {angle}: {all:.1e} ({at}), robust {robust:.1e} ({robust_at})"
        );
        largest = largest.max(all);
    }
    largest
}

#[test]
fn turning_machine_and_frame_changes_no_scalar_until_20_ms_after_first_contact() {
    for (detection, law) in [("hyp1", "slip"), ("hyp2", "stick-slip"), ("hyp2-frozen", "slip")] {
        let all = turned_difference("reduced", detection, law, 0.02, &[0.7, 2.9]);
        assert!(all < 1e-8, "{all}");
    }
}

#[test]
fn turning_machine_and_frame_changes_no_scalar_of_the_exponential_engine() {
    for (detection, law) in
        [("hyp1", "slip"), ("hyp1", "stick-slip"), ("hyp2", "stick-slip"), ("hyp2-frozen", "stick-slip")]
    {
        let all = turned_difference("exponential", detection, law, 0.02, &[0.7, 2.9]);
        assert!(all < 1e-8, "{all}");
    }
}

#[test]
fn turning_machine_and_frame_changes_no_scalar_on_a_radial_spring() {
    for law in ["slip", "stick-slip"] {
        let mut base = rig("exponential", "hyp2", law, 0.2);
        base.diaphragms[0].kind = DiaphragmKind::RadialSpring { stiffness: 1e6 };
        for angle in [0.7, 2.9] {
            let (a, b) = (run(base.clone()), run(turned(&base, angle)));
            assert!(a.value("contact_impulse_Ns") > 0.0 && a.value("impacts") >= 10.0, "contact happened");
            let (all, at) = difference(&a, &b, &[]);
            println!("{law}, turned by {angle}: {all:.1e} ({at})");
            assert!(all < 1e-8, "{all} ({at})");
        }
    }
}

#[test]
fn turning_the_full_model_changes_no_scalar_until_5_ms_after_first_contact() {
    let all = turned_difference("full", "hyp2", "stick-slip", 5e-3, &[0.7]);
    assert!(all < 1e-8, "{all}");
}

#[test]
fn robust_outputs_stay_invariant_to_the_scatter_of_a_tiny_disturbance() {
    // 0.15 s of rub; scatter: initial displacement changed by 1e-12 of 1 mm
    let base = rig("reduced", "hyp2", "stick-slip", 0.3);
    let mut disturbed = base.clone();
    disturbed.rotor.initial.displacement[0] += 1e-15;
    let (a, b, c) = (run(base.clone()), run(turned(&base, 1.9)), run(disturbed));
    assert!(a.value("impacts") > 3.0, "contact happened");
    let (scatter, turned) = (difference(&a, &c, &ROBUST), difference(&a, &b, &ROBUST));
    println!("after {} impacts: scatter {scatter:?}, turned {turned:?}", a.value("impacts"));
    assert!(turned.0 < 100.0 * scatter.0 + 1e-9);
}

/// Anisotropic bearings, stiff enough to require more than the default modes, rotated in steps of a tenth of a right angle.
#[test]
fn as_many_modes_are_kept_however_bearings_are_turned() {
    let text = study_machine("lab_rig")
        .replacen("stiffness = \"2e6 N/m\"", "stiffness = [[1e9, 0.0], [0.0, 2e6]]", 1)
        .replace("damping = \"600 N s/m\"", "damping = [[600.0, 0.0], [0.0, 300.0]]");
    let mut machine = machine_with(&text, &[]);
    // ring modes above those of the shaft, so that the bearings determine the number of modes
    machine.run.ring_modes = Some(60);
    let kept = |angle: f64| {
        let machine = turned(&machine, angle);
        let structure = Structure::build(&machine, None).unwrap_or_else(|error| panic!("{error}"));
        (structure.lateral.coordinates.size(), structure.left_out_at_bearings())
    };
    // with few modes, the lag at the contact is the same for every direction of the axes
    let lag = |angle: f64| {
        let mut machine = turned(&machine, angle);
        machine.run.rotor_modes = Some(8);
        let structure = Structure::build(&machine, None).unwrap_or_else(|error| panic!("{error}"));
        structure.truncation_error_at_contact(&machine)
    };
    let share = lag(0.0);
    assert!(share > 0.03, "{share}");
    for angle in [0.3, std::f64::consts::FRAC_PI_4, 1.2] {
        assert!((lag(angle) / share - 1.0).abs() < 1e-6, "turned by {angle}: {} and not {share}", lag(angle));
    }
    let (modes, left_out) = kept(0.0);
    assert!(modes > DEFAULT_ROTOR_MODES, "{modes}: the stiff direction asks for more");
    for tenth in 1..=10 {
        let (other, share) = kept(std::f64::consts::FRAC_PI_2 * f64::from(tenth) / 10.0);
        assert_eq!(other, modes, "turned by {tenth} tenths of a right angle");
        for (a, b) in share.iter().zip(&left_out) {
            assert!((a - b).abs() < 1e-6, "{share:?} {left_out:?}");
        }
    }
}

/// A soft and a stiff axis: the default step follows from the soft one, for every orientation of the axes.
#[test]
fn the_default_step_does_not_depend_on_how_the_axes_lie() {
    let text = "schema = 1\nname = \"jeffcott\"\n[rotor]\nkind = \"point-mass\"\nmass = 1.0\npolar_inertia = 1.0\n\
        initial_speed = 1e-3\n[rotor.bearings.b]\nstiffness = [[4.0, 0.0], [0.0, 1.0]]\n[run]\nend_time = 100.0\n";
    let machine = crate::common::machine(text);
    let step = |angle: f64| {
        let machine = turned(&machine, angle);
        let structure = Structure::build(&machine, None).unwrap_or_else(|error| panic!("{error}"));
        TimeStep::new(&machine, &structure).unwrap_or_else(|error| panic!("{error}")).step
    };
    let steps: Vec<f64> = (0..=8).map(|k| step(0.2 * f64::from(k))).collect();
    assert!(steps.iter().all(|other| other.to_bits() == steps[0].to_bits()), "{steps:?}");
}
