//! Writes the scripts, runs the commands of the scheduler, and reads its job status. Every call has a time limit.

use super::{Command, Job, Scheduler, Script, depends, filled};
use crate::run::shards::SCHEDULER;
use bladeoff_system::files::{FileError, write_whole};
use bladeoff_system::folder::Folder;
use bladeoff_system::place::Place;
use bladeoff_system::shown;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::{self, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// File with the jobs of the last submission.
const JOBS: &str = "jobs.json";
/// Largest script, or list of jobs, that is read \[bytes\].
const MOST: u64 = 1 << 20;
/// Time limit for a submission.
const HANDING_IN: Duration = Duration::from_secs(120);
/// Time limit for a status query, which is for display only.
const ASKING: Duration = Duration::from_secs(5);
/// Beginning of the last line of a script that the user has not edited.
const MARK: &str = "# As written by bladeoff, blake3 of the lines above: ";

/// Reason why the jobs, or some of them, were not submitted.
#[derive(Debug, thiserror::Error)]
pub enum SubmitError {
    /// A file operation that failed.
    #[error(transparent)]
    File(#[from] FileError),
    /// A scheduler program that does not exist or cannot be started.
    #[error(
        "cannot start {}: is {scheduler} installed? The scripts are written: --dry-run prints the commands that submit them",
        shown(program)
    )]
    Start {
        /// Path of the program.
        program: PathBuf,
        /// Scheduler of the program.
        scheduler: Scheduler,
        /// Error of the operating system.
        #[source]
        source: io::Error,
    },
    /// A command of the scheduler that failed.
    #[error("{command}: {how}")]
    Refused {
        /// The command as shell text.
        command: String,
        /// Exit code and last output.
        how: String,
    },
}

/// Result of a submission.
#[derive(Debug, Clone, PartialEq)]
pub struct Handed {
    /// Job ids, in the order of the commands.
    pub jobs: Vec<String>,
    /// Exit code of the last command, if the command itself is the scheduler (GNU parallel).
    pub code: Option<i32>,
}

/// Writes the scripts. Scripts that the user has edited are kept; returns their names.
///
/// # Errors
/// The directory cannot be written.
pub fn write_scripts(job: &Job, scheduler: Scheduler) -> Result<Vec<&'static str>, SubmitError> {
    let folder = folder_of(&job.directory)?;
    let mut kept = Vec::new();
    for Script { name, text } in job.scripts(scheduler) {
        let place = folder.place(name);
        let text = marked(&text);
        let found = place.read(MOST).ok();
        if found.as_deref() == Some(text.as_bytes()) {
            continue;
        }
        if found.is_some_and(|found| is_edited(&found)) {
            kept.push(name);
            continue;
        }
        write_whole(&place, text.as_bytes())?;
    }
    Ok(kept)
}

fn folder_of(directory: &Path) -> Result<Folder, FileError> {
    let all = Folder::open(directory).map_err(FileError::at("open", directory))?;
    let place = all.place(SCHEDULER);
    match place.create_folder() {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
            return Err(FileError::at("create", &place)(error));
        }
        _ => {}
    }
    all.folder(SCHEDULER).map_err(FileError::at("use", &place))
}

fn marked(text: &str) -> String {
    format!("{text}{MARK}{}\n", blake3::hash(text.as_bytes()).to_hex())
}

/// Whether a script differs from what was written.
fn is_edited(found: &[u8]) -> bool {
    let Ok(found) = std::str::from_utf8(found) else { return true };
    found.rfind(MARK).is_none_or(|at| marked(&found[..at]) != found)
}

/// Runs the commands that submit a job, and stores the job ids that they print.
///
/// # Errors
/// A command cannot be started or fails; jobs submitted before it stay submitted.
pub fn hand_in(job: &Job, scheduler: Scheduler) -> Result<Handed, SubmitError> {
    let mut handed = Handed { jobs: Vec::new(), code: None };
    for command in job.commands(scheduler) {
        let words = words_of(&command, &handed.jobs);
        if scheduler == Scheduler::Parallel {
            handed.code = Some(in_front(scheduler, &words)?);
            continue;
        }
        let printed = asked(scheduler, &words, HANDING_IN)?;
        // a federation prints "123;cluster"
        let number = printed.trim().split(';').next().unwrap_or_default().to_owned();
        handed.jobs.push(number);
        remember(job, scheduler, &handed.jobs)?;
    }
    Ok(handed)
}

/// Words of a command, with the ids of the jobs submitted before.
fn words_of(command: &Command, jobs: &[String]) -> Vec<String> {
    command.0.iter().map(|word| if depends(word) { filled(word, jobs) } else { word.clone() }).collect()
}

fn remember(job: &Job, scheduler: Scheduler, jobs: &[String]) -> Result<(), FileError> {
    let said = json!({ "scheduler": scheduler.name(), "jobs": jobs, "shards": job.shards, "todo": job.todo });
    write_whole(folder_of(&job.directory)?.place(JOBS), said.to_string().as_bytes())
}

/// Runs a command in the foreground; returns its exit code.
fn in_front(scheduler: Scheduler, words: &[String]) -> Result<i32, SubmitError> {
    let (program, arguments) = words.split_first().expect("a command has a word");
    let status = process::Command::new(program).args(arguments).status();
    let status = status.map_err(|source| SubmitError::Start { program: program.into(), scheduler, source })?;
    status.code().ok_or_else(|| SubmitError::Refused { command: text_of(words), how: status.to_string() })
}

fn text_of(words: &[String]) -> String {
    Command(words.to_vec()).text(&[], |word| word.to_owned())
}

/// Runs a command and returns its output; a timeout is a failure.
fn asked(scheduler: Scheduler, words: &[String], most: Duration) -> Result<String, SubmitError> {
    let (program, arguments) = words.split_first().expect("a command has a word");
    let failed = |source| SubmitError::Start { program: program.into(), scheduler, source };
    let mut command = process::Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(failed)?;
    let reader = |mut pipe: Box<dyn Read + Send>| {
        thread::spawn(move || {
            let mut text = Vec::new();
            let _ = (&mut pipe).take(MOST).read_to_end(&mut text);
            String::from_utf8_lossy(&text).into_owned()
        })
    };
    let out = child.stdout.take().map(|pipe| reader(Box::new(pipe)));
    let err = child.stderr.take().map(|pipe| reader(Box::new(pipe)));
    let begun = Instant::now();
    let status = loop {
        match child.try_wait().map_err(failed)? {
            Some(status) => break Some(status),
            None if begun.elapsed() >= most => break None,
            None => thread::sleep(Duration::from_millis(20)),
        }
    };
    let refused = |how: String| SubmitError::Refused { command: text_of(words), how };
    let Some(status) = status else {
        let _ = child.kill();
        let _ = child.wait();
        return Err(refused(format!("no answer within {} s", most.as_secs())));
    };
    let said = |of: Option<thread::JoinHandle<String>>| of.and_then(|thread| thread.join().ok()).unwrap_or_default();
    let (out, err) = (said(out), said(err));
    if status.success() { Ok(out) } else { Err(refused(format!("{status}: {}", err.trim()))) }
}

/// Status of the last submitted jobs according to the scheduler, as text; `None` without jobs, or if the scheduler has no such query.
#[must_use]
pub fn scheduler_says(directory: &Path) -> Option<String> {
    let bytes = Place::from(&directory.join(SCHEDULER).join(JOBS)).read(MOST).ok()?;
    let jobs: Value = serde_json::from_slice(&bytes).ok()?;
    let scheduler: Scheduler = jobs["scheduler"].as_str()?.parse().ok()?;
    if scheduler != Scheduler::Slurm {
        return None;
    }
    let numbers: Vec<&str> = jobs["jobs"].as_array()?.iter().filter_map(Value::as_str).collect();
    let list = numbers.join(",");
    let words = ["squeue", "--noheader", "--array", "--states=all", "--format=%T", "--jobs", &list].map(str::to_owned);
    let of = format!("slurm, {} {list}", if numbers.len() == 1 { "job" } else { "jobs" });
    Some(match asked(scheduler, &words, ASKING) {
        Ok(text) => {
            let mut counts: BTreeMap<&str, u64> = BTreeMap::new();
            text.lines()
                .map(str::trim)
                .filter(|line| !line.is_empty())
                .for_each(|state| *counts.entry(state).or_default() += 1);
            let counts: Vec<String> =
                counts.iter().map(|(state, count)| format!("{count} {}", state.to_lowercase())).collect();
            format!("{of}: {}", if counts.is_empty() { "not known any more".to_owned() } else { counts.join(", ") })
        }
        Err(error) => format!("{of}: unknown ({error})"),
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::job;
    use super::*;
    use std::fs;

    #[test]
    fn a_script_that_was_edited_is_kept_and_one_that_was_not_follows_the_options() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let here = |job: Job| Job { directory: folder.path().into(), ..job };
        let path = folder.path().join("scheduler/shard.sbatch");
        assert_eq!(write_scripts(&here(job()), Scheduler::Slurm).expect("written"), Vec::<&str>::new());
        let other = here(Job { partition: Some("short".to_owned()), ..job() });
        assert_eq!(write_scripts(&other, Scheduler::Slurm).expect("written"), Vec::<&str>::new());
        let text = fs::read_to_string(&path).expect("there");
        assert!(text.contains("--partition=short"), "{text}");
        fs::write(&path, text.replace("--ntasks=1", "--ntasks=1 --exclusive")).expect("edited");
        assert_eq!(write_scripts(&here(job()), Scheduler::Slurm).expect("written"), ["shard.sbatch"]);
        assert!(fs::read_to_string(&path).expect("there").contains("--exclusive"));
    }

    #[test]
    fn a_program_that_does_not_answer_is_not_waited_for() {
        let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let error =
            asked(Scheduler::Slurm, &words(&["sleep", "60"]), Duration::from_millis(100)).expect_err("it sleeps");
        assert!(error.to_string().contains("no answer"), "{error}");
        let error =
            asked(Scheduler::Slurm, &words(&["sh", "-c", "echo why >&2; exit 3"]), ASKING).expect_err("it fails");
        assert!(error.to_string().contains("exit status: 3: why"), "{error}");
        assert_eq!(asked(Scheduler::Slurm, &words(&["echo", "12;here"]), ASKING).expect("it answers"), "12;here\n");
        let error = asked(Scheduler::Slurm, &words(&["/no/such/program"]), ASKING).expect_err("not there");
        assert!(matches!(error, SubmitError::Start { .. }), "{error}");
    }
}
