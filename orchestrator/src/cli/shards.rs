//! Output of `status` for a directory of shards.

use super::error::CliError;
use crate::run::Stage;
use crate::run::shards::{AttemptStatus, ShardsStatus, verify_chunks};
use crate::submit::scheduler_says;
use bladeoff_answers::summary::{counted, duration};
use bladeoff_system::call;
use bladeoff_text::document::visible;
use serde_json::{Value, json};
use std::ffi::OsStr;
use std::path::Path;

/// Largest number of attempts shown.
const SHOWN: usize = 40;

/// The last interim analysis of `[stop]` for which all samples are present.
pub(super) fn look_at_hand<'a>(seen: &ShardsStatus, stages: &'a [Stage]) -> Option<&'a Stage> {
    let there = seen.first_missing.map_or(seen.samples, |chunk| chunk * seen.chunk);
    stages.iter().rfind(|stage| stage.samples <= there)
}

/// Status as text. `ahead`: the last interim analysis of `[stop]` that a merge could make.
pub(super) fn as_text(directory: &Path, seen: &ShardsStatus, ahead: Option<&Stage>) -> String {
    let living = seen.attempts.iter().filter(|attempt| attempt.lives).count();
    let state = match (seen.is_merged, seen.there == seen.chunks, living) {
        (true, _, _) => "complete".to_owned(),
        (false, true, _) => "all chunks are there, not merged".to_owned(),
        (false, false, 0) => "no attempt is running: every attempt has ended or no longer reports".to_owned(),
        (false, false, _) => format!("running: {}", counted(living as u64, "attempt")),
    };
    let mut lines = Vec::new();
    let mut line = |name: &str, text: String| lines.push(format!("{name:<10} {}", visible(&text)));
    line("state", state);
    line("study", seen.study.clone());
    let share = 100.0 * seen.done as f64 / seen.samples.max(1) as f64;
    line("done", format!("{} of {} ({share:.1} %)", seen.done, counted(seen.samples, "sample")));
    line("chunks", format!("{} of {} of {} each", seen.there, seen.chunks, counted(seen.chunk, "sample")));
    if seen.there < seen.chunks {
        line("missing", seen.missing.clone());
    }
    if let Some(stage) = ahead {
        let merge = call::command([OsStr::new("merge"), call::path_word(directory).as_os_str()]);
        line("stop", format!("the interim analysis of {} can be made: {merge}", counted(stage.points, "point")));
    }
    for attempt in seen.attempts.iter().take(SHOWN) {
        line("attempt", of_attempt(attempt));
    }
    if seen.attempts.len() > SHOWN {
        line("attempt", format!("and {} more", seen.attempts.len() - SHOWN));
    }
    if !seen.is_merged {
        line("resume", seen.resume_command(directory));
    }
    lines.push(String::new());
    lines.join("\n")
}

fn of_attempt(attempt: &AttemptStatus) -> String {
    let word = |key: &str| attempt.report.get(key).and_then(Value::as_str);
    let number = |key: &str| attempt.report.get(key).and_then(Value::as_u64).unwrap_or(0);
    let state = match (word("state"), attempt.lives, attempt.silent) {
        (_, true, _) => "computes".to_owned(),
        (Some("running"), false, Some(silent)) => format!("not heard of for {}", duration(silent)),
        (said, _, _) => said.unwrap_or("unknown").to_owned(),
    };
    let job = word("job").map(|job| format!(", job {job}")).unwrap_or_default();
    let lost = match number("lost") {
        0 => String::new(),
        lost => format!(", {lost} had been published by others before"),
    };
    format!(
        "shard {} on {}{job}, since {}: {state}; {} published{lost}",
        word("shard").unwrap_or("unknown"),
        word("host").unwrap_or("an unknown host"),
        word("started").unwrap_or("unknown"),
        counted(number("published"), "chunk")
    )
}

/// Status as JSON.
pub(super) fn as_json(directory: &Path, seen: &ShardsStatus) -> Value {
    let living = seen.attempts.iter().any(|attempt| attempt.lives);
    let state = match (seen.is_merged, living) {
        (true, _) => "complete",
        (false, true) => "running",
        (false, false) => "ended",
    };
    let attempts = seen.attempts.iter().map(|attempt| {
        let mut said = attempt.report.clone();
        said.insert("lives".to_owned(), json!(attempt.lives));
        said.insert("silent_s".to_owned(), json!(attempt.silent.map(|silent| silent.as_secs_f64())));
        Value::Object(said)
    });
    json!({
        "schema": 1,
        "state": state,
        "study": seen.study,
        "program": seen.program,
        "total": seen.samples,
        "done": seen.done,
        "left": seen.samples - seen.done,
        "resume": if seen.is_merged { Value::Null } else { json!(seen.resume_command(directory)) },
        "shards": {
            "chunk": seen.chunk,
            "chunks": seen.chunks,
            "there": seen.there,
            "missing": seen.missing,
            "attempts": attempts.collect::<Vec<_>>(),
            "scheduler": scheduler_says(directory),
        },
    })
}

/// Result of `--verify` for the chunks: text, and whether a chunk is damaged.
pub(super) fn verified(directory: &Path) -> Result<Option<(String, bool)>, CliError> {
    Ok(verify_chunks(directory)?.map(|(whole, damaged)| {
        let mut text = format!("\n{} {} as written\n", counted(whole, "chunk"), bladeoff_answers::summary::are(whole));
        damaged.iter().for_each(|one| text.push_str(&format!("{}\n", visible(one))));
        (text, !damaged.is_empty())
    }))
}
