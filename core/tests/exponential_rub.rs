//! Contact of the exponential engine: against the reduced engine at a fine step, and against itself.

mod common;

use bladeoff_core::engine::exponential::{FlightSettings, rubbing_run};
use bladeoff_core::structure::Structure;
use common::{machine_with, run, study_machine};

#[test]
fn one_long_rub_of_the_turbine_is_that_of_the_reduced_engine() {
    let changes = [("run.end_time", "3.4 s")];
    let machine = machine_with(&study_machine("lp_turbine"), &changes);
    let structure = Structure::build(&machine, None).expect("buildable");
    for step in [1.25e-5, 2.5e-5, 5e-5] {
        let begun = std::time::Instant::now();
        let found = rubbing_run(&machine, &structure, FlightSettings::of_step(step), true);
        println!("{step} {found:?} {:?}", begun.elapsed());
    }
    let fine = run(machine_with(&study_machine("lp_turbine"), &[("run.end_time", "3.4 s"), ("run.step", "2.7e-5 s")]));
    for name in [
        "first_contact_s",
        "end_speed_rad_s",
        "max_bearing_load_front_N",
        "max_bearing_load_rear_N",
        "max_filtered_contact_force_N",
        "contact_impulse_Ns",
        "friction_energy_J",
        "max_eccentricity_m",
    ] {
        println!("{name} {}", fine.value(name));
    }
}
