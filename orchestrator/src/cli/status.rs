//! `bladeoff status`: progress of a study, during the run and afterwards.

use super::answer::{forecast_in, waiting};
use super::error::CliError;
use super::exit::Exit;
use super::output::{print_json, tell};
use super::place::default_directory;
use super::shards;
use super::why::frozen;
use crate::html_report::above_max_beyond;
use crate::questions::Forecasts;
use crate::run::shards::{samples_of, shards_status};
use crate::run::{DirectoryStatus, PrecisionCheck, RunState, TableEnd, Verified, directory_status, verify};
use crate::submit::scheduler_says;
use crate::terminal::Eta;
use bladeoff_answers::summary::{Align, TextTable, counted};
use bladeoff_model::outcome::Status;
use bladeoff_text::document::visible;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Long help.
const ABOUT: &str = "\
Show the progress of a study

Works while the study runs and afterwards, from any terminal, without disturbing it. Shows finished samples, pace, remaining \
time, failures by cause, the task of each worker, the state of the run, and the command that resumes it. The remaining time \
is a range. Once a tenth of the run is done, it contains the true time in about 95 of 100 cases, if the load of the computer \
does not change. The data of a running study are at most about a second old.

The state is one of:

  running    the process lives
  stopped    the process is suspended (SIGSTOP, Ctrl-Z)
  killed     the last run could not record its end;
             finished samples are kept
  ended      ended in order before it was complete:
             interrupted, terminated, wall, until,
             max_failures, failed
  complete   the table exists
  unknown    a run of another user whose lock cannot be
             read, or a lock that no run holds

Samples count when they are on disk.";

/// Show the progress of a study
#[derive(Debug, clap::Args)]
#[command(long_about = ABOUT, after_help = "Examples:
  bladeoff status
  bladeoff status runs/first-look
  bladeoff status runs/first-look --json
  bladeoff status runs/first-look --verify
  watch bladeoff status runs/gap-friction-map")]
pub struct Args {
    /// Result directory of `bladeoff run` [default: the current one if it contains a study, otherwise the newest one
    /// below runs/]
    directory: Option<PathBuf>,

    /// Print one JSON object: the content of status.json with the present state
    #[arg(long)]
    json: bool,

    /// Also compare every file with its checksum: tables and inputs by the BLAKE3 in manifest.json, answers by
    /// answers.b3sum, the record page by page. Exit code 6 if one is damaged. `bladeoff run` with the same study then
    /// writes all files again except the record, and computes samples that the record has lost
    #[arg(long)]
    verify: bool,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let directory = args.directory.clone().map_or_else(default_directory, Ok)?;
    let mut text = text(&directory, args.json)?;
    if !args.json
        && let Some(says) = scheduler_says(&directory)
    {
        text.push_str(&format!("{:<10} {}\n", "scheduler", visible(&says)));
    }
    let mut exit = Exit::Ok;
    if args.verify
        && let Some((words, is_damaged)) = shards::verified(&directory)?
    {
        text = if args.json { chunks_json(&text, &words) } else { text + &words };
        exit = if is_damaged { Exit::Io } else { exit };
    }
    if args.verify {
        let verified = verify(&directory)?;
        if verified.iter().any(|file| file.is_whole == Some(false)) {
            exit = Exit::Io;
        }
        text = if args.json { verified_json(&text, &verified) } else { text + &verified_text(&verified) };
    }
    if args.json { print_json(&text) } else { tell(&text) }?;
    Ok(exit)
}

/// Status of a directory, as text or JSON.
///
/// # Errors
/// The directory is not a result directory, or cannot be read.
pub fn text(directory: &Path, json: bool) -> Result<String, CliError> {
    let known = samples_of(directory)?;
    // the remaining time is that up to the next interim analysis
    let stop = known.as_ref().and_then(|samples| samples.study().stop);
    let has_looks = stop.is_some_and(|stop| stop.asks_for_width());
    if let Some(samples) = &known {
        let waiting = waiting(samples)?;
        let stages = waiting.as_ref().map_or(&[][..], |waiting| waiting.stages());
        if let Some(seen) = shards_status(directory, stages.last().map(|stage| stage.samples))? {
            let ahead = if seen.is_merged { None } else { shards::look_at_hand(&seen, stages) };
            return Ok(match json {
                true => pretty(&shards::as_json(directory, &seen)),
                false => shards::as_text(directory, &seen, ahead),
            });
        }
    }
    let seen = directory_status(directory)?.ok_or_else(|| CliError::NotARun { path: directory.to_path_buf() })?;
    // a complete study has its forecast with the answers
    let ahead = match seen.state {
        RunState::Running { .. } | RunState::Ended | RunState::Killed(_) => forecast_in(directory),
        RunState::Complete | RunState::Unknown { .. } => None,
    };
    let too_many = seen.last_report.as_ref().and_then(|report| too_many_beyond(directory, report));
    if json {
        return Ok(as_json(seen, ahead.as_ref(), too_many));
    }
    let end = end_told(&seen, directory);
    Ok(as_text(&seen, (end.as_deref(), has_looks), ahead.as_ref(), too_many))
}

fn verified_text(verified: &[Verified]) -> String {
    let mut table = TextTable::new(&[("file", Align::Left), ("verified", Align::Left)]);
    for file in verified {
        table.row(vec![file.name.clone(), visible(&file.words).into_owned()]);
    }
    format!("\n{}", table.render(""))
}

fn pretty(value: &Value) -> String {
    let mut text = serde_json::to_string_pretty(value).unwrap_or_default();
    text.push('\n');
    text
}

/// Status with the results for the chunks, as JSON.
fn chunks_json(status: &str, words: &str) -> String {
    let mut object: Map<String, Value> = serde_json::from_str(status).unwrap_or_default();
    object.insert("chunks".to_owned(), json!(words.trim().lines().collect::<Vec<_>>()));
    pretty(&Value::Object(object))
}

/// Status with the key `verified`: for each file whether it is undamaged (null: unknown), and the text.
fn verified_json(status: &str, verified: &[Verified]) -> String {
    let mut object: Map<String, Value> = serde_json::from_str(status).unwrap_or_default();
    let files = verified.iter().map(|file| {
        let said = json!({ "whole": file.is_whole, "says": file.words });
        (file.name.clone(), said)
    });
    object.insert("verified".to_owned(), Value::Object(files.collect()));
    let mut text = serde_json::to_string_pretty(&Value::Object(object)).unwrap_or_default();
    text.push('\n');
    text
}

/// Line if more of the finished samples are beyond the model than the study allows; also `None` if the study cannot be read.
fn too_many_beyond(directory: &Path, report: &Map<String, Value>) -> Option<String> {
    let beyond = report.get("by_status")?.get(Status::Beyond.word())?.as_u64().filter(|beyond| *beyond > 0)?;
    above_max_beyond(&frozen(directory).ok()?, beyond, report.get("done")?.as_u64()?)
}

fn as_json(seen: DirectoryStatus, ahead: Option<&Forecasts>, too_many: Option<String>) -> String {
    let mut object = seen.last_report.unwrap_or_default();
    if seen.state == RunState::Ended {
        // the reason recorded by the run: interrupted, terminated, wall, until, max_failures, failed
        let said = object.get("state").and_then(Value::as_str).map(str::to_owned);
        object.insert("ended".to_owned(), json!(said));
    }
    if let RunState::Unknown { why } = &seen.state {
        let said = object.get("state").and_then(Value::as_str).map(str::to_owned);
        object.insert("last_state".to_owned(), json!(said));
        object.insert("unknown".to_owned(), json!(why));
    }
    object.insert("state".to_owned(), json!(seen.state.word()));
    object.insert("forecast".to_owned(), json!(ahead.map(Forecasts::json)));
    object.insert("above_max_beyond".to_owned(), json!(too_many));
    let mut text = serde_json::to_string_pretty(&Value::Object(object)).unwrap_or_default();
    text.push('\n');
    text
}

fn as_text(
    seen: &DirectoryStatus,
    (end, has_looks): (Option<&str>, bool),
    ahead: Option<&Forecasts>,
    too_many: Option<String>,
) -> String {
    let empty = Map::new();
    let report = seen.last_report.as_ref().unwrap_or(&empty);
    let word = |key: &str| report.get(key).and_then(Value::as_str);
    let mut lines = vec![format!("{:<10} {}", "state", visible(&state(seen, end, word).replace('\n', " ")))];
    let mut line = |name: &str, text: String| lines.push(format!("{name:<10} {}", visible(&text)));
    if seen.last_report.is_none() {
        line("done", "unknown: the run has not reported yet".to_owned());
    } else {
        line("study", word("study").unwrap_or("unknown").to_owned());
        line("done", done(seen, report));
        line("outcome", outcome(report));
        if let Some(too_many) = too_many {
            line("warning", too_many);
        }
        if let RunState::Running { .. } = seen.state {
            line("pace", pace(report, has_looks));
        }
        let forecast = match seen.state {
            RunState::Running { .. } => Forecasts::lines_beside_the_time_left,
            _ => Forecasts::lines,
        };
        for text in ahead.map(forecast).unwrap_or_default() {
            line("forecast", text);
        }
        let deaths = number(report, "worker_deaths");
        if deaths > 0.0 {
            line("deaths", format!("{}, each replaced", counted(deaths as u64, "worker death")));
        }
        if let RunState::Running { .. } = seen.state {
            line("updated", word("updated").unwrap_or("unknown").to_owned());
            for worker in report.get("workers").and_then(Value::as_array).into_iter().flatten() {
                lines.push(visible(worker["doing"].as_str().unwrap_or("worker")).into_owned());
            }
        } else if let Some(command) =
            word("resume").filter(|_| !matches!(seen.state, RunState::Complete | RunState::Unknown { .. }))
        {
            line("resume", command.to_owned());
        }
    }
    lines.push(String::new());
    lines.join("\n")
}

fn state<'a>(seen: &DirectoryStatus, end: Option<&str>, word: impl Fn(&str) -> Option<&'a str>) -> String {
    let by =
        |holder: &Option<crate::run::Holder>| holder.as_ref().map(|holder| format!(": {holder}")).unwrap_or_default();
    let last = || word("updated").map(|time| format!("; last report at {time}")).unwrap_or_default();
    match &seen.state {
        RunState::Running { holder, stopped: false } => format!("running{}", by(holder)),
        RunState::Running { holder, stopped: true } => {
            format!("stopped{}; it continues after SIGCONT (`fg`, `kill -CONT`)", by(holder))
        }
        RunState::Killed(Some(holder)) => {
            format!("killed: {holder}, did not end in order; finished samples are kept{}", last())
        }
        RunState::Killed(None) => {
            format!("killed or failed: it could not record its end; finished samples are kept{}", last())
        }
        RunState::Complete => match end {
            Some(end) => format!("complete: {end}"),
            None => "complete".to_owned(),
        },
        RunState::Unknown { why } => {
            let last = match (word("updated"), word("state")) {
                (Some(time), Some(said)) => format!("its last message, at {time}: {said}"),
                _ => "it has reported nothing".to_owned(),
            };
            format!("unknown whether a run is alive: {why}; {last}")
        }
        RunState::Ended => match (word("state"), word("error")) {
            (Some("failed"), Some(error)) => format!("ended: failed: {error}"),
            (Some("wall"), _) => "ended: by --wall".to_owned(),
            (Some("until"), _) => "ended: by --until".to_owned(),
            (Some("max_failures"), _) => "ended: by --max-failures".to_owned(),
            (Some("complete") | None, _) => "ended".to_owned(),
            (Some(said), _) => format!("ended: {said}"),
        },
    }
}

/// End of the table by `[stop]`, as text.
fn end_told(seen: &DirectoryStatus, directory: &Path) -> Option<String> {
    let report = seen.last_report.as_ref()?;
    let end = TableEnd::of_json(report.get("stop")?)?;
    // a directory with an unreadable study is shown, too
    Some(match frozen(directory) {
        Ok(samples) => end.words(&samples),
        Err(_) => end.words_of(report.get("points").and_then(Value::as_u64).unwrap_or(0), None),
    })
}

fn done(seen: &DirectoryStatus, report: &Map<String, Value>) -> String {
    let (done, total, reused) = (number(report, "done"), number(report, "total"), number(report, "reused"));
    let share = if total > 0.0 { 100.0 * done / total } else { 100.0 };
    // the record may contain more samples than the last report
    let is_last = seen.state == RunState::Complete && report.get("state") == Some(&json!("complete"));
    let is_known = seen.is_counted || is_last || matches!(seen.state, RunState::Running { .. });
    let least = match &seen.state {
        _ if is_known => "",
        RunState::Unknown { .. } => "at least ",
        _ => "(the record cannot be read) at least ",
    };
    let surplus = number(report, "surplus");
    let earlier = match (reused > 0.0, surplus > 0.0) {
        (false, false) => String::new(),
        (true, false) => format!(", {reused} of them in earlier runs"),
        (_, true) => format!("; {surplus} more in the record, beyond the end of the table"),
    };
    format!("{least}{done} of {} ({share:.1} %){earlier}", counted(total as u64, "sample"))
}

fn outcome(report: &Map<String, Value>) -> String {
    let counts = |key: &str| -> Vec<String> {
        let pairs = report.get(key).and_then(Value::as_object).into_iter().flatten();
        pairs.filter(|(_, count)| count.as_u64() != Some(0)).map(|(word, count)| format!("{word} {count}")).collect()
    };
    let (by_status, by_cause) = (counts("by_status"), counts("by_cause"));
    match (by_status.is_empty(), by_cause.is_empty()) {
        (true, _) => "nothing yet".to_owned(),
        (false, true) => by_status.join(", "),
        (false, false) => format!("{}; causes: {}", by_status.join(", "), by_cause.join(", ")),
    }
}

fn pace(report: &Map<String, Value>, has_looks: bool) -> String {
    let rate = number(report, "rate_per_s");
    let time =
        |key: &str| report.get(key).and_then(Value::as_f64).and_then(|time| Duration::try_from_secs_f64(time).ok());
    let left = time("left_from_s").zip(time("left_to_s")).map(|(low, high)| Eta { low, high }.text());
    let to = if has_looks { " to the next interim analysis of [stop]" } else { "" };
    let left = left.map_or_else(|| "time left not known yet".to_owned(), |left| left + to);
    if rate >= 1.0 { format!("{rate:.1}/s, {left}") } else { format!("{:.1}/min, {left}", rate * 60.0) }
}

fn number(report: &Map<String, Value>, key: &str) -> f64 {
    report.get(key).and_then(Value::as_f64).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_of_a_study_with_stop_is_left_to_its_next_interim_analysis() {
        let report = json!({ "rate_per_s": 2.0, "left_from_s": 0.1, "left_to_s": 0.5 });
        let report = report.as_object().expect("an object");
        let plain = pace(report, false);
        assert!(plain.starts_with("2.0/s, ") && plain.ends_with(" left"), "{plain}");
        assert_eq!(pace(report, true), plain + " to the next interim analysis of [stop]");
        assert_eq!(pace(&Map::new(), true), "0.0/min, time left not known yet");
    }
}
