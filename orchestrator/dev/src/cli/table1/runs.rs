//! The runs for the table: each detection, engine and start once, with the CPU time of the computing thread.

use crate::table1::Done;
use bladeoff::cli::{CliError, remark, set_parameter};
use bladeoff::engine;
use bladeoff_core::record::columns;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Detection, END_TIME, Engine, Machine, MachineDef};
use bladeoff_study::Samples;
use bladeoff_system::threads::in_parallel;
use bladeoff_worker::process::thread_cpu_time;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// One requested run.
pub(super) struct Case {
    pub machine: Machine,
    pub engine: &'static str,
    pub detection: &'static str,
    /// Number of the start; 0 is the start that the machine file defines.
    pub start: usize,
}

/// The requested runs of a study, fast ones first: with this engine or `all`, from the first `scatter` starts.
pub(super) fn cases(
    samples: &Samples,
    wanted: &str,
    scatter: u64,
    end_time: Option<&str>,
) -> Result<Vec<Case>, CliError> {
    let mut starts: Vec<Machine> = Vec::new();
    let mut cases = Vec::new();
    for sample in 0..samples.count() {
        let mut def: MachineDef = samples.machine(sample);
        if let Some(time) = end_time {
            set_parameter(&mut def, END_TIME, time, &format!("--end-time {time}"))?;
        }
        let machine = def.build()?;
        let Some(detection) = engine::detection(&machine) else { continue };
        let engine = machine.run.engine.word();
        // machines that differ in more than engine and detection have different starts
        set_parameter(&mut def, "run.engine", Engine::Reduced.word(), "run.engine")?;
        let mut bare = def.build()?;
        for diaphragm in &mut bare.diaphragms {
            diaphragm.contact.detection = Detection::Hyp1;
        }
        let start = starts.iter().position(|known| *known == bare).unwrap_or_else(|| {
            starts.push(bare);
            starts.len() - 1
        });
        if (wanted == "all" || wanted == engine) && (start as u64) < scatter {
            cases.push(Case { machine, engine, detection, start });
        }
    }
    cases.sort_by_key(|case| (case.engine == "full", case.start));
    Ok(cases)
}

/// Computes the runs, as many in parallel as there are cores.
pub(super) fn compute(cases: &[Case]) -> Result<Vec<Done>, CliError> {
    let mut structures: Vec<(&'static str, Structure)> = Vec::new();
    for case in cases {
        if !structures.iter().any(|(engine, structure)| *engine == case.engine && structure.fits(&case.machine)) {
            structures.push((case.engine, engine::build(&case.machine)?));
        }
    }
    let count = AtomicUsize::new(0);
    let started = Instant::now();
    let run = |case: &Case| -> Result<Done, CliError> {
        let structure = structures
            .iter()
            .find(|(engine, structure)| *engine == case.engine && structure.fits(&case.machine))
            .map(|(_, structure)| structure)
            .expect("one was built for each case above");
        let before = thread_cpu_time();
        let outcome = engine::simulate(&case.machine, structure)?;
        let cpu = (thread_cpu_time() - before).as_secs_f64();
        let done = count.fetch_add(1, Ordering::Relaxed) + 1;
        remark(&format!(
            "{done}/{} {} {}, start {}: {cpu:.1} s of CPU time, {:.0} s so far",
            cases.len(),
            case.engine,
            case.detection,
            case.start,
            started.elapsed().as_secs_f64()
        ));
        let names = columns(&case.machine).into_iter().map(|column| (column.name, column.kind)).collect();
        Ok(Done { engine: case.engine, detection: case.detection, start: case.start, cpu, names, outcome })
    };
    in_parallel(|| cases.par_iter().map(run).collect())?
}
