//! Submission of the shards of a study to a job scheduler: scripts that the user can read and edit, and the commands that submit them.
//!
//! ```text
//! Job --scripts--> text of the scripts: pure       (slurm, parallel; pbs, lsf, hyperqueue: templates)
//!     --commands--> submission commands: pure      hand_in runs them and stores the job ids
//! ```
//! A task only runs `bladeoff run --shard`, and the last task `bladeoff merge`. The chunks on disk determine what is done; the scheduler is
//! only queried for display.

mod hand_in;
mod parallel;
mod slurm;
mod templates;

pub use hand_in::{Handed, SubmitError, hand_in, scheduler_says, write_scripts};

use bladeoff_system::call::word;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

/// Program that runs the tasks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheduler {
    /// Job arrays of Slurm.
    Slurm,
    /// GNU parallel, over ssh where hosts are named.
    Parallel,
    /// Job arrays of PBS Pro and OpenPBS: a template.
    Pbs,
    /// Job arrays of LSF: a template.
    Lsf,
    /// Task arrays of HyperQueue: a template.
    HyperQueue,
}

impl Scheduler {
    /// All schedulers.
    pub const ALL: [Self; 5] = [Self::Slurm, Self::Parallel, Self::Pbs, Self::Lsf, Self::HyperQueue];

    /// Name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Slurm => "slurm",
            Self::Parallel => "parallel",
            Self::Pbs => "pbs",
            Self::Lsf => "lsf",
            Self::HyperQueue => "hyperqueue",
        }
    }

    /// Whether the tests run the scripts; the others are reviewed only, and submitted by the user.
    #[must_use]
    pub fn is_tested(self) -> bool {
        matches!(self, Self::Slurm | Self::Parallel)
    }
}

impl fmt::Display for Scheduler {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Scheduler {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|one| one.name() == text).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            let nearest = Self::ALL
                .map(Self::name)
                .into_iter()
                .max_by(|a, b| strsim::jaro_winkler(a, text).total_cmp(&strsim::jaro_winkler(b, text)));
            let nearest = nearest.filter(|name| strsim::jaro_winkler(name, text) > 0.7);
            let meant = nearest.map(|name| format!("; did you mean {name}?")).unwrap_or_default();
            format!("must be one of {names}{meant}")
        })
    }
}

/// Description of a submission. Paths are absolute, because tasks start in other directories.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// Name of the study.
    pub study: String,
    /// Path of this program.
    pub program: PathBuf,
    /// Path of the study file.
    pub file: PathBuf,
    /// Directory shared by the shards.
    pub directory: PathBuf,
    /// Number of shards.
    pub shards: u64,
    /// Shards with missing chunks.
    pub todo: Vec<u64>,
    /// Further options of each shard, quoted: `--scale 0.3`.
    pub more: String,
    /// Wall time of a task.
    pub time: Option<Duration>,
    /// Partition or queue.
    pub partition: Option<String>,
    /// Account to charge.
    pub account: Option<String>,
    /// Cores per task.
    pub cpus: Option<u64>,
    /// Hosts for GNU parallel.
    pub hosts: Vec<String>,
    /// Local directory on the node for the record of a shard.
    pub scratch: Option<PathBuf>,
}

/// A script of a submission.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Script {
    /// File name.
    pub name: &'static str,
    /// Content.
    pub text: String,
}

/// A submission command; `{0}` behind `afterany:` in a word is replaced by the id that the first command printed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Command(pub Vec<String>);

impl Command {
    fn of(words: &[&str]) -> Self {
        Self(words.iter().map(|word| (*word).to_owned()).collect())
    }

    /// The command as shell text, with `numbers` as the ids that earlier commands print, quoted by `quoted`.
    fn text(&self, numbers: &[String], quoted: impl Fn(&str) -> String) -> String {
        let one = |one: &String| if depends(one) { quoted(&filled(one, numbers)) } else { word(one) };
        self.0.iter().map(one).collect::<Vec<_>>().join(" ")
    }
}

/// Whether a word contains a job dependency.
fn depends(word: &str) -> bool {
    ["--dependency=afterany:", "depend=afterany:"].iter().any(|before| word.starts_with(before))
}

/// A word with the ids that earlier commands have printed.
fn filled(word: &str, numbers: &[String]) -> String {
    let all = numbers.iter().enumerate();
    all.fold(word.to_owned(), |word, (at, number)| word.replace(&format!("{{{at}}}"), number))
}

/// The commands as lines of a shell script.
#[must_use]
pub fn as_shell(commands: &[Command]) -> String {
    let numbers: Vec<String> = (0..commands.len()).map(|at| format!("$job{at}")).collect();
    let is_used = |at: usize| {
        let number = format!("{{{at}}}");
        commands.iter().flat_map(|command| &command.0).any(|word| depends(word) && word.contains(&number))
    };
    let line = |(at, command): (usize, &Command)| {
        let text = command.text(&numbers, |word| format!("\"{word}\""));
        if is_used(at) { format!("job{at}=$({text})\n") } else { format!("{text}\n") }
    };
    commands.iter().enumerate().map(line).collect()
}

impl Job {
    /// Scripts for a scheduler.
    #[must_use]
    pub fn scripts(&self, scheduler: Scheduler) -> Vec<Script> {
        match scheduler {
            Scheduler::Slurm => slurm::scripts(self),
            Scheduler::Parallel => parallel::scripts(self),
            Scheduler::Pbs => templates::pbs(self),
            Scheduler::Lsf => templates::lsf(self),
            Scheduler::HyperQueue => templates::hyperqueue(self),
        }
    }

    /// Submission commands for a scheduler.
    #[must_use]
    pub fn commands(&self, scheduler: Scheduler) -> Vec<Command> {
        match scheduler {
            Scheduler::Slurm => slurm::commands(self),
            Scheduler::Parallel => parallel::commands(self),
            Scheduler::Pbs => templates::pbs_commands(self),
            Scheduler::Lsf => templates::lsf_commands(self),
            Scheduler::HyperQueue => templates::hyperqueue_commands(self),
        }
    }

    fn folder(&self) -> PathBuf {
        self.directory.join(crate::run::shards::SCHEDULER)
    }

    /// Path of a script or log, quoted for a shell.
    fn path(&self, name: &str) -> String {
        word(self.folder().join(name)).to_string()
    }

    /// Path of a script or log, unquoted.
    fn plain(&self, name: &str) -> String {
        self.folder().join(name).to_string_lossy().into_owned()
    }

    /// `bladeoff run --shard`, with the shard number in a shell variable.
    fn shard(&self, number: &str) -> String {
        let scratch = self.scratch.as_ref().map(|path| format!(" --scratch {}", word(path))).unwrap_or_default();
        let wall = self.wall().map(|wall| format!(" --wall {}s", wall.as_secs())).unwrap_or_default();
        format!(
            "{} run {} --out {} --shard {number}/{}{}{scratch}{wall}",
            word(&self.program),
            word(&self.file),
            word(&self.directory),
            self.shards,
            self.more
        )
    }

    /// The command `bladeoff merge`.
    fn merge(&self) -> String {
        let trust = if self.more.contains("--trust-dir") { " --trust-dir" } else { "" };
        format!("{} merge {}{trust}", word(&self.program), word(&self.directory))
    }

    /// Wall time limit of a shard: the time of the task less a tenth (at least 15 s, at most 10 min), so that the shard has written its last
    /// results before the scheduler kills it.
    #[must_use]
    pub fn wall(&self) -> Option<Duration> {
        let time = self.time?;
        let before = (time / 10).clamp(Duration::from_secs(15), Duration::from_secs(600));
        Some(time.saturating_sub(before).max(Duration::from_secs(1)))
    }

    /// The shards with missing chunks as ranges: `0-3,7`.
    fn array(&self) -> String {
        let word =
            |(first, last): &(u64, u64)| if first == last { first.to_string() } else { format!("{first}-{last}") };
        self.ranges().iter().map(word).collect::<Vec<_>>().join(",")
    }

    fn ranges(&self) -> Vec<(u64, u64)> {
        let mut ranges: Vec<(u64, u64)> = Vec::new();
        for &shard in &self.todo {
            match ranges.last_mut() {
                Some((_, last)) if *last + 1 == shard => *last = shard,
                _ => ranges.push((shard, shard)),
            }
        }
        ranges
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn job() -> Job {
        Job {
            study: "night".to_owned(),
            program: "/opt/bladeoff/bin/bladeoff".into(),
            file: "/home/me/my studies/night.toml".into(),
            directory: "/scratch/me/night".into(),
            shards: 16,
            todo: vec![0, 1, 2, 3, 7, 9, 10],
            more: " --scale 0.3".to_owned(),
            time: Some(Duration::from_secs(8 * 3600)),
            partition: Some("long".to_owned()),
            account: Some("turbines".to_owned()),
            cpus: Some(64),
            hosts: vec!["blue".to_owned(), "red".to_owned()],
            scratch: None,
        }
    }

    /// Regenerate with `BLADEOFF_WRITE_DOCS=1 cargo test --release --workspace --lib scripts_are_those_that_were_reviewed`.
    #[test]
    fn scripts_are_those_that_were_reviewed() {
        for scheduler in Scheduler::ALL {
            let mut text = String::new();
            for script in job().scripts(scheduler) {
                text.push_str(&format!("==> {} <==\n{}\n", script.name, script.text));
            }
            text.push_str("==> handed in by <==\n");
            text.push_str(&as_shell(&job().commands(scheduler)));
            let golden = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
                .join(format!("../tests/golden/submit/{scheduler}.txt"));
            if std::env::var_os("BLADEOFF_WRITE_DOCS").is_some() {
                std::fs::create_dir_all(golden.parent().expect("a folder")).expect("made");
                std::fs::write(&golden, &text).expect("written");
            }
            let reviewed = std::fs::read_to_string(&golden).unwrap_or_default();
            assert!(text == reviewed, "{scheduler}: the scripts have changed; read them, then regenerate\n{text}");
        }
    }

    #[test]
    fn words_of_schedulers_are_read_and_near_ones_named() {
        for scheduler in Scheduler::ALL {
            assert_eq!(scheduler.name().parse(), Ok(scheduler));
        }
        let error = "slrum".parse::<Scheduler>().expect_err("none");
        assert!(error.contains("did you mean slurm?"), "{error}");
    }

    #[test]
    fn a_shard_ends_before_its_scheduler_ends_it() {
        let wall =
            |seconds: u64| Job { time: Some(Duration::from_secs(seconds)), ..job() }.wall().expect("a time").as_secs();
        assert_eq!([60, 600, 3600, 28_800, 10].map(wall), [45, 540, 3240, 28_200, 1]);
    }
}
