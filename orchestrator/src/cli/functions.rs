//! Formula studies on the command line: output of `check`, and the summary at the end of `run`.

use super::error::CliError;
use super::extent::{extents, wall_told};
use super::output::tell;
use bladeoff_answers::summary::{FunctionSummary, counted, duration};
use bladeoff_study::FunctionModel;
use bladeoff_study::Samples;
use bladeoff_text::formula::Program;
use bladeoff_worker::process::thread_cpu_time;
use std::path::PathBuf;
use std::time::Duration;

/// Number of samples evaluated to measure their cost, evenly spread over the study.
const EVALUATED: u64 = 1000;
/// CPU time to assign, receive, record and write a sample \[s\], lower and upper end (docs/benchmarks.md).
const RECORDING: [f64; 2] = [10e-6, 40e-6];
/// Time for begin and end of a run \[s\].
const START: f64 = 0.5;

/// Number of formulas as text: "2 formulas".
pub(super) fn formulas(model: &FunctionModel) -> String {
    counted(model.outputs.len() as u64, "formula")
}

/// The formulas, one line each.
pub(super) fn described(model: &FunctionModel) -> String {
    let lines = model.outputs.iter().map(|output| format!("  {} = {}\n", output.name, output.text.trim()));
    format!("\nFormulas:\n{}", lines.collect::<String>())
}

/// Evaluates some samples and prints the predicted time of all samples with this number of workers.
///
/// # Errors
/// Standard output cannot be written.
pub(super) fn estimate(samples: &Samples, model: &FunctionModel, workers: usize) -> Result<(), CliError> {
    let count = samples.count();
    let some = count.min(EVALUATED);
    let begun = thread_cpu_time();
    let (mut params, mut stack, mut failed) = (Vec::new(), Vec::new(), vec![0u64; model.outputs.len()]);
    for k in 0..some {
        let sample = (u128::from(k) * u128::from(count) / u128::from(some)) as u64;
        params.clear();
        samples.params(sample, &mut params);
        let mut value = |program: &Program| program.value(|number| params[number], &mut stack);
        for (failed, output) in failed.iter_mut().zip(&model.outputs) {
            *failed += u64::from(!value(&output.program).is_finite());
        }
    }
    let each = thread_cpu_time().saturating_sub(begun).as_secs_f64() / some.max(1) as f64;
    let mut text = format!("\nevaluated {some} of {}: {:.1} us each\n", counted(count, "sample"), 1e6 * each);
    for (output, failed) in model.outputs.iter().zip(failed).filter(|(_, failed)| *failed > 0) {
        text.push_str(&format!("  {}: no finite number in {failed} of {some}: such rows fail\n", output.name));
    }
    for extent in extents(samples)? {
        let [low, high] = RECORDING.map(|one| {
            let seconds = START + extent.samples as f64 * (one + each / workers as f64);
            duration(Duration::from_secs_f64(seconds.min(1e12)))
        });
        let span = if low == high { low } else { format!("{low} to {high}") };
        text.push_str(&format!(
            "{}: about {span} with {}: most of it goes into the record of each sample\n",
            extent.name,
            counted(workers as u64, "worker")
        ));
    }
    text.push_str(&wall_told(samples));
    tell(&text)
}

/// Summary of the rows in these files.
///
/// # Errors
/// A table that cannot be read.
pub(super) fn summary(model: &FunctionModel, files: &[PathBuf], width: Option<usize>) -> Result<String, CliError> {
    let outputs = model.outputs.iter().map(|output| output.name.clone());
    Ok(FunctionSummary::of(files, outputs)?.text(width))
}
