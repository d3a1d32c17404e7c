//! The exponential engine against independent computations: the cases of `outside.rs` and `jeffcott.rs` that depend on the engine. Rotors at rest at
//! t = 0 and rigid rings have their own tests.

use crate::common::{Every, drawn, machine, machine_with, run, run_seen, study_machine};
use bladeoff_core::rotor::RotorMatrices;
use bladeoff_model::machine::Engine;
use bladeoff_model::outcome::{Cause, EndCause, Status};
use serde_json::Value;

fn references() -> Value {
    serde_json::from_str(include_str!("../data/outside/references.json")).expect("the references are JSON")
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(|value| value.as_f64().expect("a number")).collect()
}

fn text(value: &Value) -> &str {
    value.as_str().expect("a text")
}

/// Lines of `[run]`.
fn stepping(step: f64) -> String {
    format!("engine = \"exponential\"\ncontact_step = {step:?}")
}

/// Position, angle and speed at the instants of a case, with one contact step.
fn states(case: &Value, step: f64) -> Vec<[f64; 4]> {
    let times = numbers(&case["times"]);
    let mut found = Vec::new();
    run_seen(
        machine(&text(&case["toml"]).replace("step = STEP", &stepping(step))),
        &mut Every(|frame| {
            if times.iter().any(|time| (frame.time - time).abs() < 0.25 * step) {
                found.push([frame.displacement[0], frame.displacement[1], frame.angle, frame.speed]);
            }
        }),
    );
    found
}

/// Gravity, cross-coupled bearing, residual, released and lost unbalances; the deceleration through resonance under gravity. Unbalances weigh as much
/// as the rotor, so their psi'' matters; its prediction from the previous steps is of order 2 in the step.
#[test]
fn point_masses_follow_an_independent_integration() {
    let mut seen = 0;
    for case in list(&references()["points"]) {
        seen += 1;
        let exact: Vec<Vec<f64>> = list(&case["state"]).iter().map(numbers).collect();
        let size = |k: usize| exact.iter().fold(0.0_f64, |max, state| max.max(state[k].abs()));
        let scales = [size(0).max(size(1)), size(0).max(size(1)), size(2), size(3)];
        // in contact, the speed of an instant is that before its impulse
        let compared = if text(&case["toml"]).contains("radial-spring") { 3 } else { 4 };
        let error = |step: f64| {
            let found = states(case, step);
            assert_eq!(found.len(), exact.len(), "every instant was met");
            let off = found
                .iter()
                .zip(&exact)
                .map(|(ours, exact)| (0..compared).map(|k| (ours[k] - exact[k]).abs() / scales[k]).fold(0.0, f64::max));
            off.fold(0.0, f64::max)
        };
        let errors = [0.005, 0.0025, 0.00125].map(error);
        println!("{}: {errors:?}, order {:.2}", case["name"], (errors[1] / errors[2]).log2());
        assert!(errors[2] < 1e-4 && errors[2] < 0.35 * errors[1], "{}: {errors:?}", case["name"]);
    }
    assert_eq!(seen, 4);
}

/// Static sag plus synchronous response to added and lost residual unbalances, in all modes, at every node.
#[test]
fn random_rotors_start_from_the_sag_and_response_computed_elsewhere() {
    for case in list(&references()["rotors"]) {
        let mut machine = drawn(text(&case["toml"]));
        // at t = 0, a free spin has the speed of the law
        machine.rotor.speed_law = None;
        (machine.run.engine, machine.run.step, machine.run.contact_step) = (Engine::Exponential, None, Some(1e-8));
        machine.run.rotor_modes = Some(200);
        let rotor = RotorMatrices::assemble(&machine.rotor);
        let mut start = Vec::new();
        run_seen(
            machine,
            &mut Every(|frame| {
                if frame.time == 0.0 {
                    start = frame.displacement.to_vec();
                }
            }),
        );
        let expected: Vec<Vec<f64>> = list(&case["start"]).iter().map(numbers).collect();
        let size = expected.iter().flatten().fold(0.0_f64, |max, x| max.max(x.abs()));
        let mut largest = 0.0_f64;
        for (node, place) in expected.iter().enumerate() {
            for (dof, reference) in [rotor.u(node), rotor.v(node)].into_iter().zip(place) {
                largest = largest.max((start[dof] - reference).abs() / size);
            }
        }
        println!("{}: start {largest:.1e}", case["name"]);
        assert!(largest < 1e-9, "{}: {largest:e}", case["name"]);
    }
}

#[test]
fn a_braked_rotor_stops_when_its_braking_says() {
    // J W' = -(c0 + c1 W): rest at J/c1 ln(1 + c1 W0/c0)
    let step = 5e-5;
    for constant in [0.5, 0.51, 0.53, 0.6, 1.0, 1.234, 2.0, 5.0, 7.3, 11.0] {
        let row = run(machine(&format!(
            "schema = 1\nname = \"braked\"\n[run]\nend_time = 100\n{}\n[rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 2\n\
             initial_speed = 10\n[rotor.bearings.s]\nstiffness = 1\n[braking]\nconstant = {constant:?}\nlinear = 0.1\n",
            stepping(step)
        )));
        assert_eq!(row.outcome.end_cause, EndCause::Stopped, "c0 {constant}");
        assert_eq!(row.outcome.status, Status::Ok, "c0 {constant}: {:?}", row.outcome.causes.words());
        let late = row.value("stop_time_s") - 20.0 * (1.0_f64 + 1.0 / constant).ln();
        println!("c0 {constant}: {late:.1e} s");
        // a run ends at the end of the contact step in which the rotor stops
        assert!((-0.5 * step..1.5 * step).contains(&late), "c0 {constant}: {late}");
        assert_eq!(row.value("end_speed_rad_s"), 0.0);
    }
}

/// An unbalance of ten, three and one times the inertia of the spin; reference times of rest by DOP853 at 1e-11. Where a step is too long for the
/// engine to follow, the energy guard reports it.
#[test]
fn an_unbalance_that_outweighs_the_spin_s_inertia_is_followed_by_small_steps_or_told() {
    for (inertia, rest) in [(0.001, 0.465902195), (0.003, 1.069910321), (0.01, 2.465855037)] {
        let late = |step: f64| {
            let row = run(machine(&format!(
                "schema = 1\nname = \"light\"\n[run]\nend_time = 50\n{}\n[rotor]\nkind = \"point-mass\"\nmass = 0\npolar_inertia = {inertia:?}\n\
                 initial_speed = 1.4\n[rotor.bearings.s]\nstiffness = 1\ndamping = 0.04\n[rotor.unbalances.u]\nmass = 1\nradius = 0.1\n\
                 present = \"before\"\n",
                stepping(step)
            )));
            assert_eq!(row.outcome.end_cause, EndCause::Stopped, "J {inertia}");
            let late = row.value("stop_time_s") - rest;
            println!("J {inertia}, step {step}: {late:.1e} s late, {:?}", row.outcome.causes.words());
            let told = row.outcome.causes.contains(Cause::EnergyBalance);
            assert!(told || late.abs() < 0.0021, "J {inertia}: {late} s late and not told");
            late
        };
        let (coarse, fine) = (late(1e-3), late(1e-4));
        // a run ends at the end of a contact step
        assert!(fine.abs() < 2e-4 && coarse.abs() < 1e-2, "J {inertia}: {coarse} {fine}");
    }
}

/// The orbit is the same circle from the first step on, except for the whirl frequencies, which are constant within a cell of the speed grid (error
/// relative to the reduced engine: 1.5e-7).
#[test]
fn a_residual_unbalance_starts_steady() {
    let text = study_machine("lab_rig").replace("phase = \"0 deg\"", "phase = \"35 deg\"\npresent = \"before\"");
    let (text, _) = text.split_once("\n[braking]").expect("braking");
    let whole = study_machine("lab_rig");
    let (_, stator) = whole.split_once("\n[diaphragms").expect("a diaphragm");
    let text = format!("{text}\n[diaphragms{stator}");
    let mut machine = machine_with(&text, &[("run.end_time", "0.02"), ("rotor.initial_speed", "250")]);
    machine.run.engine = Engine::Exponential;
    let places = RotorMatrices::assemble(&machine.rotor).plane_places(5);
    let mut radii: Vec<f64> = Vec::new();
    run_seen(
        machine,
        &mut Every(|frame| radii.push(frame.displacement[places[0]].hypot(frame.displacement[places[1]]))),
    );
    let (low, high) = radii.iter().fold((f64::MAX, 0.0_f64), |(l, h), r| (l.min(*r), h.max(*r)));
    println!("steady start: radius {low:.6e}, ripple {:.1e}", high / low - 1.0);
    assert!(low > 1e-5 && high / low - 1.0 < 3e-5);
}

/// Undamped, without brake, on an orbit far from steady, 200 s: energy and drift of the angular momentum.
#[test]
fn an_undamped_rotor_keeps_its_energy_and_angular_momentum() {
    let drift = |step: f64| {
        let text = format!(
            "schema = 1\nname = \"jeffcott\"\n[run]\nend_time = 200\n{}\n[rotor.bearings.spring]\nstiffness = 1\n\
             [rotor.unbalances.mass]\nmass = 1\nradius = 0.05\npresent = \"before\"\n[rotor]\nkind = \"point-mass\"\nmass = 0\n\
             polar_inertia = 1\ninitial_speed = 1.1\n[rotor.initial]\ndisplacement = [0.3, -0.1]\nvelocity = [0.05, 0.2]\nangle = 0.4\n",
            stepping(step)
        );
        let e = 0.05;
        let mut momenta: Vec<f64> = Vec::new();
        let row = run_seen(
            machine(&text),
            &mut Every(|frame| {
                let (sin, cos) = frame.angle.sin_cos();
                let (x, y) = (frame.displacement[0] + e * cos, frame.displacement[1] + e * sin);
                let (vx, vy) = (frame.velocity[0] - e * frame.speed * sin, frame.velocity[1] + e * frame.speed * cos);
                momenta.push(frame.speed + x * vy - y * vx);
            }),
        );
        let change = momenta.iter().map(|l| (l - momenta[0]).abs()).fold(0.0, f64::max) / momenta[0].abs();
        (row.value("energy_error"), change)
    };
    let (coarse, fine) = (drift(0.0025), drift(0.000625));
    assert!(coarse.0 < 5e-6 && fine.0 < 0.1 * coarse.0 && fine.1 < 0.1 * coarse.1, "{coarse:?} {fine:?}");
    println!(
        "drift over 200 s: energy {:.2e} {:.2e}, angular momentum {:.2e} {:.2e}",
        coarse.0, fine.0, coarse.1, fine.1
    );
}
