//! `bladeoff answer`: answers of a study to its questions.

use super::error::CliError;
use super::exit::Exit;
use super::output::{print_json, remark, tell};
use super::place::default_directory;
use super::refusals::NotAsked;
use super::why::{frozen, resume_command};
use crate::html_report::{LimitTable, bearings_of, too_many_beyond};
use crate::questions::{
    Answering, Forecasts, Meant, Refinement, Source, Waiting, answer, forecasts, keep, meant, pace, told,
};
use crate::run::directory::{ANSWERS, CURVES, MANIFEST, RESULTS, STUDY, read_current};
use crate::run::shards::{directory_status, is_unmerged, row_files, unread};
use crate::run::{PrecisionCheck, RunState};
use bladeoff_answers::ask::{in_words, percent_given};
use bladeoff_answers::summary::counted;
use bladeoff_answers::tables::Table;
use bladeoff_study::{Asked, Samples, StudyError, read_asked};
use bladeoff_system::shown;
use bladeoff_text::document::Collector;
use std::path::{Path, PathBuf};

/// Largest number of lines about insufficient precision.
const MOST_SHORT: usize = 8;

/// Answer the questions of a study from its results
///
/// A study with a `[design]` has random points. Its `[[question]]`s ask for probabilities, quantiles, means, exceedance
/// and fragility curves, differences and sensitivities. Each answer is a sentence with the interval of the design.
/// Failed, invalid and quarantined runs are counted as harmless and as harmful, and the interval covers both. The values
/// of runs beyond the model count as lower bounds.
///
/// Answers of a complete study are also written to answers.json in the directory, and curves to answers/NAME.parquet;
/// `run` does the same at its end. Answers of an incomplete study are only printed. They use the first points, up to the
/// first missing one, because the points that finish first are not a random sample.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff answer
  bladeoff answer runs/blade-off-risk
  bladeoff answer runs/blade-off-risk --json \\
    | jq .answers[0].high
  bladeoff answer runs/blade-off-risk \\
    --study other-questions.toml")]
pub struct Args {
    /// Result directory of `bladeoff run` [default: the current one if it contains a study, otherwise the newest one
    /// below runs/]
    directory: Option<PathBuf>,

    /// Print the content of answers.json
    #[arg(long)]
    json: bool,

    /// Use the [[question]]s of this study file instead of those of the directory; then nothing is written
    #[arg(long, value_name = "FILE")]
    study: Option<PathBuf>,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let directory = args.directory.clone().map_or_else(default_directory, Ok)?;
    let (samples, file, asked) = asked_of(&directory, args.study.as_deref())?;
    if asked.questions.is_empty() {
        return Err(NotAsked::Questions { file }.into());
    }
    let answering = answer(&directory, &samples, &asked.questions)?;
    if !answering.is_known {
        let table = shown(directory.join(RESULTS));
        remark(&format!("warning: {table} cannot be verified: {MANIFEST} has no checksum of it"));
    }
    let (is_kept, exit) = match args.study {
        None => kept(&directory, &answering, false),
        Some(_) => (false, Exit::Ok),
    };
    if !answering.answers.complete {
        remark_unwritten(&directory)?;
    }
    remark_limits(&directory, &samples)?;
    if args.json {
        print_json(&answering.answers.json().map_err(|error| CliError::stdout(error.into()))?)?;
    } else {
        let ahead =
            forecast_of(&directory, &samples, &answering).map(|ahead| ahead_in_words(&ahead)).unwrap_or_default();
        let short = if args.study.is_none() { short_in_words(&samples, &answering) } else { String::new() };
        tell(&(told(&answering) + &short + &ahead + &files(&directory, &answering, is_kept)))?;
    }
    Ok(exit)
}

/// Prints how many finished samples are in the record of a directory and in none of its tables. A run in progress writes them with the next
/// part; for a killed run, the command that writes them is printed.
pub(super) fn remark_unwritten(directory: &Path) -> Result<(), CliError> {
    if is_unmerged(directory) {
        unread(directory).iter().for_each(|damaged| remark(&format!("warning: {damaged}")));
        return Ok(());
    }
    let Some(seen) = directory_status(directory)? else { return Ok(()) };
    let told = |key: &str| seen.last_report.as_ref()?.get(key)?.as_u64();
    let done = told("done").unwrap_or(0);
    let rows = read_current(directory, row_files, Table::count_rows)? as u64;
    if matches!(seen.state, RunState::Running { .. })
        && let Some(total) = told("total").filter(|_| done > rows)
    {
        remark(&format!(
            "note: {done} of {} are finished, and the tables have {rows} of their rows; the run writes the others \
             with its next part (run --refresh)",
            counted(total, "sample")
        ));
        return Ok(());
    }
    if !seen.is_counted {
        return Ok(());
    }
    if done > rows {
        let how = resume_command(&seen)
            .map(|command| format!("; this writes them and resumes: {command}"))
            .unwrap_or_default();
        let samples = counted(done - rows, "sample");
        remark(&format!(
            "warning: {samples} of {done} are in the record of {} but not yet in a table{how}",
            shown(directory)
        ));
    }
    Ok(())
}

/// Prints how many ok runs exceed noted limits, whether too many runs are beyond the model, and notes on bearings with inaccurate peak
/// loads. Returns the line about too many runs beyond the model.
pub(super) fn remark_limits(directory: &Path, samples: &Samples) -> Result<Option<String>, CliError> {
    let (noted, too_many) = read_current(directory, row_files, |files| {
        Ok((LimitTable::of(samples, files)?.noted(), too_many_beyond(samples, files)?))
    })?;
    too_many.iter().chain(&noted).for_each(|line| remark(&format!("warning: {line}")));
    bearings_of(samples).iter().for_each(|note| remark(&format!("note: {note}")));
    Ok(too_many)
}

/// Forecast of the intervals of these answers with more points; `None` if the pace is unknown or there is no interval.
pub(super) fn forecast_of(directory: &Path, samples: &Samples, answering: &Answering) -> Option<Forecasts> {
    // the final number of combinations of [refine] is unknown; a study that [stop] ended early is precise enough
    if samples.study().refine.is_some() {
        return None;
    }
    let pace = pace(&directory_status(directory).ok()??.last_report?).filter(|_| answering.of == answering.design)?;
    let awaited = waiting(samples).ok()?.map(|waiting| waiting.awaited());
    forecasts(answering, pace, samples.groups().len(), awaited.as_ref())
}

/// Figures of these answers that are less precise than `[stop]` requires; for an incomplete study, only those that more points cannot improve.
pub(super) fn short_of(samples: &Samples, answering: &Answering) -> Vec<String> {
    let waiting = waiting(samples).ok().flatten().filter(|_| answering.points > 0);
    let short = waiting.map(|waiting| waiting.short_of(&answering.answers.answers, !answering.answers.complete));
    let mut lines: Vec<String> =
        short.unwrap_or_default().into_iter().map(|(name, why)| format!("{name}: {why}")).collect();
    let more = lines.len().saturating_sub(MOST_SHORT);
    lines.truncate(MOST_SHORT);
    lines.extend((more > 0).then(|| format!("and {more} more")));
    lines
}

fn short_in_words(samples: &Samples, answering: &Answering) -> String {
    let lines: String = short_of(samples, answering).iter().map(|line| format!("  {line}\n")).collect();
    if lines.is_empty() { lines } else { format!("\nNot as precise as [stop] asks:\n{lines}") }
}

fn ahead_in_words(ahead: &Forecasts) -> String {
    let lines: String = ahead.lines().iter().map(|line| format!("  {line}\n")).collect();
    format!("\n{}:\n{lines}", ahead.head())
}

/// Forecast of the answers to the own questions of a directory.
pub(super) fn forecast_in(directory: &Path) -> Option<Forecasts> {
    let (samples, _, asked) = asked_of(directory, None).ok()?;
    let answering = answer(directory, &samples, &asked.questions).ok().filter(|_| !asked.questions.is_empty())?;
    forecast_of(directory, &samples, &answering)
}

/// The study of a directory, the questions of its study file or of another file, and the name of that file.
pub(super) fn asked_of(directory: &Path, other: Option<&Path>) -> Result<(Samples, PathBuf, Meant), CliError> {
    directory_status(directory)?.ok_or_else(|| CliError::NotARun { path: directory.to_path_buf() })?;
    let samples = frozen(directory)?;
    let read = other.map(read_asked).transpose()?;
    let (file, meant) = match &read {
        Some((file, text, asked)) => (PathBuf::from(file), understood(&samples, file, text, asked)?),
        None => {
            let study = samples.study();
            (directory.join(STUDY), understood(&samples, &study.file, &study.text, &study.asked)?)
        }
    };
    Ok((samples, file, meant))
}

/// Valid questions and gates of a file for these samples.
pub(in crate::cli) fn understood(samples: &Samples, file: &str, text: &str, asked: &Asked) -> Result<Meant, CliError> {
    if asked.is_empty() {
        return Ok(Meant::default());
    }
    let found = meant(samples, Source { file, text, asked });
    found.map_err(|problems| StudyError::Problems(vec![problems]).into())
}

/// Rejects questions and gates that these samples cannot answer.
pub(super) fn check_questions(samples: &Samples) -> Result<(), CliError> {
    let study = samples.study();
    understood(samples, &study.file, &study.text, &study.asked).map(|_| ())
}

/// Text of `check` on the questions and gates of a study.
pub(super) fn asked_in_words(samples: &Samples) -> Result<String, CliError> {
    let study = samples.study();
    let Meant { questions, gates } = understood(samples, &study.file, &study.text, &study.asked)?;
    let mut text = String::new();
    for (what, lines) in [
        ("Questions", questions.iter().map(in_words).collect::<Vec<_>>()),
        (
            "Gates",
            gates.iter().map(|gate| format!("{} (confidence {})", gate.text, percent_given(gate.confidence))).collect(),
        ),
    ] {
        if !lines.is_empty() {
            text.push_str(&format!(
                "\n{what}:\n{}",
                lines.iter().map(|line| format!("  {line}\n")).collect::<String>()
            ));
        }
    }
    if let Some(waiting) = waiting(samples)? {
        let lines = waiting.in_words().iter().map(|line| format!("  {line}\n")).collect::<String>();
        text.push_str(&format!("\nStop:\n{lines}"));
    }
    if let Some(refinement) = refinement(samples)? {
        let lines = refinement.in_words().iter().map(|line| format!("  {line}\n")).collect::<String>();
        text.push_str(&format!("\nRefine:\n{lines}"));
    } else if let Some(why) = Refinement::whole_part(samples) {
        text.push_str(&format!("\nRefine:\n  {why}\n"));
    }
    Ok(text)
}

/// Stopping rule of a study, if it has one.
pub(super) fn waiting(samples: &Samples) -> Result<Option<Waiting>, CliError> {
    let study = samples.study();
    Ok(Waiting::of(samples, &understood(samples, &study.file, &study.text, &study.asked)?))
}

/// Refinement of the map of a study, if it has one.
pub(super) fn refinement(samples: &Samples) -> Result<Option<Refinement>, CliError> {
    let study = samples.study();
    let meant = understood(samples, &study.file, &study.text, &study.asked)?;
    Refinement::of(samples, &meant).map_err(|unrefined| {
        let mut problems = Collector::new(&study.file, &study.text);
        unrefined.tell(samples, &mut problems);
        StudyError::Problems(vec![problems.into_problems()]).into()
    })
}

/// Largest number of samples that a study needs, by its `[stop]`; `None`: all samples.
pub(super) fn last_needed(samples: &Samples) -> Result<Option<u64>, CliError> {
    Ok(waiting(samples)?.and_then(|waiting| Some(waiting.stages().last()?.samples)))
}

/// Text at the end of `run` on the questions of its study; answers of a complete study are written into the directory. Also returns the exit
/// code, if nothing else determines it.
pub(super) fn answers_of_run(directory: &Path, samples: &Samples, trusts: bool) -> Result<(String, Exit), CliError> {
    let study = samples.study();
    let Meant { questions, .. } = understood(samples, &study.file, &study.text, &study.asked)?;
    if questions.is_empty() {
        return Ok((String::new(), Exit::Ok));
    }
    let answering = answer(directory, samples, &questions)?;
    let (is_kept, exit) = kept(directory, &answering, trusts);
    let short = short_in_words(samples, &answering);
    Ok((format!("\n{}{short}{}", told(&answering), files(directory, &answering, is_kept)), exit))
}

/// Writes the answers of a complete study, or prints the reason why not. Returns whether they are written, and the exit code if nothing
/// else determines it: reading a directory without write permission is no failure.
fn kept(directory: &Path, answering: &Answering, trusts: bool) -> (bool, Exit) {
    if !answering.answers.complete {
        return (false, Exit::Ok);
    }
    match keep(directory, answering, trusts) {
        Ok(()) => (true, Exit::Ok),
        Err(error) => {
            let source = std::error::Error::source(&error).map(|source| format!(": {source}")).unwrap_or_default();
            remark(&format!("the answers are not written: {error}{source}"));
            (false, if error.is_refusal() { Exit::Ok } else { Exit::Io })
        }
    }
}

/// Text with the paths of the written files.
fn files(directory: &Path, answering: &Answering, is_kept: bool) -> String {
    if !is_kept {
        return String::new();
    }
    let curves = if answering.curves.is_empty() {
        String::new()
    } else {
        let names: Vec<String> = answering.curves.iter().map(|(name, _)| format!("{CURVES}/{name}.parquet")).collect();
        format!("; curves: {}", names.join(", "))
    };
    format!("\nAnswers: {}{curves}\n", shown(directory.join(ANSWERS)))
}
