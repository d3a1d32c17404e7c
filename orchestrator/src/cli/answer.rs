//! `bladeoff answer`: what a study answers to its questions.

use super::error::CliError;
use super::exit::Exit;
use super::output::{print_json, remark, tell};
use super::place::default_directory;
use super::refusals::NotAsked;
use super::why::frozen;
use crate::answering::{Answering, Meant, Source, answer, keep, meant, told};
use crate::run::directory::{ANSWERS, CURVES, MANIFEST, RESULTS, STUDY};
use crate::run::see;
use bladeoff_answers::ask::{in_words, percent_given};
use bladeoff_study::{Asked, Samples, StudyError, read_asked};
use bladeoff_system::shown;
use std::path::{Path, PathBuf};

/// Answer the questions of a study from its results
///
/// A study with a `[design]` has random points; its `[[question]]`s ask for probabilities, quantiles, means, exceedance and fragility curves,
/// and differences of these. Each answer is a sentence with an interval that is proper to the design. Failed, invalid and quarantined
/// runs stay in: they are counted as harmless and as harmful, and the interval covers both.
///
/// Of a complete study the answers are also written to answers.json in the directory, and curves to answers/NAME.parquet; `run` does the
/// same at its end. While a study runs, and after one that is not complete, they are only printed: then the first points count, up to
/// the one before the first that is missing, because what finishes first is not random.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff answer
  bladeoff answer runs/blade-off-risk
  bladeoff answer runs/blade-off-risk --json | jq .answers[0].high
  bladeoff answer runs/blade-off-risk --study other-questions.toml")]
pub struct Args {
    /// Result directory of `bladeoff run` [default: the current one if a study was run there, otherwise the one below runs/
    /// that was written to last]
    directory: Option<PathBuf>,

    /// Print what answers.json holds
    #[arg(long)]
    json: bool,

    /// Take the [[question]]s of this study file instead of those of the directory; nothing is written then
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
    let is_kept = args.study.is_none() && kept(&directory, &answering, false);
    if args.json {
        print_json(&answering.answers.json().map_err(|error| CliError::stdout(error.into()))?)?;
    } else {
        tell(&(told(&answering) + &files(&directory, &answering, is_kept)))?;
    }
    Ok(Exit::Ok)
}

/// The study of a directory, and what its file or another one asks of it; the name of that file.
pub(super) fn asked_of(directory: &Path, other: Option<&Path>) -> Result<(Samples, PathBuf, Meant), CliError> {
    see(directory)?.ok_or_else(|| CliError::NotARun { path: directory.to_path_buf() })?;
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

fn understood(samples: &Samples, file: &str, text: &str, asked: &Asked) -> Result<Meant, CliError> {
    if asked.is_empty() {
        return Ok(Meant::default());
    }
    let found = meant(samples, Source { file, text, asked });
    found.map_err(|problems| StudyError::Problems(vec![problems]).into())
}

/// Refuses questions and gates that these samples cannot answer.
pub(super) fn check_questions(samples: &Samples) -> Result<(), CliError> {
    let study = samples.study();
    understood(samples, &study.file, &study.text, &study.asked).map(|_| ())
}

/// What `check` says of the questions and gates of a study.
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
    Ok(text)
}

/// What `run` says of the questions of its study at its end; those of a complete one are written into the directory.
pub(super) fn answers_of_run(directory: &Path, samples: &Samples, trusts: bool) -> Result<String, CliError> {
    let study = samples.study();
    let Meant { questions, .. } = understood(samples, &study.file, &study.text, &study.asked)?;
    if questions.is_empty() {
        return Ok(String::new());
    }
    let answering = answer(directory, samples, &questions)?;
    let is_kept = kept(directory, &answering, trusts);
    Ok(format!("\n{}{}", told(&answering), files(directory, &answering, is_kept)))
}

/// Writes the answers of a complete study; says why not.
fn kept(directory: &Path, answering: &Answering, trusts: bool) -> bool {
    if !answering.answers.complete {
        return false;
    }
    match keep(directory, answering, trusts) {
        Ok(()) => true,
        Err(error) => {
            let source = std::error::Error::source(&error).map(|source| format!(": {source}")).unwrap_or_default();
            remark(&format!("the answers are not written: {error}{source}"));
            false
        }
    }
}

/// Where they were written to.
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
