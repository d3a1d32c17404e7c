//! A machine file by the exponential engine, free or with contact: what it comes to at a step, a spacing of the grid and a number of cells.
//!
//! `cargo run --release -p bladeoff-core --example exponential -- free|rub|again studies/machines/lp_turbine.toml 8e-4 [SPACING CELLS]`. `again` computes it once
//! more, as a study does the samples after the first: the time of that is the last line. Its instructions: `valgrind --tool=callgrind`,
//! docs/theory/08-exponential-engine.md.
#![allow(clippy::print_stdout, reason = "its output")]

use bladeoff_core::engine::exponential::{FlightSettings, free_run, rubbing_run};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::MachineDef;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [kind, path, step, grid @ ..] = arguments.as_slice() else {
        return Err("free|rub|again MACHINE STEP [SPACING CELLS]".into());
    };
    let def = MachineDef::parse(path, &std::fs::read_to_string(path)?).map_err(|problems| problems.to_string())?;
    let machine = def.build().map_err(|problems| problems.to_string())?;
    let structure = Structure::build(&machine, None)?;
    let mut settings = FlightSettings::of_step(step.parse()?);
    if let [spacing, cells] = grid {
        settings = FlightSettings { spacing: Some(spacing.parse()?), cells: cells.parse()?, ..settings };
    }
    match kind.as_str() {
        "free" => println!("{:?}", free_run(&machine, &structure, settings, 0.9 * machine.rotor.initial_speed)?),
        _ => println!("{:?}", rubbing_run(&machine, &structure, settings, true)?),
    }
    if kind == "again" {
        let begun = std::time::Instant::now();
        rubbing_run(&machine, &structure, settings, true)?;
        println!("{:.2} ms", 1e3 * begun.elapsed().as_secs_f64());
    }
    Ok(())
}
