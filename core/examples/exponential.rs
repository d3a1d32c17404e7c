//! A machine file by the exponential engine, free or with contact: what it comes to at a step, a spacing of the grid and a number of cells.
//!
//! `cargo run --release -p bladeoff-core --example exponential -- free|rub studies/machines/lp_turbine.toml 8e-4 [SPACING CELLS]`. Its
//! instructions: `valgrind --tool=callgrind`, docs/theory/08-exponential-engine.md.
#![allow(clippy::print_stdout, reason = "its output")]

use bladeoff_core::engine::exponential::{FlightSettings, free_run, rubbing_run};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::MachineDef;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [kind, path, step, grid @ ..] = arguments.as_slice() else {
        return Err("free|rub MACHINE STEP [SPACING CELLS]".into());
    };
    let def = MachineDef::parse(path, &std::fs::read_to_string(path)?).map_err(|problems| problems.to_string())?;
    let machine = def.build().map_err(|problems| problems.to_string())?;
    let structure = Structure::build(&machine, None)?;
    let mut settings = FlightSettings::of_step(step.parse()?);
    if let [spacing, cells] = grid {
        settings = FlightSettings { spacing: Some(spacing.parse()?), cells: cells.parse()?, ..settings };
    }
    match kind.as_str() {
        "rub" => println!("{:?}", rubbing_run(&machine, &structure, settings, true)?),
        _ => println!("{:?}", free_run(&machine, &structure, settings, 0.9 * machine.rotor.initial_speed)?),
    }
    Ok(())
}
