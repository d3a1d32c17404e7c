//! History of a run, as an option of `simulate` and `replay`.

use super::error::CliError;
use super::output::remark;
use super::run::at_least_one;
use super::stop::{Stop, Stoppable, recovering, stopped, what_is_left};
use crate::engine::{self, EngineError};
use crate::history::{Decimation, Recorder, Settings};
use crate::terminal::RunWatch;
use bladeoff_answers::summary::{counted, duration};
use bladeoff_answers::tables::CsvStyle;
use bladeoff_core::engine::TimeStep;
use bladeoff_core::record::{Follower, NoHistory};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::Outcome;
use bladeoff_system::{causes, shown};
use bladeoff_text::document::units::{format_quantity, parse_bare_or_quantity};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of a history.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "History")]
pub struct HistoryArgs {
    /// Write the run's history to FILE: .mcap (Foxglove, PlotJuggler), .csv or .parquet by its extension. An existing
    /// file is replaced when the history is complete, with a message. A history that cannot be written is a warning and
    /// does not change the run
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

    /// Write a .csv history with `;` between cells and decimal commas, as `export --csv --decimal-comma` writes a table
    #[arg(long, requires = "history")]
    decimal_comma: bool,
}

impl HistoryArgs {
    /// Settings of the history of a run; `None` without `--history`.
    ///
    /// # Errors
    /// An invalid interval, or one longer than the run.
    pub fn settings(&self, machine: &Machine, time_step: &TimeStep) -> Result<Option<Settings>, CliError> {
        let Some(path) = self.history.clone() else { return Ok(None) };
        let decimation = match (&self.every, self.decimate) {
            (Some(text), _) => Decimation::Every(interval(text, machine.run.end_time)?),
            (None, Some(steps)) => Decimation::Steps(decimation(steps, machine.run.end_time, time_step.step)?),
            (None, None) => Decimation::Default,
        };
        let csv = if self.decimal_comma { CsvStyle::Comma } else { CsvStyle::Point };
        Ok(Some(Settings { path, channels: self.channels.clone(), decimation, csv }))
    }
}

/// Interval of `--every`, at most the length of the run.
fn interval(text: &str, end_time: f64) -> Result<f64, CliError> {
    let longest = format_quantity(end_time, "s");
    let refused = |message| CliError::Argument {
        argument: format!("--every {text}"),
        message,
        allowed: Some(format!(
            "a time > 0 such as \"0.1 ms\", or a number of seconds, up to the longest that the run may take: run.end_time = {longest}"
        )),
    };
    let time = parse_bare_or_quantity(text, "s").map_err(|error| refused(error.to_string()))?;
    // tolerance of 1 ppm, so that the printed limit is accepted
    if time > 0.0 && time <= end_time * (1.0 + 1e-6) { Ok(time) } else { Err(refused("out of range".to_owned())) }
}

/// Steps of `--decimate`, at most those of the run.
fn decimation(steps: u64, end_time: f64, step: f64) -> Result<u64, CliError> {
    let most = (end_time / step).ceil().max(1.0);
    if steps as f64 <= most {
        return Ok(steps);
    }
    Err(CliError::Argument {
        argument: format!("--decimate {steps}"),
        message: "out of range".to_owned(),
        allowed: Some(format!("1 to {most}, the steps that the run may take")),
    })
}

/// Simulates a run, with a progress display if `is_shown`.
fn simulate(
    machine: &Machine,
    structure: &Structure,
    recorder: Option<&mut dyn Follower>,
    is_shown: bool,
) -> Result<Outcome, EngineError> {
    if !is_shown {
        return engine::simulate_watched(machine, structure, recorder.unwrap_or(&mut NoHistory));
    }
    let mut watch = RunWatch::new(machine, recorder);
    let outcome = engine::simulate_watched(machine, structure, &mut watch);
    watch.finish();
    outcome
}

/// The machine with the step that resolves its impacts, and that step, both of which a history contains.
fn resolved(machine: &Machine, structure: &Structure, is_shown: bool) -> Result<(Machine, TimeStep), EngineError> {
    let mut machine = machine.clone();
    if !is_shown {
        let time_step = engine::resolve_step(&mut machine, structure, &mut NoHistory)?;
        return Ok((machine, time_step));
    }
    let mut watch = RunWatch::new(&machine, None);
    let time_step = engine::resolve_step(&mut machine, structure, &mut watch);
    watch.finish();
    Ok((machine, time_step?))
}

/// Simulates a run with its history, if requested, and a progress display if `is_shown`. Also returns the text on the history.
///
/// # Errors
/// The run cannot start or was stopped, or the settings of the history are invalid.
pub fn watched(
    machine: &Machine,
    structure: &Structure,
    settings: Option<&Settings>,
    is_shown: bool,
) -> Result<(Outcome, Option<String>), CliError> {
    let Some(settings) = settings else { return Ok((simulate(machine, structure, None, is_shown)?, None)) };
    settings.channels(machine, structure)?;
    let (machine, time_step) = &resolved(machine, structure, is_shown)?;
    let stop = Stop::listen();
    let mut recorder = Recorder::new(settings, machine, structure, time_step)?;
    let temporary = recorder.temporary().map(Path::to_path_buf);
    if let Some(temporary) = &temporary {
        stop.writes(temporary);
        if let Some(left) = recorder.in_its_way() {
            remark(&announced(&left, temporary));
        }
    }
    let mut watching = Stoppable { recorder: &mut recorder, stop: &stop.is_told };
    let outcome = simulate(machine, structure, Some(&mut watching), is_shown)?;
    if let Some(signal) = stop.signal() {
        // writes the buffered records to the file
        drop(recorder);
        return Err(CliError::Stopped { signal, words: stopped(signal, temporary.as_deref()) });
    }
    let started = Instant::now();
    let said = match recorder.finish(machine, &outcome) {
        Ok(written) => format!(
            "history {}: {} at {}, every {}{}{}",
            shown(&written.path),
            counted(written.channels as u64, "channel"),
            counted(written.records, "instant"),
            format_quantity(written.every, "s"),
            slow(started),
            if written.replaced { "; it replaced an existing file" } else { "" },
        ),
        Err(error) => {
            let mut text = format!("warning: there is no history: {error}");
            text.extend(causes(&error).map(|cause| format!("\n  because: {cause}")));
            text.extend(temporary.as_deref().and_then(what_is_left).map(|left| format!("\n  {left}")));
            text
        }
    };
    Ok((outcome, Some(said)))
}

/// Message that a history has another temporary name because the usual one is occupied.
fn announced(left: &Path, temporary: &Path) -> String {
    let recover = recovering(left).map(|command| format!(" (if a killed run has left it: {command})"));
    format!(
        "{} exists and is kept{} until this history is complete; the history is written to {}",
        shown(left),
        recover.unwrap_or_default(),
        shown(temporary)
    )
}

/// Text with the time to complete the file, if that is at least 1 s.
fn slow(started: Instant) -> String {
    let took = started.elapsed();
    if took.as_secs() >= 1 { format!(" (written in {})", duration(took)) } else { String::new() }
}
