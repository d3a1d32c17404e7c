//! Lost masses against the mass and inertia at their nodes; the spin loses energy only to the brake.

use crate::common::{Every, machine, machine_with, run, run_seen, study_machine};
use bladeoff_core::engine::{TimeStep, simulate};
use bladeoff_core::record::NoHistory;
use bladeoff_core::rotor::RotorMatrices;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Layer, Presence, RotorKind, Unbalance, UnbalanceKind, overdrawn};
use bladeoff_model::outcome::Status;
use bladeoff_numerics::linalg::{Matrix, mul, mul_tn, spd_inverse};

const LOST: (&str, &str) = ("blade_off.kind", "lost");

/// The condensed mass and inertia that the check of a file uses (closed forms) agree with the dense matrices of a run.
#[test]
fn what_a_node_has_is_that_of_the_matrices() {
    for (name, shear, bore, taper) in [
        ("lp_turbine_paper", Some(0.9), 0.0, 1.0),
        ("lab_rig", Some(0.3), 0.4, 1.0),
        ("lab_rig", None, 0.5, 1.0),
        ("lab_rig", Some(0.9), 0.3, 1.6),
    ] {
        for (last, turns) in [(0, 0), (4, 4), (6, 6), (0, 4), (6, 3)] {
            let mut rotor = machine(&study_machine(name)).rotor;
            let RotorKind::Shaft(shaft) = &mut rotor.kind else { unreachable!("a shaft") };
            for element in &mut shaft.elements {
                (element.shear_coefficient, element.inner_diameter) = (shear, bore * element.diameter);
                (element.end_diameter, element.end_inner_diameter) = (taper * element.diameter, element.inner_diameter);
            }
            if taper != 1.0 {
                let elements = shaft.elements[3..5].to_vec();
                shaft.layers.push(Layer { name: String::new(), first: 3, elements });
            }
            let unbalance = |kind, (node, torsional_node), mass, radius, phase| Unbalance {
                name: String::new(),
                node,
                torsional_node,
                mass,
                radius,
                phase,
                kind,
                presence: Presence::AtRelease,
                release: None,
            };
            rotor.unbalances = vec![
                unbalance(UnbalanceKind::Lost, (4, 4), 5e-3, 20e-3, 2.5),
                unbalance(UnbalanceKind::Lost, (0, 2), 4e-3, 10e-3, 0.7),
                unbalance(UnbalanceKind::Added, (4, 4), 20e-3, 30e-3, 1.0),
                unbalance(UnbalanceKind::Lost, (last, turns), 1e4, 0.1, -1.0),
            ];
            let found = overdrawn(&rotor).expect("more than is there");
            let matrices = RotorMatrices::assemble(&rotor);
            let lateral = matrices.mass.nrows();
            let mut all = Matrix::zeros(lateral + matrices.nodes, lateral + matrices.nodes);
            all.view_mut((0, 0), (lateral, lateral)).copy_from(&matrices.mass);
            all.view_mut((lateral, lateral), (matrices.nodes, matrices.nodes)).copy_from(&matrices.torsional_mass);
            let motion = |site: &Unbalance| {
                let mut b = Matrix::zeros(2, all.ncols());
                (b[(0, matrices.u(site.node))], b[(1, matrices.v(site.node))]) = (1.0, 1.0);
                b[(0, lateral + site.torsional_node)] = -site.radius * site.phase.sin();
                b[(1, lateral + site.torsional_node)] = site.radius * site.phase.cos();
                b
            };
            let (others, drawn) = (&rotor.unbalances[..3], &rotor.unbalances[3]);
            let taken: Vec<Matrix> =
                others.iter().map(|site| mul_tn(&motion(site), &motion(site)) * site.signed_mass()).collect();
            let b = motion(drawn);
            taken.iter().for_each(|part| all += part);
            let mobility = spd_inverse(&all).expect("what is left before is definite");
            let seen = mul(&mul(&b, &mobility), &b.transpose());
            let share = drawn.mass * seen.symmetric_eigenvalues().max();
            let [mass, inertia] = [matrices.u(last), lateral + turns].map(|at| 1.0 / mobility[(at, at)]);
            println!(
                "{name} nodes {last}, {turns}: mass {mass:.4e} kg, inertia {inertia:.4e} kg m2, share {share:.4e}"
            );
            assert_eq!(found.unbalance, 3);
            for (ours, dense) in [(found.mass, mass), (found.polar_inertia, inertia), (found.share, share)] {
                assert!((ours / dense - 1.0).abs() < 1e-11, "{name} {last} {turns}: {ours:e} {dense:e}");
            }
        }
    }
}

/// Up to the limit of the lost share, in both engines at their default steps, the run is sound and the brake takes energy in every step.
#[test]
fn a_brake_never_drives_a_rotor_that_lost_a_mass() {
    let rig = study_machine("lab_rig");
    for (radius, position, speed) in
        [("40 mm", "0.6 m", "3000 rpm"), ("350 mm", "0.6 m", "300 rpm"), ("39 mm", "0.5 m", "3000 rpm")]
    {
        for engine in ["reduced", "full"] {
            let changes = [
                LOST,
                ("blade_off.radius", radius),
                ("blade_off.position", position),
                ("rotor.initial_speed", speed),
                ("contact.rotor_radius", "40 mm"),
                ("contact.gap", "10 mm"),
                ("run.end_time", "20 ms"),
                ("run.engine", engine),
            ];
            let (mut taken, mut steps, mut least) = (f64::NEG_INFINITY, 0, f64::INFINITY);
            let row = run_seen(
                machine_with(&rig, &changes),
                &mut Every(|frame| {
                    least = least.min(frame.energies.braking - taken.min(f64::MAX));
                    taken = frame.energies.braking;
                    steps += 1;
                }),
            );
            println!(
                "{radius} at {position}, {engine}: step {:e}, energy error {:.1e}, braking {taken:.3e} J",
                row.value("step_s"),
                row.value("energy_error")
            );
            assert_eq!(row.outcome.status, Status::Ok, "{:?}", row.outcome);
            assert!(steps > 1000 && taken > 0.0 && least >= 0.0, "{least}");
            assert!(row.value("end_speed_rad_s") < row.machine.rotor.initial_speed);
        }
    }
}

/// Step limit of a shaft with a node that lost most of its inertia: the node oscillates faster than any torsional mode of the shaft, and
/// the limit includes it with its coupling to deflection. With the limit of the shaft alone, the run grew without bound.
#[test]
fn the_step_limit_is_that_of_what_is_left() {
    let rig = study_machine("lab_rig");
    let free = rig.split("[diaphragms").next().expect("a first part");
    let changes = [
        LOST,
        ("blade_off.radius", "43.4 mm"),
        ("blade_off.position", "0.5 m"),
        ("run.engine", "full"),
        ("run.end_time", "5 ms"),
    ];
    let lost = machine_with(free, &changes);
    let structure = Structure::build(&lost, None).expect("buildable");
    let plan = TimeStep::new(&lost, &structure).expect("it can start");
    let whole = structure.torsion.highest.max(structure.lateral.highest);
    println!("highest frequency {:.4e}, of the shaft {whole:.4e} rad/s", plan.highest_frequency);
    assert!(plan.highest_frequency > 1.05 * whole);
    let with_step = |step: f64| machine_with(free, &[&changes[..], &[("run.step", &format!("{step:e}"))]].concat());
    let row = run(with_step(0.99 * plan.largest_step));
    assert!(row.outcome.status == Status::Ok && row.value("energy_error") < 1e-9, "{:?}", row.outcome);
    let refused = simulate(&with_step(1.01 * plan.largest_step), &structure, &mut NoHistory).expect_err("too large");
    assert!(refused.to_string().contains("too large"), "{refused}");
}
