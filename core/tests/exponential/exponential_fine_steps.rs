//! Exponential engine with fine contact steps: a ring with 24 stiff blades, whose modes with 9 to 12 nodal diameters have almost the same frequency
//! (4.57 kHz).

use crate::common::{Row, machine_with, run};
use bladeoff_model::machine::{Engine, Machine};
use bladeoff_model::outcome::Status;

fn ring(step: f64, end_time: &str) -> Row {
    let text = include_str!("../data/ring_24_blades.toml");
    let mut machine: Machine = machine_with(text, &[("run.end_time", end_time)]);
    machine.run.engine = Engine::Exponential;
    machine.run.contact_step = Some(step);
    run(machine)
}

/// Without the damping of the truncated ring modes, friction energy is 35 % larger at 2 us and 53 % larger at 1 us.
#[test]
fn a_ring_with_stiff_blades_converges_with_the_contact_step() {
    let finest = ring(0.5e-6, "0.03 s");
    for step in [6.5e-6, 3e-6, 2e-6, 1e-6] {
        let coarser = ring(step, "0.03 s");
        assert!(coarser.value("impacts") > 0.0 && finest.value("impacts") > 0.0, "touches");
        for (name, within) in
            [("friction_energy_J", 4e-3), ("max_filtered_contact_force_N", 2e-3), ("contact_impulse_Ns", 4e-3)]
        {
            let (ours, reference) = (coarser.value(name), finest.value(name));
            assert!((ours / reference - 1.0).abs() < within, "{step}: {name}: {ours} {reference}");
        }
        // penetration of the whole ring, far below its guard
        for row in [&coarser, &finest] {
            let penetration = row.value("residual_penetration_m");
            assert!(penetration > 0.0 && penetration < 1e-5, "{step}: {penetration}");
            assert_eq!(row.outcome.status, Status::Ok);
        }
        let works = [&coarser, &finest].map(|row| row.value("normal_work_J"));
        assert!((works[0] - works[1]).abs() < 1e-4 * finest.value("friction_energy_J"), "{step}: {works:?}");
    }
}

/// The flutter of the reduced ring that starts after 0.1 s is not covered: the penetration of the whole ring makes the run invalid.
#[test]
fn a_ring_that_is_penetrated_between_its_candidates_is_invalid() {
    let row = ring(6.5e-6, "0.12 s");
    assert!(row.value("impacts") > 0.0, "touches");
    assert!(row.value("residual_penetration_m") > 2e-5, "{}", row.value("residual_penetration_m"));
    assert_eq!(row.outcome.status, Status::Invalid);
}
