//! A history beside a run, as `simulate` and `replay` take it.

use super::error::CliError;
use super::run::at_least_one;
use crate::engine::{self, EngineError};
use crate::history::{Decimation, Format, Recorder, Settings, left_behind};
use crate::report::RunWatch;
use bladeoff_answers::report::{counted, duration};
use bladeoff_core::engine::{NoHistory, Observer, Plan};
use bladeoff_core::outcome::Outcome;
use bladeoff_core::structure::Structure;
use bladeoff_model::document::units::{format_quantity, parse_bare_or_quantity};
use bladeoff_model::machine::Machine;
use bladeoff_system::call;
use std::ffi::OsStr;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of a history.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "History")]
pub struct HistoryArgs {
    /// Write the run's history to FILE: .mcap (Foxglove, PlotJuggler), .csv or .parquet by its extension. A history that
    /// cannot be written is a warning, never a failed run
    #[arg(long = "history", value_name = "FILE")]
    history: Option<PathBuf>,

    /// Channels to record, separated by commas: names ("contact.gap"), groups ("contact"), patterns ("bearing.*.load") or
    /// "all" [default: all but single nodes and ring nodes]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', requires = "history")]
    channels: Vec<String>,

    /// Interval between recorded instants, in seconds or with a unit, rounded to whole steps [default: 0.1 ms, or a
    /// hundred-thousandth of run.end_time if that is longer]
    #[arg(long, value_name = "TIME", requires = "history", conflicts_with = "decimate")]
    every: Option<String>,

    /// Record every N-th step
    #[arg(long, value_name = "N", requires = "history", value_parser = at_least_one)]
    decimate: Option<u64>,
}

impl HistoryArgs {
    /// What is asked for; `None` without `--history`.
    ///
    /// # Errors
    /// An interval that is no time.
    pub fn settings(&self) -> Result<Option<Settings>, CliError> {
        let Some(path) = self.history.clone() else { return Ok(None) };
        let decimation = match (&self.every, self.decimate) {
            (Some(text), _) => Decimation::Every(self.interval(text)?),
            (None, Some(steps)) => Decimation::Steps(steps),
            (None, None) => Decimation::Default,
        };
        Ok(Some(Settings { path, channels: self.channels.clone(), decimation }))
    }

    fn interval(&self, text: &str) -> Result<f64, CliError> {
        let refused = |message| CliError::Argument {
            argument: format!("--every {text}"),
            message,
            allowed: Some("a time > 0 such as \"0.1 ms\", or a number of seconds".to_owned()),
        };
        let time = parse_bare_or_quantity(text, "s").map_err(|error| refused(error.to_string()))?;
        if time > 0.0 && time.is_finite() { Ok(time) } else { Err(refused("out of range".to_owned())) }
    }
}

/// A run whose progress is shown, if it is to be.
fn simulate(
    machine: &Machine,
    structure: &Structure,
    recorder: Option<&mut dyn Observer>,
    shown: bool,
) -> Result<Outcome, EngineError> {
    if !shown {
        return engine::simulate_watched(machine, structure, recorder.unwrap_or(&mut NoHistory));
    }
    let mut watch = RunWatch::new(machine, recorder);
    let outcome = engine::simulate_watched(machine, structure, &mut watch);
    watch.finish();
    outcome
}

/// A run, watched where a history is asked for, its progress `shown`; what to say about the history.
///
/// # Errors
/// The run cannot start, or the history asked for is wrong in itself.
pub fn watched(
    machine: &Machine,
    structure: &Structure,
    plan: &Plan,
    settings: Option<&Settings>,
    shown: bool,
) -> Result<(Outcome, Option<String>), CliError> {
    let Some(settings) = settings else { return Ok((simulate(machine, structure, None, shown)?, None)) };
    let mut recorder = Recorder::new(settings, machine, structure, plan)?;
    let outcome = simulate(machine, structure, Some(&mut recorder), shown)?;
    let started = Instant::now();
    let said = match recorder.finish(machine, &outcome) {
        Ok(written) => format!(
            "history {}: {} at {}, every {}{}",
            written.path.display(),
            counted(written.channels as u64, "channel"),
            counted(written.records, "instant"),
            format_quantity(written.every, "s"),
            slow(started),
        ),
        Err(error) => {
            let mut text = format!("warning: there is no history: {error}");
            let mut source = std::error::Error::source(&error);
            while let Some(cause) = source {
                text.push_str(&format!("\n  because: {cause}"));
                source = cause.source();
            }
            if let Some(left) = left_behind(&settings.path) {
                text.push_str(&match Format::of(&settings.path) {
                    Ok(Format::Mcap) => {
                        let recover = call::command([OsStr::new("recover"), call::path_word(&left).as_os_str()]);
                        format!("\n  what was written until then: {recover}")
                    }
                    _ => format!("\n  what was written until then is in {}", left.display()),
                });
            }
            text
        }
    };
    Ok((outcome, Some(said)))
}

/// How long the end of the file took, where that is worth a word.
fn slow(started: Instant) -> String {
    let took = started.elapsed();
    if took.as_secs() >= 1 { format!(" (written in {})", duration(took)) } else { String::new() }
}
