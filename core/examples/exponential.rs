//! Runs a machine file with changes and prints its row and cost, for any engine: the first run, and a later one, as in a study after the first two
//! samples.
//!
//! `cargo run --release -p bladeoff-core --example exponential -- MACHINE [PATH=VALUE ...] [COLUMN ...]`, for example `studies/machines/lp_turbine_paper.toml
//! run.engine=exponential "run.contact_step=50 us" energy_error`. Instructions: `valgrind --tool=callgrind`, docs/theory/08-exponential-engine.md.
#![allow(clippy::print_stdout, reason = "its output")]

use bladeoff_core::engine::simulate;
use bladeoff_core::record::{NoHistory, columns};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::MachineDef;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [path, rest @ ..] = arguments.as_slice() else { return Err("MACHINE [PATH=VALUE ...] [COLUMN ...]".into()) };
    let mut def = MachineDef::parse(path, &std::fs::read_to_string(path)?).map_err(|problems| problems.to_string())?;
    let mut wanted = Vec::new();
    for word in rest {
        match word.split_once('=') {
            Some((path, value)) => {
                let info = def.resolve(path)?;
                let value = def.parse_value(&info, value)?;
                def.set(&info, &value)?;
            }
            None => wanted.push(word.as_str()),
        }
    }
    let machine = def.build().map_err(|problems| problems.to_string())?;
    let structure = Structure::build(&machine, None)?;
    let run = || -> Result<_, Box<dyn std::error::Error>> {
        let begun = Instant::now();
        Ok((simulate(&machine, &structure, &mut NoHistory)?, begun.elapsed()))
    };
    let (outcome, first) = run()?;
    println!("status = {} {}", outcome.status.word(), outcome.causes.words().unwrap_or_default());
    for (column, value) in columns(&machine).iter().zip(&outcome.values) {
        if let Some(value) = value.filter(|_| wanted.is_empty() || wanted.contains(&column.name.as_str())) {
            println!("{} = {value}", column.name);
        }
    }
    // bases and cells that the second run computes are kept for the third
    run()?;
    println!("first = {:.1} ms, next = {:.1} ms", 1e3 * first.as_secs_f64(), 1e3 * run()?.1.as_secs_f64());
    Ok(())
}
