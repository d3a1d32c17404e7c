//! `bladeoff gate`: whether probabilities are below their bounds, as an exit code.

use super::answer::{asked_of, remark_limits, remark_unwritten};
use super::error::CliError;
use super::exit::Exit;
use super::json::pretty;
use super::output::{print_json, remark, tell};
use super::place::default_directory;
use super::refusals::NotAsked;
use crate::questions::{decided, judge, only_gates};
use crate::run::shards::directory_status;
use bladeoff_answers::gate::{Decision, Verdict, junit, verdict};
use bladeoff_study::Samples;
use bladeoff_system::files::write_whole;
use bladeoff_system::shown;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Check probability limits; the exit code is the result
///
/// A gate is `P(CONDITION) < BOUND`. It passes if the upper limit of the probability, with failed and invalid runs
/// counted as harmful, is below the bound. It fails if the lower limit, with these runs counted as harmless, is at or
/// above the bound. Otherwise it is open; the message has the number of points that would decide, or reports that failed
/// runs prevent a decision. Limits are exact and one-sided, so the design has to be "monte-carlo". Every combination of
/// [[vary]] has to pass. A failed gate has precedence over an open one.
///
/// In an incomplete study the first 256, 512, 1024 ... points are judged. Each interim analysis uses a stricter level, so
/// that repeated analyses do not make it easier to pass.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff run studies/ci-night.toml --wall 20min || \\
    test $? -eq 5
  bladeoff gate runs/ci-night
  bladeoff gate runs/ci-night --junit gate.xml
  bladeoff gate runs/ci-night --json | jq .verdict
  bladeoff gate runs/ci-night \\
    --require \"P(max_bearing_load_N > 1.2 MN) < 1e-2\" \\
    --confidence 0.99

Exit codes: 0 every gate passed, 4 one failed, 5 none failed and one is open.")]
pub struct Args {
    /// Result directory of `bladeoff run` [default: the current one if it contains a study, otherwise the newest one
    /// below runs/]
    directory: Option<PathBuf>,

    /// A gate, instead of the [[gate]]s of the study; may be given several times
    #[arg(long, value_name = "GATE", conflicts_with = "study")]
    require: Vec<String>,

    /// Confidence of the gates of --require [default: 0.95]
    #[arg(long, value_name = "NUMBER", requires = "require", value_parser = part)]
    confidence: Option<f64>,

    /// Also write the decisions to this file as JUnit XML: a test case for each gate and combination. An existing file is
    /// replaced
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,

    /// Use the [[gate]]s of this study file instead of those of the directory
    #[arg(long, value_name = "FILE")]
    study: Option<PathBuf>,

    /// Print JSON: verdict, points judged and points of the study, and each decision with its numbers and its sentence
    #[arg(long)]
    json: bool,
}

fn part(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.parse().ok();
    number.filter(|number| *number > 0.0 && *number < 1.0).ok_or_else(|| "must be between 0 and 1".to_owned())
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let directory = args.directory.clone().map_or_else(default_directory, Ok)?;
    let (samples, file, asked) = asked_of(&directory, args.study.as_deref())?;
    let gates = if args.require.is_empty() {
        asked.gates
    } else {
        only_gates(&samples, &args.require, args.confidence).map_err(refused)?
    };
    if gates.is_empty() {
        let output = samples.study().function().and_then(|model| model.outputs.first());
        let condition =
            output.map_or("max_bearing_load_N > 1.2 MN".to_owned(), |output| format!("{} > 1", output.name));
        return Err(NotAsked::Gates { file, directory, example: format!("P({condition}) < 1e-2") }.into());
    }
    let (decisions, points, of) = judge(&directory, &samples, &gates)?;
    if points < of {
        remark_unwritten(&directory)?;
    }
    let too_many = remark_limits(&directory, &samples)?;
    if let Some(path) = &args.junit {
        write_whole(path, junit(&name(&directory, &samples), &decisions, too_many.as_deref()).as_bytes())?;
        remark(&format!("wrote {}", shown(path)));
    }
    if args.json {
        print_json(&as_json(&decisions, points, of))?;
    } else {
        tell(&decided(&decisions, points, of))?;
    }
    Ok(match verdict(&decisions) {
        Verdict::Passed => Exit::Ok,
        Verdict::Failed => Exit::Failures,
        Verdict::Open => Exit::Incomplete,
    })
}

fn as_json(decisions: &[Decision], points: u64, of: u64) -> String {
    let decision = |found: &Decision| {
        json!({
            "gate": found.gate,
            "group": found.group,
            "verdict": word(found.verdict),
            "n": found.n,
            "events": found.events.0,
            "events_if_bad_harmful": found.events.1,
            "bad": found.bad,
            "beyond": found.beyond,
            "low": found.limits.0,
            "high": found.limits.1,
            "level": found.level,
            "more": found.more,
            "sentence": found.sentence,
        })
    };
    let all: Vec<Value> = decisions.iter().map(decision).collect();
    pretty(&json!({
        "verdict": word(verdict(decisions)),
        "complete": points == of,
        "points": points,
        "of": of,
        "decisions": all,
    }))
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Passed => "passed",
        Verdict::Open => "open",
        Verdict::Failed => "failed",
    }
}

/// All errors in --require.
fn refused(wrong: Vec<(String, String)>) -> CliError {
    let lines: Vec<String> =
        wrong.into_iter().map(|(text, message)| format!("--require {text:?}: {message}")).collect();
    CliError::Gates(lines.join("\n"))
}

/// Name of the study: a study without `name` is named after its file, and the frozen copy has another file name.
pub(super) fn name(directory: &Path, samples: &Samples) -> String {
    let report = directory_status(directory).ok().flatten().and_then(|seen| seen.last_report);
    let name = report.as_ref().and_then(|report| report.get("study")).and_then(|name| name.as_str());
    name.unwrap_or(&samples.study().name).to_owned()
}
